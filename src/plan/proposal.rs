//! A plan: selected runs, and the standard deviations that they will give.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

use super::codes;
use super::grid::{GridOptions, grid};
use super::information::{Information, shared};
use super::instrument;
use super::manoeuvre::{Manoeuvre, ManoeuvreError};
use super::sail::{Course, Sailed};
use super::selection::select;
use crate::estimate::filter_error::RandomForce;
use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::tank::TankError;

/// Wanted standard deviation of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wish {
    /// Index of the parameter in the model.
    pub parameter: usize,
    /// Wanted standard deviation, SI.
    pub std: f64,
}

/// Options of a plan.
#[derive(Debug, Clone, Default)]
pub struct PlanOptions {
    /// Greatest force of each degree of freedom, N and N·m; a degree of freedom without one is not pushed.
    pub limits: BTreeMap<Dof, f64>,
    /// Maximum number of runs.
    pub most: usize,
    /// Greatest horizontal distance from the start of a run, m; unlimited when absent.
    pub room: Option<f64>,
    /// Options of the grid of candidates.
    pub grid: GridOptions,
    /// Options of the fit that the data will be used for.
    pub fitting: OutputErrorOptions,
    /// Random force that will act on the vehicle, possibly none, if the data will be fitted by filter error; `None`
    /// if by output error.
    pub forces: Option<Vec<RandomForce>>,
    /// Covariance of the shared free parameters (row-major, SI) from other data that will be fitted together with
    /// these runs.
    pub known: Option<Vec<f64>>,
}

/// A plan.
#[derive(Debug, Clone)]
pub struct Proposal {
    /// The runs, the most valuable first.
    pub runs: Vec<ProposedRun>,
    /// Predicted accuracy of each parameter with all runs together.
    pub parameters: Vec<Predicted>,
    /// Predicted covariance of `parameters`, row-major, SI; `None` if the runs do not identify all of them.
    pub covariance: Option<Vec<f64>>,
    /// Number of candidates that were judged.
    pub candidates: usize,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
}

/// A run of a plan.
#[derive(Debug, Clone)]
pub struct ProposedRun {
    /// The simulated run, with the command history and the log of perfect instruments.
    pub sailed: Sailed,
    /// Greatest ratio of predicted to wanted standard deviation after this run and those before it; `None` while a
    /// wanted parameter is not identifiable.
    pub worst: Option<f64>,
}

/// Predicted accuracy of one parameter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Predicted {
    /// Index in the model.
    pub parameter: usize,
    /// Value in the model, SI.
    pub value: f64,
    /// Wanted standard deviation, SI.
    pub wanted: Option<f64>,
    /// Predicted standard deviation, SI; `None` if the runs do not distinguish the parameter from others.
    pub std: Option<f64>,
}

