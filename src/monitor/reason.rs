//! Why a model no longer fits: what each change could explain of the disagreement.
//!
//! ```text
//! S = Σ xᵀr,   I = Σ xᵀx   over the windows that are off       δθ = I⁻¹ S,   explained = Sᵀ I⁻¹ S / Σ rᵀr
//! ```
//!
//! x: what a little change of a parameter, or a little of an absent effect, adds to the log, the initial state of each
//! window projected out; r: residual. The same products that the discovery scores its candidates with, but nothing of
//! the model is refitted: here its parameters are known, and a change of one of them is a reason like any other.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::discover::{Own, Probe, candidates, score};
use crate::effects::Family;
use crate::estimate::output_error::{OutputErrorError, OutputErrorFit, OutputErrorOptions, Problem};
use crate::model::Model;
use crate::run::Run;

/// A change that would explain the disagreement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reason {
    /// Term whose parameter has changed, or effect that has come: `inertia@surge`, `thruster_fault@surge`; several
    /// terms that change together are joined by ` + `.
    pub id: String,
    /// Whether the term is in the model.
    pub known: bool,
    /// Symbol of the first parameter.
    pub parameter: String,
    /// Its value in the model; `null` for an effect that has come.
    pub before: Option<f64>,
    /// Its value after the change, to first order; `null` for the shape of an effect.
    pub after: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// Share of the disagreement that it explains, 0 to 1.
    pub explained: f64,
    /// What has happened most likely, in words.
    pub meaning: String,
}

/// Number of reasons that are told.
const TOLD: usize = 6;

/// A reason explains at least this share.
const LEAST: f64 = 0.05;

/// What a parameter has to explain to be worth it, in units of the noise: as in the search for missing effects.
const WORTH: f64 = 4.0;

/// Ranks the changes that would explain what `fit` (all parameters held) leaves in the segments `off`.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub fn reasons(
    model: &Model,
    fit: &OutputErrorFit,
    runs: &[Run],
    off: &[bool],
    fitting: &OutputErrorOptions,
) -> Result<Vec<Reason>, OutputErrorError> {
    let mut free = fit.model.clone();
    for p in &mut free.parameters {
        p.fixed = false;
        p.prior = None;
        (p.min, p.max) = (f64::NEG_INFINITY, f64::INFINITY);
    }
    let problem = Problem::new(&free, runs, fitting)?;
    let problem = Problem { sigma: fit.problem.sigma.clone(), ..problem };
    let fit = OutputErrorFit { model: free, problem, ..fit.clone() };
    let list = candidates(&fit.model, runs, &[]);
    let (probes, own) = score(&fit, runs, &list, fitting)?;
    let all: f64 = own.iter().zip(off).filter(|(_, off)| **off).map(|(o, _)| o.rr).sum();
    if all.is_nan() || all <= 0.0 {
        return Ok(Vec::new());
    }
    let mut found: Vec<(Reason, usize)> = Vec::new();
    let directions = &fit.problem.dynamics.directions;
    let known = |columns: &[usize]| of_parameters(model, directions, columns, &own, off);
    for k in 0..directions.len() {
        found.extend(known(&[k]).map(|r| (r, 1)));
    }
    // what changes together: all inertias, all drags
    for kind in ["inertia", "drag"] {
        let of =
            |p: usize| model.parameters[p].effect == kind || model.parameters[p].effect.ends_with(&format!("_{kind}"));
        let columns: Vec<usize> = (0..directions.len()).filter(|k| of(directions[*k])).collect();
        if columns.len() > 1 {
            found.extend(known(&columns).map(|r| (r, columns.len())));
        }
    }
    let mut best: Vec<Option<(Reason, usize)>> = vec![None; list.len()];
    for probe in probes.iter().filter(|p| !p.per_run) {
        let candidate = &list[probe.candidate];
        let effect = &candidate.terms[0].0;
        let Some((delta, explained)) = of_probe(probe, off) else { continue };
        if best[probe.candidate].as_ref().is_some_and(|(r, _)| r.explained >= explained) {
            continue;
        }
        let specs = effect.parameters(candidate.terms[0].1);
        let shape = candidate.blended || specs.first().is_none_or(|s| !s.is_linear());
        let reason = Reason {
            id: candidate.name(),
            known: false,
            parameter: specs.first().map(|s| s.name.clone()).unwrap_or_default(),
            before: None,
            after: (!shape).then(|| specs[0].neutral + delta[0]),
            unit: specs.first().map(|s| s.dimension.to_string()).unwrap_or_default(),
            explained,
            meaning: meaning(effect.about().id, effect.about().family).into(),
        };
        best[probe.candidate] = Some((reason, delta.len()));
    }
    found.extend(best.into_iter().flatten());
    let most = found.iter().map(|(r, _)| r.explained).fold(0.0, f64::max);
    let samples: usize = fit.linearised.iter().zip(off).filter(|(_, off)| **off).map(|(l, _)| l.samples).sum();
    // noise as the best reason leaves it
    let noise = ((all - most) / samples.max(1) as f64).max(1.0);
    let worth = |(reason, parameters): &(Reason, usize)| reason.explained - WORTH * noise * *parameters as f64;
    found.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
    let mut told: Vec<Reason> = Vec::new();
    for (mut reason, _) in found {
        reason.explained = (reason.explained / all).min(1.0);
        if reason.explained >= LEAST && told.len() < TOLD {
            told.push(reason);
        }
    }
    Ok(told)
}

