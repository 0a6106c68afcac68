//! Which parameters the data cannot distinguish.
//!
//! ```text
//! J D = U S Vᵀ        D: columns of unit length
//! η_j = s_max/s_j     condition indices; 30 and more: a near dependence
//! π_jk = (v_kj/s_j)² / Σ_i (v_ki/s_i)²      share of the variance of θ_k that comes from the direction j
//! inflation_k = √(Σ_i (v_ki/s_i)²)          std of θ_k over that with all other parameters known
//! ```
//!
//! J: Jacobian by the unknowns in units of the noise, with the initial states projected out, by its
//! triangular factor. Parameters of which more than half of the variance comes from one direction
//! of large condition index form a group. Belsley, Kuh and Welsch, *Regression Diagnostics* (1980),
//! ch. 3.

use faer::Mat;

use crate::estimate::output_error::{OutputErrorFit, normal_factor};

/// Condition index from which on a dependence counts.
pub const SAME: f64 = 30.0;

/// Share of the variance beyond which a parameter takes part in a dependence.
const PART: f64 = 0.5;

/// One direction of the parameter space.
#[derive(Debug, Clone, PartialEq)]
pub struct ConditionIndex {
    /// η: 1 for the direction that is known best.
    pub index: f64,
    /// π by unknown: share of its variance that comes from this direction.
    pub proportions: Vec<f64>,
}

/// The effect of collinearity on the unknowns of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Collinearity {
    /// Directions, the best known first.
    pub indices: Vec<ConditionIndex>,
    /// Standard deviation over that with all others known, by unknown; 1 if nothing else resembles
    /// it.
    pub inflation: Vec<f64>,
    /// Groups of unknowns that this data does not separate, with the condition index.
    pub groups: Vec<(Vec<usize>, f64)>,
}

/// Columns of the triangular factor of the Jacobian of a fit.
pub fn factor_of(fit: &OutputErrorFit) -> Vec<Vec<f64>> {
    let p = fit.problem.unknowns.len();
    let factor = normal_factor(&fit.problem, &fit.model, &fit.linearised);
    (0..p).map(|j| (0..p).map(|i| if i <= j { factor.at(i, j)[0] } else { 0.0 }).collect()).collect()
}

/// Collinearity of the columns of a Jacobian or its triangular factor; `None` if a column is 0 or
/// not finite, or no decomposition is found.
pub fn collinearity(columns: &[Vec<f64>]) -> Option<Collinearity> {
    let p = columns.len();
    let length: Vec<f64> = columns.iter().map(|c| c.iter().map(|x| x * x).sum::<f64>().sqrt()).collect();
    if p == 0 || length.iter().any(|l| !(l.is_finite() && *l > 0.0)) {
        return None;
    }
    let rows = columns[0].len();
    let scaled = Mat::from_fn(rows, p, |i, j| columns[j][i] / length[j]);
    let svd = scaled.thin_svd().ok()?;
    let s: Vec<f64> = svd.S().column_vector().iter().copied().collect();
    let v = svd.V();
    if s.iter().any(|x| !(x.is_finite() && *x > 0.0)) {
        return None;
    }
    let part = |k: usize, j: usize| (v[(k, j)] / s[j]).powi(2);
    let variance: Vec<f64> = (0..p).map(|k| (0..p).map(|j| part(k, j)).sum()).collect();
    let indices: Vec<ConditionIndex> = (0..p)
        .map(|j| ConditionIndex { index: s[0] / s[j], proportions: (0..p).map(|k| part(k, j) / variance[k]).collect() })
        .collect();
    let group = |one: &ConditionIndex| {
        let members: Vec<usize> = (0..p).filter(|k| one.proportions[*k] > PART).collect();
        (one.index >= SAME && members.len() > 1).then_some((members, one.index))
    };
    Some(Collinearity {
        groups: indices.iter().rev().filter_map(group).collect(),
        indices,
        inflation: variance.iter().map(|v| v.sqrt()).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two columns that differ by a part in a hundred, and an independent one.
    #[test]
    fn a_near_dependence_names_its_columns() {
        let n = 40;
        let wave = |k: usize, a: f64| (a * k as f64).sin();
        let a: Vec<f64> = (0..n).map(|k| 1e3 * wave(k, 0.3)).collect();
        let b: Vec<f64> = (0..n).map(|k| wave(k, 0.3) + 0.01 * wave(k, 1.1)).collect();
        let c: Vec<f64> = (0..n).map(|k| wave(k, 0.7)).collect();
        let found = collinearity(&[a, b, c]).unwrap();
        assert_eq!(found.groups.len(), 1);
        assert_eq!(found.groups[0].0, [0, 1]);
        assert!(found.groups[0].1 > 100.0, "{:?}", found.groups);
        assert!(found.inflation[0] > 50.0 && found.inflation[2] < 1.5, "{:?}", found.inflation);
        for k in 0..3 {
            let sum: f64 = found.indices.iter().map(|i| i.proportions[k]).sum();
            // rounding of three terms
            assert!((sum - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn orthogonal_columns_are_told_apart_and_empty_ones_refused() {
        let found = collinearity(&[vec![2.0, 0.0], vec![0.0, 5.0]]).unwrap();
        assert!(found.groups.is_empty() && found.inflation.iter().all(|x| (x - 1.0).abs() < 1e-14));
        assert_eq!(collinearity(&[vec![0.0, 0.0], vec![0.0, 5.0]]), None);
        assert_eq!(collinearity(&[vec![f64::NAN, 0.0]]), None);
        assert_eq!(collinearity(&[]), None);
    }
}
