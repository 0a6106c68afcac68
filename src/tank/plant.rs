//! The true vehicle, integrated step by step: classical Runge-Kutta on the compiled rates of a
//! model, for simulations in which the command is not known beforehand. It contains no physics of
//! its own.

use std::collections::BTreeMap;

use crate::dynamics::{Dynamics, Functions, Source};
use crate::model::Interpolation;
use crate::run::Signal;
use crate::simd::Plain;
use crate::symbolic::{Leaf, Registers};

/// Commands so far, one row per tick of the control.
#[derive(Debug, Clone)]
pub(super) struct Commands {
    /// Time from tick to tick, s.
    pub(super) period: f64,
    /// Interpolation between ticks.
    pub(super) input: Interpolation,
    /// Forces at the ticks, N and N·m.
    pub(super) rows: Vec<[f64; 6]>,
}

impl Commands {
    /// Value and slope at `t`; at a jump those on the side of `within`, an instant of the same
    /// integration step.
    fn read(&self, dof: usize, t: f64, within: f64) -> (f64, f64) {
        let last = self.rows.len() - 1;
        if within < 0.0 {
            return (self.rows[0][dof], 0.0);
        }
        let k = ((within / self.period).floor() as usize).min(last);
        let (here, next) = (self.rows[k][dof], self.rows[(k + 1).min(last)][dof]);
        match self.input {
            Interpolation::Hold => (here, 0.0),
            Interpolation::Linear => {
                let slope = (next - here) / self.period;
                (here + slope * (t - k as f64 * self.period), slope)
            }
        }
    }
}

/// Registers of a set of functions.
#[derive(Debug)]
struct Machine<'a> {
    functions: &'a Functions,
    registers: Registers<1>,
}

impl<'a> Machine<'a> {
    fn new(functions: &'a Functions, theta: &[f64]) -> Machine<'a> {
        let mut registers = functions.plan.registers();
        for (slot, source) in functions.sources.iter().enumerate() {
            if let Source::Parameter(p) = source {
                functions.plan.set(&mut registers, slot, [theta[*p]]);
            }
        }
        functions.plan.prepare(&mut registers);
        Machine { functions, registers }
    }

    fn evaluate(&mut self, x: &[f64], input: &[f64]) -> Vec<f64> {
        let plan = &self.functions.plan;
        for (slot, source) in self.functions.sources.iter().enumerate() {
            match *source {
                // memory that has not started yet is read by nothing
                Source::State(k) => plan.set(&mut self.registers, slot, [x.get(k).copied().unwrap_or(0.0)]),
                Source::Input(k) => plan.set(&mut self.registers, slot, [input[k]]),
                Source::Parameter(_) => {}
            }
        }
        plan.evaluate(Plain, &mut self.registers);
        (0..self.functions.count).map(|k| plan.output(&self.registers, k)[0]).collect()
    }
}

/// A vehicle during its simulation.
#[derive(Debug)]
pub(super) struct Plant<'a> {
    dynamics: &'a Dynamics,
    theta: &'a [f64],
    channels: &'a BTreeMap<String, Signal>,
    rates: Machine<'a>,
    observation: Machine<'a>,
    pub(super) commands: Commands,
    pub(super) time: f64,
    pub(super) state: Vec<f64>,
}

