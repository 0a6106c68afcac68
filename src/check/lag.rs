//! The lag with the least residual of a fit: how much later one channel shows what another one shows.
//!
//! ```text
//! d̂ = argmin SSE(d),   σ_d² = 2 s² / SSE″(d̂),   s² = SSE(d̂)/(n − p),   c² = (SSE(0) − SSE(d̂))/s²
//! ```
//!
//! The minimum on a grid is refined by the parabola through it and its two neighbours. c is the
//! distance from zero lag in standard deviations, by the sums of squares: a dent in a flat cost has
//! a small σ_d, but also a small c.

use serde::Serialize;

use super::codes;
use super::report::{FaultKind, Found};
use crate::log::number::short;

/// A lag with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Lag {
    /// Lag, s; positive when the second channel is late.
    pub seconds: f64,
    /// Standard deviation, s, for white residuals.
    pub std: f64,
    /// Distance from zero lag by the sums of squares, in standard deviations.
    #[serde(skip)]
    pub certainty: f64,
}

impl Lag {
    /// Whether the lag is significant: by this many standard deviations, both σ_d and those of the
    /// sums of squares, and by more than `least` s.
    pub fn is_clear(&self, deviations: f64, least: f64) -> bool {
        self.certainty > deviations && self.seconds.abs() > (deviations * self.std).max(least)
    }
}

/// Longest lag that is searched, s.
pub const REACH: f64 = 1.5;

/// Returns the lag between −[`REACH`] and [`REACH`] with the least cost, on a grid of `step` s;
/// `cost` gives the sum of squares and the remaining degrees of freedom. `None` if the minimum lies
/// at an end: then no lag was found.
pub fn least(step: f64, cost: impl Fn(f64) -> Option<(f64, usize)>) -> Option<Lag> {
    let half = (REACH / step).floor() as i32;
    let costs: Vec<(f64, usize)> = (-half..=half).map(|k| cost(f64::from(k) * step)).collect::<Option<_>>()?;
    let best = (0..costs.len()).min_by(|a, b| costs[*a].0.total_cmp(&costs[*b].0))?;
    let (before, after) = (costs.get(best.checked_sub(1)?)?.0, costs.get(best + 1)?.0);
    let (least, free) = costs[best];
    let bend = before - 2.0 * least + after;
    if bend <= 0.0 {
        return None;
    }
    let shift = (0.5 * (before - after) / bend).clamp(-0.5, 0.5);
    let at = (best as f64 - f64::from(half) + shift) * step;
    let lowest = least - 0.125 * (before - after).powi(2) / bend;
    // a parabola through costs that bend more than one may go below zero
    let lowest = if lowest > 0.0 { lowest } else { least };
    let variance = 2.0 * lowest.max(0.0) / free.max(1) as f64 / (bend / (step * step));
    let none = costs[half as usize].0;
    let certainty = ((none - lowest).max(0.0) * free.max(1) as f64 / lowest.max(f64::MIN_POSITIVE)).sqrt();
    Some(Lag { seconds: at, std: variance.sqrt(), certainty })
}

/// Returns the finding that the second of two channels comes later than the first, or earlier, by more than `least` s;
/// `channels` are those of the finding.
pub fn latency(lag: Option<Lag>, [first, second]: [&str; 2], least: f64, channels: &[&str]) -> Option<Found> {
    let lag = lag.filter(|lag| lag.is_clear(5.0, least))?;
    let (late, early) = if lag.seconds > 0.0 { (second, first) } else { (first, second) };
    let seconds = lag.seconds.abs();
    let text = format!(
        "{late} lags {early} by {} ± {} s: latency of its sensor or its time stamps",
        short(seconds, 3),
        short(2.0 * lag.std, 2)
    );
    Some(Found::new(&codes::LATENCY, channels, text).fault(FaultKind::Delay, late, seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_parabola_has_its_minimum_found_between_the_points() {
        let lag = least(0.1, |d| Some((2.0 + 8.0 * (d - 0.234).powi(2), 100))).unwrap();
        assert!((lag.seconds - 0.234).abs() < 1e-9);
        // σ² = 2 · 0.02 / 16
        assert!((lag.std - 0.05).abs() < 1e-9, "{}", lag.std);
        // 8 · 0.234² over s² = 0.02
        assert!((lag.certainty - (8.0 * 0.234_f64.powi(2) / 0.02).sqrt()).abs() < 1e-6, "{}", lag.certainty);
        assert_eq!(least(0.1, |d| Some((d, 100))), None);
    }

    #[test]
    fn a_dent_in_a_flat_cost_is_no_lag() {
        let lag = least(0.1, |d| Some((2.0 - 0.02 * f64::from((d - 1.0).abs() < 0.05), 100))).unwrap();
        assert!(lag.seconds / lag.std > 5.0 && lag.certainty < 1.1, "{lag:?}");
    }
}
