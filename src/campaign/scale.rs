//! Whether a campaign determines absolute forces.
//!
//! ```text
//! d(c π)/dt = c w + (c η) τ       for any c
//! ```
//!
//! If the scale of the thrust (η) and every inertia, drag and restoring force are free, any
//! multiple of a solution is a solution: motion alone shows ratios. One inertia, weight or scale of
//! thrust that is held, or has a prior, fixes the scale. The scale is also free if no command
//! drives a degree of freedom at all (τ = 0).

use super::codes;
use crate::chain::{Nature, nature};
use crate::effects::{Family, id};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::{Model, Parameter};
use crate::run::{Run, RunKind, is_commanded};

/// Returns a finding about the degrees of freedom in which no force is known absolutely, if there
/// are any.
///
/// `undriven` are those in which no run has a command and no formula of the user acts.
pub(super) fn finding(model: &Model, undriven: &[Dof]) -> Option<Finding> {
    let open: Vec<Dof> = model.dofs.iter().copied().filter(|dof| is_open(model, *dof, undriven)).collect();
    // coupling terms carry a known scale from one degree of freedom to the others
    if open.is_empty() || coupled(model) && open.len() < model.dofs.len() {
        return None;
    }
    let why = match open.iter().all(|dof| undriven.contains(dof)) {
        true => "no command drives it",
        false => "the scale of the thrust is free",
    };
    let names: Vec<&str> = open.iter().map(|dof| dof.name()).collect();
    let text = format!(
        "no force is known absolutely in {}: {why} and no inertia, drag or weight is fixed or has a prior, so any \
         multiple of the estimates fits as well; fix one with [[parameter]] fixed = true (a weighed mass with its \
         added mass, a measured thrust) or give it a `std`",
        names.join(", ")
    );
    Some(Finding::new(&codes::NO_SCALE, text))
}

/// Returns the modelled degrees of freedom in which no run has a command and no formula of the user
/// acts (`formulas`).
pub(super) fn undriven(model: &Model, runs: &[Run], formulas: &[Dof]) -> Vec<Dof> {
    // a campaign of bench runs has no moving vehicle
    if runs.iter().all(|run| run.kind == RunKind::Bench) {
        return Vec::new();
    }
    model.dofs.iter().copied().filter(|dof| !is_commanded(runs, *dof) && !formulas.contains(dof)).collect()
}

/// Whether everything in the balance of `dof` is free, the scale of the thrust included if there is
/// thrust.
fn is_open(model: &Model, dof: Dof, undriven: &[Dof]) -> bool {
    let free = |p: &Parameter| !p.fixed && p.prior.is_none();
    let here = |p: &&Parameter| p.place.dof == Some(dof) || p.spec.shared.is_some();
    let scale = undriven.contains(&dof)
        || model
            .parameters
            .iter()
            .any(|p| p.effect == id::THRUST_INTERACTION_LOSS && p.place.dof == Some(dof) && free(p));
    let known = |p: &Parameter| {
        let term = model.term(&p.term).map(|t| model.terms[t].effect.about().family);
        let force = term == Some(Family::Body) && p.spec.is_linear();
        force && !free(p) && p.value != 0.0
    };
    scale && !model.parameters.iter().filter(here).any(known)
}

/// Whether inertias are in the balance of other degrees of freedom than their own.
fn coupled(model: &Model) -> bool {
    model.terms.iter().any(|t| t.parameters.is_empty() && nature(model, t) == Nature::Coriolis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::run::Signal;

    #[test]
    fn one_held_inertia_or_a_prior_gives_the_scale() {
        let effects = ["inertia", "linear_drag", "thrust_interaction_loss"];
        let mut model = Model::with_effects(&[Dof::Surge, Dof::Yaw], Coriolis::Tied, &effects).unwrap();
        assert!(finding(&model, &[]).unwrap().message.contains("absolutely in surge, yaw"));
        let surge = model.parameter_of("inertia@surge").unwrap();
        (model.parameters[surge].value, model.parameters[surge].fixed) = (300.0, true);
        assert!(finding(&model, &[]).unwrap().message.contains("absolutely in yaw"));
        let yaw = model.parameter_of("linear_drag@yaw").unwrap();
        (model.parameters[yaw].value, model.parameters[yaw].prior) = (20.0, Some((20.0, 2.0)));
        assert_eq!(finding(&model, &[]), None);
        let known = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        assert_eq!(finding(&known, &[]), None, "thrust in newton is a force that is known");
    }

    #[test]
    fn a_motion_that_no_command_drives_has_no_scale() {
        let effects = ["inertia", "linear_drag"];
        let mut model = Model::with_effects(&[Dof::Surge, Dof::Yaw], Coriolis::Tied, &effects).unwrap();
        let run = |yaw: f64| {
            let signal = |value: f64| Signal::new(vec![0.0, 1.0, 2.0].into(), vec![value; 3]);
            let signals = [("tau_u".to_string(), signal(10.0)), ("tau_r".to_string(), signal(yaw))].into();
            Run { name: "a".into(), signals, ..Run::default() }
        };
        let of = |model: &Model, run: Run, formulas: &[Dof]| finding(model, &undriven(model, &[run], formulas));
        let said = of(&model, run(0.0), &[]).unwrap().message;
        assert!(said.contains("absolutely in yaw: no command drives it and"), "{said}");
        assert_eq!(of(&model, run(1.0), &[]), None);
        assert_eq!(of(&model, run(0.0), &[Dof::Yaw]), None, "a formula of the user's drives it");
        let drag = model.parameter_of("linear_drag@yaw").unwrap();
        (model.parameters[drag].value, model.parameters[drag].fixed) = (20.0, true);
        assert_eq!(of(&model, run(0.0), &[]), None, "a drag that is held is a force that is known");
    }
}
