//! Filter error: maximum likelihood of a model that expects to be pushed.
//!
//! ```text
//! ẋ = f(x, θ, τ) + M⁻¹ d,   ḋ = −d/T + white,   y = h(x, θ) + e        min over θ, η of  −2 ln L = Σ (e²/s + ln s)
//! ```
//!
//! In real water a vehicle is pushed all the time: turbulence, tether, thrusters that are not quite what the curve says.
//! A Kalman filter carries what is believed of the state from sample to sample; the innovations e, with the variance s
//! that the filter itself expects, make the likelihood. θ by Gauss-Newton on the innovations, the noise η (rms and
//! correlation time of the random force in each degree of freedom, deviation of each sensor) by Fisher scoring, in turns
//! until neither moves. No segments and no initial states: each run is one stretch, and an unstable vehicle needs
//! nothing special. Jategaonkar, *Flight Vehicle System Identification* (2015), ch. 5; Kristensen, Madsen and Jørgensen,
//! *Automatica* 40 (2004) 225-237.

mod forecast;
mod gauss_markov;
mod likelihood;
mod noise;
mod options;
mod pass;
mod problem;
mod sensor;
mod start;
mod steps;
mod transition;
mod ud;

use nalgebra::DMatrix;

pub use forecast::{AHEAD, Channel, Forecast, Point, Prediction, Whiteness};
pub use noise::{Coloured, Coordinate, NoiseModel, RandomForce, SensorNoise};
pub use options::{FilterErrorOptions, Forces};
pub use problem::Filtered;

use super::output_error::OutputErrorError;
use crate::least_squares::singular_ratio;
use crate::model::Model;
use crate::run::Run;

/// The result of a filter-error fit.
#[derive(Debug, Clone)]
pub struct FilterErrorFit {
    /// The model with the estimates and their standard deviations in place.
    pub model: Model,
    /// The noise.
    pub noise: NoiseModel,
    /// The runs, unknowns and starting beliefs.
    pub filtered: Filtered,
    /// Covariance of the unknowns, row-major.
    pub covariance: Vec<f64>,
    /// Unknowns of the noise that were estimated, and the covariance of their logarithms.
    pub noise_covariance: (Vec<Coordinate>, DMatrix<f64>),
    /// −2 ln L, priors included.
    pub cost: f64,
    /// Number of samples.
    pub samples: usize,
    /// Deviations beyond which innovations are held back; infinite where no outlier was met.
    pub limit: f64,
    /// Passes taken.
    pub iterations: usize,
    /// Whether the last steps were small enough.
    pub converged: bool,
}

impl FilterErrorFit {
    /// cond(JᵀJ), J: Jacobian of the innovations over their deviations: the covariance has the same.
    pub fn condition_number(&self) -> f64 {
        let p = self.filtered.problem.unknowns.len();
        let factor = DMatrix::from_row_slice(p, p, &self.covariance).cholesky().map(|f| f.l());
        let columns = factor.map(|l| (0..p).map(|j| l.column(j).iter().copied().collect()).collect());
        columns.map_or(f64::INFINITY, |columns: Vec<Vec<f64>>| singular_ratio(columns).powi(2))
    }
}

/// Fits the free parameters of `model`, which holds their starting values, and the noise to `runs`.
///
/// # Errors
/// [`OutputErrorError`].
pub fn filter_error(
    model: &Model,
    runs: &[Run],
    options: &FilterErrorOptions,
) -> Result<FilterErrorFit, OutputErrorError> {
    let filtered = Filtered::new(model, runs, &options.base)?;
    let noise = start::noise(&filtered, model, runs, &options.forces);
    steps::maximised(model, filtered, noise, options)
}
