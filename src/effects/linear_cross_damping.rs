//! Linear damping from another motion.
//!
//! ```text
//! wᵢ −= d νⱼ
//! ```
//!
//! d in the unit that makes the product a force or moment. Fossen, Handbook of Marine Craft
//! Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 6.

use super::parameter::{drag, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::symbolic::Expr;

/// A force in proportion to the velocity in another direction.
#[derive(Debug)]
pub struct LinearCrossDamping;

impl Effect for LinearCrossDamping {
    fn about(&self) -> About<'_> {
        About {
            id: "linear_cross_damping",
            family: Family::Body,
            scope: Scope::Pairs,
            formula: "−d νⱼ",
            meaning: "A force proportional to the velocity in another direction.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 6",
            shown_by: "motion in the other direction",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let (i, j) = (place.here(), place.there());
        let other = j.velocity();
        vec![drag(i, other, velocity(j))]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let (i, j) = (place.here().index(), place.there().index());
        let other = at.nu_r[j];
        wrench[i] -= theta[0] * other;
    }
}
