//! A steady force that keeps its compass direction.
//!
//! ```text
//! (X, Y, Z) += Rᵀ(φ, θ, ψ) (F_N, F_E, 0)
//! ```
//!
//! F_N, F_E: force north and east, N. Causes: a steady wind on what stands out of the water, or a
//! tether that the current carries off. A current is a different effect: it acts through drag and
//! inertia, and so depends on the speed through the water. A wind with known force coefficients
//! ahead and abeam and a logged speed is a formula of the campaign file.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "earth_force";

/// A steady force that keeps its compass direction.
#[derive(Debug)]
pub struct EarthForce;

impl Effect for EarthForce {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Environment,
            scope: Scope::Vehicle(&[Dof::Surge]),
            formula: "(X, Y, Z) += Rᵀ(F_N, F_E, 0)",
            meaning: "A steady force that keeps its compass direction: wind, or a tether that hangs off to one side.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 10 (wind)",
            shown_by: "several headings, at small and at large speeds",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        ["F_N", "F_E"].map(|name| ParameterSpec::linear(name, Dimension::FORCE)).to_vec()
    }

    fn pose(&self) -> &'static [&'static str] {
        &["psi"]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let push = at.to_body([theta[0], theta[1], at.graph.zero()]);
        for (axis, force) in wrench.iter_mut().zip(push) {
            *axis += force;
        }
    }
}
