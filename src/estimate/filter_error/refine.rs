//! Refinement of the noise to what the likelihood asks for: forces without which −2 ln L is no more
//! than [`CHANCE`] higher are removed, and sensors whose innovations are not white are given a part
//! that is correlated in time if −2 ln L falls by more than that.

use super::likelihood::Innovations;
use super::noise::{Coloured, SensorNoise};
use super::start::TIME;
use super::steps::Search;
use super::whiteness::Whiteness;
use crate::frame::Dof;

/// Rise of −2 ln L without a force (two unknowns) that chance exceeds once in a hundred: the 99 %
/// quantile of χ²(2).
const CHANCE: f64 = 9.21;

/// The same for a sensor if others of its kind have coloured noise: Akaike's price of two unknowns.
const ALIKE: f64 = 4.0;

/// Share of a force with which the search continues after sensors are given coloured noise.
const STOOD_IN: f64 = 0.1;

impl<'a> Search<'a> {
    /// Gives the noise of sensors a part that is correlated in time if their innovations are not
    /// white and the likelihood asks for it, all such channels at once; returns whether the search
    /// has converged.
    ///
    /// If there is such a part, a force as quick as the samples may stand in for the coloured noise
    /// of a sensor whose innovations look white: such sensors are tested as well.
    pub(super) fn colour(&mut self) -> bool {
        let outputs = self.noise.sensors.len();
        let innovations = self.filtered.innovations(&self.model, &self.noise, &self.mobilities, self.limit);
        let white = |output: usize| {
            let of = innovations.iter().map(|z| Whiteness::of(&z[output].z));
            of.reduce(|a, b| a.with(&b)).is_none_or(|w| w.is_white(outputs))
        };
        let parts = |(output, sensor): (usize, &SensorNoise)| {
            let part = sensor.std * std::f64::consts::FRAC_1_SQRT_2;
            let asked = !self.silent[output] && !white(output);
            asked.then_some((output, part, Coloured { rms: part, time: 4.0 * self.times.0 }))
        };
        let asked: Vec<_> = self.noise.sensors.iter().enumerate().filter_map(parts).collect();
        if asked.is_empty() {
            return true;
        }
        let mut converged = self.coloured(&asked, CHANCE, |_| true);
        loop {
            let (asked, quick) = (self.stood_in_for(), self.quick());
            if asked.is_empty() {
                return converged;
            }
            let before = self.clone();
            let settled = self.coloured(&asked, ALIKE, |dof| quick.contains(&dof));
            // what replaces the force must have converged to a noise, not be on the way to one
            if !settled || self.cost >= before.cost {
                self.back_to(before);
                return converged;
            }
            converged = true;
        }
    }

    /// Degrees of freedom with a force whose correlation time is no longer than the sample
    /// interval.
    fn quick(&self) -> Vec<Dof> {
        self.noise.forces.iter().filter(|f| f.time <= 2.0 * self.times.0).map(|f| f.dof).collect()
    }

    /// Sensors without coloured noise in a degree of freedom with a force as quick as the samples.
    /// Each comes with the noise of a coloured sensor, if possible of its kind, in proportion to
    /// the expected innovations of the two; empty if no sensor has coloured noise.
    fn stood_in_for(&self) -> Vec<(usize, f64, Coloured)> {
        let names = &self.filtered.problem.dynamics.outputs;
        let is_velocity = |output: usize| Dof::ALL.iter().any(|dof| dof.velocity() == names[output]);
        let of_quick: Vec<&str> = self.quick().iter().flat_map(|dof| [dof.velocity(), dof.position()]).collect();
        let plain = |output: &usize| {
            !self.silent[*output]
                && self.noise.sensors[*output].coloured.is_none()
                && of_quick.contains(&names[*output].as_str())
        };
        let asked: Vec<usize> = (0..names.len()).filter(plain).collect();
        if asked.is_empty() {
            return Vec::new();
        }
        let innovations = self.filtered.innovations(&self.model, &self.noise, &self.mobilities, self.limit);
        let like = |output: usize| {
            let of_its_kind = self.noise.coloured().find(|(other, _)| is_velocity(*other) == is_velocity(output));
            let (other, colour) = of_its_kind.or(self.noise.coloured().next())?;
            let scale = expected(&innovations, output) / expected(&innovations, other);
            let colour = Coloured { rms: scale * colour.rms, time: colour.time };
            Some((output, scale * self.noise.sensors[other].std, colour))
        };
        asked.into_iter().filter_map(like).collect()
    }

