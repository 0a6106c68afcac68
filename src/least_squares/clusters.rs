//! Covariance of estimates with correlated residuals, by clusters: stretches that are independent
//! of each other.
//!
//! ```text
//! s_c = (HᵀH)⁻¹ g_c,   g_c: Hᵀe summed over cluster c,   f: such as C/(C − 1) n/(n − p)
//!
//! many:  Σ = f Σ_c s_c s_cᵀ
//! few:   Σ = D W D κ                              κ = max(1, f/p Σ_c s_cᵀ W⁻¹ s_c)
//!        Dᵢᵢ² = max(1, f Σ_c s_cᵢ² / (κ Wᵢᵢ))
//! ```
//!
//! W is the covariance for white residuals. The first form (Liang and Zeger, *Biometrika* 73
//! (1986) 13) has at most the rank C: with few clusters it shrinks, and some combinations of
//! parameters would be known exactly. The second uses the clusters only for the inflation of the
//! variance, one number for all directions, and never gives a smaller standard deviation than W or
//! the first form.

use nalgebra::{DMatrix, DVector};

/// Minimum number of clusters for each unknown that the sandwich needs.
const CLUSTERS_AN_UNKNOWN: usize = 2;

/// Covariance by clusters.
pub(crate) struct OfClusters {
    /// (p, p).
    pub covariance: DMatrix<f64>,
    /// Whether there were too few clusters for the sandwich, so that the covariance for white
    /// residuals was widened.
    pub few: bool,
}

/// Covariance of estimates whose covariance is `white` for white residuals; `shifts` are the s_c,
/// `factor` is f.
pub(crate) fn of_clusters(white: &DMatrix<f64>, shifts: &[DVector<f64>], factor: f64) -> OfClusters {
    let p = white.nrows();
    let sandwich = |i: usize, j: usize| factor * shifts.iter().map(|s| s[i] * s[j]).sum::<f64>();
    if shifts.len() >= CLUSTERS_AN_UNKNOWN * p {
        return OfClusters { covariance: DMatrix::from_fn(p, p, sandwich), few: false };
    }
    // one cluster tells nothing: its shift is that of all rows, which is 0
    let inflation = if shifts.len() < 2 { 1.0 } else { factor * misfit(white, shifts) / p as f64 };
    let inflation = inflation.max(1.0);
    let wider: Vec<f64> = (0..p)
        .map(|i| {
            let ratio = if shifts.len() < 2 { 1.0 } else { sandwich(i, i) / (inflation * white[(i, i)]) };
            ratio.max(1.0).sqrt()
        })
        .collect();
    let covariance = DMatrix::from_fn(p, p, |i, j| wider[i] * inflation * white[(i, j)] * wider[j]);
    OfClusters { covariance, few: true }
}

/// Σ_c s_cᵀ W⁻¹ s_c; 0 if W has no inverse. Computed in units of the standard deviations of W,
/// which may differ widely.
fn misfit(white: &DMatrix<f64>, shifts: &[DVector<f64>]) -> f64 {
    let p = white.nrows();
    let unit: Vec<f64> = (0..p).map(|i| white[(i, i)].sqrt().max(f64::MIN_POSITIVE)).collect();
    let correlation = DMatrix::from_fn(p, p, |i, j| white[(i, j)] / (unit[i] * unit[j]));
    let Some(factor) = correlation.cholesky() else { return 0.0 };
    let square = |s: &DVector<f64>| {
        let scaled = DVector::from_fn(p, |i, _| s[i] / unit[i]);
        scaled.dot(&factor.solve(&scaled))
    };
    shifts.iter().map(square).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// Four parameters in widely different units, two of them strongly correlated.
    fn white() -> DMatrix<f64> {
        let unit = [1e-4, 1.0, 1e3, 1e5];
        let correlation = |i: usize, j: usize| if i == j { 1.0 } else { 0.9_f64.powi(i.abs_diff(j) as i32) };
        DMatrix::from_fn(4, 4, |i, j| unit[i] * correlation(i, j) * unit[j])
    }

    /// Shifts of `count` clusters whose true variance is `inflation` times the white one; their sum
    /// is 0, as for an estimate.
    fn shifts(count: usize, inflation: f64, seed: u64) -> Vec<DVector<f64>> {
        let root = white().cholesky().unwrap().l() * (inflation / count as f64).sqrt();
        let mut noise = Noise::new(seed, 0);
        let mut all: Vec<DVector<f64>> =
            (0..count).map(|_| &root * DVector::from_fn(4, |_, _| noise.normal())).collect();
        let mean = all.iter().fold(DVector::zeros(4), |sum, s| sum + s) / count as f64;
        all.iter_mut().for_each(|s| *s -= &mean);
        all
    }

    fn of(count: usize, inflation: f64, seed: u64) -> OfClusters {
        of_clusters(&white(), &shifts(count, inflation, seed), count as f64 / (count as f64 - 1.0))
    }

    #[test]
    fn law_many_clusters_tell_the_covariance() {
        let many = of(4000, 9.0, 1);
        assert!(!many.few);
        for i in 0..4 {
            // of 4000 squares the mean is known to √(2/4000) = 2.2 %; three of those
            let ratio = many.covariance[(i, i)] / (9.0 * white()[(i, i)]);
            assert!((ratio - 1.0).abs() < 0.07, "{i}: {ratio}");
        }
    }

    #[test]
    fn law_few_clusters_widen_and_never_narrow() {
        let mut mean = 0.0;
        for seed in 0..200 {
            let found = of(5, 9.0, seed);
            assert!(found.few);
            let sandwich = 5.0 / 4.0;
            for i in 0..4 {
                let own: f64 = shifts(5, 9.0, seed).iter().map(|s| sandwich * s[i] * s[i]).sum();
                let variance = found.covariance[(i, i)];
                assert!(variance >= white()[(i, i)] * (1.0 - 1e-12) && variance >= own * (1.0 - 1e-12), "{seed} {i}");
            }
            assert!(found.covariance.clone().cholesky().is_some(), "no combination is known exactly");
            mean += found.covariance[(1, 1)] / (9.0 * white()[(1, 1)]) / 200.0;
        }
        // wider than the truth by the greater of two, and not by much
        assert!((1.0..1.5).contains(&mean), "{mean}");
    }

    #[test]
    fn white_residuals_stay_as_wide_as_they_are() {
        let mean = (0..200).map(|seed| of(5, 1.0, seed).covariance[(2, 2)]).sum::<f64>() / 200.0 / white()[(2, 2)];
        assert!((1.0..1.5).contains(&mean), "{mean}");
        let one = of_clusters(&white(), &[DVector::zeros(4)], f64::INFINITY);
        assert!(one.few && (one.covariance - white()).amax() < 1e-12 * 1e10);
    }
}
