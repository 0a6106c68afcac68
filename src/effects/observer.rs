//! A logged signal that is a function of the states, such as the rate at which a pressure sensor falls.
//!
//! ```text
//! y = h(ν, η, τ, …, t, channels)
//! ```
//!
//! The model predicts it, and output error compares the prediction with the log, as for a velocity.

use super::Instant;
use super::instant::is_channel;
use crate::formula::Formula;
use crate::symbolic::Expr;

/// A channel of the log with the formula that predicts it.
#[derive(Debug, Clone, PartialEq)]
pub struct Observer {
    channel: String,
    formula: Formula,
}

impl Observer {
    /// The logged `channel` is `formula`, in the SI unit of the channel.
    pub fn new(channel: &str, formula: Formula) -> Observer {
        Observer { channel: channel.to_string(), formula }
    }

    /// Name of the channel.
    pub fn channel(&self) -> &str {
        &self.channel
    }

    /// The formula.
    pub fn formula(&self) -> &Formula {
        &self.formula
    }

    /// Channels of the log that the formula reads besides states, commands and time.
    pub fn channels(&self) -> Vec<String> {
        self.formula.names().into_iter().filter(|name| is_channel(name)).map(str::to_string).collect()
    }

    /// The formula of the channel's value at an instant.
    pub fn express<'g>(&self, at: &Instant<'g>) -> Expr<'g> {
        self.formula.lower(at.graph, &|name| at.named(name))
    }
}