    /// Climbs with a part correlated in time for the sensors `asked`, each with the starting values
    /// of its white standard deviation and of that part, and with little of the forces that may
    /// have stood in for it. Goes back unless −2 ln L falls by more than `price` for each sensor.
    /// Returns whether the search has converged.
    fn coloured(&mut self, asked: &[(usize, f64, Coloured)], price: f64, stood_in: impl Fn(Dof) -> bool) -> bool {
        let before = self.clone();
        for (output, white, coloured) in asked {
            self.noise.sensors[*output] = SensorNoise { std: *white, coloured: Some(*coloured) };
        }
        // a force that has stood in for coloured noise is slow to go and quick to grow
        if self.options.forces.is_estimated() {
            for force in self.noise.forces.iter_mut().filter(|f| stood_in(f.dof)) {
                (force.rms, force.time) = (STOOD_IN * force.rms, TIME);
            }
        }
        self.renew();
        let converged = self.climb(self.options.tolerance);
        if before.cost - self.cost <= price * asked.len() as f64 {
            self.back_to(before);
            return true;
        }
        // parts without which the likelihood is as high are removed again
        let mut gone = false;
        for (output, ..) in asked {
            let Some(coloured) = self.noise.sensors[*output].coloured else { continue };
            let mut without = self.noise.clone();
            let sensor = &mut without.sensors[*output];
            (sensor.std, sensor.coloured) = (sensor.std.hypot(coloured.rms), None);
            let rise = self.linearised(&self.model, &without).1 - self.cost;
            if rise <= price {
                (self.noise, gone) = (without, true);
            }
        }
        if gone {
            self.renew();
            return self.climb(self.options.tolerance);
        }
        converged
    }

    /// Goes back to an earlier state of the search; the passes taken since then still count.
    fn back_to(&mut self, before: Search<'a>) {
        let passes = self.passes;
        *self = Search { passes, ..before };
    }

    /// Removes the forces that the likelihood does not ask for, the weakest first; returns whether
    /// the search has converged.
    pub(super) fn drop_forces(&mut self) -> bool {
        let mut converged = true;
        let mut kept: Vec<Dof> = Vec::new();
        // all at once, in case there is no force at all
        if self.options.forces.is_estimated() && !self.noise.forces.is_empty() {
            let before = self.clone();
            let count = self.noise.forces.len() as f64;
            let mut without = self.noise.clone();
            without.forces.clear();
            let (_, cost) = self.linearised(&self.model, &without);
            if cost - before.cost <= 5.0 * CHANCE * count {
                self.noise = without;
                self.renew();
                let settled = self.climb(self.options.tolerance);
                // the rise without all forces may be no more than is allowed for one of them
                if self.cost - before.cost <= CHANCE {
                    return settled;
                }
                self.back_to(before);
            }
        }
        while self.options.forces.is_estimated() {
            // the rise before the other unknowns have adapted is the most that it can be
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
            // sensors take up what a force leaves: a rise of three times chance may shrink to
            // chance
            if rise > 5.0 * CHANCE {
                break;
            }
            let before = self.clone();
            let dof = self.noise.forces[weakest].dof;
            self.noise.forces.remove(weakest);
            self.renew();
            let settled = self.climb(self.options.tolerance);
            if self.cost - before.cost <= CHANCE {
                converged = settled;
            } else {
                self.back_to(before);
                kept.push(dof);
            }
        }
        converged
    }
}

/// Standard deviation with which a sample of an output is expected one sample ahead (root mean
/// square).
fn expected(innovations: &[Vec<Innovations>], output: usize) -> f64 {
    let of = || innovations.iter().map(|stretch| &stretch[output]);
    let samples: usize = of().map(|i| i.z.len()).sum();
    (of().map(|i| i.expected).sum::<f64>() / samples.max(1) as f64).sqrt()
}
