//! Joint Newton steps of parameters and noise, where alternating steps creep or do not converge.
//!
//! ```text
//! x = (θ/s, ln η):   (|H| + μ) δ = −g        g, H: slope and curvature of −ln L by x
//! |H|: H with the absolute values of its eigenvalues
//! ```
//!
//! The rows of an alternating step hold the gain of the filter fixed, and Fisher's information is
//! the curvature expected of a correct model. If the model is not correct, parameters and noise
//! trade against each other along ridges where neither is the curvature of the data, and
//! alternating steps gain a tenth at a time, or nothing. Here slope and curvature are differences
//! of the likelihood itself ([`super::differences`]), and the curvature is kept as long as steps
//! gain what they promise. Saddle points: Dauphin and others, *Advances in Neural Information
//! Processing Systems* 27 (2014).

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::differences::Joint;
use super::noise::{Coordinate, NoiseModel};
use super::noise_steps::{FARTHEST, FLAT};
use super::steps::{HOPE, Search};
use crate::estimate::output_error::value;
use crate::model::Model;
use crate::progress;

/// Step of a difference, in standard deviations of a parameter and in a logarithm of the noise: the
/// term in its cube is negligible in a slope, and roundings of ln L are negligible in a curvature.
const STEP: f64 = 1e-2;

/// Dampings that are tried side by side, relative to the curvature.
const DAMPINGS: [f64; 8] = [0.0, 0.01, 0.1, 1.0, 10.0, 1e2, 1e3, 1e4];

/// Greatest number of steps: the ridges that were seen took five to twenty.
const STEPS: usize = 40;

/// Least eigenvalue of a curvature relative to its diagonal: differences of ln L do not distinguish
/// smaller ones from zero.
const LEAST: f64 = 1e-6;

/// Range of the actual gain of a step over the promised one within which the curvature is kept.
const AS_PROMISED: std::ops::Range<f64> = 0.7..1.5;

/// Fall of −2 ln L, that of a parameter one standard deviation off, below which a promise need not
/// be kept if the step gains nothing. If innovations are held back, the curvature changes from one
/// sample to the next, and the quadratic is no more accurate than that.
const NEAR: f64 = 1.0;

