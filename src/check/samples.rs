//! One signal as samples at their true instants, with its running integral.
//!
//! ```text
//! F(t) = ∫ x dt by the trapezoid,     ∫ₐᵇ x dt = F(b) − F(a),     σ² = ⟨(Δ³x)²⟩/20
//! ```
//!
//! The signal is linear between samples. A value that the log of a slower sensor repeats is no
//! sample and is left out. σ is the standard deviation of white noise: its third difference has the
//! variance 20 σ², while that of a smooth motion is nearly zero.

use std::f64::consts::{PI, TAU};

use crate::log::check::hold;
use crate::log::check::statistics::median;
use crate::navigation::comes_round;
use crate::run::Signal;

/// Factor by which a step must exceed the usual one to be a hole.
const HOLE: f64 = 5.0;

/// Samples of one quantity.
#[derive(Debug, Clone)]
pub struct Samples {
    time: Vec<f64>,
    values: Vec<f64>,
    area: Vec<f64>,
    step: f64,
}

impl Samples {
    /// Returns the true samples of a signal; `None` with fewer than eight.
    pub fn of(signal: &Signal) -> Option<Samples> {
        let (time, values) = (signal.time(), signal.values());
        match hold::of(values) {
            Some(hold) => {
                let kept = hold.samples(values);
                let (time, values) = kept.into_iter().map(|k| (time[k], values[k])).unzip();
                Samples::new(time, values)
            }
            None => Samples::new(time.to_vec(), values.to_vec()),
        }
    }

    /// The same for an angle, which is unwrapped. An angle that jumps by 360 is unwrapped as
    /// degrees; one with a wider range than a wrapped angle in radians is left as it is.
    pub fn of_angle(signal: &Signal) -> Option<Samples> {
        let samples = Samples::of(signal)?;
        let degrees = samples.values.windows(2).any(|w| ((w[1] - w[0]).abs() - 360.0).abs() < 30.0);
        if !degrees && !comes_round(&samples.values) {
            return Some(samples);
        }
        let turn = if degrees { 360.0 } else { TAU };
        let values = unwound(&samples.values, turn);
        Samples::new(samples.time, values)
    }

    /// Returns samples with these time stamps (s) and values, of equal number; `None` with fewer
    /// than eight.
    pub fn new(time: Vec<f64>, values: Vec<f64>) -> Option<Samples> {
        let steps = time.windows(2).map(|w| w[1] - w[0]);
        let step = median(steps)?;
        if values.len() < 8 || step <= 0.0 {
            return None;
        }
        let mut area = vec![0.0; time.len()];
        for k in 1..time.len() {
            area[k] = area[k - 1] + 0.5 * (values[k] + values[k - 1]) * (time[k] - time[k - 1]);
        }
        Some(Samples { time, values, area, step })
    }

    /// Returns a function of time and value at the instants of these samples.
    pub fn map(&self, f: impl Fn(f64, f64) -> f64) -> Samples {
        let values: Vec<f64> = self.time.iter().zip(&self.values).map(|(t, x)| f(*t, *x)).collect();
        let mut area = vec![0.0; values.len()];
        for k in 1..values.len() {
            area[k] = area[k - 1] + 0.5 * (values[k] + values[k - 1]) * (self.time[k] - self.time[k - 1]);
        }
        Samples { time: self.time.clone(), values, area, step: self.step }
    }

    /// Time stamps, s.
    pub fn time(&self) -> &[f64] {
        &self.time
    }

    /// Values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Usual step, s.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Value at `t`, linear between samples, constant outside.
    pub fn at(&self, t: f64) -> f64 {
        let (k, part) = self.place(t);
        self.values[k] + part * (self.values[k + 1] - self.values[k])
    }

    /// Integral from `a` to `b`; the part outside of the samples adds nothing.
    pub fn integral(&self, a: f64, b: f64) -> f64 {
        self.area_at(b) - self.area_at(a)
    }

    fn area_at(&self, t: f64) -> f64 {
        let (k, part) = self.place(t);
        let here = self.values[k] + 0.5 * part * (self.values[k + 1] - self.values[k]);
        self.area[k] + here * part * (self.time[k + 1] - self.time[k])
    }

    /// Returns the interval that contains `t` and the fraction of it before `t`, 0 to 1.
    fn place(&self, t: f64) -> (usize, f64) {
        let last = self.time.len() - 2;
        // with regular samples the step gives the interval; otherwise it is searched
        let regular = (((t - self.time[0]) / self.step) as usize).min(last);
        let within = self.time[regular] <= t && t < self.time[regular + 1];
        let k = if within { regular } else { self.time.partition_point(|s| *s <= t).clamp(1, last + 1) - 1 };
        (k, ((t - self.time[k]) / (self.time[k + 1] - self.time[k])).clamp(0.0, 1.0))
    }

