//! Even terms: a force in proportion to the square of another velocity, whatever the sign of that
//! velocity.
//!
//! ```text
//! wᵢ −= d νⱼ²        X_vv v², X_rr r², X_ww w², X_qq q²;   Z_uu u², M_uu u²
//! ```
//!
//! d in the unit that makes the product a force or moment. A ship loses speed when it drifts or
//! turns, to either side alike; the speed of a hull that differs above and below causes lift and a
//! pitching moment. Sway, roll and yaw have no such terms: a hull is the same to port and
//! starboard. Gertler and Hagen, Standard Equations of Motion for Submarine Simulation, NSRDC
//! Report 2510 (1967); Abkowitz, Lectures on Ship Hydrodynamics, HyA Report Hy-5 (1964).

use super::parameter::{drag, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;

/// Places of the even terms of a hull that is the same to port and starboard.
const PLACES: [(Dof, Dof); 6] = [
    (Dof::Surge, Dof::Sway),
    (Dof::Surge, Dof::Yaw),
    (Dof::Surge, Dof::Heave),
    (Dof::Surge, Dof::Pitch),
    (Dof::Heave, Dof::Surge),
    (Dof::Pitch, Dof::Surge),
];

/// A force in proportion to the square of another velocity that does not change its sign with it.
#[derive(Debug)]
pub struct EvenDrag;

impl Effect for EvenDrag {
    fn about(&self) -> About<'_> {
        About {
            id: "even_drag",
            family: Family::Body,
            scope: Scope::Couples(&PLACES),
            formula: "−d νⱼ²",
            meaning: "A force proportional to the square of another velocity, which does not change sign with it.",
            source: "Gertler and Hagen, Standard Equations of Motion for Submarine Simulation, NSRDC Report 2510 (1967)",
            shown_by: "fast motion in the other direction, to both sides",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let (i, j) = (place.here(), place.there());
        let other = j.velocity();
        vec![drag(i, &format!("{other}{other}"), velocity(j).power(2))]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let (i, j) = (place.here().index(), place.there().index());
        let other = at.nu_r[j];
        wrench[i] -= theta[0] * other * other;
    }
}
