//! A DVL that is turned about the vertical.
//!
//! ```text
//! u_log = u cos α + v sin α,   v_log = −u sin α + v cos α
//! ```
//!
//! α: rad.

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Velocity measured in axes that are turned.
#[derive(Debug)]
pub struct SensorDvlMisalignment;

impl Effect for SensorDvlMisalignment {
    fn about(&self) -> About<'_> {
        About {
            id: "sensor_dvl_misalignment",
            family: Family::Sensor,
            scope: Scope::Vehicle(&[Dof::Surge, Dof::Sway]),
            formula: "u_log = u cos α + v sin α,   v_log = −u sin α + v cos α",
            meaning: "Velocity measured in axes that are rotated.",
            source: "Kinsey, Eustice and Whitcomb, IFAC MCMC (2006), underwater navigation",
            shown_by: "fast surge, or a position that is independent of the DVL",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::shape("alpha_dvl", Dimension::ONE, &[0.0], -1.6, 1.6)]
    }

    fn sense<'g>(&self, _: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], logged: &mut Logged<'g>) {
        let (sin, cos) = (theta[0].sin(), theta[0].cos());
        let [u, v, ..] = logged.nu;
        logged.nu[0] = u * cos + v * sin;
        logged.nu[1] = v * cos - u * sin;
    }
}
