//! Covariance of a curve's coefficients: of each direction separately, or of the joint problem.

use super::{DirectionFit, FitError, Side, regress};
use crate::least_squares::LeastSquaresError;

/// Covariance if each direction was fitted separately.
pub(super) fn apart(sides: &[DirectionFit; 2]) -> [[f64; 6]; 6] {
    let mut covariance = [[0.0; 6]; 6];
    for (k, side) in sides.iter().enumerate() {
        let (a, b) = (2 * k, 2 * k + 1);
        (covariance[a][a], covariance[b][b]) = (side.a.std.powi(2), side.b.std.powi(2));
        (covariance[a][b], covariance[b][a]) = (side.covariance, side.covariance);
    }
    covariance
}

/// Covariance of the joint problem: |F| linearised at the optimum in a and b of each direction, and
/// in c and n if they are free.
pub(super) fn together(
    sides: [&Side; 2],
    fits: &[DirectionFit; 2],
    c: f64,
    n: f64,
    free: [bool; 2],
) -> Result<[[f64; 6]; 6], FitError> {
    let rows = sides[0].command.len() + sides[1].command.len();
    let mut columns = vec![vec![0.0; rows]; 6];
    let mut residual = Vec::with_capacity(rows);
    for (side, (data, fit)) in sides.iter().zip(fits).enumerate() {
        for (i, (x, k)) in data.rows(c, n).enumerate() {
            let row = residual.len();
            let force = (fit.a.value * x + fit.b.value) * x * k;
            columns[2 * side][row] = x * x * k;
            columns[2 * side + 1][row] = x * k;
            columns[4][row] = if x > 0.0 { -(2.0 * fit.a.value * x + fit.b.value) * k } else { 0.0 };
            columns[5][row] = force * data.log_supply[i];
            residual.push(data.force[i] - force);
        }
    }
    let places: Vec<usize> = (0..6).filter(|&j| j < 4 || free[j - 4]).collect();
    let used: Vec<&[f64]> = places.iter().map(|j| columns[*j].as_slice()).collect();
    let mut covariance = [[0.0; 6]; 6];
    match regress(&used, &residual) {
        Ok(joint) => {
            for (i, a) in places.iter().enumerate() {
                for (j, b) in places.iter().enumerate() {
                    covariance[*a][*b] = joint.covariance[i][j];
                }
            }
        }
        // a table computed by the formula: no residual
        Err(LeastSquaresError::NoVariance { .. }) => {}
        Err(_) => return Err(FitError::NotIdentifiable { direction: "forward and reverse" }),
    }
    Ok(covariance)
}
