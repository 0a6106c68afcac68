//! Steady stretches of a log: where a velocity neither drifts nor fluctuates.
//!
//! A window is steady if the straight line through it has a small slope and the scatter about that
//! line is small. White noise of the sensor, estimated from the second differences of the samples,
//! does not count as unsteadiness. The standard deviation of the mean of a window is
//!
//! ```text
//! σ_mean² = (σ²/n) [1 + 2 Σₗ (1 − l/n) ρₗ]          ρₗ: correlation of samples l apart, until it has decayed
//! ```
//!
//! so that correlated samples count for less: Box, Jenkins and Reinsel, *Time Series Analysis*,
//! section 2.1.5.

use serde::{Deserialize, Serialize};

use crate::log::check::time::gaps_of;
use crate::run::{Run, Signal, rounding};

/// Limits within which a stretch counts as steady.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SteadyOptions {
    /// Greatest change of the straight line over a window, as a part of the greatest speed of the run.
    pub drift: f64,
    /// Greatest scatter about the line (one standard deviation), as a part of the greatest speed of the run.
    pub scatter: f64,
    /// Least length of a window, s.
    pub length: f64,
}

impl Default for SteadyOptions {
    /// The paper's record of Fig. 7 is steady with 0.748 ± 0.045 m/s over 18 s: 6 % of scatter.
    fn default() -> SteadyOptions {
        SteadyOptions { drift: 0.04, scatter: 0.08, length: 6.0 }
    }
}

/// A steady stretch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SteadyWindow {
    /// Begin, s.
    pub from: f64,
    /// End, s.
    pub to: f64,
}

/// A mean and its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// Mean of the samples.
    pub value: f64,
    /// Standard deviation of the mean, with correlation of the samples taken into account.
    pub std: f64,
    /// Standard deviation of the samples.
    pub scatter: f64,
    /// Number of samples.
    pub samples: usize,
}

/// Steady windows of the velocity `channel` of a run, each extended from its beginning while it
/// stays steady; with `force`, the commanded force must be steady as well. Windows do not overlap,
/// and none spans a gap.
pub fn steady_windows(run: &Run, channel: &str, force: Option<&str>, options: SteadyOptions) -> Vec<SteadyWindow> {
    let Some(velocity) = run.signal(channel).filter(|s| s.len() > 2) else { return Vec::new() };
    let signals: Vec<&Signal> = std::iter::once(velocity).chain(force.and_then(|name| run.signal(name))).collect();
    let scales: Vec<(f64, f64)> = signals.iter().map(|s| (greatest(s.values()), white_noise(s.values()))).collect();
    let gaps = gaps_of(run, [channel]);
    let steady = |from: f64, to: f64| {
        let gap = gaps.iter().any(|g| *g > from && *g <= to);
        let calm = |(signal, (scale, noise)): (&&Signal, &(f64, f64))| {
            let (t, x) = part(signal, from, to);
            // with white noise alone, the change of the line over the window has the standard
            // deviation σ sqrt(12/n)
            let by_chance = 2.0 * noise * (12.0 / t.len().max(1) as f64).sqrt();
            line(t, x).is_some_and(|(slope, scatter)| {
                (slope * (to - from)).abs() <= (options.drift * scale).max(by_chance)
                    && scatter <= (options.scatter * scale).max(1.5 * noise)
            })
        };
        !gap && signals.iter().zip(&scales).all(calm)
    };
    let time = velocity.time();
    let end = time[time.len() - 1];
    let mut windows = Vec::new();
    let mut k = 0;
    while k < time.len() && time[k] + options.length <= end + rounding(end) {
        let from = time[k];
        let shortest = time.partition_point(|t| *t < from + options.length - rounding(from)).min(time.len() - 1);
        if !steady(from, time[shortest]) {
            k += 1;
            continue;
        }
        // grow by quarters of the shortest length while it stays steady
        let mut last = shortest;
        loop {
            let next = time.partition_point(|t| *t < time[last] + 0.25 * options.length).min(time.len() - 1);
            if next == last || !steady(from, time[next]) {
                break;
            }
            last = next;
        }
        windows.push(SteadyWindow { from, to: time[last] });
        k = last + 1;
    }
    windows
}

/// Mean of a channel over a window; `None` with fewer than two samples in it.
pub fn mean_of(run: &Run, channel: &str, window: SteadyWindow) -> Option<Mean> {
    let (_, x) = part(run.signal(channel)?, window.from, window.to);
    let n = x.len();
    if n < 2 {
        return None;
    }
    let value = x.iter().sum::<f64>() / n as f64;
    let e: Vec<f64> = x.iter().map(|x| x - value).collect();
    let variance = e.iter().map(|e| e * e).sum::<f64>() / (n - 1) as f64;
    let mut inflation = 1.0;
    if variance > 0.0 {
        // beyond a third of the window the correlation is not known
        for lag in 1..=n / 3 {
            let rho = e[lag..].iter().zip(&e).map(|(a, b)| a * b).sum::<f64>() / (variance * (n - 1) as f64);
            // uncorrelated samples show as much by chance
            if rho <= 1.0 / (n as f64).sqrt() {
                break;
            }
            inflation += 2.0 * (1.0 - lag as f64 / n as f64) * rho;
        }
    }
    let std = (variance / n as f64 * inflation).sqrt();
    Some(Mean { value, std, scatter: variance.sqrt(), samples: n })
}

