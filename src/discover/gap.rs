//! The gap: free simulation against measurement on runs that took no part in the fit.
//!
//! ```text
//! gap_i = rms over all samples of (simulated yᵢ − measured yᵢ)         y: velocities, observed functions of the states
//! ```
//!
//! The initial state of each stretch is estimated on its first seconds with the model's parameters held. The noise
//! floor is what remains when the same model starts anew every two seconds: too short for a missing force to build up,
//! and what initial states take up of the sensor's noise, the more the more coloured it is ([`super::colour`]), is
//! allowed for. What the data leave open grows along a run ([`super::left_open`]) and is no disagreement; where it
//! outgrows the noise, the run is unstable under its commands and compared in segments, each from an initial state of its
//! own.

use std::collections::BTreeMap;

use super::colour::{colours, taken_up};
use crate::estimate::output_error::{
    Linearised, OutputErrorError, OutputErrorFit, OutputErrorOptions, Problem, fit_from,
};
use crate::estimate::samples_in;
use crate::frame::Measured;
use crate::model::Model;
use crate::run::Run;
use crate::simulate::{Stretch, free_run, in_reach, values_in_run};

/// Length of the segments from which the noise floor is read, s.
pub(super) const FLOOR_SEGMENT: f64 = 2.0;

/// Length of the beginning of a run on which its initial state is estimated, s: short enough that an unstable motion has
/// not yet left the data.
const FIRST_SECONDS: f64 = 3.0;

/// Samples of the slowest velocity sensor that both hold at least: of fewer, a fitted state takes up most of the noise.
const FEWEST: f64 = 6.0;

/// `seconds`, or what holds [`FEWEST`] samples of a slower log.
pub(super) fn lasting(seconds: f64, model: &Model, runs: &[Run]) -> f64 {
    let long = 1e3;
    seconds.max(FEWEST * long / samples_in(long, model, runs) as f64)
}

/// Steps in which an initial state is found.
const SETTLING: usize = 15;

/// Disagreement of a model with runs, by what is measured.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gap {
    /// Root mean square over all runs, in the unit of the channel.
    pub rms: BTreeMap<Measured, f64>,
    /// The same for each run, with its name.
    pub runs: Vec<(String, BTreeMap<Measured, f64>)>,
}

/// Squares and their number, by what is measured.
pub(super) type Sums = BTreeMap<Measured, (f64, f64)>;

/// Free simulation of `model` over `runs`; over those marked in `cut` in segments.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what the model reads.
pub fn gap(model: &Model, runs: &[Run], options: &OutputErrorOptions, cut: &[bool]) -> Result<Gap, OutputErrorError> {
    let mut result = Gap::default();
    let mut sums = Sums::new();
    for (k, run) in runs.iter().enumerate() {
        let own = match cut.get(k) {
            Some(true) => in_segments(model, run, options)?,
            _ => whole(model, run, options)?,
        };
        for (dof, (squares, count)) in &own {
            let sum = sums.entry(dof.clone()).or_default();
            sum.0 += squares;
            sum.1 += count;
        }
        result.runs.push((run.name.clone(), rms(&own)));
    }
    result.rms = rms(&sums);
    Ok(result)
}

/// The gap of a model that cannot be simulated on `runs`, because it runs away from every start: it predicts nothing, and
/// the motion itself is the gap.
pub(super) fn motion(model: &Model, runs: &[Run]) -> Gap {
    let squares = |run: &Run, measured: &Measured| {
        let values = run.signal(measured.channel()).map_or(&[][..], |signal| signal.values());
        let known = values.iter().filter(|x| !x.is_nan());
        known.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0))
    };
    let of = |runs: &[Run]| -> Sums {
        let all = |m: &Measured| runs.iter().map(|run| squares(run, m)).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        model.measured().into_iter().map(|m| (m.clone(), all(&m))).collect()
    };
    let each = |run: &Run| (run.name.clone(), rms(&of(std::slice::from_ref(run))));
    Gap { rms: rms(&of(runs)), runs: runs.iter().map(each).collect() }
}

/// The initial state of each stretch of a run, fitted on its first segment with the parameters held.
pub(super) fn beginning(
    model: &Model,
    run: &Run,
    options: &OutputErrorOptions,
) -> Result<OutputErrorFit, OutputErrorError> {
    let held = held_for(model, run, options)?;
    let segment = lasting(FIRST_SECONDS, model, std::slice::from_ref(run));
    let short = OutputErrorOptions { segment, iterations: SETTLING, ..options.clone() };
    let mut problem = Problem::new(&held, std::slice::from_ref(run), &short)?;
    let starts = problem.tracks[0].starts.clone();
    problem.segments.retain(|s| starts.contains(&s.first));
    let x0 = problem.initial_states(&held);
    fit_from(&held, problem, x0, &short)
}

/// Grid points of the stretch that a segment begins.
pub(super) fn stretch_of(fit: &OutputErrorFit, segment: &Stretch) -> Stretch {
    let track = &fit.problem.tracks[0];
    let next = track.starts.iter().find(|s| **s > segment.first).copied().unwrap_or(track.time.len());
    Stretch { track: 0, first: segment.first, last: next - 1 }
}

