//! Captive tests: the vehicle on load cells, held still (bollard pull) or towed.
//!
//! ```text
//! bollard   load = w + τ     pull of the thrusters on the cells
//! towing    load = −w        pull of the carriage that keeps the speed: the drag, positive ahead
//! ```
//!
//! w is the sum of the wrenches of the model's effects, τ the force of its actuators for the
//! command, at a given motion. The motion is steady, so the balance contains no inertia.

use std::collections::BTreeMap;

use super::basin::{available, stream};
use super::plant::line;
use super::{Noise, Sensor, TankError, Trial};
use crate::chain::{Available, assemble};
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, RunKind, Signal};
use crate::simd::Plain;
use crate::symbolic::{Graph, Leaf, Plan, Registers};

/// Performs a captive test. `trial.channels` contain the velocities that are not 0 and the other
/// channels that the model reads; the pilot gives commands as functions of time only; the sensors
/// read load cells (`load_u`, …) and channels. `index` is the number of the run.
///
/// # Errors
/// [`TankError::MissingChannel`] if a sensor or an effect reads a channel that does not exist.
pub fn captive(
    model: &Model,
    trial: &Trial,
    sensors: &[Sensor],
    control_rate: f64,
    index: usize,
    seed: u64,
) -> Result<Run, TankError> {
    let ticks = (trial.duration * control_rate).round().max(1.0) as usize;
    let stamps: std::sync::Arc<[f64]> = (0..=ticks).map(|k| k as f64 / control_rate).collect();
    let mut pilot = trial.pilot.clone();
    let commands: Vec<[f64; 6]> = stamps.iter().map(|t| pilot.command(*t, &trial.start)).collect();
    let mut channels = trial.channels.clone();
    for dof in &model.dofs {
        let values: Vec<f64> = commands.iter().map(|row| row[dof.index()]).collect();
        channels.insert(dof.force().to_string(), Signal::new(stamps.clone(), values));
    }
    let mut rig = Rig::new(model, &channels);
    let mut run = Run { name: trial.name.clone(), kind: trial.kind, role: trial.role, ..Run::default() };
    for dof in &model.dofs {
        run.signals.extend(channels.get(dof.force()).map(|s| (dof.force().to_string(), s.clone())));
    }
    let sign = if trial.kind == RunKind::Towing { -1.0 } else { 1.0 };
    let end = stamps[ticks];
    for (k, sensor) in sensors.iter().enumerate() {
        let missing = || TankError::MissingChannel { trial: trial.name.clone(), channel: sensor.channel.clone() };
        let load = Dof::ALL.iter().find(|dof| dof.load() == sensor.channel);
        let mut truth = Vec::new();
        for t in sensor.instants(end) {
            truth.push(match (load, channels.get(&sensor.channel)) {
                (Some(dof), _) => sign * rig.force(t, &channels)[dof.index()],
                (None, Some(signal)) => line(signal, t, t).0,
                (None, None) => return Err(missing()),
            });
        }
        run.signals.insert(sensor.channel.clone(), sensor.log(&truth, &mut Noise::new(seed, stream(index, k))));
    }
    Ok(run)
}

/// Computation of the force on a vehicle with given motion.
struct Rig {
    plan: Plan,
    registers: Registers<1>,
    inputs: Vec<String>,
}

impl Rig {
    fn new(model: &Model, channels: &BTreeMap<String, Signal>) -> Rig {
        let graph = Graph::new();
        let read = Available { from_log: true, ..available(model, channels) };
        let equations = assemble(&graph, model, &read);
        let plan = Plan::compile(&equations.force);
        let mut registers = plan.registers();
        for (slot, leaf) in plan.leaves().iter().enumerate() {
            if let Leaf::Parameter(p) = *leaf {
                plan.set(&mut registers, slot, [model.parameters[usize::from(p)].value]);
            }
        }
        plan.prepare(&mut registers);
        Rig { plan, registers, inputs: equations.inputs }
    }

    fn force(&mut self, t: f64, channels: &BTreeMap<String, Signal>) -> [f64; 6] {
        for (slot, leaf) in self.plan.leaves().iter().enumerate() {
            if let Leaf::Input(k) = *leaf {
                let signal = channels.get(&self.inputs[usize::from(k)]);
                self.plan.set(&mut self.registers, slot, [signal.map_or(t, |signal| line(signal, t, t).0)]);
            }
        }
        self.plan.evaluate(Plain, &mut self.registers);
        std::array::from_fn(|i| self.plan.output(&self.registers, i)[0])
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Law, Pilot};
    use super::*;
    use crate::effects::Coriolis;

    fn model() -> Model {
        let effects = ["inertia", "quadratic_drag", "bias", "thrust_interaction_loss"];
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &effects).unwrap();
        for (name, value) in
            [("inertia", 800.0), ("quadratic_drag", 368.48), ("bias", -0.23), ("thrust_interaction_loss", 0.97)]
        {
            assert!(model.set(&format!("{name}@surge"), value));
        }
        model
    }

    #[test]
    fn exact_bollard_pull_is_the_thrust_less_its_loss() {
        let laws = vec![(Dof::Surge, Law::sine(296.8, 263.27, 24.0))];
        let trial = Trial { kind: RunKind::Bollard, duration: 24.0, pilot: Pilot::new(laws), ..Trial::default() };
        let run = captive(&model(), &trial, &[Sensor::new("load_u", 10.0, 0.0)], 10.0, 0, 1).unwrap();
        let (load, tau) = (run.signal("load_u").unwrap(), run.signal("tau_u").unwrap());
        assert_eq!(load.len(), 241);
        for (load, tau) in load.values().iter().zip(tau.values()) {
            // one product and one sum in floating point; the bias is a force on the drag side
            assert!((load - (0.97 * tau + 0.23)).abs() < 1e-12 * 600.0);
        }
    }

    #[test]
    fn exact_towing_force_is_the_drag() {
        let speed = Signal::new(vec![0.0, 30.0].into(), vec![0.5, 0.5]);
        let channels = BTreeMap::from([("u".to_string(), speed)]);
        let trial = Trial { kind: RunKind::Towing, duration: 30.0, channels, ..Trial::default() };
        let sensors = [Sensor::new("load_u", 10.0, 0.0), Sensor::new("u", 3.0, 0.0)];
        let run = captive(&model(), &trial, &sensors, 10.0, 0, 1).unwrap();
        let expected = 368.48 * 0.25 - 0.23;
        assert!(run.signal("load_u").unwrap().values().iter().all(|f| (f - expected).abs() < 1e-12 * expected));
        assert_eq!(run.signal("u").unwrap().values()[7], 0.5);
        assert!(captive(&model(), &trial, &[Sensor::new("v", 3.0, 0.0)], 10.0, 0, 1).is_err());
    }
}
