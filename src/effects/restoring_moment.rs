//! Righting moment: centre of buoyancy above centre of gravity.
//!
//! ```text
//! (K, M) −= (z_g W − z_b B) (cos θ sin φ, sin θ)
//! ```
//!
//! z_g W − z_b B: N·m, one parameter for both. Fossen (2021), ch. 4.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// The righting moment in roll or pitch.
#[derive(Debug)]
pub struct RestoringMoment(pub Dof);

impl Effect for RestoringMoment {
    fn about(&self) -> About<'_> {
        let (id, formula, scope): (_, _, &[Dof]) = match self.0 {
            Dof::Roll => ("restoring_roll", "−(z_g W − z_b B) cos θ sin φ", &[Dof::Roll]),
            _ => ("restoring_pitch", "−(z_g W − z_b B) sin θ", &[Dof::Pitch]),
        };
        About {
            id,
            family: Family::Body,
            scope: Scope::Vehicle(scope),
            formula,
            meaning: "Moment that rights the vehicle.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 4",
            shown_by: "roll and pitch that vary",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear("z_gW-z_bB", Dimension::MOMENT).shared("righting")]
    }

    fn pose(&self) -> &'static [&'static str] {
        match self.0 {
            Dof::Roll => &["phi"],
            _ => &["theta"],
        }
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let down = at.down();
        match self.0 {
            Dof::Roll => wrench[3] -= theta[0] * down[1],
            _ => wrench[4] += theta[0] * down[0],
        }
    }
}
