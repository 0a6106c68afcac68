//! Comparison of a rate with its angle: whether both describe the same motion.
//!
//! ```text
//! c = Σ Δα ∫r dt / Σ (∫r dt)²         explained = c Σ Δα ∫r dt / Σ Δα²
//! ```
//!
//! over the intervals between samples of the angle α, Δα within half a turn. The module
//! `crate::check` measures this more accurately, with roll and pitch, standard deviations and a
//! lag; here it only decides whether a large rate is plausible.

use std::f64::consts::{PI, TAU};

use super::statistics::range;
use crate::run::Signal;

/// Least number of intervals.
const FEWEST: usize = 20;
/// Largest difference of the factor from 1.
const TOLERANCE: f64 = 0.2;
/// Least share of the changes of the angle that the rate must explain.
const EXPLAINED: f64 = 0.7;

/// Whether the angle changes as its rate says, with a factor near 1.
pub fn agree(rate: &Signal, angle: &Signal) -> bool {
    let (time, alpha) = (angle.time(), angle.values());
    let (mut both, mut said, mut turned, mut used) = (0.0, 0.0, 0.0, 0);
    for k in 1..time.len() {
        let by_rate = integral(rate, time[k - 1], time[k]);
        // beyond half a turn the direction of the turn is ambiguous
        if by_rate.abs() > 0.8 * PI {
            continue;
        }
        let change = alpha[k] - alpha[k - 1];
        let change = change - TAU * (change / TAU).round();
        both += change * by_rate;
        said += by_rate * by_rate;
        turned += change * change;
        used += 1;
    }
    let factor = both / said;
    used >= FEWEST && 2 * used >= time.len() && (factor - 1.0).abs() < TOLERANCE && factor * both > EXPLAINED * turned
}

/// Whether an angle is clearly in radians: it jumps by 2π, or stays within one turn. An unwrapped
/// angle over several turns may be in degrees.
pub fn in_radians(angle: &Signal) -> bool {
    let jumps = angle.values().windows(2).any(|w| ((w[1] - w[0]).abs() - TAU).abs() < 0.5);
    jumps || range(angle.values().iter().copied()).is_some_and(|(a, b)| b - a <= TAU)
}

/// Integral of the signal from `a` to `b`, linear between samples.
fn integral(signal: &Signal, a: f64, b: f64) -> f64 {
    let time = signal.time();
    let inside = &time[time.partition_point(|t| *t <= a)..time.partition_point(|t| *t < b)];
    let mut stamps = vec![a];
    stamps.extend(inside);
    stamps.push(b);
    stamps.windows(2).map(|w| 0.5 * (signal.at(w[0]) + signal.at(w[1])) * (w[1] - w[0])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_at_its_own_stamps_agrees_with_the_angle_that_it_turns() {
        let stamps = |step: f64, n: u32| (0..n).map(|k| step * f64::from(k)).collect::<Vec<f64>>();
        let signal = |time: Vec<f64>, f: &dyn Fn(f64) -> f64| {
            let values: Vec<f64> = time.iter().map(|t| f(*t)).collect();
            Signal::new(time.into(), values)
        };
        let angle = signal(stamps(0.25, 200), &|t| (0.8 * t).sin());
        for (factor, right) in [(1.0, true), (-1.0, false), (1.5, false), (57.3, false), (0.0, false)] {
            let rate = signal(stamps(0.07, 720), &|t| factor * 0.8 * (0.8 * t).cos());
            assert_eq!(agree(&rate, &angle), right, "{factor}");
        }
        assert!(in_radians(&angle) && !in_radians(&signal(stamps(0.1, 200), &|t| 20.0 * t)));
    }
}
