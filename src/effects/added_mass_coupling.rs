//! Inertial coupling of two degrees of freedom.
//!
//! ```text
//! πᵢ += mᵢⱼ νⱼ        and, where j is modelled as well,   πⱼ += mᵢⱼ νᵢ
//! ```
//!
//! mᵢⱼ: element of the symmetric matrix of inertia, kg, kg·m or kg·m². The paper's X_q̇ is that of
//! surge and pitch (its sign is opposite to SNAME's): Avila et al. (2013), eq. 20.

use super::parameter::{force, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "added_mass_coupling";

/// Momentum in one direction from motion in another: added mass off the diagonal, or a centre of
/// gravity off the origin.
#[derive(Debug)]
pub struct AddedMassCoupling;

impl Effect for AddedMassCoupling {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Body,
            scope: Scope::Pairs,
            formula: "πᵢ += mᵢⱼ νⱼ",
            meaning: "Momentum in one direction from motion in another: added mass off the diagonal, or a centre of gravity off the origin.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), eq. 20",
            shown_by: "both motions accelerating, at different times",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let (i, j) = (place.here(), place.there());
        let dimension = force(i).over(velocity(j)).times(Dimension::TIME);
        let name = format!("m_{}{}", i.velocity(), j.velocity());
        vec![ParameterSpec::linear(name, dimension).sname(format!("{}_{}dot", i.sname(), j.velocity()))]
    }

    fn momentum<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], momentum: &mut Six<'g>) {
        let (i, j) = (place.here(), place.there());
        momentum[i.index()] += theta[0] * at.nu_r[j.index()];
        if at.models(j) {
            momentum[j.index()] += theta[0] * at.nu_r[i.index()];
        }
    }
}
