//! A steady current.
//!
//! ```text
//! ν_r = ν − Rᵀ(φ, θ, ψ) (V_N, V_E, 0)      drag and Coriolis terms act on ν_r
//! ```
//!
//! V_N, V_E: velocity of the water north and east, m/s, constant in the earth frame. Fossen (2021), ch. 10.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Water that moves over ground.
#[derive(Debug)]
pub struct Current;

impl Effect for Current {
    fn about(&self) -> About<'_> {
        About {
            id: "current",
            family: Family::Environment,
            scope: Scope::Vehicle(&[Dof::Surge]),
            formula: "ν_r = ν − Rᵀ(V_N, V_E, 0)",
            meaning: "Water that moves over ground.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 10",
            shown_by: "several headings, or speeds both well above and below the current",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        ["V_N", "V_E"].map(|name| ParameterSpec::shape(name, Dimension::VELOCITY, &[0.0], -5.0, 5.0)).to_vec()
    }

    fn water<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>]) -> Option<[Expr<'g>; 3]> {
        Some([theta[0], theta[1], at.graph.zero()])
    }
}
