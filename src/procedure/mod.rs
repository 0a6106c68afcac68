//! The staged procedure of Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94.
//!
//! ```text
//! (i)   thruster curves and η_inter from bollard pull,                   τ = η_inter η_adv τ_nom
//!       η_adv from tow or maker's data
//! (ii)  drag from constant-velocity runs                                 τ = k_Q ν|ν| + k_L ν + b
//! (iii) drag held; inertia, coupling and bias from oscillatory runs      ν̇ = a₁ q̇ + a₂ R + a₃
//!       and, if the vehicle turns at speed, k_uv from zig-zags           ṙ = a₁ u v + a₂ R + a₃
//! ```
//!
//! Each stage holds the results of the earlier stages and propagates their uncertainty. The reason
//! for stages is conditioning: in a single fit, drag and inertia of one run are nearly the same
//! signal, as the [`direct_regression`] shows.

mod advance;
mod bench;
mod bollard;
pub mod codes;
mod curves;
pub mod direct_regression;
mod drag;
mod effective_thrust;
mod error;
mod inertia;
pub mod numbers;
mod options;
mod pitch;
mod prepare;
mod result;
pub mod sensitivity;
mod small_sample;
mod stage_covariance;
mod stages;

use std::collections::BTreeMap;

pub use self::advance::{is_powered, towed_drag};
pub use self::bench::Bench;
use self::bench::{of_kind, parameters_at, parameters_of};
pub use self::bollard::settled_loads;
pub use self::curves::with_curve_moved;
pub use self::drag::{steady_means, towed};
pub use self::effective_thrust::{acting_forces, acting_thruster_force};
pub use self::error::ProcedureError;
use self::inertia::Kind;
pub use self::numbers::FlowNumbers;
pub use self::options::{
    Align, BollardStage, DirectStage, GivenWindow, OscillatoryStage, PitchSource, StagedOptions, SteadyStage,
    ZigzagStage,
};
pub use self::prepare::shown;
pub use self::result::{Estimate, Stage, StagedResult};
use self::stage_covariance::Held;
use self::stages::Stages;
use crate::chain::Nature;
use crate::effects::id;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::{Model, Parameter};
use crate::run::{Role, Run, RunKind};
use crate::thrust::efficiency::{AdvanceSpeed, Efficiency};
use crate::thrust::thruster::Thruster;
use crate::vehicle::Vehicle;

/// The staged procedure: estimates the free parameters of `model` from the training runs.
///
/// # Errors
/// [`ProcedureError`]. A stage whose data is missing or does not determine its parameters gives a
/// finding, not an error.
pub fn staged(
    runs: &[Run],
    model: &Model,
    bench: Bench<'_>,
    options: &StagedOptions,
) -> Result<StagedResult, ProcedureError> {
    let mut result = StagedResult::begun(model, bench);
    let runs = pitched(ready(runs, model, options, &mut result.warnings)?, bench, options, &mut result.warnings);
    check_axis(&runs, bench)?;
    check_windows(&runs, options, &mut result.warnings);
    let mut held = Held::of_bench(&bench);
    let mut stages = Stages { runs: &runs, bench, options, held: &mut held, result: &mut result };
    stages.interaction()?;
    let towed = stages.towed()?;
    let towed = stages.advance(towed);
    stages.coverage();
    for (dof, towed) in model.dofs.iter().zip(towed) {
        stages.drag(*dof, towed)?;
    }
    for dof in &model.dofs {
        stages.integral(Kind::Oscillatory, *dof)?;
    }
    for dof in inertia::ZIGZAG.into_iter().filter(|dof| model.dofs.contains(dof)) {
        stages.integral(Kind::Zigzag, dof)?;
    }
    stages.direct();
    result.efficiency = held.efficiency.clone();
    result.covariance = held.covariance_of(model.parameters.len());
    judge(model, &held, bench.vehicle, &runs, &mut result);
    Ok(result)
}

/// η_inter from the bollard runs with role `train`, together with the losses that `bench` knows:
/// stage (i) alone.
///
/// # Errors
/// [`ProcedureError`].
pub fn interaction_losses(
    runs: &[Run],
    model: &Model,
    bench: Bench<'_>,
    options: &StagedOptions,
) -> Result<Efficiency, ProcedureError> {
    let bollard: Vec<Run> = runs.iter().filter(|run| run.kind == RunKind::Bollard).cloned().collect();
    let mut result = StagedResult::begun(model, bench);
    let runs = ready(&bollard, model, options, &mut result.warnings)?;
    let mut held = Held::of_bench(&bench);
    Stages { runs: &runs, bench, options, held: &mut held, result: &mut result }.interaction()?;
    Ok(held.efficiency.clone())
}

/// Degrees of freedom with free drag parameters, all zero at the start, that no training run of
/// constant velocity or towing shows: stage (iii) would estimate an inertia without any drag.
pub fn without_steady_runs(runs: &[Run], model: &Model) -> Vec<Dof> {
    let training: Vec<Run> = runs.iter().filter(|run| run.role == Role::Train).cloned().collect();
    let absent = |p: &usize| model.parameters[*p].value.abs() <= 0.0;
    let unseen = |dof: &Dof| {
        let drag = parameters_of(model, *dof, Nature::Drag);
        let steady = [RunKind::ConstantVelocity, RunKind::Towing];
        !drag.is_empty()
            && drag.iter().all(absent)
            && steady.into_iter().all(|kind| of_kind(&training, kind, *dof, &model.dofs).is_empty())
    };
    model.dofs.iter().copied().filter(unseen).collect()
}

