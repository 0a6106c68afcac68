//! The basin: a true model controlled by a pilot, observed by sensors.
//!
//! ```text
//! pilot(t, measured) → command → actuators → M ν̇ = … + disturbance → sensors → log
//! ```
//!
//! The pilot gives commands at the control rate. Between its ticks the command is linear (the
//! command for the next tick is decided at the current one) or held, according to the model's
//! `input`. The log contains exactly this command.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use thiserror::Error;

use super::disturbance::{DisturbingForce, channel_of};
use super::plant::{Commands, Plant, line};
use super::{Disturbance, Measured, Noise, Pilot, Sensor};
use crate::chain::{Attitude, Available, StateId, turns_freely};
use crate::dynamics::Dynamics;
use crate::effects::{Place, channel};
use crate::frame::Dof;
use crate::model::{Interpolation, Model, ModelError};
use crate::navigation::quaternion;
use crate::run::{Role, Run, RunKind, Signal};

/// The tank with its instruments.
#[derive(Debug, Clone, PartialEq)]
pub struct Basin {
    /// Longest step of the integration, s.
    pub step: f64,
    /// Rate of the commands, Hz; they are logged at this rate.
    pub control_rate: f64,
    /// Instruments.
    pub sensors: Vec<Sensor>,
    /// Disturbance of the motion.
    pub disturbance: Disturbance,
    /// Representation of the attitude: a quaternion for trials that pass the vertical. Then φ and ψ
    /// are logged in (−π, π] and θ in [−π/2, π/2], as instruments report them.
    pub attitude: Attitude,
}

impl Default for Basin {
    /// Steps of 10 ms, commands at 10 Hz, no sensors, no disturbance, attitude by angles.
    fn default() -> Basin {
        let (sensors, disturbance) = (Vec::new(), Disturbance::default());
        Basin { step: 0.01, control_rate: 10.0, sensors, disturbance, attitude: Attitude::Angles }
    }
}

/// One experiment in the basin.
#[derive(Debug, Clone, Default)]
pub struct Trial {
    /// Name of the run.
    pub name: String,
    /// Kind of experiment.
    pub kind: RunKind,
    /// Fit or validation.
    pub role: Role,
    /// Length, s.
    pub duration: f64,
    /// The pilot.
    pub pilot: Pilot,
    /// Initial ν and η; only those that the model simulates count.
    pub start: Measured,
    /// Channels that the model reads besides states and commands, by name; linear between samples.
    pub channels: BTreeMap<String, Signal>,
}

/// Error of a trial.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TankError {
    /// The model is not valid.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A channel that the model or a sensor reads does not exist.
    #[error("trial `{trial}`: nothing gives the channel `{channel}`")]
    MissingChannel {
        /// Name of the trial.
        trial: String,
        /// Name of the channel.
        channel: String,
    },
    /// The motion diverges.
    #[error("trial `{trial}`: the motion diverges at t = {time} s")]
    Diverges {
        /// Name of the trial.
        trial: String,
        /// Time, s.
        time: f64,
    },
    /// There is no such effect to hide.
    #[error("`{name}` cannot be hidden: {reason}")]
    CannotHide {
        /// Effect and place asked for.
        name: String,
        /// Cause.
        reason: &'static str,
    },
}

impl Basin {
    /// Simulates one trial with the true `model`; `index` is the number of the run, which selects
    /// per-run parameters and the noise streams.
    ///
    /// # Errors
    /// [`TankError`] for an invalid model, a missing channel, or a diverging motion.
    pub fn sail(&self, model: &Model, trial: &Trial, index: usize, seed: u64) -> Result<Run, TankError> {
        model.check()?;
        let mut model = model.clone();
        let mut channels = trial.channels.clone();
        let period = 1.0 / self.control_rate;
        let ticks = (trial.duration * self.control_rate).round().max(1.0) as usize;
        let stamps: Arc<[f64]> = (0..=ticks).map(|k| k as f64 / self.control_rate).collect();
        for (name, at) in [(channel::ANCHOR_NORTH, 0), (channel::ANCHOR_EAST, 1)] {
            channels.entry(name.to_string()).or_insert_with(|| constant(&stamps, trial.start.pose[at]));
        }
        for dof in model.dofs.clone() {
            if self.disturbance.std[dof.index()] > 0.0 {
                model.add(Arc::new(DisturbingForce), Place::at(dof))?;
                let mut noise = Noise::new(seed, stream(index, DISTURBANCES + dof.index()));
                let forces = self.disturbance.forces(dof, ticks, period, &mut noise);
                channels.insert(channel_of(dof), Signal::new(stamps.clone(), forces));
            }
        }

        let dynamics = compile(&model, &channels, self.attitude);
        if let Some((_, channel)) = dynamics.inputs.iter().find(|(_, name)| !known(&model, &channels, name)) {
            return Err(TankError::MissingChannel { trial: trial.name.clone(), channel: channel.clone() });
        }
        let theta = crate::simulate::values_in_run(&model, index);
        let commands = Commands { period, input: model.input, rows: Vec::with_capacity(ticks + 1) };
        let record = self.record(&dynamics, &theta, trial, &channels, commands, ticks)?;
        self.write_log(&dynamics, &model, trial, &channels, &record, (index, seed), &stamps)
    }

