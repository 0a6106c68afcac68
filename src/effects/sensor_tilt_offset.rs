//! Constant errors of roll and pitch.
//!
//! ```text
//! φ_log = φ + c_φ,   θ_log = θ + c_θ
//! ```
//!
//! c: rad.

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// An inclinometer that is mounted askew.
#[derive(Debug)]
pub struct SensorTiltOffset;

impl Effect for SensorTiltOffset {
    fn about(&self) -> About<'_> {
        About {
            id: "sensor_tilt_offset",
            family: Family::Sensor,
            scope: Scope::Vehicle(&[Dof::Roll, Dof::Pitch]),
            formula: "φ_log = φ + c_φ,   θ_log = θ + c_θ",
            meaning: "An inclinometer that is mounted at an angle.",
            source: "Kinsey, Eustice and Whitcomb, IFAC MCMC (2006), underwater navigation",
            shown_by: "roll and pitch at rest, with known restoring moments",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        ["c_phi", "c_theta"].map(|name| ParameterSpec::linear(name, Dimension::ONE)).to_vec()
    }

    fn sense<'g>(&self, _: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], logged: &mut Logged<'g>) {
        logged.attitude[0] += theta[0];
        logged.attitude[1] += theta[1];
    }
}