/// The training runs as [`staged`] uses them from stage (ii) on: smoothed, with derived rates and
/// effective forces. Direct fits and simulations that are compared with the staged model use the
/// same runs.
///
/// # Errors
/// [`ProcedureError::Filter`].
pub fn made_ready(
    runs: &[Run],
    model: &Model,
    efficiency: &Efficiency,
    thrusters: &[Thruster],
    options: &StagedOptions,
) -> Result<Vec<Run>, ProcedureError> {
    let ready = ready(runs, model, options, &mut Vec::new())?;
    Ok(ready.iter().map(|run| acting_forces(run, efficiency, thrusters).0).collect())
}

/// Training runs, smoothed, with derived body rates where they are not logged.
fn ready(
    runs: &[Run],
    model: &Model,
    options: &StagedOptions,
    warnings: &mut Vec<Finding>,
) -> Result<Vec<Run>, ProcedureError> {
    let mut ready = Vec::new();
    let mut made: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for run in runs.iter().filter(|run| run.role == Role::Train) {
        let mut run = prepare::smooth(run, options)?;
        for rate in prepare::make_rates(&mut run, model, &options.rates)? {
            made.entry(rate).or_default().push(run.name.clone());
        }
        ready.push(run);
    }
    for (rate, names) in made {
        let text = format!(
            "{rate} is not logged in {} runs ({}, …): the derivative of the filtered angle is used, whose noise \
             affects the coefficient of {rate} and its standard error",
            names.len(),
            names[0]
        );
        warnings.push(Finding { column: Some(rate.to_string()), ..Finding::new(&codes::RATE_MADE, text) });
    }
    if ready.is_empty() { Err(ProcedureError::NoTrainingRun) } else { Ok(ready) }
}

/// The runs; if the options ask for it, steady runs get their pitch from the balance of moments.
fn pitched(runs: Vec<Run>, bench: Bench<'_>, options: &StagedOptions, warnings: &mut Vec<Finding>) -> Vec<Run> {
    if options.steady.pitch == PitchSource::Logged {
        return runs;
    }
    let of = |run: Run| match run.kind {
        RunKind::ConstantVelocity => match pitch::of_moments(&run, bench.vehicle, &options.steady) {
            Ok(pitched) => pitched,
            Err(text) => {
                warnings.push(Finding::new(&codes::NO_PITCH, text).of_run(&run.name));
                run
            }
        },
        _ => run,
    };
    runs.into_iter().map(of).collect()
}

/// Returns an error if advance losses along the thrusters' axes are asked for and a run that moves
/// by its thrusters lacks the force of each thruster.
fn check_axis(runs: &[Run], bench: Bench<'_>) -> Result<(), ProcedureError> {
    let along = bench.efficiency.advance_speed == AdvanceSpeed::ThrusterAxis && bench.efficiency.eta_adv.is_some();
    let drives = |run: &&Run| !matches!(run.kind, RunKind::Bollard | RunKind::Towing);
    let lacking = runs.iter().filter(drives).find(|run| along && !effective_thrust::by_thruster(run, bench.thrusters));
    lacking.map_or(Ok(()), |run| Err(ProcedureError::AdvanceByThruster { run: run.name.clone() }))
}

/// Adds a finding for each window that is given for a run that does not exist.
fn check_windows(runs: &[Run], options: &StagedOptions, warnings: &mut Vec<Finding>) {
    let steady = |run: &&Run| matches!(run.kind, RunKind::ConstantVelocity | RunKind::Towing);
    let names: Vec<&str> = runs.iter().filter(steady).map(|run| run.name.as_str()).collect();
    for window in options.steady.windows.iter().filter(|w| !names.contains(&w.run.as_str())) {
        let hint = crate::nearest::nearest(&window.run, names.iter().copied());
        let hint = hint.map_or(String::new(), |name| format!("; did you mean `{name}`?"));
        let text = format!("stage.steady.windows: `{}` is not a constant-velocity or towing run{hint}", window.run);
        warnings.push(Finding::new(&codes::NO_SUCH_RUN, text));
    }
}

/// Adds findings about impossible signs, parameters that no stage estimates, and a net weight
/// without restoring term.
fn judge(model: &Model, held: &Held, vehicle: &Vehicle, runs: &[Run], result: &mut StagedResult) {
    for stage in &mut result.stages {
        let unphysical = |e: &&Estimate| {
            let is_this = |p: &&Parameter| p.effect == e.effect && p.spec.name == e.name;
            model.parameters.iter().find(is_this).is_some_and(|p| p.spec.least >= 0.0 && e.value < 0.0)
        };
        for e in stage.estimates.iter().filter(unphysical) {
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
        && id::restoring(Dof::Surge).is_some_and(|id| model.term(&id).is_none())
    {
        result.warnings.push(Finding::new(&codes::GRAVITY, codes::GRAVITY.meaning));
    }
}
