//! A single thruster, for the effects of single thrusters.
//!
//! ```text
//! w_T = b_T F_T          b_T: wrench of 1 N of thruster T, with η_inter;
//!                        F_T: its force as commanded, with η_adv
//! ```
//!
//! Other effects of the catalogue stand in degrees of freedom. Those of single thrusters are made
//! for a vehicle whose thrusters are described, and have the thruster's name in their id:
//! `thruster_loss@T6`.

use super::{Instant, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// A thruster: its name, the channel with its force, and the wrench of one newton.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SingleThruster {
    /// Name, as the campaign calls it.
    pub name: String,
    /// Channel of its force, N.
    pub channel: String,
    /// (s, p × s): wrench of 1 N along its axis s at its place p, without losses; 1 in translation,
    /// m in rotation.
    pub unit_wrench: [f64; 6],
    /// Wrench of 1 N at the body origin: 1 in translation, m in rotation; 0 where it gives nothing.
    pub wrench: [f64; 6],
}

impl SingleThruster {
    /// Speed along its axis, through the water: s · (v + ω × p) = (s, p × s) · ν.
    pub(super) fn advance<'g>(&self, at: &Instant<'g>) -> Expr<'g> {
        let along = |dof: Dof| {
            let unit = if dof.is_rotation() { Dimension::LENGTH } else { Dimension::ONE };
            at.unit(unit, self.unit_wrench[dof.index()]) * at.nu_r[dof.index()]
        };
        Dof::ALL
            .into_iter()
            .filter(|dof| self.unit_wrench[dof.index()].abs() > 0.0)
            .map(along)
            .fold(at.graph.zero(), |a, b| a + b)
    }

    /// Adds `share` of its wrench to τ.
    pub(super) fn push<'g>(&self, at: &Instant<'g>, share: Expr<'g>, tau: &mut Six<'g>) {
        let force = at.channel(&self.channel);
        for dof in Dof::ALL {
            let (i, unit) = (dof.index(), if dof.is_rotation() { Dimension::MOMENT } else { Dimension::FORCE });
            if self.wrench[i].abs() > 0.0 {
                tau[i] += share * force * at.unit(unit, self.wrench[i]);
            }
        }
    }
}
