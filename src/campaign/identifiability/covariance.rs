//! What a covariance says of its parameters: for fits of rows, which have no one Jacobian.
//!
//! ```text
//! ρ = D⁻¹ Σ D⁻¹ = L Lᵀ        J = L⁻¹: JᵀJ = ρ⁻¹, the information in units of the deviations
//! inflation_k = √(ρ⁻¹)_kk     std of θ_k over that with all other parameters known
//! ```

use nalgebra::DMatrix;

use super::{Believable, Direction, Identifiability, correlations, groups, harmless};
use crate::estimate::identifiability::{collinearity, shares};
use crate::finding::Finding;
use crate::model::Model;
use crate::run::Run;

/// What `covariance`, in the order of the model's parameters, says of those that were estimated; `runs` are those of
/// motion. `None` where there is none, or it is no covariance.
pub(in crate::campaign) fn of_covariance(
    model: &Model,
    covariance: &[Vec<f64>],
    runs: &[Run],
    findings: &mut Vec<Finding>,
) -> Option<Identifiability> {
    let own = |p: &usize| covariance[*p][*p] > 0.0 && !model.parameters[*p].spec.per_run;
    let unknowns: Vec<usize> = model.free().into_iter().filter(own).collect();
    let at = |i: usize, j: usize| covariance[unknowns[i]][unknowns[j]];
    let n = unknowns.len();
    let correlation = DMatrix::from_fn(n, n, |i, j| at(i, j) / (at(i, i) * at(j, j)).sqrt());
    let factor = correlation.cholesky()?.l();
    let inverse = factor.solve_lower_triangular(&DMatrix::identity(n, n))?;
    let columns: Vec<Vec<f64>> = (0..n).map(|j| inverse.column(j).iter().copied().collect()).collect();
    let known = collinearity(&columns)?;
    let share = shares(model, runs);
    let mut parameters = Vec::new();
    for (k, parameter) in unknowns.iter().enumerate() {
        let p = &model.parameters[*parameter];
        let read = model.terms.iter().filter(|t| t.parameters.contains(parameter));
        let force_share = read.filter_map(|t| share.get(&t.name())).copied().reduce(f64::max);
        findings.extend(harmless(model, *parameter, force_share));
        parameters.push(Believable {
            term: p.term.clone(),
            name: p.spec.name.clone(),
            inflation: known.inflation[k],
            force_share,
            first_half: None,
            second_half: None,
            halves_z: None,
        });
    }
    let groups = groups(model, &known, &unknowns, findings);
    let proportions =
        |shares: &[f64]| shares.iter().zip(&unknowns).map(|(s, p)| (model.parameters[*p].full_name(), *s)).collect();
    let directions = known.indices.iter().rev();
    Some(Identifiability {
        condition_number_scaled: known.indices.iter().map(|i| i.index).fold(1.0, f64::max),
        parameters,
        groups,
        correlations: correlations(model, &unknowns, at),
        condition_indices: directions
            .map(|one| Direction { index: one.index, proportions: proportions(&one.proportions) })
            .collect(),
        inertia_against_amplitude: Vec::new(),
        segment_lengths: Vec::new(),
        windows: Vec::new(),
        profiles: Vec::new(),
    })
}
