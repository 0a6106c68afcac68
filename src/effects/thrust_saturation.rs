//! A command that exceeds the greatest thrust.
//!
//! ```text
//! τᵢ → min(max(τᵢ, −c), c)
//! ```
//!
//! c: N (N·m).

use super::parameter::force;
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;

/// A limit of the thrust.
#[derive(Debug)]
pub struct ThrustSaturation;

impl Effect for ThrustSaturation {
    fn about(&self) -> About<'_> {
        About {
            id: "thrust_saturation",
            family: Family::Actuator,
            scope: Scope::Each(&Dof::ALL),
            formula: "τᵢ → min(max(τᵢ, −c), c)",
            meaning: "A limit of the thrust.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 9",
            shown_by: "commands near the limit",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        vec![
            ParameterSpec::shape(
                format!("c_sat{}", dof.velocity()),
                force(dof),
                &[0.5, 0.7, 0.85, 0.95],
                0.0,
                f64::MAX,
            )
            .relative()
            .neutral(f64::INFINITY),
        ]
    }

    fn actuate<'g>(&self, _: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], tau: &mut Six<'g>) {
        let i = place.here().index();
        tau[i] = tau[i].max(-theta[0]).min(theta[0]);
    }
}
