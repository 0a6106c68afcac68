//! A run: the logs of all sensors in one experiment, each at its own time stamps.
//!
//! A [`Signal`] contains the samples (tₖ, xₖ) of one logged quantity in SI units, with its own time
//! stamps, so that sensors of different rates are stored together without resampling.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::frame::Dof;

/// Greatest difference of time stamps near `t` that count as the same instant, s: nanoseconds that
/// a printed stamp loses, and the rounding of the number itself, which matters for clocks that
/// count from 1970.
pub fn rounding(t: f64) -> f64 {
    1e-9 + 4.0 * f64::EPSILON * t.abs()
}

/// Number of the thruster whose command (`letter` V) or force (F) a channel is: 3 for `V3`.
pub fn thruster_of(channel: &str, letter: &str) -> Option<usize> {
    let number = channel.strip_prefix(letter).filter(|n| n.bytes().all(|b| b.is_ascii_digit()))?;
    number.parse().ok()
}

/// Returns the channel of the command of the thruster with this index, which counts from 0.
pub fn thruster_command(index: usize) -> String {
    format!("V{}", index + 1)
}

/// Returns the channel of the nominal force of the thruster with this index, which counts from 0.
pub fn thruster_force(index: usize) -> String {
    format!("F{}", index + 1)
}

/// Angles of fins and speed of a propeller: commands other than forces and thrusters.
const DEFLECTIONS: [&str; 3] = ["rudder", "stern_plane", "propeller_n"];

/// Whether a channel is the angle of a fin or the speed of a propeller, which a log may command or
/// measure.
pub fn is_deflection(channel: &str) -> bool {
    DEFLECTIONS.contains(&channel)
}

/// Whether a channel is a command: a force `tau_u`, a command `V3`, a thruster's force `F3`,
/// `acting_F3`, the angle of a fin or the speed of a propeller. Between samples it is interpolated
/// like commands: held or linear.
pub fn is_command(channel: &str) -> bool {
    if is_deflection(channel) {
        return true;
    }
    let own = channel.strip_prefix("acting_").unwrap_or(channel);
    channel.starts_with("tau_") || ["V", "F"].into_iter().any(|letter| thruster_of(own, letter).is_some())
}

/// Greatest magnitude of a channel over runs; 0 if no run has it.
pub fn greatest(runs: &[Run], channel: &str) -> f64 {
    let values = runs.iter().filter_map(|run| run.signal(channel)).flat_map(|s| s.values());
    values.fold(0.0, |most: f64, x| most.max(x.abs()))
}

/// Ratio to the largest command below which a command is rounding of the thrust allocation, N or
/// N·m over the same.
const ROUNDING: f64 = 1e-9;

/// Forces and moments below this value are rounding of the allocation to thrusters, N or N·m.
pub fn rounding_of_commands(runs: &[Run]) -> f64 {
    rounding_of(Dof::ALL.into_iter().map(|dof| greatest(runs, dof.force())))
}

/// The same, given the greatest magnitude in each degree of freedom.
pub fn rounding_of(greatest: impl Iterator<Item = f64>) -> f64 {
    ROUNDING * greatest.fold(0.0, f64::max)
}

/// Whether a force or moment beyond rounding is commanded in a degree of freedom.
pub fn is_commanded(runs: &[Run], dof: Dof) -> bool {
    greatest(runs, dof.force()) > rounding_of_commands(runs)
}

/// Root mean square of the commanded force or moment in a degree of freedom, over the samples of
/// all runs, N or N·m; `None` if none is commanded.
pub fn commanded_rms(runs: &[Run], dof: Dof) -> Option<f64> {
    let values = runs.iter().filter_map(|run| run.signal(dof.force())).flat_map(|s| s.values());
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    is_commanded(runs, dof).then(|| f64::sqrt(sum / count))
}

/// Time stamp, s, beyond which a stamp is that of a wall clock and not the time since the start of a
/// log: three years.
pub const WALL_CLOCK: f64 = 1e8;

/// Kind of experiment of a run. The staged procedure uses each kind for the parameters that it
/// determines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunKind {
    /// Vehicle held still, thrust measured by load cells.
    Bollard,
    /// Vehicle towed at constant speed, drag measured by load cells.
    Towing,
    /// Constant command until the speed is steady.
    ConstantVelocity,
    /// Sinusoidal command about an offset.
    Oscillatory,
    /// Turning moment that changes sign when the heading reaches a bound.
    Zigzag,
    /// One thruster on a bench: its command and its force over time.
    Bench,
    /// Any other.
    #[default]
    Free,
}

impl RunKind {
    /// Name as in a campaign: `constant_velocity`.
    pub const fn name(self) -> &'static str {
        match self {
            RunKind::Bollard => "bollard",
            RunKind::Towing => "towing",
            RunKind::ConstantVelocity => "constant_velocity",
            RunKind::Oscillatory => "oscillatory",
            RunKind::Zigzag => "zigzag",
            RunKind::Bench => "bench",
            RunKind::Free => "free",
        }
    }
}

/// Role of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Takes part in the fit.
    #[default]
    Train,
    /// Takes no part in the fit; the model is validated on it.
    Validate,
}

/// The samples of one sensor channel, SI units. Time stamps are finite and strictly increasing;
/// values are finite.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    time: Arc<[f64]>,
    values: Arc<[f64]>,
}

