//! A model fitted on segments as long as its motion allows, with steps as short as its noise asks for.
//!
//! ```text
//! std of y(t) = |R⁻ᵀ (∂y/∂x₀)ᵀ|          R: factor of a short segment's information on x₀, in units of the noise
//! Σ (y_h − y_{h/2})² / σ² < 5             h: step of the integrator
//! ```
//!
//! The fit begins on short segments, from which no motion runs away before the log corrects it. Neighbours are then
//! joined as far as what is uncertain of the first one's initial state stays small: in a steady run to segments of the
//! wanted length, in one that is unstable to shorter ones. Where even short segments stay far from the data a long one
//! could lead into a wrong valley, and they stay short until the model is better. A step of the integrator is short
//! enough when what it errs by is less than what is asked of a name. Bock (1983).

use super::gap::{BOUND, variance};
use super::search::noise_level;
use crate::estimate::output_error::{
    LANES, OutputErrorError, OutputErrorFit, OutputErrorOptions, Problem, fit_from, step_error,
};
use crate::model::Model;
use crate::run::Run;
use crate::simulate::{Emission, Stretch, integrate_fast};

/// Parts of the wanted length on which the fit begins; the second where the first stay far from the data.
const PARTS: [usize; 2] = [3, 8];

/// Residual variance over that of the noise from which on segments stay short.
const ROUGH: f64 = 25.0;

/// Steps after which a fit that is still rough is given up.
const FIRST_STEPS: usize = 4;

/// Steps after which any fit is given up.
const PATIENCE: usize = 12;

/// A step that promises less is the last one of a fit that only starts another, in units of the noise variance.
const LOOSE: f64 = 1.0;

/// A step that promises less is the last one of any fit of the search, in units of the noise variance: what is asked of a
/// name is a hundred times more.
const CLOSE: f64 = 0.1;

/// Σ (error of the integrator / σ)² from which on its steps are too long: a third of the least that a name has to bring.
const ERRS: f64 = 5.0;

/// The shortest step that is tried, as a share of the usual one.
const SHORTEST: f64 = 0.1;

/// A fit with what it was made with.
pub(super) struct Settled {
    pub fit: OutputErrorFit,
    pub options: OutputErrorOptions,
    /// Whether segments are short because the model is far from the data.
    pub rough: bool,
}

/// Fits `model` on segments as long as its motion allows.
///
/// # Errors
/// [`OutputErrorError`] when no length of segments gives a fit.
pub(super) fn settle(model: &Model, runs: &[Run], fitting: &OutputErrorOptions) -> Result<Settled, OutputErrorError> {
    let mut options = OutputErrorOptions { tolerance: fitting.tolerance.max(CLOSE), ..fitting.clone() };
    let first = attempt(model, runs, &shortened(fitting, PARTS[0]));
    let mut parts = PARTS[0];
    let far = first.as_ref().map_or(true, |fit| !fit.converged || noise_level(fit) >= ROUGH);
    let mut short = match far.then(|| attempt(model, runs, &shortened(fitting, PARTS[1]))) {
        Some(Ok(shorter)) => {
            parts = PARTS[1];
            shorter
        }
        _ => first?,
    };
    let errs = step_error(&short.problem, &short.model, &short.initial_states);
    if errs > ERRS {
        // a scheme of the fourth order: the square of its error goes with the eighth power of the step
        let share = (ERRS / errs).powf(0.125).max(SHORTEST);
        options.longest_step = share * fitting.longest_step;
        let problem =
            Problem { segments: short.problem.segments.clone(), ..Problem::new(&short.model, runs, &options)? };
        short.problem = Problem { sigma: short.problem.sigma, ..problem };
    }
    let (segments, x0) = lengthened(&short, parts);
    let problem = Problem { segments, ..short.problem.clone() };
    if let Ok(fit) = in_patience(&short.model, problem, x0, &options)
        && fit.converged
        && noise_level(&fit) < ROUGH
    {
        return Ok(Settled { fit, options, rough: false });
    }
    let options = OutputErrorOptions { segment: fitting.segment / parts as f64, ..options };
    let fit = fit_from(&short.model, short.problem, short.initial_states, &options)?;
    Ok(Settled { fit, options, rough: true })
}

