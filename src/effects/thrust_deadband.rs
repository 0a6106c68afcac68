//! A command that does nothing until it is large enough.
//!
//! ```text
//! τᵢ → sign(τᵢ) max(|τᵢ| − c, 0)
//! ```
//!
//! c: N (N·m). Causes: motor drivers and stuck propellers.

use super::parameter::force;
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;

/// A dead band of the thrust.
#[derive(Debug)]
pub struct ThrustDeadband;

impl Effect for ThrustDeadband {
    fn about(&self) -> About<'_> {
        About {
            id: "thrust_deadband",
            family: Family::Actuator,
            scope: Scope::Each(&Dof::ALL),
            formula: "τᵢ → sign(τᵢ) max(|τᵢ| − c, 0)",
            meaning: "A dead band of the thrust.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 9",
            shown_by: "commands that pass slowly through zero",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        vec![
            ParameterSpec::shape(format!("c_dead{}", dof.velocity()), force(dof), &[0.05, 0.15, 0.3], 0.0, f64::MAX)
                .relative(),
        ]
    }

    fn actuate<'g>(&self, _: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], tau: &mut Six<'g>) {
        let i = place.here().index();
        tau[i] = tau[i].sign() * (tau[i].abs() - theta[0]).max(tau[i].graph().zero());
    }
}