/// Error of planning.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlanError {
    /// No parameter is free.
    #[error("all runs share no free parameter of the model: there is nothing to plan for")]
    NothingFree,
    /// No degree of freedom has a limit of thrust.
    #[error("no degree of freedom has a limit of thrust: give at least one, such as --limit surge=100")]
    NoLimit,
    /// No candidate can be carried out.
    #[error("none of the {candidates} candidate runs can be carried out: {reason}")]
    NoCandidate {
        /// Number of candidates.
        candidates: usize,
        /// Reason why the last one was left out.
        reason: String,
    },
    /// A given run is invalid.
    #[error(transparent)]
    Manoeuvre(#[from] ManoeuvreError),
    /// A given run cannot be simulated.
    #[error(transparent)]
    Sail(#[from] TankError),
    /// A run logs nothing that the model predicts.
    #[error(transparent)]
    Information(#[from] OutputErrorError),
}

/// Greatest |θ| of a proposed run, rad: beyond it, Euler angles and trim are no longer ordinary.
const STEEPEST: f64 = 1.2;

/// Proposes the smallest number of runs that fulfils `wishes`, at most `options.most`.
///
/// # Errors
/// [`PlanError`] when no parameter is free, no limit of thrust is given, or no candidate can be carried out.
pub fn propose(course: &Course, wishes: &[Wish], options: &PlanOptions) -> Result<Proposal, PlanError> {
    let parameters = shared(&course.model);
    if parameters.is_empty() {
        return Err(PlanError::NothingFree);
    }
    let told = grid(&course.model, &options.limits, &options.grid);
    if told.is_empty() {
        return Err(PlanError::NoLimit);
    }
    let fitting = instrument::fitting(&options.fitting, &course.instruments, &course.model);
    let judged: Vec<Result<(Sailed, Information), String>> =
        told.par_iter().map(|one| judge(course, one, options, &fitting)).collect();
    let mut reason = String::new();
    let (mut sailed, mut information) = (Vec::new(), Vec::new());
    for one in judged {
        match one {
            Ok((run, known)) => {
                sailed.push(run);
                information.push(known);
            }
            Err(why) => reason = why,
        }
    }
    if sailed.is_empty() {
        return Err(PlanError::NoCandidate { candidates: told.len(), reason });
    }
    let known = known(&parameters, options);
    let wanted = wanted(&parameters, wishes);
    let mut chosen: Vec<Sailed> =
        select(&information, &known, &wanted, options.most).into_iter().map(|k| sailed[k].clone()).collect();
    number_names(&mut chosen);
    let mut plan = predicted(course, chosen, wishes, options)?;
    plan.candidates = told.len();
    if sailed.len() < told.len() {
        let text = format!("{} of {} candidate runs were left out: {reason}", told.len() - sailed.len(), told.len());
        plan.warnings.push(Finding::new(&codes::LEFT_OUT, text));
    }
    Ok(plan)
}

/// Predicts the accuracy that these runs will give.
///
/// # Errors
/// [`PlanError`] when a run is invalid, asks for more thrust than the vehicle has, or cannot be simulated.
pub fn predict(
    course: &Course,
    runs: &[Manoeuvre],
    wishes: &[Wish],
    options: &PlanOptions,
) -> Result<Proposal, PlanError> {
    if shared(&course.model).is_empty() {
        return Err(PlanError::NothingFree);
    }
    for run in runs {
        run.validate(&course.model, &options.limits)?;
    }
    let sailed = runs.par_iter().map(|run| course.sail(run)).collect::<Result<Vec<_>, _>>()?;
    predicted(course, sailed, wishes, options)
}

/// Simulates a candidate and computes its information; the error is the reason why it is left out.
fn judge(
    course: &Course,
    manoeuvre: &Manoeuvre,
    options: &PlanOptions,
    fitting: &OutputErrorOptions,
) -> Result<(Sailed, Information), String> {
    let sailed = course.sail(manoeuvre).map_err(|e| e.to_string())?;
    let name = &manoeuvre.name;
    if let Some(room) = options.room.filter(|room| sailed.reach > *room) {
        return Err(format!("`{name}` goes {:.0} m from its start, but only {room} m are available", sailed.reach));
    }
    if sailed.pitch > STEEPEST {
        return Err(format!("`{name}` pitches by {:.0}°", sailed.pitch.to_degrees()));
    }
    for (dof, limit) in &options.limits {
        let asked = sailed.run.signal(dof.force()).map_or(&[][..], |s| s.values());
        let most = asked.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        if most > limit * (1.0 + 1e-9) {
            return Err(format!(
                "`{name}` needs {most:.3} in {dof} to hold the pose, but the vehicle provides {limit:.3}"
            ));
        }
    }
    let information =
        Information::of(&course.model, &sailed.run, fitting, options.forces.as_deref()).map_err(|e| e.to_string())?;
    Ok((sailed, information))
}

fn known(parameters: &[usize], options: &PlanOptions) -> Information {
    let told = options.known.as_ref().and_then(|c| Information::of_covariance(parameters.to_vec(), c));
    told.unwrap_or_else(|| Information::none(parameters.to_vec()))
}

fn wanted(parameters: &[usize], wishes: &[Wish]) -> Vec<Option<f64>> {
    let of = |p: &usize| wishes.iter().find(|w| w.parameter == *p).map(|w| w.std);
    parameters.iter().map(of).collect()
}

/// Appends a number to the names of runs that share one.
fn number_names(chosen: &mut [Sailed]) {
    let names: Vec<String> = chosen.iter().map(|run| run.manoeuvre.name.clone()).collect();
    for (k, run) in chosen.iter_mut().enumerate() {
        let before = names[..k].iter().filter(|name| **name == names[k]).count();
        if names.iter().filter(|name| **name == names[k]).count() > 1 {
            run.manoeuvre.name = format!("{}_{}", names[k], before + 1);
            run.run.name.clone_from(&run.manoeuvre.name);
        }
    }
}

/// Ratio of a standard deviation to the parameter's size, or to the wanted deviation, from which it counts as unknown.
const UNKNOWN: f64 = 1e3;

fn predicted(
    course: &Course,
    sailed: Vec<Sailed>,
    wishes: &[Wish],
    options: &PlanOptions,
) -> Result<Proposal, PlanError> {
    let parameters = shared(&course.model);
    let fitting = instrument::fitting(&options.fitting, &course.instruments, &course.model);
    let shown = sailed
        .par_iter()
        .map(|run| Information::of(&course.model, &run.run, &fitting, options.forces.as_deref()))
        .collect::<Result<Vec<_>, _>>()?;
    let known = known(&parameters, options);
    let wanted = wanted(&parameters, wishes);
    let size = |k: usize| course.model.parameters[parameters[k]].value.abs().max(wanted[k].unwrap_or(0.0)).max(1e-9);
    // weak prior: a parameter that the runs do not identify keeps this deviation and is recognised by it
    let vague: Vec<f64> = (0..parameters.len()).map(|k| 10.0 * UNKNOWN * size(k)).collect();
    let vague = Information::of_deviations(parameters.clone(), &vague);
    let deviations = |runs: &[Information]| -> Vec<Option<f64>> {
        let all = Information::together(runs.iter().chain([&known, &vague]), &parameters);
        let std = all.deviations().unwrap_or_else(|| vec![f64::INFINITY; parameters.len()]);
        std.into_iter().enumerate().map(|(k, s)| (s < UNKNOWN * size(k)).then_some(s)).collect()
    };
    let worst = |std: &[Option<f64>]| {
        let ratios = wanted.iter().zip(std).filter_map(|(w, s)| w.map(|w| s.map_or(f64::INFINITY, |s| s / w)));
        let most = ratios.fold(0.0, f64::max);
        most.is_finite().then_some(most)
    };
    let runs: Vec<ProposedRun> = sailed
        .into_iter()
        .enumerate()
        .map(|(k, sailed)| ProposedRun { sailed, worst: worst(&deviations(&shown[..=k])) })
        .collect();
    let std = deviations(&shown);
    let covariance = Information::together(shown.iter().chain([&known]), &parameters)
        .covariance()
        .filter(|_| std.iter().all(Option::is_some));
    let parameters: Vec<Predicted> = parameters
        .iter()
        .enumerate()
        .map(|(k, p)| Predicted {
            parameter: *p,
            value: course.model.parameters[*p].value,
            wanted: wanted[k],
            std: std[k],
        })
        .collect();
    let warnings = findings(course, &parameters);
    Ok(Proposal { runs, parameters, covariance, candidates: 0, warnings })
}

/// Findings for parameters that the plan does not identify, or not accurately enough.
fn findings(course: &Course, parameters: &[Predicted]) -> Vec<Finding> {
    let mut warnings = Vec::new();
    for p in parameters {
        let told = &course.model.parameters[p.parameter];
        let name = format!("{} of `{}`", told.spec.name, told.term);
        match (p.std, p.wanted) {
            (None, _) => {
                let text = format!("the plan cannot separate {name} from the others: {}", shown_by(course, &told.term));
                warnings.push(Finding::new(&codes::NOT_SHOWN, text));
            }
            (Some(std), Some(wanted)) if std > wanted * (1.0 + 1e-9) => {
                let text = format!(
                    "{name}: the plan gives ± {std:.3e}, but ± {wanted:.3e} {} was requested",
                    told.spec.dimension
                );
                warnings.push(Finding::new(&codes::NOT_REACHED, text));
            }
            _ => {}
        }
    }
    warnings
}

/// Kind of run that shows the effect of a term, in the words of the catalogue.
fn shown_by(course: &Course, term: &str) -> String {
    let found = course.model.terms.iter().find(|t| t.name() == term);
    found.map_or_else(String::new, |t| format!("it is shown by {}", t.effect.about().shown_by))
}
