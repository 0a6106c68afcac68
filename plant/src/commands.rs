//! Commands to the actuators, with their interpolation in time, wiring faults and backlash.
//!
//! ```text
//! V = curve⁻¹(Tᵀ(TTᵀ)⁻¹ τ)  per thruster, or τ itself
//! logged: V or τ        issued: V or τ after wiring faults and backlash
//! ```

use nalgebra::Vector6;

use crate::actuation::CHANNELS;
use crate::thruster::{Thruster, allocate, configuration};

/// Interpolation between two commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Input {
    /// The earlier command is held.
    #[default]
    Hold,
    /// A straight line from one to the next.
    Linear,
}

/// Faults between the pilot's computer and the actuators.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Wiring {
    /// Pairs of channels whose commands are exchanged.
    pub swaps: Vec<(usize, usize)>,
    /// Run, and the channel whose sign is reversed in it.
    pub reversed: Option<(usize, usize)>,
    /// Half width of the backlash of each channel, in the unit of the command.
    pub backlash: [f64; CHANNELS],
}

/// The commands of a run, one for each command period.
#[derive(Debug, Clone)]
pub struct Commands<'a> {
    thrusters: &'a [Thruster],
    wiring: &'a Wiring,
    run: usize,
    input: Input,
    start: f64,
    period: f64,
    /// Commands as logged.
    pub logged: Vec<[f64; CHANNELS]>,
    issued: Vec<[f64; CHANNELS]>,
}

impl<'a> Commands<'a> {
    /// An empty list of commands. The first one given is for the time `start`, s, each further one
    /// for a `period` later. `thrusters` are the thrusters as the pilot knows them; empty if the
    /// command is a wrench.
    pub fn new(
        thrusters: &'a [Thruster],
        wiring: &'a Wiring,
        run: usize,
        input: Input,
        start: f64,
        period: f64,
    ) -> Commands<'a> {
        Commands { thrusters, wiring, run, input, start, period, logged: Vec::new(), issued: Vec::new() }
    }

    /// Appends the command for a wanted wrench.
    pub fn give(&mut self, wrench: &[f64; 6], moves: [bool; 6]) {
        let mut logged = [0.0; CHANNELS];
        if self.thrusters.is_empty() {
            for i in (0..6).filter(|i| moves[*i]) {
                logged[i] = wrench[i];
            }
        } else {
            let forces = allocate(self.thrusters, &Vector6::from_column_slice(wrench));
            for (k, thruster) in self.thrusters.iter().enumerate() {
                logged[k] = thruster.command(forces[k]);
            }
        }
        let mut issued = logged;
        for (a, b) in &self.wiring.swaps {
            issued.swap(*a, *b);
        }
        if let Some((run, channel)) = self.wiring.reversed
            && run == self.run
        {
            issued[channel] = -issued[channel];
        }
        for (k, width) in self.wiring.backlash.iter().enumerate().filter(|(_, width)| **width > 0.0) {
            let last = self.issued.last().map_or(0.0, |c| c[k]);
            issued[k] = last.clamp(issued[k] - width, issued[k] + width);
        }
        self.logged.push(logged);
        self.issued.push(issued);
    }

    /// Wrench of the last logged command according to the thrusters as the pilot knows them, N and N·m.
    pub fn believed(&self) -> Vector6<f64> {
        let Some(logged) = self.logged.last() else { return Vector6::zeros() };
        if self.thrusters.is_empty() {
            return Vector6::from_column_slice(&logged[..6]);
        }
        let forces: Vec<f64> = self.thrusters.iter().zip(logged).map(|(t, v)| t.bollard(*v)).collect();
        configuration(self.thrusters) * nalgebra::DVector::from_vec(forces)
    }

    /// Value and slope of each channel at `from`, `delay` s late. No new command may begin inside
    /// the interval.
    pub fn line(&self, from: f64, to: f64, delay: f64) -> [(f64, f64); CHANNELS] {
        let middle = 0.5 * (from + to) - delay - self.start;
        let last = self.issued.len() - 1;
        if middle < 0.0 {
            return self.issued[0].map(|value| (value, 0.0));
        }
        let k = ((middle / self.period).floor() as usize).min(last);
        let now = self.issued[k];
        if self.input == Input::Hold || k == last {
            return now.map(|value| (value, 0.0));
        }
        let since = from - delay - self.start - k as f64 * self.period;
        std::array::from_fn(|c| {
            let slope = (self.issued[k + 1][c] - now[c]) / self.period;
            (now[c] + slope * since, slope)
        })
    }
}

// values that are set are returned bit for bit
#[cfg(test)]
#[allow(clippy::float_cmp)]
mod tests {
    use super::*;

    fn given<'a>(wiring: &'a Wiring, input: Input) -> Commands<'a> {
        let mut commands = Commands::new(&[], wiring, 3, input, -0.2, 0.1);
        for k in 0..4 {
            commands.give(&[f64::from(k), -1.0, 0.0, 0.0, 0.0, 2.0], [true; 6]);
        }
        commands
    }

    #[test]
    fn held_and_linear_commands_and_their_delay() {
        let wiring = Wiring::default();
        let held = given(&wiring, Input::Hold);
        assert_eq!(held.line(-0.1, 0.0, 0.0)[0], (1.0, 0.0));
        assert_eq!(held.line(-0.05, 0.0, 0.1)[0], (0.0, 0.0));
        let linear = given(&wiring, Input::Linear);
        let (value, slope) = linear.line(-0.05, 0.0, 0.0)[0];
        assert!((value - 1.5).abs() < 1e-12 && (slope - 10.0).abs() < 1e-9);
        let (value, _) = linear.line(0.0, 0.05, 0.05)[0];
        assert!((value - 1.5).abs() < 1e-12);
    }

    #[test]
    fn wires_and_backlash_change_what_is_issued_and_not_what_is_logged() {
        let mut wiring = Wiring { swaps: vec![(0, 5)], reversed: Some((3, 1)), ..Wiring::default() };
        wiring.backlash[5] = 0.5;
        let commands = given(&wiring, Input::Hold);
        assert_eq!(commands.logged[3][..6], [3.0, -1.0, 0.0, 0.0, 0.0, 2.0]);
        let line = commands.line(0.1, 0.2, 0.0);
        assert_eq!([line[0].0, line[1].0, line[5].0], [2.0, 1.0, 2.5]);
    }
}
