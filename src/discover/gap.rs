//! The gap: free simulation against measurement on runs that took no part in the fit.
//!
//! ```text
//! gap_i = rms over all samples of (simulated yᵢ − measured yᵢ)         y: velocities, observed functions of the states
//! ```
//!
//! The initial state of each stretch is estimated on its first seconds with the model's parameters held. The noise
//! floor is what remains when the same model starts anew every two seconds: too short for a missing force to build up,
//! long enough to see all of the sensor's noise, coloured noise included.

use std::collections::BTreeMap;

use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions, Problem, fit_from};
use crate::frame::Measured;
use crate::model::Model;
use crate::run::Run;
use crate::simulate::{free_run, values_in_run};

/// Length of the segments from which the noise floor is read, s.
const FLOOR_SEGMENT: f64 = 2.0;

/// Disagreement of a model with runs, by what is measured.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gap {
    /// Root mean square over all runs, in the unit of the channel.
    pub rms: BTreeMap<Measured, f64>,
    /// The same for each run, with its name.
    pub runs: Vec<(String, BTreeMap<Measured, f64>)>,
}

/// Free simulation of `model` over `runs`.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what the model reads.
pub fn gap(model: &Model, runs: &[Run], options: &OutputErrorOptions) -> Result<Gap, OutputErrorError> {
    let mut result = Gap::default();
    let mut sums: BTreeMap<Measured, (f64, f64)> = BTreeMap::new();
    for run in runs {
        let held = held_for(model, run, options)?;
        let mut problem = Problem::new(&held, std::slice::from_ref(run), options)?;
        let track = problem.tracks[0].clone();
        problem.segments.retain(|s| track.starts.contains(&s.first));
        let x0 = problem.initial_states(&held);
        let settled = fit_from(&held, problem, x0, &OutputErrorOptions { iterations: 15, ..options.clone() })?;
        let dynamics = &settled.problem.dynamics;
        let theta = values_in_run(&held, 0);
        let mut own: BTreeMap<Measured, (f64, f64)> = BTreeMap::new();
        for (segment, start) in settled.problem.segments.iter().zip(&settled.initial_states) {
            let next = track.starts.iter().find(|s| **s > segment.first).copied().unwrap_or(track.time.len());
            let simulated = free_run(dynamics, &track, &theta, start, segment.first, next - 1);
            let width = dynamics.outputs.len();
            for compared in model.measured() {
                let Some(column) = dynamics.outputs.iter().position(|o| *o == compared.channel()) else { continue };
                let measured = track.observed[segment.first * width..].iter().skip(column).step_by(width);
                let predicted = simulated.outputs.iter().skip(column).step_by(width);
                let sum = own.entry(compared).or_default();
                for (y, x) in measured.zip(predicted).filter(|(y, _)| !y.is_nan()) {
                    // a simulation that runs away is as wrong as can be, not more
                    let error = if x.is_finite() { (x - y).clamp(-1e3, 1e3) } else { 1e3 };
                    sum.0 += error * error;
                    sum.1 += 1.0;
                }
            }
        }
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

fn rms(sums: &BTreeMap<Measured, (f64, f64)>) -> BTreeMap<Measured, f64> {
    sums.iter().map(|(dof, (squares, count))| (dof.clone(), (squares / count.max(1.0)).sqrt())).collect()
}

/// Disagreement with the simulation started anew every segment: root mean square by degree of freedom. Where motion is
/// unstable a whole run cannot be simulated however good the model; a segment can.
///
/// # Errors
/// As [`gap`].
pub fn segment_gap(
    model: &Model,
    runs: &[Run],
    options: &OutputErrorOptions,
) -> Result<BTreeMap<Measured, f64>, OutputErrorError> {
    let mut sums: BTreeMap<Measured, (f64, f64)> = BTreeMap::new();
    for run in runs {
        let held = held_for(model, run, options)?;
        let problem = Problem::new(&held, std::slice::from_ref(run), options)?;
        let x0 = problem.initial_states(&held);
        let fit = fit_from(&held, problem, x0, &OutputErrorOptions { iterations: 15, ..options.clone() })?;
        let freedom = spare(&fit);
        for compared in model.measured() {
            let outputs = &fit.problem.dynamics.outputs;
            let Some(column) = outputs.iter().position(|o| *o == compared.channel()) else { continue };
            let count = fit.problem.samples_of(column) as f64;
            let sum = sums.entry(compared).or_default();
            sum.0 += (fit.residual_rms[column] * freedom).powi(2) * count;
            sum.1 += count;
        }
    }
    Ok(rms(&sums))
}

/// √(samples over samples less initial states): what a residual has lost to the states that were fitted to it.
fn spare(fit: &crate::estimate::output_error::OutputErrorFit) -> f64 {
    let states = fit.problem.dynamics.states.len() - fit.problem.dynamics.memories();
    let used = (states * fit.problem.segments.len()) as f64;
    (fit.samples as f64 / (fit.samples as f64 - used).max(1.0)).sqrt()
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
    segment_gap(model, runs, &OutputErrorOptions { segment: FLOOR_SEGMENT, ..options.clone() })
}

/// The model with every parameter held for one run; those that each run has its own value of are estimated on it.
fn held_for(model: &Model, run: &Run, options: &OutputErrorOptions) -> Result<Model, OutputErrorError> {
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
