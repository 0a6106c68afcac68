//! Drag of a rudder or a pair of stern planes at an angle to the flow.
//!
//! ```text
//! X = −k u |u| δ²          k = ½ ρ A C_D
//! ```
//!
//! δ: angle of the fin, rad. Fossen (2021), ch. 9: the part of the lift that points astern.

use super::fin_lift::Fin;
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// The drag that a fin adds when it is turned.
#[derive(Debug)]
pub struct FinDrag(pub Fin);

impl Effect for FinDrag {
    fn about(&self) -> About<'_> {
        About {
            id: match self.0 {
                Fin::Rudder => "rudder_drag",
                Fin::SternPlane => "stern_plane_drag",
            },
            family: Family::Actuator,
            scope: Scope::Vehicle(&[Dof::Surge]),
            formula: "X −= k u |u| δ²",
            meaning: "Drag that a fin adds when it is deflected.",
            source: "Fossen, Handbook of Marine Craft (2021), ch. 9",
            shown_by: "a log of the fin's angle (rad), large angles at speed",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear(format!("k_D_{}", self.0.channel()), Dimension::new(1, -1, 0)).at_least(0.0)]
    }

    fn channels(&self, _: Place) -> Vec<String> {
        vec![self.0.channel().into()]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let (delta, u) = (at.channel(self.0.channel()), at.nu_r[0]);
        wrench[0] -= theta[0] * u * u.abs() * delta * delta;
    }
}
