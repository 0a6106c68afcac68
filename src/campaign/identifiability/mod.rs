//! Identifiability of the parameters of a fit, in numbers and in words.

use std::collections::BTreeMap;

use serde::Serialize;

mod covariance;

pub(super) use covariance::of_covariance;

use super::codes;
use super::inertia_amplitude::{InertiaAgainstAmplitude, against_amplitude};
use super::load::Campaign;
use crate::effects::{Coriolis, id};
use crate::estimate::identifiability::{Collinearity, collinearity, factor_of, halves, shares};
use crate::estimate::output_error::OutputErrorFit;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::Run;
use crate::wording::listed;

/// What the data of a fit can determine and what it cannot; the key `identifiability` of
/// `hydrosysid fit --json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Identifiability {
    /// cond(J) with columns of unit length, over the common unknowns and those of each run.
    pub condition_number_scaled: f64,
    /// Each estimated parameter that all runs share.
    pub parameters: Vec<Believable>,
    /// Parameters that this data does not separate.
    pub groups: Vec<Group>,
    /// Pairs of parameters with correlated estimates, |ρ| ≥ 0.9.
    pub correlations: Vec<Correlation>,
    /// Belsley's condition indices, the greatest first, with the share of each parameter's variance.
    pub condition_indices: Vec<Direction>,
    /// Virtual masses and moments of inertia of each run against its Keulegan-Carpenter number.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inertia_against_amplitude: Vec<InertiaAgainstAmplitude>,
    /// Estimates with segments of other lengths; only in a thorough fit.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub segment_lengths: Vec<OtherLength>,
    /// Estimates with longer windows of the rows; only in a thorough fit by rows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub windows: Vec<OtherWindow>,
    /// Profile likelihoods of the doubtful parameters; only in a thorough fit.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub profiles: Vec<ProfileOf>,
}

/// Evidence for one estimate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Believable {
    /// Term: `quadratic_drag@surge`.
    pub term: String,
    /// Symbol.
    pub name: String,
    /// Standard deviation over that with all other parameters known; 1 if no other parameter acts
    /// alike.
    pub inflation: f64,
    /// Share of the force in its balance that the term carries; `null` if it cannot be determined.
    pub force_share: Option<f64>,
    /// Estimate from the first half of each run, SI.
    pub first_half: Option<f64>,
    /// Estimate from the second half of each run, SI.
    pub second_half: Option<f64>,
    /// Difference of the two halves over its standard deviation.
    pub halves_z: Option<f64>,
}

/// Parameters that the data does not separate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Group {
    /// Names of the parameters, with their terms.
    pub terms: Vec<String>,
    /// Condition index of the direction in which they are known worst.
    pub index: f64,
    /// The run that would separate them.
    pub run: String,
}

/// Two parameters with correlated estimates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Correlation {
    /// The first parameter, with its term.
    pub a: String,
    /// The second parameter, with its term.
    pub b: String,
    /// ρ.
    pub correlation: f64,
}

/// One direction of Belsley's decomposition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Direction {
    /// Condition index.
    pub index: f64,
    /// Share of the variance, by parameter and term.
    pub proportions: BTreeMap<String, f64>,
}

/// Estimates with segments of another length.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OtherLength {
    /// Length of the segments, s.
    pub segment: f64,
    /// Change of each estimate over its standard deviation, by parameter and term.
    pub change: BTreeMap<String, f64>,
}

/// Estimates from rows over other windows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OtherWindow {
    /// Length of the windows, in units of those of the fit.
    pub times: usize,
    /// Change of each estimate over its standard deviation, by parameter and term.
    pub change: BTreeMap<String, f64>,
}

/// Profile likelihood of one parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ProfileOf {
    /// Term.
    pub term: String,
    /// Symbol.
    pub name: String,
    /// Values at which it was held, SI.
    pub values: Vec<f64>,
    /// Increase of the cost there, χ² with one degree of freedom.
    pub rise: Vec<f64>,
    /// 95 % confidence interval, SI; `null` on a side on which the data gives no bound within five
    /// standard deviations.
    pub interval: [Option<f64>; 2],
}

