//! Quadratic drag from another motion.
//!
//! ```text
//! wᵢ −= d νⱼ |νⱼ|
//! ```
//!
//! d in the unit that makes the product a force or moment. Fossen, Handbook of Marine Craft
//! Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 6.

use super::parameter::{drag, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::symbolic::Expr;

/// A force in proportion to the square of the velocity in another direction.
#[derive(Debug)]
pub struct CrossDrag;

impl Effect for CrossDrag {
    fn about(&self) -> About<'_> {
        About {
            id: "cross_drag",
            family: Family::Body,
            scope: Scope::Pairs,
            formula: "−d νⱼ |νⱼ|",
            meaning: "A force proportional to the square of the velocity in another direction.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 6",
            shown_by: "fast motion in the other direction",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let (i, j) = (place.here(), place.there());
        let other = j.velocity();
        vec![drag(i, &format!("{other}|{other}|"), velocity(j).power(2))]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let (i, j) = (place.here().index(), place.there().index());
        let other = at.nu_r[j];
        wrench[i] -= theta[0] * other * other.abs();
    }
}
