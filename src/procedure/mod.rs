//! The staged procedure of Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94.
//!
//! ```text
//! (i)   η_inter from bollard pull; η_adv from tow or maker's data        τ = η_inter η_adv τ_nom
//! (ii)  drag from constant-velocity runs                                 τ = k_Q ν|ν| + k_L ν + b
//! (iii) drag held; inertia, coupling and bias from oscillatory runs      ν̇ = a₁ q̇ + a₂ R + a₃
//!       and, where the vehicle turns with speed, k_uv from zig-zags      ṙ = a₁ u v + a₂ R + a₃
//! ```
//!
//! Each stage sees only what earlier ones have left, with its uncertainty. The reason for stages is conditioning: in a
//! single fit drag and inertia of one run are nearly the same signal, as the [`twin`] shows.

mod bollard;
pub mod codes;
mod drag;
mod held;
mod inertia;
pub mod numbers;
mod prepare;
mod result;
pub mod sensitivity;
pub mod twin;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use self::held::Held;
use self::inertia::Kind;
use self::numbers::DRAG;
pub use self::numbers::FlowNumbers;
pub use self::prepare::acting_forces;
pub use self::result::{Estimate, Stage, StagedResult};
use crate::estimate::{IntegralError, LeastSquaresError, RegressorError, RegressorOptions, StdMethod, SteadyOptions};
use crate::filter::{FilterError, PolynomialFilter, Window};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Role, Run, RunKind};
use crate::thrust::efficiency::{Efficiency, EfficiencyError};
use crate::vehicle::{Vehicle, Water};

/// Options of the procedure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StagedOptions {
    /// What counts as a steady window.
    pub steady: SteadyOptions,
    /// Rows of the integral stages.
    pub regressor: RegressorOptions,
    /// Standard deviations of the integral stages.
    pub std: StdMethod,
    /// Filter of all velocities before anything else; none when absent.
    pub filter: Option<PolynomialFilter>,
    /// Filter whose slope makes a body rate from its angle.
    pub rates: PolynomialFilter,
    /// Filter whose slope is the acceleration of the direct fit.
    pub differentiation: PolynomialFilter,
    /// Whether drag in yaw has values of its own clockwise and anticlockwise, where runs show both.
    pub per_direction: bool,
}

impl Default for StagedOptions {
    /// One-sample rows of unfiltered velocities, HAC deviations; angles and velocities are differentiated over 1 s.
    fn default() -> StagedOptions {
        let second = PolynomialFilter { window: Window::Seconds(1.0), degree: 2 };
        StagedOptions {
            steady: SteadyOptions::default(),
            regressor: RegressorOptions::default(),
            std: StdMethod::default(),
            filter: None,
            rates: second,
            differentiation: second,
            per_direction: true,
        }
    }
}

/// What is known of the vehicle apart from its model.
#[derive(Debug, Clone, Copy)]
pub struct Bench<'a> {
    /// Dry figures.
    pub vehicle: &'a Vehicle,
    /// The water.
    pub water: &'a Water,
    /// Losses of thrust that are known beforehand; η_inter of bollard runs takes the place of what is absent.
    pub efficiency: &'a Efficiency,
}

