//! The fit and its overlay on the runs: quickly a first result of a fast estimator, then that of
//! the campaign's estimator.

use std::sync::Arc;
use std::time::Instant;

use serde::Serialize;

use super::answer::{Answer, Refusal};
use super::workspace::Workspace;
use crate::campaign::{self, Campaign, Estimator, Fit, FitOptions, FitParameter, Simulation};
use crate::compare::Disagreement;
use crate::effects::{Place, common_name};
use crate::finding::Finding;
use crate::model::name_of;
use crate::report::{Label, Style, estimate, figure, unit};
use crate::report_content::motion_figure;
use crate::run::{Role, RunKind};

/// A fit with its comparison and simulation of the runs.
pub(super) struct Fitted {
    stamp: String,
    /// Whether the campaign's own estimator is still running.
    first_look: bool,
    seconds: f64,
    fit: Fit,
    disagreements: Vec<Disagreement>,
    simulation: Simulation,
}

fn fitted(campaign: &Campaign, estimator: Option<Estimator>) -> Result<(Fit, Vec<Disagreement>, Simulation), Refusal> {
    let fit = campaign::fit(campaign, FitOptions { estimator })?;
    let under = campaign.under(&fit.efficiency).with_noise(fit.model_noise());
    let disagreements = campaign::disagreements(&under, &fit.model)?;
    let simulation = campaign::simulate(&under, &fit.model, &fit.envelope)?;
    Ok((fit, disagreements, simulation))
}

/// Estimators for the first result, the fastest first: integral least squares needs velocities.
const QUICK: &[Estimator] = &[Estimator::Integral, Estimator::OutputError];

/// Whether a fast estimator gives a first result before the campaign's estimator: only filter error
/// takes long.
fn looks_first(campaign: &Campaign) -> bool {
    let captive = campaign.runs.iter().any(|run| matches!(run.kind, RunKind::Bollard | RunKind::Towing));
    !captive && campaign.options.estimator.is_none_or(|estimator| estimator == Estimator::FilterError)
}

/// Starts the fit of the current campaign.
pub(super) fn begin(workspace: &Arc<Workspace>) -> Result<Answer, Refusal> {
    let shared = workspace.clone();
    let number = workspace.fit.begin(move |early| {
        let begun = Instant::now();
        let stamp = shared.stamp()?;
        let campaign = shared.campaign()?;
        let of = |first_look, (fit, disagreements, simulation)| Fitted {
            stamp: stamp.clone(),
            first_look,
            seconds: begun.elapsed().as_secs_f64(),
            fit,
            disagreements,
            simulation,
        };
        let quick = if looks_first(&campaign) { QUICK } else { &[] };
        if let Some(first) = quick.iter().find_map(|estimator| fitted(&campaign, Some(*estimator)).ok()) {
            early.show(of(true, first));
        }
        Ok(of(false, fitted(&campaign, None)?))
    });
    Ok(Answer::json(&serde_json::json!({"number": number})))
}

/// The fit as the page shows it.
#[derive(Serialize)]
struct Shown<'a> {
    stamp: &'a str,
    first_look: bool,
    seconds: f64,
    estimator: &'static str,
    sentence: &'a str,
    converged: bool,
    parameters: Vec<Parameter<'a>>,
    runs: Vec<Run<'a>>,
    warnings: Vec<&'a Finding>,
}

#[derive(Serialize)]
struct Parameter<'a> {
    #[serde(flatten)]
    parameter: &'a FitParameter,
    common_name: String,
    /// The symbol with its markup, as HTML.
    symbol: String,
    /// Value and standard deviation in the format for people.
    text: String,
    shown_unit: String,
}

#[derive(Serialize)]
struct Run<'a> {
    run: &'a str,
    role: Role,
    measured: Vec<&'a Disagreement>,
}

/// The last fit; `null` if there is none, for example because a newer one has replaced it and
/// failed.
pub(super) fn result(workspace: &Workspace) -> Result<Answer, Refusal> {
    let Some(fitted) = workspace.fit.result() else { return Ok(Answer::json(&None::<Shown<'_>>)) };
    let Fitted { stamp, first_look, seconds, fit, disagreements, simulation } = &*fitted;
    let parameter = |p: &FitParameter| {
        let name = name_of(&p.effect, Place { dof: p.dof, other: p.other });
        (common_name(&name), Label::symbol(&p.name).html())
    };
    let parameters = fit.parameters.iter().map(|p| {
        let (common_name, symbol) = parameter(p);
        let text = estimate(p.value, p.std.filter(|_| !p.fixed), Style::Text);
        Parameter { parameter: p, common_name, symbol, text, shown_unit: unit(&p.unit) }
    });
    let run = |run: &'_ campaign::Simulated| (run.run.clone(), run.role);
    let names: Vec<(String, Role)> = simulation.runs.iter().map(run).collect();
    let measured = |name: &str| disagreements.iter().filter(|r| r.run == name).collect();
    Ok(Answer::json(&Shown {
        stamp,
        first_look: *first_look,
        seconds: *seconds,
        estimator: fit.estimator.name(),
        sentence: &fit.sentence,
        converged: fit.converged,
        parameters: parameters.collect(),
        runs: names.iter().map(|(run, role)| Run { run, role: *role, measured: measured(run) }).collect(),
        warnings: fit.warnings.iter().chain(&simulation.warnings).fold(Vec::new(), |mut all, finding| {
            if !all.contains(&finding) {
                all.push(finding);
            }
            all
        }),
    }))
}

#[derive(Serialize)]
struct Overlay {
    run: String,
    figures: Vec<String>,
}

/// Measured and simulated motion of a run: one figure per degree of freedom; none for a run that
/// the last fit does not contain.
pub(super) fn overlay(workspace: &Workspace, run: &str) -> Result<Answer, Refusal> {
    let fitted = workspace.fit.result();
    let known =
        fitted.as_ref().and_then(|f| Some((f, f.simulation.runs.iter().find(|simulated| simulated.run == run)?)));
    let Some((fitted, simulated)) = known else {
        return Ok(Answer::json(&Overlay { run: run.to_string(), figures: Vec::new() }));
    };
    let noise = |dof| {
        let of = |r: &&Disagreement| r.run == run && r.dof == dof;
        fitted.disagreements.iter().find(of).map(|r| r.noise_floor)
    };
    let dofs = &fitted.fit.model.dofs;
    let figures = dofs.iter().filter_map(|dof| Some(figure(&motion_figure(simulated, *dof, noise(*dof))?, dof.name())));
    Ok(Answer::json(&Overlay { run: run.to_string(), figures: figures.collect() }))
}
