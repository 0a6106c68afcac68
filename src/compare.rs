//! Comparison of a model with runs: simulation against measurement.
//!
//! ```text
//! E = mean |y − ŷ|,   σ = std |y − ŷ|                       Avila et al. (2013), eq. 25
//! fit = 100 (1 − ‖y − ŷ‖ / ‖y − ȳ‖) %                       Ljung (1999), ch. 16
//! ```
//!
//! y: measured velocity (m/s) or rate (rad/s), or, if a run logs none, the corresponding position (m) or angle (rad);
//! ŷ: simulated with held parameters, from a state that is estimated on the first seconds of the run. If the motion
//! is unstable, even a good model cannot simulate a whole run: the simulation then restarts every few seconds, and a
//! finding says so.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

use crate::check::samples::within_half_turn;
use crate::estimate::output_error::{LONGEST_STEP, OutputErrorError, OutputErrorOptions, Problem, fit_from};
use crate::finding::{Code, Finding, Severity};
use crate::frame::{Dof, Measured};
use crate::model::Model;
use crate::progress::Count;
use crate::run::{Role, Run};
use crate::simulate::{Track, Trajectory, free_run, in_reach};

/// Codes of the findings of a comparison.
pub const CODES: [Code; 1] = [UNSTABLE];

const UNSTABLE: Code = Code {
    code: "C001",
    kind: "unstable-simulation",
    severity: Severity::Warning,
    meaning: "the simulated motion is unstable: it is compared on segments, since small errors grow without bound",
};

/// Growth of the difference between two starts beyond which a simulation of the whole run is meaningless.
const GROWTH: f64 = 100.0;

/// Options of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareOptions {
    /// First seconds of a run on which the initial state is estimated, s.
    pub settle: f64,
    /// Length of the segments where motion is unstable, s.
    pub segment: f64,
    /// Longest step of the integrator, s, as in a fit.
    pub longest_step: Option<f64>,
    /// Whether the logged position is a measurement of its own.
    pub position: bool,
    /// Standard deviation of the noise by channel, SI; estimated from the data where absent.
    pub noise: BTreeMap<String, f64>,
}

impl Default for CompareOptions {
    fn default() -> CompareOptions {
        CompareOptions { settle: 5.0, segment: 8.0, longest_step: None, position: false, noise: BTreeMap::new() }
    }
}

/// Error of a comparison.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CompareError {
    /// The model cannot be simulated on a run.
    #[error("run `{run}`: {source}")]
    Simulation {
        /// Name of the run.
        run: String,
        /// Cause.
        source: OutputErrorError,
    },
}

/// Disagreement of a model with one run in one degree of freedom.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Disagreement {
    /// Name of the run.
    pub run: String,
    /// Whether the run took part in the fit.
    pub role: Role,
    /// Degree of freedom, or the channel of an observed function of the states; the channel of the position or angle
    /// if the run logs no velocity.
    pub dof: Measured,
    /// Mean of |measured − simulated|, in `unit`.
    pub mean_abs: f64,
    /// Standard deviation of |measured − simulated|, in `unit`.
    pub std_abs: f64,
    /// Root mean square of measured − simulated, in `unit`.
    pub rms: f64,
    /// Standard deviation of the sensor's noise, in `unit`.
    pub noise_floor: f64,
    /// 100 if the simulation equals the measurement, 0 if it is no better than the measurement's mean.
    pub fit_percent: f64,
    /// `m/s` or `rad/s`; `m` or `rad` for a position or angle; for an observed function the unit of its formula.
    pub unit: String,
    /// Number of stretches that were simulated, each from an initial state of its own: 1 for a run in one piece, more
    /// if it has gaps or its motion is unstable.
    pub pieces: usize,
    /// Length of the stretches into which unstable motion was cut (C001), s; `null` if it was not cut.
    pub piece_length: Option<f64>,
}

/// A model compared with runs.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Comparison {
    /// One entry per run and degree of freedom that is measured there.
    pub runs: Vec<Disagreement>,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
}

/// Compares a model with runs. A parameter with per-run values takes the value of each run if there are as many
/// values as runs, otherwise its common value.
///
/// # Errors
/// [`CompareError`] when a run lacks what the model reads.
pub fn compare(model: &Model, runs: &[Run], options: &CompareOptions) -> Result<Comparison, CompareError> {
    // a single run is part of other work and shows no progress
    let count = (runs.len() > 1).then(|| Count::begun("simulating runs", runs.len()));
    let each: Result<Vec<Comparison>, CompareError> = runs
        .par_iter()
        .enumerate()
        .map(|(k, run)| one(&fixed_at_run(model, k, runs.len()), run, options))
        .inspect(|_| count.iter().for_each(Count::one_done))
        .collect();
    let mut all = Comparison::default();
    for one in each? {
        all.runs.extend(one.runs);
        all.warnings.extend(one.warnings);
    }
    Ok(all)
}

