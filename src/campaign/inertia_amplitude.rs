//! Dependence of the virtual mass on the amplitude of the runs.

use serde::Serialize;

use super::codes;
use super::load::Campaign;
use crate::effects::{channel, id};
use crate::estimate::identifiability::{RunByRun, run_by_run, trend};
use crate::estimate::output_error::OutputErrorFit;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::run::Run;
use crate::wording::p_value;

/// The inertia of one degree of freedom run by run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InertiaAgainstAmplitude {
    /// Degree of freedom.
    pub dof: Dof,
    /// Runs that oscillate in it and show its inertia.
    pub runs: Vec<InertiaOfRun>,
    /// Slope of the inertia against KC, kg or kg·m² per unit.
    pub slope: f64,
    /// Standard deviation of `slope`.
    pub slope_std: f64,
    /// Probability of such a slope by chance, if there is no trend.
    pub p_value: f64,
}

/// The inertia that one run shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InertiaOfRun {
    /// Name of the run.
    pub run: String,
    /// Keulegan-Carpenter number of the run.
    pub kc: f64,
    /// Virtual mass or moment of inertia, SI.
    pub value: f64,
    /// Standard deviation of `value`, SI.
    pub std: f64,
    /// C_m = (m_v − m)/(ρ ∇), if mass and volume are known; translations only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub added_mass_coefficient: Option<f64>,
}

/// Accepted probability of a trend by chance, over all degrees of freedom together.
const LEVEL: f64 = 0.01;

/// Error below which it counts as small, in units of the noise.
const FAR: f64 = 2.0;

/// Least ratio of the greatest to the smallest KC at which runs can show a trend.
const SPREAD: f64 = 1.3;

/// Whether a separate inertia for each run explains most of the error that a common one leaves, or
/// leaves little (root mean squares in units of the noise).
fn explains(common: f64, apart: f64) -> bool {
    apart < FAR || apart * apart - 1.0 < 0.5 * (common * common - 1.0)
}

/// Returns the inertias run by run against KC, for the degrees of freedom in which three runs or
/// more oscillate at different KC.
pub(super) fn against_amplitude(
    campaign: &Campaign,
    fit: &OutputErrorFit,
    runs: &[Run],
    findings: &mut Vec<Finding>,
) -> Vec<InertiaAgainstAmplitude> {
    let asked: Vec<(Dof, usize)> = fit
        .model
        .dofs
        .iter()
        .filter(|dof| spread(runs, **dof))
        .filter_map(|dof| Some((*dof, fit.model.inertia(*dof)?)))
        .filter(|(_, p)| !fit.model.parameters[*p].fixed)
        .collect();
    if asked.is_empty() {
        return Vec::new();
    }
    let parameters: Vec<usize> = asked.iter().map(|(_, p)| *p).collect();
    let Ok(found) = run_by_run(fit, runs, &campaign.options.output_error, &parameters) else { return Vec::new() };
    let of_dof =
        |((dof, _), found): (&(Dof, usize), Option<RunByRun>)| of(campaign, fit, runs, *dof, &found?, findings);
    asked.iter().zip(found).filter_map(of_dof).collect()
}

/// Returns KC of a run in `dof`; `None` if it does not oscillate.
fn number(run: &Run, dof: Dof) -> Option<f64> {
    run.signal(&channel::keulegan_carpenter(dof))?.values().first().copied().filter(|kc| *kc > 0.0)
}

fn spread(runs: &[Run], dof: Dof) -> bool {
    let numbers: Vec<f64> = runs.iter().filter_map(|run| number(run, dof)).collect();
    let greatest = numbers.iter().fold(0.0, |m: f64, k| m.max(*k));
    let smallest = numbers.iter().fold(f64::INFINITY, |m: f64, k| m.min(*k));
    numbers.len() > 2 && greatest > SPREAD * smallest
}

/// Returns the inertia of `dof` run by run against KC; `None` if fewer than three oscillating runs
/// show it.
fn of(
    campaign: &Campaign,
    fit: &OutputErrorFit,
    runs: &[Run],
    dof: Dof,
    found: &RunByRun,
    findings: &mut Vec<Finding>,
) -> Option<InertiaAgainstAmplitude> {
    let parameter = fit.model.inertia(dof)?;
    let kept: Vec<usize> = (0..found.runs.len()).filter(|k| number(&runs[found.runs[*k]], dof).is_some()).collect();
    if kept.len() < 3 {
        return None;
    }
    let n = found.runs.len();
    let of_kept = RunByRun {
        runs: kept.iter().map(|k| found.runs[*k]).collect(),
        values: kept.iter().map(|k| found.values[*k]).collect(),
        covariance: kept
            .iter()
            .flat_map(|a| kept.iter().map(|b| found.covariance[a * n + b]).collect::<Vec<_>>())
            .collect(),
        left: found.left.clone(),
    };
    let numbers: Vec<f64> = of_kept.runs.iter().filter_map(|r| number(&runs[*r], dof)).collect();
    let line = trend(&of_kept, &numbers)?;
    let term = format!("{}@{dof}", id::ADDED_MASS_AMPLITUDE);
    if line.p_value < LEVEL / fit.model.dofs.len() as f64 && fit.model.term(&term).is_none() {
        let (low, high) = numbers.iter().fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), k| (a.min(*k), b.max(*k)));
        let changes = format!(
            "the inertia in {dof} changes by {:.3} ± {:.3} {} per unit of KC over runs of KC {low:.2} to {high:.2} ({})",
            line.slope,
            line.std,
            fit.model.parameters[parameter].spec.dimension,
            p_value(line.p_value)
        );
        let output = fit.problem.dynamics.outputs.iter().position(|name| *name == dof.velocity());
        let of = |times: &[f64]| output.and_then(|k| times.get(k).copied()).unwrap_or(0.0);
        let (common, apart) = (of(&fit.times_noise()), of(&found.left));
        findings.push(if explains(common, apart) {
            let advice = format!("add the effect `{term}`, or use the model only at such amplitudes");
            Finding::new(&codes::INERTIA_AMPLITUDE, format!("{changes}: {advice}"))
        } else {
            let text = format!(
                "{changes}, but even with a separate inertia in each run the model is off by {apart:.1} times the \
                 noise: something else is missing, and the inertia compensates for it; look for that first \
                 (`hydrosysid discover`)"
            );
            Finding::new(&codes::INERTIA_AMPLITUDE, text)
        });
    }
    let displaced = campaign.vehicle.volume.map(|v| v * campaign.water.density).filter(|_| !dof.is_rotation());
    let coefficient = |m: f64| Some((m - campaign.vehicle.mass?) / displaced?);
    let m = kept.len();
    let rows = (0..m).map(|k| InertiaOfRun {
        run: runs[of_kept.runs[k]].name.clone(),
        kc: numbers[k],
        value: of_kept.values[k],
        std: of_kept.covariance[k * m + k].sqrt(),
        added_mass_coefficient: coefficient(of_kept.values[k]),
    });
    Some(InertiaAgainstAmplitude {
        dof,
        runs: rows.collect(),
        slope: line.slope,
        slope_std: line.std,
        p_value: line.p_value,
    })
}
