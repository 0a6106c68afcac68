//! Slopes of the likelihood by the parameters, the gain of the filter following.
//!
//! ```text
//! ∂(−ln L)/∂θ ≈ (−ln L(θ + h) + ln L(θ))/h − h/(2 s²)        h = s/1000,  s: a parameter's deviation beside the others
//! Rᵀ d = ∂(−ln L)/∂θ                                         d: the right-hand side that the rows should have had
//! ```
//!
//! The rows of a Gauss-Newton step hold the gain. Where a model follows its data badly, or a heading turns much of what is believed,
//! their slope leads to places where the likelihood does not rise although it could. The difference to the slope of the likelihood
//! itself moves slowly from step to step, so it is taken where a step has failed, and kept.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::Filtered;
use super::noise::NoiseModel;
use super::noise_steps::NEAR_TOP;
use super::steps::Search;
use crate::estimate::output_error::{Fold, Unknown, move_by, read_inputs, value};
use crate::model::Model;

/// Deviation over which a slope by a parameter is taken: its square does not show, and roundings of ln L do not either.
pub(super) const STEP: f64 = 1e-3;

/// Fall of −2 ln L that a whole step of the parameters promises at most for its slopes to be taken anew where it has led down: a few
/// deviations of each. Farther off the quadratic ends before the gain that is held counts.
const WORTH_MENDING: f64 = 300.0;

/// What the slopes of the likelihood have more than those of the rows, by unknown.
#[derive(Debug, Clone)]
pub(super) struct Mended {
    more: Vec<f64>,
    /// Whether they are those of here.
    pub fresh: bool,
}

impl Mended {
    /// The factor with the right-hand side that has these slopes as well; unknowns without information keep theirs.
    fn of(&self, factor: &Fold<1>) -> Fold<1> {
        let p = self.more.len();
        let mut right = vec![0.0; p];
        for i in 0..p {
            let pivot = factor.at(i, i)[0];
            let sum: f64 = (0..i).map(|j| factor.at(j, i)[0] * right[j]).sum();
            right[i] = if pivot == 0.0 { 0.0 } else { (self.more[i] - sum) / pivot };
        }
        let mut mended = factor.clone();
        right.into_iter().enumerate().for_each(|(i, more)| mended.add(i, p, more));
        mended
    }
}

