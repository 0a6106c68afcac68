//! Deviation of the compass, a function of the heading.
//!
//! ```text
//! ψ_log = ψ + a cos ψ + b sin ψ + c
//! ```
//!
//! a, b, c: rad. Cause: hard iron on board.

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// A heading error that depends on the heading.
#[derive(Debug)]
pub struct SensorCompassDeviation;

impl Effect for SensorCompassDeviation {
    fn about(&self) -> About<'_> {
        About {
            id: "sensor_compass_deviation",
            family: Family::Sensor,
            scope: Scope::Vehicle(&[Dof::Yaw]),
            formula: "ψ_log = ψ + a cos ψ + b sin ψ + c",
            meaning: "A heading error that depends on the heading.",
            source: "Bowditch, American Practical Navigator, ch. 6",
            shown_by: "a gyro in addition to the compass, and turns through all headings",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        ["a_dev", "b_dev", "c_dev"].map(|name| ParameterSpec::linear(name, Dimension::ONE)).to_vec()
    }

    fn sense<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], logged: &mut Logged<'g>) {
        let psi = at.attitude[2];
        logged.attitude[2] += theta[0] * psi.cos() + theta[1] * psi.sin() + theta[2];
    }
}
