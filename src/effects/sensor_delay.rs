//! A delay of all navigation channels.
//!
//! ```text
//! x_log(t) = x(t − T)   in every navigation channel
//! ```
//!
//! T: s. A shift of all measurements against the commands is the same as a shift of the commands by
//! −T: it is written as a delay of the command, and no data can tell the two apart.

use super::{About, CommandDelay, Effect, Family, ParameterSpec, Place, Scope};
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "sensor_delay";

/// Navigation that is logged late.
#[derive(Debug)]
pub struct SensorDelay;

impl Effect for SensorDelay {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Sensor,
            scope: Scope::Everywhere,
            formula: "x_log(t) = x(t − T)",
            meaning: "Navigation that is logged late.",
            source: "Ljung, System Identification, 2nd ed. (1999), ch. 10",
            shown_by: "commands that change faster than the vehicle answers",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::shape("T_log", Dimension::TIME, &[0.1, 0.2, 0.4, 0.8, 1.6], -5.0, 10.0)]
    }

    fn delays_command(&self) -> Option<CommandDelay> {
        Some(CommandDelay::Constant(0))
    }
}
