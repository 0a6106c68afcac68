//! The verb `compare`: comparison of the model with every run, those of the fit and held-out ones.

use serde::Serialize;

use super::error::Error;
use super::load::Campaign;
use super::noise::Noise;
use super::prediction::foretold;
use crate::compare::{self, CompareOptions, Disagreement};
use crate::envelope::{self, Envelope};
use crate::finding::Finding;
use crate::model::Model;
use crate::run::Run;

/// Comparison of a model with runs. Serialises as `hydrosysid compare --json`.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// Format of the result: 1.
    pub format: u32,
    /// One entry per run and degree of freedom.
    pub runs: Vec<Disagreement>,
    /// Noise, and accuracy of the predictions; absent if the model is so wrong that no filter can
    /// follow the runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
}

/// Returns the options of a comparison with the runs of a campaign.
pub(super) fn options(campaign: &Campaign) -> CompareOptions {
    let fitting = &campaign.options.output_error;
    CompareOptions {
        longest_step: fitting.longest_step,
        position: fitting.position,
        noise: campaign.file.noise.sensors.clone(),
        ..CompareOptions::default()
    }
}

/// Returns the runs of free motion, and the model with its values for those runs.
fn of_motion(campaign: &Campaign, model: &Model) -> (Model, Vec<Run>) {
    let kept = campaign.motion_numbers(None);
    let runs = campaign.motion(None);
    let mut model = model.clone();
    for p in model.parameters.iter_mut().filter(|p| p.per_run.len() == campaign.runs.len()) {
        p.per_run = kept.iter().map(|k| p.per_run[*k]).collect();
    }
    (model, runs)
}

/// Returns how far `model` is off on each run of free motion: the quick part of [`compare()`],
/// without the noise.
///
/// # Errors
/// As [`compare()`].
pub fn disagreements(campaign: &Campaign, model: &Model) -> Result<Vec<Disagreement>, Error> {
    let (model, runs) = of_motion(campaign, model);
    Ok(compare::compare(&model, &runs, &options(campaign))?.runs)
}

/// Compares `model` with the runs of free motion of a campaign; `envelope` is that of its fit.
///
/// # Errors
/// [`Error`] if a run lacks what the model reads.
pub fn compare(campaign: &Campaign, model: &Model, envelope: &Envelope) -> Result<Comparison, Error> {
    let (model, runs) = of_motion(campaign, model);
    let result = compare::compare(&model, &runs, &options(campaign))?;
    let mut warnings = campaign.findings.clone();
    warnings.extend(result.warnings);
    warnings.extend(runs.iter().flat_map(|run| envelope::beyond(run, envelope)));
    let noise = foretold(campaign, &model, &runs)?.map(|f| f.found);
    Ok(Comparison { format: 1, runs: result.runs, noise, warnings })
}
