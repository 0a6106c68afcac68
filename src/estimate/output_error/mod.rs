//! Output error on segments (multiple shooting): the estimator for measurement noise alone.
//!
//! ```text
//! min over θ, x₀ₛ of  Σ_s Σ_k |h(x(t_k; x₀ₛ, θ), θ) − y_k|² / σ² + priors
//! ```
//!
//! Each run is divided into segments of some seconds, each simulated from a free initial state x₀ₛ.
//! The method is Levenberg-Marquardt with integrated sensitivities. The initial states are
//! eliminated segment by segment in a triangular factor, so that the cost grows with the number of
//! segments and not with its cube. Noise enters where it belongs, in the measurement, and unstable
//! motions have no time to diverge. Bock (1983); Jategaonkar, *Flight Vehicle System
//! Identification* (2015), ch. 4.

mod bound;
pub(crate) mod covariance;
mod fold;
mod join;
mod loss;
mod noise;
mod observed;
mod problem;
mod resampled;
mod response;
mod states;

use std::collections::BTreeMap;

use thiserror::Error;

pub(crate) use fold::Fold;
pub(crate) use observed::heading_is_known;
pub(crate) use problem::LANES;
pub use problem::{Linearised, Problem, Unknown};

pub use bound::cramer_rao;
pub use covariance::StdMethod;
pub(crate) use loss::HUBER;
pub use loss::Loss;

use crate::log::number::short;
use crate::model::Model;
use crate::progress;
use crate::run::Run;
use crate::simulate::TrackError;

/// Longest step of the integrator if the motion may be quick and no other step is given, s: RK4 is
/// then accurate to 1e-5 for time constants above 0.5 s.
pub const LONGEST_STEP: f64 = 0.1;

/// Options of the fit.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputErrorOptions {
    /// Length of a segment, s. Long enough to see slow drag, short enough that unstable motion
    /// stays near the data.
    pub segment: f64,
    /// Longest step of the integrator, s; `None`: [`LONGEST_STEP`], or longer if the motion is
    /// slow.
    pub longest_step: Option<f64>,
    /// Whether the logged position is a measurement of its own (acoustic, GNSS), not integrated
    /// from the velocity.
    pub position: bool,
    /// Standard deviation of the noise by channel, SI; estimated from the data if absent.
    pub sigma: Option<BTreeMap<String, f64>>,
    /// Greatest number of steps.
    pub iterations: usize,
    /// Converged when a step would lower the cost by less than this share of one degree of freedom.
    pub tolerance: f64,
    /// Length of the clusters whose residuals are taken as independent of one another, s.
    pub cluster: f64,
    /// The cost of a residual: its square, or less if outliers are expected.
    pub loss: Loss,
    /// Whether segments are joined at the end if the data allow it, so that fewer initial states
    /// take up information.
    pub join: bool,
    /// Whether each step is reported to the observer of the progress; a fit within other work stays
    /// silent.
    pub told: bool,
}

impl OutputErrorOptions {
    /// Longest step of a motion that may be quick, s.
    pub fn longest_step_of_quick_motion(&self) -> f64 {
        self.longest_step.unwrap_or(LONGEST_STEP)
    }
}

impl Default for OutputErrorOptions {
    fn default() -> OutputErrorOptions {
        OutputErrorOptions {
            segment: 8.0,
            longest_step: None,
            position: false,
            sigma: None,
            iterations: 40,
            tolerance: 1e-3,
            cluster: 24.0,
            loss: Loss::Squares,
            join: false,
            told: false,
        }
    }
}

/// Reason why an output-error fit cannot be done.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum OutputErrorError {
    /// No channel that the model predicts is logged.
    #[error("no run logs a velocity, rate or angle that the model predicts")]
    NothingObserved,
    /// A run lacks what the model reads, or is too short.
    #[error(transparent)]
    Track(#[from] TrackError),
    /// Fewer samples than unknowns.
    #[error("{samples} samples for {unknowns} unknowns: more data or fewer effects are needed")]
    TooFewSamples {
        /// Number of samples.
        samples: usize,
        /// Number of unknowns, initial states included.
        unknowns: usize,
    },
    /// The simulation overflows at the starting values.
    #[error("the simulation diverges at the starting values of the parameters: {values}")]
    Diverges {
        /// Names and values.
        values: String,
    },
    /// A bootstrap draws clusters, and there are fewer than two.
    #[error("{clusters} clusters of residuals to draw from: a bootstrap needs at least two; use shorter ones")]
    TooFewClusters {
        /// Number of clusters.
        clusters: usize,
    },
    /// A fit that was compared with another one, and had no hope of becoming better.
    #[error("given up after {passes} passes: another fit is far better")]
    GivenUp {
        /// Passes taken.
        passes: usize,
        /// −2 ln L there.
        cost: f64,
    },
    /// A parameter that the data do not determine.
    #[error("this data says nothing about {}: fix them, or add a run that moves them", at_the_end(.parameters, .values))]
    NotIdentified {
        /// Their names ([`crate::model::Parameter::full_name`]).
        parameters: Vec<String>,
        /// Their values where the search ended: a value that has grown without bound points to a
        /// motion that the force of its term does not make.
        values: Vec<f64>,
    },
}

