//! A constant error of the heading.
//!
//! ```text
//! ψ_log = ψ + c
//! ```
//!
//! c: rad.

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// A compass that is mounted askew.
#[derive(Debug)]
pub struct SensorHeadingOffset;

impl Effect for SensorHeadingOffset {
    fn about(&self) -> About<'_> {
        About {
            id: "sensor_heading_offset",
            family: Family::Sensor,
            scope: Scope::Vehicle(&[Dof::Yaw]),
            formula: "ψ_log = ψ + c",
            meaning: "A compass that is mounted at an angle.",
            source: "Kinsey, Eustice and Whitcomb, IFAC MCMC (2006), underwater navigation",
            shown_by: "a position that is independent of the compass",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear("c_psi", Dimension::ONE)]
    }

    fn sense<'g>(&self, _: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], logged: &mut Logged<'g>) {
        logged.attitude[2] += theta[0];
    }
}
