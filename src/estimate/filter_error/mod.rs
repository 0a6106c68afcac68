//! Filter error: maximum likelihood of a model with random forces.
//!
//! ```text
//! ẋ = f(x, θ, τ) + M⁻¹ d,   ḋ = −d/T + white,   y = h(x, θ) + e
//! min over θ, η of  −2 ln L = Σ (e²/s + ln s)
//! ```
//!
//! In real water a vehicle is pushed all the time: by turbulence, by the tether, by thrusters that
//! do not quite follow their curve. A Kalman filter carries the estimate of the state from sample
//! to sample; the innovations e, with the variance s that the filter itself expects, give the
//! likelihood. The parameters θ are found by Gauss-Newton on the innovations, the noise η (rms and
//! correlation time of the random force in each degree of freedom, standard deviation of each
//! sensor) by Fisher scoring. Both kinds of steps alternate until neither moves; if they get stuck
//! on the way, both are moved together. There are no segments and no free initial states: each run
//! is one stretch, and an unstable vehicle needs no special treatment. Jategaonkar, *Flight Vehicle
//! System Identification* (2015), ch. 5; Kristensen, Madsen and Jørgensen, *Automatica* 40 (2004)
//! 225-237.

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
    /// The runs, unknowns and initial state estimates.
    pub filtered: Filtered,
    /// Covariance of the unknowns, row-major.
    pub covariance: Vec<f64>,
    /// Unknowns of the noise that were estimated.
    pub noise_unknowns: Vec<Coordinate>,
    /// Standard deviation of the noise of each output, where one is given.
    pub stated: Vec<Option<f64>>,
    /// −2 ln L, priors included.
    pub cost: f64,
    /// −2 ln L with every innovation as it is, before any were held back.
    pub plain: f64,
    /// Number of samples.
    pub samples: usize,
    /// Number of standard deviations beyond which innovations are held back; infinite if no outlier
    /// was found.
    pub limit: f64,
    /// Stretches linearised at the estimate.
    pub linear: Vec<Linear>,
    /// Number of passes taken.
    pub iterations: usize,
    /// Whether the last steps were small enough.
    pub converged: bool,
    /// The kind of steps by which the fit reached its estimate.
    pub(crate) reached: Reached,
}

/// The kind of steps by which a fit reached its estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reached {
    /// Alternating steps of parameters and noise.
    InTurns,
    /// The same, until a step that promised a gain failed.
    Stuck,
    /// Joint steps of parameters and noise, after that.
    Together,
}

impl FilterErrorFit {
    /// Share of the innovations that are held back, and the share beyond the limit by chance in
    /// Gaussian noise; `None` if every innovation counts as it is.
    pub fn held_back(&self) -> Option<(f64, f64)> {
        let beyond = self.linear.iter().map(|s| s.beyond).sum::<usize>() as f64 / self.samples as f64;
        self.limit.is_finite().then(|| (beyond, 1.0 - tails::share(self.limit)))
    }

    /// Predicts the runs of the fit.
    pub fn forecast(&self) -> Vec<Forecast> {
        self.filtered.forecast(&self.model, &self.noise, self.limit)
    }

    /// −2 ln L of the runs of the fit with the parameters of each of `models` and the noise of the
    /// fit; infinite for a model that diverges.
    pub(crate) fn costs_at(&self, models: &[Model]) -> Vec<f64> {
        let points: Vec<(Model, NoiseModel)> = models.iter().map(|m| (m.clone(), self.noise.clone())).collect();
        let Some(mobilities) = self.filtered.mobilities(&self.model) else { return vec![f64::INFINITY; models.len()] };
        let costs = self.filtered.costs_side_by_side(&self.model, &points, &mobilities, self.limit);
        let whole = |stretches: Vec<f64>| stretches.into_iter().sum::<f64>();
        costs.into_iter().map(whole).map(|cost| if cost.is_finite() { cost } else { f64::INFINITY }).collect()
    }

    /// Options of a refit nearby, with slightly different runs or inputs: it takes the same kind of
    /// steps as this fit, wherever they lead.
    pub(crate) fn nearby(&self, options: &FilterErrorOptions) -> FilterErrorOptions {
        let higher = if self.reached == Reached::Together { 0.0 } else { f64::INFINITY };
        FilterErrorOptions { higher, told: false, ..options.clone() }
    }

    /// Index and prior information of each unknown that has a prior.
    pub(crate) fn priors(&self) -> impl Iterator<Item = (usize, f64)> {
        let prior = |(k, unknown): (usize, &Unknown)| {
            let (_, std) = self.model.parameters[unknown.parameter].prior?;
            Some((k, 1.0 / (std * std)))
        };
        self.filtered.problem.unknowns.iter().enumerate().filter_map(prior)
    }

    /// Covariance of the logarithms of [`FilterErrorFit::noise_unknowns`], priors included; zero if
    /// the data do not determine them.
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

    /// cond(JᵀJ), where J is the Jacobian of the innovations over their standard deviations; the
    /// covariance has the same condition number.
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
        // a model that lacks much may start from values that no vehicle has
        Err(OutputErrorError::Diverges { values }) => {
            from(&tame(model, runs)).map_err(|_| OutputErrorError::Diverges { values })
        }
        fitted => fitted,
    }
}

/// [`filter_error`] from a noise that is roughly known, e.g. from the fit of a similar model.
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

/// Fits the free parameters of `model` to `runs` under a known noise, by Gauss-Newton alone.
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

/// −2 ln L of runs that took no part in a fit, under its model and noise; infinite if the model
/// diverges on them.
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

/// The Cramér-Rao bound with a random force: the covariance of the free parameters of `truth`,
/// row-major in the order of the unknowns, that no unbiased estimator can beat on `runs` under the
/// true `noise`.
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

/// Starting points for the tests of the steps.
#[cfg(test)]
mod tests {
    use super::steps::Search;
    use super::*;
    use crate::tank::{BlindOptions, blind};

    /// Runs of a tank, and its model with all free parameters a fifth too large.
    pub fn sailed() -> (Vec<Run>, Model) {
        let campaign = blind(&BlindOptions { duration: 40.0, ..BlindOptions::default() }).expect("the tank sails");
        let mut model = campaign.truth;
        model.parameters.iter_mut().filter(|p| !p.fixed).for_each(|p| p.value *= 1.2);
        (campaign.runs, model)
    }

    /// A search that starts from them.
    pub fn search<'a>((runs, model): &(Vec<Run>, Model), options: &'a FilterErrorOptions) -> Search<'a> {
        let filtered = Filtered::new(model, runs, &options.base).expect("the runs are whole");
        let noise = start::noises(&filtered, model, runs, &options.forces).remove(0);
        Search::new(model, filtered, noise, options).expect("it does not run away")
    }
}
