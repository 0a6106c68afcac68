//! Outliers: innovations that come from a fault of a sensor and not from a push.
//!
//! ```text
//! ℓ_j: line through the samples k − j and k + j, at the instant of k;    d_j = y_k − ℓ_j,    j = 1, 2, 3
//! wild:   |e_k| > 5 √s   and, for one j,   d_j/e_k ≥ ¾   and   |d_j| > 7 median |d_j|
//!         (median: of the channel in this stretch)
//! ```
//!
//! Gaussian noise makes no innovation of five standard deviations in any log, but a model that
//! lacks a force does, again and again. If these innovations are held back, the filter stays behind
//! a vehicle that has gone elsewhere. That is tried all the same, because a single push is not part
//! of the model either; it is taken back if the fit does not converge, or if a density with such
//! tails is not more likely than the Gaussian. A wild sample differs from its neighbours by all of
//! its innovation; a push also moves the samples after it, so that the sample differs by half of it
//! at most.

use super::likelihood::Innovations;
use super::problem::Filtered;
use super::tails::OUTLIER;
use crate::simulate::{nearest_turn, quantile};

/// Number of samples compared on each side: a burst may be as long.
const APART: usize = 3;

/// Least share of its innovation by which a wild sample differs from its neighbours: between the
/// whole, and the half that a push leaves.
const ALL: f64 = 0.75;

/// Multiple of the median distance by which a wild sample is off its neighbours; in Gaussian noise,
/// three samples in a million are. Each wild sample changes three distances, and a sixth of all
/// samples may be wild.
const TIMES: f64 = 7.0;

impl Filtered {
    /// Number of wild samples among those whose `innovations`, by stretch and output, are beyond
    /// five standard deviations.
    pub(super) fn wild_samples(&self, innovations: &[Vec<Innovations>]) -> usize {
        let problem = &self.problem;
        let outputs = &problem.dynamics.outputs;
        let mut wild = 0;
        for (stretch, innovations) in problem.segments.iter().zip(innovations) {
            let track = &problem.tracks[stretch.track];
            for (output, of) in innovations.iter().enumerate().filter(|(_, of)| of.is_far()) {
                let turns = matches!(outputs[output].as_str(), "phi" | "psi");
                let at = |row: usize| (track.time[row], track.observed[row * outputs.len() + output]);
                let samples: Vec<(f64, f64)> =
                    (stretch.first..=stretch.last).map(at).filter(|(_, y)| !y.is_nan()).collect();
                wild += among(&samples, of, turns);
            }
        }
        wild
    }
}

impl Innovations {
    /// Whether one of them is beyond five standard deviations.
    fn is_far(&self) -> bool {
        self.z.iter().any(|z| z.abs() > OUTLIER)
    }
}

/// Number of wild ones among the `samples` of one channel, each a time and a value; `turns` for
/// angles that are known up to whole turns.
fn among(samples: &[(f64, f64)], of: &Innovations, turns: bool) -> usize {
    debug_assert_eq!(samples.len(), of.z.len());
    let off = |k: usize, j: usize| -> Option<f64> {
        let ((t0, y0), (t, y), (t1, y1)) = (*samples.get(k.checked_sub(j)?)?, samples[k], *samples.get(k + j)?);
        let (before, after) = (nearest_turn(y - y0, turns), nearest_turn(y - y1, turns));
        Some(before + (after - before) * (t - t0) / (t1 - t0))
    };
    let usual: Vec<f64> = (1..=APART)
        .map(|j| {
            let sizes: Vec<f64> = (0..samples.len()).filter_map(|k| Some(off(k, j)?.abs())).collect();
            if sizes.is_empty() { f64::INFINITY } else { quantile(&sizes, 0.5) }
        })
        .collect();
    let is_wild = |k: &usize| {
        of.z[*k].abs() > OUTLIER
            && (1..=APART).any(|j| off(*k, j).is_some_and(|d| d / of.e[*k] >= ALL && d.abs() > TIMES * usual[j - 1]))
    };
    (0..samples.len().min(of.z.len())).filter(is_wild).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// Number of wild samples among 300 of a heading at 10 Hz about ±π, whose innovations are
    /// noise, `spikes` and `pushes`.
    fn channel(spikes: &[(usize, f64)], pushes: &[(usize, f64)]) -> usize {
        let (mut noise, std) = (Noise::new(3, 1), 0.01);
        let (mut samples, mut e, mut pushed) = (Vec::new(), Vec::new(), 0.0);
        for k in 0..300 {
            let t = 0.1 * f64::from(k as u32);
            let here = |of: &[(usize, f64)]| of.iter().filter(|(at, _)| *at == k).map(|(_, by)| by).sum::<f64>();
            let push = here(pushes);
            pushed += push;
            let error = std * noise.normal() + here(spikes);
            samples.push((t, nearest_turn(3.0 + 0.2 * (0.5 * t).sin() + pushed + error, true)));
            e.push(error + push);
        }
        let z = e.iter().map(|e| e / std).collect();
        among(&samples, &Innovations { z, e, expected: 0.0 }, true)
    }

    #[test]
    fn a_wild_sample_is_an_outlier_and_a_push_is_none() {
        assert_eq!(channel(&[], &[]), 0);
        assert_eq!(channel(&[(60, 0.3), (200, -0.2)], &[]), 2);
        let burst = [(60, 0.3), (61, 0.3), (62, 0.3)];
        assert!(channel(&burst, &[]) > 0, "of a burst, too");
        let pushes: Vec<(usize, f64)> = (0..20).map(|k| (10 + 14 * k, if k % 2 == 0 { 0.4 } else { -0.4 })).collect();
        assert_eq!(channel(&[], &pushes), 0, "a push moves those after it, too");
        assert_eq!(channel(&[(100, 0.3)], &pushes), 1);
    }

    #[test]
    fn first_and_last_samples_have_no_neighbours_to_stand_off() {
        assert_eq!(channel(&[(0, 0.5), (299, 0.5)], &[]), 0);
    }
}
