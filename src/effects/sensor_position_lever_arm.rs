//! A position that is measured elsewhere than at the origin.
//!
//! ```text
//! (x, y)_log = (x, y) + R (x_pos, y_pos, 0)
//! ```
//!
//! x_pos, y_pos: place of the antenna or the beacon in body axes, m. It swings about the origin as
//! the vehicle turns; measured velocities, or the motion that follows from the forces, show where
//! the origin is.

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// An antenna or a beacon that is not at the origin.
#[derive(Debug)]
pub struct SensorPositionLeverArm;

impl Effect for SensorPositionLeverArm {
    fn about(&self) -> About<'_> {
        About {
            id: "sensor_position_lever_arm",
            family: Family::Sensor,
            scope: Scope::VehicleAny(&[&[Dof::Surge, Dof::Yaw], &[Dof::Sway, Dof::Yaw]]),
            formula: "(x, y)_log = (x, y) + R (x_pos, y_pos, 0)",
            meaning: "Position measured elsewhere than at the origin: an antenna or a beacon with a lever arm.",
            source: "Kinsey, Eustice and Whitcomb, IFAC MCMC (2006), underwater navigation",
            shown_by: "a position that is independent of the velocities, and turns",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        ["x_pos", "y_pos"].map(|name| ParameterSpec::linear(name, Dimension::LENGTH)).to_vec()
    }

    fn pose(&self) -> &'static [&'static str] {
        &["x", "y"]
    }

    fn sense<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], logged: &mut Logged<'g>) {
        let arm = at.to_earth([theta[0], theta[1], at.graph.zero()]);
        for (position, arm) in logged.position.iter_mut().zip(arm).take(2) {
            *position += arm;
        }
    }
}
