//! The Cramér-Rao bound: what no unbiased estimator can beat on these runs.
//!
//! ```text
//! Σ ≥ (JᵀJ)⁻¹      J = ∂y/∂θ / σ at the true parameters, one free initial state a run projected out
//! ```
//!
//! For white Gaussian noise of known deviation σ. Segments of a fit have more free initial states than that, and lose
//! what those take up. Maine and Iliff, *NASA Reference Publication* 1077 (1981), ch. 4.

use super::{OutputErrorError, OutputErrorOptions, Problem, covariance, normal_factor};
use crate::model::Model;
use crate::run::Run;

/// Covariance bound of the free parameters of `truth`, row-major in the order of [`Problem::unknowns`], for sensors that
/// log where and when `runs` do with the noise `options.sigma`; the values of `runs`, free of noise, give the initial
/// states.
///
/// # Errors
/// [`OutputErrorError`] where a run lacks what the model reads or does not determine a parameter.
pub fn cramer_rao(truth: &Model, runs: &[Run], options: &OutputErrorOptions) -> Result<Vec<f64>, OutputErrorError> {
    let whole = OutputErrorOptions { segment: f64::INFINITY, ..options.clone() };
    let problem = Problem::new(truth, runs, &whole)?;
    let segments = problem.linearise(truth, &problem.initial_states(truth));
    let factor = normal_factor(&problem, truth, &segments);
    covariance::bread(&problem, truth, &factor)
}
