//! A clock of the sensors that runs at another rate than that of the commands.
//!
//! ```text
//! x_log(t) = x((1 − δ) t)   in every navigation channel
//! τ(t) → τ(t − δ t),   dx/dt → (1 − δ) dx/dt   in the time of the log
//! ```
//!
//! t counts from the beginning of the run; δ: 1, positive if the sensors' clock is fast. Two computers that are not
//! synchronised, or stamps that count samples at a rate that is not the true one. A constant difference of the two clocks
//! is a delay.

use super::{About, CommandDelay, Effect, Family, ParameterSpec, Place, Scope};
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "sensor_clock_drift";

/// Navigation that is logged with a clock of another rate.
#[derive(Debug)]
pub struct SensorClockDrift;

impl Effect for SensorClockDrift {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Sensor,
            scope: Scope::Everywhere,
            formula: "x_log(t) = x((1 − δ) t)",
            meaning: "Navigation that is logged with a clock of another rate.",
            source: "Mills, Computer Network Time Synchronization, 2nd ed. (2010), ch. 4",
            shown_by: "commands that change throughout a long run",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::shape("delta_clock", Dimension::ONE, &[1e-3, 4e-3, 1.6e-2], -0.1, 0.1)]
    }

    fn delays_command(&self) -> Option<CommandDelay> {
        Some(CommandDelay::Growing(0))
    }
}
