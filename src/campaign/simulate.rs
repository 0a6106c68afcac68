//! The verb `simulate`: simulation of the model with the inputs of the runs.
//!
//! The initial state of each stretch without a gap is estimated from its first seconds with the
//! parameters held. After that the measurement has no influence.

use std::collections::BTreeMap;

use nalgebra::{Quaternion, UnitQuaternion};
use rayon::prelude::*;
use serde::Serialize;

use super::error::Error;
use super::load::{Campaign, moves};
use super::prediction::foretold;
use crate::envelope::{self, Envelope};
use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions, Problem, fit_from};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::navigation::{euler_angles, unwrap, upright};
use crate::progress::Count;
use crate::run::{Role, Run, Signal};
use crate::simulate::{free_run, values_in_run};

/// Length of the beginning of a stretch from which its initial state is estimated, s.
const SETTLE: f64 = 5.0;

/// Simulated runs. Serialises as `hydrosysid simulate --json`.
#[derive(Debug, Clone, Serialize)]
pub struct Simulation {
    /// Format of the result: 1.
    pub format: u32,
    /// The runs.
    pub runs: Vec<Simulated>,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
}

impl Simulation {
    /// Returns all runs side by side for a plotting tool: channels `RUN/u/measured`,
    /// `RUN/u/simulated` and `RUN/u/residual` (measured − simulated), SI, each at the time stamps
    /// at which it is known; `RUN/u/std` if the model has noise.
    pub fn series(&self) -> Run {
        let mut side_by_side = Run { name: "series".into(), ..Run::default() };
        for run in &self.runs {
            for (channel, simulated) in &run.simulated {
                let measured: Vec<f64> = run
                    .measured
                    .get(channel)
                    .map_or_else(Vec::new, |column| column.iter().map(|x| x.unwrap_or(f64::NAN)).collect());
                let residual = measured.iter().zip(simulated).map(|(y, x)| y - x).collect();
                let std = run
                    .std
                    .get(channel)
                    .map_or_else(Vec::new, |column| column.iter().map(|x| x.unwrap_or(f64::NAN)).collect());
                let of = |kind| format!("{}/{channel}/{kind}", run.run);
                let simulated = simulated.clone();
                let kinds = [("measured", measured), ("simulated", simulated), ("residual", residual), ("std", std)];
                for (kind, values) in kinds {
                    let known: Vec<(f64, f64)> =
                        run.time.iter().copied().zip(values).filter(|(_, x)| x.is_finite()).collect();
                    if !known.is_empty() {
                        let (time, values): (Vec<f64>, Vec<f64>) = known.into_iter().unzip();
                        side_by_side.signals.insert(of(kind), Signal::new(time.into(), values));
                    }
                }
            }
        }
        side_by_side
    }
}

/// One simulated run.
#[derive(Debug, Clone, Serialize)]
pub struct Simulated {
    /// Name of the run.
    pub run: String,
    /// Whether the run took part in the fit.
    pub role: Role,
    /// Time stamps, s.
    pub time: Vec<f64>,
    /// Simulated channels by name, SI, one value per time stamp.
    pub simulated: BTreeMap<String, Vec<f64>>,
    /// Measured channels by name, SI; `null` if a sensor has no sample.
    pub measured: BTreeMap<String, Vec<Option<f64>>>,
    /// Standard deviation of a sample about the simulation, by channel, SI, from the random force
    /// and the sensor noise. `null` in the first two seconds of a stretch; no channel if the model
    /// has no noise.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub std: BTreeMap<String, Vec<Option<f64>>>,
}

impl Simulated {
    /// Returns the simulated channels as signals, each with its standard deviation as `u_std` if
    /// the model has noise.
    pub fn signals(&self) -> BTreeMap<String, Signal> {
        let time: std::sync::Arc<[f64]> = self.time.clone().into();
        let simulated = self.simulated.iter().map(|(name, x)| (name.clone(), Signal::new(time.clone(), x.clone())));
        let bands = self.std.iter().map(|(name, std)| {
            let known = self.time.iter().zip(std).filter_map(|(t, s)| Some((*t, (*s)?)));
            let (time, values): (Vec<f64>, Vec<f64>) = known.unzip();
            (format!("{name}_std"), Signal::new(time.into(), values))
        });
        simulated.chain(bands.filter(|(_, band)| !band.is_empty())).collect()
    }
}

