//! Whether a fit lacks an effect of the catalogue at all, without its name.
//!
//! ```text
//! p = level · exp(ln p − ln p_threshold)        of the first of the best few scores, step 2 of the search, that a refit bears out
//! ```
//!
//! Predictions seconds ahead are a coarse test: a gyro that is 50 ms late passes it, and moves the yaw inertia by five of its
//! deviations. The scores see it. They also see what the unknown beginnings of the runs make of a friction near rest, and the
//! refit does not ([`super::refit::merit`]). Which effect it is they do not say: a name has to pass the rest of the search.

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

/// Candidates that are refitted before a fit is said to lack none.
const REFITS: usize = 3;

/// An effect that a fit lacks.
#[derive(Debug, Clone, PartialEq)]
pub struct Lacking {
    /// Probability of such a gain by chance, of all candidates.
    pub p_value: f64,
    /// How many candidates were asked.
    pub candidates: usize,
    /// What kind of effect the refit bears out.
    pub family: Family,
    /// By how much each parameter of the model moves where the effect that the refit bears out is in it: what the parameters are
    /// off by as long as it is not.
    pub moves: Vec<f64>,
}

impl Lacking {
    /// δδᵀ, δ: [`Lacking::moves`]: what it adds to the covariance of the parameters.
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
    // what has a value of its own in every run follows anything that comes and goes
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

/// How far a parameter is from here to where another model has it: of one with a value in every run the farthest.
fn moved(p: &Parameter, other: &Model) -> f64 {
    let there = other.parameters.iter().find(|o| o.term == p.term && o.spec.name == p.spec.name);
    there.map_or(0.0, |there| {
        let of_runs = there.per_run.iter().zip(&p.per_run).map(|(there, here)| there - here);
        of_runs.fold(there.value - p.value, |most, by| if by.abs() > most.abs() { by } else { most })
    })
}
