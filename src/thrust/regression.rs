//! Least squares of a few columns, by Householder QR on columns scaled to unit length.
//!
//! ```text
//! θ̂ = argmin |y − H θ|²,   σ² = |y − H θ̂|²/(n − p),   σ_θ = σ sqrt(diag (HᵀH)⁻¹) = σ × length of each row of R⁻¹
//! ```

use faer::Mat;

/// A diagonal of R below this (columns are of unit length) means that the columns do not stand apart.
const RANK_TOLERANCE: f64 = 1e-10;

/// Coefficients and what is known about them.
pub(super) struct Regression {
    pub coefficients: Vec<f64>,
    pub standard_errors: Vec<f64>,
    pub residual_std: f64,
    pub sum_of_squares: f64,
}

/// Regresses y on the columns; `None` where there are not more rows than columns or the columns do not stand apart.
pub(super) fn regress(columns: &[&[f64]], y: &[f64]) -> Option<Regression> {
    let (n, p) = (y.len(), columns.len());
    let length: Vec<f64> = columns.iter().map(|c| c.iter().map(|x| x * x).sum::<f64>().sqrt()).collect();
    if n <= p || length.iter().any(|l| !l.is_normal()) {
        return None;
    }
    let qr = Mat::from_fn(n, p, |row, column| columns[column][row] / length[column]).qr();
    let (q, r) = (qr.compute_thin_Q(), qr.thin_R());
    if (0..p).any(|k| r[(k, k)].abs() < RANK_TOLERANCE) {
        return None;
    }
    let mut inverse = vec![vec![0.0; p]; p];
    for column in 0..p {
        for row in (0..=column).rev() {
            let known: f64 = (row + 1..=column).map(|k| r[(row, k)] * inverse[k][column]).sum();
            inverse[row][column] = (f64::from(row == column) - known) / r[(row, row)];
        }
    }
    let projected: Vec<f64> = (0..p).map(|k| (0..n).map(|row| q[(row, k)] * y[row]).sum()).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let coefficients: Vec<f64> = (0..p).map(|k| dot(&inverse[k], &projected) / length[k]).collect();
    let residual = |row: usize| y[row] - (0..p).map(|k| columns[k][row] * coefficients[k]).sum::<f64>();
    let sum_of_squares = (0..n).map(|row| residual(row).powi(2)).sum::<f64>();
    let residual_std = (sum_of_squares / (n - p) as f64).sqrt();
    let spread = |k: usize| residual_std * dot(&inverse[k], &inverse[k]).sqrt() / length[k];
    Some(Regression { standard_errors: (0..p).map(spread).collect(), coefficients, residual_std, sum_of_squares })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_line_through_five_points() {
        // y = 1, 3, 2, 5, 4 at x = 0 … 4: by hand 1.4 + 0.8 x, Σe² = 3.6, σ² = 1.2, slope's σ = sqrt(1.2/10)
        let fit = regress(&[&[1.0; 5], &[0.0, 1.0, 2.0, 3.0, 4.0]], &[1.0, 3.0, 2.0, 5.0, 4.0]).unwrap();
        assert!((fit.coefficients[0] - 1.4).abs() < 1e-14 && (fit.coefficients[1] - 0.8).abs() < 1e-14);
        assert!((fit.sum_of_squares - 3.6).abs() < 1e-13 && (fit.residual_std - 1.2_f64.sqrt()).abs() < 1e-13);
        assert!((fit.standard_errors[1] - 0.12_f64.sqrt()).abs() < 1e-14);
        assert!((fit.standard_errors[0] - 0.72_f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn columns_that_do_not_stand_apart_have_no_answer() {
        assert!(regress(&[&[1.0, 2.0, 3.0], &[2.0, 4.0, 6.0]], &[1.0, 2.0, 3.0]).is_none());
        assert!(regress(&[&[0.0; 3]], &[1.0, 2.0, 3.0]).is_none());
        assert!(regress(&[&[1.0]], &[1.0]).is_none());
    }
}
