//! Stage (iii): inertia, coupling and bias, and in a zig-zag the Munk coefficient, with drag held.
//!
//! ```text
//! oscillatory:  u̇ = a₁ q̇ + a₂ R + a₃,   a₁ = −X_q̇/m_u, a₂ = 1/m_u, a₃ = −b/m_u     (20), (21), (26), (27)
//! zig-zag:      ṙ = a₁ u v + a₂ R + a₃,  a₁ = −k_uv/I_r, a₂ = 1/I_r, a₃ = −b/I_r     (28), (29)
//!               u̇ = a₁ v r + a₂ R + …,   v̇ = a₁ u r + a₂ R                        (28), free coefficients
//! R = τ − drag with the coefficients of stage (ii)
//! ```
//!
//! In integral form, per unit inertia. The parameters follow from the fitted ratios by the delta
//! method, and the uncertainty of the held drag is propagated. Rows have the time stamps of the own
//! velocity; u and v of a slower sensor are interpolated linearly. Inertia and bias are also free
//! in a zig-zag: if they were held at values from oscillations of other amplitudes, their misfit
//! would be taken for a Coriolis coefficient, because v r hardly changes sign. Each run has a stage
//! of its own, and all runs together have one more.

use super::effective_thrust::acting_forces;
use super::numbers::flow_numbers;
use super::result::Stage;
use super::stage_covariance::{Found, Held, How};
use super::{Bench, ProcedureError, StagedOptions, codes, parameters_at, parameters_of};
use crate::chain::Nature;
use crate::effects::{Coriolis, id};
use crate::estimate::{RegressorOptions, Span};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::Run;

/// Kind of run, which decides what the balance contains besides inertia and bias.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Motion in one degree of freedom.
    Oscillatory,
    /// Turning at speed.
    Zigzag,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Kind::Oscillatory => "oscillatory",
            Kind::Zigzag => "zigzag",
        }
    }

    /// Samples per row, whether drag is held, whether each run has a stage of its own.
    fn options(self, options: &StagedOptions) -> (usize, bool, bool) {
        let (o, z) = (&options.oscillatory, &options.zigzag);
        match self {
            Kind::Oscillatory => (o.window, o.hold_drag, o.per_run),
            Kind::Zigzag => (z.window, z.hold_drag, z.per_run),
        }
    }

    /// Parameters to estimate in `dof`.
    pub fn free(self, model: &Model, dof: Dof, held: &Held, options: &StagedOptions) -> Vec<usize> {
        let drag = if self.options(options).1 { Vec::new() } else { parameters_of(model, dof, Nature::Drag) };
        let coriolis = match model.coriolis {
            Coriolis::Free => parameters_of_term(model, &id::coriolis(dof)),
            // tied: k_uv = m_v − m_u; the mass in sway is estimated in yaw if no run of sway has
            // shown it
            Coriolis::Tied if dof == Dof::Yaw => {
                parameters_at(model, Dof::Sway, &[id::INERTIA]).into_iter().filter(|p| !held.has(*p)).collect()
            }
            Coriolis::Tied => Vec::new(),
        };
        match self {
            Kind::Oscillatory => [parameters_at(model, dof, &MOMENTUM_AND_BIAS), drag].concat(),
            // without a coefficient of its own the balance shows nothing that an oscillation does
            // not show better
            Kind::Zigzag if coriolis.is_empty() && dof != Dof::Yaw => Vec::new(),
            Kind::Zigzag => [parameters_at(model, dof, &MOMENTUM_AND_BIAS), coriolis, drag].concat(),
        }
    }
}

/// Degrees of freedom whose balance is fitted to a zig-zag.
pub(super) const ZIGZAG: [Dof; 3] = [Dof::Surge, Dof::Sway, Dof::Yaw];

/// Effects that a run in one degree of freedom determines if its drag is held.
const MOMENTUM_AND_BIAS: [&str; 3] = [id::INERTIA, id::ADDED_MASS_COUPLING, id::BIAS];

