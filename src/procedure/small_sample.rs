//! Standard deviations from few rows, each the mean of many samples.
//!
//! ```text
//! s̃² = (ν s² + ν₀ s₀²)/(ν + ν₀),      two deviations are t(ν + ν₀)       if ν s²/s₀² < χ²₀.₉₈(ν)
//! s̃² = s²,                             two deviations are t(ν)            otherwise
//! ```
//!
//! s²: variance of the residuals, with ν degrees of freedom. s₀²: variance of the rows that the
//! noise of the samples predicts. With one degree of freedom the residuals alone widen a standard
//! deviation seven times, although the samples show how well each mean is known. s₀² does not
//! contain differences between windows, so it counts for only ν₀ = 4 degrees of freedom, and not at
//! all if the residuals contradict it. This is an inverse χ² prior: Gelman et al., *Bayesian Data
//! Analysis* (2013), section 3.2.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::least_squares::student_quantile;

/// ν₀: degrees of freedom with which the noise of the samples counts.
const OF_SAMPLES: f64 = 4.0;

/// Probability below which the residuals contradict the noise of the samples. Each false alarm
/// makes a standard deviation with one degree of freedom five times too wide.
const AGAINST: f64 = 0.02;

/// Factor between the reported standard deviations and those of the residuals alone. `shown`:
/// variance of the residuals, with `freedom` degrees of freedom; `expected`: variance that the
/// noise of the samples predicts.
pub(super) fn widening(freedom: f64, shown: f64, expected: f64) -> f64 {
    let agree =
        || ChiSquared::new(freedom).is_ok_and(|chi| freedom * shown / expected < chi.inverse_cdf(1.0 - AGAINST));
    if shown > 0.0 && expected > 0.0 && agree() {
        let all = freedom + OF_SAMPLES;
        ((freedom * shown + OF_SAMPLES * expected) / (all * shown)).sqrt() * student(all)
    } else {
        student(freedom)
    }
}

/// Half of the quantile of Student's t with the probability of two standard deviations of a normal
/// distribution.
fn student(freedom: f64) -> f64 {
    const TWO_SIGMA: f64 = 0.977_249_868_051_820_8;
    student_quantile(TWO_SIGMA, freedom.max(1.0)) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    #[test]
    fn paper_quantiles_of_student() {
        // tables: t(0.97725) is 13.97 for 1, 3.307 for 3 and 2.0 for infinitely many degrees of
        // freedom
        for (freedom, quantile) in [(1.0, 13.97), (3.0, 3.307), (1e6, 2.0)] {
            assert!((2.0 * student(freedom) / quantile - 1.0).abs() < 1e-3, "four printed digits: {freedom}");
        }
        assert_eq!(widening(1.0, 9.0, 1.0), student(1.0), "residuals that the samples do not explain");
        assert_eq!(widening(2.0, 1.0, 0.0), student(2.0), "samples that say nothing");
    }

    /// Mean of n normal numbers: two reported deviations contain it in 95.4 % of the draws if the
    /// noise of the samples is right, and not much less often if the windows scatter up to twice as
    /// much.
    #[test]
    fn law_two_deviations_hold_what_they_should() {
        let mut noise = Noise::new(5, 1);
        const DRAWS: usize = 4000;
        for (rows, truth, least, most) in
            [(2, 1.0, 0.94, 0.99), (4, 1.0, 0.94, 0.99), (2, 2.0, 0.88, 0.98), (4, 4.0, 0.82, 0.98)]
        {
            let (mut held, mut width) = (0, 0.0);
            for _ in 0..DRAWS {
                let x: Vec<f64> = (0..rows).map(|_| f64::sqrt(truth) * noise.normal()).collect();
                let n = rows as f64;
                let mean = x.iter().sum::<f64>() / n;
                let shown = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
                let std = (shown / n).sqrt() * widening(n - 1.0, shown, 1.0);
                held += usize::from(mean.abs() < 2.0 * std);
                width += std / (truth / n).sqrt() / DRAWS as f64;
            }
            let share = held as f64 / DRAWS as f64;
            assert!(
                (least..most).contains(&share),
                "{rows} rows, variance {truth}: {share}, {width:.2} times too wide"
            );
        }
    }
}
