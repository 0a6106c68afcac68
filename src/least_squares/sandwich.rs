//! Covariance of least squares for residuals that are correlated along a run.
//!
//! ```text
//! HAC:  cov = (HᵀH)⁻¹ [Γ₀ + Σₗ (1 − l/(L + 1)) (Γₗ + Γₗᵀ)] (HᵀH)⁻¹ n/(n − p),   Γₗ = Σₖ hₖ eₖ eₖ₋ₗ hₖ₋ₗᵀ
//! ```
//!
//! Newey and West, *Econometrica* 55 (1987) 703; residuals of different runs are not multiplied.
//! The weights are proportional to the number of windows of L + 1 rows that contain both rows, so
//! that the bracket is a sum of squares for any number of lags:
//!
//! ```text
//! Γ₀ + Σₗ (1 − l/(L + 1)) (Γₗ + Γₗᵀ) = 1/(L + 1) Σₜ sₜ sₜᵀ
//! sₜ = Σ hₖ eₖ over the existing rows of t − L … t
//! ```

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::clusters::{OfClusters, of_clusters};
use super::scale::times_power_of_two;
use super::solve::Fit;
use super::streaming_qr::StreamingQr;
use super::system::LeastSquaresError;

/// Number of rows that are multiplied while they are in the cache.
const NEAR: usize = 256;

/// Method of the standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StdMethod {
    /// Equation (14) of the paper: valid for independent residuals.
    Paper,
    /// Heteroscedasticity and autocorrelation consistent.
    #[default]
    Hac,
}

impl Fit {
    /// Covariance of the estimates, (p, p), by `method`; `h` and `y` are those of the fit, `blocks`
    /// the rows of each run.
    ///
    /// # Errors
    /// [`LeastSquaresError`] if the shapes are not those of the fit.
    pub fn covariance_by(
        &self,
        method: StdMethod,
        h: &[&[f64]],
        y: &[f64],
        blocks: &[Range<usize>],
    ) -> Result<Vec<Vec<f64>>, LeastSquaresError> {
        let residuals = self.residuals(h, y)?;
        if method == StdMethod::Paper {
            return Ok(self.covariance.clone());
        }
        let (n, p) = (y.len(), h.len());
        let (w, exponents) = (&self.frame.w, &self.frame.exponents);
        let meat = long_run(&self.scores(h, &residuals), blocks, n as f64 / (n - p) as f64);
        let half: Vec<Vec<f64>> =
            w.iter().map(|w| (0..p).map(|k| (0..p).map(|l| w[l] * meat[l][k]).sum()).collect()).collect();
        let unit = |j: usize, x: f64| times_power_of_two(x, self.frame.y_exponent - exponents[j]);
        Ok((0..p).map(|i| (0..p).map(|j| unit(i, unit(j, dot(&half[i], &w[j])))).collect()).collect())
    }
}

impl Fit {
    /// Scores in coordinates in which H has orthonormal columns: Σⱼ hⱼ wⱼₖ e, column by column.
    fn scores(&self, h: &[&[f64]], residuals: &[f64]) -> Vec<Vec<f64>> {
        let mut scores = vec![vec![0.0; residuals.len()]; h.len()];
        let mut column = [0.0; NEAR];
        for begin in (0..residuals.len()).step_by(NEAR) {
            let rows = begin..(begin + NEAR).min(residuals.len());
            for (j, h) in h.iter().enumerate() {
                for ((x, h), e) in column.iter_mut().zip(&h[rows.clone()]).zip(&residuals[rows.clone()]) {
                    let e = times_power_of_two(*e, -self.frame.y_exponent);
                    *x = times_power_of_two(*h, -self.frame.exponents[j]) * e;
                }
                for (score, w) in scores.iter_mut().zip(&self.frame.w[j]) {
                    score[rows.clone()].iter_mut().zip(&column).for_each(|(score, x)| *score += x * w);
                }
            }
        }
        scores
    }

