//! The direct regression: all parameters in one fit, with a differentiated velocity, as a
//! cautionary example.
//!
//! ```text
//! ṙ = a₁ u v + a₂ r + a₃ r|r| + a₄ τ + a₅,   ṙ by the slope of a polynomial filter             (30)
//! ```
//!
//! The result simulates about as well as the staged model, but its parameters may be absurd
//! (negative quadratic drag): in one run drag, inertia and the Munk moment are nearly the same
//! signal. It is shown for comparison and never recommended.

use super::result::Stage;
use super::{ProcedureError, StagedOptions, parameters_at, parameters_of};
use crate::chain::Nature;
use crate::effects::id;
use crate::estimate::{DirectError, IntegralError, direct_columns, fit_rows};
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, RunKind};

/// The direct fit of `dof` to `runs`: inertia, drag, Coriolis coefficient and bias are all free.
/// Returns the stage and the model with the estimated values.
///
/// # Errors
/// [`ProcedureError`] if the balance is not linear, the velocity cannot be differentiated, or the
/// rows do not determine the parameters.
pub fn direct(
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    options: &StagedOptions,
) -> Result<(Stage, Model), ProcedureError> {
    let mut all = model.clone();
    let own = [parameters_of(model, dof, Nature::Drag), parameters_at(model, dof, &[id::INERTIA, id::BIAS])];
    let mut free = own.concat();
    if let Some(term) = model.term(&id::coriolis(dof)) {
        free.extend(model.terms[term].parameters.iter().filter(|p| !model.parameters[**p].fixed));
    }
    for (k, parameter) in all.parameters.iter_mut().enumerate() {
        parameter.fixed = !free.contains(&k);
    }
    let columns = direct_columns(dof, runs, &all, &options.direct.filter).map_err(|error| match error {
        DirectError::Regressor(e) => ProcedureError::Integral(IntegralError::Regressor(e)),
        DirectError::Filter(e) => ProcedureError::Filter(e),
    })?;
    let inertia = model.inertia(dof);
    let fit = fit_rows(&columns, inertia, options.std).map_err(|source| ProcedureError::Linear {
        stage: "direct",
        dof,
        source,
    })?;
    let mut twin = model.clone();
    fit.write_to(&mut twin);
    let stage = Stage::of_fit("direct", dof, runs.iter().map(|r| r.name.clone()).collect(), model, &fit);
    Ok((stage, twin))
}

/// The model reduced to the balance of `dof`; all other motion is taken as logged, as in (29) and
/// (30).
#[must_use]
pub fn alone(model: &Model, dof: Dof) -> Model {
    let mut own = model.clone();
    own.dofs = vec![dof];
    own.terms.retain(|term| match term.place.dof {
        Some(place) => place == dof,
        None => term.effect.about().id.ends_with(&format!("_{dof}")),
    });
    own
}

/// Kind of runs for the direct fit of `dof`: zig-zags for yaw if there are any, otherwise
/// oscillatory runs.
pub fn kind_of(dof: Dof, runs: &[Run]) -> RunKind {
    let turns = dof == Dof::Yaw && runs.iter().any(|run| run.kind == RunKind::Zigzag);
    if turns { RunKind::Zigzag } else { RunKind::Oscillatory }
}