impl Search<'_> {
    /// Factor of the information here, its last column as what is known of the slopes has it.
    pub(super) fn mended_factor(&self) -> Fold<1> {
        let factor = self.filtered.factor(&self.model, &self.current);
        self.mended.as_ref().map_or_else(|| factor.clone(), |mended| mended.of(&factor))
    }

    /// −2 ln L of each stretch at each of `points`: few stretches alone would leave most lanes idle. What delays read is read for
    /// all points of like delays at once.
    pub(super) fn costs_side_by_side(&self, points: &[(Model, NoiseModel)]) -> Vec<Vec<f64>> {
        let late = self.filtered.problem.dynamics.delays();
        let delays = |model: &Model| -> Vec<u64> {
            let of = |p: &usize| std::iter::once(&model.parameters[*p].value).chain(&model.parameters[*p].per_run);
            late.iter().flat_map(of).map(|delay| delay.to_bits()).collect()
        };
        let mut alike: BTreeMap<Vec<u64>, Vec<usize>> = BTreeMap::new();
        points.iter().enumerate().for_each(|(k, (model, _))| alike.entry(delays(model)).or_default().push(k));
        let here = delays(&self.model);
        let of = |(delays, members): (Vec<u64>, Vec<usize>)| {
            let own: Vec<&(Model, NoiseModel)> = members.iter().map(|k| &points[*k]).collect();
            let costs = |filtered: &Filtered| filtered.costs_at(&own, &self.mobilities, self.limit);
            let costs = if delays == here {
                costs(&self.filtered)
            } else {
                let mut read = self.filtered.clone();
                read_inputs(&mut read.problem, &own[0].0);
                costs(&read)
            };
            members.into_iter().zip(costs).collect::<Vec<_>>()
        };
        let mut all: Vec<(usize, Vec<f64>)> = alike.into_par_iter().flat_map_iter(of).collect();
        all.sort_by_key(|(k, _)| *k);
        all.into_iter().map(|(_, costs)| costs).collect()
    }

    /// Takes the slopes of the likelihood here.
    pub(super) fn mend(&mut self) {
        let unknowns = self.filtered.problem.unknowns.clone();
        let factor = self.filtered.factor(&self.model, &self.current);
        let (p, scales) = (unknowns.len(), self.scales());
        let of_rows = |k: usize| (0..=k).map(|i| factor.at(i, k)[0] * factor.at(i, p)[0]).sum::<f64>();
        let slopes = self.parameter_slopes(&unknowns, &scales);
        let more = (0..p).map(|k| slopes[k] / scales[k] - of_rows(k)).collect();
        self.mended = Some(Mended { more, fresh: true });
        self.passes += 1;
    }

    /// What is done about the slopes once they have led to where the likelihood is lower: near the top they are taken anew. Far
    /// off, where the quadratic ends or the noise is still to change, those of the rows lead farther than what was once taken.
    /// Whether they have changed.
    pub(super) fn mends(&mut self) -> bool {
        if !self.to_the_top() || self.mended.as_ref().is_some_and(|mended| mended.fresh) {
            return false;
        }
        let far = self.mended.take().is_some();
        let promised = self.promised();
        let near = self.noise_moves < NEAR_TOP && (self.tolerance..WORTH_MENDING).contains(&promised);
        if near {
            self.mend();
        }
        near || far
    }

    /// Deviation of each parameter beside the others as they are.
    pub(super) fn scales(&self) -> Vec<f64> {
        let factor = self.filtered.factor(&self.model, &self.current);
        let of = |k: usize| (0..=k).map(|i| factor.at(i, k)[0].powi(2)).sum::<f64>().sqrt();
        (0..self.filtered.problem.unknowns.len()).map(|k| 1.0 / of(k).max(f64::MIN_POSITIVE)).collect()
    }

    /// Slopes of −ln L by the parameters over `scales`, priors included: of one that each run has of its own, all runs at once.
    /// Half of what the curvature adds over a step, 1 by the scale, is taken off.
    pub(super) fn parameter_slopes(&self, unknowns: &[Unknown], scales: &[f64]) -> Vec<f64> {
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
        let points: Vec<(Model, NoiseModel)> = parameters.iter().map(|p| (of(p), self.noise.clone())).collect();
        let there = self.costs_side_by_side(&points);
        let mut slopes = vec![0.0; unknowns.len()];
        for (parameter, there) in parameters.iter().copied().zip(there) {
            let rises = problem.segments.iter().zip(there.iter().zip(&self.current));
            let rises: Vec<(usize, f64)> =
                rises.map(|(s, (there, here))| (problem.tracks[s.track].run, there - here.cost)).collect();
            for (k, unknown) in own(parameter) {
                let of_runs = rises.iter().filter(|(run, _)| unknown.run.is_none_or(|own| own == *run));
                let prior = self.model.parameters[parameter].prior;
                let of_prior = prior.map_or(0.0, |(mean, std)| (value(&self.model, *unknown) - mean) / (std * std));
                let rise: f64 = of_runs.map(|(_, rise)| rise).sum();
                let curved = 0.5 * moved(k) / scales[k];
                slopes[k] = (0.5 * rise / moved(k) + of_prior) * scales[k] - curved;
            }
        }
        slopes
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::estimate::filter_error::{FilterErrorOptions, filter_error, start};
    use crate::estimate::output_error::damped_step;
    use crate::frame::Dof;
    use crate::run::Run;
    use crate::tank::{BlindOptions, blind};

    /// Runs of a tank, and its model with parameters a fifth off.
    pub fn sailed() -> (Vec<Run>, Model) {
        let campaign = blind(&BlindOptions { duration: 40.0, ..BlindOptions::default() }).expect("the tank sails");
        let mut model = campaign.truth;
        model.parameters.iter_mut().filter(|p| !p.fixed).for_each(|p| p.value *= 1.2);
        (campaign.runs, model)
    }

    /// A search from there.
    pub fn search<'a>((runs, model): &(Vec<Run>, Model), options: &'a FilterErrorOptions) -> Search<'a> {
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

    /// Of fixes and headings alone, and of a model without the drag that grows with the square: on the way its rows, whose gain is
    /// held, lead to where the likelihood does not rise.
    #[test]
    fn a_fit_of_fixes_rests_where_the_likelihood_does() {
        let mut campaign = blind(&BlindOptions { duration: 40.0, ..BlindOptions::default() }).expect("the tank sails");
        campaign
            .runs
            .iter_mut()
            .for_each(|run| run.signals.retain(|name, _| !["u", "v", "r"].contains(&name.as_str())));
        let without: Vec<&str> = vec!["inertia", "linear_drag"];
        let model =
            Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Tied, &without).expect("it is known");
        let options = FilterErrorOptions::default();
        let fit = filter_error(&model, &campaign.runs, &options).expect("the runs determine it");
        assert!(fit.converged);
        let mut search = Search::new(&fit.model, fit.filtered, fit.noise, &options).expect("it does not run away");
        search.limit = fit.limit;
        search.renew();
        search.mend();
        let unknowns = search.filtered.problem.unknowns.clone();
        let (_, promised) = damped_step(&search.mended_factor(), &search.model, &unknowns, 0.0);
        // a tenth of a parameter's deviation
        assert!(promised < 0.1, "{promised}");
    }

    #[test]
    fn a_mended_factor_has_the_slopes_of_the_likelihood_and_the_information_of_the_rows() {
        let (campaign, options) = (sailed(), FilterErrorOptions::default());
        let mut search = search(&campaign, &options);
        let (rows, scales) = (search.mended_factor(), search.scales());
        search.mend();
        let mended = search.mended_factor();
        let unknowns = search.filtered.problem.unknowns.clone();
        let (p, slopes) = (unknowns.len(), search.parameter_slopes(&unknowns, &scales));
        for k in 0..p {
            let slope: f64 = (0..=k).map(|i| mended.at(i, k)[0] * mended.at(i, p)[0]).sum::<f64>() * scales[k];
            // rounding alone: the triangle is of the same numbers
            assert!((slope - slopes[k]).abs() < 1e-9 * slopes[k].abs().max(1.0), "{k}: {slope} {}", slopes[k]);
            assert!((0..=k).all(|i| mended.at(i, k) == rows.at(i, k)));
        }
        assert!((0..p).any(|i| mended.at(i, p) != rows.at(i, p)));
    }
}
