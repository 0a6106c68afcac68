//! Moments of a centre of gravity off the vertical axis of the vehicle.
//!
//! ```text
//! (K, M, N) += r × W g,      r = (x, y, 0),   g = (−sin θ, cos θ sin φ, cos θ cos φ)
//! ```
//!
//! x, y: offsets, m; W: weight, N. The vertical offset is the restoring moment, an effect of its
//! own. Fossen (2021), ch. 4.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "trim_offset";

/// Moments of a centre of gravity or buoyancy off the axis.
#[derive(Debug)]
pub struct TrimOffset;

impl Effect for TrimOffset {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Body,
            scope: Scope::Vehicle(&[Dof::Roll, Dof::Pitch]),
            formula: "(K, M, N) += (x, y, 0) × W g(φ, θ)",
            meaning: "Moments of a centre of gravity or buoyancy off the axis.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 4",
            shown_by: "roll and pitch at rest",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        ["x_g", "y_g"].map(|name| ParameterSpec::linear(name, Dimension::LENGTH)).to_vec()
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let [gx, gy, gz] = at.down().map(|g| g * at.unit(Dimension::FORCE, at.weight));
        let (x, y) = (theta[0], theta[1]);
        wrench[3] += y * gz;
        wrench[4] -= x * gz;
        wrench[5] += x * gy - y * gx;
    }
}
