//! Plausibility checks of a log: one small check per file, each a pure function of signals.
//!
//! A check only reports: nothing is changed, dropped or rescaled.

pub mod far;
pub mod hold;
pub mod plausible;
pub mod repeat;
pub mod sign;
pub mod statistics;
pub mod time;
pub mod time_unit;
pub mod turning;

use std::collections::BTreeMap;

use super::codes;
use crate::finding::Code;
use crate::frame::Dof;
use crate::run::Signal;

/// Result of a check.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Its code.
    pub code: Code,
    /// The channels concerned.
    pub channels: Vec<String>,
    /// Time stamp of the first sample concerned, s; `None` if the whole channel is concerned.
    pub time: Option<f64>,
    /// Description in one sentence, without the place.
    pub text: String,
}

impl Seen {
    fn new(code: Code, channels: &[&str], time: Option<f64>, text: String) -> Seen {
        Seen { code, channels: channels.iter().map(|c| (*c).to_string()).collect(), time, text }
    }
}

/// Whether the channel is a measured state or a load cell, not a command.
pub fn is_measured(name: &str) -> bool {
    Dof::ALL.iter().any(|d| [d.velocity(), d.position(), d.load()].contains(&name))
}

/// Whether the channel is a measured velocity or rate.
pub fn is_velocity(name: &str) -> bool {
    Dof::ALL.iter().any(|d| d.velocity() == name)
}

/// Runs all checks. `time` holds the stamps of the rows, s; `units` the units of the signals, where known.
pub fn all(time: &[f64], signals: &BTreeMap<String, Signal>, units: &BTreeMap<String, &'static str>) -> Vec<Seen> {
    let mut seen = time::check(time, signals);
    if seen.iter().all(|s| s.code != codes::TIME_UNIT) {
        seen.extend(time_unit::check(time, signals));
    }
    seen.extend(time::check_sensors(time, signals));
    let said = |s: &Seen| s.channels.iter().all(|c| units.get(c) == Some(&"us"));
    seen.extend(plausible::check(signals).into_iter().filter(|s| !said(s)));
    for (name, signal) in signals {
        seen.extend(far::check(name, signal));
    }
    // a sentinel above the plausible limit is reported once
    let codes: Vec<Seen> = seen.iter().filter(|s| s.code == codes::SENTINEL).cloned().collect();
    seen.retain(|s| {
        s.code != codes::MAGNITUDE || !codes.iter().any(|c| (&c.channels, c.time) == (&s.channels, s.time))
    });
    seen.extend(repeat::check(signals));
    // a fit of data already known to be wrong says nothing about signs
    if seen.iter().all(|s| [codes::GAP, codes::UNEVEN_COMMAND].contains(&s.code)) {
        seen.extend(sign::check(signals));
    }
    seen
}