/// A change of the parameters at these columns of the model's own sensitivities.
fn of_parameters(model: &Model, directions: &[usize], columns: &[usize], own: &[Own], off: &[bool]) -> Option<Reason> {
    let p = directions.len();
    let mut information = DMatrix::<f64>::zeros(columns.len(), columns.len());
    let mut slope = DVector::<f64>::zeros(columns.len());
    for (own, _) in own.iter().zip(off).filter(|(_, off)| **off) {
        for (i, a) in columns.iter().enumerate() {
            slope[i] += own.xr[*a];
            for (j, b) in columns.iter().enumerate() {
                information[(i, j)] += own.xx[a * p + b];
            }
        }
    }
    let (delta, explained) = solved(&information, &slope)?;
    let first = &model.parameters[directions[columns[0]]];
    let mut names: Vec<&str> = columns.iter().map(|c| model.parameters[directions[*c]].term.as_str()).collect();
    names.dedup();
    let term = &model.terms[model.term(&first.term)?];
    Some(Reason {
        id: names.join(" + "),
        known: true,
        parameter: first.spec.name.clone(),
        before: Some(first.value),
        after: Some(first.value + delta[0]),
        unit: first.spec.dimension.to_string(),
        explained,
        meaning: meaning(&first.effect, term.effect.about().family).into(),
    })
}

/// What a probe of an absent effect explains.
fn of_probe(probe: &Probe, off: &[bool]) -> Option<(DVector<f64>, f64)> {
    let k = probe.segments.first()?.zr.len();
    let mut information = DMatrix::<f64>::zeros(k, k);
    let mut slope = DVector::<f64>::zeros(k);
    for (products, _) in probe.segments.iter().zip(off).filter(|(_, off)| **off) {
        information += DMatrix::from_row_slice(k, k, &products.zz);
        slope += DVector::from_column_slice(&products.zr);
    }
    solved(&information, &slope)
}

/// δ = I⁻¹ S and Sᵀ I⁻¹ S; `None` where the windows say nothing of it.
fn solved(information: &DMatrix<f64>, slope: &DVector<f64>) -> Option<(DVector<f64>, f64)> {
    let scale = information.diagonal().map(|d| if d > 0.0 { d.sqrt() } else { 1.0 });
    let scaled = DMatrix::from_fn(scale.len(), scale.len(), |i, j| information[(i, j)] / (scale[i] * scale[j]));
    let right = slope.component_div(&scale);
    let inverse = scaled.pseudo_inverse(1e-9).ok()?;
    let delta = (inverse * &right).component_div(&scale);
    let explained = slope.dot(&delta);
    (explained.is_finite() && explained > 0.0).then_some((delta, explained))
}

/// What a change of an effect most likely means.
fn meaning(id: &str, family: Family) -> &'static str {
    match (family, id) {
        (Family::Actuator, _) => {
            "the thrust has changed: a thruster fails or is fouled, its rope or the battery is at its end"
        }
        (Family::Environment, _) => "the water moves, or a tether pulls",
        (Family::Sensor, _) => "a sensor says something else than it did",
        (_, "inertia" | "added_mass_coupling" | "added_mass_amplitude") => {
            "the mass or where it sits has changed: payload, ballast, water inside"
        }
        (_, "bias" | "trim_offset") => "a steady force has come or gone: trim, tether, a stuck thruster",
        (_, id) if id.starts_with("restoring") => "weight or buoyancy has changed: payload, ballast, water inside",
        (_, id) if id.starts_with("coriolis") || id == "fluid_memory" => "the shape in the water has changed",
        _ => "the resistance has changed: fouling, something caught or lost",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_change_is_that_of_least_squares_whatever_the_units() {
        let information = DMatrix::from_row_slice(2, 2, &[4.0e6, 1.0e3, 1.0e3, 1.0]);
        let (delta, explained) = solved(&information, &DVector::from_vec(vec![2.0e3, 1.0])).unwrap();
        // (4e6, 1e3; 1e3, 1) δ = (2e3, 1), by hand: δ = (1/3e3, 2/3)
        assert!((delta[0] - 1.0 / 3.0e3).abs() < 1e-15 && (delta[1] - 2.0 / 3.0).abs() < 1e-12, "{delta}");
        assert!((explained - (2.0 / 3.0 + 2.0 / 3.0)).abs() < 1e-12);
        assert!(solved(&DMatrix::zeros(1, 1), &DVector::zeros(1)).is_none());
    }
}
