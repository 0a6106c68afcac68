//! Runs near the vertical: representation of their attitude, and what they must log for it.
//!
//! A model that turns about several axes uses a quaternion there ([`Attitude::of`]), for which each
//! run needs all three angles at the same time stamps. A model that only pitches has no
//! singularity: its θ goes on beyond 90°, where instruments report a vehicle on its back.

use super::codes;
use super::moves::moves;
use crate::chain::{Attitude, turns_freely};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::navigation::upright;
use crate::run::Run;

/// |θ| beyond which Euler angles are poor, and beyond which they are of no use, rad.
const NEAR_POLE: [f64; 2] = [1.3, 1.5];

/// Whether the model pitches and turns about no other axis.
fn pitches_alone(model: &Model) -> bool {
    model.dofs.contains(&Dof::Pitch) && !turns_freely(model)
}

/// Continues θ of a run beyond the vertical if the model only pitches.
pub(super) fn unfold(model: &Model, run: &mut Run) {
    if pitches_alone(model) {
        upright::unfold(run);
    }
}

/// Returns the findings about runs near the vertical, errors among them.
pub(super) fn findings(model: &Model, runs: &[Run]) -> Vec<Finding> {
    if !model.dofs.contains(&Dof::Pitch) {
        return Vec::new();
    }
    let moving: Vec<Run> = runs.iter().filter(|run| moves(run.kind)).cloned().collect();
    let alone = pitches_alone(model);
    let upright = Attitude::of(model, &moving) == Attitude::Quaternion;
    let lacking = moving.iter().find(|run| !upright::is_whole(run));
    moving.iter().filter_map(|run| judged(run, alone, upright, lacking)).collect()
}

fn judged(run: &Run, alone: bool, upright: bool, lacking: Option<&Run>) -> Option<Finding> {
    let most = run.signal("theta")?.values().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let degrees = most.to_degrees();
    if alone && run.signal("phi").is_some() {
        return None;
    }
    if upright {
        let text = format!(
            "run `{}` pitches by {degrees:.0}°: attitude is represented by a quaternion and compared by rotations, not \
             by angles",
            run.name
        );
        return upright::is_steep(run).then(|| Finding::new(&codes::BY_QUATERNION, text).of_run(&run.name));
    }
    let code = if most > NEAR_POLE[1] { &codes::VERTICAL } else { &codes::NEAR_VERTICAL };
    let needed = match lacking {
        _ if alone => "log phi, which tells on which side of the vertical the vehicle is".to_string(),
        Some(other) => format!("log phi, theta and psi at the same instants, which run `{}` does not", other.name),
        None => "simulate roll or yaw as well".to_string(),
    };
    let text = format!("run `{}` pitches by {degrees:.0}°, and Euler angles are singular at 90°: {needed}", run.name);
    (most > NEAR_POLE[0]).then(|| Finding::new(code, text).of_run(&run.name))
}
