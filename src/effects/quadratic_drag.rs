//! Quadratic drag.
//!
//! ```text
//! wᵢ −= d νᵢ |νᵢ|
//! ```
//!
//! d: kg/m (kg·m²), SNAME X_u|u| = −d. Pressure drag of a bluff body; Avila et al. (2013), eq. 3.

use super::parameter::{drag, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;

/// Id, as in a campaign file.
pub const ID: &str = "quadratic_drag";

/// Drag in proportion to the square of the speed.
#[derive(Debug)]
pub struct QuadraticDrag;

impl Effect for QuadraticDrag {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Body,
            scope: Scope::Each(&Dof::ALL),
            formula: "−d νᵢ |νᵢ|",
            meaning: "Drag proportional to the square of the speed.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), eq. 3",
            shown_by: "high speeds",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        let v = dof.velocity();
        vec![drag(dof, &format!("{v}|{v}|"), velocity(dof).power(2)).at_least(0.0)]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let i = place.here().index();
        let v = at.nu_r[i];
        wrench[i] -= theta[0] * v * v.abs();
    }
}
