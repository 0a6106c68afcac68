//! Slope and curvature of the likelihood by finite differences, with the gain of the filter
//! computed anew at each point.
//!
//! ```text
//! g_j  ≈ (f(x + h_j) − f(x))/h − h H_jj/2                              f = −ln L,   x = (θ/s, ln η)
//! H_jk ≈ (f(x + h_j + h_k) − f(x + h_j) − f(x + h_k) + f(x))/h²
//! s: standard deviation of a parameter with the others fixed
//! ```
//!
//! All points are filtered side by side. A parameter with a value per run is moved in all runs at
//! once.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::Filtered;
use super::noise::{Coordinate, NoiseModel};
use super::start::Prior;
use super::steps::Search;
use crate::estimate::output_error::{Unknown, move_by, read_inputs, value};
use crate::model::Model;

/// The unknown parameters, and the unknowns of the noise if these move as well.
pub(super) struct Joint {
    pub unknowns: Vec<Unknown>,
    pub coordinates: Vec<Coordinate>,
    /// Standard deviation of each parameter with the others fixed.
    pub scales: Vec<f64>,
    /// Step of a difference: in standard deviations of a parameter, and in a logarithm of the
    /// noise.
    step: f64,
    /// Side to which each unknown is moved, +1 or −1: away from an upper bound.
    side: Vec<f64>,
    /// Unknowns that move at once: one parameter in all runs, or one logarithm of the noise.
    directions: Vec<Vec<usize>>,
}

impl Joint {
    /// Moves unknown `k` by `x`.
    pub fn go(&self, k: usize, x: f64, (model, noise): (&mut Model, &mut NoiseModel)) {
        match self.unknowns.get(k) {
            Some(unknown) => move_by(model, *unknown, x * self.scales[k]),
            None => {
                let coordinate = self.coordinates[k - self.unknowns.len()];
                noise.set(coordinate, noise.at(coordinate) + x);
            }
        }
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        self.side.len()
    }
}

impl Filtered {
    /// −2 ln L of each stretch at each of `points`. The points are filtered side by side, because
    /// few stretches alone would leave most lanes idle. Delayed inputs are read once for all points
    /// with the same delays; for the delays of `here` they have been read already.
    pub(super) fn costs_side_by_side(
        &self,
        here: &Model,
        points: &[(Model, NoiseModel)],
        mobilities: &[DMatrix<f64>],
        limit: f64,
    ) -> Vec<Vec<f64>> {
        let late = self.problem.dynamics.delays();
        let delays = |model: &Model| -> Vec<u64> {
            let of = |p: &usize| std::iter::once(&model.parameters[*p].value).chain(&model.parameters[*p].per_run);
            late.iter().flat_map(of).map(|delay| delay.to_bits()).collect()
        };
        let mut alike: BTreeMap<Vec<u64>, Vec<usize>> = BTreeMap::new();
        points.iter().enumerate().for_each(|(k, (model, _))| alike.entry(delays(model)).or_default().push(k));
        let here = delays(here);
        let of = |(delays, members): (Vec<u64>, Vec<usize>)| {
            let own: Vec<&(Model, NoiseModel)> = members.iter().map(|k| &points[*k]).collect();
            let costs = |filtered: &Filtered| filtered.costs_at(&own, mobilities, limit);
            let costs = if delays == here {
                costs(self)
            } else {
                let mut read = self.clone();
                read_inputs(&mut read.problem, &own[0].0);
                costs(&read)
            };
            members.into_iter().zip(costs).collect::<Vec<_>>()
        };
        let mut all: Vec<(usize, Vec<f64>)> = alike.into_par_iter().flat_map_iter(of).collect();
        all.sort_by_key(|(k, _)| *k);
        all.into_iter().map(|(_, costs)| costs).collect()
    }
}

