//! Whether anything in a campaign tells absolute forces.
//!
//! ```text
//! d(c π)/dt = c w + (c η) τ       for any c
//! ```
//!
//! Where the scale of the thrust (η) is free and so is every inertia, drag and restoring force, any multiple of a solution
//! is one: motion alone shows ratios. One inertia, weight or scale of thrust that is held, or has a prior, ends that.

use super::codes;
use crate::effects::Family;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::{Model, Parameter};

/// One sentence on the degrees of freedom in which no force is known absolutely; none where all are.
pub(super) fn finding(model: &Model) -> Option<Finding> {
    let open: Vec<&str> = model.dofs.iter().filter(|dof| is_open(model, **dof)).map(|dof| dof.name()).collect();
    // terms that couple carry a known scale from one degree of freedom to the others
    if open.is_empty() || coupled(model) && open.len() < model.dofs.len() {
        return None;
    }
    let text = format!(
        "no force is known absolutely in {}: the scale of the thrust is free and no inertia, drag or weight is held or has a \
         prior, so that any multiple of the estimates fits as well; hold one with [[parameter]] fixed = true (a weighed mass \
         with its added part, a measured thrust) or give it a `std`",
        open.join(", ")
    );
    Some(Finding::new(&codes::NO_SCALE, text))
}

/// Whether the scale of the thrust and of everything else in the balance of `dof` is free.
fn is_open(model: &Model, dof: Dof) -> bool {
    let free = |p: &Parameter| !p.fixed && p.prior.is_none();
    let here = |p: &&Parameter| p.place.dof == Some(dof) || p.spec.shared.is_some();
    let scale =
        model.parameters.iter().any(|p| p.effect == "thrust_interaction_loss" && p.place.dof == Some(dof) && free(p));
    let known = |p: &Parameter| {
        let term = model.term(&p.term).map(|t| model.terms[t].effect.about().family);
        let force = term == Some(Family::Body) && p.spec.is_linear();
        force && !free(p) && p.value != 0.0
    };
    scale && !model.parameters.iter().filter(here).any(known)
}

/// Whether inertias stand in the balance of more than their own degree of freedom.
fn coupled(model: &Model) -> bool {
    model.terms.iter().any(|t| t.effect.about().id.starts_with("coriolis_") && t.parameters.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    #[test]
    fn one_held_inertia_or_a_prior_gives_the_scale() {
        let effects = ["inertia", "linear_drag", "thrust_interaction_loss"];
        let mut model = Model::with_effects(&[Dof::Surge, Dof::Yaw], Coriolis::Tied, &effects).unwrap();
        assert!(finding(&model).unwrap().message.contains("absolutely in surge, yaw"));
        let surge = model.parameter_of("inertia@surge").unwrap();
        (model.parameters[surge].value, model.parameters[surge].fixed) = (300.0, true);
        assert!(finding(&model).unwrap().message.contains("absolutely in yaw"));
        let yaw = model.parameter_of("linear_drag@yaw").unwrap();
        (model.parameters[yaw].value, model.parameters[yaw].prior) = (20.0, Some((20.0, 2.0)));
        assert_eq!(finding(&model), None);
        let known = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        assert_eq!(finding(&known), None, "thrust in newton is a force that is known");
    }
}
