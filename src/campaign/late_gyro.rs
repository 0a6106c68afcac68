//! A gyro that comes later than the other sensors: its stamps are late, or it is low-pass filtered.
//!
//! ```text
//! −2 ln L(ω_log(t + T); θ)    beside    −2 ln L(ω_log; θ, Ts)        T ω̇_log + ω_log = ω
//! ```
//!
//! The checks see a latency of about T in both cases. The baseline is fitted once for each, to the
//! same samples. A gyro that is filtered is left to the search, which names its time constant; one
//! that is late is mended like any other fault of a log.

use super::log_faults::Fault;
use crate::effects::{Place, gyro_lag};
use crate::estimate::filter_error::{FilterErrorOptions, filter_error};
use crate::estimate::started;
use crate::model::Model;
use crate::run::{Role, Run};

/// Decrease of −2 ln L below which a fit is not improved further: small against the difference that
/// decides.
const ROUGH: f64 = 0.5;

/// Limit in standard deviations beyond which innovations are down-weighted, the same on both sides
/// of the likelihood ratio.
const LIMIT: f64 = 5.0;

/// Whether the gyro is low-pass filtered rather than late, as `fault` has it.
pub(super) fn is_smoothed(model: &Model, runs: &[Run], fault: &Fault, fitting: &FilterErrorOptions) -> bool {
    let Some(latency) = fault.latency_of_gyro() else { return false };
    let options = FilterErrorOptions { tolerance: ROUGH, refine: false, limit: Some(LIMIT), ..fitting.clone() };
    // held-out runs judge what the fit finds and have no part in the choice
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
