//! What the scores say: how much a candidate explains, and whether chance could do as well.
//!
//! ```text
//! B = (XᵀX)⁻¹ Xᵀz̃      z⊥ = z̃ − X B         what is left beside a refit of everything in the model
//! S = z⊥ᵀr,  I = z⊥ᵀz⊥,  β = I⁻¹ S,  explained = Sᵀ I⁻¹ S
//! s_c = z⊥ᵀr − I_c β  in cluster c          V = G/(G − k) Σ s_c s_cᵀ
//! F = explained / (k φ),   φ = tr(I⁻¹ V)/k   against F(k, G_eff − k), times the number of probes
//! ```
//!
//! φ is the inflation of the noise that this very candidate sees: 1 for white residuals at the assumed level, more
//! where residuals are correlated or something else is missing. Clusters are segments, short ones joined to stretches of
//! some seconds; G_eff = (Σ tr I_c)²/Σ (tr I_c)²
//! counts those in which the candidate says anything. Liang and Zeger (1986); Bell and McCaffrey (2002).

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::products::{Own, Products};
use super::score::Probe;
use crate::estimate::output_error::Problem;

/// A probe judged.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// Index of the candidate.
    pub candidate: usize,
    /// Index of its probe.
    pub probe: usize,
    /// Estimate of its parameters at the linearisation: all of run 0 first, for parameters per run.
    pub beta: Vec<f64>,
    /// Number of parameters.
    pub parameters: usize,
    /// Fall of the cost, in units of the noise variance.
    pub explained: f64,
    /// Share of its signal that is left beside a refit of the model, 0 to 1.
    pub left: f64,
    /// Inflation of the noise.
    pub inflation: f64,
    /// Probability of as much by chance, corrected for the number of probes.
    pub p_value: f64,
    /// Predicted gain on each run when it is left out, in units of the noise variance.
    pub left_out_gain: Vec<f64>,
    /// Smallest size of the first parameter that this data would have shown, in its unit.
    pub visible: f64,
}

/// Below this share of its signal a candidate cannot be told from what is in the model.
pub const INDISTINGUISHABLE: f64 = 0.003;

/// Judges all probes. `count` is the number of probes that chance had.
pub fn judge(problem: &Problem, own: &[Own], probes: &[Probe]) -> Vec<Evidence> {
    let clusters = clusters(problem);
    let own: Vec<Own> = clusters.iter().map(|c| Own::sum(&own[c.clone()])).collect();
    let tracks: Vec<usize> = clusters.iter().map(|c| problem.segments[c.start].track).collect();
    let base = Base::new(problem, &tracks, &own);
    let count = probes.len() as f64;
    let joined = |probe: &Probe| Probe {
        segments: clusters.iter().map(|c| Products::sum(&probe.segments[c.clone()])).collect(),
        ..*probe
    };
    probes.par_iter().filter_map(|probe| base.judge(&tracks, &own, &joined(probe), count)).collect()
}

/// Length from which on residuals of two stretches are taken as independent, s.
const CLUSTER: f64 = 6.0;

/// Segments that follow one another, joined until they are long enough.
fn clusters(problem: &Problem) -> Vec<Range<usize>> {
    let mut all: Vec<Range<usize>> = Vec::new();
    for (k, segment) in problem.segments.iter().enumerate() {
        let time = &problem.tracks[segment.track].time;
        let joins = |known: &Range<usize>| {
            let first = &problem.segments[known.start];
            first.track == segment.track && time[segment.last] - time[first.first] <= CLUSTER
        };
        match all.last_mut() {
            Some(known) if joins(known) => known.end = k + 1,
            _ => all.push(k..k + 1),
        }
    }
    all
}

/// The model's own information.
struct Base {
    unknowns: usize,
    inverse: DMatrix<f64>,
    columns: Vec<Vec<usize>>,
}

