//! A small least-squares fit whose standard deviations allow for correlated residuals.
//!
//! ```text
//! min ‖y − H θ‖,   H = Q R (columns scaled),   cov θ = R⁻¹ (Σ_g s_g s_gᵀ) R⁻ᵀ,   s_g = Σ_{i in g} qᵢ eᵢ
//! ```
//!
//! g runs over up to thirty stretches of neighbouring rows (cluster-robust covariance; Cameron and
//! Miller, *Journal of Human Resources* 50 (2015) 317-372); the standard deviation for white
//! residuals is used if it is larger.

use nalgebra::{DMatrix, DVector};

/// Largest number of stretches of rows that are treated as independent of each other.
const CLUSTERS: usize = 30;

/// Result of a fit.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Estimates, in the order of the columns.
    pub theta: Vec<f64>,
    /// Their standard deviations.
    pub std: Vec<f64>,
    /// Sum of squared residuals.
    pub cost: f64,
    /// Share of the sum of squares of the target that the fit explains.
    pub explained: f64,
    /// Ratio of the largest to the smallest singular value of the scaled columns.
    pub condition: f64,
    /// Number of rows.
    pub rows: usize,
}

/// Fits `target` (n) by `columns` (each n); `None` with too few rows or dependent columns.
pub fn fit(columns: &[&[f64]], target: &[f64]) -> Option<Fit> {
    let (rows, width) = (target.len(), columns.len());
    if width == 0 || rows < 2 * width + 6 {
        return None;
    }
    let mut h = DMatrix::from_fn(rows, width, |i, j| columns[j][i]);
    let scale: Vec<f64> = h.column_iter().map(|c| c.norm()).collect();
    if scale.iter().any(|s| !s.is_finite() || *s <= 0.0) {
        return None;
    }
    for (mut column, s) in h.column_iter_mut().zip(&scale) {
        column /= *s;
    }
    let y = DVector::from_column_slice(target);
    let total = y.norm_squared();
    let qr = h.clone().qr();
    let (q, r) = (qr.q(), qr.r());
    // dependent: a difference this small is below the noise of any sensor
    if total <= 0.0 || r.diagonal().iter().any(|d| d.abs() < 1e-9) {
        return None;
    }
    let scaled = r.solve_upper_triangular(&(q.transpose() * &y))?;
    let residual = &y - &h * &scaled;
    let cost = residual.norm_squared();
    let inverse = r.solve_upper_triangular(&DMatrix::identity(width, width))?;
    let white = &inverse * inverse.transpose() * (cost / (rows - width) as f64);
    let groups = CLUSTERS.min(rows / 4).max(2);
    let mut meat = DMatrix::zeros(width, width);
    for g in 0..groups {
        let (from, to) = (g * rows / groups, (g + 1) * rows / groups);
        let s = q.rows(from, to - from).transpose() * residual.rows(from, to - from);
        meat += &s * s.transpose();
    }
    let robust = &inverse * meat * inverse.transpose() * (groups as f64 / (groups - 1) as f64);
    // an exact fit has no residuals
    let wider = |i: usize| if white[(i, i)] > 0.0 { (robust[(i, i)] / white[(i, i)]).max(1.0).sqrt() } else { 1.0 };
    let std = |i: usize| white[(i, i)].sqrt() * wider(i) / scale[i];
    Some(Fit {
        theta: scaled.iter().zip(&scale).map(|(x, s)| x / s).collect(),
        std: (0..width).map(std).collect(),
        cost,
        explained: 1.0 - cost / total,
        condition: condition(&r),
        rows,
    })
}

/// Condition number of R from the eigenvalues of RᵀR: accurate up to 1e7, which is enough here.
fn condition(r: &DMatrix<f64>) -> f64 {
    let values = (r.transpose() * r).symmetric_eigenvalues();
    let (low, high) = values.iter().fold((f64::INFINITY, 0.0f64), |(a, b), x| (a.min(*x), b.max(*x)));
    (high / low.max(1e-15)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tank::Noise;

    #[test]
    fn exact_data_give_the_coefficients_back() {
        let a: Vec<f64> = (0..50).map(|k| f64::from(k).sin()).collect();
        let b: Vec<f64> = (0..50).map(|k| 1e3 * f64::from(k).cos()).collect();
        let y: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 3.0 * a - 0.5 * b).collect();
        let f = fit(&[&a, &b], &y).unwrap();
        // rounding of a well-conditioned fit
        assert!((f.theta[0] - 3.0).abs() < 1e-9 && (f.theta[1] + 0.5).abs() < 1e-12 && f.explained > 1.0 - 1e-12);
        assert!(fit(&[&a, &a], &y).is_none());
    }

    #[test]
    fn intervals_bear_correlated_residuals() {
        let (mut white, mut slow) = (0, 0);
        for seed in 0..200 {
            let mut noise = Noise::new(seed, 1);
            let x: Vec<f64> = (0..300).map(|k| (0.1 * f64::from(k)).sin()).collect();
            for (colour, hits) in [(0.0, &mut white), (0.8, &mut slow)] {
                let e = noise.coloured(300, colour);
                let y: Vec<f64> = x.iter().zip(&e).map(|(x, e)| x + 0.1 * e).collect();
                let f = fit(&[&x], &y).unwrap();
                *hits += usize::from((f.theta[0] - 1.0).abs() < 2.0 * f.std[0]);
            }
        }
        // 95 % of 200 is 190 ± 3; with AR(1) 0.8 intervals for white residuals would cover half
        assert!(white > 178, "{white}");
        assert!(slow > 160, "{slow}");
    }
}