/// Magnitude of a correlation from which a pair is reported.
const TOGETHER: f64 = 0.9;
/// Share of the force below which an uncertain term does no harm.
const HARMLESS: f64 = 0.02;
/// Relative standard deviation above which an estimate is uncertain.
pub(super) const UNCERTAIN: f64 = 0.5;

/// Returns the part of the identifiability that needs no further fit.
pub(super) fn of_fit(
    campaign: &Campaign,
    fit: &OutputErrorFit,
    runs: &[Run],
    findings: &mut Vec<Finding>,
) -> Option<Identifiability> {
    let model = &fit.model;
    let unknowns = &fit.problem.unknowns;
    let known = collinearity(&factor_of(fit))?;
    let halves = halves(fit);
    let share = shares(model, runs);
    let name = |k: usize| model.parameters[unknowns[k].parameter].full_name();
    let mut parameters = Vec::new();
    for (k, unknown) in unknowns.iter().enumerate().filter(|(_, u)| u.run.is_none()) {
        let p = &model.parameters[unknown.parameter];
        let read = model.terms.iter().filter(|t| t.parameters.contains(&unknown.parameter));
        let force_share = read.filter_map(|t| share.get(&t.name())).copied().reduce(f64::max);
        let half = |of: fn(&crate::estimate::identifiability::Halves) -> &Vec<f64>| halves.as_ref().map(|h| of(h)[k]);
        findings.extend(harmless(model, unknown.parameter, force_share));
        parameters.push(Believable {
            term: p.term.clone(),
            name: p.spec.name.clone(),
            inflation: known.inflation[k],
            force_share,
            first_half: half(|h| &h.first),
            second_half: half(|h| &h.second),
            halves_z: half(|h| &h.z),
        });
        if let Some(h) = halves.as_ref().filter(|h| h.z[k].abs() > h.limit) {
            findings.push(halves_differ(model, unknown.parameter, [h.first[k], h.second[k]], h.z[k]));
        }
    }
    let indices: Vec<usize> = unknowns.iter().map(|u| u.parameter).collect();
    let groups = groups(model, &known, &indices, findings);
    let p = unknowns.len();
    let correlations = correlations(model, &indices, |i, j| fit.covariance[i * p + j]);
    coriolis(fit, findings);
    let directions = known.indices.iter().rev().map(|one| Direction {
        index: one.index,
        proportions: one.proportions.iter().enumerate().map(|(k, share)| (name(k), *share)).collect(),
    });
    Some(Identifiability {
        condition_number_scaled: known.indices.iter().map(|i| i.index).fold(1.0, f64::max),
        parameters,
        groups,
        correlations,
        condition_indices: directions.collect(),
        inertia_against_amplitude: against_amplitude(campaign, fit, runs, findings),
        segment_lengths: Vec::new(),
        windows: Vec::new(),
        profiles: Vec::new(),
    })
}

/// Returns the finding that a parameter is not resolved but harmless, if its term carries hardly
/// any force.
fn harmless(model: &Model, parameter: usize, force_share: Option<f64>) -> Option<Finding> {
    let p = &model.parameters[parameter];
    let std = p.std.unwrap_or(0.0);
    let share = force_share.filter(|share| *share < HARMLESS && std > UNCERTAIN * p.value.abs())?;
    let text = format!(
        "{}: {:.3e} ± {std:.1e} {} is not resolved, but harmless: it carries {:.1} % of the force in its balance",
        model.parameters[parameter].full_name(),
        p.value,
        p.spec.dimension,
        100.0 * share
    );
    Some(Finding::new(&codes::HARMLESS, text))
}

/// Returns the finding that the halves of the runs differ.
pub(super) fn halves_differ(model: &Model, parameter: usize, halves: [f64; 2], z: f64) -> Finding {
    let text = format!(
        "{}: the first halves of the runs give {:.4e}, the second {:.4e} {}, {:.1} standard errors apart: something \
         changes during a run, or an effect is missing",
        model.parameters[parameter].full_name(),
        halves[0],
        halves[1],
        model.parameters[parameter].spec.dimension,
        z.abs()
    );
    Finding::new(&codes::HALVES, text)
}

