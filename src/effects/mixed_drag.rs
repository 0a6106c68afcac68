//! Drag that grows with the speed of another motion.
//!
//! ```text
//! wᵢ −= d |νⱼ| νᵢ
//! ```
//!
//! d in the unit that makes the product a force or moment. Abkowitz, Lectures on Ship
//! Hydrodynamics, HyA Report Hy-5 (1964).

use super::parameter::{drag, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::symbolic::Expr;

/// Id, as in a campaign file.
pub const ID: &str = "mixed_drag";

/// Drag in one direction that grows with the speed in another.
#[derive(Debug)]
pub struct MixedDrag;

impl Effect for MixedDrag {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Body,
            scope: Scope::Pairs,
            formula: "−d |νⱼ| νᵢ",
            meaning: "Drag in one direction that grows with the speed in another.",
            source: "Abkowitz, Lectures on Ship Hydrodynamics, HyA Report Hy-5 (1964)",
            shown_by: "both motions at once",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let (i, j) = (place.here(), place.there());
        let (own, other) = (i.velocity(), j.velocity());
        vec![drag(i, &format!("|{other}|{own}"), velocity(j).times(velocity(i))).at_least(0.0)]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let (i, j) = (place.here().index(), place.there().index());
        let other = at.nu_r[j];
        wrench[i] -= theta[0] * other.abs() * at.nu_r[i];
    }
}
