//! Models of single runs and their errors on the other runs: Table 6 of Avila et al. (2013).
//!
//! ```text
//! θ_r: fit of run r alone        E_rs = mean |y_s − ŷ_s(θ_r)|
//! r: model of run r, s: run that is simulated
//! ```
//!
//! In a staged fit, θ_r comes from the stages of single runs. Otherwise each training run is fitted
//! alone. The fit starts from the common estimates, and a prior with a standard deviation of the
//! estimate's own size holds each parameter to its estimate, so that what a run does not show stays
//! as it is.

use serde::Serialize;

use super::compare::options;
use super::file::Estimator;
use super::fit::{Fit, FitStage};
use super::load::Campaign;
use crate::compare::cross_validate;
use crate::estimate::output_error::{OutputErrorOptions, output_error};
use crate::frame::{Dof, Measured};
use crate::model::Model;
use crate::progress::Count;
use crate::run::{Role, Run};

/// Largest number of runs that are fitted alone, and of the other runs that each model is simulated
/// on: the longest ones. A larger matrix cannot be read.
pub const MOST: usize = 20;

/// Standard deviation of the prior at the common value, in units of that value.
const HELD: f64 = 1.0;

/// Models of single runs, and the errors of each on every run.
/// Serialises as `hydrosysid compare --cross --json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EachRun {
    /// Format of the result: 1.
    pub format: u32,
    /// One model per run.
    pub models: Vec<OwnModel>,
    /// Errors of each model on each run, by degree of freedom; none for a pair that cannot be
    /// simulated.
    pub crossed: Vec<Crossed>,
    /// Runs that were left out, because there are twenty longer ones.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
}

impl EachRun {
    /// Returns what was compared, by degree of freedom: velocities, and positions and angles of
    /// runs that log no velocity.
    pub fn compared(&self) -> Vec<&Measured> {
        let mut all: Vec<&Measured> = Vec::new();
        for cell in &self.crossed {
            if !all.contains(&&cell.dof) {
                all.push(&cell.dof);
            }
        }
        all.sort_by_key(|dof| dof.along());
        all
    }
}

/// The model of one run alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OwnModel {
    /// Name of the run.
    pub run: String,
    /// Degrees of freedom of its model.
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

/// Errors of the model of one run on another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Crossed {
    /// Run that the model was made from.
    pub model: String,
    /// Run that it was simulated on.
    pub run: String,
    /// Degree of freedom; the channel of the position or angle where the run logs no velocity.
    pub dof: Measured,
    /// Mean |measured − simulated|, m/s or rad/s; m or rad of a position or angle.
    pub mean_abs: f64,
    /// Standard deviation of |measured − simulated|, in the same unit.
    pub std_abs: f64,
}

/// Returns the models of single runs of `fit`, each simulated on the others and on held-out runs;
/// empty if fewer than two runs can be fitted alone.
pub fn each_run(campaign: &Campaign, fit: &Fit) -> EachRun {
    let campaign = campaign.under(&fit.efficiency);
    let mut left_out = Vec::new();
    let alone = match fit.estimator {
        Estimator::Staged => of_stages(&campaign, fit, &mut left_out),
        Estimator::FilterError | Estimator::OutputError | Estimator::Integral => of_fits(&campaign, fit, &mut left_out),
    };
    if alone.len() < 2 {
        return EachRun { format: 1, models: Vec::new(), crossed: Vec::new(), left_out: Vec::new() };
    }
    let staged = fit.estimator == Estimator::Staged;
    let has_model = |run: &Run| alone.iter().any(|(own, _)| own.run == run.name);
    // a stage is about one kind of run; runs of other kinds show what the stage holds constant
    let held_out = |run: &Run| !staged && run.role == Role::Validate;
    let (own, others): (Vec<Run>, Vec<Run>) =
        campaign.motion(None).into_iter().filter(|run| has_model(run) || held_out(run)).partition(|run| has_model(run));
    let others = longest(others, duration, |run| run.name.clone(), &mut left_out);
    let runs: Vec<Run> = own.into_iter().chain(others).collect();
    let models: Vec<(String, Model)> = alone.iter().map(|(own, model)| (own.run.clone(), model.clone())).collect();
    let mut crossed = Vec::new();
    let count = Count::begun("simulating each run with all models", runs.len());
    for run in &runs {
        count.one_done();
        // one run at a time: a run that cannot be simulated does not stop the others
        let Ok(rows) = cross_validate(&models, std::slice::from_ref(run), &options(&campaign)) else { continue };
        for (row, (own, _)) in rows.iter().zip(&alone) {
            let shared = |dof: &Dof| {
                let about = |own: &OwnModel| own.run == run.name && own.dofs.contains(dof);
                own.dofs.contains(dof) && (!staged || alone.iter().any(|(own, _)| about(own)))
            };
            crossed.extend(row.comparison.runs.iter().filter_map(|r| {
                r.dof.along().filter(shared)?;
                let (model, run, dof) = (row.model.clone(), r.run.clone(), r.dof.clone());
                Some(Crossed { model, run, dof, mean_abs: r.mean_abs, std_abs: r.std_abs })
            }));
        }
    }
    EachRun { format: 1, models: alone.into_iter().map(|(own, _)| own).collect(), crossed, left_out }
}

