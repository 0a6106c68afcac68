//! Quadratic drag that differs between ahead and astern.
//!
//! ```text
//! wᵢ −= d νᵢ |νᵢ|   only where νᵢ < 0
//! ```
//!
//! d: kg/m (kg·m²), the additional quadratic drag at negative velocity.

use super::parameter::{drag, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;

/// Id, as in a campaign file.
pub const ID: &str = "drag_asymmetry";

/// Quadratic drag that differs between the two directions of motion.
#[derive(Debug)]
pub struct DragAsymmetry;

impl Effect for DragAsymmetry {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Body,
            scope: Scope::Each(&Dof::ALL),
            formula: "−d νᵢ |νᵢ|   only where νᵢ < 0",
            meaning: "Quadratic drag that differs between the two directions of motion.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), Table 7: yaw drag per direction",
            shown_by: "motion in both directions",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        let v = dof.velocity();
        vec![drag(dof, &format!("{v}|{v}|-"), velocity(dof).power(2))]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let i = place.here().index();
        let v = at.nu_r[i];
        wrench[i] -= theta[0] * v * v.abs() * (-v).step();
    }
}
