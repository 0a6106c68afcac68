//! The verb `discover`: what the campaign's baseline lacks, if anything.

use super::codes;
use super::error::Error;
use super::file::DiscoverTable;
use super::load::Campaign;
use super::log_faults::{Fault, faults};

use crate::discover::{self, Discovery, SearchOptions};
use crate::finding::Finding;
use crate::model::{Model, Parameter};

/// Looks for what the baseline of a campaign lacks on its runs of free motion.
///
/// # Errors
/// [`Error`] when the baseline cannot be fitted or a run lacks what it reads.
pub fn discover(campaign: &Campaign) -> Result<Discovery, Error> {
    let table = &campaign.file.discover;
    let usual = DiscoverTable::default();
    let (level, most, families) = (table.level, table.max_effects, table.families.clone());
    let options = SearchOptions { level, most, families, ..SearchOptions::default() };
    let mut runs = campaign.motion(None);
    let faults = faults(&runs, &campaign.model.dofs);
    for fault in &faults {
        fault.mend(&mut runs);
    }
    let fitting = &campaign.options.output_error;
    let search = |model: &Model| discover::discover(model, &runs, &campaign.candidates, fitting, &options);
    let mut found = search(&campaign.model)?;
    let (held, said) = undetermined(&campaign.model, &found);
    if let Some(held) = held {
        found = search(&held)?;
    }
    found.warnings.extend(said);
    found.seed = table.seed.unwrap_or(campaign.options.seed);
    if table.families != usual.families {
        let names: Vec<&str> = table.families.iter().map(|family| family.name()).collect();
        let text = format!("only effects of the family {} were tried, and the campaign's own", names.join(", "));
        found.warnings.push(Finding::new(&codes::FAMILIES, text));
    }
    let told = campaign.findings.iter().filter(|f| f.code != codes::NO_VALIDATION.code).cloned();
    let told: Vec<Finding> = told.chain(campaign.brought.iter().cloned()).collect();
    found.warnings.splice(0..0, told);
    let mended = |fault: &Fault| {
        let text = format!("{fault}; the search worked on the mended channel, the files are as they were");
        Finding::new(&codes::CORRECTED, text)
    };
    found.warnings.extend(faults.iter().map(mended));
    found.log_findings = faults.iter().flat_map(Fault::findings).collect();
    Ok(found)
}

/// An inertia whose standard deviation is above this part of it is not known: in quasi-steady motion the force and the
/// drag balance each other, whatever the mass.
const UNKNOWN: f64 = 0.3;

/// What to say of inertias that the runs do not determine, and the model in which they are held where a value is known
/// beforehand: left free they would take up what is missing.
fn undetermined(model: &Model, found: &Discovery) -> (Option<Model>, Vec<Finding>) {
    let Some(baseline) = found.steps.first().map(|step| &step.fit.model) else { return (None, Vec::new()) };
    let loose = |p: &&Parameter| {
        p.effect == "inertia" && !p.fixed && p.prior.is_none() && p.std.is_some_and(|std| std > UNKNOWN * p.value.abs())
    };
    let mut held = model.clone();
    let (mut any, mut said) = (false, Vec::new());
    for p in baseline.parameters.iter().filter(loose) {
        let known = held.parameters.iter_mut().find(|k| k.term == p.term && k.spec.name == p.spec.name);
        let std = p.std.unwrap_or(f64::NAN);
        let unit = p.spec.dimension;
        let mut text = format!(
            "{} of `{}` cannot be known from these runs: {:.4} ± {:.2} {unit}; it needs motion that accelerates under a known force",
            p.spec.name, p.term, p.value, std
        );
        if let Some(known) = known.filter(|k| k.value > 0.0) {
            known.fixed = true;
            any = true;
            text += &format!("; it was held at {:.4} {unit}", known.value);
        }
        said.push(Finding::new(&codes::NO_INERTIA, text));
    }
    (any.then_some(held), said)
}
