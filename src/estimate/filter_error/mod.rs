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
//! until neither moves; where those stick on the way, both together. No segments and no initial states: each run is one
//! stretch, and an unstable vehicle needs nothing special. Jategaonkar, *Flight Vehicle System Identification* (2015),
//! ch. 5; Kristensen, Madsen and Jørgensen, *Automatica* 40 (2004) 225-237.

mod adjoint;
mod ascent;
mod beginning;
mod differences;
mod elsewhere;
mod forecast;
mod gauss_markov;
mod information;
mod left_out;
mod likelihood;
mod noise;
mod noise_steps;
mod open;
mod options;
mod outliers;
mod pass;
mod prediction;
mod problem;
mod quasi_newton;
mod refine;
mod resampled;
mod sensor;
mod slope_correction;
mod smoothed_beginning;
mod start;
mod steps;
mod steps_together;
mod tails;
mod transition;
mod ud;
mod uncertain_noise;
mod unseen_velocity;
mod whiteness;

use nalgebra::DMatrix;

pub(crate) use elsewhere::first_halves;
pub use forecast::{AHEAD, Channel, Forecast, Point};
use information::Asked;
pub use likelihood::Linear;
pub use noise::{Coloured, Coordinate, NoiseModel, RandomForce, SensorNoise};
pub use open::with_all_open;
pub use options::{FilterErrorOptions, Forces};
pub use prediction::Prediction;
pub use problem::Filtered;
pub use whiteness::Whiteness;

use super::output_error::{OutputErrorError, Unknown, covariance};
use super::tame;
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
    /// Unknowns of the noise that were estimated.
    pub noise_unknowns: Vec<Coordinate>,
    /// Deviation of each output's noise, where one is stated.
    pub stated: Vec<Option<f64>>,
    /// −2 ln L, priors included.
    pub cost: f64,
    /// What it was with every innovation as it is, before any were held back.
    pub plain: f64,
    /// Number of samples.
    pub samples: usize,
    /// Deviations beyond which innovations are held back; infinite where no outlier was met.
    pub limit: f64,
    /// Stretches linearised at the estimate.
    pub linear: Vec<Linear>,
    /// Passes taken.
    pub iterations: usize,
    /// Whether the last steps were small enough.
    pub converged: bool,
    /// By which steps the fit has come where it is.
    pub(crate) reached: Reached,
}

/// By which steps a fit has come where it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reached {
    /// Parameters and noise in turns.
    InTurns,
    /// The same, until a step that promised something led nowhere.
    Stuck,
    /// Parameters and noise together, after that.
    Together,
}

impl FilterErrorFit {
    /// Share of the innovations that are held back, and the share that chance puts beyond the limit in Gaussian noise; `None` where
    /// every innovation counts as it is.
    pub fn held_back(&self) -> Option<(f64, f64)> {
        let beyond = self.linear.iter().map(|s| s.beyond).sum::<usize>() as f64 / self.samples as f64;
        self.limit.is_finite().then(|| (beyond, 1.0 - tails::share(self.limit)))
    }

    /// How it predicts the runs that it was made of.
    pub fn forecast(&self) -> Vec<Forecast> {
        self.filtered.forecast(&self.model, &self.noise, self.limit)
    }

    /// −2 ln L of the runs of the fit where `models` have its parameters, its noise as it is; infinite where one runs away.
    pub(crate) fn costs_at(&self, models: &[Model]) -> Vec<f64> {
        let points: Vec<(Model, NoiseModel)> = models.iter().map(|m| (m.clone(), self.noise.clone())).collect();
        let Some(mobilities) = self.filtered.mobilities(&self.model) else { return vec![f64::INFINITY; models.len()] };
        let costs = self.filtered.costs_side_by_side(&self.model, &points, &mobilities, self.limit);
        let whole = |stretches: Vec<f64>| stretches.into_iter().sum::<f64>();
        costs.into_iter().map(whole).map(|cost| if cost.is_finite() { cost } else { f64::INFINITY }).collect()
    }

    /// Options of a refit nearby, of runs or inputs that differ a little: it goes the way that this fit went, wherever that leads.
    pub(crate) fn nearby(&self, options: &FilterErrorOptions) -> FilterErrorOptions {
        let higher = if self.reached == Reached::Together { 0.0 } else { f64::INFINITY };
        FilterErrorOptions { higher, told: false, ..options.clone() }
    }

    /// Number and information of each unknown of which something is known beforehand.
    pub(crate) fn priors(&self) -> impl Iterator<Item = (usize, f64)> {
        let prior = |(k, unknown): (usize, &Unknown)| {
            let (_, std) = self.model.parameters[unknown.parameter].prior?;
            Some((k, 1.0 / (std * std)))
        };
        self.filtered.problem.unknowns.iter().enumerate().filter_map(prior)
    }

