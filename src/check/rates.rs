//! Rates: how often each channel has a new value.
//!
//! ```text
//! rate = 1/mean(tₖ₊₁ − tₖ)/ρ        mean of the steps up to five times the median
//!                                   ρ rows for which a value is held, see `log::check::hold`
//! ```

use serde::Serialize;

use super::codes;
use super::report::Found;
use crate::log::check::time::{gaps, usual_step};
use crate::log::check::{hold, is_measured};
use crate::log::number::short;
use crate::run::{Run, Signal, is_command, thruster_of};

/// Rate of new values of a channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelRate {
    /// Channel.
    pub channel: String,
    /// True samples per second, Hz.
    pub rate_hz: f64,
    /// Rows per second, Hz.
    pub logged_hz: f64,
    /// Number of rows.
    pub samples: usize,
    /// Number of gaps: steps of more than five times the usual one and of more than 0.2 s.
    pub gaps: usize,
    /// Mean number of rows for which a value is held; 1 if each row is a sample.
    pub held: f64,
    /// Spread of the steps: (95th − 5th percentile)/median.
    pub jitter: f64,
}

/// Returns the rates of all channels.
pub fn measure(run: &Run) -> Vec<ChannelRate> {
    run.signals.iter().filter_map(|(name, signal)| rate(name, signal)).collect()
}

fn rate(name: &str, signal: &Signal) -> Option<ChannelRate> {
    let time = signal.time();
    let step = usual_step(time).filter(|s| *s > 0.0)?;
    // a command is held by its nature
    let held = if is_command(name) { 1.0 } else { hold::of(signal.values()).map_or(1.0, |h| h.rows) };
    let gaps = gaps(time);
    let mean = {
        let steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).filter(|s| *s <= 5.0 * step).collect();
        steps.iter().sum::<f64>() / steps.len().max(1) as f64
    };
    let quantile = |p| crate::log::check::statistics::quantile(time.windows(2).map(|w| w[1] - w[0]), p);
    let jitter = (quantile(0.95)? - quantile(0.05)?) / step;
    let logged_hz = 1.0 / mean;
    let (channel, samples) = (name.to_string(), signal.len());
    Some(ChannelRate { channel, rate_hz: logged_hz / held, logged_hz, samples, gaps: gaps.len(), held, jitter })
}

/// Returns the number of the thruster that a channel `V3` or `F3` belongs to.
pub fn number_of(name: &str) -> Option<usize> {
    ["V", "F"].into_iter().find_map(|letter| thruster_of(name, letter))
}

/// Finds held channels; those of one rate are one finding.
pub fn judge(rates: &[ChannelRate]) -> Vec<Found> {
    let mut held: Vec<&ChannelRate> = rates.iter().filter(|r| r.held > 1.0 && !is_auxiliary(&r.channel)).collect();
    let mut found = Vec::new();
    while let Some(first) = held.first().copied() {
        let (same, rest): (Vec<_>, Vec<_>) =
            held.into_iter().partition(|r| (r.rate_hz / first.rate_hz - 1.0).abs() < 0.05);
        let names: Vec<&str> = same.iter().map(|r| r.channel.as_str()).collect();
        let text = format!(
            "{} change {} times a second in a log of {} rows a second: a slower sensor, each value repeated for {} \
             rows on average; only the first of them is a measurement: repeated = \"no_sample\" keeps that one only",
            names.join(", "),
            short(first.rate_hz, 3),
            short(first.logged_hz, 3),
            short(first.held, 3)
        );
        found.push(Found::new(&codes::HELD, &names, text));
        held = rest;
    }
    found
}

/// Whether no fit reads the channel unless an effect asks for it: its rate is in the table only.
fn is_auxiliary(name: &str) -> bool {
    !is_measured(name) && !is_command(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_true_rate_of_a_held_channel_is_found() {
        let time: std::sync::Arc<[f64]> = (0..500).map(|k| 0.11 * f64::from(k)).collect();
        let mut run = Run::default();
        let five: Vec<f64> = time.iter().map(|t| (t * 5.0).floor().sin()).collect();
        let all: Vec<f64> = time.iter().map(|t| t.sin()).collect();
        run.signals.insert("u".into(), Signal::new(time.clone(), five.clone()));
        run.signals.insert("tau_u".into(), Signal::new(time.clone(), five));
        run.signals.insert("r".into(), Signal::new(time.clone(), all));
        let rates = measure(&run);
        let u = rates.iter().find(|r| r.channel == "u").unwrap();
        // 55 s of samples at 5 Hz: one sample more or less at the ends
        assert!((u.rate_hz - 5.0).abs() < 0.1 && (u.logged_hz - 9.09).abs() < 0.01, "{u:?}");
        let found = judge(&rates);
        assert_eq!((found.len(), &found[0].channels[..]), (1, &["u".to_string()][..]));
    }
}
