//! A loss of thrust astern.
//!
//! ```text
//! τᵢ → (1 − k) τᵢ   where τᵢ < 0
//! ```
//!
//! k: 1. Propellers are made for one direction: Avila et al. (2013), eq. 1 has one curve for each.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// A loss of thrust when the force is negative.
#[derive(Debug)]
pub struct ThrustReverseLoss;

impl Effect for ThrustReverseLoss {
    fn about(&self) -> About<'_> {
        About {
            id: "thrust_reverse_loss",
            family: Family::Actuator,
            scope: Scope::Each(&Dof::ALL),
            formula: "τᵢ → (1 − k) τᵢ   where τᵢ < 0",
            meaning: "A loss of thrust when the force is negative.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), eq. 1",
            shown_by: "commands of both signs, against and with the motion",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear(format!("k_rev{}", place.here().velocity()), Dimension::ONE)]
    }

    fn actuate<'g>(&self, _: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], tau: &mut Six<'g>) {
        let i = place.here().index();
        tau[i] = tau[i] - theta[0] * (-tau[i]).step() * tau[i];
    }
}
