//! Thrust that falls with the speed of advance.
//!
//! ```text
//! τᵢ → (1 − k |νᵢ|) τᵢ
//! ```
//!
//! k: s/m (s). Avila et al. (2013), eq. 17: η_adv = 0.9967 − 0.1946 |v_a|, for 0 to 1 m/s.

use super::parameter::velocity;
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "thrust_advance_loss";

/// A loss of thrust in proportion to the speed.
#[derive(Debug)]
pub struct ThrustAdvanceLoss;

impl Effect for ThrustAdvanceLoss {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Actuator,
            scope: Scope::Each(&Dof::ALL),
            formula: "τᵢ → (1 − k |νᵢ|) τᵢ",
            meaning: "A loss of thrust proportional to the speed.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), eq. 17",
            shown_by: "thrust and speed that vary independently: acceleration at full command, coasting",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        vec![ParameterSpec::linear(format!("k_adv{}", dof.velocity()), Dimension::ONE.over(velocity(dof)))]
    }

    fn actuate<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], tau: &mut Six<'g>) {
        let i = place.here().index();
        tau[i] = tau[i] - theta[0] * at.nu_r[i].abs() * tau[i];
    }
}