impl Search<'_> {
    /// Takes joint steps until they promise less than `tolerance`; returns whether that was
    /// reached.
    pub(super) fn climb_together(&mut self, tolerance: f64) -> bool {
        self.quasi.forget();
        self.linearise_as_pushed();
        let mut known: Option<(Joint, DMatrix<f64>)> = None;
        for _ in 0..STEPS {
            let kept = known.take().filter(|(joint, _)| joint.coordinates == self.coordinates());
            let was_kept = kept.is_some();
            let (joint, curvature) =
                kept.map_or_else(|| (self.joint(self.coordinates(), STEP), None), |(joint, h)| (joint, Some(h)));
            let (gradient, raw) = self.differences(&joint, curvature);
            let before = self.cost;
            let Some((promised, share)) = self.step_together(&joint, &gradient, &raw) else {
                if was_kept {
                    continue;
                }
                return false;
            };
            if self.options.told {
                progress::tell("fitting by filter error", self.passes, 0);
            }
            if promised < tolerance || promised < NEAR && before - self.cost < tolerance {
                return true;
            }
            if AS_PROMISED.contains(&share) {
                known = Some((joint, raw));
            }
            if self.cost - HOPE * promised > self.bar {
                self.given_up = true;
                return false;
            }
        }
        false
    }

    /// Takes one step. Returns the greatest fall of −2 ln L that was promised, and the actual fall
    /// as a share of that promised by the damped step. `None` if no step leads up.
    fn step_together(
        &mut self,
        joint: &Joint,
        gradient: &DVector<f64>,
        curvature: &DMatrix<f64>,
    ) -> Option<(f64, f64)> {
        let (p, n) = (joint.unknowns.len(), joint.len());
        let mut h = curvature.clone();
        for (k, (_, more)) in self.priors(joint).into_iter().enumerate() {
            h[(k, k)] += more + if k < p { 0.0 } else { FLAT };
        }
        // a difference diverges
        if !h.iter().chain(gradient.iter()).all(|x| x.is_finite()) {
            return None;
        }
        // how far each unknown can move
        let room = |k: usize| match joint.unknowns.get(k) {
            Some(unknown) => {
                let parameter = &self.model.parameters[unknown.parameter];
                let now = value(&self.model, *unknown);
                ((parameter.min - now) / joint.scales[k], (parameter.max - now) / joint.scales[k])
            }
            None if self.is_bound(joint.coordinates[k - p], gradient[k]) => (0.0, 0.0),
            None => (f64::NEG_INFINITY, f64::INFINITY),
        };
        let room: Vec<(f64, f64)> = (0..n).map(room).collect();
        let steps: Vec<(DVector<f64>, f64)> = DAMPINGS.map(|mu| bounded_step(&h, gradient, &room, mu)).into();
        let promised = steps[0].1;
        if promised < 0.1 * self.tolerance {
            return Some((promised, 1.0));
        }
        let trial = |step: &DVector<f64>| {
            let (mut model, mut noise) = (self.model.clone(), self.noise.clone());
            let part = (FARTHEST / step.rows(p, n - p).amax().max(f64::MIN_POSITIVE)).min(1.0);
            (0..n).for_each(|k| joint.go(k, part * step[k], (&mut model, &mut noise)));
            joint.coordinates.iter().for_each(|c| noise.set(*c, self.bounded(*c, noise.at(*c))));
            (model, noise)
        };
        let points: Vec<(Model, NoiseModel)> = steps.iter().map(|(step, _)| trial(step)).collect();
        let own = self.costs_side_by_side(&points).into_iter().map(|costs| costs.iter().sum::<f64>());
        let costs = own.zip(&points).map(|(own, (model, noise))| own + self.prior_costs(model, noise));
        let best = costs.enumerate().filter(|(_, cost)| cost.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1));
        self.passes += 1;
        let (best, cost) = best.filter(|(_, cost)| *cost < self.cost)?;
        let share = (self.cost - cost) / steps[best].1;
        (self.model, self.noise) = points.into_iter().nth(best)?;
        self.linearise_as_pushed();
        Some((promised, share))
    }

    /// Linearises at the current point with its inertias, after removing the forces that have run
    /// to zero.
    fn linearise_as_pushed(&mut self) {
        self.drop_nothings();
        self.filtered.problem.follow(&self.model);
        self.follow_as_pushed();
        let (next, cost) = self.linearised(&self.model, &self.noise);
        self.take(next, cost);
    }

    /// Updates the inertias to the current point, and scales the forces so that they accelerate as
    /// before: another inertia alone makes no other noise.
    fn follow_as_pushed(&mut self) {
        if let (true, Some(here)) = (self.options.forces.is_estimated(), self.filtered.mobilities(&self.model)) {
            for i in 0..self.noise.forces.len() {
                let (coordinate, k) = (Coordinate::ForceRms(i), self.velocity_of(i));
                let moved = self.noise.at(coordinate) + (self.mobilities[0][(k, k)] / here[0][(k, k)]).ln();
                self.noise.set(coordinate, self.bounded(coordinate, moved));
            }
        }
        self.follow_inertia();
    }

    /// Index of a force among the velocities.
    fn velocity_of(&self, force: usize) -> usize {
        let own = self.noise.forces[force].dof;
        self.filtered.problem.dynamics.velocities().iter().position(|dof| *dof == own).unwrap_or(0)
    }
}

