//! A constant loss of thrust by interaction with the hull and other thrusters.
//!
//! ```text
//! τᵢ → η τᵢ
//! ```
//!
//! η: 1. Any wrong scale of the thrust looks the same; a negative η means a wrong sign. Avila et
//! al. (2013), eq. 16 and Table 2.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "thrust_interaction_loss";

/// A wrong scale of the thrust.
#[derive(Debug)]
pub struct ThrustInteractionLoss;

impl Effect for ThrustInteractionLoss {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Actuator,
            scope: Scope::Each(&Dof::ALL),
            formula: "τᵢ → η τᵢ",
            meaning: "A wrong scale of the thrust.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), eq. 16",
            shown_by: "load cells, or a mass, a weight or Coriolis terms that fix the scale",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear(format!("eta_{}", place.here().velocity()), Dimension::ONE).neutral(1.0)]
    }

    fn actuate<'g>(&self, _: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], tau: &mut Six<'g>) {
        let i = place.here().index();
        tau[i] = theta[0] * tau[i];
    }
}
