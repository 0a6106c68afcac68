//! Finds time stamps in minutes or hours: angles and positions then change 60 or 3600 times faster
//! than rates and velocities say.
//!
//! ```text
//! f = |Δψ| / |∫ r dt|      f = |Δ(x, y)| / ∫ √(u² + v²) dt
//! over windows of samples: f = 1 in seconds, 60 in minutes, 3600 in hours
//! ```
//!
//! Without such channels only the rate of the log is left: 300, 600 or 1200 rows per second are no
//! usual rates, but are those of 5, 10 or 20 Hz with stamps in minutes.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::super::codes;
use super::super::number::short;
use super::Seen;
use super::statistics::median;
use super::time::usual_step;
use crate::run::Signal;

/// Units that are tested: seconds per unit, name, and value of `time_unit`.
const UNITS: [(f64, &str, &str); 2] = [(60.0, "minutes", "min"), (3600.0, "hours", "h")];
/// Number of windows that a log is cut into, and least number of samples in one.
const WINDOWS: usize = 50;
const FEWEST: usize = 4;
/// Largest relative difference of a ratio from a unit, for the heading and for the position. The
/// heading has less margin: 57.3 is the ratio of degrees to radians.
const NEAR: (f64, f64) = (0.03, 0.15);
/// Usual rates of loggers that, with stamps in minutes, appear faster than any usual rate, Hz.
const RATES: [f64; 6] = [5.0, 10.0, 20.0, 25.0, 50.0, 100.0];

/// Finds the unit of the stamps if it is not the second.
pub fn check(time: &[f64], signals: &BTreeMap<String, Signal>) -> Option<Seen> {
    let turn = turn(signals);
    let way = way(signals);
    let is_near = |ratio: Option<f64>, unit: f64, near: f64| ratio.is_none_or(|r| (r / unit - 1.0).abs() < near);
    let of = |(unit, ..): &&(f64, &str, &str)| is_near(turn, *unit, NEAR.0) && is_near(way, *unit, NEAR.1);
    if let Some(found) = turn.or(way) {
        let (_, name, word) = UNITS.iter().find(of)?;
        let (changes, from) = match way {
            Some(_) => ("the position changes", "the velocity"),
            None => ("psi changes", "r"),
        };
        let text = format!(
            "{changes} {} times as fast as {from} indicates: the stamps are in {name}; set time_unit = \"{word}\"",
            short(way.unwrap_or(found), 3)
        );
        return Some(Seen::new(codes::TIME_UNIT, &["t"], None, text));
    }
    let rate = 1.0 / usual_step(time)?;
    let (unit, name, word) = UNITS[0];
    let slower = RATES.into_iter().find(|usual| (rate / (usual * unit) - 1.0).abs() < 0.005)?;
    let text = format!(
        "{} rows a second is not a usual rate; {slower} Hz is one, so the stamps are probably in {name}: set time_unit \
         = \"{word}\"",
        short(rate, 4)
    );
    Some(Seen::new(codes::TIME_UNIT, &["t"], None, text))
}

/// Returns the change of the heading over the integral of the yaw rate.
fn turn(signals: &BTreeMap<String, Signal>) -> Option<f64> {
    let (psi, r) = (signals.get("psi")?, signals.get("r")?);
    let step = |k: usize| {
        let change = psi.values()[k + 1] - psi.values()[k];
        change - TAU * (change / TAU).round()
    };
    let windows = windows(&[psi, r])?;
    let pair = |w: &(usize, usize)| ((w.0..w.1).map(step).sum::<f64>().abs(), integral(r.time(), r.values(), *w).abs());
    ratio(&windows.iter().map(pair).collect::<Vec<_>>())
}

/// Returns the distance covered over the integral of the horizontal speed.
fn way(signals: &BTreeMap<String, Signal>) -> Option<f64> {
    let [x, y, u] = ["x", "y", "u"].map(|name| signals.get(name));
    let (x, y, u) = (x?, y?, u?);
    let v = signals.get("v").filter(|v| v.len() == u.len());
    let speed: Vec<f64> =
        u.values().iter().enumerate().map(|(k, u)| u.hypot(v.map_or(0.0, |v| v.values()[k]))).collect();
    let windows = windows(&[x, y, u])?;
    let change = |s: &Signal, w: &(usize, usize)| s.values()[w.1] - s.values()[w.0];
    let pair = |w: &(usize, usize)| (change(x, w).hypot(change(y, w)), integral(u.time(), &speed, *w));
    ratio(&windows.iter().map(pair).collect::<Vec<_>>())
}

