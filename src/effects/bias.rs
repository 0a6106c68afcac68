//! A constant force.
//!
//! ```text
//! wᵢ −= b
//! ```
//!
//! b: N (N·m), on the side of drag as in the paper (Avila et al. 2013, eq. 2): the force is −b.

use super::parameter::force;
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;

/// Id, as in a campaign file.
pub const ID: &str = "bias";

/// A constant force: trim, cable, offset of a command.
#[derive(Debug)]
pub struct Bias;

impl Effect for Bias {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Body,
            scope: Scope::Each(&Dof::ALL),
            formula: "−b",
            meaning: "A constant force: trim, cable, offset of a command.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), eq. 2",
            shown_by: "motion in both directions, which separates it from friction, at more than one attitude, which \
                       separates it from weight",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        vec![ParameterSpec::linear(format!("b_{}", dof.velocity()), force(dof))]
    }

    fn wrench<'g>(&self, _: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        wrench[place.here().index()] -= theta[0];
    }
}