/// Returns the [`MOST`] longest of a list, in the order of the list; the names of the rest go to
/// `left_out`.
fn longest<T>(
    list: Vec<T>,
    length: impl Fn(&T) -> f64,
    name: impl Fn(&T) -> String,
    left_out: &mut Vec<String>,
) -> Vec<T> {
    let lengths: Vec<f64> = list.iter().map(length).collect();
    let mut order: Vec<usize> = (0..list.len()).collect();
    // a stable order: of equally long runs the first ones stay
    order.sort_by(|a, b| lengths[*b].total_cmp(&lengths[*a]));
    order.truncate(MOST);
    let mut keep = |(k, one): (usize, T)| {
        if order.contains(&k) {
            return Some(one);
        }
        left_out.push(name(&one));
        None
    };
    list.into_iter().enumerate().filter_map(&mut keep).collect()
}

fn duration(run: &Run) -> f64 {
    run.span().map_or(0.0, |(from, to)| to - from)
}

/// Returns the stages of single runs, each with the model that has its estimates.
fn of_stages(campaign: &Campaign, fit: &Fit, left_out: &mut Vec<String>) -> Vec<(OwnModel, Model)> {
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
    let run_of = |stage: &&FitStage| campaign.runs.iter().find(|run| run.name == stage.runs[0]).map_or(0.0, duration);
    let stages = longest(fit.stages.iter().filter(single).collect(), run_of, |s| s.runs[0].clone(), left_out);
    stages.into_iter().map(of_stage).collect()
}

/// Fits each training run alone.
fn of_fits(campaign: &Campaign, fit: &Fit, left_out: &mut Vec<String>) -> Vec<(OwnModel, Model)> {
    let training = campaign.motion(Some(Role::Train));
    let moving: Vec<(usize, &Run)> = campaign.motion_numbers(Some(Role::Train)).into_iter().zip(&training).collect();
    let moving = longest(moving, |(_, run)| duration(run), |(_, run)| run.name.clone(), left_out);
    let count = Count::begun("fitting each run alone", moving.len());
    let fitting = OutputErrorOptions { join: campaign.file.fit.join, ..campaign.options.output_error.clone() };
    moving
        .into_iter()
        .inspect(|_| count.one_done())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_runs_are_kept_in_their_order() {
        let lengths: Vec<usize> = (0..MOST + 2).map(|k| if k == 1 || k == 5 { 10 } else { 90 + k }).collect();
        let mut left_out = Vec::new();
        let kept = longest(lengths.clone(), |l| *l as f64, ToString::to_string, &mut left_out);
        assert_eq!(kept, lengths.into_iter().filter(|l| *l > 10).collect::<Vec<_>>());
        assert_eq!(left_out, ["10", "10"]);
        // of equally long runs the first
        let kept = longest((0..MOST + 1).collect(), |_| 1.0, ToString::to_string, &mut left_out);
        assert_eq!(kept, (0..MOST).collect::<Vec<_>>());
    }
}
