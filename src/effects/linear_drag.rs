//! Linear drag.
//!
//! ```text
//! wᵢ −= d νᵢ
//! ```
//!
//! d: kg/s (kg·m²/s), SNAME X_u = −d. Skin friction at low speed; Avila et al. (2013), eq. 3.

use super::parameter::{drag, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;

/// Id, as in a campaign file.
pub const ID: &str = "linear_drag";

/// Drag in proportion to the speed.
#[derive(Debug)]
pub struct LinearDrag;

impl Effect for LinearDrag {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Body,
            scope: Scope::Each(&Dof::ALL),
            formula: "−d νᵢ",
            meaning: "Drag proportional to the speed.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), eq. 3",
            shown_by: "low speeds",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        let v = dof.velocity();
        vec![drag(dof, v, velocity(dof)).at_least(0.0)]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let i = place.here().index();
        let v = at.nu_r[i];
        wrench[i] -= theta[0] * v;
    }
}
