//! A DVL that is not at the origin.
//!
//! ```text
//! (u, v)_log = (u − r y, v + r x)
//! ```
//!
//! x, y: position of the DVL, m.

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Velocity measured elsewhere than at the origin.
#[derive(Debug)]
pub struct SensorDvlLeverArm;

impl Effect for SensorDvlLeverArm {
    fn about(&self) -> About<'_> {
        About {
            id: "sensor_dvl_lever_arm",
            family: Family::Sensor,
            scope: Scope::Vehicle(&[Dof::Surge, Dof::Sway, Dof::Yaw]),
            formula: "(u, v)_log = (u − r y, v + r x)",
            meaning: "Velocity measured elsewhere than at the origin.",
            source: "Kinsey, Eustice and Whitcomb, IFAC MCMC (2006), underwater navigation",
            shown_by: "turns",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        ["x_dvl", "y_dvl"].map(|name| ParameterSpec::linear(name, Dimension::LENGTH)).to_vec()
    }

    fn sense<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], logged: &mut Logged<'g>) {
        let r = at.nu[5];
        logged.nu[0] -= r * theta[1];
        logged.nu[1] += r * theta[0];
    }
}
