//! Test whether a fit lacks any effect of the catalogue, without naming it.
//!
//! ```text
//! p = level · exp(ln p − ln p_threshold)        of the first of the best few scores, step 2 of the search, that a refit bears out
//! ```
//!
//! Predictions seconds ahead are a coarse test: a gyro that is 50 ms late passes it, and shifts the yaw inertia by
//! five of its standard deviations. The scores detect it. They also respond to the unknown initial states of the
//! runs, which look like friction near rest, but the refit does not ([`super::refit::merit`]). They do not tell which
//! effect it is: a name must pass the rest of the search.

use std::sync::Arc;

use super::candidate::Candidate;
use super::naming::p_of_all;
use super::refit::{beside, merit};
use super::screen::{Score, log_survival};
use super::task::{ROUGH, SearchOptions, Task, asked, screened};
use crate::effects::{Effect, Family, Place};
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions, filter_error_from};
use crate::estimate::output_error::OutputErrorError;
use crate::model::{Model, Parameter};
use crate::run::Run;

/// Number of candidates that are refitted before a fit counts as complete.
const REFITS: usize = 3;

/// An effect that a fit lacks.
#[derive(Debug, Clone, PartialEq)]
pub struct Lacking {
    /// Probability of such a gain by chance, over all candidates.
    pub p_value: f64,
    /// Number of candidates that were tested.
    pub candidates: usize,
    /// Family of the effect that the refit confirms.
    pub family: Family,
    /// Change of each parameter of the model when the confirmed effect is added: the bias of the parameters as long
    /// as it is missing.
    pub moves: Vec<f64>,
}

impl Lacking {
    /// δδᵀ, δ: [`Lacking::moves`]: its contribution to the covariance of the parameters.
    pub fn covariance(&self) -> Vec<Vec<f64>> {
        self.moves.iter().map(|a| self.moves.iter().map(|b| a * b).collect()).collect()
    }
}

/// Whether `fit` to `runs` lacks an effect of the catalogue, or one of `own`, beyond chance.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub fn lacking(
    fit: &FilterErrorFit,
    runs: &[Run],
    own: &[(Arc<dyn Effect>, Place)],
    fitting: &FilterErrorOptions,
    options: &SearchOptions,
) -> Result<Option<Lacking>, OutputErrorError> {
    let task = Task { train: runs, held: &[], own, fitting, options };
    // a value of its own in every run follows anything that comes and goes
    let list: Vec<Candidate> = asked(&fit.model, &task).into_iter().filter(|c| !c.has_own_values()).collect();
    let screen = screened(fit, &list, &task)?;
    let mut best: Vec<&Score> = Vec::new();
    for score in screen.scores.iter().take_while(|score| score.log_p < screen.threshold) {
        if list[score.candidate].is_possible(score) && best.iter().all(|known| known.candidate != score.candidate) {
            best.push(score);
        }
    }
    let refitting = FilterErrorOptions { tolerance: ROUGH, told: false, ..beside(fit, &task) };
    let borne_out = |score: &&Score| {
        let model = list[score.candidate].started(&fit.model, score)?;
        let with = filter_error_from(&model, runs, fit.noise.clone(), &refitting).ok()?;
        let log_p = log_survival(merit(fit, &with, fit.cost - with.cost), score.parameters);
        (log_p < screen.threshold).then(|| Lacking {
            p_value: p_of_all(log_p, screen.threshold, options.level),
            candidates: list.len(),
            family: list[score.candidate].family(),
            moves: fit.model.parameters.iter().map(|p| moved(p, &with.model)).collect(),
        })
    };
    Ok(best.iter().take(REFITS).find_map(borne_out))
}

/// Change of a parameter from this model to another; for per-run values the greatest one.
fn moved(p: &Parameter, other: &Model) -> f64 {
    let there = other.parameters.iter().find(|o| o.term == p.term && o.spec.name == p.spec.name);
    there.map_or(0.0, |there| {
        let of_runs = there.per_run.iter().zip(&p.per_run).map(|(there, here)| there - here);
        of_runs.fold(there.value - p.value, |most, by| if by.abs() > most.abs() { by } else { most })
    })
}