    /// Integrates the motion and stores the outputs at every instant that a sensor reports.
    fn record(
        &self,
        dynamics: &Dynamics,
        theta: &[f64],
        trial: &Trial,
        channels: &BTreeMap<String, Signal>,
        mut commands: Commands,
        ticks: usize,
    ) -> Result<Record, TankError> {
        let mut pilot = trial.pilot.clone();
        let (period, input) = (commands.period, commands.input);
        commands.rows.push(pilot.command(0.0, &trial.start));
        let start: Vec<f64> = dynamics.states.iter().filter_map(|id| start_of(*id, &trial.start)).collect();
        let mut plant = Plant::new(dynamics, theta, channels, commands, start);
        let end = ticks as f64 / self.control_rate;
        let mut instants: Vec<f64> = self.sensors.iter().flat_map(|s| s.instants(end)).collect();
        instants.sort_by(f64::total_cmp);
        instants.dedup_by(|b, a| *b - *a < SAME_INSTANT);
        let mut due = instants.into_iter().peekable();

        let mut record = Record { time: Vec::new(), outputs: Vec::new(), commands: Vec::new() };
        for k in 0..ticks {
            let tick = (k + 1) as f64 / self.control_rate;
            let seen = measured(dynamics, &plant.observe(), channels, plant.time);
            match input {
                Interpolation::Linear => plant.commands.rows.push(pilot.command(tick, &seen)),
                Interpolation::Hold if k > 0 => plant.commands.rows.push(pilot.command(k as f64 * period, &seen)),
                Interpolation::Hold => {}
            }
            let last = k + 1 == ticks;
            while let Some(t) = due.next_if(|t| *t < tick - SAME_INSTANT || last) {
                if t > plant.time {
                    plant.sail(t, self.step);
                }
                record.time.push(t);
                record.outputs.push(plant.observe());
            }
            if plant.time < tick {
                plant.sail(tick, self.step);
            }
            if plant.state.iter().any(|x| x.is_nan() || x.abs() > LARGEST_STATE) {
                return Err(TankError::Diverges { trial: trial.name.clone(), time: tick });
            }
        }
        record.commands = plant.commands.rows;
        if record.commands.len() == ticks {
            record.commands.push(record.commands[ticks - 1]);
        }
        Ok(record)
    }

    #[allow(clippy::too_many_arguments)] // everything that is known of one run comes together here
    fn write_log(
        &self,
        dynamics: &Dynamics,
        model: &Model,
        trial: &Trial,
        channels: &BTreeMap<String, Signal>,
        record: &Record,
        (index, seed): (usize, u64),
        stamps: &Arc<[f64]>,
    ) -> Result<Run, TankError> {
        let mut run = Run { name: trial.name.clone(), kind: trial.kind, role: trial.role, ..Run::default() };
        for dof in &model.dofs {
            let values: Vec<f64> = record.commands.iter().map(|row| row[dof.index()]).collect();
            run.signals.insert(dof.force().to_string(), Signal::new(stamps.clone(), values));
        }
        let end = stamps[stamps.len() - 1];
        for (k, sensor) in self.sensors.iter().enumerate() {
            let output = dynamics.outputs.iter().position(|name| *name == sensor.channel);
            let value = |t: f64| match (output, channels.get(&sensor.channel)) {
                (Some(column), _) => Some(record.at(t)?[column]),
                (None, Some(signal)) => Some(line(signal, t, t).0),
                (None, None) => None,
            };
            let truth: Option<Vec<f64>> = sensor.instants(end).into_iter().map(value).collect();
            let missing = || TankError::MissingChannel { trial: trial.name.clone(), channel: sensor.channel.clone() };
            let truth = truth.ok_or_else(missing)?;
            let mut noise = Noise::new(seed, stream(index, k));
            run.signals.insert(sensor.channel.clone(), sensor.log(&truth, &mut noise));
        }
        // derived channels that the model reads, as a campaign would add them
        for (name, signal) in channels.iter().filter(|(name, _)| derived(name)) {
            run.signals.insert(name.clone(), signal.clone());
        }
        Ok(run)
    }
}