/// A fit that is given up where its first steps do not bring it near the data.
fn in_patience(
    model: &Model,
    problem: Problem,
    x0: Vec<Vec<f64>>,
    options: &OutputErrorOptions,
) -> Result<OutputErrorFit, OutputErrorError> {
    let steps = |iterations: usize| OutputErrorOptions { iterations, ..options.clone() };
    let first = fit_from(model, problem, x0, &steps(FIRST_STEPS))?;
    if first.converged || noise_level(&first) >= ROUGH {
        return Ok(first);
    }
    fit_from(&first.model, first.problem, first.initial_states, &steps(PATIENCE))
}

fn shortened(fitting: &OutputErrorOptions, parts: usize) -> OutputErrorOptions {
    let segment = fitting.segment / parts as f64;
    OutputErrorOptions { segment, tolerance: LOOSE, ..fitting.clone() }
}

/// A fit on segments of `options`, from the log.
fn attempt(model: &Model, runs: &[Run], options: &OutputErrorOptions) -> Result<OutputErrorFit, OutputErrorError> {
    let problem = Problem::new(model, runs, options)?;
    let x0 = problem.initial_states(model);
    in_patience(model, problem, x0, options)
}

/// Neighbours joined, `most` at a time where the motion allows it, with the initial states of the first of each.
fn lengthened(fit: &OutputErrorFit, most: usize) -> (Vec<Stretch>, Vec<Vec<f64>>) {
    let all = &fit.problem.segments;
    let mut groups: Vec<(usize, usize)> = Vec::new();
    for (k, segment) in all.iter().enumerate() {
        let follows = |last: &Stretch| {
            last.track == segment.track
                && last.last + 1 == segment.first
                && !fit.problem.tracks[segment.track].starts.contains(&segment.first)
        };
        match groups.last_mut() {
            Some((head, count)) if *count < most && follows(&all[*head + *count - 1]) => *count += 1,
            _ => groups.push((k, 1)),
        }
    }
    let reach = steady_until(fit, &groups);
    let (mut segments, mut states) = (Vec::new(), Vec::new());
    for ((head, count), until) in groups.into_iter().zip(reach) {
        let steady = (head..head + count).take_while(|k| *k == head || all[*k].last <= until).count();
        // what holds from the first on is taken to hold from the others of its group
        for first in (head..head + count).step_by(steady) {
            let last = (first + steady).min(head + count) - 1;
            segments.push(Stretch { last: all[last].last, ..all[first] });
            states.push(fit.initial_states[first].clone());
        }
    }
    (segments, states)
}

/// For each group (its first segment, how many) the grid point up to which its uncertain initial state stays small.
fn steady_until(fit: &OutputErrorFit, groups: &[(usize, usize)]) -> Vec<usize> {
    let problem = &fit.problem;
    let (nx, outputs) = (problem.dynamics.states.len(), problem.dynamics.outputs.len());
    let width = nx + problem.dynamics.directions.len();
    let mut until: Vec<usize> = groups.iter().map(|(head, count)| problem.segments[head + count - 1].last).collect();
    for (part, batch) in groups.chunks(LANES).enumerate() {
        let heads: Vec<usize> = batch.iter().map(|(head, _)| *head).collect();
        let (mut stretches, theta, start) = problem.lanes::<LANES>(&fit.model, &fit.initial_states, &heads);
        for (stretch, (head, count)) in stretches.iter_mut().flatten().zip(batch) {
            stretch.last = problem.segments[head + count - 1].last;
        }
        let mut take = |at: &Emission<'_, LANES>| {
            for (lane, head) in heads.iter().enumerate() {
                let Some(k) = at.grid[lane] else { continue };
                let row = |output: usize, i: usize| at.jacobian[output * width + i][lane] / problem.sigma[output];
                let grown = |output: usize| {
                    let variance = variance(&fit.linearised[*head], nx, |i| row(output, i));
                    variance.is_nan() || variance > BOUND * BOUND
                };
                let until = &mut until[part * LANES + lane];
                if k < *until && k > problem.segments[*head].last && (0..outputs).any(grown) {
                    *until = k;
                }
            }
        };
        integrate_fast(&problem.dynamics, &problem.tracks, &stretches, &theta, &start, true, &mut take);
    }
    until
}