impl Search<'_> {
    /// −2 ln L of each stretch at each of `points`.
    pub(super) fn costs_side_by_side(&self, points: &[(Model, NoiseModel)]) -> Vec<Vec<f64>> {
        self.filtered.costs_side_by_side(&self.model, points, &self.mobilities, self.limit)
    }

    /// Standard deviation of each parameter with the others fixed.
    pub(super) fn scales(&self) -> Vec<f64> {
        let factor = self.filtered.factor(&self.model, &self.current);
        let of = |k: usize| (0..=k).map(|i| factor.at(i, k)[0].powi(2)).sum::<f64>().sqrt();
        (0..self.filtered.problem.unknowns.len()).map(|k| 1.0 / of(k).max(f64::MIN_POSITIVE)).collect()
    }

    /// The unknowns at the current point, with `coordinates` of the noise, and the step of
    /// differences by them.
    pub(super) fn joint(&self, coordinates: Vec<Coordinate>, step: f64) -> Joint {
        let unknowns = self.filtered.problem.unknowns.clone();
        let (scales, p) = (self.scales(), unknowns.len());
        let side = |k: usize| {
            let farther = value(&self.model, unknowns[k]) + 2.0 * step * scales[k];
            if farther > self.model.parameters[unknowns[k].parameter].max { -1.0 } else { 1.0 }
        };
        let side = (0..p).map(side).chain(coordinates.iter().map(|_| 1.0)).collect();
        let mut parameters: Vec<usize> = unknowns.iter().map(|u| u.parameter).collect();
        parameters.sort_unstable();
        parameters.dedup();
        let of = |parameter: usize| (0..p).filter(|k| unknowns[*k].parameter == parameter).collect::<Vec<usize>>();
        let directions = parameters.into_iter().map(of).chain((p..p + coordinates.len()).map(|k| vec![k])).collect();
        Joint { unknowns, coordinates, scales, step, side, directions }
    }

    /// Slope of −ln L, priors included, and its curvature without priors; `known` is that curvature
    /// if it is known.
    pub(super) fn differences(&mut self, joint: &Joint, known: Option<DMatrix<f64>>) -> (DVector<f64>, DMatrix<f64>) {
        let (m, step) = (joint.directions.len(), joint.step);
        let pairs: Vec<(usize, usize)> =
            if known.is_none() { (0..m).flat_map(|a| (0..=a).map(move |b| (a, b))).collect() } else { Vec::new() };
        let point = |directions: &[usize]| {
            let (mut model, mut noise) = (self.model.clone(), self.noise.clone());
            for k in directions.iter().flat_map(|d| &joint.directions[*d]) {
                joint.go(*k, step * joint.side[*k], (&mut model, &mut noise));
            }
            (model, noise)
        };
        let points: Vec<(Model, NoiseModel)> =
            (0..m).map(|a| point(&[a])).chain(pairs.iter().map(|(a, b)| point(&[*a, *b]))).collect();
        let there = self.costs_side_by_side(&points);
        let (once, twice) = there.split_at(m);
        let problem = &self.filtered.problem;
        let counts = |k: usize, stretch: usize| {
            let run = joint.unknowns.get(k).and_then(|u| u.run);
            run.is_none_or(|run| run == problem.tracks[problem.segments[stretch].track].run)
        };
        let here: Vec<f64> = self.current.iter().map(|s| s.cost).collect();
        let mut curvature = known.unwrap_or_else(|| DMatrix::zeros(joint.len(), joint.len()));
        for ((a, b), both) in pairs.iter().zip(twice) {
            for (i, j) in joint.directions[*a].iter().flat_map(|i| joint.directions[*b].iter().map(move |j| (*i, *j))) {
                if a == b && i != j {
                    continue;
                }
                let bent = |s: usize| both[s] - once[*a][s] - once[*b][s] + here[s];
                let sum: f64 = (0..here.len()).filter(|s| counts(i, *s) && counts(j, *s)).map(bent).sum();
                curvature[(i, j)] = 0.5 * sum / (step * step * joint.side[i] * joint.side[j]);
                curvature[(j, i)] = curvature[(i, j)];
            }
        }
        let mut gradient = DVector::zeros(joint.len());
        for (costs, direction) in once.iter().zip(&joint.directions) {
            for &k in direction {
                let rise: f64 = (0..here.len()).filter(|s| counts(k, *s)).map(|s| costs[s] - here[s]).sum();
                gradient[k] = 0.5 * (rise / step - step * curvature[(k, k)]) * joint.side[k];
            }
        }
        self.passes += points.len().div_ceil(m.max(1));
        self.priors(joint).into_iter().enumerate().for_each(|(k, (slope, _))| gradient[k] += slope);
        (gradient, curvature)
    }

    /// Slope and curvature of the priors by each unknown.
    pub(super) fn priors(&self, joint: &Joint) -> Vec<(f64, f64)> {
        let of_parameters = joint.unknowns.iter().zip(&joint.scales).map(|(unknown, scale)| {
            let prior = self.model.parameters[unknown.parameter].prior;
            prior.map_or((0.0, 0.0), |(mean, std)| {
                let off = (value(&self.model, *unknown) - mean) / std;
                (off * scale / std, (scale / std).powi(2))
            })
        });
        let of_noise = Prior::new(&joint.coordinates, &self.stated).of;
        let of_noise = of_noise.into_iter().zip(&joint.coordinates).map(|(of, c)| {
            of.map_or((0.0, 0.0), |(mean, std)| ((self.noise.at(*c) - mean) / (std * std), 1.0 / (std * std)))
        });
        of_parameters.chain(of_noise).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::filter_error::FilterErrorOptions;
    use crate::estimate::filter_error::tests::{sailed, search};

    #[test]
    fn slopes_are_those_of_the_likelihood() {
        let (campaign, options) = (sailed(), FilterErrorOptions::default());
        let mut search = search(&campaign, &options);
        let step = 1e-3;
        let joint = search.joint(Vec::new(), step);
        let (slopes, _) = search.differences(&joint, Some(DMatrix::identity(joint.len(), joint.len())));
        for (k, slope) in slopes.iter().enumerate() {
            let there = |by: f64| {
                let mut model = search.model.clone();
                move_by(&mut model, joint.unknowns[k], by * joint.scales[k]);
                0.5 * search.linearised(&model, &search.noise).1
            };
            let both_ways = (there(0.01) - there(-0.01)) / 0.02;
            // allowed: two steps, because a one-sided difference is corrected by half of a
            // curvature that is taken as 1 by the scale, and a thousandth of the slope
            assert!((slope - both_ways).abs() < 2.0 * step + 1e-3 * slope.abs(), "{k}: {slope} {both_ways}");
        }
    }

    /// Slopes by the parameters are compared with central differences, those by the noise with the
    /// backward pass through the filter.
    #[test]
    fn slopes_with_their_own_curvature_are_those_of_the_likelihood() {
        let (campaign, options) = (sailed(), FilterErrorOptions::default());
        let mut search = search(&campaign, &options);
        let joint = search.joint(search.coordinates(), 1e-2);
        let (gradient, curvature) = search.differences(&joint, None);
        let (again, kept) = search.differences(&joint, Some(curvature.clone()));
        assert!(gradient == again && curvature == kept);
        let most = |k: usize| 1e-2 * curvature[(k, k)].abs().max(1.0);
        for k in 0..joint.unknowns.len() {
            let there = |by: f64| {
                let (mut model, mut noise) = (search.model.clone(), search.noise.clone());
                joint.go(k, by, (&mut model, &mut noise));
                0.5 * search.linearised(&model, &noise).1
            };
            let both_ways = (there(0.01) - there(-0.01)) / 0.02;
            let bent = (there(0.01) - 2.0 * there(0.0) + there(-0.01)) / 1e-4;
            // allowed: the third derivative over a hundredth of a standard deviation, taken as a
            // hundredth of the curvature
            assert!((gradient[k] - both_ways).abs() < most(k), "{k}: {} {both_ways}", gradient[k]);
            assert!((curvature[(k, k)] - bent).abs() < 5.0 * most(k), "{k}: {} {bent}", curvature[(k, k)]);
        }
        let of_noise = search.renew_with_slopes(&joint.coordinates);
        let priors = search.priors(&joint);
        for (at, slope) in (joint.unknowns.len()..).zip(of_noise) {
            assert!((gradient[at] - slope - priors[at].0).abs() < most(at), "{at}: {} {slope}", gradient[at]);
        }
    }
}
