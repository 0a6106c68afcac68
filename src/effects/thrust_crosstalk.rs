//! A command in one direction that pushes in another.
//!
//! ```text
//! τᵢ += k τⱼ
//! ```
//!
//! k: 1, m or 1/m. Cause: thrusters whose places or directions differ from those of the allocation.

use super::parameter::force;
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::symbolic::Expr;

/// A force in proportion to the command in another direction.
#[derive(Debug)]
pub struct ThrustCrosstalk;

impl Effect for ThrustCrosstalk {
    fn about(&self) -> About<'_> {
        About {
            id: "thrust_crosstalk",
            family: Family::Actuator,
            scope: Scope::Pairs,
            formula: "τᵢ += k τⱼ",
            meaning: "A force proportional to the command in another direction.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 11",
            shown_by: "commands in the other direction",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let (i, j) = (place.here(), place.there());
        vec![ParameterSpec::linear(format!("k_{}{}", i.velocity(), j.velocity()), force(i).over(force(j)))]
    }

    fn actuate<'g>(&self, _: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], tau: &mut Six<'g>) {
        let (i, j) = (place.here().index(), place.there().index());
        tau[i] += theta[0] * tau[j];
    }
}
