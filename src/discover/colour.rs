//! The colour of the sensors' noise, and what it costs.
//!
//! ```text
//! ρ = 1 + 2 Σ dₖ dₖ₊₁ / Σ dₖ²                            d: differences of the residuals from sample to sample
//! τ(n) = (1 + ρ)/(1 − ρ) − 2ρ (1 − ρⁿ)/(n (1 − ρ)²)       n var(mean of n samples)/σ²: 1 for white noise, n at most
//! ```
//!
//! An initial state that is fitted to n samples takes up τ of them, not one, and is uncertain accordingly. Differences
//! hardly see what is slow: a missing force does not pass for colour.

use super::thin::residuals;
use crate::estimate::output_error::OutputErrorFit;

/// Beyond this the noise is a drift, and what is slow cannot be told from it.
const MOST: f64 = 0.95;

/// Correlation of neighbouring samples of the noise, by output, from a fit on short segments.
pub(super) fn colours(fit: &OutputErrorFit) -> Vec<f64> {
    let all = residuals(fit);
    let outputs = fit.problem.dynamics.outputs.len();
    let of = |output: usize| {
        let (mut squares, mut products) = (0.0, 0.0);
        for segment in &fit.problem.segments {
            let grid = segment.first..=segment.last;
            let own: Vec<f64> =
                grid.map(|k| all[segment.track][k * outputs + output]).filter(|r| r.is_finite()).collect();
            let steps: Vec<f64> = own.windows(2).map(|w| w[1] - w[0]).collect();
            products += steps.windows(2).map(|d| d[0] * d[1]).sum::<f64>();
            // each step but those at the ends stands in two products
            squares += steps.windows(2).map(|d| 0.5 * (d[0] * d[0] + d[1] * d[1])).sum::<f64>();
        }
        if squares > 0.0 { (1.0 + 2.0 * products / squares).clamp(0.0, MOST) } else { 0.0 }
    };
    (0..outputs).map(of).collect()
}

/// τ: how many of `samples` of noise of this colour a fitted mean takes up.
pub(super) fn taken_up(colour: f64, samples: f64) -> f64 {
    let rest = 1.0 - colour;
    (1.0 + colour) / rest - 2.0 * colour * (1.0 - colour.powf(samples)) / (samples * rest * rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    #[test]
    fn white_noise_takes_up_one_sample_and_a_drift_all() {
        assert!((taken_up(0.0, 20.0) - 1.0).abs() < 1e-12);
        assert!((taken_up(1.0 - 1e-6, 20.0) - 20.0).abs() < 1e-3);
    }

    /// Means of 20 000 stretches: the standard error of a variance is 1 %, of the bound three of them.
    #[test]
    fn means_of_coloured_noise_scatter_as_the_formula_says() {
        let (n, stretches) = (20, 20_000);
        let noise = Noise::new(3, 1).coloured(n * stretches, 0.8);
        let means: Vec<f64> = noise.chunks(n).map(|c| c.iter().sum::<f64>() / n as f64).collect();
        let variance = means.iter().map(|m| m * m).sum::<f64>() / stretches as f64;
        let predicted = taken_up(0.8, n as f64) / n as f64;
        assert!((variance / predicted - 1.0).abs() < 0.05, "{variance} {predicted}");
    }
}
