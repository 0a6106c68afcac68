//! A tether that pulls the vehicle back to its anchor.
//!
//! ```text
//! (X, Y, Z) −= k Rᵀ(φ, θ, ψ) (x − x_a, y − y_a, 0)
//! ```
//!
//! k: N/m; (x_a, y_a): anchor, the position at the start of the run unless given, m. The anchor
//! stands on the ground: in moving water the pull is not the same seen from the ground and from the
//! water.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six, channel};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "tether_spring";

/// A tether that pulls back to its anchor.
#[derive(Debug)]
pub struct TetherSpring;

impl Effect for TetherSpring {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Environment,
            scope: Scope::Vehicle(&[Dof::Surge]),
            formula: "(X, Y, Z) −= k Rᵀ(x − x_a, y − y_a, 0)",
            meaning: "A tether that pulls back towards its anchor.",
            source: "Buckham et al., Ocean Engineering 30 (2003), slack tethers",
            shown_by: "motion far from the anchor, and a log of the position",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear("k_tether", Dimension::FORCE.over(Dimension::LENGTH)).at_least(0.0)]
    }

    fn tied_to_ground(&self) -> bool {
        true
    }

    fn channels(&self, _: Place) -> Vec<String> {
        vec![channel::ANCHOR_NORTH.into(), channel::ANCHOR_EAST.into()]
    }

    fn pose(&self) -> &'static [&'static str] {
        &["x", "y"]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let [north, east, _] = at.position;
        let from_anchor =
            [north - at.channel(channel::ANCHOR_NORTH), east - at.channel(channel::ANCHOR_EAST), at.graph.zero()];
        for (i, x) in at.to_body(from_anchor).into_iter().enumerate() {
            wrench[i] -= theta[0] * x;
        }
    }
}