impl Base {
    fn new(problem: &Problem, tracks: &[usize], own: &[Own]) -> Base {
        let p = problem.unknowns.len();
        let columns: Vec<Vec<usize>> = (0..problem.tracks.len()).map(|t| problem.columns_of(t)).collect();
        let mut xx = DMatrix::<f64>::zeros(p, p);
        for (track, own) in tracks.iter().zip(own) {
            let map = &columns[*track];
            for (i, a) in map.iter().enumerate() {
                for (j, b) in map.iter().enumerate() {
                    xx[(*a, *b)] += own.xx[i * map.len() + j];
                }
            }
        }
        Base { unknowns: p, inverse: inverse(&xx), columns }
    }

    fn judge(&self, tracks: &[usize], own: &[Own], probe: &Probe, count: f64) -> Option<Evidence> {
        let runs = self.columns.len();
        let k0 = probe.segments.first()?.zr.len();
        let k = if probe.per_run { k0 * runs } else { k0 };
        let spread = |track: usize, products: &Products| {
            Wide::new(products, probe.per_run, track, k0, k, &self.columns[track], self.unknowns)
        };
        let wide: Vec<Wide> =
            tracks.iter().zip(&probe.segments).map(|(track, products)| spread(*track, products)).collect();
        let sum = |f: &dyn Fn(&Wide) -> &DMatrix<f64>, rows, columns| {
            wide.iter().fold(DMatrix::<f64>::zeros(rows, columns), |total, w| total + f(w))
        };
        let xz = sum(&|w| &w.xz, self.unknowns, k);
        let b = &self.inverse * &xz;
        let zz = sum(&|w| &w.zz, k, k);
        let information = &zz - xz.transpose() * &b;
        let raw: f64 = probe.segments.iter().flat_map(|s| s.raw.iter()).sum();
        let left = (information.trace().max(0.0) / raw.max(f64::MIN_POSITIVE)).sqrt();
        if left.is_nan() || left <= INDISTINGUISHABLE {
            return None;
        }
        let info_inverse = inverse(&information);
        let gradients: Vec<DVector<f64>> = wide
            .iter()
            .zip(own)
            .zip(tracks)
            .map(|((w, own), track)| {
                let mut xr = DVector::<f64>::zeros(self.unknowns);
                for (i, column) in self.columns[*track].iter().enumerate() {
                    xr[*column] += own.xr[i];
                }
                &w.zr - b.transpose() * xr
            })
            .collect();
        let score = gradients.iter().fold(DVector::<f64>::zeros(k), |total, g| total + g);
        let beta = &info_inverse * &score;
        let explained = score.dot(&beta).max(0.0);
        let shares: Vec<DMatrix<f64>> = wide
            .iter()
            .zip(own)
            .zip(tracks)
            .map(|((w, own), track)| {
                let map = &self.columns[*track];
                let mut xx = DMatrix::<f64>::zeros(self.unknowns, self.unknowns);
                for (i, a) in map.iter().enumerate() {
                    for (j, c) in map.iter().enumerate() {
                        xx[(*a, *c)] += own.xx[i * map.len() + j];
                    }
                }
                let cross = w.xz.transpose() * &b;
                &w.zz - &cross - cross.transpose() + b.transpose() * xx * &b
            })
            .collect();
        let weights: Vec<f64> = shares.iter().map(|i| (&info_inverse * i).trace().max(0.0)).collect();
        let total: f64 = weights.iter().sum();
        let effective = total * total / weights.iter().map(|w| w * w).sum::<f64>().max(f64::MIN_POSITIVE);
        let clusters = wide.len() as f64;
        let mut v = DMatrix::<f64>::zeros(k, k);
        for (gradient, share) in gradients.iter().zip(&shares) {
            let s = gradient - share * &beta;
            v += &s * s.transpose();
        }
        let spare = effective - k as f64;
        let correction = if spare > 1.0 { effective / spare } else { effective.max(1.0) };
        let inflation = ((&info_inverse * v).trace() / k as f64 * correction.min(clusters)).max(0.7);
        let f = explained / (k as f64 * inflation);
        let chance = FisherSnedecor::new(k as f64, spare.max(1.0)).map_or(1.0, |d| d.sf(f));
        let left_out_gain = left_out(tracks, &gradients, &shares, &information, &score, runs, probe.per_run);
        // visible: five standard deviations, which is where the corrected test is all but sure to see it
        let visible = 5.0 * (info_inverse[(0, 0)].max(0.0) * inflation).sqrt();
        Some(Evidence {
            candidate: probe.candidate,
            probe: probe.probe,
            beta: beta.iter().copied().collect(),
            parameters: k,
            explained,
            left,
            inflation,
            p_value: (chance * count).min(1.0),
            left_out_gain,
            visible,
        })
    }
}