impl<'a> Plant<'a> {
    /// A vehicle at time 0 in the state `start` (velocities and positions; memory starts quasi-steady).
    pub(super) fn new(
        dynamics: &'a Dynamics,
        theta: &'a [f64],
        channels: &'a BTreeMap<String, Signal>,
        commands: Commands,
        start: Vec<f64>,
    ) -> Plant<'a> {
        let rates = Machine::new(&dynamics.rates, theta);
        let observation = Machine::new(&dynamics.observation, theta);
        let mut plant = Plant { dynamics, theta, channels, rates, observation, commands, time: 0.0, state: start };
        let input = plant.inputs(0.0, 0.0);
        let memory = Machine::new(&dynamics.start, theta).evaluate(&plant.state, &input);
        plant.state.extend(memory);
        plant
    }

    /// The outputs of the dynamics at the current instant, in their order.
    pub(super) fn observe(&mut self) -> Vec<f64> {
        let input = self.inputs(self.time, self.time);
        self.observation.evaluate(&self.state, &input)
    }

    /// Integrates up to the instant `end` in steps of at most `longest`. No step crosses a tick of
    /// the command, nor a tick shifted by a delay.
    pub(super) fn sail(&mut self, end: f64, longest: f64) {
        let mut stops = Vec::new();
        for late in self.dynamics.delays().iter().map(|p| self.theta[*p]).chain([0.0]) {
            let ticks = |t: f64| (t - late) / self.commands.period;
            let (first, last) = (ticks(self.time).floor() as i64, ticks(end).ceil() as i64);
            stops.extend((first..=last).map(|k| k as f64 * self.commands.period + late));
        }
        let inside = |stop: &f64| *stop > self.time + 1e-9 && *stop < end - 1e-9;
        stops.retain(inside);
        stops.sort_unstable_by(f64::total_cmp);
        stops.push(end);
        let mut begin = self.time;
        for stop in stops {
            let parts = ((stop - begin) / longest * (1.0 - 1e-9)).ceil().max(1.0);
            let h = (stop - begin) / parts;
            for i in 0..parts as usize {
                self.step(begin + h * i as f64, h);
            }
            begin = stop;
        }
        self.time = end;
    }

    fn step(&mut self, t: f64, h: f64) {
        let within = t + 0.5 * h;
        let [first, middle, last] = [t, within, t + h].map(|t| self.inputs(t, within));
        let mut ahead = |x: &[f64], reach: f64, k: &[f64], input: &[f64]| {
            let y: Vec<f64> = x.iter().zip(k).map(|(x, k)| x + reach * k).collect();
            self.rates.evaluate(&y, input)
        };
        let zero = vec![0.0; self.state.len()];
        let k1 = ahead(&self.state, 0.0, &zero, &first);
        let k2 = ahead(&self.state, 0.5 * h, &k1, &middle);
        let k3 = ahead(&self.state, 0.5 * h, &k2, &middle);
        let k4 = ahead(&self.state, h, &k3, &last);
        for (i, x) in self.state.iter_mut().enumerate() {
            *x += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }

    /// Inputs at `t`; at a jump those on the side of `within`.
    fn inputs(&self, t: f64, within: f64) -> Vec<f64> {
        let read = |(leaf, name): &(Leaf, String)| {
            let (slope, [late, drift]) = match *leaf {
                Leaf::Delayed { late, .. } => (false, late.values(self.theta)),
                Leaf::DelayedRate { late, .. } => (true, late.values(self.theta)),
                Leaf::Rate(_) => (true, [0.0; 2]),
                _ => (false, [0.0; 2]),
            };
            // the tank's runs begin at 0
            let earlier = |t: f64| t - late - drift * t;
            let (t, within) = (earlier(t), earlier(within));
            let force = crate::frame::Dof::ALL.iter().position(|dof| dof.force() == name);
            let both = match (force, self.channels.get(name)) {
                (Some(dof), _) => self.commands.read(dof, t, within),
                (None, Some(signal)) => line(signal, t, within),
                (None, None) => (t, 1.0),
            };
            if slope { both.1 } else { both.0 }
        };
        self.dynamics.inputs.iter().map(read).collect()
    }
}

/// Value and slope of the linear interpolation between the samples, constant outside of them.
pub(super) fn line(signal: &Signal, t: f64, within: f64) -> (f64, f64) {
    let (time, x) = (signal.time(), signal.values());
    let k = time.partition_point(|s| *s <= within);
    if k == 0 || k == x.len() {
        return (x[k.max(1) - 1], 0.0);
    }
    let slope = (x[k] - x[k - 1]) / (time[k] - time[k - 1]);
    (x[k - 1] + slope * (t - time[k - 1]), slope)
}
