//! Disturbance of the compass by the thrusters' currents.
//!
//! ```text
//! ψ_log = ψ + a Σ|τᵢ|
//! ```
//!
//! a: rad/N; the sum over the translational commands. Avila et al. (2013) suspect it.

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// A heading error in proportion to the thrusters' command.
#[derive(Debug)]
pub struct SensorCompassMagnetic;

impl Effect for SensorCompassMagnetic {
    fn about(&self) -> About<'_> {
        About {
            id: "sensor_compass_magnetic",
            family: Family::Sensor,
            scope: Scope::Vehicle(&[Dof::Yaw]),
            formula: "ψ_log = ψ + a Σ|τᵢ|",
            meaning: "A heading error proportional to the thrusters' command.",
            source: "Kinsey, Eustice and Whitcomb, IFAC MCMC (2006), underwater navigation",
            shown_by: "a gyro in addition to the compass, and commands that change",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear("a_mag", Dimension::ONE.over(Dimension::FORCE))]
    }

    fn sense<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], logged: &mut Logged<'g>) {
        let effort = at.command[..3].iter().fold(at.graph.zero(), |sum, tau| sum + tau.abs());
        logged.attitude[2] += theta[0] * effort;
    }
}
