//! Moment of the hull's lift at an angle to the flow, in addition to the Munk moment.
//!
//! ```text
//! yaw  N −= k u v        pitch  M −= k u w        k = −N_uv, −M_uw beyond the rows of −C(ν)ν
//! ```
//!
//! k: kg. Fins and the tail of a hull have lift, which the ideal fluid of the Munk moment lacks: a
//! torpedo with fins is stable because of it, a blunt hull shows less than m_v − m_u. Beside a
//! Coriolis row with a coefficient of its own it is the same regressor as that coefficient. The
//! force of the same lift is a drag that grows with the speed (`mixed_drag@sway:surge`). Prestero,
//! MIT (2001), ch. 4.5; Fossen (2021), ch. 6.

use super::parameter::{force, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;

/// Each moment with the motion across the hull that causes it.
const PLACES: [(Dof, Dof); 2] = [(Dof::Pitch, Dof::Heave), (Dof::Yaw, Dof::Sway)];

/// The moment of the lift of the hull.
#[derive(Debug)]
pub struct LiftMoment;

impl Effect for LiftMoment {
    fn about(&self) -> About<'_> {
        About {
            id: "lift_moment",
            family: Family::Body,
            scope: Scope::Couples(&PLACES),
            formula: "−k u νⱼ",
            meaning: "Moment of the lift of hull and fixed fins at an angle to the flow.",
            source: "Prestero, MIT (2001), ch. 4.5; Fossen, Handbook of Marine Craft (2021), ch. 6",
            shown_by: "motion ahead and across at once, with the Coriolis terms tied to the inertias",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let (i, j) = (place.here(), place.there());
        let product = velocity(Dof::Surge).times(velocity(j));
        let spec = ParameterSpec::linear(format!("k_lift{}", i.velocity()), force(i).over(product));
        vec![spec.sname(format!("{}_u{}", i.sname(), j.velocity()))]
    }

    fn shares_row(&self, place: Place) -> Option<Dof> {
        place.dof
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let (i, j) = (place.here().index(), place.there().index());
        wrench[i] -= theta[0] * at.nu_r[0] * at.nu_r[j];
    }
}
