//! The profile likelihood of one parameter, which is held at several values while all others are
//! refitted.
//!
//! ```text
//! Λ(θ_k) = (min over all others of cost(θ_k) − cost) / s²        Λ ≤ 3.84 within the 95 % interval
//! ```
//!
//! If the likelihood is not a parabola, this interval is right and estimate ± 1.96 std is not; if
//! it never rises, the data do not bound the parameter. Murphy and van der Vaart, *J. Am. Stat.
//! Assoc.* 95 (2000) 449-465.

use crate::estimate::output_error::{OutputErrorError, OutputErrorFit, OutputErrorOptions, output_error};
use crate::run::Run;

/// Chi-square of one degree of freedom at 95 %.
const BOUND: f64 = 3.841_458_820_694_124;

/// Distances from the estimate at which a parameter is held, in standard deviations.
const DISTANCES: [f64; 4] = [1.0, 2.0, 3.0, 5.0];

/// One point of a profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfilePoint {
    /// Value at which the parameter is held, SI.
    pub value: f64,
    /// Λ there.
    pub rise: f64,
}

/// The profile of one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Index of the parameter in the model.
    pub parameter: usize,
    /// Points, by value.
    pub points: Vec<ProfilePoint>,
    /// 95 % interval, SI; `None` on a side where Λ does not rise to its bound within five standard
    /// deviations.
    pub interval: [Option<f64>; 2],
}

/// The profile of the common parameter number `parameter` of a fit.
///
/// # Errors
/// [`OutputErrorError`] if the fit with the parameter held cannot be done.
pub fn profile(
    fit: &OutputErrorFit,
    runs: &[Run],
    options: &OutputErrorOptions,
    parameter: usize,
) -> Result<Profile, OutputErrorError> {
    let told = &fit.model.parameters[parameter];
    let (best, std) = (told.value, told.std.unwrap_or(0.0));
    let states = fit.problem.free_states();
    let unknowns = fit.problem.unknowns.len() + states * fit.problem.segments.len();
    let scale = fit.cost / fit.samples.saturating_sub(unknowns).max(1) as f64;
    let sigma = fit.problem.dynamics.outputs.iter().cloned().zip(fit.problem.sigma.iter().copied()).collect();
    let options = OutputErrorOptions { sigma: Some(sigma), ..options.clone() };
    let mut points = vec![ProfilePoint { value: best, rise: 0.0 }];
    for sign in [-1.0, 1.0] {
        // each fit starts where the last one ended
        let mut model = fit.model.clone();
        model.parameters[parameter].fixed = true;
        for distance in DISTANCES {
            let value = best + sign * distance * std;
            if value < told.min || value > told.max {
                break;
            }
            model.parameters[parameter].value = value;
            let held = output_error(&model, runs, &options)?;
            points.push(ProfilePoint { value, rise: (held.cost - fit.cost).max(0.0) / scale });
            model = held.model;
            if points.last().is_some_and(|p| p.rise > 2.0 * BOUND) {
                break;
            }
        }
    }
    points.sort_by(|a, b| a.value.total_cmp(&b.value));
    let middle = points.iter().position(|p| p.value.total_cmp(&best).is_eq()).unwrap_or(0);
    let lower = crossing(points[..=middle].iter().rev());
    let upper = crossing(points[middle..].iter());
    Ok(Profile { parameter, points, interval: [lower, upper] })
}

/// The value at which √Λ, which is a straight line for a parabola, crosses its bound going
/// outwards.
fn crossing<'a>(outwards: impl Iterator<Item = &'a ProfilePoint>) -> Option<f64> {
    let points: Vec<&ProfilePoint> = outwards.collect();
    let pair = points.windows(2).find(|w| w[1].rise >= BOUND)?;
    let (a, b, bound) = (pair[0].rise.sqrt(), pair[1].rise.sqrt(), BOUND.sqrt());
    Some(pair[0].value + (pair[1].value - pair[0].value) * (bound - a) / (b - a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_gives_the_usual_interval_and_a_flat_side_none() {
        let point = |value: f64| ProfilePoint { value, rise: value * value };
        let upper = crossing([0.0, 1.0, 2.0].map(point).iter());
        // √3.8415 = 1.95996
        assert!((upper.unwrap() - 1.959_963_98).abs() < 1e-8, "{upper:?}");
        let flat = [0.0, 1.0, 2.0].map(|value| ProfilePoint { value, rise: 0.1 * value });
        assert_eq!(crossing(flat.iter()), None);
    }
}
