//! The part of a log with which a model is compared.
//!
//! ```text
//! velocities and angles;   north, east and down if measured apart and the heading is known;
//! functions of the states
//! ```

use std::collections::BTreeSet;

use super::OutputErrorOptions;
use crate::chain::{Attitude, Available};
use crate::frame::Dof;
use crate::model::Model;
use crate::navigation::upright;
use crate::run::Run;

/// The runs with the channels with which a quaternion is compared, if a quaternion carries the
/// attitude.
pub(super) fn upright(model: &Model, runs: &[Run]) -> Option<Vec<Run>> {
    (Attitude::of(model, runs) == Attitude::Quaternion).then(|| runs.iter().map(upright::with_quaternion).collect())
}

/// Channels that all runs have, and whether the position is simulated.
pub(crate) fn available(model: &Model, runs: &[Run], options: &OutputErrorOptions) -> Available {
    let mut channels: BTreeSet<String> = runs.first().map(|r| r.signals.keys().cloned().collect()).unwrap_or_default();
    channels.retain(|name| runs.iter().all(|run| run.signal(name).is_some_and(|s| !s.is_empty())));
    let planar = model.dofs.iter().filter(|d| !d.is_rotation()).all(|d| channels.contains(d.position()));
    let attitude = Attitude::of(model, runs);
    let position = options.position && planar || model.dofs.iter().any(|dof| pose_only(*dof, runs));
    Available { channels, position, from_log: false, attitude }
}

/// Whether a motion is known only by its position: no run logs its velocity.
fn pose_only(dof: Dof, runs: &[Run]) -> bool {
    let logged = |name: &str| runs.iter().any(|run| run.signal(name).is_some_and(|s| !s.is_empty()));
    !dof.is_rotation() && !logged(dof.velocity()) && logged(dof.position())
}

/// Whether north and east follow from surge and sway: the heading is modelled, or every run logs
/// it.
pub(crate) fn heading_is_known(model: &Model, runs: &[Run]) -> bool {
    let logged = |run: &Run| run.signal(Dof::Yaw.position()).is_some_and(|s| !s.is_empty());
    model.dofs.contains(&Dof::Yaw) || runs.iter().all(logged)
}

/// Channels that are compared: those of modelled velocities and angles (turns for a quaternion)
/// that some run logs, positions if measured independently with a known heading (heave: with any)
/// or if no run logs the velocity, and observed functions of the states.
pub(super) fn observed(model: &Model, runs: &[Run], options: &OutputErrorOptions) -> BTreeSet<String> {
    let turns = Attitude::of(model, runs) == Attitude::Quaternion;
    let fixed = |dof: &Dof| options.position && (*dof == Dof::Heave || heading_is_known(model, runs));
    let states = model.dofs.iter().flat_map(|dof| {
        let position = if dof.is_rotation() { !turns } else { fixed(dof) || pose_only(*dof, runs) };
        [Some(dof.velocity()), position.then(|| dof.position())]
    });
    let turns = upright::TURNS.into_iter().filter(|_| turns).map(Some);
    let logged = |name: &&str| runs.iter().any(|run| run.signal(name).is_some_and(|s| !s.is_empty()));
    let functions = model.observers.iter().map(crate::effects::Observer::channel);
    states.chain(turns).flatten().chain(functions).filter(logged).map(str::to_string).collect()
}
