//! Step 7: how the fits of the search predict the held-out runs, and where the last one fails.
//!
//! ```text
//! E(2 s), E(8 s)  against what the filter, and draws of all that is open, expect;      innovations white
//! σ_F ≤ 10 rms τ,  and σ_F ≤ 0.2 rms τ where T > 10 s                                   σ_F, T: random force, τ: commands
//! ```
//!
//! A held-out run may leave the range of the runs of the fit: astern, or faster. If the model fails on such runs alone,
//! something is still missing, but the runs of the fit do not show what it is.

use super::gap::{GapStep, gap_step, noise_floor, predictions};
use super::pushed::{lasting, overwhelmed, pushed_hard};
use super::searched::Search;
use super::task::Task;
use super::verdict::failing;
use crate::envelope;
use crate::estimate::filter_error::{FilterErrorFit, Forecast, with_all_open};
use crate::estimate::output_error::OutputErrorError;
use crate::finding::Finding;
use crate::progress;
use crate::run::Run;

/// Quality of the predictions of a search's fits.
pub(super) struct Judged {
    /// The gap before and after each step.
    pub gap: Vec<GapStep>,
    /// Predictions of the runs of the fit by the last fit.
    pub training: Vec<Forecast>,
    /// Channels in which the last fit fails, with the ratio of actual to expected error.
    pub failing: Vec<(String, f64)>,
    /// Where held-out runs go beyond those of the fit, if the last fit fails on such runs alone.
    pub beyond: Vec<Finding>,
    /// Held-out runs on which the last fit fails, the worst first.
    pub erring: Vec<String>,
    /// Whether the fit predicts its own runs well but fails on others: its runs then do not show what is missing.
    pub follows_training: bool,
}

/// Whether the runs of the fit show that something is missing: innovations correlate with a candidate, or a random
/// force is too large for turbulence.
fn is_shown(found: &Search, task: &Task<'_>) -> bool {
    found.screen.asks() || !pushed_hard(&found.last_fit().noise.forces, task.train).is_empty()
}

impl Judged {
    /// Judges every step of `found`.
    ///
    /// # Errors
    /// [`OutputErrorError`] when a held-out run lacks what the model reads.
    pub fn new(found: &Search, task: &Task<'_>) -> Result<Judged, OutputErrorError> {
        let Task { held, fitting, .. } = *task;
        let mut predicted = Vec::new();
        for (k, step) in found.steps.iter().enumerate() {
            progress::tell("the gap on held-out runs", k, found.steps.len());
            predicted.push(predictions(&step.fit, held, fitting)?);
        }
        let fit = found.last_fit();
        let floor = noise_floor(fit);
        let steps = found.steps.iter().zip(&predicted).enumerate();
        let gap = steps.map(|(k, (step, (outputs, made)))| gap_step(found, k, step, outputs, made, &floor)).collect();
        let (outputs, last) = &predicted[predicted.len() - 1];
        let training = fit.forecast();
        let mut failing_in = failing(outputs, last, &training);
        let (mut beyond, mut erring, mut follows_training) = (Vec::new(), Vec::new(), false);
        if !failing_in.is_empty() && !held.is_empty() {
            let estimated = fit.on_others(held, fitting)?;
            let allowed = with_all_open(fit, &estimated, last, (held, &fitting.base), task.options.seed)?;
            failing_in = failing(outputs, &allowed, &training);
            if !failing_in.is_empty() {
                erring = erring_most(outputs, &allowed, held);
                follows_training = predicts_training(outputs, fit, &training, task)?;
            }
            let range = envelope::of(task.train);
            let strange: Vec<Vec<Finding>> = held.iter().map(|run| envelope::beyond(run, &range)).collect();
            let within = allowed.into_iter().zip(&strange).filter(|(_, found)| found.is_empty());
            let within: Vec<Forecast> = within.map(|(forecast, _)| forecast).collect();
            if !failing_in.is_empty() && !is_shown(found, task) && failing(outputs, &within, &training).is_empty() {
                beyond = strange.concat();
            }
        }
        let forces = &fit.noise.forces;
        for (dof, times) in overwhelmed(forces, task.train).into_iter().chain(lasting(forces, task.train)) {
            if failing_in.iter().all(|(known, _)| known != dof.velocity()) {
                failing_in.push((dof.velocity().to_string(), times));
                beyond.clear();
                erring.clear();
            }
        }
        Ok(Judged { gap, training, failing: failing_in, beyond, erring, follows_training })
    }
}

/// Whether a fit predicts its own runs as expected, including the parameters' uncertainty where motions are unstable.
fn predicts_training(
    outputs: &[String],
    fit: &FilterErrorFit,
    training: &[Forecast],
    task: &Task<'_>,
) -> Result<bool, OutputErrorError> {
    if failing(outputs, training, training).is_empty() {
        return Ok(true);
    }
    let mut held = fit.model.clone();
    held.parameters.iter_mut().for_each(|p| p.fixed = true);
    let allowed = with_all_open(fit, &held, training, (task.train, &task.fitting.base), task.options.seed)?;
    Ok(failing(outputs, &allowed, training).is_empty())
}

/// Names of the runs on which predictions fail, in descending order of the ratio of actual to expected error.
fn erring_most(outputs: &[String], forecasts: &[Forecast], held: &[Run]) -> Vec<String> {
    let times = |forecast: &Forecast| {
        let failing = failing(outputs, std::slice::from_ref(forecast), &[]);
        failing.into_iter().map(|(_, times)| times).reduce(f64::max)
    };
    let mut erring: Vec<(&Run, f64)> =
        held.iter().zip(forecasts).filter_map(|(run, f)| Some((run, times(f)?))).collect();
    erring.sort_by(|a, b| b.1.total_cmp(&a.1));
    erring.into_iter().map(|(run, _)| run.name.clone()).collect()
}