/// Why the procedure cannot be carried out.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProcedureError {
    /// No run takes part in the fit.
    #[error("no run takes part in the fit: at least one needs role = \"train\"")]
    NoTrainingRun,
    /// Losses along the thrusters' own axes need the forces of the thrusters.
    #[error(
        "[efficiency] advance_speed = \"thruster_axis\" needs thruster forces; the staged procedure has τ alone: use \"vehicle\""
    )]
    AdvanceByThruster,
    /// A velocity or an angle cannot be filtered.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// A balance has no regressor.
    #[error(transparent)]
    Integral(#[from] IntegralError),
    /// Efficiencies that cannot be found.
    #[error(transparent)]
    Efficiency(#[from] EfficiencyError),
    /// A linear system without solution.
    #[error("{stage}, {dof}: {source}")]
    Linear {
        /// The stage.
        stage: &'static str,
        /// Degree of freedom.
        dof: Dof,
        /// What is wrong.
        source: LeastSquaresError,
    },
}

impl ProcedureError {
    /// What the data of one stage lacks is a finding, and the other stages go on; a model that has no regressor at all
    /// is an error.
    fn unless_data<T>(stage: &str, dof: Dof, result: Result<T, IntegralError>) -> Result<Result<T, Finding>, Self> {
        use RegressorError as R;
        match result {
            Ok(value) => Ok(Ok(value)),
            Err(IntegralError::Regressor(e @ (R::NeedsOutputError { .. } | R::Product { .. }))) => {
                Err(IntegralError::Regressor(e).into())
            }
            Err(e) => Ok(Err(Finding::new(&codes::TOO_LITTLE, format!("{stage}, {dof}: {e}")))),
        }
    }
}

/// The staged procedure: estimates the free parameters of `model` from the training runs.
///
/// # Errors
/// [`ProcedureError`]. A stage whose data is not there or does not determine its parameters is a finding, not an error.
pub fn staged(
    runs: &[Run],
    model: &Model,
    bench: Bench<'_>,
    options: &StagedOptions,
) -> Result<StagedResult, ProcedureError> {
    let mut result = StagedResult { stages: Vec::new(), model: model.clone(), warnings: Vec::new() };
    let runs = ready(runs, model, options, &mut result.warnings)?;
    let efficiency = interaction(&runs, model, bench.efficiency, &mut result)?;
    let acting = acting(&runs, &efficiency, &mut result)?;
    let mut held = Held::default();
    for dof in &model.dofs {
        drag_of(*dof, &runs, &acting, options, &mut held, &mut result)?;
    }
    for dof in &model.dofs {
        integral(Kind::Oscillatory, RunKind::Oscillatory, *dof, &acting, bench, options, &mut held, &mut result)?;
    }
    // (29) is the balance of yaw: in surge and sway the bias of these runs would pass for a Coriolis coefficient
    if model.dofs.contains(&Dof::Yaw) {
        integral(Kind::Zigzag, RunKind::Zigzag, Dof::Yaw, &acting, bench, options, &mut held, &mut result)?;
    }
    thrust_scale(&efficiency, &mut result);
    judge(model, &held, bench.vehicle, &runs, &mut result);
    Ok(result)
}

/// The runs as [`staged`] uses them from stage (ii) on: smoothed, with the rates made, with the forces that act. Twins
/// and simulations that are to be compared with the staged model take the same.
///
/// # Errors
/// [`ProcedureError::Filter`].
pub fn made_ready(
    runs: &[Run],
    model: &Model,
    efficiency: &Efficiency,
    options: &StagedOptions,
) -> Result<Vec<Run>, ProcedureError> {
    let ready = ready(runs, model, options, &mut Vec::new())?;
    Ok(ready.iter().map(|run| acting_forces(run, efficiency).0).collect())
}

/// Training runs, smoothed, with the rates that are not logged.
fn ready(
    runs: &[Run],
    model: &Model,
    options: &StagedOptions,
    warnings: &mut Vec<Finding>,
) -> Result<Vec<Run>, ProcedureError> {
    let mut ready = Vec::new();
    let mut made: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for run in runs.iter().filter(|run| run.role == Role::Train) {
        let mut run = options.filter.map_or_else(|| Ok(run.clone()), |filter| prepare::smooth(run, &filter))?;
        for rate in prepare::make_rates(&mut run, model, &options.rates)? {
            made.entry(rate).or_default().push(run.name.clone());
        }
        ready.push(run);
    }
    for (rate, names) in made {
        let text = format!(
            "{rate} is not logged in {} runs ({}, …): it is the slope of the filtered angle, whose noise enters the \
             coefficient of {rate} and its deviation",
            names.len(),
            names[0]
        );
        warnings.push(Finding { column: Some(rate.to_string()), ..Finding::new(&codes::RATE_MADE, text) });
    }
    if ready.is_empty() { Err(ProcedureError::NoTrainingRun) } else { Ok(ready) }
}

/// Stage (i): η_inter of each degree of freedom that has bollard runs and no known value.
fn interaction(
    runs: &[Run],
    model: &Model,
    known: &Efficiency,
    result: &mut StagedResult,
) -> Result<Efficiency, ProcedureError> {
    let mut efficiency = known.clone();
    for dof in &model.dofs {
        if let Some((stage, found)) = bollard::stage(*dof, &of_kind(runs, RunKind::Bollard, *dof, &model.dofs))? {
            result.stages.push(stage);
            if !known.eta_inter.0.iter().any(|entry| entry.dof == *dof) {
                efficiency.eta_inter.0.push(found);
            }
        }
    }
    Ok(efficiency)
}

/// Every run with the forces that act.
fn acting(runs: &[Run], efficiency: &Efficiency, result: &mut StagedResult) -> Result<Vec<Run>, ProcedureError> {
    if efficiency.eta_adv.is_some() && !prepare::is_paper_speed(efficiency) {
        return Err(ProcedureError::AdvanceByThruster);
    }
    let mut acting = Vec::new();
    for run in runs.iter().filter(|run| run.kind != RunKind::Bollard) {
        let (acts, warnings) = acting_forces(run, efficiency);
        acting.push(acts);
        // of what holds the other degrees of freedom nothing is estimated
        let shown = prepare::shown(run, &result.model.dofs).map(Dof::force);
        result.warnings.extend(warnings.into_iter().filter(|w| w.column.as_deref() == shown));
    }
    Ok(acting)
}

/// Stage (ii): towed where load cells were logged, propelled where the vehicle ran at constant velocity; the propelled
/// drag is the one that is kept when both are there, as in the paper.
fn drag_of(
    dof: Dof,
    runs: &[Run],
    acting: &[Run],
    options: &StagedOptions,
    held: &mut Held,
    result: &mut StagedResult,
) -> Result<(), ProcedureError> {
    let towing = of_kind(runs, RunKind::Towing, dof, &result.model.dofs);
    let towed: Vec<Run> = towing.into_iter().filter_map(|run| drag::towed(run, dof)).collect();
    let sources = [
        ("towing", towed.iter().collect::<Vec<_>>()),
        ("steady", of_kind(acting, RunKind::ConstantVelocity, dof, &result.model.dofs)),
    ];
    let mut found = None;
    for (name, runs) in sources {
        if runs.is_empty() {
            continue;
        }
        match drag::stage(name, dof, &runs, &result.model, options)? {
            Ok(mut drag) => {
                result.stages.append(&mut drag.stages);
                found = Some(drag);
            }
            Err(finding) => result.warnings.push(finding),
        }
    }
    match found {
        Some(drag) => {
            drag.fit.write_to(&mut result.model);
            held.join(drag.held);
        }
        None if !parameters_at(&result.model, dof, &DRAG).is_empty() => {
            let text = format!("no run shows the drag in {dof}: constant_velocity or towing runs would");
            result.warnings.push(Finding::new(&codes::NO_RUN, text));
        }
        None => {}
    }
    Ok(())
}

/// Stage (iii) of one kind in one degree of freedom.
#[allow(clippy::too_many_arguments)] // the state of the procedure, named piece by piece
fn integral(
    kind: Kind,
    of: RunKind,
    dof: Dof,
    acting: &[Run],
    bench: Bench<'_>,
    options: &StagedOptions,
    held: &mut Held,
    result: &mut StagedResult,
) -> Result<(), ProcedureError> {
    let runs = of_kind(acting, of, dof, &result.model.dofs);
    if runs.is_empty() || kind.free(&result.model, dof, held).is_empty() {
        return Ok(());
    }
    match inertia::stages(kind, dof, &runs, &result.model, held, &bench, options)? {
        Ok((stages, fit)) => {
            result.stages.extend(stages);
            fit.write_to(&mut result.model);
            let masses: Vec<usize> = parameters_at(&result.model, dof, &["inertia"]);
            if kind == Kind::Oscillatory {
                held.add(&fit, &masses, None);
            }
        }
        Err(finding) => result.warnings.push(finding),
    }
    Ok(())
}

/// A scale of thrust that is known to σ_η/η leaves every coefficient known to no better than that part of itself.
fn thrust_scale(efficiency: &Efficiency, result: &mut StagedResult) {
    for entry in &efficiency.eta_inter.0 {
        let Some(part) = entry.std.map(|std| std / entry.value) else { continue };
        let widen = |value: f64, std: f64| std.hypot(value * part);
        for stage in
            result.stages.iter_mut().filter(|s| s.dof == entry.dof && !["bollard", "towing"].contains(&s.name.as_str()))
        {
            stage.estimates.iter_mut().for_each(|e| e.std = widen(e.value, e.std));
        }
        for p in result.model.parameters.iter_mut().filter(|p| p.place.dof == Some(entry.dof)) {
            p.std = p.std.map(|std| widen(p.value, std));
        }
    }
}

/// What a reader has to know: signs that cannot be, parameters that no stage estimates.
fn judge(model: &Model, held: &Held, vehicle: &Vehicle, runs: &[Run], result: &mut StagedResult) {
    for stage in &mut result.stages {
        let drag = |e: &&Estimate| DRAG[..3].contains(&e.effect.as_str()) || e.effect == "inertia";
        for e in stage.estimates.iter().filter(drag).filter(|e| e.value < 0.0) {
            let text = format!("{}, {}: {} = {:.4} ± {:.4} {}", stage.name, stage.dof, e.name, e.value, e.std, e.unit);
            stage.warnings.push(Finding::new(&codes::UNPHYSICAL, text));
        }
    }
    for p in model.free() {
        let parameter = &model.parameters[p];
        let found = |stage: &Stage| stage.estimates.iter().any(|e| e.name == parameter.spec.name);
        if !held.has(p) && !result.stages.iter().any(found) {
            let text = format!("{} of {} keeps its value {}", parameter.spec.name, parameter.term, parameter.value);
            result.warnings.push(Finding::new(&codes::NOT_ESTIMATED, text));
        }
    }
    let pitches = runs.iter().any(|run| run.signal("theta").is_some());
    if vehicle.net_weight().is_some()
        && pitches
        && model.dofs.contains(&Dof::Surge)
        && model.term("restoring_surge").is_none()
    {
        result.warnings.push(Finding::new(&codes::GRAVITY, codes::GRAVITY.meaning));
    }
}

/// Runs of a kind that show `dof`: all zig-zags do, any other run shows one of `dofs`.
fn of_kind<'a>(runs: &'a [Run], kind: RunKind, dof: Dof, dofs: &[Dof]) -> Vec<&'a Run> {
    let shows = |run: &&Run| kind == RunKind::Zigzag || prepare::shown(run, dofs) == Some(dof);
    runs.iter().filter(|run| run.kind == kind).filter(shows).collect()
}

/// Free linear parameters of the terms of these effects in `dof`.
fn parameters_at(model: &Model, dof: Dof, effects: &[&str]) -> Vec<usize> {
    let here = |p: &usize| {
        let parameter = &model.parameters[*p];
        parameter.place.dof == Some(dof) && effects.contains(&parameter.effect.as_str()) && parameter.spec.is_linear()
    };
    model.free().into_iter().filter(here).collect()
}
