//! Identifiability from a covariance: for fits of rows, which do not have a single Jacobian.
//!
//! ```text
//! ρ = D⁻¹ Σ D⁻¹ = L Lᵀ        J = L⁻¹: JᵀJ = ρ⁻¹, the information in units of the deviations
//! inflation_k = √(ρ⁻¹)_kk     std of θ_k over that with all other parameters known
//! ```

use nalgebra::DMatrix;

use super::super::codes;
use super::{Believable, Direction, Identifiability, correlations, groups, harmless};
use crate::estimate::identifiability::{collinearity, shares};
use crate::finding::Finding;
use crate::log::number::short;
use crate::model::Model;
use crate::run::{Run, is_commanded};

/// Ratio of a standard deviation to that of the prior above which the data says nothing about the
/// parameter.
const UNTOLD: f64 = 0.9;

/// Relative standard deviation, beside the scale, above which the data leaves a parameter
/// uncertain.
const UNCERTAIN: f64 = 0.05;

/// Least share of a variance that remains beside a scale: below it, rounding decides.
const ROUNDING: f64 = 1e-12;

/// Returns what `covariance`, in the order of the model's parameters, shows about those that were
/// estimated; `runs` are those of motion. `None` if none was estimated, or if it is no covariance.
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
    let scale = scale(model, covariance, &unknowns, runs);
    if let Some(k) = scale {
        let (p, std) = (&model.parameters[unknowns[k]], at(k, k).sqrt());
        let text = format!(
            "no force is known absolutely: the scale of all masses, drags and forces comes from the prior of {}, known \
             to {} %; their ratios are more certain than their standard errors say",
            p.full_name(),
            short(100.0 * std / p.value.abs(), 2)
        );
        findings.push(Finding::new(&codes::SCALE_BY_PRIOR, text));
    }
    // apart from the scale, the data has to separate the rest
    let beside = |i: usize, j: usize| match scale {
        Some(k) if i == k && j == k => at(k, k),
        Some(k) if i == k || j == k => 0.0,
        Some(k) if i == j => (at(i, i) - at(i, k).powi(2) / at(k, k)).max(ROUNDING * at(i, i)),
        Some(k) => at(i, j) - at(i, k) * at(j, k) / at(k, k),
        None => at(i, j),
    };
    let correlation = DMatrix::from_fn(n, n, |i, j| beside(i, j) / (beside(i, i) * beside(j, j)).sqrt());
    let factor = correlation.cholesky()?.l();
    let inverse = factor.solve_lower_triangular(&DMatrix::identity(n, n))?;
    let columns: Vec<Vec<f64>> = (0..n).map(|j| inverse.column(j).iter().copied().collect()).collect();
    let mut known = collinearity(&columns)?;
    // ratios that are known are separated, however correlated they are
    let is_uncertain = |k: &usize| beside(*k, *k).sqrt() > UNCERTAIN * model.parameters[unknowns[*k]].value.abs();
    known.groups.retain(|(members, _)| scale.is_none() || members.iter().any(is_uncertain));
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

/// Returns the unknown that gives all others their scale: if no run commands a force, one about
/// which the data says nothing beyond its prior.
fn scale(model: &Model, covariance: &[Vec<f64>], unknowns: &[usize], runs: &[Run]) -> Option<usize> {
    let untold = |p: &usize| {
        let prior = model.parameters[*p].prior;
        prior.is_some_and(|(_, std)| covariance[*p][*p].sqrt() > UNTOLD * std)
    };
    let undriven = !model.dofs.iter().any(|dof| is_commanded(runs, *dof));
    unknowns.iter().position(untold).filter(|_| undriven)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::frame::Dof;
    use crate::run::Signal;

    /// Drag that is known to 1 % of the mass, and a mass that is known to 5 % from its prior alone.
    #[test]
    fn what_hangs_on_one_scale_is_told_as_that() {
        let effects = ["inertia", "linear_drag"];
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &effects).expect("it is known");
        for (value, p) in [100.0, 20.0].into_iter().zip(&mut model.parameters) {
            p.value = value;
        }
        model.parameters[0].prior = Some((100.0, 5.0));
        let scaled = vec![vec![25.0, 5.0], vec![5.0, 1.0 + 0.04]];
        let told = |runs: &[Run]| {
            let mut findings = Vec::new();
            let found = of_covariance(&model, &scaled, runs, &mut findings).expect("it is a covariance");
            (found.condition_number_scaled, findings.iter().map(|f| f.code).collect::<Vec<_>>())
        };
        let (condition, codes) = told(&[Run::default()]);
        assert!((condition - 1.0).abs() < 1e-9 && codes.contains(&"M227"), "{condition} {codes:?}");
        // a commanded thrust gives the scale
        let mut driven = Run::default();
        driven.signals.insert("tau_u".into(), Signal::new(vec![0.0, 1.0].into(), vec![0.0, 10.0]));
        let (condition, codes) = told(&[driven]);
        assert!(condition > 5.0 && !codes.contains(&"M227"), "{condition} {codes:?}");
    }
}
