//! Predictions whose parameters, forces and start are open: how far they spread.
//!
//! ```text
//! E|y − ŷ|² = R + mean |ŷ(θ, d, x₀) − ŷ|²      θ ~ N(θ̂, C),  d: forces of the noise model,  x₀ ~ N(x̂, P)
//! ```
//!
//! The filter's own variance is linearised and takes the parameters for known: both are wrong seconds ahead of a vehicle
//! that is unstable, and of a motion larger than those of the fit.

use nalgebra::{DMatrix, DVector};

use super::prediction::DRAWS;
use super::{FilterErrorFit, Filtered, Forecast};
use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions};
use crate::model::Model;
use crate::noise::Noise;
use crate::run::Run;

/// `forecasts` of `runs`, made with `estimated` (the fit's model, its parameters held), their expected errors those of
/// draws where these are larger than the filter's.
///
/// # Errors
/// [`OutputErrorError`] where a run lacks what the model reads.
pub fn with_all_open(
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
    for draw in 0..DRAWS {
        let step = &root * DVector::from_fn(p, |_, _| noise.normal());
        let mut model = estimated.clone();
        for (unknown, by) in unknowns.iter().zip(step.iter()).filter(|(u, _)| u.run.is_none()) {
            let parameter = &mut model.parameters[unknown.parameter];
            parameter.value = (parameter.value + by).clamp(parameter.min, parameter.max);
        }
        let seed = seed.wrapping_mul(DRAWS as u64).wrapping_add(draw as u64);
        let drawn = Filtered::new(&model, runs, options)?.forecast_drawn(&model, &fit.noise, fit.limit, Some(seed));
        for ((open, drawn), own) in open.iter_mut().zip(&drawn).zip(forecasts) {
            for ((open, drawn), own) in open.channels.iter_mut().zip(&drawn.channels).zip(&own.channels) {
                for ((at, there), (_, here)) in drawn.foretold.iter().zip(&own.foretold) {
                    let sums = open.predictions[*at].drawn.get_or_insert([0.0; DRAWS]);
                    sums[draw] += (there - here).powi(2);
                }
            }
        }
    }
    for channel in open.iter_mut().flat_map(|forecast| &mut forecast.channels) {
        let variance = fit.noise.sensors[channel.output].std.powi(2);
        for prediction in &mut channel.predictions {
            let Some(drawn) = &mut prediction.drawn else { continue };
            drawn.iter_mut().for_each(|draw| *draw += variance * prediction.count as f64);
            let spread = drawn.iter().sum::<f64>() / DRAWS as f64;
            // a draw that runs away leaves all open
            prediction.expected = if spread.is_nan() { f64::INFINITY } else { prediction.expected.max(spread) };
        }
    }
    Ok(open)
}
