//! Spread of predictions by Monte Carlo over parameters, random force and initial state.
//!
//! ```text
//! s = R + mean |ŷ(θ, d, x₀) − ŷ|²      θ ~ N(θ̂, C),  d: forces of the noise model,  x₀ ~ N(x̂, P)
//! Σ min((y − ŷ)²/s, 6²)               against the same sum of each draw, with the s of the other draws
//! ```
//!
//! The filter's own variance is linearised and takes the parameters as known. Both are wrong
//! seconds ahead for an unstable vehicle, and for a motion larger than those of the fit. One
//! prediction that went the other way says little about such a vehicle, however large its error; a
//! wrong model errs again and again.

use nalgebra::{DMatrix, DVector};

use super::prediction::{DRAWS, Prediction};
use super::{FilterErrorFit, Filtered, Forecast};
use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions};
use crate::model::Model;
use crate::noise::Noise;
use crate::run::Run;

/// Greatest error of a prediction, in standard deviations: a larger error counts as this.
const FARTHEST: f64 = 6.0;

/// Returns `forecasts` of `runs` in units of the standard deviation given by draws, where that is
/// larger than the filter's. The forecasts were made with `estimated`, the model of the fit with
/// its parameters held.
///
/// # Errors
/// [`OutputErrorError`] if a run lacks what the model reads.
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
    // for each prediction, the difference between each draw and it
    let mut off: Vec<Vec<Vec<[f64; DRAWS]>>> =
        forecasts.iter().map(|f| f.channels.iter().map(|c| vec![[0.0; DRAWS]; c.foretold.len()]).collect()).collect();
    let random = fit.noise.elsewhere(estimated, runs);
    for draw in 0..DRAWS {
        let step = &root * DVector::from_fn(p, |_, _| noise.normal());
        let mut model = estimated.clone();
        for (unknown, by) in unknowns.iter().zip(step.iter()).filter(|(u, _)| u.run.is_none()) {
            let parameter = &mut model.parameters[unknown.parameter];
            parameter.value = (parameter.value + by).clamp(parameter.min, parameter.max);
        }
        let seed = seed.wrapping_mul(DRAWS as u64).wrapping_add(draw as u64);
        let filtered = Filtered::begun(&model, runs, (&random, fit.limit), options)?;
        let drawn = filtered.forecast_drawn(&model, &random, fit.limit, Some(seed));
        for ((off, drawn), own) in off.iter_mut().zip(&drawn).zip(forecasts) {
            for ((off, drawn), own) in off.iter_mut().zip(&drawn.channels).zip(&own.channels) {
                for ((off, there), here) in off.iter_mut().zip(&drawn.foretold).zip(&own.foretold) {
                    off[draw] = there.mean - here.mean;
                }
            }
        }
    }
    let channels = open.iter_mut().zip(&off).flat_map(|(forecast, off)| forecast.channels.iter_mut().zip(off));
    for (channel, off) in channels {
        let white = fit.noise.sensors[channel.output].std.powi(2);
        for (at, prediction) in channel.predictions.iter_mut().enumerate() {
            let own = channel.foretold.iter().zip(off).filter(|(f, _)| f.at == at && !f.wild);
            if own.clone().next().is_some() {
                *prediction = in_deviations(*prediction, white, own.map(|(f, off)| (f.error, f.variance, off)));
            }
        }
    }
    Ok(open)
}

/// A prediction in units of the standard deviation given by draws. `parts` holds, for each
/// predicted sample, the error, the variance that the filter expected, and the difference of each
/// draw; `white` is the variance of the sensor.
fn in_deviations<'a>(
    prediction: Prediction,
    white: f64,
    parts: impl Iterator<Item = (f64, f64, &'a [f64; DRAWS])>,
) -> Prediction {
    let (mut squares, mut drawn, mut count) = (0.0, [0.0; DRAWS], 0);
    for (error, variance, off) in parts {
        let spread = white + off.iter().map(|x| x * x).sum::<f64>() / DRAWS as f64;
        count += 1;
        if !error.is_finite() {
            // the model itself diverges from where the vehicle was
            squares += FARTHEST * FARTHEST;
            drawn.iter_mut().for_each(|sum| *sum += 1.0);
        } else if spread.is_finite() {
            // if a draw diverges, the prediction is not judged
            let counts = |square: f64, s: f64| (square / s.max(variance)).min(FARTHEST * FARTHEST);
            squares += counts(error * error, spread);
            // a draw is compared with the other draws, as the vehicle is with all of them: if few
            // draws go the other way, one that does counts
            for (sum, x) in drawn.iter_mut().zip(off) {
                let others = (spread - white - x * x / DRAWS as f64) * DRAWS as f64 / (DRAWS - 1) as f64;
                *sum += counts(x * x + white, white + others.max(0.0));
            }
        }
    }
    Prediction { squares, expected: f64::from(count), drawn: Some(drawn), ..prediction }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twenty predictions, from which draws differ by 1 and −3 in turn. One error of a thousand
    /// counts as six standard deviations, and is not significant; ten errors of six show that the
    /// model is wrong. If draws are not numbers, a prediction is not judged.
    #[test]
    fn one_prediction_that_went_the_other_way_is_no_error_and_ten_are() {
        let off = |part: usize| -> [f64; DRAWS] {
            std::array::from_fn(|k| if (k + part).is_multiple_of(2) { 1.0 } else { -3.0 })
        };
        let drawn: Vec<[f64; DRAWS]> = (0..20).map(off).collect();
        let of = |errors: &[f64], drawn: &[[f64; DRAWS]]| {
            let empty = Prediction::new(Some(8.0));
            let prediction = Prediction { count: errors.len(), ..empty };
            in_deviations(prediction, 0.0, errors.iter().zip(drawn).map(|(e, off)| (*e, 1.0, off)))
        };
        let deviation = 5f64.sqrt();
        let mut errors = vec![deviation; 20];
        assert!((of(&errors, &drawn).ratio() - 1.0).abs() < 1e-12);
        errors[7] = 1000.0;
        let once = of(&errors, &drawn);
        assert!((once.squares - 19.0 - 36.0).abs() < 1e-12 && !once.errs(12), "{once:?}");
        errors[..10].fill(6.0 * deviation);
        assert!(of(&errors, &drawn).errs(12));
        let lost = [[f64::NAN; DRAWS]; 20];
        assert_eq!(of(&errors, &lost).squares, 0.0);
        assert!(of(&[f64::NAN; 20], &lost).errs(12), "the model itself is lost");
    }
}
