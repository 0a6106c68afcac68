//! The verb `discover`: what the campaign's baseline lacks, if anything.

use super::codes;
use super::error::Error;
use super::file::DiscoverTable;
use super::load::Campaign;
use std::collections::BTreeMap;

use crate::check::{self, CheckOptions, FaultKind};
use crate::discover::{self, Discovery, LogFinding, SearchOptions};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::run::{Run, Signal};

/// Looks for what the baseline of a campaign lacks on its runs of free motion.
///
/// # Errors
/// [`Error`] when the baseline cannot be fitted or a run lacks what it reads.
pub fn discover(campaign: &Campaign) -> Result<Discovery, Error> {
    let table = &campaign.file.discover;
    let usual = DiscoverTable::default();
    let mut options = SearchOptions { families: table.families.clone(), ..SearchOptions::default() };
    // what the file does not ask for is left as the search was calibrated
    if table.level.to_bits() != usual.level.to_bits() {
        options.level = table.level;
    }
    if table.max_effects != usual.max_effects {
        options.most = table.max_effects;
    }
    let mut runs = campaign.motion(None);
    let faults = faults(&runs, &campaign.model.dofs);
    for fault in &faults {
        correct(&mut runs, fault);
    }
    let fitting = &campaign.options.output_error;
    let mut found = discover::discover(&campaign.model, &runs, &campaign.candidates, fitting, &options)?;
    found.seed = table.seed.unwrap_or(campaign.options.seed);
    let told: Vec<_> = campaign.findings.iter().filter(|f| f.code != codes::NO_VALIDATION.code).cloned().collect();
    if table.families != usual.families {
        let names: Vec<&str> = table.families.iter().map(|family| family.name()).collect();
        let text = format!("only effects of the family {} were tried, and the campaign's own", names.join(", "));
        found.warnings.push(Finding::new(&codes::FAMILIES, text));
    }
    found.warnings.splice(0..0, told);
    let corrected = faults.iter().map(|fault| {
        let text = format!(
            "{}: the log is off by a factor of {:.4} ({}); the search worked on the corrected channel, the files are as they were",
            fault.channel, fault.factor, fault.kind
        );
        Finding::new(&codes::CORRECTED, text)
    });
    found.warnings.extend(corrected);
    found.log_findings = faults;
    Ok(found)
}

/// A factor counts as a wrong unit from this ratio on: what is nearer to 1 may be an effect and is left to the search.
const WRONG_UNIT: f64 = 5.0;

/// Wrong units and signs on which more than half of the runs agree that say anything of the channel.
fn faults(runs: &[Run], dofs: &[Dof]) -> Vec<LogFinding> {
    let options = CheckOptions { dofs: dofs.to_vec(), ..CheckOptions::default() };
    let mut seen: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for run in runs {
        for fault in check::run(run, &options).log_findings {
            let unit = fault.kind == FaultKind::Unit && !(1.0 / WRONG_UNIT..=WRONG_UNIT).contains(&fault.factor.abs());
            if unit || fault.kind == FaultKind::Sign {
                seen.entry(fault.channel).or_default().push(fault.factor);
            }
        }
    }
    let agreed = |(channel, mut factors): (String, Vec<f64>)| {
        factors.sort_by(f64::total_cmp);
        let factor = factors[factors.len() / 2];
        let alike = factors.iter().filter(|f| (*f / factor - 1.0).abs() < 0.1).count();
        // one run may deceive; commands and velocities in a straight line say nothing of yaw
        (alike >= 2 && 2 * alike > factors.len()).then(|| LogFinding {
            kind: if factor < 0.0 && factor > -1.5 { "sign" } else { "unit" }.to_string(),
            channel,
            factor,
        })
    };
    seen.into_iter().filter_map(agreed).collect()
}

/// Divides a channel by the factor by which it is off.
fn correct(runs: &mut [Run], fault: &LogFinding) {
    for run in runs {
        if let Some(signal) = run.signals.get_mut(&fault.channel) {
            let values: Vec<f64> = signal.values().iter().map(|x| x / fault.factor).collect();
            *signal = Signal::new(signal.shared_time().clone(), values);
        }
    }
}