/// Standard deviation of the mean over a window from white sensor noise alone; `None` with fewer
/// than three samples. Slow motion about the mean is not part of it.
pub fn noise_of_mean(signal: &Signal, window: SteadyWindow) -> Option<f64> {
    let (_, x) = part(signal, window.from, window.to);
    (x.len() > 2).then(|| white_noise(x) / (x.len() as f64).sqrt())
}

/// Standard deviation of white noise on a slow signal: that of the second differences over sqrt(6).
fn white_noise(x: &[f64]) -> f64 {
    let sum: f64 = x.windows(3).map(|x| (x[0] - 2.0 * x[1] + x[2]).powi(2)).sum();
    (sum / (6.0 * x.len().saturating_sub(2).max(1) as f64)).sqrt()
}

fn greatest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |a, x| x.abs().max(a))
}

fn part(signal: &Signal, from: f64, to: f64) -> (&[f64], &[f64]) {
    let (time, slack) = (signal.time(), rounding(to));
    let range = time.partition_point(|t| *t < from - slack)..time.partition_point(|t| *t <= to + slack);
    (&time[range.clone()], &signal.values()[range])
}

/// Slope of the straight line and scatter about it; `None` with fewer than three samples.
fn line(t: &[f64], x: &[f64]) -> Option<(f64, f64)> {
    let n = t.len() as f64;
    if t.len() < 3 {
        return None;
    }
    let (tm, xm) = (t.iter().sum::<f64>() / n, x.iter().sum::<f64>() / n);
    let (mut tt, mut tx, mut xx) = (0.0, 0.0, 0.0);
    for (t, x) in t.iter().zip(x) {
        tt += (t - tm).powi(2);
        tx += (t - tm) * (x - xm);
        xx += (x - xm).powi(2);
    }
    let slope = tx / tt;
    Some((slope, ((xx - slope * tx).max(0.0) / (n - 2.0)).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(n: usize, u: impl Fn(f64) -> f64) -> Run {
        let time: Vec<f64> = (0..n).map(|k| k as f64 / 3.0).collect();
        let values: Vec<f64> = time.iter().map(|t| u(*t)).collect();
        let mut run = Run::default();
        run.signals.insert("u".into(), Signal::new(time.into(), values));
        run
    }

    #[test]
    fn the_settled_part_of_a_step_is_found() {
        let run = run(121, |t| 0.75 * (t / 3.0).tanh());
        let found = steady_windows(&run, "u", None, SteadyOptions::default());
        assert_eq!(found.len(), 1, "{found:?}");
        // 0.75 (1 − tanh(t/3)) is below 4 % of 0.75 after 6 s
        assert!(found[0].from > 2.0 && found[0].from < 7.0 && found[0].to > 38.0, "{found:?}");
        assert!(steady_windows(&self::run(121, |t| 0.02 * t), "u", None, SteadyOptions::default()).is_empty());
    }

    #[test]
    fn no_window_reaches_across_a_gap() {
        let mut run = run(121, |_| 0.5);
        run.gaps.push(20.0);
        let found = steady_windows(&run, "u", None, SteadyOptions::default());
        assert_eq!(found.len(), 2);
        assert!(found[0].to < 20.0 && found[1].from >= 20.0, "{found:?}");
    }

    #[test]
    fn law_correlated_samples_count_for_less() {
        // white noise from a linear congruence (Knuth's MMIX), and its running mean of 8
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let white: Vec<f64> = (0..600).map(|_| next()).collect();
        let slow: Vec<f64> = (0..592).map(|k| white[k..k + 8].iter().sum::<f64>() / 8.0).collect();
        let window = SteadyWindow { from: 0.0, to: 1e3 };
        let of = |x: &[f64]| mean_of(&run(x.len(), |t| x[(t * 3.0).round() as usize]), "u", window).unwrap();
        let (a, b) = (of(&white), of(&slow));
        // both means are equally well known, though the slow samples scatter sqrt(8) times less; a
        // fifth is allowed for chance
        assert!((a.std / (a.scatter / 600f64.sqrt()) - 1.0).abs() < 0.2, "{a:?}");
        assert!((b.std / a.std - 1.0).abs() < 0.3, "{a:?} {b:?}");
    }
}