/// A model that was identified from one run, compared with all runs: a row of Table 6 of the paper.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CrossRow {
    /// Name of the model: the run from which it was identified.
    pub model: String,
    /// Its comparison with every run, its own included.
    #[serde(flatten)]
    pub comparison: Comparison,
}

/// Compares every model with every run: the cross-validation matrix, one row per model.
///
/// # Errors
/// As [`compare`].
pub fn cross_validate(
    models: &[(String, Model)],
    runs: &[Run],
    options: &CompareOptions,
) -> Result<Vec<CrossRow>, CompareError> {
    let row = |(name, model): &(String, Model)| {
        compare(model, runs, options).map(|comparison| CrossRow { model: name.clone(), comparison })
    };
    models.par_iter().map(row).collect()
}

/// The model with every parameter fixed at its value in run `k` of `count`.
fn fixed_at_run(model: &Model, k: usize, count: usize) -> Model {
    let mut fixed = model.clone();
    for parameter in &mut fixed.parameters {
        parameter.fixed = true;
        if parameter.per_run.len() == count {
            parameter.value = parameter.per_run[k];
        }
        parameter.per_run.clear();
    }
    fixed
}

fn one(model: &Model, run: &Run, options: &CompareOptions) -> Result<Comparison, CompareError> {
    let failed = |source| CompareError::Simulation { run: run.name.clone(), source };
    let mut comparison = Comparison::default();
    let whole = match Simulated::of(model, run, options.settle, false, options) {
        Err(OutputErrorError::Diverges { .. }) => None,
        other => Some(other.map_err(failed)?).filter(|simulated| simulated.stable),
    };
    let (simulated, piece_length) = match whole {
        Some(simulated) => (simulated, None),
        None => {
            let (simulated, seconds) = in_segments(model, run, options).map_err(failed)?;
            let text = format!(
                "run `{}`: the simulated motion is unstable; it is compared on segments of {seconds} s, not over the whole run",
                run.name
            );
            comparison.warnings.push(Finding::new(&UNSTABLE, text).of_run(&run.name));
            (simulated, Some(seconds))
        }
    };
    for measured in model.measured() {
        let Some((measured, column, pairs)) = simulated.told(measured) else { continue };
        let count = pairs.len() as f64;
        let mean = |f: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|(y, x)| f(*y, *x)).sum::<f64>() / count;
        let level = mean(&|y, _| y);
        let mean_abs = mean(&|y, x| (y - x).abs());
        let squares = mean(&|y, x| (y - x).powi(2));
        let spread = mean(&|y, _| (y - level).powi(2));
        comparison.runs.push(Disagreement {
            run: run.name.clone(),
            role: run.role,
            mean_abs,
            std_abs: (squares - mean_abs * mean_abs).max(0.0).sqrt(),
            rms: squares.sqrt(),
            noise_floor: simulated.sigma[column],
            fit_percent: if spread > 0.0 { 100.0 * (1.0 - (squares / spread).sqrt()) } else { 0.0 },
            unit: unit(&measured, &simulated.units[column]),
            pieces: simulated.pieces.len(),
            piece_length,
            dof: measured,
        });
    }
    Ok(comparison)
}

/// Unit of the compared quantity; `known` is that of an observed function.
fn unit(measured: &Measured, known: &str) -> String {
    let is_pose = |dof: &Dof| dof.position() == measured.channel();
    match (measured.dof(), Dof::ALL.iter().find(|dof| is_pose(dof))) {
        (Some(dof), _) => if dof.is_rotation() { "rad/s" } else { "m/s" }.into(),
        (None, Some(dof)) => if dof.is_rotation() { "rad" } else { "m" }.into(),
        (None, None) => known.to_string(),
    }
}

/// Simulates the run in segments. If a model is so wrong that the motion leaves the range of a double within one, the
/// length is halved, down to two steps of the integrator.
fn in_segments(model: &Model, run: &Run, options: &CompareOptions) -> Result<(Simulated, f64), OutputErrorError> {
    let mut seconds = options.segment;
    loop {
        let simulated = Simulated::of(model, run, seconds, true, options)?;
        if simulated.stable || seconds < 4.0 * options.longest_step.unwrap_or(LONGEST_STEP) {
            return Ok((simulated, seconds));
        }
        seconds /= 2.0;
    }
}

/// Pairs (measured, simulated) at the samples of one channel.
type Pairs = Vec<(f64, f64)>;

/// A run simulated in one piece per stretch without a gap, or in segments.
struct Simulated {
    track: Track,
    outputs: Vec<String>,
    units: Vec<String>,
    sigma: Vec<f64>,
    pieces: Vec<(usize, Trajectory)>,
    stable: bool,
}

