//! Singular values of a small matrix by one-sided Jacobi rotations.
//!
//! ```text
//! A V = U Σ:  columns x, y are turned until all are orthogonal; their lengths are then the singular values
//! tan 2φ = 2 xᵀy / (|y|² − |x|²)
//! ```
//!
//! Small singular values have a relative error of about ε κ(A D), D being the best scaling of
//! columns; methods that first reduce to bidiagonal form lose them at ε σ_max. Demmel and Veselić,
//! *SIAM J. Matrix Anal.* 13 (1992) 1204.

/// Maximum number of sweeps over all pairs; ten are enough for the worst matrices of the tests.
const SWEEPS: usize = 60;

/// Singular values, greatest first, of the matrix with these columns (at least as long as there are
/// columns). Entries must be finite and their squares in range.
pub(super) fn singular_values(mut columns: Vec<Vec<f64>>) -> Vec<f64> {
    let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
    let p = columns.len();
    columns.sort_by(|a, b| square(b).total_cmp(&square(a)));
    for _ in 0..SWEEPS {
        let mut still = true;
        for i in 0..p {
            for j in i + 1..p {
                let (head, tail) = columns.split_at_mut(j);
                still &= make_orthogonal(&mut head[i], &mut tail[0]);
            }
        }
        if still {
            break;
        }
    }
    let mut lengths: Vec<f64> = columns.iter().map(|x| square(x).sqrt()).collect();
    lengths.sort_by(|a, b| b.total_cmp(a));
    lengths
}

/// Greatest over smallest singular value of the matrix with these columns; 1 for one or none.
pub(crate) fn singular_ratio(columns: Vec<Vec<f64>>) -> f64 {
    match singular_values(columns).as_slice() {
        [first, .., last] => first / last,
        _ => 1.0,
    }
}

/// Rotates x and y in their plane until they are orthogonal; returns whether they already were.
fn make_orthogonal(x: &mut [f64], y: &mut [f64]) -> bool {
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for (x, y) in x.iter().zip(y.iter()) {
        xx += x * x;
        yy += y * y;
        xy += x * y;
    }
    let cosine = xy / (xx.sqrt() * yy.sqrt());
    // a NaN, from a column of zeros, counts as orthogonal
    if cosine.is_nan() || cosine.abs() <= f64::EPSILON {
        return true;
    }
    let zeta = (yy - xx) / (2.0 * xy);
    let tangent = 1.0_f64.copysign(zeta) / (zeta.abs() + zeta.hypot(1.0));
    let c = 1.0 / tangent.hypot(1.0);
    let s = c * tangent;
    for (x, y) in x.iter_mut().zip(y.iter_mut()) {
        (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_values_of_a_triangle() {
        // [3 1; 0 3]ᵀ[3 1; 0 3] has eigenvalues (19 ± √37)/2
        let values = singular_values(vec![vec![3.0, 0.0], vec![1.0, 3.0]]);
        let root = 37.0_f64.sqrt();
        for (value, exact) in values.iter().zip([(19.0 + root) / 2.0, (19.0 - root) / 2.0]) {
            assert!((value * value / exact - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn exact_small_values_beside_great_ones() {
        // diag(1e100, 1, 1e-100) turned from the left by a rotation: lengths are the values
        let (c, s) = (0.6, 0.8);
        let values = singular_values(vec![vec![c * 1e100, s * 1e100, 0.0], vec![-s, c, 0.0], vec![0.0, 0.0, 1e-100]]);
        for (value, exact) in values.iter().zip([1e100, 1.0, 1e-100]) {
            assert!((value / exact - 1.0).abs() < 1e-14, "{value}");
        }
    }

    #[test]
    fn zeros_and_nan_end() {
        assert_eq!(singular_values(vec![vec![0.0, 0.0], vec![0.0, 2.0]]), [2.0, 0.0]);
        assert_eq!(singular_values(vec![vec![f64::NAN, 1.0], vec![1.0, 2.0]]).len(), 2);
    }
}
