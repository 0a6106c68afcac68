//! A wrong scale of the yaw gyro.
//!
//! ```text
//! r_log = (1 + s) r
//! ```
//!
//! s: 1.

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// A yaw rate that is too large or too small by a factor.
#[derive(Debug)]
pub struct SensorGyroScale;

impl Effect for SensorGyroScale {
    fn about(&self) -> About<'_> {
        About {
            id: "sensor_gyro_scale",
            family: Family::Sensor,
            scope: Scope::Vehicle(&[Dof::Yaw]),
            formula: "r_log = (1 + s) r",
            meaning: "A yaw rate that is too large or too small by a factor.",
            source: "Kinsey, Eustice and Whitcomb, IFAC MCMC (2006), underwater navigation",
            shown_by: "a compass in addition to the gyro, and turns",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear("s_gyro", Dimension::ONE)]
    }

    fn sense<'g>(&self, _: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], logged: &mut Logged<'g>) {
        logged.nu[5] = logged.nu[5] + theta[0] * logged.nu[5];
    }
}