impl Signal {
    /// A signal from time stamps (s) and values of equal length; several signals may share one `time`.
    ///
    /// # Panics
    /// If the lengths differ: that is a defect of the caller, never of data.
    pub fn new(time: Arc<[f64]>, values: impl Into<Arc<[f64]>>) -> Signal {
        let values = values.into();
        assert_eq!(time.len(), values.len(), "a signal has one value a time stamp");
        Signal { time, values }
    }

    /// Whether its values are not all the same.
    pub fn varies(&self) -> bool {
        self.values.windows(2).any(|w| w[0].to_bits() != w[1].to_bits())
    }

    /// Standard deviation of white noise on a slow signal: median second difference over 0.6745 √6.
    pub fn white_noise(&self) -> f64 {
        let mut bends: Vec<f64> = self.values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
        let middle = bends.len() / 2;
        if bends.is_empty() {
            return 0.0;
        }
        *bends.select_nth_unstable_by(middle, f64::total_cmp).1 / (0.6745 * 6.0_f64.sqrt())
    }

    /// Time stamps, s.
    pub fn time(&self) -> &[f64] {
        &self.time
    }

    /// The time stamps as a shared slice: signals of one sensor share it.
    pub fn shared_time(&self) -> &Arc<[f64]> {
        &self.time
    }

    /// Values, SI.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Linear interpolation between samples, constant outside them; 0 for a signal without samples.
    pub fn at(&self, t: f64) -> f64 {
        let (time, x) = (self.time(), self.values());
        match time.partition_point(|s| *s <= t) {
            0 => x.first().copied().unwrap_or(0.0),
            k if k == x.len() => x[k - 1],
            k => x[k - 1] + (x[k] - x[k - 1]) * (t - time[k - 1]) / (time[k] - time[k - 1]),
        }
    }
}

/// One run: named signals, kind and role.
#[derive(Debug, Clone, Default)]
pub struct Run {
    /// Name shown to people: the file's name in a campaign.
    pub name: String,
    /// Kind of experiment.
    pub kind: RunKind,
    /// Fit or validation.
    pub role: Role,
    /// Time stamps at which a gap of the whole log ends, s: nothing is integrated across one. A gap
    /// of a single sensor follows from its own time stamps: [`crate::log::check::time::gaps_of`].
    pub gaps: Vec<f64>,
    /// Signals by canonical name (`u`, `tau_u`, `psi`, …) or, for auxiliary channels, by their own
    /// name.
    pub signals: BTreeMap<String, Signal>,
}

/// Names of the supply voltage in a log.
const SUPPLY: [&str; 7] =
    ["supply_V", "supply_voltage", "supply", "voltage_V", "battery_V", "battery_voltage", "battery"];

impl Run {
    /// The signal with this name; `None` if the log has none.
    pub fn signal(&self, name: &str) -> Option<&Signal> {
        self.signals.get(name)
    }

    /// The command `V3` from which a thruster's force `F3` is computed, if the run has it.
    pub fn command_of(&self, force: &str) -> Option<String> {
        let command = format!("V{}", thruster_of(force, "F")?);
        self.signals.contains_key(&command).then_some(command)
    }

    /// The supply voltage, V, under any of its names in logs.
    pub fn supply_voltage(&self) -> Option<&Signal> {
        SUPPLY.iter().find_map(|name| self.signal(name)).filter(|s| !s.is_empty())
    }

    /// The part of the run from `from` to `to`, s, both included.
    pub fn between(&self, from: f64, to: f64) -> Run {
        let cut = |signal: &Signal| {
            let (a, b) = (signal.time.partition_point(|t| *t < from), signal.time.partition_point(|t| *t <= to));
            Signal::new(signal.time[a..b].into(), &signal.values[a..b])
        };
        let signals = self.signals.iter().map(|(name, signal)| (name.clone(), cut(signal))).collect();
        let gaps = self.gaps.iter().copied().filter(|g| *g > from && *g <= to).collect();
        Run { signals, gaps, ..self.clone() }
    }

    /// Time stamp at which the time of the run is 0, s: the first one for stamps of a wall clock,
    /// otherwise 0, as in the log. With seconds since 1970 a phase 2πt/T would have no accuracy.
    pub fn origin(&self) -> f64 {
        self.span().map_or(0.0, |(first, _)| if first.abs() < WALL_CLOCK { 0.0 } else { first })
    }

    /// First and last time stamp over all signals, s; `None` for a run without samples.
    pub fn span(&self) -> Option<(f64, f64)> {
        let ends = self.signals.values().filter_map(|s| Some((*s.time().first()?, *s.time().last()?)));
        ends.reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_commanded_is_told_from_what_is_measured() {
        for command in ["tau_u", "V3", "F12", "acting_F3", "rudder", "stern_plane", "propeller_n"] {
            assert!(is_command(command), "{command}");
        }
        for other in ["u", "psi", "V", "Vx", "F", "supply_V", "wind_speed"] {
            assert!(!is_command(other), "{other}");
        }
    }

    #[test]
    fn span_covers_sensors_of_different_rates() {
        let mut run = Run::default();
        assert_eq!(run.span(), None);
        run.signals.insert("u".into(), Signal::new(vec![0.3, 0.6].into(), vec![1.0, 2.0]));
        run.signals.insert("r".into(), Signal::new(vec![0.1, 0.2, 0.5].into(), vec![0.0; 3]));
        assert_eq!(run.span(), Some((0.1, 0.6)));
    }
}
