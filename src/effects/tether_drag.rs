//! Drag of the tether that has been paid out.
//!
//! ```text
//! wᵢ −= k z νᵢ |νᵢ|
//! ```
//!
//! k: kg/m² (kg·m); z: depth, the length of tether in the water, m.

use super::parameter::{force, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Drag that grows with the length of tether in the water.
#[derive(Debug)]
pub struct TetherDrag;

impl Effect for TetherDrag {
    fn about(&self) -> About<'_> {
        About {
            id: "tether_drag",
            family: Family::Environment,
            scope: Scope::Each(&Dof::ALL),
            formula: "−k z νᵢ |νᵢ|",
            meaning: "Drag that grows with the length of tether in the water.",
            source: "Feng and Allen, IEEE Journal of Oceanic Engineering 29 (2004)",
            shown_by: "runs at different depths",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        let dimension = force(dof).over(velocity(dof).power(2)).over(Dimension::LENGTH);
        vec![ParameterSpec::linear(format!("k_z{0}|{0}|", dof.velocity()), dimension).at_least(0.0)]
    }

    fn pose(&self) -> &'static [&'static str] {
        &["z"]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let i = place.here().index();
        wrench[i] -= theta[0] * at.position[2] * at.nu_r[i] * at.nu_r[i].abs();
    }
}
