//! Position without a heading.
//!
//! ```text
//! (ẋ, ẏ) = R(ψ) (u, v)      north and east say nothing of surge and sway where ψ is not known
//! ```

use super::codes;
use crate::estimate::output_error::heading_is_known;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::Run;

/// Returns the finding that the position takes no part, if the heading is neither modelled nor
/// logged.
pub(super) fn finding(model: &Model, runs: &[Run]) -> Option<Finding> {
    let moving: Vec<Run> = runs.iter().filter(|run| super::moves::moves(run.kind)).cloned().collect();
    let logged = |name: &&str| moving.iter().any(|run| run.signal(name).is_some_and(|s| !s.is_empty()));
    let horizontal = [Dof::Surge, Dof::Sway].into_iter().filter(|dof| model.dofs.contains(dof));
    let lost: Vec<&str> = horizontal.map(Dof::position).filter(logged).collect();
    (!lost.is_empty() && !heading_is_known(model, &moving)).then(|| {
        let text = format!(
            "the position {} is logged, but the heading is neither modelled nor logged: north and east then show \
             nothing of surge and sway and are not used; log psi",
            lost.join(", ")
        );
        Finding::new(&codes::NO_HEADING, text)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::run::Signal;

    #[test]
    fn a_position_needs_a_heading() {
        let of = |dofs: &[Dof], channels: &[&str]| {
            let mut run = Run::default();
            for name in channels {
                run.signals.insert((*name).into(), Signal::new(vec![0.0, 1.0].into(), vec![0.0, 1.0]));
            }
            let model = Model::with_effects(dofs, Coriolis::Tied, &["inertia"]).unwrap();
            finding(&model, &[run]).is_some()
        };
        let vertical = [Dof::Surge, Dof::Heave, Dof::Pitch];
        assert!(of(&vertical, &["u", "w", "q", "x", "z"]));
        assert!(!of(&vertical, &["u", "w", "q", "x", "z", "psi"]));
        assert!(!of(&vertical, &["u", "w", "q", "z"]), "a depth needs none");
        assert!(!of(&[Dof::Surge, Dof::Yaw], &["u", "r", "x"]), "the model tells it");
    }
}
