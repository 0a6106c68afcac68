//! The verb `compare`: the model against every run, those of the fit and those that took no part.

use std::collections::BTreeMap;

use serde::Serialize;

use super::codes;
use super::error::Error;
use super::load::{Campaign, moves};
use crate::compare::{self, CompareOptions, Disagreement};
use crate::finding::Finding;
use crate::model::Model;
use crate::run::Run;

/// A model held against runs. Serialises as `hydrosysid compare --json`.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// Format of the result: 1.
    pub format: u32,
    /// One entry a run and degree of freedom.
    pub runs: Vec<Disagreement>,
    /// What there is to say.
    pub warnings: Vec<Finding>,
}

/// Compares `model` with the runs of free motion of a campaign; `envelope` holds the velocities between which it was
/// fitted.
///
/// # Errors
/// [`Error`] when a run lacks what the model reads.
pub fn compare(campaign: &Campaign, model: &Model, envelope: &BTreeMap<String, [f64; 2]>) -> Result<Comparison, Error> {
    let fitting = &campaign.options.output_error;
    let options = CompareOptions {
        longest_step: fitting.longest_step,
        position: fitting.position,
        noise: campaign.file.noise.clone(),
        ..CompareOptions::default()
    };
    let kept: Vec<usize> = (0..campaign.runs.len()).filter(|k| moves(campaign.runs[*k].kind)).collect();
    let runs: Vec<Run> = kept.iter().map(|k| campaign.runs[*k].clone()).collect();
    let mut model = model.clone();
    for p in model.parameters.iter_mut().filter(|p| p.per_run.len() == campaign.runs.len()) {
        p.per_run = kept.iter().map(|k| p.per_run[*k]).collect();
    }
    let result = compare::compare(&model, &runs, &options)?;
    let mut warnings = campaign.findings.clone();
    warnings.extend(result.warnings);
    warnings.extend(runs.iter().flat_map(|run| beyond(run, envelope)));
    Ok(Comparison { format: 1, runs: result.runs, warnings })
}

/// Share by which a run may leave the envelope before it is said: a tenth of its width.
const MARGIN: f64 = 0.1;

/// Says where a run goes beyond the velocities of the fit.
fn beyond(run: &Run, envelope: &BTreeMap<String, [f64; 2]>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (channel, [low, high]) in envelope {
        let margin = MARGIN * (high - low);
        let values = run.signal(channel).map_or(&[][..], |s| s.values());
        let out = values.iter().filter(|x| **x < low - margin || **x > high + margin).count();
        if out * 100 > values.len() {
            let text = format!(
                "run `{}`: {channel} goes beyond the {low:.3} to {high:.3} of the fit in {:.0} % of its samples: the model extrapolates there",
                run.name,
                100.0 * out as f64 / values.len() as f64
            );
            findings.push(Finding::new(&codes::OUT_OF_ENVELOPE, text).of_run(&run.name));
        }
    }
    findings
}
