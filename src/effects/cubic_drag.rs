//! Cubic drag.
//!
//! ```text
//! wᵢ −= d νᵢ³
//! ```
//!
//! d: kg·s/m² (kg·m²·s), SNAME X_uuu = −d. Abkowitz (1964), third-order manoeuvring model.

use super::parameter::{drag, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;

/// Id, as in a campaign file.
pub const ID: &str = "cubic_drag";

/// Drag in proportion to the cube of the speed.
#[derive(Debug)]
pub struct CubicDrag;

impl Effect for CubicDrag {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Body,
            scope: Scope::Each(&Dof::ALL),
            formula: "−d νᵢ³",
            meaning: "Drag proportional to the cube of the speed.",
            source: "Abkowitz, Lectures on Ship Hydrodynamics, HyA Report Hy-5 (1964)",
            shown_by: "a wide range of speeds",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        let v = dof.velocity();
        vec![drag(dof, &format!("{v}{v}{v}"), velocity(dof).power(3)).at_least(0.0)]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let i = place.here().index();
        let v = at.nu_r[i];
        wrench[i] -= theta[0] * v * v * v;
    }
}
