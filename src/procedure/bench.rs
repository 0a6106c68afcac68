//! Inputs of every stage: the vehicle data apart from the model, the runs of a kind, the parameters
//! of effects.

use super::prepare::shown;
use crate::chain::{Nature, nature};
use crate::frame::Dof;
use crate::model::{Model, Term};
use crate::run::{Run, RunKind};
use crate::thrust::efficiency::Efficiency;
use crate::thrust::measured::MeasuredCurve;
use crate::thrust::thruster::Thruster;
use crate::vehicle::{Vehicle, Water};

/// Data of the vehicle apart from its model.
#[derive(Debug, Clone, Copy)]
pub struct Bench<'a> {
    /// Weighed and measured data of the vehicle.
    pub vehicle: &'a Vehicle,
    /// The water.
    pub water: &'a Water,
    /// Known losses of thrust; bollard runs supply η_inter where it is absent.
    pub efficiency: &'a Efficiency,
    /// The thrusters, if they are described; for runs that log each of them, the losses apply
    /// thruster by thruster.
    pub thrusters: &'a [Thruster],
    /// Thruster curves that were fitted to bollard tables, with their covariance.
    pub curves: &'a [MeasuredCurve],
}

/// Runs of a kind that show `dof`: every zig-zag does; any other run shows one of `dofs`.
pub(super) fn of_kind<'a>(runs: &'a [Run], kind: RunKind, dof: Dof, dofs: &[Dof]) -> Vec<&'a Run> {
    let shows = |run: &&Run| kind == RunKind::Zigzag || shown(run, dofs) == Some(dof);
    runs.iter().filter(|run| run.kind == kind).filter(shows).collect()
}

/// Free linear parameters of the terms in `dof` whose nature is `wanted`.
pub(super) fn parameters_of(model: &Model, dof: Dof, wanted: Nature) -> Vec<usize> {
    let here = |term: &&Term| term.place.dof == Some(dof) && nature(model, term) == wanted;
    let own = |p: &usize| !model.parameters[*p].fixed && model.parameters[*p].spec.is_linear();
    model.terms.iter().filter(here).flat_map(|term| term.parameters.iter().copied().filter(own)).collect()
}

/// Free linear parameters of these effects in `dof`.
pub(super) fn parameters_at(model: &Model, dof: Dof, effects: &[&str]) -> Vec<usize> {
    let here = |p: &usize| {
        let parameter = &model.parameters[*p];
        parameter.place.dof == Some(dof) && effects.contains(&parameter.effect.as_str()) && parameter.spec.is_linear()
    };
    model.free().into_iter().filter(here).collect()
}