    /// Standard deviation of white noise on the samples.
    pub fn noise(&self) -> f64 {
        let third: Vec<f64> = self.values.windows(4).map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).collect();
        // the median resists spikes; if most differences are zero only the mean square is informative
        let usual = median(third.iter().map(|d| d.abs())).unwrap_or(0.0) / 0.6745;
        let square = (third.iter().map(|d| d * d).sum::<f64>() / third.len().max(1) as f64).sqrt();
        if usual > 0.0 { usual.min(square) / 20f64.sqrt() } else { square / 20f64.sqrt() }
    }

    /// Returns the stretches without samples: from, to.
    fn holes(&self) -> impl Iterator<Item = (f64, f64)> {
        self.time.windows(2).filter(|w| w[1] - w[0] > HOLE * self.step).map(|w| (w[0], w[1]))
    }
}

/// Returns adjacent windows of this width in which every signal has samples; `margin` is left free
/// at both ends of each stretch. A long log gives 3000 at most, evenly distributed.
pub fn windows(signals: &[&Samples], width: f64, margin: f64) -> Vec<(f64, f64)> {
    const MOST: usize = 3000;
    let begin = signals.iter().map(|s| s.time[0]).fold(f64::NEG_INFINITY, f64::max) + margin;
    let end = signals.iter().map(|s| s.time[s.time.len() - 1]).fold(f64::INFINITY, f64::min) - margin;
    if width <= 0.0 || end.is_nan() || begin.is_nan() || end <= begin {
        return Vec::new();
    }
    let mut holes: Vec<(f64, f64)> = signals.iter().flat_map(|s| s.holes()).collect();
    holes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut stretches = Vec::new();
    let mut from = begin;
    for (a, b) in holes {
        stretches.push((from, (a - margin).min(end)));
        from = from.max(b + margin);
    }
    stretches.push((from, end));
    let count = |(a, b): (f64, f64)| (((b - a) / width * (1.0 + 1e-9)).floor()).max(0.0) as usize;
    let stride = stretches.iter().map(|s| count(*s)).sum::<usize>().div_ceil(MOST).max(1);
    let tiles = |s: (f64, f64)| (0..count(s)).map(move |k| (s.0 + width * k as f64, s.0 + width * (k + 1) as f64));
    stretches.into_iter().flat_map(tiles).step_by(stride).collect()
}

/// Returns an angle without its jumps by a full turn.
fn unwound(angle: &[f64], turn: f64) -> Vec<f64> {
    let mut turns = 0.0;
    let mut last = angle.first().copied().unwrap_or(0.0);
    let next = |x: &f64| {
        turns -= ((x - last) / turn).round();
        last = *x;
        x + turn * turns
    };
    angle.iter().map(next).collect()
}

/// Returns an angle wrapped to (−π, π], rad.
pub fn within_half_turn(angle: f64) -> f64 {
    let x = angle.rem_euclid(TAU);
    if x > PI { x - TAU } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line() -> Samples {
        let time: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(k)).collect();
        Samples::new(time.clone(), time.iter().map(|t| 2.0 * t).collect()).unwrap()
    }

    #[test]
    fn exact_a_straight_line_is_integrated_exactly_between_samples() {
        let s = line();
        // rounding only: the trapezoid is exact on a line
        assert!((s.at(3.33) - 6.66).abs() < 1e-12);
        assert!((s.integral(1.234, 5.678) - (5.678f64.powi(2) - 1.234f64.powi(2))).abs() < 1e-12);
    }

    #[test]
    fn noise_is_that_of_the_samples_and_motion_has_none() {
        let time: Vec<f64> = (0..4000).map(|k| 0.1 * f64::from(k)).collect();
        let mut noise = crate::tank::Noise::new(1, 1);
        let values: Vec<f64> = time.iter().map(|t| (0.5 * t).sin() + 0.01 * noise.normal()).collect();
        // 4000 differences determine σ to some 3 percent; 10 percent is three of those
        let noisy = Samples::new(time.clone(), values).unwrap().noise();
        assert!((noisy / 0.01 - 1.0).abs() < 0.1, "{noisy}");
        assert!(Samples::new(time.clone(), time.iter().map(|t| (0.5 * t).sin()).collect()).unwrap().noise() < 1e-4);
    }

    #[test]
    fn windows_stay_clear_of_holes() {
        let time: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(k) + if k > 50 { 20.0 } else { 0.0 }).collect();
        let s = Samples::new(time, vec![0.0; 100]).unwrap();
        let w = windows(&[&s], 1.0, 0.0);
        assert_eq!(w.len(), 5 + 4);
        assert!(w.iter().all(|(a, b)| *b <= 5.0 + 1e-9 || *a >= 25.0));
    }

    #[test]
    fn turns_are_unwound_in_degrees_and_radians() {
        let turning = |turn: f64| -> Vec<f64> { (0..60).map(|k| (0.05 * turn * f64::from(k)) % turn).collect() };
        for turn in [360.0, TAU] {
            let time: Vec<f64> = (0..60).map(f64::from).collect();
            let s = Samples::of_angle(&Signal::new(time.into(), turning(turn))).unwrap();
            assert!((s.values()[59] - 0.05 * turn * 59.0).abs() < 1e-9);
        }
    }
}
