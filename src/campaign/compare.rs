//! The verb `compare`: the model against every run, those of the fit and those that took no part.

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

/// A model held against runs. Serialises as `hydrosysid compare --json`.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// Format of the result: 1.
    pub format: u32,
    /// One entry a run and degree of freedom.
    pub runs: Vec<Disagreement>,
    /// Noise, and how the model predicts; absent where it is so wrong that no filter can follow the runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
    /// What there is to say.
    pub warnings: Vec<Finding>,
}

/// How the runs of a campaign are compared.
pub(super) fn options(campaign: &Campaign) -> CompareOptions {
    let fitting = &campaign.options.output_error;
    CompareOptions {
        longest_step: fitting.longest_step,
        position: fitting.position,
        noise: campaign.file.noise.sensors.clone(),
        ..CompareOptions::default()
    }
}

/// The runs of free motion, and the model with its values in those.
fn of_motion(campaign: &Campaign, model: &Model) -> (Model, Vec<Run>) {
    let kept = campaign.motion_numbers(None);
    let runs = campaign.motion(None);
    let mut model = model.clone();
    for p in model.parameters.iter_mut().filter(|p| p.per_run.len() == campaign.runs.len()) {
        p.per_run = kept.iter().map(|k| p.per_run[*k]).collect();
    }
    (model, runs)
}

/// How far `model` is off on each run of free motion: the part of [`compare()`] that is quick, without the noise.
///
/// # Errors
/// As [`compare()`].
pub fn disagreements(campaign: &Campaign, model: &Model) -> Result<Vec<Disagreement>, Error> {
    let (model, runs) = of_motion(campaign, model);
    Ok(compare::compare(&model, &runs, &options(campaign))?.runs)
}

/// Compares `model` with the runs of free motion of a campaign; `envelope` is that in which it was
/// fitted.
///
/// # Errors
/// [`Error`] when a run lacks what the model reads.
pub fn compare(campaign: &Campaign, model: &Model, envelope: &Envelope) -> Result<Comparison, Error> {
    let (model, runs) = of_motion(campaign, model);
    let result = compare::compare(&model, &runs, &options(campaign))?;
    let mut warnings = campaign.findings.clone();
    warnings.extend(result.warnings);
    warnings.extend(runs.iter().flat_map(|run| envelope::beyond(run, envelope)));
    let noise = foretold(campaign, &model, &runs)?.map(|f| f.found);
    Ok(Comparison { format: 1, runs: result.runs, noise, warnings })
}
