//! Log of a run, and its CSV file: one row for each time stamp, empty cells where a sensor has no new sample.

use std::fmt::Write;

use crate::plant::State;

/// A logged channel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Signal {
    /// Name of the column.
    pub name: String,
    /// Time stamps, s.
    pub time: Vec<f64>,
    /// Values, SI.
    pub values: Vec<f64>,
}

/// The log of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// File name.
    pub name: String,
    /// Kind of the run: `oscillatory`, `zigzag`, `constant_velocity`, `free` or `bollard`.
    pub kind: &'static str,
    /// Whether it is a validation run, which takes no part in a fit.
    pub validates: bool,
    /// Channels.
    pub signals: Vec<Signal>,
    /// The true states at the instants of the commands.
    pub truth: Vec<(f64, State)>,
}

/// Time stamps that differ by less than this are one row, s.
const SAME: f64 = 1e-7;

/// Unit of a column.
pub fn unit(name: &str) -> &'static str {
    match name {
        "x" | "y" | "z" => "m",
        "phi" | "theta" | "psi" => "rad",
        "u" | "v" | "w" => "m/s",
        "p" | "q" | "r" => "rad/s",
        "tau_u" | "tau_v" | "tau_w" | "load_u" | "load_v" | "load_w" => "N",
        "tau_p" | "tau_q" | "tau_r" | "load_p" | "load_q" | "load_r" => "N*m",
        _ => "V",
    }
}

impl Log {
    /// The channel of this name.
    pub fn signal(&self, name: &str) -> Option<&Signal> {
        self.signals.iter().find(|s| s.name == name)
    }

    /// Whether every channel has a sample in every row.
    pub fn is_full(&self) -> bool {
        let rows = self.stamps().len();
        self.signals.iter().all(|s| s.time.len() == rows)
    }

    /// The time stamps of all channels, each once.
    fn stamps(&self) -> Vec<f64> {
        let mut all: Vec<f64> = self.signals.iter().flat_map(|s| s.time.iter().copied()).collect();
        all.sort_unstable_by(f64::total_cmp);
        all.dedup_by(|b, a| *b - *a < SAME);
        all
    }

    /// The log as CSV. `command_unit` is the unit of the thrusters' commands: `V` or `1`.
    pub fn csv(&self, command_unit: &str) -> String {
        let mut text = String::from("t [s]");
        for signal in &self.signals {
            let command = signal.name.starts_with('V');
            let _ = write!(text, ",{} [{}]", signal.name, if command { command_unit } else { unit(&signal.name) });
        }
        text.push('\n');
        let mut next = vec![0; self.signals.len()];
        for t in self.stamps() {
            let _ = write!(text, "{t}");
            for (signal, k) in self.signals.iter().zip(&mut next) {
                text.push(',');
                if signal.time.get(*k).is_some_and(|stamp| stamp - t < SAME) {
                    let _ = write!(text, "{}", signal.values[*k]);
                    *k += 1;
                }
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_merged_and_gaps_are_empty() {
        let signal = |name: &str, time: &[f64], values: &[f64]| Signal {
            name: name.to_string(),
            time: time.to_vec(),
            values: values.to_vec(),
        };
        let log = Log {
            name: "a.csv".to_string(),
            kind: "free",
            validates: false,
            signals: vec![
                signal("u", &[0.0, 0.1, 0.2], &[1.0, 2.0, 3.0]),
                signal("V1", &[0.0, 0.2 + 1e-12], &[0.5, -0.5]),
            ],
            truth: Vec::new(),
        };
        assert_eq!(log.csv("1"), "t [s],u [m/s],V1 [1]\n0,1,0.5\n0.1,2,\n0.2,3,-0.5\n");
        assert!(!log.is_full());
    }
}