/// Products of one segment in the columns of all unknowns and all runs.
struct Wide {
    zz: DMatrix<f64>,
    zr: DVector<f64>,
    xz: DMatrix<f64>,
}

impl Wide {
    fn new(
        products: &Products,
        per_run: bool,
        track: usize,
        k0: usize,
        k: usize,
        columns: &[usize],
        unknowns: usize,
    ) -> Wide {
        let offset = if per_run { track * k0 } else { 0 };
        let (mut zz, mut zr) = (DMatrix::<f64>::zeros(k, k), DVector::<f64>::zeros(k));
        let mut xz = DMatrix::<f64>::zeros(unknowns, k);
        for a in 0..k0 {
            zr[offset + a] = products.zr[a];
            for b in 0..k0 {
                zz[(offset + a, offset + b)] = products.zz[a * k0 + b];
            }
            for (i, column) in columns.iter().enumerate() {
                xz[(*column, offset + a)] += products.xz[i * k0 + a];
            }
        }
        Wide { zz, zr, xz }
    }
}

/// Gain on each run when the candidate is estimated on the others: 2βᵀS_r − βᵀI_rβ with β = (I − I_r)⁻¹(S − S_r).
fn left_out(
    tracks: &[usize],
    gradients: &[DVector<f64>],
    shares: &[DMatrix<f64>],
    information: &DMatrix<f64>,
    score: &DVector<f64>,
    runs: usize,
    per_run: bool,
) -> Vec<f64> {
    if per_run || runs < 2 {
        return Vec::new();
    }
    let k = score.len();
    (0..runs)
        .map(|run| {
            let mut s = DVector::<f64>::zeros(k);
            let mut i = DMatrix::<f64>::zeros(k, k);
            for ((track, gradient), share) in tracks.iter().zip(gradients).zip(shares) {
                if *track == run {
                    s += gradient;
                    i += share;
                }
            }
            let beta = inverse(&(information - &i)) * (score - &s);
            2.0 * beta.dot(&s) - (beta.transpose() * i * &beta)[(0, 0)]
        })
        .collect()
}

/// Inverse of a symmetric positive matrix, scaled to a unit diagonal first; what has no information gets 0.
fn inverse(a: &DMatrix<f64>) -> DMatrix<f64> {
    let n = a.nrows();
    let scale: Vec<f64> = (0..n).map(|i| if a[(i, i)] > 0.0 { 1.0 / a[(i, i)].sqrt() } else { 0.0 }).collect();
    let mut scaled = DMatrix::<f64>::from_fn(n, n, |i, j| a[(i, j)] * scale[i] * scale[j]);
    for i in 0..n {
        // a relative ridge at the level of rounding keeps the factorisation going on exact ties
        scaled[(i, i)] = if scale[i] > 0.0 { scaled[(i, i)] + 1e-11 } else { 1.0 };
    }
    match scaled.cholesky() {
        Some(factor) => {
            let inverse = factor.inverse();
            DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j])
        }
        None => DMatrix::zeros(n, n),
    }
}