/// Simulates `model` over the runs of free motion of a campaign; `envelope` is that of its fit.
///
/// # Errors
/// [`Error`] if a run lacks what the model reads.
pub fn simulate(campaign: &Campaign, model: &Model, envelope: &Envelope) -> Result<Simulation, Error> {
    let runs: Vec<(usize, &Run)> = campaign.runs.iter().enumerate().filter(|(_, run)| moves(run.kind)).collect();
    let mut warnings = campaign.findings.clone();
    warnings.extend(runs.iter().flat_map(|(_, run)| envelope::beyond(run, envelope)));
    let count = Count::begun("simulating runs", runs.len());
    let simulated: Result<Vec<Simulated>, Error> =
        runs.par_iter().copied().map(|(k, run)| one(campaign, model, run, k)).inspect(|_| count.one_done()).collect();
    let mut simulated = simulated?;
    for (one, (k, run)) in simulated.iter_mut().zip(&runs) {
        one.std = band(campaign, model, run, *k, &one.time)?;
    }
    Ok(Simulation { format: 1, runs: simulated, warnings })
}

/// Returns the model with the values of its parameters in run `index`, all held.
fn in_run(model: &Model, index: usize) -> Model {
    let mut held = model.clone();
    for (p, value) in held.parameters.iter_mut().zip(values_in_run(model, index)) {
        p.value = value;
        p.fixed = true;
        p.per_run.clear();
    }
    held
}

/// Returns the standard deviation of a sample about the free run at each of these time stamps, by
/// channel.
fn band(
    campaign: &Campaign,
    model: &Model,
    run: &Run,
    index: usize,
    time: &[f64],
) -> Result<BTreeMap<String, Vec<Option<f64>>>, Error> {
    if campaign.noise.is_none() {
        return Ok(BTreeMap::new());
    }
    let Some(found) = foretold(campaign, &in_run(model, index), std::slice::from_ref(run))? else {
        return Ok(BTreeMap::new());
    };
    let mut all = BTreeMap::new();
    for (output, name) in found.filtered.problem.dynamics.outputs.iter().enumerate() {
        let free = || found.forecasts.iter().filter_map(|f| f.channels.get(output)).flat_map(|c| &c.free);
        let known: BTreeMap<u64, f64> = free().map(|p| (p.time.to_bits(), p.std)).collect();
        let std = time.iter().map(|t| known.get(&t.to_bits()).copied()).collect();
        all.insert(upright::instrument_of(name).unwrap_or(name).to_string(), std);
    }
    Ok(all)
}

