//! What is random, no more than the likelihood asks for: forces without which −2 ln L is no more than [`CHANCE`] higher
//! are taken out, and sensors whose innovations are not white are given a part that is correlated in time where it falls by
//! more.

use nalgebra::DMatrix;

use super::likelihood::Linear;
use super::noise::{Coloured, NoiseModel};
use super::start::TIME;
use super::steps::Search;
use super::whiteness::Whiteness;
use crate::estimate::output_error::read_inputs;
use crate::model::Model;

/// Rise of −2 ln L without a force of two unknowns that chance makes once in a hundred: the 99 % quantile of χ²(2).
const CHANCE: f64 = 9.21;

/// Share of a force with which the search goes on once sensors are given colour.
const STOOD_IN: f64 = 0.1;

impl Search<'_> {
    /// Gives the noise of sensors a part that is correlated in time where innovations are not white and the likelihood
    /// asks for it, all such channels at once; whether the search has converged.
    pub(super) fn colour(&mut self) -> bool {
        let outputs = self.noise.sensors.len();
        let innovations = self.filtered.innovations(&self.model, &self.noise, &self.mobilities, self.limit);
        let white = |output: usize| {
            let of = innovations.iter().map(|z| Whiteness::of(&z[output]));
            of.reduce(|a, b| a.with(&b)).is_none_or(|w| w.is_white(outputs))
        };
        let asked: Vec<usize> = (0..outputs).filter(|c| !self.silent[*c] && !white(*c)).collect();
        if asked.is_empty() {
            return true;
        }
        let before = self.saved();
        for output in &asked {
            let sensor = &mut self.noise.sensors[*output];
            let part = sensor.std * std::f64::consts::FRAC_1_SQRT_2;
            (sensor.std, sensor.coloured) = (part, Some(Coloured { rms: part, time: 4.0 * self.times.0 }));
        }
        // a force that has stood in for the colour is slow to go and quick to grow
        if self.options.forces.is_estimated() {
            for force in &mut self.noise.forces {
                (force.rms, force.time) = (STOOD_IN * force.rms, TIME);
            }
        }
        self.renew();
        let converged = self.climb(self.options.tolerance);
        if before.4 - self.cost <= CHANCE * asked.len() as f64 {
            self.restore(before);
            return true;
        }
        // those without which the likelihood is as great go again
        let mut gone = false;
        for output in asked {
            let Some(coloured) = self.noise.sensors[output].coloured else { continue };
            let mut without = self.noise.clone();
            let sensor = &mut without.sensors[output];
            (sensor.std, sensor.coloured) = (sensor.std.hypot(coloured.rms), None);
            let rise = self.linearised(&self.model, &without).1 - self.cost;
            if rise <= CHANCE {
                (self.noise, gone) = (without, true);
            }
        }
        if gone {
            self.renew();
            return self.climb(self.options.tolerance);
        }
        converged
    }

    #[allow(clippy::type_complexity)] // what a step may have to give back
    fn saved(&self) -> (Model, NoiseModel, Vec<DMatrix<f64>>, Vec<Linear>, f64) {
        (self.model.clone(), self.noise.clone(), self.mobilities.clone(), self.current.clone(), self.cost)
    }

    fn restore(&mut self, saved: (Model, NoiseModel, Vec<DMatrix<f64>>, Vec<Linear>, f64)) {
        (self.model, self.noise, self.mobilities, self.current, self.cost) = saved;
        read_inputs(&mut self.filtered.problem, &self.model);
    }

    /// Takes out the forces that the likelihood does not ask for, the weakest first; whether the search has converged.
    pub(super) fn drop_forces(&mut self) -> bool {
        let mut converged = true;
        let mut kept: Vec<crate::frame::Dof> = Vec::new();
        // all at once, where none of them is any
        if self.options.forces.is_estimated() && !self.noise.forces.is_empty() {
            let before = self.saved();
            let count = self.noise.forces.len() as f64;
            let mut without = self.noise.clone();
            without.forces.clear();
            let (_, cost) = self.linearised(&self.model, &without);
            if cost - before.4 <= 5.0 * CHANCE * count {
                self.noise = without;
                self.renew();
                let settled = self.climb(self.options.tolerance);
                // a sum of as many as there are may rise by no more than one of them
                if self.cost - before.4 <= CHANCE {
                    return settled;
                }
                self.restore(before);
            }
        }
        while self.options.forces.is_estimated() {
            // what −2 ln L rises by at once is the most that it may rise by
            let rise = |i: usize| {
                let mut without = self.noise.clone();
                without.forces.remove(i);
                let stretches = self.filtered.linearise(&self.model, &without, &self.mobilities, self.limit, false);
                let here: f64 = self.current.iter().map(|s| s.cost).sum();
                stretches.iter().map(|s| s.cost).sum::<f64>() - here
            };
            let candidates = (0..self.noise.forces.len()).filter(|i| !kept.contains(&self.noise.forces[*i].dof));
            let rises: Vec<(usize, f64)> = candidates.map(|i| (i, rise(i))).collect();
            let Some((weakest, rise)) = rises.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            // sensors take up what a force leaves: three times chance may come to chance
            if rise > 5.0 * CHANCE {
                break;
            }
            let before = self.saved();
            let dof = self.noise.forces[weakest].dof;
            self.noise.forces.remove(weakest);
            self.renew();
            let settled = self.climb(self.options.tolerance);
            if self.cost - before.4 <= CHANCE {
                converged = settled;
            } else {
                self.restore(before);
                kept.push(dof);
            }
        }
        converged
    }
}
