//! A gyro that says late what others say: stamped late, or behind a low pass.
//!
//! ```text
//! −2 ln L(ω_log(t + T); θ)    beside    −2 ln L(ω_log; θ, Ts)        T ω̇_log + ω_log = ω
//! ```
//!
//! The checks see a latency of about T in both. The baseline is fitted once in either way, to the same samples. A gyro that is
//! smoothed is left to the search, which names its time constant; one that is late is mended like any other fault of a log.

use super::log_faults::Fault;
use crate::effects::{Place, gyro_lag};
use crate::estimate::filter_error::{FilterErrorOptions, filter_error};
use crate::estimate::started;
use crate::model::Model;
use crate::run::{Role, Run};

/// Fall of −2 ln L below which the fits are not improved any more: little beside what tells them apart.
const ROUGH: f64 = 0.5;

/// Deviations beyond which innovations are held back: the same on both sides of a ratio of likelihoods.
const LIMIT: f64 = 5.0;

/// Whether the gyro is smoothed rather than late by what `fault` says.
pub(super) fn is_smoothed(model: &Model, runs: &[Run], fault: &Fault, fitting: &FilterErrorOptions) -> bool {
    let Some(latency) = fault.latency_of_gyro() else { return false };
    let options = FilterErrorOptions { tolerance: ROUGH, refine: false, limit: Some(LIMIT), ..fitting.clone() };
    // runs that take no part in the fit judge its names, and choose nothing
    let train: Vec<Run> = runs.iter().filter(|run| run.role == Role::Train).cloned().collect();
    let cost = |model: &Model, runs: &[Run]| {
        let fit = filter_error(&started(model, runs), runs, &options).ok()?;
        fit.converged.then_some(fit.cost)
    };
    let mut smoothed = model.clone();
    let Ok(term) = smoothed.add(gyro_lag(), Place::VEHICLE) else { return false };
    for k in smoothed.terms[term].parameters.clone() {
        smoothed.parameters[k].value = latency;
    }
    let mut mended = train.clone();
    fault.mend(&mut mended);
    match (cost(&smoothed, &train), cost(model, &mended)) {
        (Some(smoothed), Some(late)) => smoothed < late,
        (smoothed, _) => smoothed.is_some(),
    }
}
