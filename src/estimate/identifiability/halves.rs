//! Whether the two halves of the record agree.
//!
//! ```text
//! θ_h = θ − R_h⁻¹ r_h       one Gauss-Newton step on the segments of one half of each run
//! z = (θ₁ − θ₂)/√(σ₁² + σ₂²)
//! ```
//!
//! A parameter that drifts in the course of the runs (a battery, a tether, a wet vehicle), or
//! stands in for an effect that the model lacks, differs between the halves by more than its
//! standard deviation. The step needs no further fit.

use statrs::distribution::{ContinuousCDF, Normal};

use crate::estimate::output_error::StdMethod;
use crate::estimate::output_error::{
    Fold, Linearised, OutputErrorFit, Problem, normal_factor, normal_factor_where, value,
};
use crate::simulate::{Stretch, Track};

/// Estimates from the halves of each run, by unknown.
#[derive(Debug, Clone, PartialEq)]
pub struct Halves {
    /// From the first halves.
    pub first: Vec<f64>,
    /// From the second halves.
    pub second: Vec<f64>,
    /// Their difference over its standard deviation.
    pub z: Vec<f64>,
    /// |z| that chance exceeds in one of a hundred fits, over all unknowns together.
    pub limit: f64,
}

/// Estimates from the halves of each run; `None` if one half does not determine all unknowns.
pub fn halves(fit: &OutputErrorFit) -> Option<Halves> {
    let (problem, linearised) = cut(fit);
    let p = problem.unknowns.len();
    let second_half = |s: usize| {
        let stretch = &problem.segments[s];
        let track = &problem.tracks[stretch.track];
        stretch.first >= middle(track)
    };
    let whole = deviations(&normal_factor(&fit.problem, &fit.model, &fit.linearised), p)?;
    // standard deviations are widened in the same proportion as those of the whole fit, so that they
    // hold for correlated residuals too. The widening of few clusters is not used: a parameter that
    // changes between the halves widens all of them
    let wider: Vec<f64> = (0..p)
        .map(|k| match fit.std_method {
            StdMethod::FewClusters => fit.white_scale().sqrt(),
            _ => fit.covariance[k * p + k].sqrt() / whole[k],
        })
        .collect();
    let half = |second: bool| {
        let factor = normal_factor_where(&problem, &fit.model, &linearised, |s| second_half(s) == second);
        let std = deviations(&factor, p)?;
        let step = factor.solve();
        let values: Vec<f64> = (0..p).map(|k| value(&fit.model, problem.unknowns[k]) - step[k]).collect();
        Some((values, std))
    };
    let ((first, s1), (second, s2)) = (half(false)?, half(true)?);
    let z = (0..p).map(|k| (first[k] - second[k]) / (wider[k] * s1[k].hypot(s2[k]))).collect();
    let limit = Normal::standard().inverse_cdf(1.0 - 0.01 / (2.0 * p as f64));
    Some(Halves { first, second, z, limit })
}

/// Grid point in the middle of a run.
fn middle(track: &Track) -> usize {
    let (begin, end) = (track.time[0], track.time[track.time.len() - 1]);
    track.time.partition_point(|t| *t < 0.5 * (begin + end))
}

/// The fit with segments that span the middle of their run cut there.
fn cut(fit: &OutputErrorFit) -> (Problem, Vec<Linearised>) {
    let mut problem = fit.problem.clone();
    let (mut segments, mut kept) = (Vec::new(), Vec::new());
    for (stretch, x0) in fit.problem.segments.iter().zip(&fit.initial_states) {
        let k = middle(&problem.tracks[stretch.track]);
        kept.push(Some(x0.clone()));
        // a segment has at least two grid points
        if stretch.first + 2 <= k && k < stretch.last {
            segments.extend([Stretch { last: k - 1, ..*stretch }, Stretch { first: k, ..*stretch }]);
            kept.push(None);
        } else {
            segments.push(*stretch);
        }
    }
    if segments.len() == fit.problem.segments.len() {
        return (problem, fit.linearised.clone());
    }
    problem.segments = segments;
    let logged = problem.initial_states(&fit.model);
    let x0: Vec<Vec<f64>> = kept.into_iter().zip(logged).map(|(kept, logged)| kept.unwrap_or(logged)).collect();
    let linearised = problem.linearise(&fit.model, &x0);
    (problem, linearised)
}

/// √ of the diagonal of (RᵀR)⁻¹; `None` if a direction is not determined.
fn deviations(factor: &Fold<1>, p: usize) -> Option<Vec<f64>> {
    let weak = |k: usize| {
        let length = (0..=k).map(|i| factor.at(i, k)[0].powi(2)).sum::<f64>().sqrt();
        factor.at(k, k)[0].abs() <= 1e-9 * length
    };
    if p == 0 || (0..p).any(weak) {
        return None;
    }
    let inverse = factor.inverse(p)?;
    Some((0..p).map(|k| inverse[k * p..(k + 1) * p].iter().map(|x| x * x).sum::<f64>().sqrt()).collect())
}
