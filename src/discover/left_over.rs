//! Whether the names account for all of the residuals of the fit.
//!
//! ```text
//! q = (residual variance of the fit)/(noise floor of the same runs)²        both for what their states took up
//! q > 1 + 0.02 + 2 τ √(2d)/n                                                 n samples, d states fitted for the floor
//! ```
//!
//! On segments of some seconds a true model leaves the sensor's noise and nothing else; a chain of names that stands in
//! for something else can come near it on other runs and still leave more. 2 % is what sharing out the states among the
//! channels errs by; the last term is two deviations of the difference of two estimates from the same samples.

use super::colour::{colours, taken_up};
use super::gap::{FLOOR_SEGMENT, floor, lasting, spare};
use crate::estimate::output_error::{OutputErrorError, OutputErrorFit, OutputErrorOptions};
use crate::estimate::samples_in;
use crate::finding::{Code, Severity};
use crate::frame::Measured;
use crate::run::Run;

/// Names that leave something over.
pub(super) const LEFT_OVER: Code = Code {
    code: "D105",
    kind: "left-over",
    severity: Severity::Warning,
    meaning: "With everything that was named in the model the fit still leaves more than the noise of the sensors: \
              something is there that no effect of the catalogue explains, and the names may stand in for it.",
};

/// Error of sharing out the states among the channels.
const SHARING: f64 = 0.02;

/// What is measured of which the fit leaves more than the noise, with the residual variance over that of the noise.
///
/// # Errors
/// As [`floor`].
pub(super) fn left_over(
    fit: &OutputErrorFit,
    train: &[Run],
    options: &OutputErrorOptions,
) -> Result<Vec<(Measured, f64)>, OutputErrorError> {
    let colours = colours(fit);
    let problem = &fit.problem;
    let points: usize = problem.segments.iter().map(|s| s.last - s.first + 1).sum();
    let each = samples_in(lasting(FLOOR_SEGMENT, &fit.model, train), &fit.model, train).max(1) as f64;
    let states = problem.free_states() as f64 * points as f64 / each;
    let mut over = Vec::new();
    for (measured, noise) in floor(&fit.model, train, options)? {
        let Some(column) = problem.dynamics.outputs.iter().position(|o| *o == measured.channel()) else { continue };
        let known = options.sigma.as_ref().and_then(|sigma| sigma.get(measured.channel()));
        let noise = known.map_or(noise, |known| noise.max(*known));
        let left = fit.residual_rms[column].powi(2) * spare(fit, column, colours[column]) / (noise * noise);
        let samples = problem.samples_of(column).max(1) as f64;
        let chance = 2.0 * taken_up(colours[column], each) * (2.0 * states).sqrt() / samples;
        if left > 1.0 + SHARING + chance {
            over.push((measured, left));
        }
    }
    Ok(over)
}
