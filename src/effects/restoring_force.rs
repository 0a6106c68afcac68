//! Net weight: the restoring force of a vehicle that is heavier or lighter than the water it displaces.
//!
//! ```text
//! (X, Y, Z) += (W − B) (−sin θ, cos θ sin φ, cos θ cos φ)
//! ```
//!
//! W − B: weight less buoyancy, N; one parameter for all three. Avila et al. (2013), eq. 19; Fossen (2021), ch. 4.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// The part of the net weight in surge, sway or heave.
#[derive(Debug)]
pub struct RestoringForce(pub Dof);

impl Effect for RestoringForce {
    fn about(&self) -> About<'_> {
        let (id, formula, scope): (_, _, &[Dof]) = match self.0 {
            Dof::Surge => ("restoring_surge", "−(W − B) sin θ", &[Dof::Surge]),
            Dof::Sway => ("restoring_sway", "(W − B) cos θ sin φ", &[Dof::Sway]),
            _ => ("restoring_heave", "(W − B) cos θ cos φ", &[Dof::Heave]),
        };
        About {
            id,
            family: Family::Body,
            scope: Scope::Vehicle(scope),
            formula,
            meaning: "Weight minus buoyancy, rotated into body axes.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), eq. 19",
            shown_by: "pitch or roll that varies independently of the speed",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear("W-B", Dimension::FORCE).shared("net_weight")]
    }

    fn pose(&self) -> &'static [&'static str] {
        match self.0 {
            Dof::Surge => &["theta"],
            Dof::Sway => &["phi"],
            _ => &[],
        }
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let i = self.0.index();
        wrench[i] += theta[0] * at.down()[i];
    }
}
