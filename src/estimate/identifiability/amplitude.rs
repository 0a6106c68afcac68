//! Estimates of a parameter run by run, and whether they follow a number of each run, as virtual
//! mass may follow the Keulegan-Carpenter number.
//!
//! ```text
//! θ = [shared; m_1 … m_n]       one more fit, with a value of its own in each run
//! m_r = a + c KC_r              generalised least squares with the covariance of m
//! z = c/σ_c
//! ```
//!
//! Added mass of bluff bodies grows with the amplitude of the oscillation: C_m from 0.4 to 3.5 over
//! KC from 0.55 to 39.8 in Table 5 of Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013)
//! 81-94.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

use crate::estimate::output_error::{OutputErrorError, OutputErrorFit, OutputErrorOptions, output_error, value};
use crate::run::Run;

/// Estimates of one parameter from each run that shows it, all other parameters common.
#[derive(Debug, Clone, PartialEq)]
pub struct RunByRun {
    /// Indices of the runs in the fit.
    pub runs: Vec<usize>,
    /// Estimates, SI.
    pub values: Vec<f64>,
    /// Their covariance, row-major, SI.
    pub covariance: Vec<f64>,
    /// Root mean square of the residuals of each output in that fit, in units of its noise.
    pub left: Vec<f64>,
}

/// A straight line through estimates of runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trend {
    /// Value at 0, SI.
    pub intercept: f64,
    /// Slope c, SI per unit of the number.
    pub slope: f64,
    /// Standard deviation of the slope.
    pub std: f64,
    /// Probability of such a slope by chance, two-sided.
    pub p_value: f64,
}

/// Standard deviation, in units of the common value, of the prior that holds the values of runs
/// together: a run that does not show the parameter keeps the common value.
const HELD: f64 = 1.0;

/// Standard deviation of a run's estimate, as a share of the common value, below which the run
/// shows the parameter.
const SHOWN: f64 = 0.5;

/// Fits the common unknowns `parameters` (indices in the model) run by run, all others common: one
/// more fit, started from `fit`. An entry is `None` if the parameter was not fitted or fewer than
/// two runs show it.
///
/// # Errors
/// [`OutputErrorError`] if that fit cannot be done.
pub fn run_by_run(
    fit: &OutputErrorFit,
    runs: &[Run],
    options: &OutputErrorOptions,
    parameters: &[usize],
) -> Result<Vec<Option<RunByRun>>, OutputErrorError> {
    let mut model = fit.model.clone();
    for index in parameters.iter().filter(|p| !fit.model.parameters[**p].fixed) {
        let parameter = &mut model.parameters[*index];
        parameter.spec.per_run = true;
        parameter.per_run = vec![parameter.value; runs.len()];
        parameter.prior = parameter.prior.or(Some((parameter.value, HELD * parameter.value.abs().max(1e-12))));
    }
    let apart = output_error(&model, runs, options)?;
    Ok(parameters.iter().map(|p| of_runs(&apart, *p, fit.model.parameters[*p].value)).collect())
}

/// The estimates of one parameter from a fit with a value in each run.
fn of_runs(fit: &OutputErrorFit, parameter: usize, common: f64) -> Option<RunByRun> {
    let unknowns = &fit.problem.unknowns;
    let p = unknowns.len();
    let kept: Vec<(usize, usize)> = unknowns
        .iter()
        .enumerate()
        .filter(|(k, u)| u.parameter == parameter && fit.covariance[k * p + k].sqrt() < SHOWN * common.abs())
        .filter_map(|(k, u)| Some((k, u.run?)))
        .collect();
    (kept.len() > 1).then(|| RunByRun {
        runs: kept.iter().map(|(_, run)| *run).collect(),
        values: kept.iter().map(|(k, _)| value(&fit.model, unknowns[*k])).collect(),
        covariance: kept
            .iter()
            .flat_map(|(a, _)| kept.iter().map(|(b, _)| fit.covariance[a * p + b]).collect::<Vec<_>>())
            .collect(),
        left: fit.times_noise(),
    })
}

/// The line through estimates against `numbers`, one number for each run of `estimates`; `None` if
/// the numbers do not differ or the covariance is not positive definite.
pub fn trend(estimates: &RunByRun, numbers: &[f64]) -> Option<Trend> {
    let n = numbers.len();
    let covariance = DMatrix::from_row_slice(n, n, &estimates.covariance);
    let half = covariance.cholesky()?.l();
    let design = DMatrix::from_fn(n, 2, |r, c| if c == 0 { 1.0 } else { numbers[r] });
    let (x, y) = (half.solve_lower_triangular(&design)?, DVector::from_column_slice(&estimates.values));
    let y = half.solve_lower_triangular(&y)?;
    let inverse = (x.transpose() * &x).try_inverse()?;
    let solution = &inverse * (x.transpose() * y);
    let std = inverse[(1, 1)].sqrt();
    let (intercept, slope) = (solution[0], solution[1]);
    if !(std.is_finite() && slope.is_finite() && std > 0.0) {
        return None;
    }
    let p_value = 2.0 * Normal::standard().cdf(-(slope / std).abs());
    Some(Trend { intercept, slope, std, p_value })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y = 3 + 2x with independent standard deviations of 1: the slope's variance is 1/Σ(x − x̄)².
    #[test]
    fn exact_line_and_its_deviation() {
        let numbers = [1.0, 2.0, 6.0];
        let covariance = (0..9).map(|k| if k / 3 == k % 3 { 1.0 } else { 0.0 }).collect();
        let estimates = RunByRun {
            runs: vec![0, 1, 2],
            values: numbers.iter().map(|x| 3.0 + 2.0 * x).collect(),
            covariance,
            left: vec![],
        };
        let found = trend(&estimates, &numbers).unwrap();
        assert!((found.slope - 2.0).abs() < 1e-12 && (found.intercept - 3.0).abs() < 1e-12);
        assert!((found.std - 1.0 / 14f64.sqrt()).abs() < 1e-12);
        assert!(found.p_value < 1e-10);
        assert_eq!(trend(&estimates, &[2.0, 2.0, 2.0]), None);
    }
}
