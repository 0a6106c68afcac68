//! Predictions whose parameters are open: what their uncertainty adds to the errors that are expected.
//!
//! ```text
//! E|y − ŷ|² = (variance of the filter) + mean over θ ~ N(θ̂, C) of |ŷ(θ) − ŷ(θ̂)|²
//! ```

use nalgebra::{DMatrix, DVector};

use super::{FilterErrorFit, Filtered, Forecast};
use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions};
use crate::model::Model;
use crate::noise::Noise;
use crate::run::Run;

/// Draws of the parameters by which it is found how far their uncertainty spreads predictions.
const DRAWS: usize = 8;

/// `forecasts` of `runs`, made with `estimated` (the fit's model, its parameters held), with what the uncertainty of the
/// parameters adds to the expected errors: the mean of their squares under parameters drawn from the estimate's
/// distribution, less that under the estimate itself. Without a random force it is all that makes an unstable vehicle's
/// predictions err.
///
/// # Errors
/// [`OutputErrorError`] where a run lacks what the model reads.
pub fn with_parameters_open(
    fit: &FilterErrorFit,
    estimated: &Model,
    forecasts: &[Forecast],
    (runs, options): (&[Run], &OutputErrorOptions),
    seed: u64,
) -> Result<Vec<Forecast>, OutputErrorError> {
    let unknowns = &fit.filtered.problem.unknowns;
    let p = unknowns.len();
    let mut open = forecasts.to_vec();
    let Some(root) = DMatrix::from_row_slice(p, p, &fit.covariance).cholesky().map(|f| f.l()) else { return Ok(open) };
    let mut noise = Noise::new(seed, 0xd4a3);
    for _ in 0..DRAWS {
        let step = &root * DVector::from_fn(p, |_, _| noise.normal());
        let mut model = estimated.clone();
        for (unknown, by) in unknowns.iter().zip(step.iter()).filter(|(u, _)| u.run.is_none()) {
            let parameter = &mut model.parameters[unknown.parameter];
            parameter.value = (parameter.value + by).clamp(parameter.min, parameter.max);
        }
        let drawn = Filtered::new(&model, runs, options)?.forecast(&model, &fit.noise, fit.limit);
        for ((open, drawn), own) in open.iter_mut().zip(&drawn).zip(forecasts) {
            for ((open, drawn), own) in open.channels.iter_mut().zip(&drawn.channels).zip(&own.channels) {
                for ((open, drawn), own) in open.predictions.iter_mut().zip(&drawn.predictions).zip(&own.predictions) {
                    open.expected += (drawn.squares - own.squares) / DRAWS as f64;
                }
            }
        }
    }
    for (open, own) in open.iter_mut().zip(forecasts) {
        for (open, own) in open.channels.iter_mut().zip(&own.channels) {
            for (open, own) in open.predictions.iter_mut().zip(&own.predictions) {
                // a draw that runs away leaves all open
                open.expected = if open.expected.is_nan() { f64::INFINITY } else { open.expected.max(own.expected) };
            }
        }
    }
    Ok(open)
}
