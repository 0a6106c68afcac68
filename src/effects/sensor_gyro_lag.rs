//! A gyro behind a low pass.
//!
//! ```text
//! T ω̇_log + ω_log = ω,    ω = (p, q, r)
//! ```
//!
//! T: s. Navigation units smooth the turn rates that they report. A DVL separates this lag from one
//! of the thrusters, which all sensors show.

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope, Six};
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Turn rates that follow with a lag.
#[derive(Debug)]
pub struct SensorGyroLag;

impl Effect for SensorGyroLag {
    fn about(&self) -> About<'_> {
        About {
            id: "sensor_gyro_lag",
            family: Family::Sensor,
            scope: Scope::MOVES_AND_TURNS,
            formula: "T d(p, q, r)_log/dt + (p, q, r)_log = (p, q, r)",
            meaning: "Turn rates that are smoothed, and therefore lag.",
            source: "Jategaonkar, Flight Vehicle System Identification, 2nd ed. (2015), ch. 2.3",
            shown_by: "turns, and a compass or a DVL without delay",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::shape("T_gyro_lag", Dimension::TIME, &[0.05, 0.1, 0.2, 0.4, 0.8], 0.02, 5.0)]
    }

    fn sense<'g>(&self, at: &Instant<'g>, _: Place, _: &[Expr<'g>], memory: &[Expr<'g>], logged: &mut Logged<'g>) {
        for (i, smoothed) in at.rotations().zip(memory) {
            logged.nu[i] += *smoothed - at.nu[i];
        }
    }

    fn memory<'g>(&self, at: &Instant<'g>, _: Place, _: &Six<'g>) -> Vec<Expr<'g>> {
        at.rotations().map(|i| at.nu[i]).collect()
    }

    fn memory_rate<'g>(
        &self,
        at: &Instant<'g>,
        _: Place,
        theta: &[Expr<'g>],
        memory: &[Expr<'g>],
        _: &Six<'g>,
    ) -> Vec<Expr<'g>> {
        at.rotations().zip(memory).map(|(i, smoothed)| (at.nu[i] - *smoothed) / theta[0]).collect()
    }
}