/// Two instants closer than this are one, s.
const SAME_INSTANT: f64 = 1e-9;

/// Limit of a state, SI: beyond it the motion diverges.
const LARGEST_STATE: f64 = 1e6;

/// First noise stream of the disturbances.
const DISTURBANCES: usize = 512;

/// Noise stream of one source in one run; stream 0 is not used.
pub(super) fn stream(run: usize, source: usize) -> u64 {
    ((run as u64 + 1) << 16) + source as u64
}

/// A channel that does not change.
fn constant(stamps: &Arc<[f64]>, value: f64) -> Signal {
    Signal::new(stamps.clone(), vec![value; stamps.len()])
}

/// Whether a channel is derived from a log rather than logged: no CSV contains it.
pub fn derived(name: &str) -> bool {
    let fixed = [channel::SUPPLY_RATIO, channel::ANCHOR_NORTH, channel::ANCHOR_EAST];
    fixed.contains(&name) || Dof::ALL.iter().any(|dof| channel::keulegan_carpenter(*dof) == name)
}

fn known(model: &Model, channels: &BTreeMap<String, Signal>, name: &str) -> bool {
    name == "t" || channels.contains_key(name) || model.dofs.iter().any(|dof| dof.force() == name)
}

/// The channels that a model may read: the given ones and the commands of its degrees of freedom.
pub(super) fn available(model: &Model, channels: &BTreeMap<String, Signal>) -> Available {
    let commands = model.dofs.iter().map(|dof| dof.force().to_string());
    let channels = channels.keys().cloned().chain(commands).collect();
    Available { channels, position: true, ..Available::default() }
}

fn compile(model: &Model, channels: &BTreeMap<String, Signal>, attitude: Attitude) -> Dynamics {
    let everything: BTreeSet<String> =
        Dof::ALL.iter().flat_map(|dof| [dof.velocity(), dof.position()]).map(str::to_string).collect();
    let attitude = if turns_freely(model) { attitude } else { Attitude::Angles };
    Dynamics::compile(model, &Available { attitude, ..available(model, channels) }, &everything, &[])
}

fn start_of(id: StateId, start: &Measured) -> Option<f64> {
    match id {
        StateId::Velocity(dof) => Some(start.nu[dof.index()]),
        StateId::Position(dof) => Some(start.pose[dof.index()]),
        StateId::Quaternion(k) => {
            let [phi, theta, psi] = [start.pose[3], start.pose[4], start.pose[5]];
            let q = quaternion(phi, theta, psi);
            Some([q.w, q.i, q.j, q.k][usize::from(k)])
        }
        StateId::Memory { .. } => None,
    }
}

fn measured(dynamics: &Dynamics, outputs: &[f64], channels: &BTreeMap<String, Signal>, t: f64) -> Measured {
    let value = |name: &str| match dynamics.outputs.iter().position(|output| *output == name) {
        Some(k) => outputs[k],
        None => channels.get(name).map_or(0.0, |signal| line(signal, t, t).0),
    };
    Measured { nu: Dof::ALL.map(|dof| value(dof.velocity())), pose: Dof::ALL.map(|dof| value(dof.position())) }
}

/// The simulated motion: outputs at instants, commands at ticks.
struct Record {
    time: Vec<f64>,
    outputs: Vec<Vec<f64>>,
    commands: Vec<[f64; 6]>,
}

impl Record {
    /// Outputs at a recorded instant.
    fn at(&self, t: f64) -> Option<&[f64]> {
        let k = self.time.partition_point(|s| *s < t - 2.0 * SAME_INSTANT);
        self.outputs.get(k).map(Vec::as_slice)
    }
}
