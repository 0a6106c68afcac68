//! A wrong scale of the DVL.
//!
//! ```text
//! (u, v, w)_log = (1 + s) (u, v, w)
//! ```
//!
//! s: 1. Cause: a wrong speed of sound.

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Velocity that is too large or too small by a factor.
#[derive(Debug)]
pub struct SensorDvlScale;

impl Effect for SensorDvlScale {
    fn about(&self) -> About<'_> {
        About {
            id: "sensor_dvl_scale",
            family: Family::Sensor,
            scope: Scope::Vehicle(&[Dof::Surge]),
            formula: "(u, v, w)_log = (1 + s) (u, v, w)",
            meaning: "Velocity that is too large or too small by a factor.",
            source: "Kinsey, Eustice and Whitcomb, IFAC MCMC (2006), underwater navigation",
            shown_by: "a position that is independent of the DVL",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear("s_dvl", Dimension::ONE)]
    }

    fn sense<'g>(&self, _: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], logged: &mut Logged<'g>) {
        for v in &mut logged.nu[..3] {
            *v = *v + theta[0] * *v;
        }
    }
}