/// Returns groups of parameters that the data does not separate; `unknowns` are the indices of the
/// unknowns in the model.
fn groups(model: &Model, known: &Collinearity, unknowns: &[usize], findings: &mut Vec<Finding>) -> Vec<Group> {
    let group = |(members, index): &(Vec<usize>, f64)| {
        let members: Vec<usize> = members.iter().map(|k| unknowns[*k]).collect();
        let terms: Vec<String> = members.iter().map(|p| model.parameters[*p].full_name()).collect();
        let run = told_apart_by(model, &members);
        let text = format!("this data does not separate {} (condition index {index:.0}): {run}", listed(&terms));
        findings.push(Finding::new(&codes::NOT_APART, text));
        Group { terms, index: *index, run }
    };
    known.groups.iter().map(group).collect()
}

/// Returns pairs of unknowns with correlated estimates; `at` is their covariance.
fn correlations(model: &Model, unknowns: &[usize], at: impl Fn(usize, usize) -> f64) -> Vec<Correlation> {
    let p = unknowns.len();
    let mut found = Vec::new();
    for i in 0..p {
        for j in i + 1..p {
            let correlation = at(i, j) / (at(i, i) * at(j, j)).sqrt();
            if correlation.abs() >= TOGETHER {
                let name = |k: usize| model.parameters[unknowns[k]].full_name();
                found.push(Correlation { a: name(i), b: name(j), correlation });
            }
        }
    }
    found
}

/// Describes the runs that show the effects of these parameters, according to the catalogue.
fn told_apart_by(model: &Model, parameters: &[usize]) -> String {
    let mut told: Vec<String> = Vec::new();
    for p in parameters {
        let term = model.terms.iter().find(|t| t.parameters.contains(p));
        if let Some(term) = term {
            let one = format!("`{}` is shown by {}", term.name(), term.effect.about().shown_by);
            if !told.contains(&one) {
                told.push(one);
            }
        }
    }
    told.join("; ")
}

/// Adds findings about free Coriolis coefficients: k_uv beside m_v − m_u, and the work that they do
/// together, which should be zero.
fn coriolis(fit: &OutputErrorFit, findings: &mut Vec<Finding>) {
    let model = &fit.model;
    let p = fit.problem.unknowns.len();
    let of = |name: &str| {
        let index = model.parameter_of(name)?;
        let unknown = fit.problem.unknowns.iter().position(|u| u.parameter == index && u.run.is_none());
        Some((model.parameters[index].value, unknown))
    };
    // value and standard deviation of a sum of estimates with these signs
    let sum = |parts: &[(String, f64)]| -> Option<(f64, f64)> {
        let found: Vec<((f64, Option<usize>), f64)> =
            parts.iter().map(|(name, sign)| Some((of(name)?, *sign))).collect::<Option<_>>()?;
        let value = found.iter().map(|((v, _), sign)| v * sign).sum();
        let mut variance = 0.0;
        for ((_, a), sa) in &found {
            for ((_, b), sb) in &found {
                if let (Some(a), Some(b)) = (a, b) {
                    variance += sa * sb * fit.covariance[a * p + b];
                }
            }
        }
        Some((value, f64::max(variance, 0.0).sqrt()))
    };
    if model.coriolis != Coriolis::Free {
        return;
    }
    let mass = |dof: Dof| format!("{}@{dof}", id::INERTIA);
    let munk = [(mass(Dof::Sway), 1.0), (mass(Dof::Surge), -1.0)];
    if let (Some((k, k_std)), Some((m, m_std))) = (sum(&[(id::coriolis(Dof::Yaw), 1.0)]), sum(&munk)) {
        let text = format!(
            "k_uv = {k:.1} ± {k_std:.1} kg compares with m_v − m_u = {m:.1} ± {m_std:.1} kg: equal in an ideal fluid; \
             k_uv also contains lift on the hull"
        );
        findings.push(Finding::new(&codes::MUNK, text));
    }
    let power = [(Dof::Surge, 1.0), (Dof::Sway, -1.0), (Dof::Yaw, -1.0)].map(|(row, sign)| (id::coriolis(row), sign));
    if let Some((value, std)) = sum(&power).filter(|(value, std)| *std > 0.0 && value.abs() > 3.0 * std) {
        let text = format!(
            "the free Coriolis terms do work: their coefficients leave {value:.1} ± {std:.1} kg of u v r, inertia \
             alone would leave 0; they contain lift or a missing effect"
        );
        findings.push(Finding::new(&codes::CORIOLIS_WORKS, text));
    }
}
