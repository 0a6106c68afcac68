//! Reason why a model no longer fits: how much of the innovations each change could explain.
//!
//! ```text
//! S = −Σ gᵀe,   I = Σ gᵀg   over the windows that are off       δ = I⁻¹ S,   explained = Sᵀ I⁻¹ S / (Σ eᵀe − n)
//! ```
//!
//! e: innovations over their standard deviations, n of them, whose sum of squares is n on average for a model that
//! fits; g: derivative of the innovations with respect to a parameter, or to the strength of an absent effect. The
//! columns are those by which the discovery scores its candidates, but the model is not refitted: here its parameters
//! are known, and a change of one of them is a reason like any other.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::chain::{Nature, nature, nature_at};
use crate::discover::{Columns, ModelOnRuns, Probe, candidates, in_chunks};
use crate::effects::Family;
use crate::estimate::filter_error::{Filtered, NoiseModel};
use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions};
use crate::model::Model;
use crate::run::Run;

/// A change that would explain the disagreement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reason {
    /// Term whose parameter has changed, or effect that has appeared: `inertia@surge`, `thruster_fault@surge`; several
    /// terms that change together are joined by ` + `.
    pub id: String,
    /// Whether the term is in the model.
    pub known: bool,
    /// Symbol of the first parameter.
    pub parameter: String,
    /// Its value in the model; `null` for an effect that has appeared.
    pub before: Option<f64>,
    /// Its value after the change, to first order; `null` for the shape of an effect.
    pub after: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// Share of the disagreement that it explains, 0 to 1.
    pub explained: f64,
    /// Most likely cause, in words.
    pub meaning: String,
}

/// Maximum number of reasons that are reported.
const TOLD: usize = 6;

/// Least share that a reason must explain.
const LEAST: f64 = 0.05;

/// Amount that each parameter must explain, in units of the noise: as in the search for missing effects.
const WORTH: f64 = 4.0;

/// Ranks the changes that would explain the innovations of `model` under `noise` in the windows that are `off`.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub fn reasons(
    model: &Model,
    noise: &NoiseModel,
    runs: &[Run],
    off: &[bool],
    fitting: &OutputErrorOptions,
) -> Result<Vec<Reason>, OutputErrorError> {
    let mut free = model.clone();
    for p in &mut free.parameters {
        p.fixed = false;
        p.prior = None;
        p.per_run.clear();
        (p.min, p.max) = (f64::NEG_INFINITY, f64::INFINITY);
    }
    let filtered = Filtered::in_windows(&free, runs, fitting)?;
    // the search is for the behaviour of a changed vehicle: no innovation is clipped
    let at = ModelOnRuns { filtered: &filtered, model: &free, noise, limit: f64::INFINITY };
    let list = candidates(&free, runs, &[]);
    let chunks = in_chunks(at, runs, &list, fitting, |_, columns| Off::new(columns, off))?;
    let Some(first) = chunks.first() else { return Ok(Vec::new()) };
    let innovations = first.sum[(first.sum.nrows() - 1, first.sum.nrows() - 1)];
    let samples: usize =
        off.iter().enumerate().filter(|(_, off)| **off).map(|(k, _)| filtered.problem.samples_in(k)).sum();
    let samples = samples as f64;
    let mut found: Vec<(Reason, usize)> = Vec::new();
    let directions = &filtered.problem.dynamics.directions;
    let known = |columns: &[usize]| of_parameters(model, directions, columns, first);
    for k in 0..directions.len() {
        found.extend(known(&[k]).map(|r| (r, 1)));
    }
    // parameters that change together: all inertias, all drags
    for kinds in [&[Nature::Inertia][..], &[Nature::Drag, Nature::CrossDrag]] {
        let of = |p: usize| model.term_of(p).is_some_and(|term| kinds.contains(&nature(model, term)));
        let columns: Vec<usize> = (0..directions.len()).filter(|k| of(directions[*k])).collect();
        if columns.len() > 1 {
            found.extend(known(&columns).map(|r| (r, columns.len())));
        }
    }
    let mut best: Vec<Option<(Reason, usize)>> = vec![None; list.len()];
    for chunk in &chunks {
        let mut next = directions.len();
        for probe in &chunk.probes {
            let columns: Vec<usize> = (next..next + probe.width).collect();
            next += probe.width;
            let better = |explained: f64| best[probe.candidate].as_ref().is_none_or(|(r, _)| r.explained < explained);
            let Some((delta, explained)) = chunk.explained(&columns).filter(|(_, e)| !probe.per_run && better(*e))
            else {
                continue;
            };
            let candidate = &list[probe.candidate];
            let effect = &candidate.terms[0].0;
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
                meaning: meaning(nature_at(effect.as_ref(), candidate.terms[0].1, model), effect.about().family).into(),
            };
            best[probe.candidate] = Some((reason, delta.len()));
        }
    }
    found.extend(best.into_iter().flatten());
    let most = found.iter().map(|(r, _)| r.explained).fold(0.0, f64::max);
    // variance of the innovations that the best reason leaves
    let noise = ((innovations - most) / samples.max(1.0)).max(1.0);
    let worth = |(reason, parameters): &(Reason, usize)| reason.explained - WORTH * noise * *parameters as f64;
    found.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
    let beyond = (innovations - samples).max(most);
    let mut told: Vec<Reason> = Vec::new();
    for (mut reason, _) in found {
        reason.explained /= beyond;
        if reason.explained >= LEAST && told.len() < TOLD {
            told.push(reason);
        }
    }
    Ok(told)
}

