//! Dry friction.
//!
//! ```text
//! wᵢ −= d tanh(νᵢ/ε),      ε = 1 cm/s or 0.01 rad/s
//! ```
//!
//! d: N (N·m). The tanh is the sign of the velocity, smooth enough to integrate. νᵢ is the
//! velocity through the water, as for every other resistance of the body.

use super::parameter::{force, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;

/// Id, as in a campaign file.
pub const ID: &str = "coulomb_friction";

/// ε, m/s or rad/s: the speed at which the friction has reached three quarters of its value.
const WIDTH: f64 = 0.01;

/// A resistance that does not depend on the speed, only on its sign.
#[derive(Debug)]
pub struct CoulombFriction;

impl Effect for CoulombFriction {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Body,
            scope: Scope::Each(&Dof::ALL),
            formula: "−d tanh(νᵢ/ε), ε = 0.01",
            meaning: "A resistance that does not depend on the speed, only on its sign.",
            source: "Olsson et al., European Journal of Control 4 (1998), friction models",
            shown_by: "slow motion in both directions",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        vec![ParameterSpec::linear(format!("c_{}", dof.velocity()), force(dof)).at_least(0.0)]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let i = place.here().index();
        wrench[i] -= theta[0] * (at.nu_r[i] / at.unit(velocity(place.here()), WIDTH)).tanh();
    }
}