/// Names with the values where the search ended.
fn at_the_end(names: &[String], values: &[f64]) -> String {
    let shown = |(name, value): (&String, &f64)| format!("{name} ({} where the search ended)", short(*value, 2));
    names.iter().zip(values).map(shown).collect::<Vec<_>>().join(", ")
}

/// The result of an output-error fit.
#[derive(Debug, Clone)]
pub struct OutputErrorFit {
    /// The model with the estimates and their standard deviations in place.
    pub model: Model,
    /// The problem at the estimate: segments, noise, unknowns.
    pub problem: Problem,
    /// Initial state of each segment.
    pub initial_states: Vec<Vec<f64>>,
    /// Segments linearised at the estimate.
    pub linearised: Vec<Linearised>,
    /// Covariance of the unknowns, row-major.
    pub covariance: Vec<f64>,
    /// How the standard deviations were computed.
    pub std_method: StdMethod,
    /// Σ (residual/σ)².
    pub cost: f64,
    /// Number of samples.
    pub samples: usize,
    /// Root mean square of the residuals of each output, in its unit.
    pub residual_rms: Vec<f64>,
    /// Steps taken.
    pub iterations: usize,
    /// Whether the last step was small enough.
    pub converged: bool,
}

impl OutputErrorFit {
    /// Root mean square of the residuals of each output in units of its noise.
    pub fn times_noise(&self) -> Vec<f64> {
        self.residual_rms.iter().zip(&self.problem.sigma).map(|(rms, sigma)| rms / sigma).collect()
    }
}

/// Fits the free parameters of `model`, which holds their starting values, to `runs`.
///
/// # Errors
/// [`OutputErrorError`].
pub fn output_error(
    model: &Model,
    runs: &[Run],
    options: &OutputErrorOptions,
) -> Result<OutputErrorFit, OutputErrorError> {
    let problem = Problem::new(model, runs, options)?;
    let x0 = problem.initial_states(model);
    let fit = fit_from(model, problem, x0, options)?;
    if options.join { join::joined(fit, options) } else { Ok(fit) }
}

/// [`output_error`] of a prepared problem from given initial states.
pub(crate) fn fit_from(
    model: &Model,
    mut problem: Problem,
    mut x0: Vec<Vec<f64>>,
    options: &OutputErrorOptions,
) -> Result<OutputErrorFit, OutputErrorError> {
    let mut model = model.clone();
    let unknowns = problem.unknowns.clone();
    let delays = problem.dynamics.delays();
    let mut current = problem.linearise(&model, &x0);
    let mut cost = total(&current) + prior_cost(&model, &unknowns);
    if !cost.is_finite() {
        let name = |p: &crate::model::Parameter| format!("{} {} = {}", p.term, p.spec.name, p.value);
        let values = model.parameters.iter().map(name).collect::<Vec<_>>().join(", ");
        return Err(OutputErrorError::Diverges { values });
    }
    let samples: usize = current.iter().map(|s| s.samples).sum();
    let count = unknowns.len() + problem.free_states() * problem.segments.len();
    if samples <= count {
        return Err(OutputErrorError::TooFewSamples { samples, unknowns: count });
    }
    if unknowns.is_empty() {
        let (x0, settled, steps) = states::settle(&problem, &model, x0, current, options);
        let cost = total(&settled);
        return finish(model, problem, x0, settled, cost, samples, steps, steps < options.iterations, options);
    }
    let (mut damping, mut iterations, mut converged, mut refused) = (1e-6, 0, false, false);
    let mut held = vec![0.0; problem.segments.len()];
    while iterations < options.iterations {
        iterations += 1;
        if options.told {
            progress::tell("fitting by output error", iterations, 0);
        }
        let global = normal_factor(&problem, &model, &current);
        let (step, predicted) = damped_step(&global, &model, &unknowns, damping);
        let mut trial = model.clone();
        for (unknown, delta) in unknowns.iter().zip(&step) {
            move_by(&mut trial, *unknown, *delta);
        }
        let taken: Vec<f64> = unknowns.iter().map(|u| value(&trial, *u) - value(&model, *u)).collect();
        let states = states::follow(&problem, &current, &x0, &taken, &held);
        let late = unknowns.iter().zip(&taken).any(|(u, d)| delays.contains(&u.parameter) && *d != 0.0);
        if late {
            read_inputs(&mut problem, &trial);
        }
        let next = problem.linearise(&trial, &states);
        let next_cost = total(&next) + prior_cost(&trial, &unknowns);
        let gain = cost - next_cost;
        if next_cost.is_finite() && gain >= -1e-9 * cost.abs() {
            (model, x0, current, cost) = (trial, states, next, next_cost);
            if problem.follow(&model) {
                current = problem.linearise(&model, &x0);
                cost = total(&current) + prior_cost(&model, &unknowns);
            }
            // a damping that has just been refused would be refused again
            if !refused {
                damping = (damping * 0.1).max(1e-12);
                states::ease(&mut held);
            }
            refused = false;
            if predicted.min(gain.abs()) < options.tolerance || predicted < 1e-12 * cost {
                converged = true;
                break;
            }
        } else {
            if unknowns.iter().any(|u| delays.contains(&u.parameter)) {
                read_inputs(&mut problem, &model);
            }
            (damping, refused) = ((damping * 10.0).max(1e-4), true);
            states::hold_back(&mut held, &current, &next);
            if damping > 1e8 {
                converged = predicted < 1.0;
                break;
            }
        }
    }
    finish(model, problem, x0, current, cost, samples, iterations, converged, options)
}

