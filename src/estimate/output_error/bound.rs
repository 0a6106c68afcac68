//! The Cramér-Rao bound: the covariance that no unbiased estimator can beat on these runs.
//!
//! ```text
//! Σ ≥ (JᵀJ)⁻¹      J = ∂y/∂θ / σ at the true parameters, one free initial state per run projected out
//! ```
//!
//! For white Gaussian noise of known standard deviation σ. The segments of a fit have more free
//! initial states, which take up information. Maine and Iliff, *NASA Reference Publication* 1077
//! (1981), ch. 4.

use super::{OutputErrorError, OutputErrorOptions, Problem, covariance, normal_factor};
use crate::model::Model;
use crate::run::Run;

/// Covariance bound of the free parameters of `truth`, row-major in the order of
/// [`Problem::unknowns`], for sensors that log the channels of `runs` at the same instants with the
/// noise `options.sigma`. The values of `runs`, free of noise, give the initial states.
///
/// # Errors
/// [`OutputErrorError`] if a run lacks what the model reads, or the runs do not determine a
/// parameter.
pub fn cramer_rao(truth: &Model, runs: &[Run], options: &OutputErrorOptions) -> Result<Vec<f64>, OutputErrorError> {
    let whole = OutputErrorOptions { segment: f64::INFINITY, ..options.clone() };
    let problem = Problem::new(truth, runs, &whole)?;
    let segments = problem.linearise(truth, &problem.initial_states(truth));
    let factor = normal_factor(&problem, truth, &segments);
    covariance::bread(&problem, truth, &factor)
}
