//! Least squares on rows of runs, with standard deviations that hold when residuals are correlated.
//!
//! ```text
//! θ̂ = argmin |y − H θ|²      paper (14, 15):  cov = σ² (HᵀH)⁻¹,  σ² = |e|²/(n − p)
//! HAC:  cov = (HᵀH)⁻¹ [Γ₀ + Σₗ (1 − l/(L + 1)) (Γₗ + Γₗᵀ)] (HᵀH)⁻¹ n/(n − p),   Γₗ = Σₖ hₖ eₖ eₖ₋ₗ hₖ₋ₗᵀ
//! ```
//!
//! By Householder QR of H with columns of unit length, never HᵀH. HAC: Newey and West, *Econometrica* 55 (1987) 703;
//! no product of residuals reaches from one run into another.

use std::ops::Range;

use faer::Mat;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A diagonal of R below this (columns are of unit length) means that the columns do not stand apart.
const RANK_TOLERANCE: f64 = 1e-10;

/// How standard deviations are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StdMethod {
    /// Equation (14) of the paper: right where residuals are independent.
    Paper,
    /// Heteroscedasticity and autocorrelation consistent.
    #[default]
    Hac,
}

/// Why a linear system has no solution.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum LinearError {
    /// Not more rows than unknowns.
    #[error("{rows} rows for {unknowns} unknowns: at least {} are needed", unknowns + 1)]
    TooFewRows {
        /// Rows.
        rows: usize,
        /// Unknowns.
        unknowns: usize,
    },
    /// A column is a combination of those before it.
    #[error("this data cannot tell `{column}` from the others: excite them apart, or fix one")]
    Dependent {
        /// Name of the column.
        column: String,
    },
}

/// A solved linear system.
#[derive(Debug, Clone)]
pub struct LinearFit {
    /// θ̂.
    pub coefficients: Vec<f64>,
    /// Covariance by the method asked for.
    pub covariance: Vec<Vec<f64>>,
    /// Covariance by (14).
    pub covariance_paper: Vec<Vec<f64>>,
    /// e = y − H θ̂.
    pub residuals: Vec<f64>,
    /// σ̂ of (15).
    pub residual_std: f64,
    /// cond(HᵀH), as the paper prints.
    pub condition_number: f64,
    /// cond(H) with columns of unit length.
    pub condition_number_scaled: f64,
}

/// Solves `columns` θ = `y`; `names` are for the message, `blocks` the runs.
///
/// # Errors
/// [`LinearError`] for too few rows and columns that depend on each other.
pub fn solve(
    columns: &[&[f64]],
    y: &[f64],
    names: &[String],
    blocks: &[Range<usize>],
    method: StdMethod,
) -> Result<LinearFit, LinearError> {
    let (n, p) = (y.len(), columns.len());
    if n <= p {
        return Err(LinearError::TooFewRows { rows: n, unknowns: p });
    }
    let name = |k: usize| names.get(k).cloned().unwrap_or_default();
    let length: Vec<f64> = columns.iter().map(|c| dot(c, c).sqrt()).collect();
    if let Some(k) = length.iter().position(|l| !l.is_normal()) {
        return Err(LinearError::Dependent { column: name(k) });
    }
    let qr = Mat::from_fn(n, p, |row, column| columns[column][row] / length[column]).qr();
    let (q, r) = (qr.compute_thin_Q(), qr.thin_R());
    if let Some(k) = (0..p).find(|k| r[(*k, *k)].abs() < RANK_TOLERANCE) {
        return Err(LinearError::Dependent { column: name(k) });
    }
    let inverse = invert(p, |row, column| r[(row, column)]);
    let projected: Vec<f64> = (0..p).map(|k| (0..n).map(|row| q[(row, k)] * y[row]).sum()).collect();
    let coefficients: Vec<f64> = (0..p).map(|k| dot(&inverse[k], &projected) / length[k]).collect();
    let fitted = |row: usize| (0..p).map(|k| columns[k][row] * coefficients[k]).sum::<f64>();
    let residuals: Vec<f64> = (0..n).map(|row| y[row] - fitted(row)).collect();
    let variance = dot(&residuals, &residuals) / (n - p) as f64;
    let symmetric = |f: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..p).map(|i| (0..p).map(|j| f(i, j) / (length[i] * length[j])).collect()).collect()
    };
    let covariance_paper = symmetric(&|i, j| variance * dot(&inverse[i], &inverse[j]));
    let covariance = match method {
        StdMethod::Paper => covariance_paper.clone(),
        StdMethod::Hac => {
            let basis: Vec<Vec<f64>> =
                (0..p).map(|k| (0..n).map(|row| q[(row, k)] * residuals[row]).collect()).collect();
            let meat = long_run(&basis, blocks, n as f64 / (n - p) as f64);
            let half: Vec<Vec<f64>> =
                (0..p).map(|i| (0..p).map(|k| (0..p).map(|l| inverse[i][l] * meat[l][k]).sum()).collect()).collect();
            symmetric(&|i, j| dot(&half[i], &inverse[j]))
        }
    };
    let condition = |f: &dyn Fn(usize, usize) -> f64| {
        singular_ratio(&Mat::from_fn(p, p, |i, j| if i <= j { f(i, j) } else { 0.0 }))
    };
    Ok(LinearFit {
        condition_number: condition(&|i, j| r[(i, j)] * length[j]).powi(2),
        condition_number_scaled: condition(&|i, j| r[(i, j)]),
        coefficients,
        covariance,
        covariance_paper,
        residuals,
        residual_std: variance.sqrt(),
    })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Inverse of an upper triangle, by rows.
