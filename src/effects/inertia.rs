//! Inertia of vehicle and water.
//!
//! ```text
//! πᵢ = mᵢ νᵢ
//! ```
//!
//! mᵢ: virtual mass, dry and added, kg (kg·m² in rotation). Avila et al. (2013), eq. 3; SNAME's
//! −X_u̇ is its added part.

use super::parameter::{force, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "inertia";

/// Virtual mass: what accelerates with the vehicle, dry mass and added mass.
#[derive(Debug)]
pub struct Inertia;

impl Effect for Inertia {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Body,
            scope: Scope::Each(&Dof::ALL),
            formula: "πᵢ = mᵢ νᵢ",
            meaning: "Virtual mass: what accelerates with the vehicle, dry mass and added mass.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), eq. 3",
            shown_by: "any change of speed under a known force",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        let name = if dof.is_rotation() { format!("I_{}", dof.velocity()) } else { format!("m_{}", dof.velocity()) };
        let sname = format!("{}_{}dot", dof.sname(), dof.velocity());
        vec![
            ParameterSpec::linear(name, force(dof).over(velocity(dof)).times(Dimension::TIME))
                .sname(sname)
                .at_least(ParameterSpec::LEAST_INERTIA),
        ]
    }

    fn momentum<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], momentum: &mut Six<'g>) {
        let i = place.here().index();
        momentum[i] += theta[0] * at.nu_r[i];
    }
}