/// One simulation of each stretch of a run from beginning to end.
fn whole(model: &Model, run: &Run, options: &OutputErrorOptions) -> Result<Sums, OutputErrorError> {
    let settled = beginning(model, run, options)?;
    let (dynamics, track) = (&settled.problem.dynamics, &settled.problem.tracks[0]);
    let theta = values_in_run(&settled.model, 0);
    let width = dynamics.outputs.len();
    let mut own = Sums::new();
    for (segment, start) in settled.problem.segments.iter().zip(&settled.initial_states) {
        let stretch = stretch_of(&settled, segment);
        let simulated = free_run(dynamics, track, &theta, start, stretch.first, stretch.last);
        for compared in model.measured() {
            let Some(column) = dynamics.outputs.iter().position(|o| *o == compared.channel()) else { continue };
            let measured = track.observed[segment.first * width..].iter().skip(column).step_by(width);
            let predicted = simulated.outputs.iter().skip(column).step_by(width);
            let sum = own.entry(compared).or_default();
            for (y, x) in measured.zip(predicted).filter(|(y, _)| !y.is_nan()) {
                let error = in_reach(*x, *y) - y;
                sum.0 += error * error;
                sum.1 += 1.0;
            }
        }
    }
    Ok(own)
}

/// What an uncertain initial state may grow to, in units of the noise, on a segment that is to be fitted.
pub(super) const BOUND: f64 = 10.0;

/// |R⁻ᵀ rowᵀ|²: variance of what the `row` makes of the initial states that a segment leaves uncertain; infinite where it
/// reads a state of which nothing is known.
pub(super) fn variance(segment: &Linearised, nx: usize, row: impl Fn(usize) -> f64) -> f64 {
    let mut solved = vec![0.0; nx];
    for i in 0..nx {
        let known: f64 = (0..i).map(|j| segment.at(j, i) * solved[j]).sum();
        let (pivot, rest) = (segment.at(i, i), row(i) - known);
        // a state of which nothing is known and that nothing reads spreads nothing
        solved[i] = if pivot == 0.0 { if rest == 0.0 { 0.0 } else { f64::INFINITY } } else { rest / pivot };
    }
    solved.iter().map(|x| x * x).sum()
}

pub(super) fn rms(sums: &BTreeMap<Measured, (f64, f64)>) -> BTreeMap<Measured, f64> {
    sums.iter().map(|(dof, (squares, count))| (dof.clone(), (squares / count.max(1.0)).sqrt())).collect()
}

/// The simulation of a run started anew every segment. Where motion is unstable a whole run cannot be simulated however
/// good the model; a segment can.
fn in_segments(model: &Model, run: &Run, options: &OutputErrorOptions) -> Result<Sums, OutputErrorError> {
    let fit = started_anew(model, run, options)?;
    let colours = colours(&fit);
    let mut own = Sums::new();
    for compared in model.measured() {
        let outputs = &fit.problem.dynamics.outputs;
        let Some(column) = outputs.iter().position(|o| *o == compared.channel()) else { continue };
        let count = fit.problem.samples_of(column) as f64;
        let freedom = spare(&fit, column, colours[column]);
        own.insert(compared, (fit.residual_rms[column].powi(2) * freedom * count, count));
    }
    Ok(own)
}

/// The initial states of a run's segments, fitted with the parameters held.
pub(super) fn started_anew(
    model: &Model,
    run: &Run,
    options: &OutputErrorOptions,
) -> Result<OutputErrorFit, OutputErrorError> {
    let held = held_for(model, run, options)?;
    let segment = options.segment.min(lasting(FIRST_SECONDS, model, std::slice::from_ref(run)));
    let short = OutputErrorOptions { segment, iterations: SETTLING, ..options.clone() };
    let problem = Problem::new(&held, std::slice::from_ref(run), &short)?;
    let x0 = problem.initial_states(&held);
    fit_from(&held, problem, x0, &short)
}

/// 1 over the share of a residual's variance that is left by the states that were fitted to it, at most 10.
///
/// ```text
/// 1/(1 − τ(n) states/samples)        n: samples of the output in a segment
/// ```
pub(super) fn spare(fit: &OutputErrorFit, column: usize, colour: f64) -> f64 {
    let segments = fit.problem.segments.len() as f64;
    let states = fit.problem.free_states();
    let taken = taken_up(colour, (fit.problem.samples_of(column) as f64 / segments).max(1.0));
    1.0 / (1.0 - states as f64 * segments / fit.samples as f64 * taken).max(0.1)
}

/// Noise floor of each modelled velocity and observed function, in its unit.
///
/// # Errors
/// As [`gap`].
pub fn floor(
    model: &Model,
    runs: &[Run],
    options: &OutputErrorOptions,
) -> Result<BTreeMap<Measured, f64>, OutputErrorError> {
    let short = OutputErrorOptions { segment: lasting(FLOOR_SEGMENT, model, runs), ..options.clone() };
    Ok(gap(model, runs, &short, &vec![true; runs.len()])?.rms)
}

/// The model with every parameter held for one run; those that each run has its own value of are estimated on it.
pub(super) fn held_for(model: &Model, run: &Run, options: &OutputErrorOptions) -> Result<Model, OutputErrorError> {
    let mut held = model.clone();
    let mut own = false;
    for parameter in &mut held.parameters {
        parameter.fixed = !parameter.spec.per_run;
        parameter.per_run.clear();
        own |= parameter.spec.per_run;
    }
    if own {
        let problem = Problem::new(&held, std::slice::from_ref(run), options)?;
        let x0 = problem.initial_states(&held);
        held = fit_from(&held, problem, x0, options)?.model;
        for parameter in &mut held.parameters {
            parameter.fixed = true;
        }
    }
    Ok(held)
}