fn parameters_of_term(model: &Model, name: &str) -> Vec<usize> {
    let all = model.term(name).map(|t| model.terms[t].parameters.clone()).unwrap_or_default();
    all.into_iter().filter(|p| !model.parameters[*p].fixed).collect()
}

/// Stages of each run and of all runs together; the returned fit is that of all.
pub(super) fn stages(
    kind: Kind,
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    held: &Held,
    bench: &Bench<'_>,
    options: &StagedOptions,
) -> Result<Result<(Vec<Stage>, Found), Finding>, ProcedureError> {
    let free = kind.free(model, dof, held, options);
    let (samples, _, per_run) = kind.options(options);
    let regressor = RegressorOptions { span: Span::Samples(samples), ..RegressorOptions::default() };
    let how = How { regressor, std: options.std, few: false };
    let mut stages = Vec::new();
    for run in runs.iter().filter(|_| per_run && runs.len() > 1) {
        let found = held.fit((dof, &[run]), model, &free, how, &|_| {});
        let found = match ProcedureError::unless_data(kind.name(), dof, found)? {
            Ok(found) => found,
            Err(finding) => return Ok(Err(finding.of_run(&run.name))),
        };
        stages.push(of_run(kind, format!("{} {}", kind.name(), run.name), dof, run, model, held, bench, &found));
    }
    // an inertia that depends on the amplitude is identifiable from several runs only
    let several = kind == Kind::Oscillatory && runs.len() > 1;
    let amplitude = if several { parameters_at(model, dof, &[id::ADDED_MASS_AMPLITUDE]) } else { Vec::new() };
    let free = [free, amplitude].concat();
    let found = match ProcedureError::unless_data(kind.name(), dof, held.fit((dof, runs), model, &free, how, &|_| {}))?
    {
        Ok(found) => found,
        Err(finding) => return Ok(Err(finding)),
    };
    let mut stage = match runs {
        [run] => of_run(kind, kind.name().to_string(), dof, run, model, held, bench, &found),
        runs => {
            let names = runs.iter().map(|r| r.name.clone()).collect();
            Stage::of_fit(kind.name(), dof, names, model, &found.fit)
        }
    };
    finish(kind, model, &mut stage);
    stages.push(stage);
    Ok(Ok((stages, found)))
}

/// The stage of a single run, with its flow numbers if it is oscillatory.
#[allow(clippy::too_many_arguments)] // one call; a struct for it would only name the same things twice
fn of_run(
    kind: Kind,
    name: String,
    dof: Dof,
    run: &Run,
    model: &Model,
    held: &Held,
    bench: &Bench<'_>,
    found: &Found,
) -> Stage {
    let mut stage = Stage::of_fit(name, dof, vec![run.name.clone()], model, &found.fit);
    if kind == Kind::Oscillatory {
        let mut own = held.written(model);
        found.fit.write_to(&mut own);
        let (acting, _) = acting_forces(run, &held.efficiency, &held.thrusters);
        stage.numbers = flow_numbers(&acting, 0, dof, &own, bench.vehicle, bench.water).ok().flatten();
    }
    stage
}

/// Adds a note if the Munk coefficient differs from the difference of the masses by more than three
/// standard errors.
fn finish(kind: Kind, model: &Model, stage: &mut Stage) {
    let masses = (model.value_at(id::INERTIA, Dof::Sway), model.value_at(id::INERTIA, Dof::Surge));
    if let (Kind::Zigzag, (Some(m_v), Some(m_u)), Some(k)) = (kind, masses, stage.estimate("k_uv"))
        && m_v > 0.0
        && m_u > 0.0
        && (k.value - (m_v - m_u)).abs() > 3.0 * k.std
    {
        let text = format!(
            "k_uv is {:.1} ± {:.1} kg, but the difference of the virtual masses is {:.1} kg: reported as estimated",
            k.value,
            k.std,
            m_v - m_u
        );
        stage.warnings.push(Finding::new(&codes::MUNK, text));
    }
}