#[allow(clippy::too_many_arguments)] // the pieces of the result
fn finish(
    mut model: Model,
    problem: Problem,
    initial_states: Vec<Vec<f64>>,
    linearised: Vec<Linearised>,
    cost: f64,
    samples: usize,
    iterations: usize,
    converged: bool,
    options: &OutputErrorOptions,
) -> Result<OutputErrorFit, OutputErrorError> {
    let (covariance, std_method) = covariance::of(&problem, &model, &linearised, options)?;
    let p = problem.unknowns.len();
    for (k, unknown) in problem.unknowns.iter().enumerate() {
        let std = covariance[k * p + k].sqrt();
        let parameter = &mut model.parameters[unknown.parameter];
        // of a parameter per run, the largest standard deviation is shown
        parameter.std =
            Some(if unknown.run.is_some_and(|r| r > 0) { parameter.std.unwrap_or(0.0).max(std) } else { std });
    }
    let ny = problem.dynamics.outputs.len();
    let residual_rms = (0..ny)
        .map(|k| {
            let squares: f64 = linearised.iter().map(|s| s.squares[k]).sum();
            let count = problem.samples_of(k);
            problem.sigma[k] * (squares / count.max(1) as f64).sqrt()
        })
        .collect();
    Ok(OutputErrorFit {
        model,
        problem,
        initial_states,
        linearised,
        covariance,
        std_method,
        cost,
        samples,
        residual_rms,
        iterations,
        converged,
    })
}

/// Σ (residual/σ)² over all segments.
pub(crate) fn total(segments: &[Linearised]) -> f64 {
    segments.iter().map(Linearised::cost).sum()
}

pub(crate) fn prior_cost(model: &Model, unknowns: &[Unknown]) -> f64 {
    let term =
        |u: &Unknown| model.parameters[u.parameter].prior.map_or(0.0, |(m, s)| ((value(model, *u) - m) / s).powi(2));
    unknowns.iter().map(term).sum()
}

/// Value of an unknown.
pub(crate) fn value(model: &Model, unknown: Unknown) -> f64 {
    let parameter = &model.parameters[unknown.parameter];
    unknown.run.and_then(|r| parameter.per_run.get(r).copied()).unwrap_or(parameter.value)
}

/// Moves an unknown, within its bounds.
pub(crate) fn move_by(model: &mut Model, unknown: Unknown, delta: f64) {
    let moved = value(model, unknown) + delta;
    let parameter = &mut model.parameters[unknown.parameter];
    let moved = moved.clamp(parameter.min, parameter.max);
    match unknown.run {
        None => parameter.value = moved,
        Some(run) => {
            if parameter.per_run.len() <= run {
                parameter.per_run.resize(run + 1, parameter.value);
            }
            parameter.per_run[run] = moved;
        }
    }
}

pub(crate) fn read_inputs(problem: &mut Problem, model: &Model) {
    for track in &mut problem.tracks {
        let theta = crate::simulate::values_in_run(model, track.run);
        track.read_inputs(&problem.dynamics, &theta);
    }
}

