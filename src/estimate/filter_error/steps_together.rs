//! Steps of parameters and noise together, where steps in turns do not come to rest.
//!
//! ```text
//! x = (θ/h, ln η):    δ = −H g      g: slope of −ln L by x      H₀ = diag((JᵀJ)⁻¹, (I + F)⁻¹), and what the steps have shown
//! ```
//!
//! The rows J hold the gain of the filter: where a model follows its data badly, their slope leads to places where the
//! likelihood does not rise although it could, and a step in turns ends there. Here the slopes by θ are differences of the
//! likelihood itself, over a thousandth of a deviation. Parameters and noise that trade against each other creep in turns and
//! go together by what the steps have shown of the curvature ([`super::quasi_newton`]).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::Filtered;
use super::noise::Coordinate;
use super::noise_steps::{EASED, FARTHEST, FLAT, LEAST_DAMPING, MOST_DAMPING, PART};
use super::steps::{HOPE, Search};
use crate::estimate::output_error::{Unknown, move_by, read_inputs, value};
use crate::model::Model;
use crate::progress;

/// Deviation over which a slope by a parameter is taken: its square does not show, and roundings of ln L do not either.
const STEP: f64 = 1e-3;

/// Share of a parameter's information that is added to it: roundings of what goes together exactly.
const ROUNDED: f64 = 1e-9;

/// Steps in a row that have to gain something, where they promise no more than this, a parameter a deviation off.
const IDLE: usize = 6;
const NEAR: f64 = 1.0;