    /// Covariance of the logarithms of [`FilterErrorFit::noise_unknowns`], priors included; zero where the data do not
    /// determine them.
    pub fn noise_covariance(&self) -> DMatrix<f64> {
        let (filtered, unknowns) = (&self.filtered, &self.noise_unknowns);
        let covariance = filtered.mobilities(&self.model).and_then(|mobilities| {
            let mut information =
                filtered.noise_information(&self.model, &self.noise, unknowns, &mobilities, self.limit, Asked::All);
            start::Prior::new(unknowns, &self.stated).inform(&mut information);
            Some(information.cholesky()?.inverse())
        });
        covariance.unwrap_or_else(|| DMatrix::zeros(unknowns.len(), unknowns.len()))
    }

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
    let from = |model: &Model| {
        let filtered = Filtered::new(model, runs, &options.base)?;
        let noises = start::noises(&filtered, model, runs, &options.forces);
        ascent::maximised(model, filtered, noises, options)
    };
    match from(model) {
        // a model that lacks much may start as a vehicle that none is
        Err(OutputErrorError::Diverges { values }) => {
            from(&tame(model, runs)).map_err(|_| OutputErrorError::Diverges { values })
        }
        fitted => fitted,
    }
}

/// [`filter_error`] from a noise that is known roughly, as of a fit of nearly the same model.
///
/// # Errors
/// [`OutputErrorError`].
pub fn filter_error_from(
    model: &Model,
    runs: &[Run],
    noise: NoiseModel,
    options: &FilterErrorOptions,
) -> Result<FilterErrorFit, OutputErrorError> {
    ascent::maximised(model, Filtered::new(model, runs, &options.base)?, vec![noise], options)
}

/// The free parameters of `model` on `runs` under a noise that is known, by Gauss-Newton alone.
///
/// # Errors
/// As [`filter_error`].
pub fn parameters_under(
    model: &Model,
    runs: &[Run],
    (noise, limit): (&NoiseModel, f64),
    options: &FilterErrorOptions,
) -> Result<Model, OutputErrorError> {
    steps::parameters_under(model, Filtered::new(model, runs, &options.base)?, noise.clone(), limit, options)
}

/// −2 ln L of runs that took no part in a fit, under its model and noise; infinite where the model runs away on them.
///
/// # Errors
/// [`OutputErrorError`] where a run lacks what the model reads.
pub fn cost_of(
    model: &Model,
    runs: &[Run],
    (noise, limit): (&NoiseModel, f64),
    options: &FilterErrorOptions,
) -> Result<f64, OutputErrorError> {
    let filtered = Filtered::begun(model, runs, (noise, limit), &options.base)?;
    let Some(mobilities) = filtered.mobilities(model) else { return Ok(f64::INFINITY) };
    let stretches = filtered.linearise(model, noise, &mobilities, limit, false);
    let cost: f64 = stretches.iter().map(|s| s.cost).sum();
    Ok(if cost.is_finite() { cost } else { f64::INFINITY })
}

/// The Cramér-Rao bound with a random force: covariance of the free parameters of `truth`, row-major in the order of
/// the unknowns, that no unbiased estimator can beat on `runs` under the true `noise`.
///
/// # Errors
/// [`OutputErrorError`] where a run lacks what the model reads or does not determine a parameter.
pub fn bound(
    truth: &Model,
    runs: &[Run],
    noise: &NoiseModel,
    options: &FilterErrorOptions,
) -> Result<Vec<f64>, OutputErrorError> {
    let filtered = Filtered::new(truth, runs, &options.base)?;
    let mobilities = filtered.mobilities(truth).unwrap_or_default();
    let linear = filtered.linearise(truth, noise, &mobilities, f64::INFINITY, true);
    covariance::bread(&filtered.problem, truth, &filtered.factor(truth, &linear))
}

/// Where the tests of the steps begin.
#[cfg(test)]
mod tests {
    use super::steps::Search;
    use super::*;
    use crate::tank::{BlindOptions, blind};

    /// Runs of a tank, and its model with parameters a fifth off.
    pub fn sailed() -> (Vec<Run>, Model) {
        let campaign = blind(&BlindOptions { duration: 40.0, ..BlindOptions::default() }).expect("the tank sails");
        let mut model = campaign.truth;
        model.parameters.iter_mut().filter(|p| !p.fixed).for_each(|p| p.value *= 1.2);
        (campaign.runs, model)
    }

    /// A search from there.
    pub fn search<'a>((runs, model): &(Vec<Run>, Model), options: &'a FilterErrorOptions) -> Search<'a> {
        let filtered = Filtered::new(model, runs, &options.base).expect("the runs are whole");
        let noise = start::noises(&filtered, model, runs, &options.forces).remove(0);
        Search::new(model, filtered, noise, options).expect("it does not run away")
    }
}
