//! What each run says alone, and how its model does on the others: Table 6 of Avila et al. (2013).
//!
//! ```text
//! θ_r: fit of run r alone        E_rs = mean |y_s − ŷ_s(θ_r)|        r: model of run r, s: run that is simulated
//! ```
//!
//! Of a staged fit θ_r are the stages of single runs; else one fit a training run, started from the common estimates and
//! held to them by a deviation of their own size, so that what a run does not show stays as it is.

use serde::Serialize;

use super::compare::options;
use super::file::Estimator;
use super::fit::{Fit, FitStage};
use super::load::Campaign;
use crate::compare::cross_validate;
use crate::estimate::output_error::{OutputErrorOptions, output_error};
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Role, Run};

/// Most runs that are fitted alone, and most that each model is simulated on.
pub const MOST: usize = 8;

/// Deviation, in units of the common value, that holds a parameter to it.
const HELD: f64 = 1.0;

/// The models of single runs, and each on every run. Serialises as `hydrosysid compare --cross --json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EachRun {
    /// Format of the result: 1.
    pub format: u32,
    /// One model a run.
    pub models: Vec<OwnModel>,
    /// Each model on each run, by degree of freedom; none for a pair that cannot be simulated.
    pub crossed: Vec<Crossed>,
}

/// What one run says alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OwnModel {
    /// Name of the run.
    pub run: String,
    /// Degrees of freedom that its model is about.
    pub dofs: Vec<Dof>,
    /// Its estimates.
    pub estimates: Vec<OwnEstimate>,
}

/// An estimate from one run alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OwnEstimate {
    /// Term: `quadratic_drag@surge`.
    pub term: String,
    /// Symbol.
    pub name: String,
    /// Value, SI.
    pub value: f64,
    /// Standard deviation, SI.
    pub std: f64,
}

/// The model of one run on another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Crossed {
    /// Run that the model was made from.
    pub model: String,
    /// Run that it was simulated on.
    pub run: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// Mean |measured − simulated|, m/s or rad/s.
    pub mean_abs: f64,
    /// Standard deviation of |measured − simulated|, m/s or rad/s.
    pub std_abs: f64,
}

/// The models of single runs of `fit`, each simulated on the others and on runs that took no part; empty where fewer
/// than two runs can stand alone.
pub fn each_run(campaign: &Campaign, fit: &Fit) -> EachRun {
    let campaign = campaign.under(&fit.efficiency);
    let alone = match fit.estimator {
        Estimator::Staged => of_stages(fit),
        Estimator::OutputError | Estimator::Integral => of_fits(&campaign, fit),
    };
    if alone.len() < 2 {
        return EachRun { format: 1, models: Vec::new(), crossed: Vec::new() };
    }
    let staged = fit.estimator == Estimator::Staged;
    let has_model = |run: &Run| alone.iter().any(|(own, _)| own.run == run.name);
    // a stage is about one kind of run; other kinds show what it holds
    let held_out = |run: &Run| !staged && run.role == Role::Validate;
    let (own, others): (Vec<Run>, Vec<Run>) =
        campaign.motion(None).into_iter().filter(|run| has_model(run) || held_out(run)).partition(|run| has_model(run));
    let runs: Vec<Run> = own.into_iter().chain(others.into_iter().take(MOST)).collect();
    let models: Vec<(String, Model)> = alone.iter().map(|(own, model)| (own.run.clone(), model.clone())).collect();
    let mut crossed = Vec::new();
    for run in &runs {
        // one run at a time, so that one that cannot be simulated leaves the others
        let Ok(rows) = cross_validate(&models, std::slice::from_ref(run), &options(&campaign)) else { continue };
        for (row, (own, _)) in rows.iter().zip(&alone) {
            let shared = |dof: &Dof| {
                let about = |own: &OwnModel| own.run == run.name && own.dofs.contains(dof);
                own.dofs.contains(dof) && (!staged || alone.iter().any(|(own, _)| about(own)))
            };
            crossed.extend(row.comparison.runs.iter().filter_map(|r| {
                let dof = r.dof.dof().filter(shared)?;
                let (model, run) = (row.model.clone(), r.run.clone());
                Some(Crossed { model, run, dof, mean_abs: r.mean_abs, std_abs: r.std_abs })
            }));
        }
    }
    EachRun { format: 1, models: alone.into_iter().map(|(own, _)| own).collect(), crossed }
}

/// The stages of single runs, each with the model that has its estimates in place.
fn of_stages(fit: &Fit) -> Vec<(OwnModel, Model)> {
    let single = |s: &&FitStage| {
        let moved = s.name.starts_with("oscillatory") || s.name.starts_with("zigzag");
        moved && s.runs.len() == 1 && !s.estimates.is_empty()
    };
    let of_stage = |stage: &FitStage| {
        let mut model = fit.model.clone();
        let mut estimates = Vec::new();
        for e in &stage.estimates {
            let term = if e.dof.is_empty() { e.effect.clone() } else { format!("{}@{}", e.effect, e.dof) };
            if let Some(p) = model.parameter(&term, &e.name) {
                model.parameters[p].value = e.value;
                model.parameters[p].per_run.clear();
            }
            estimates.push(OwnEstimate { term, name: e.name.clone(), value: e.value, std: e.std });
        }
        (OwnModel { run: stage.runs[0].clone(), dofs: vec![stage.dof], estimates }, model)
    };
    fit.stages.iter().filter(single).take(MOST).map(of_stage).collect()
}

/// One fit a training run.
fn of_fits(campaign: &Campaign, fit: &Fit) -> Vec<(OwnModel, Model)> {
    let training = campaign.runs.iter().enumerate().filter(|(_, run)| run.role == Role::Train);
    let moving = training.filter(|(_, run)| super::load::moves(run.kind));
    let fitting = OutputErrorOptions { join: campaign.file.fit.join, ..campaign.options.output_error.clone() };
    moving
        .take(MOST)
        .filter_map(|(k, run)| {
            let mut model = fit.model.clone();
            for p in &mut model.parameters {
                if let Some(own) = p.per_run.get(k).copied() {
                    (p.value, p.per_run) = (own, vec![own]);
                }
                if !p.fixed {
                    p.prior = p.prior.or(Some((p.value, HELD * p.value.abs().max(1e-12))));
                }
            }
            let mut found = output_error(&model, std::slice::from_ref(run), &fitting).ok()?.model;
            for p in &mut found.parameters {
                if let [own] = p.per_run[..] {
                    (p.value, p.per_run) = (own, Vec::new());
                }
            }
            let free = found.parameters.iter().filter(|p| !p.fixed);
            let estimates = free
                .filter_map(|p| {
                    let std = p.std.filter(|std| *std > 0.0 && std.is_finite())?;
                    Some(OwnEstimate { term: p.term.clone(), name: p.spec.name.clone(), value: p.value, std })
                })
                .collect();
            Some((OwnModel { run: run.name.clone(), dofs: found.dofs.clone(), estimates }, found))
        })
        .collect()
}
