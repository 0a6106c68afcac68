//! Lift of a rudder or a pair of stern planes, by the angle of the flow at the fin.
//!
//! ```text
//! rudder       Y = −k |u| (u δ + v + x r),      N =  x Y
//! stern plane  Z = −k |u| (u δ + w − x q),      M = −x Z          k = ½ ρ A C_Lα
//! ```
//!
//! δ: angle of the fin, rad, positive where it turns the vehicle to starboard (rudder) or its nose
//! down (stern plane); x: position of the fin ahead of the origin, m, negative at the stern; A:
//! area, m²; C_Lα: slope of its lift, 1/rad. (v + x r)/u is the angle at which the water meets the
//! fin. Prestero, *Verification of a Six-Degree of Freedom Simulation Model for the REMUS
//! Autonomous Underwater Vehicle*, MIT (2001), ch. 4.6; Fossen (2021), ch. 9.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Upper limit of the distance of a fin from the origin, m: the longest ships have 460 m.
const FARTHEST: f64 = 500.0;

/// A fin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fin {
    /// An upright fin.
    Rudder,
    /// A flat fin.
    SternPlane,
}

impl Fin {
    /// Channel of its angle, rad.
    pub const fn channel(self) -> &'static str {
        match self {
            Fin::Rudder => "rudder",
            Fin::SternPlane => "stern_plane",
        }
    }

    /// Degrees of freedom in which it turns and pushes the vehicle.
    pub const fn moves(self) -> [Dof; 2] {
        match self {
            Fin::Rudder => [Dof::Yaw, Dof::Sway],
            Fin::SternPlane => [Dof::Pitch, Dof::Heave],
        }
    }
}

/// The lift of a fin, and the moment that it makes.
#[derive(Debug)]
pub struct FinLift(pub Fin);

impl Effect for FinLift {
    fn about(&self) -> About<'_> {
        let (id, formula, scope): (_, _, &[Dof]) = match self.0 {
            Fin::Rudder => ("rudder_force", "Y −= k |u| (u δ + v + x r),   N = x Y", &[Dof::Yaw]),
            Fin::SternPlane => ("stern_plane_force", "Z −= k |u| (u δ + w − x q),   M = −x Z", &[Dof::Pitch]),
        };
        About {
            id,
            family: Family::Actuator,
            scope: Scope::Vehicle(scope),
            formula,
            meaning: "Lift of a fin by its angle of attack.",
            source: "Prestero, MIT (2001), ch. 4.6; Fossen, Handbook of Marine Craft (2021), ch. 9",
            shown_by: "a log of the fin's angle (rad) that varies at speed",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        let name = self.0.channel();
        vec![
            // a fin at δ = 0 is a drag against v + x r
            ParameterSpec::linear(format!("k_{name}"), Dimension::new(1, -1, 0)).at_least(0.0),
            // at the stern
            ParameterSpec::shape(format!("x_{name}"), Dimension::LENGTH, &[-0.5], -FARTHEST, FARTHEST).by_length(),
        ]
    }

    fn channels(&self, _: Place) -> Vec<String> {
        vec![self.0.channel().into()]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let (delta, u, x) = (at.channel(self.0.channel()), at.nu_r[0], theta[1]);
        let [turn, across] = self.0.moves().map(Dof::index);
        let arm = if self.0 == Fin::Rudder { x } else { -x };
        let lift = -(theta[0] * u.abs() * (u * delta + at.nu_r[across] + arm * at.nu_r[turn]));
        wrench[across] += lift;
        wrench[turn] += arm * lift;
    }
}