/// Returns the first and last samples of windows, if the signals share their stamps.
fn windows(signals: &[&Signal]) -> Option<Vec<(usize, usize)>> {
    let count = signals[0].len();
    let length = (count / WINDOWS).max(FEWEST);
    if count < 5 * length || signals.iter().any(|s| s.time() != signals[0].time()) {
        return None;
    }
    Some((0..(count - 1) / length).map(|k| (k * length, (k + 1) * length)).collect())
}

/// ∫ x dt by the trapezoidal rule.
fn integral(time: &[f64], values: &[f64], (from, to): (usize, usize)) -> f64 {
    (from..to).map(|k| 0.5 * (values[k] + values[k + 1]) * (time[k + 1] - time[k])).sum()
}

/// Returns the median ratio of the first to the second value, over the half of the windows with the
/// largest second values; `None` if the median deviation from it is 20 % or more.
fn ratio(pairs: &[(f64, f64)]) -> Option<f64> {
    let usual = median(pairs.iter().map(|p| p.1))?;
    let ratios: Vec<f64> = pairs.iter().filter(|p| p.1 >= usual && p.1 > 0.0).map(|p| p.0 / p.1).collect();
    let middle = median(ratios.iter().copied())?;
    let spread = median(ratios.iter().map(|r| (r - middle).abs()))?;
    (middle > 0.0 && spread < 0.2 * middle).then_some(middle)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A vehicle in a winding motion, 60 s at this rate, its stamps divided by `unit`.
    fn log(rate: f64, unit: f64, columns: &[&str]) -> (Vec<f64>, BTreeMap<String, Signal>) {
        let seconds: Vec<f64> = (0..(60.0 * rate) as usize).map(|k| k as f64 / rate).collect();
        let time: std::sync::Arc<[f64]> = seconds.iter().map(|t| t / unit).collect();
        let (mut x, mut y, mut rows) = (0.0, 0.0, Vec::new());
        for t in &seconds {
            let (u, r, psi) = (0.5 + 0.2 * (0.3 * t).sin(), 0.2 * (0.2 * t).cos(), (0.2 * t).sin());
            rows.push(BTreeMap::from([("u", u), ("v", 0.0), ("r", r), ("psi", psi), ("x", x), ("y", y)]));
            (x, y) = (x + u * psi.cos() / rate, y + u * psi.sin() / rate);
        }
        let signal = |name: &&str| {
            let values: Vec<f64> = rows.iter().map(|row| row[name]).collect();
            (name.to_string(), Signal::new(time.clone(), values))
        };
        (time.to_vec(), columns.iter().map(signal).collect())
    }

    #[test]
    fn minutes_and_hours_are_told_by_what_moves() {
        for columns in [&["u", "v", "r", "psi", "x", "y"] as &[&str], &["u", "r", "psi"], &["u", "v", "x", "y"]] {
            for rate in [1.0, 4.0, 10.0] {
                let said = |unit: f64| {
                    let (time, signals) = log(rate, unit, columns);
                    check(&time, &signals).map(|seen| seen.text)
                };
                assert_eq!(said(1.0), None, "{columns:?} at {rate}");
                assert!(said(60.0).is_some_and(|s| s.contains("time_unit = \"min\"")), "{columns:?} at {rate}");
                assert!(said(3600.0).is_some_and(|s| s.contains("time_unit = \"h\"")), "{columns:?} at {rate}");
            }
        }
    }

    #[test]
    fn where_nothing_moves_against_anything_the_rate_tells() {
        let said = |rate: f64, unit: f64| {
            let (time, signals) = log(rate, unit, &["u", "v", "r"]);
            check(&time, &signals).map(|seen| seen.text)
        };
        assert!(said(10.0, 60.0).is_some_and(|s| s.contains("10 Hz") && s.contains("time_unit = \"min\"")));
        for rate in [1.0, 10.0, 60.0, 100.0, 120.0, 400.0, 1000.0] {
            assert_eq!(said(rate, 1.0), None, "{rate}");
        }
    }
}