/// The step with the absolute eigenvalues of the curvature, damped by `mu`, within the room that
/// each unknown has, and by how much −2 ln L falls with it in a quadratic of that curvature. An
/// unknown that would leave its room goes to the end of it, and the others are found with it there.
fn bounded_step(h: &DMatrix<f64>, gradient: &DVector<f64>, room: &[(f64, f64)], mu: f64) -> (DVector<f64>, f64) {
    let n = gradient.len();
    let mut step = DVector::zeros(n);
    // at a bound, and the slope leads beyond it
    let mut stays: Vec<bool> =
        (0..n).map(|k| gradient[k] > 0.0 && room[k].0 >= 0.0 || gradient[k] < 0.0 && room[k].1 <= 0.0).collect();
    let length: Vec<f64> = (0..n).map(|k| h[(k, k)].abs().max(LEAST).sqrt()).collect();
    loop {
        let free: Vec<usize> = (0..n).filter(|k| !stays[*k]).collect();
        free.iter().for_each(|k| step[*k] = 0.0);
        // the slope with the unknowns that stay at their ends, and the fall on the way there
        let bent = h * &step;
        let there = gradient + &bent;
        let fall = -step.dot(&(gradient + &there));
        if free.is_empty() {
            return (step, fall.max(0.0));
        }
        let over = |i: usize, j: usize| h[(free[i], free[j])] / (length[free[i]] * length[free[j]]);
        let eigen = SymmetricEigen::new(DMatrix::from_fn(free.len(), free.len(), over));
        let size = eigen.eigenvalues.map(|lambda| lambda.abs().max(LEAST));
        let slope = DVector::from_iterator(free.len(), free.iter().map(|k| there[*k] / length[*k]));
        let slope = eigen.eigenvectors.transpose() * slope;
        let along = -slope.component_div(&size.add_scalar(mu));
        let moved = &eigen.eigenvectors * &along;
        let mut left = false;
        for (at, &k) in free.iter().enumerate() {
            let to = moved[at] / length[k];
            let (least, most) = (room[k].0.min(0.0), room[k].1.max(0.0));
            step[k] = to.clamp(least, most);
            if to < least || to > most {
                (stays[k], left) = (true, true);
            }
        }
        if !left {
            let fall = fall - along.dot(&(2.0 * slope + along.component_mul(&size)));
            return (step, fall.max(0.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::filter_error::FilterErrorOptions;
    use crate::estimate::filter_error::tests::{sailed, search};
    use crate::estimate::output_error::Unknown;

    /// f = x²/2 + y²/2 + xy/2 − 3x − y: its minimum by hand, (10/3, −2/3), and with x at most 2,
    /// (2, 0).
    #[test]
    fn exact_steps_within_their_room() {
        let h = DMatrix::from_row_slice(2, 2, &[1.0, 0.5, 0.5, 1.0]);
        let gradient = DVector::from_vec(vec![-3.0, -1.0]);
        let all = [(f64::NEG_INFINITY, f64::INFINITY); 2];
        let (step, fall) = bounded_step(&h, &gradient, &all, 0.0);
        assert!((step[0] - 10.0 / 3.0).abs() < 1e-12 && (step[1] + 2.0 / 3.0).abs() < 1e-12, "{step}");
        // −gᵀδ of a whole step is twice the fall of f
        assert!((fall - 28.0 / 3.0).abs() < 1e-12, "{fall}");
        let (step, fall) = bounded_step(&h, &gradient, &[(-1.0, 2.0), all[1]], 0.0);
        assert!((step[0] - 2.0).abs() < 1e-12 && step[1].abs() < 1e-12, "{step}");
        // f(2, 0) = −4
        assert!((fall - 8.0).abs() < 1e-12, "{fall}");
        // both at their ends: f(2, −1/2) = −3.875
        let (step, fall) = bounded_step(&h, &gradient, &[(-1.0, 2.0), (-0.5, 1.0)], 0.0);
        let at_ends = step[0] == 2.0 && step[1] == -0.5;
        assert!(at_ends && (fall - 2.0 * 3.875).abs() < 1e-12, "{step} {fall}");
        // an unknown that stands at its bound and would leave it stays
        let (step, _) = bounded_step(&h, &gradient, &[(-1.0, 0.0), all[1]], 0.0);
        assert!(step[0] == 0.0 && (step[1] - 1.0).abs() < 1e-12, "{step}");
    }

    /// From near a saddle, f = x²/2 − y²/2 at y = 1, the step leads down along both axes.
    #[test]
    fn a_saddle_is_left_downwards() {
        let h = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, -1.0]);
        let gradient = DVector::from_vec(vec![0.5, -1.0]);
        let (step, _) = bounded_step(&h, &gradient, &[(f64::NEG_INFINITY, f64::INFINITY); 2], 0.0);
        assert!((step[0] + 0.5).abs() < 1e-12 && (step[1] - 1.0).abs() < 1e-12, "{step}");
    }

    #[test]
    fn steps_together_end_where_steps_in_turns_do() {
        let (campaign, options) = (sailed(), FilterErrorOptions::default());
        let (mut turns, mut together) = (search(&campaign, &options), search(&campaign, &options));
        assert!(turns.climb(options.tolerance));
        assert!(together.climb_together(options.tolerance));
        // both promise less than the tolerance; the gain that the rows hold fixed is worth a few
        // tolerances
        assert!((turns.cost - together.cost).abs() < 10.0 * options.tolerance, "{} {}", turns.cost, together.cost);
        let unknowns = &turns.filtered.problem.unknowns;
        let off = |u: &Unknown| value(&turns.model, *u) - value(&together.model, *u);
        let off: Vec<f64> = unknowns.iter().map(off).collect();
        let factor = turns.filtered.factor(&turns.model, &turns.current);
        let row = |i: usize| (i..off.len()).map(|j| factor.at(i, j)[0] * off[j]).sum::<f64>();
        let deviations = (0..off.len()).map(|i| row(i).powi(2)).sum::<f64>().sqrt();
        // the likelihoods may differ by a tenth, and the parameters by its root
        assert!(deviations < 0.32, "{deviations}");
    }
}