impl Simulated {
    /// Simulates the run, with initial states estimated on the first `seconds` of each piece. With `segments` every
    /// piece is that long, and starts from the measured state if the estimate diverges or has too few samples.
    fn of(
        model: &Model,
        run: &Run,
        seconds: f64,
        segments: bool,
        options: &CompareOptions,
    ) -> Result<Simulated, OutputErrorError> {
        let fit_options = OutputErrorOptions {
            segment: seconds,
            longest_step: options.longest_step,
            position: options.position,
            sigma: Some(options.noise.clone()),
            iterations: 6,
            ..OutputErrorOptions::default()
        };
        let mut problem = Problem::new(model, std::slice::from_ref(run), &fit_options)?;
        let track = problem.tracks[0].clone();
        if !segments {
            problem.segments.retain(|s| track.starts.contains(&s.first));
        }
        let x0 = problem.initial_states(model);
        let (problem, starts) = match fit_from(model, problem, x0, &fit_options) {
            Ok(settled) => (settled.problem, settled.initial_states),
            Err(OutputErrorError::Diverges { .. } | OutputErrorError::TooFewSamples { .. }) if segments => {
                let problem = Problem::new(model, std::slice::from_ref(run), &fit_options)?;
                let measured = problem.initial_states(model);
                (problem, measured)
            }
            Err(other) => return Err(other),
        };
        let Problem { dynamics, segments: pieces, sigma, .. } = &problem;
        let theta = model.values();
        let last = |first: usize, end: usize| {
            let next = track.starts.iter().find(|s| **s > first).copied().unwrap_or(track.time.len());
            if segments { end } else { next - 1 }
        };
        let mut simulated = Simulated {
            outputs: dynamics.outputs.clone(),
            units: dynamics.units.clone(),
            sigma: sigma.clone(),
            pieces: Vec::new(),
            stable: true,
            track: track.clone(),
        };
        let measured = model.measured();
        let moves: Vec<usize> = (0..dynamics.outputs.len())
            .filter(|k| measured.iter().any(|m| m.channel() == dynamics.outputs[*k]))
            .collect();
        for (piece, start) in pieces.iter().zip(&starts) {
            let last = last(piece.first, piece.last);
            let trajectory = free_run(dynamics, &track, &theta, start, piece.first, last);
            if segments {
                simulated.stable &= trajectory.outputs.iter().all(|x| x.is_finite());
            } else {
                // a start that differs by a millionth of the noise, in all states at once
                let off: Vec<f64> = start.iter().map(|x| x + 1e-6 * small(sigma)).collect();
                let other = free_run(dynamics, &track, &theta, &off, piece.first, last);
                simulated.stable &= moves.iter().all(|k| {
                    let of = |t: &Trajectory| -> Vec<f64> {
                        t.outputs.iter().skip(*k).step_by(dynamics.outputs.len()).copied().collect()
                    };
                    let mut apart = of(&trajectory).into_iter().zip(of(&other)).map(|(a, b)| (a - b).abs());
                    // NaN is not below the bound
                    apart.all(|d| d < GROWTH * 1e-6 * small(sigma))
                });
            }
            simulated.pieces.push((piece.first, trajectory));
        }
        Ok(simulated)
    }

    /// The quantity that shows `measured` in this run, its output and its pairs: itself, or, for a velocity that is
    /// not logged, the position or angle. `None` if neither is logged.
    fn told(&self, measured: Measured) -> Option<(Measured, usize, Pairs)> {
        let pose = measured.dof().map(|dof| Measured::Function(dof.position().into()));
        let rotation = measured.dof().is_some_and(Dof::is_rotation);
        let found = |measured: Measured| {
            let column = self.outputs.iter().position(|name| *name == measured.channel())?;
            let pairs = self.pairs(column);
            (!pairs.is_empty()).then_some((measured, column, pairs))
        };
        found(measured).or_else(|| {
            let (pose, column, mut pairs) = found(pose?)?;
            if rotation {
                // a logged angle may be wrapped, the simulated one is not
                pairs.iter_mut().for_each(|(y, x)| *y = *x + within_half_turn(*y - *x));
            }
            Some((pose, column, pairs))
        })
    }

    /// Pairs (measured, simulated) of one output, at its samples. No instant counts twice; a value that runs away
    /// counts as [`in_reach`] says.
    fn pairs(&self, column: usize) -> Vec<(f64, f64)> {
        let width = self.outputs.len();
        let mut pairs = Vec::new();
        let mut done = 0;
        for (first, trajectory) in &self.pieces {
            for (row, outputs) in trajectory.outputs.chunks(width).enumerate() {
                let k = first + row;
                let measured = self.track.observed[k * width + column];
                if k >= done && !measured.is_nan() {
                    pairs.push((measured, in_reach(outputs[column], measured)));
                }
                done = done.max(k + 1);
            }
        }
        pairs
    }
}

/// Scale of a small change of the state: the least noise, or 1 mm/s if there is none.
fn small(sigma: &[f64]) -> f64 {
    let least = sigma.iter().copied().filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 1e-3 }
}

#[cfg(test)]
mod tests;