/// Factor of the information of all segments on the unknowns, with the initial states eliminated
/// and priors included. The last column holds the residual.
pub(crate) fn normal_factor(problem: &Problem, model: &Model, segments: &[Linearised]) -> Fold<1> {
    normal_factor_where(problem, model, segments, |_| true)
}

/// [`normal_factor`] of the segments that `keep` selects.
pub(crate) fn normal_factor_where(
    problem: &Problem,
    model: &Model,
    segments: &[Linearised],
    keep: impl Fn(usize) -> bool,
) -> Fold<1> {
    let (nx, p) = (problem.dynamics.states.len(), problem.unknowns.len());
    let mut global = Fold::<1>::new(p + 1);
    for (k, (segment, stretch)) in segments.iter().zip(&problem.segments).enumerate() {
        if !keep(k) {
            continue;
        }
        let columns = problem.columns_of(stretch.track);
        for i in nx..segment.n {
            let mut row = vec![[0.0]; p + 1];
            for (direction, column) in columns.iter().enumerate() {
                row[*column] = [segment.at(i, nx + direction)];
            }
            row[p] = [segment.at(i, segment.n - 1)];
            global.push(row.into_iter());
        }
    }
    fold_priors(&mut global, model, &problem.unknowns);
    global
}

/// Adds the rows of the priors, and folds all rows that wait.
pub(crate) fn fold_priors(global: &mut Fold<1>, model: &Model, unknowns: &[Unknown]) {
    let p = unknowns.len();
    for (k, unknown) in unknowns.iter().enumerate() {
        if let Some((mean, std)) = model.parameters[unknown.parameter].prior {
            let mut row = vec![[0.0]; p + 1];
            row[k] = [1.0 / std];
            row[p] = [(value(model, *unknown) - mean) / std];
            global.push(row.into_iter());
        }
    }
    global.fold();
}

/// The step of the unknowns with Marquardt's damping, and by how much the linearised cost falls. An
/// unknown that would leave its bounds is set to the bound, and the others are found with it there.
pub(crate) fn damped_step(global: &Fold<1>, model: &Model, unknowns: &[Unknown], damping: f64) -> (Vec<f64>, f64) {
    let p = unknowns.len();
    let mut bound: Vec<Option<f64>> = vec![None; p];
    loop {
        let mut damped = global.clone();
        for k in 0..p {
            let length: f64 = (0..=k).map(|i| global.at(i, k)[0].powi(2)).sum::<f64>().sqrt().max(1e-300);
            let weight = if bound[k].is_some() { 1e8 * length } else { damping.sqrt() * length };
            let aim = -weight * bound[k].unwrap_or(0.0);
            damped.push((0..=p).map(|j| {
                [if j == k {
                    weight
                } else if j == p {
                    aim
                } else {
                    0.0
                }]
            }));
        }
        damped.fold();
        let step: Vec<f64> = damped.solve().into_iter().map(|x| -x).collect();
        let mut new = false;
        for k in (0..p).filter(|k| bound[*k].is_none()).collect::<Vec<_>>() {
            let parameter = &model.parameters[unknowns[k].parameter];
            let (least, most) = (parameter.min, parameter.max);
            let now = value(model, unknowns[k]);
            if now + step[k] < least || now + step[k] > most {
                bound[k] = Some((now + step[k]).clamp(least, most) - now);
                new = true;
            }
        }
        if !new {
            let after: f64 = (0..p)
                .map(|i| {
                    let sum: f64 = (i..p).map(|j| global.at(i, j)[0] * step[j]).sum();
                    (global.at(i, p)[0] + sum).powi(2)
                })
                .sum();
            let before: f64 = (0..p).map(|i| global.at(i, p)[0].powi(2)).sum();
            return (step, (before - after).max(0.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::frame::Dof;

    /// min (x + y)² + (x − y)²/4 from (3, 3) with x at least 2: y = −6/5 is found with x at 2, not
    /// with x at 0.
    #[test]
    fn exact_step_to_a_bound() {
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        for parameter in &mut model.parameters {
            (parameter.value, parameter.min) = (3.0, -10.0);
        }
        model.parameters[0].min = 2.0;
        let unknowns = [0, 1].map(|parameter| Unknown { parameter, run: None });
        let mut global = Fold::<1>::new(3);
        global.push([1.0, 1.0, 6.0].into_iter().map(|x| [x]));
        global.push([0.5, -0.5, 0.0].into_iter().map(|x| [x]));
        global.fold();
        let (step, _) = damped_step(&global, &model, &unknowns, 0.0);
        // a weight of 1e8 holds the bound, and costs some digits
        assert!((step[0] + 1.0).abs() < 1e-9 && (step[1] + 4.2).abs() < 1e-6, "{step:?}");
    }
}