fn invert(p: usize, r: impl Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
    let mut inverse = vec![vec![0.0; p]; p];
    for column in 0..p {
        for row in (0..=column).rev() {
            let known: f64 = (row + 1..=column).map(|k| r(row, k) * inverse[k][column]).sum();
            inverse[row][column] = (f64::from(u8::from(row == column)) - known) / r(row, row);
        }
    }
    inverse
}

/// Greatest over smallest singular value.
pub(super) fn singular_ratio(m: &Mat<f64>) -> f64 {
    let Ok(svd) = m.thin_svd() else { return f64::INFINITY };
    let s = svd.S().column_vector();
    s[0] / s[s.nrows() - 1]
}

/// Long-run covariance of scores by the Bartlett kernel. The lag grows with the cube root of the longest run: enough
/// for the one-sample memory of differenced noise and for disturbances of some ten samples.
fn long_run(scores: &[Vec<f64>], blocks: &[Range<usize>], factor: f64) -> Vec<Vec<f64>> {
    let p = scores.len();
    let longest = blocks.iter().map(Range::len).max().unwrap_or(0);
    let lags = (1.5 * (longest as f64).cbrt()).ceil() as usize;
    let mut sum = vec![vec![0.0; p]; p];
    for block in blocks {
        for lag in 0..=lags.min(block.len().saturating_sub(1)) {
            let weight = 1.0 - lag as f64 / (lags + 1) as f64;
            for i in 0..p {
                for j in 0..p {
                    let (late, early) = (&scores[i][block.start + lag..block.end], &scores[j][block.clone()]);
                    let gamma = weight * factor * dot(late, early);
                    sum[i][j] += gamma;
                    if lag > 0 {
                        sum[j][i] += gamma;
                    }
                }
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All rows in one run.
    fn one_run(n: usize) -> Vec<Range<usize>> {
        std::iter::once(0..n).collect()
    }

    fn names(n: usize) -> Vec<String> {
        (0..n).map(|k| format!("c{k}")).collect()
    }

    #[test]
    fn exact_line_through_five_points() {
        // y = 1, 3, 2, 5, 4 at x = 0 … 4: by hand 1.4 + 0.8 x, Σe² = 3.6, σ² = 1.2, slope's σ = sqrt(1.2/10);
        // HᵀH = [5 10; 10 30] has eigenvalues (35 ± sqrt(1025))/2
        let (one, x, y) = ([1.0; 5], [0.0, 1.0, 2.0, 3.0, 4.0], [1.0, 3.0, 2.0, 5.0, 4.0]);
        let fit = solve(&[&one, &x], &y, &names(2), &one_run(5), StdMethod::Paper).unwrap();
        assert!((fit.coefficients[0] - 1.4).abs() < 1e-14 && (fit.coefficients[1] - 0.8).abs() < 1e-14);
        assert!((fit.residual_std - 1.2_f64.sqrt()).abs() < 1e-13);
        assert!((fit.covariance[1][1] - 0.12).abs() < 1e-14 && (fit.covariance[0][1] + 0.24).abs() < 1e-14);
        let root = 1025.0_f64.sqrt();
        assert!((fit.condition_number / ((35.0 + root) / (35.0 - root)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn law_differenced_noise_is_known_better_than_equation_14_says() {
        // a constant in y = 1 + e_k − e_{k−1}: the sum of residuals telescopes, so the mean is far better known
        let e: Vec<f64> = (0..401).map(|k| (f64::from(k) * 12.9898).sin() * 43758.547 % 1.0).collect();
        let y: Vec<f64> = e.windows(2).map(|e| 1.0 + e[1] - e[0]).collect();
        let one = vec![1.0; 400];
        let std = |method| solve(&[&one], &y, &names(1), &one_run(400), method).unwrap().covariance[0][0].sqrt();
        assert!(std(StdMethod::Hac) < 0.4 * std(StdMethod::Paper));
    }

    #[test]
    fn what_cannot_be_solved_is_named() {
        let refuse = |columns: &[&[f64]]| {
            solve(columns, &[1.0, 2.0, 3.0], &names(columns.len()), &one_run(3), StdMethod::Hac).unwrap_err()
        };
        assert_eq!(refuse(&[&[1.0, 2.0, 3.0], &[2.0, 4.0, 6.0]]), LinearError::Dependent { column: "c1".into() });
        assert_eq!(refuse(&[&[0.0; 3]]), LinearError::Dependent { column: "c0".into() });
        assert!(matches!(refuse(&[&[1.0; 3], &[2.0; 3], &[3.0; 3]]), LinearError::TooFewRows { rows: 3, unknowns: 3 }));
    }
}