    /// Covariance of the estimates, (p, p), by clusters: stretches of rows with the factors
    /// `blocks`, whose residuals are independent of each other.
    pub(crate) fn covariance_of_blocks(&self, blocks: &[StreamingQr]) -> OfClusters {
        let (p, count) = (self.coefficients.len(), blocks.len() as f64);
        let (w, exponents) = (&self.frame.w, &self.frame.exponents);
        let factor = count / (count - 1.0) * self.rows as f64 / (self.rows - p) as f64;
        let unit = |j: usize, x: f64| times_power_of_two(x, -exponents[j]);
        // (HᵀH)⁻¹ g of each cluster
        let shifts: Vec<DVector<f64>> = blocks
            .iter()
            .map(|block| {
                let score = block.score(&self.coefficients, exponents);
                let along: Vec<f64> = (0..p).map(|k| (0..p).map(|j| w[j][k] * score[j]).sum()).collect();
                DVector::from_fn(p, |j, _| unit(j, dot(&w[j], &along)))
            })
            .collect();
        of_clusters(&DMatrix::from_fn(p, p, |i, j| self.covariance[i][j]), &shifts, factor)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Long-run covariance of scores by the Bartlett kernel. The lag grows with the cube root of the
/// longest run: enough for the one-sample memory of differenced noise and for disturbances of some
/// ten samples.
fn long_run(scores: &[Vec<f64>], blocks: &[Range<usize>], factor: f64) -> Vec<Vec<f64>> {
    let p = scores.len();
    let longest = blocks.iter().map(Range::len).max().unwrap_or(0);
    let width = 1 + (1.5 * (longest as f64).cbrt()).ceil() as usize;
    let mut sum = vec![vec![0.0; p]; p];
    for block in blocks {
        let windows: Vec<DVector<f64>> = scores.iter().map(|s| window_sums(&s[block.clone()], width)).collect();
        for i in 0..p {
            for j in i..p {
                sum[i][j] += factor / width as f64 * windows[i].dot(&windows[j]);
                sum[j][i] = sum[i][j];
            }
        }
    }
    sum
}

/// Sums over windows of `width` neighbours, including windows that reach beyond the ends.
fn window_sums(x: &[f64], width: usize) -> DVector<f64> {
    let mut sum = 0.0;
    let next = |t: usize, _| {
        sum += x.get(t).copied().unwrap_or(0.0) - t.checked_sub(width).map_or(0.0, |gone| x[gone]);
        sum
    };
    DVector::from_fn(x.len() + width - 1, next)
}

#[cfg(test)]
mod tests {
    use super::super::least_squares;
    use super::*;

    #[test]
    fn law_differenced_noise_is_known_better_than_equation_14_says() {
        // a constant in y = 1 + e_k − e_{k−1}: the sum of residuals telescopes, so the mean is far
        // better known
        let e: Vec<f64> = (0..401).map(|k| (f64::from(k) * 12.9898).sin() * 43758.547 % 1.0).collect();
        let y: Vec<f64> = e.windows(2).map(|e| 1.0 + e[1] - e[0]).collect();
        let h: [&[f64]; 1] = [&[1.0; 400]];
        let fit = least_squares(&h, &y).unwrap();
        let all = 0..400;
        let std = |method| fit.covariance_by(method, &h, &y, std::slice::from_ref(&all)).unwrap()[0][0].sqrt();
        assert!(std(StdMethod::Hac) < 0.4 * std(StdMethod::Paper));
        assert_eq!(std(StdMethod::Paper), fit.covariance[0][0].sqrt());
    }

    /// Windows against the explicit lags: the same sums in another order.
    #[test]
    fn law_windows_are_the_weighted_lags() {
        let scores: Vec<Vec<f64>> =
            (0..2).map(|i| (0..57).map(|k| f64::from((k * (5 + i) + 3 * i) % 11) - 4.0).collect()).collect();
        let blocks = [0..40, 40..43, 43..57];
        let found = long_run(&scores, &blocks, 1.5);
        let width = 1 + (1.5 * 40.0_f64.cbrt()).ceil() as usize;
        for i in 0..2 {
            for j in 0..2 {
                let mut exact = 0.0;
                for block in &blocks {
                    for (a, b) in block.clone().flat_map(|a| block.clone().map(move |b| (a, b))) {
                        let weight = 1.0 - a.abs_diff(b) as f64 / width as f64;
                        exact += 1.5 * weight.max(0.0) * scores[i][a] * scores[j][b];
                    }
                }
                assert!((found[i][j] - exact).abs() < 1e-10, "{i} {j}: {} and {exact}", found[i][j]);
            }
        }
    }

    #[test]
    fn exact_sandwich_of_a_line() {
        // without lags (blocks of one row) cov = (HᵀH)⁻¹ Σ hhᵀe² (HᵀH)⁻¹ n/(n − p); residuals of
        // the line 1.4 + 0.8 x are −0.4, 0.8, −1, 1.2, −0.6, Σ(x − 2)²e² =
        // 0.64 + 0.64 + 1.44 + 1.44, n/(n − p) = 5/3, Σ(x − 2)² = 10
        let (one, x, y) = ([1.0; 5], [0.0, 1.0, 2.0, 3.0, 4.0], [1.0, 3.0, 2.0, 5.0, 4.0]);
        let h: [&[f64]; 2] = [&one, &x];
        let rows: Vec<Range<usize>> = (0..5).map(|k| k..k + 1).collect();
        let fit = least_squares(&h, &y).unwrap();
        let covariance = fit.covariance_by(StdMethod::Hac, &h, &y, &rows).unwrap();
        assert!((covariance[1][1] / (4.16 / 100.0 * 5.0 / 3.0) - 1.0).abs() < 1e-13, "{covariance:?}");
        let long = fit.covariance_by(StdMethod::Hac, &h, &y[..4], &rows);
        assert!(matches!(long, Err(LeastSquaresError::Length { .. })));
    }
}
