//! Eigenvalues of a general matrix, by an iteration with a limited number of steps.
//!
//! ```text
//! A v = λ v
//! ```
//!
//! Without a limit the iteration for the Schur form never ends for some matrices, about one in a
//! few million.

use nalgebra::{Complex, DMatrix, Schur};

/// Maximum number of steps per row: two or three are usual.
const STEPS: usize = 100;

/// Size below which an element below the diagonal counts as zero, relative to its neighbours:
/// rounding, and if that fails 10⁻¹⁰.
const NOTHING: [f64; 2] = [f64::EPSILON, 1e-10];

/// The eigenvalues of a square matrix; `None` if an element is not finite or the iteration does not
/// converge.
pub fn eigenvalues(matrix: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    if matrix.is_empty() {
        return Some(Vec::new());
    }
    if matrix.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let found = NOTHING.into_iter().find_map(|nothing| Schur::try_new(matrix.clone(), nothing, STEPS * matrix.nrows()));
    found.map(|schur| schur.complex_eigenvalues().iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rotation at 2 rad/s that decays at 1 1/s, and a decay at 3 1/s.
    #[test]
    fn a_turn_has_two_that_are_conjugate() {
        let matrix = DMatrix::from_row_slice(3, 3, &[-1.0, -2.0, 0.0, 2.0, -1.0, 0.0, 0.0, 0.0, -3.0]);
        let mut found = eigenvalues(&matrix).unwrap();
        found.sort_by(|a, b| a.im.total_cmp(&b.im));
        for (found, right) in found.iter().zip([(-1.0, -2.0), (-3.0, 0.0), (-1.0, 2.0)]) {
            assert!((found.re - right.0).abs() < 1e-12 && (found.im - right.1).abs() < 1e-12, "{found}");
        }
    }

    #[test]
    fn what_is_no_number_has_none() {
        assert_eq!(eigenvalues(&DMatrix::from_element(2, 2, f64::NAN)), None);
        assert_eq!(eigenvalues(&DMatrix::zeros(0, 0)), Some(Vec::new()));
    }
}
