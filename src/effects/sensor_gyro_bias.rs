//! A bias of the yaw gyro.
//!
//! ```text
//! r_log = r + b
//! ```
//!
//! b: rad/s.

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "sensor_gyro_bias";

/// A constant error of the yaw rate.
#[derive(Debug)]
pub struct SensorGyroBias;

impl Effect for SensorGyroBias {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Sensor,
            scope: Scope::Vehicle(&[Dof::Yaw]),
            formula: "r_log = r + b",
            meaning: "A constant error of the yaw rate.",
            source: "Kinsey, Eustice and Whitcomb, IFAC MCMC (2006), underwater navigation",
            shown_by: "a compass in addition to the gyro",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear("b_gyro", Dimension::RATE)]
    }

    fn sense<'g>(&self, _: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], logged: &mut Logged<'g>) {
        logged.nu[5] += theta[0];
    }
}
