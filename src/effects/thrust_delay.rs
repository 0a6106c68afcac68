//! A delay of the thrust, the same in every degree of freedom.
//!
//! ```text
//! τ(t) → τ(t − T)
//! ```
//!
//! T: s. Causes: a bus, a logger, a controller's period. No data can tell it from a delay of all
//! sensors, or from an offset of the clock of the commands.

use super::{About, CommandDelay, Effect, Family, ParameterSpec, Place, Scope};
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "thrust_delay";

/// A dead time between command and thrust.
#[derive(Debug)]
pub struct ThrustDelay;

impl Effect for ThrustDelay {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Actuator,
            scope: Scope::Everywhere,
            formula: "τ(t) → τ(t − T)",
            meaning: "A dead time between command and thrust.",
            source: "Ljung, System Identification, 2nd ed. (1999), ch. 10",
            shown_by: "commands that change faster than the vehicle answers",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::shape("T_delay", Dimension::TIME, &[0.1, 0.2, 0.4, 0.8, 1.6], -5.0, 10.0)]
    }

    fn delays_command(&self) -> Option<CommandDelay> {
        Some(CommandDelay::Constant(0))
    }
}