/// Products of a chunk of candidates over the windows that are off.
struct Off {
    probes: Vec<Probe>,
    sum: DMatrix<f64>,
}

impl Off {
    fn new(columns: Columns, off: &[bool]) -> Off {
        let n = columns.products.first().map_or(0, faer::Mat::nrows);
        let windows = || columns.products.iter().zip(off).filter(|(_, off)| **off);
        let sum = DMatrix::from_fn(n, n, |i, j| windows().map(|(window, _)| window[(i, j)]).sum());
        Off { probes: columns.probes, sum }
    }

    /// δ = I⁻¹ S of these columns together and Sᵀ I⁻¹ S; `None` if the windows hold no information on them.
    fn explained(&self, columns: &[usize]) -> Option<(DVector<f64>, f64)> {
        let e = self.sum.nrows().checked_sub(1)?;
        let of = |k: usize| columns[k];
        let scale = DVector::from_fn(columns.len(), |k, _| {
            let d = self.sum[(of(k), of(k))];
            if d > 0.0 { d.sqrt() } else { 1.0 }
        });
        let scaled =
            DMatrix::from_fn(scale.len(), scale.len(), |i, j| self.sum[(of(i), of(j))] / (scale[i] * scale[j]));
        let slope = DVector::from_fn(scale.len(), |k, _| -self.sum[(of(k), e)]);
        let inverse = scaled.pseudo_inverse(1e-9).ok()?;
        let delta = (inverse * slope.component_div(&scale)).component_div(&scale);
        let explained = slope.dot(&delta);
        (explained.is_finite() && explained > 0.0).then_some((delta, explained))
    }
}

/// A change of the model's own parameters at these columns of its sensitivities.
fn of_parameters(model: &Model, directions: &[usize], columns: &[usize], off: &Off) -> Option<Reason> {
    let (delta, explained) = off.explained(columns)?;
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
        meaning: meaning(nature(model, term), term.effect.about().family).into(),
    })
}

/// Most likely cause of a change of an effect.
fn meaning(nature: Nature, family: Family) -> &'static str {
    match (family, nature) {
        (Family::Actuator, _) => {
            "the thrust has changed: a thruster fails, is fouled or has caught a rope, or the battery is nearly empty"
        }
        (Family::Environment, _) => "the water moves, or a tether pulls",
        (Family::Sensor, _) => "a sensor reads differently than before",
        (_, Nature::Inertia) => "the mass or its location has changed: payload, ballast, water inside",
        (_, Nature::Steady) => "a steady force has come or gone: trim, tether, a stuck thruster",
        (_, Nature::Restoring) => "weight or buoyancy has changed: payload, ballast, water inside",
        (_, Nature::Coriolis | Nature::Memory) => "the wetted shape has changed",
        _ => "the resistance has changed: fouling, something caught or lost",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Products of two columns and the innovations, −S in the last of them.
    fn products(information: [f64; 3], slope: [f64; 2]) -> Off {
        let [a, b, c] = information;
        let sum = DMatrix::from_row_slice(3, 3, &[a, b, -slope[0], b, c, -slope[1], -slope[0], -slope[1], 10.0]);
        Off { probes: Vec::new(), sum }
    }

    #[test]
    fn the_change_is_that_of_least_squares_whatever_the_units() {
        let (delta, explained) = products([4.0e6, 1.0e3, 1.0], [2.0e3, 1.0]).explained(&[0, 1]).unwrap();
        // (4e6, 1e3; 1e3, 1) δ = (2e3, 1), by hand: δ = (1/3e3, 2/3)
        assert!((delta[0] - 1.0 / 3.0e3).abs() < 1e-15 && (delta[1] - 2.0 / 3.0).abs() < 1e-12, "{delta}");
        assert!((explained - (2.0 / 3.0 + 2.0 / 3.0)).abs() < 1e-12);
        assert!(products([0.0; 3], [0.0; 2]).explained(&[0]).is_none());
    }
}
