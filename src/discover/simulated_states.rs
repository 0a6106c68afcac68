//! Whether a fit simulates the states that a candidate reads: an angle that no run logs and no term reads is not
//! simulated, so a candidate that depends on it cannot be scored.

use std::collections::BTreeSet;

use super::Candidate;
use crate::chain::{Attitude, Available, StateId};
use crate::dynamics::Dynamics;
use crate::estimate::output_error::Problem;
use crate::model::Model;

/// Whether each candidate can be added to `model` without a state that `problem` does not simulate.
pub(super) fn carried(problem: &Problem, model: &Model, list: &[Candidate], channels: &BTreeSet<String>) -> Vec<bool> {
    let own = &problem.dynamics;
    let angles = model.dofs.iter().filter(|d| d.is_rotation());
    if own.quaternion().is_some() || angles.clone().all(|d| own.states.contains(&StateId::Position(*d))) {
        return vec![true; list.len()];
    }
    let observed: BTreeSet<String> = own.outputs.iter().cloned().collect();
    let stays = |candidate: &Candidate| {
        let mut model = model.clone();
        let probe = candidate.probes.first().map_or(&[][..], Vec::as_slice);
        let available = Available { channels: channels.clone(), ..available_of(problem) };
        candidate.add_to(&mut model, probe).is_ok() && {
            let with = Dynamics::compile(&model, &available, &observed, &[]);
            let known = |s: &StateId| matches!(s, StateId::Memory { .. }) || own.states.contains(s);
            with.states.iter().all(known)
        }
    };
    list.iter().map(stays).collect()
}

/// Inputs available to equations like those of `problem`: whether position is simulated, and the form of the attitude.
pub(super) fn available_of(problem: &Problem) -> Available {
    let position = problem.dynamics.states.iter().any(|s| matches!(s, StateId::Position(dof) if !dof.is_rotation()));
    let attitude = if problem.dynamics.quaternion().is_some() { Attitude::Quaternion } else { Attitude::Angles };
    Available { position, attitude, ..Available::default() }
}
