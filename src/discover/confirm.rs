//! The evidence for an effect once it has been refitted.
//!
//! ```text
//! [R₁₁ R₁₂; 0 R₂₂]   factor of the Jacobian by the model's own unknowns (1) and the effect's (2)
//! B = R₁₁⁻¹ R₁₂      s_c = g₂ − Bᵀ g₁ in cluster c,  g = Jᵀr        I = R₂₂ᵀ R₂₂
//! F = (fall of the cost) / (k φ),   φ = tr(I⁻¹ Σ s_c s_cᵀ)/k · G/(G − k)      against F(k, G − k)
//! ```
//!
//! At a model that is far off the scores ([`super::judge`]) see large residuals everywhere; with the right effect in it
//! the residuals are small, and the fall of the cost is judged against those. Clusters are segments, G counts those in
//! which the effect says anything. Liang and Zeger (1986).

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::freedom::fair_cost;
use super::search::noise_level;
use crate::estimate::output_error::{OutputErrorFit, normal_factor};

/// Probability of as great a fall of the cost by chance, times the number `count` of probes that chance had.
pub(super) fn p_of_refit(before: &OutputErrorFit, after: &OutputErrorFit, count: f64) -> f64 {
    let all = after.problem.unknowns.len();
    let known = before.problem.unknowns.len();
    let fall = (fair_cost(before) - fair_cost(after)).max(0.0);
    if all < known {
        return 1.0;
    }
    if all == known {
        // an effect without a parameter: a fall of the cost that one parameter of nothing would bring is chance
        let spare = after.problem.segments.len() as f64;
        let chance = FisherSnedecor::new(1.0, spare).map_or(1.0, |d| d.sf(fall / noise_level(after).max(0.7)));
        return (chance * count).min(1.0);
    }
    let k = all - known;
    let factor = normal_factor(&after.problem, &after.model, &after.linearised);
    let at = |i: usize, j: usize| if i <= j { factor.at(i, j)[0] } else { 0.0 };
    let own = DMatrix::from_fn(known, known, at);
    let cross = DMatrix::from_fn(known, k, |i, j| at(i, known + j));
    let new = DMatrix::from_fn(k, k, |i, j| at(known + i, known + j));
    let (Some(b), Some(inverse)) = (own.solve_upper_triangular(&cross), new.clone().try_inverse()) else { return 1.0 };
    let information_inverse = &inverse * inverse.transpose();
    let nx = after.problem.dynamics.states.len();
    let (mut scatter, mut weight, mut weight_squared) = (DMatrix::<f64>::zeros(k, k), 0.0, 0.0);
    for (segment, stretch) in after.linearised.iter().zip(&after.problem.segments) {
        let columns = after.problem.columns_of(stretch.track);
        let (mut score, mut share) = (DVector::<f64>::zeros(k), 0.0);
        for row in nx..segment.n {
            let mut z = DVector::<f64>::zeros(k);
            for (direction, column) in columns.iter().enumerate() {
                let value = segment.at(row, nx + direction);
                match column.checked_sub(known) {
                    Some(new) => z[new] += value,
                    None => z -= b.row(*column).transpose() * value,
                }
            }
            score += &z * segment.at(row, segment.n - 1);
            share += (z.transpose() * &information_inverse * &z)[(0, 0)];
        }
        scatter += &score * score.transpose();
        weight += share;
        weight_squared += share * share;
    }
    let effective = weight * weight / weight_squared.max(f64::MIN_POSITIVE);
    let spare = effective - k as f64;
    if spare <= 1.0 {
        return 1.0;
    }
    let inflation = ((&information_inverse * scatter).trace() / k as f64 * effective / spare).max(0.7);
    let chance = FisherSnedecor::new(k as f64, spare).map_or(1.0, |d| d.sf(fall / (k as f64 * inflation)));
    (chance * count).min(1.0)
}