/// Simulates one run from a state estimated on its first seconds.
pub(super) fn one(campaign: &Campaign, model: &Model, run: &Run, index: usize) -> Result<Simulated, Error> {
    let held = in_run(model, index);
    let options = OutputErrorOptions { segment: SETTLE, iterations: 6, ..campaign.options.output_error.clone() };
    // only the first seconds of each stretch: later a wrong model may diverge, and that must be
    // visible
    let mut problem = Problem::new(&held, std::slice::from_ref(run), &options)?;
    let starts = problem.tracks[0].starts.clone();
    problem.segments.retain(|s| starts.contains(&s.first));
    let x0 = problem.initial_states(&held);
    let (problem, begun) = match fit_from(&held, problem.clone(), x0.clone(), &options) {
        Ok(settled) => (settled.problem, settled.initial_states),
        // the model diverges within those seconds: it starts from the measured state
        Err(OutputErrorError::Diverges { .. }) => (problem, x0),
        Err(other) => return Err(other.into()),
    };
    let Problem { dynamics, segments, tracks, .. } = &problem;
    let track = &tracks[0];
    let width = dynamics.outputs.len();
    let mut result = Simulated {
        run: run.name.clone(),
        role: run.role,
        time: Vec::new(),
        simulated: dynamics.outputs.iter().map(|o| (o.clone(), Vec::new())).collect(),
        measured: dynamics.outputs.iter().map(|o| (o.clone(), Vec::new())).collect(),
        std: BTreeMap::new(),
    };
    let mut states = Vec::new();
    let begins = segments.iter().zip(&begun).filter(|(s, _)| track.starts.contains(&s.first));
    for (segment, start) in begins {
        let next = track.starts.iter().find(|s| **s > segment.first).copied().unwrap_or(track.time.len());
        let path = free_run(dynamics, track, &held.values(), start, segment.first, next - 1);
        result.time.extend(&path.time);
        states.extend(&path.states);
        for (column, name) in dynamics.outputs.iter().enumerate() {
            let simulated = path.outputs.iter().skip(column).step_by(width);
            let measured = track.observed[segment.first * width..next * width].iter().skip(column).step_by(width);
            result.simulated.entry(name.clone()).or_default().extend(simulated);
            let measured = measured.map(|x| (!x.is_nan()).then_some(*x));
            result.measured.entry(name.clone()).or_default().extend(measured);
        }
    }
    if let (Some(first), true) = (dynamics.quaternion(), dynamics.outputs.iter().any(|o| o == upright::TURNS[0])) {
        told_by_angles(&mut result, run, first, dynamics.states.len(), &states);
    }
    Ok(result)
}

/// Replaces the rotations that the fit compares by angles: the simulated attitude from the
/// quaternion at column `first` of the `states`, φ and ψ without jumps.
fn told_by_angles(result: &mut Simulated, run: &Run, first: usize, width: usize, states: &[f64]) {
    let angles: Vec<[f64; 3]> = states
        .chunks(width)
        .map(|x| Quaternion::new(x[first], x[first + 1], x[first + 2], x[first + 3]))
        .map(|q| euler_angles(&UnitQuaternion::new_normalize(q)))
        .collect();
    for (k, (turn, dof)) in upright::TURNS.into_iter().zip([Dof::Roll, Dof::Pitch, Dof::Yaw]).enumerate() {
        result.simulated.remove(turn);
        let logged = result.measured.remove(turn).unwrap_or_default();
        let name = dof.position();
        let signal = run.signal(name);
        let measured = result.time.iter().zip(logged).map(|(t, is)| is.and_then(|_| Some(signal?.at(*t)))).collect();
        result.measured.insert(name.to_string(), measured);
        result.simulated.insert(name.to_string(), unwrap(&angles.iter().map(|a| a[k]).collect::<Vec<f64>>()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_hold_what_is_known_at_its_own_instants() {
        let run = Simulated {
            run: "a".into(),
            role: Role::Train,
            time: vec![0.0, 0.5, 1.0],
            simulated: [("u".to_string(), vec![1.0, 2.0, f64::INFINITY]), ("r".to_string(), vec![0.0; 3])].into(),
            measured: [("u".to_string(), vec![Some(1.5), None, Some(4.0)]), ("r".to_string(), vec![None; 3])].into(),
            std: [("u".to_string(), vec![None, Some(0.1), Some(0.2)])].into(),
        };
        assert_eq!(run.signals().into_keys().collect::<Vec<String>>(), ["r", "u", "u_std"]);
        let series = Simulation { format: 1, runs: vec![run], warnings: Vec::new() }.series();
        let names: Vec<&str> = series.signals.keys().map(String::as_str).collect();
        assert_eq!(names, ["a/r/simulated", "a/u/measured", "a/u/residual", "a/u/simulated", "a/u/std"]);
        assert_eq!(series.signals["a/u/measured"].time(), [0.0, 1.0]);
        assert_eq!(series.signals["a/u/simulated"].values(), [1.0, 2.0]);
        assert_eq!(
            (series.signals["a/u/residual"].time(), series.signals["a/u/residual"].values()),
            (&[0.0][..], &[0.5][..])
        );
    }
}