impl Search<'_> {
    /// Steps together until they promise less than `tolerance`, or several have gained less: at bounds a promise is not kept.
    /// Whether that was reached.
    pub(super) fn climb_together(&mut self, tolerance: f64) -> bool {
        self.quasi.forget();
        let (scales, mut damping) = (self.scales(), 0.0);
        let mut costs = Vec::new();
        for _ in 0..self.options.iterations {
            let Some(promised) = self.step_together(&scales, &mut damping) else { return false };
            costs.push(self.cost);
            if self.options.told {
                progress::tell("fitting by filter error", self.passes, 0);
            }
            let gained = costs.len().checked_sub(IDLE + 1).map_or(f64::INFINITY, |before| costs[before] - self.cost);
            if promised < tolerance || promised < NEAR && gained.abs() < tolerance {
                return true;
            }
            if self.cost - HOPE * promised > self.bar {
                self.given_up = true;
                return false;
            }
        }
        false
    }

    /// Deviation of each parameter beside the others as they are.
    fn scales(&self) -> Vec<f64> {
        let factor = self.filtered.factor(&self.model, &self.current);
        let of = |k: usize| (0..=k).map(|i| factor.at(i, k)[0].powi(2)).sum::<f64>().sqrt();
        (0..self.filtered.problem.unknowns.len()).map(|k| 1.0 / of(k).max(f64::MIN_POSITIVE)).collect()
    }

    /// One step; by how much −2 ln L was to fall. `None` where none leads up.
    fn step_together(&mut self, scales: &[f64], remembered: &mut f64) -> Option<f64> {
        self.drop_nothings();
        let unknowns = self.filtered.problem.unknowns.clone();
        let coordinates = self.coordinates();
        self.filtered.problem.follow(&self.model);
        self.follow_as_pushed();
        let (of_noise, noise_information) = self.scored(&coordinates);
        let of_parameters = self.parameter_slopes(&unknowns, scales);
        let (p, n) = (unknowns.len(), unknowns.len() + coordinates.len());
        let mut gradient = DVector::from_iterator(n, of_parameters.into_iter().chain(of_noise.iter().copied()));
        let mut information = DMatrix::zeros(n, n);
        let factor = self.filtered.factor(&self.model, &self.current);
        let r = DMatrix::from_fn(p, p, |i, j| if i <= j { factor.at(i, j)[0] * scales[j] } else { 0.0 });
        information.view_mut((0, 0), (p, p)).copy_from(&(r.transpose() * r));
        information.view_mut((p, p), (n - p, n - p)).copy_from(&noise_information);
        let held = self.held_together(&unknowns, scales, &coordinates, &gradient);
        for k in (0..n).filter(|k| held[*k]) {
            gradient[k] = 0.0;
            information.row_mut(k).fill(0.0);
            information.column_mut(k).fill(0.0);
            information[(k, k)] = 1.0;
        }
        let at = unknowns.iter().zip(scales).map(|(u, scale)| value(&self.model, *u) / scale);
        let at = DVector::from_iterator(n, at.chain(coordinates.iter().map(|c| self.pushed(*c))));
        self.quasi.learn(&at, &gradient, &held);
        let damped = |damping: f64, gradient: &DVector<f64>| {
            let mut damped = information.clone();
            for k in 0..n {
                damped[(k, k)] = damped[(k, k)] * (1.0 + damping) + if k < p { ROUNDED } else { FLAT };
            }
            Some(damped.cholesky()?.solve(gradient))
        };
        let mut learnt = self.quasi.step(&gradient, |g| damped(0.0, g));
        let (mut part, mut damping) = (1.0, *remembered);
        // twice the fall of −ln L that the quadratic promises to the whole step
        let whole = damped(0.0, &gradient)?.dot(&gradient);
        let whole = learnt.as_ref().map_or(whole, |step| whole.max(-gradient.dot(step)));
        if whole < 0.1 * self.tolerance {
            return Some(whole.max(0.0));
        }
        loop {
            let step = match &learnt {
                Some(step) => part * step,
                None => -damped(damping, &gradient)?,
            };
            if -gradient.dot(&step) > 0.0 && self.goes(&unknowns, scales, &coordinates, &step) {
                if learnt.is_none() {
                    *remembered = if damping * EASED < LEAST_DAMPING { 0.0 } else { damping * EASED };
                }
                return Some(whole);
            }
            match (&learnt, part) {
                (Some(_), 1.0) => part = PART,
                (Some(_), _) => {
                    // what was learnt elsewhere does not hold here
                    learnt = None;
                    self.quasi.forget();
                    self.quasi.learn(&at, &gradient, &held);
                }
                (None, _) => damping = f64::max(damping * 10.0, LEAST_DAMPING),
            }
            if damping > MOST_DAMPING {
                return None;
            }
        }
    }

    /// The inertias of here, and forces that push as they did: another inertia alone makes no other noise.
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

    /// Place of a force among the velocities.
    fn velocity_of(&self, force: usize) -> usize {
        let own = self.noise.forces[force].dof;
        self.filtered.problem.dynamics.velocities().iter().position(|dof| *dof == own).unwrap_or(0)
    }

    /// A logarithm of the noise: of a force what it does to the velocity.
    fn pushed(&self, coordinate: Coordinate) -> f64 {
        let of_force = |i: usize| self.mobilities[0][(self.velocity_of(i), self.velocity_of(i))].abs().ln();
        self.noise.at(coordinate) + if let Coordinate::ForceRms(i) = coordinate { of_force(i) } else { 0.0 }
    }

    /// Takes the step where the likelihood rises along it; whether it does.
    fn goes(&mut self, unknowns: &[Unknown], scales: &[f64], coordinates: &[Coordinate], step: &DVector<f64>) -> bool {
        let p = unknowns.len();
        let longest = step.rows(p, coordinates.len()).iter().fold(f64::MIN_POSITIVE, |most, s| s.abs().max(most));
        let part = (FARTHEST / longest).min(1.0);
        let (mut model, mut noise) = (self.model.clone(), self.noise.clone());
        for (k, unknown) in unknowns.iter().enumerate() {
            move_by(&mut model, *unknown, part * step[k] * scales[k]);
        }
        for (k, c) in coordinates.iter().enumerate() {
            noise.set(*c, self.bounded(*c, noise.at(*c) + part * step[p + k]));
        }
        let late = !self.filtered.problem.dynamics.delays().is_empty();
        if late {
            read_inputs(&mut self.filtered.problem, &model);
        }
        let (next, cost) = self.linearised(&model, &noise);
        self.passes += 1;
        let rises = cost.is_finite() && cost <= self.cost + 1e-9 * self.cost.abs();
        if rises {
            (self.model, self.noise, self.current, self.cost) = (model, noise, next, cost);
        } else if late {
            read_inputs(&mut self.filtered.problem, &self.model);
        }
        rises
    }

    /// What stands at its bound and would leave it.
    fn held_together(
        &self,
        unknowns: &[Unknown],
        scales: &[f64],
        coordinates: &[Coordinate],
        gradient: &DVector<f64>,
    ) -> Vec<bool> {
        let parameters = unknowns.iter().zip(scales).enumerate().map(|(k, (unknown, scale))| {
            let parameter = &self.model.parameters[unknown.parameter];
            let there = value(&self.model, *unknown) - STEP * scale * gradient[k].signum();
            there < parameter.min || there > parameter.max
        });
        let noise = coordinates.iter().enumerate().map(|(k, c)| self.is_bound(*c, gradient[unknowns.len() + k]));
        parameters.chain(noise).collect()
    }

    /// Slopes of −ln L by the parameters over `scales`, priors included: of one that each run has of its own, all runs at once.
    fn parameter_slopes(&self, unknowns: &[Unknown], scales: &[f64]) -> Vec<f64> {
        let mut parameters: Vec<usize> = unknowns.iter().map(|u| u.parameter).collect();
        parameters.sort_unstable();
        parameters.dedup();
        // inwards, where there is a bound
        let moved = |k: usize| {
            let (now, step) = (value(&self.model, unknowns[k]), STEP * scales[k]);
            if now + step > self.model.parameters[unknowns[k].parameter].max { -step } else { step }
        };
        let problem = &self.filtered.problem;
        let own = |parameter: usize| unknowns.iter().enumerate().filter(move |(_, u)| u.parameter == parameter);
        let of = |parameter: &usize| {
            let mut model = self.model.clone();
            own(*parameter).for_each(|(k, unknown)| move_by(&mut model, *unknown, moved(k)));
            model
        };
        let models: Vec<Model> = parameters.iter().map(of).collect();
        let late = problem.dynamics.delays();
        let (read, at_once): (Vec<usize>, Vec<usize>) = (0..models.len()).partition(|k| late.contains(&parameters[*k]));
        let costs = |filtered: &Filtered, models: &[Model]| {
            filtered.costs_at(models, &self.noise, &self.mobilities, self.limit)
        };
        let side_by_side: Vec<Model> = at_once.iter().map(|k| models[*k].clone()).collect();
        let mut there: Vec<(usize, Vec<f64>)> = at_once.into_iter().zip(costs(&self.filtered, &side_by_side)).collect();
        // a delay moves what each run reads
        there.par_extend(read.into_par_iter().flat_map_iter(|k| {
            let mut read = self.filtered.clone();
            read_inputs(&mut read.problem, &models[k]);
            costs(&read, &models[k..=k]).into_iter().map(move |there| (k, there))
        }));
        let mut slopes = vec![0.0; unknowns.len()];
        for (parameter, there) in there.into_iter().map(|(k, there)| (parameters[k], there)) {
            let rises = problem.segments.iter().zip(there.iter().zip(&self.current));
            let rises: Vec<(usize, f64)> =
                rises.map(|(s, (there, here))| (problem.tracks[s.track].run, there - here.cost)).collect();
            for (k, unknown) in own(parameter) {
                let of_runs = rises.iter().filter(|(run, _)| unknown.run.is_none_or(|own| own == *run));
                let prior = self.model.parameters[parameter].prior;
                let of_prior = prior.map_or(0.0, |(mean, std)| (value(&self.model, *unknown) - mean) / (std * std));
                let rise: f64 = of_runs.map(|(_, rise)| rise).sum();
                slopes[k] = (0.5 * rise / moved(k) + of_prior) * scales[k];
            }
        }
        slopes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::filter_error::{FilterErrorOptions, Filtered, start};
    use crate::model::Model;
    use crate::run::Run;
    use crate::tank::{BlindOptions, blind};

    /// Runs of a tank, and its model with parameters a fifth off.
    fn sailed() -> (Vec<Run>, Model) {
        let campaign = blind(&BlindOptions { duration: 40.0, ..BlindOptions::default() }).expect("the tank sails");
        let mut model = campaign.truth;
        model.parameters.iter_mut().filter(|p| !p.fixed).for_each(|p| p.value *= 1.2);
        (campaign.runs, model)
    }

    fn search<'a>((runs, model): &(Vec<Run>, Model), options: &'a FilterErrorOptions) -> Search<'a> {
        let filtered = Filtered::new(model, runs, &options.base).expect("the runs are whole");
        let noise = start::noises(&filtered, model, runs, &options.forces).remove(0);
        Search::new(model, filtered, noise, options).expect("it does not run away")
    }

    #[test]
    fn slopes_are_those_of_the_likelihood() {
        let (campaign, options) = (sailed(), FilterErrorOptions::default());
        let search = search(&campaign, &options);
        let unknowns = search.filtered.problem.unknowns.clone();
        let scales = search.scales();
        for (k, slope) in search.parameter_slopes(&unknowns, &scales).into_iter().enumerate() {
            let there = |by: f64| {
                let mut model = search.model.clone();
                move_by(&mut model, unknowns[k], by * scales[k]);
                0.5 * search.linearised(&model, &search.noise).1
            };
            let both_ways = (there(0.01) - there(-0.01)) / 0.02;
            // half of the curvature, 1 by the scale, over the step to one side; and as much of the larger one
            assert!((slope - both_ways).abs() < 2.0 * STEP + 1e-3 * slope.abs(), "{k}: {slope} {both_ways}");
        }
    }

    #[test]
    fn steps_together_end_where_steps_in_turns_do() {
        let (campaign, options) = (sailed(), FilterErrorOptions::default());
        let (mut turns, mut together) = (search(&campaign, &options), search(&campaign, &options));
        assert!(turns.climb(options.tolerance));
        assert!(together.climb_together(options.tolerance));
        // both promise less than the tolerance; a gain held in the rows is worth a few of it
        assert!((turns.cost - together.cost).abs() < 10.0 * options.tolerance, "{} {}", turns.cost, together.cost);
        let unknowns = &turns.filtered.problem.unknowns;
        let off = |u: &Unknown| value(&turns.model, *u) - value(&together.model, *u);
        let off: Vec<f64> = unknowns.iter().map(off).collect();
        let factor = turns.filtered.factor(&turns.model, &turns.current);
        let row = |i: usize| (i..off.len()).map(|j| factor.at(i, j)[0] * off[j]).sum::<f64>();
        let deviations = (0..off.len()).map(|i| row(i).powi(2)).sum::<f64>().sqrt();
        // a tenth is what the likelihoods may differ by, and its root what the parameters may
        assert!(deviations < 0.32, "{deviations}");
    }
}
