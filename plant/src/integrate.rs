//! Runge-Kutta method of fourth order, with steps that end where the equations change.
//!
//! ```text
//! x₊ = x + h/6 (k₁ + 2k₂ + 2k₃ + k₄)       between steps: the cubic through both ends and both slopes
//! ```
//!
//! Commands and random forces are straight lines on an [`Interval`], and no event lies inside it.
//! Other kinks can still lie inside a step, for example a velocity that changes its sign under
//! quadratic drag, or a force that leaves the dead band. They are detected by comparing the side of
//! each kink at both ends of the step; such a step is repeated in [`PARTS`] parts.

use crate::attitude;
use crate::plant::{Interval, Ready, STATES, State, place, quaternion_of};

/// Number of parts into which a step with a kink is divided.
pub const PARTS: usize = 16;

/// A finished step, which can be interpolated.
#[derive(Debug, Clone)]
pub struct Step {
    /// Start, s.
    pub from: f64,
    /// End, s.
    pub to: f64,
    start: State,
    end: State,
    start_rate: State,
    end_rate: State,
}

impl Step {
    /// State at a time inside the step.
    pub fn at(&self, t: f64) -> State {
        let h = self.to - self.from;
        let s = ((t - self.from) / h).clamp(0.0, 1.0);
        let (s2, s3) = (s * s, s * s * s);
        let weights = [2.0 * s3 - 3.0 * s2 + 1.0, (s3 - 2.0 * s2 + s) * h, 3.0 * s2 - 2.0 * s3, (s3 - s2) * h];
        std::array::from_fn(|k| {
            weights[0] * self.start[k]
                + weights[1] * self.start_rate[k]
                + weights[2] * self.end[k]
                + weights[3] * self.end_rate[k]
        })
    }

    /// State at the end.
    pub fn end(&self) -> &State {
        &self.end
    }
}

/// Integrates the plant over an interval in steps of at most `longest` s, calls `seen` with each of
/// them, and returns the state at the end.
pub fn integrate(
    ready: &Ready<'_>,
    mut x: State,
    interval: &Interval,
    longest: f64,
    mut seen: impl FnMut(&Step),
) -> State {
    let length = interval.to - interval.from;
    let count = (length / longest - 1e-9).ceil().max(1.0) as usize;
    let h = length / count as f64;
    for k in 0..count {
        let t = interval.from + k as f64 * h;
        let (whole, bent) = step(ready, &x, t, h, interval);
        if bent {
            let part = h / PARTS as f64;
            for j in 0..PARTS {
                let (one, _) = step(ready, &x, t + j as f64 * part, part, interval);
                x = one.end;
                seen(&one);
            }
        } else {
            x = whole.end;
            seen(&whole);
        }
    }
    x
}

/// One step, and whether the equations have a kink in it.
fn step(ready: &Ready<'_>, x: &State, t: f64, h: f64, interval: &Interval) -> (Step, bool) {
    let moved = |slope: &State, by: f64| -> State { std::array::from_fn(|k| x[k] + by * slope[k]) };
    let k1 = ready.rates(t, x, interval);
    let k2 = ready.rates(t + 0.5 * h, &moved(&k1.state, 0.5 * h), interval);
    let k3 = ready.rates(t + 0.5 * h, &moved(&k2.state, 0.5 * h), interval);
    let k4 = ready.rates(t + h, &moved(&k3.state, h), interval);
    let mut end: State = [0.0; STATES];
    for k in 0..STATES {
        end[k] = x[k] + h / 6.0 * (k1.state[k] + 2.0 * (k2.state[k] + k3.state[k]) + k4.state[k]);
    }
    let unit = attitude::normalised(quaternion_of(&end));
    end[place::QUATERNION..place::NU].copy_from_slice(&unit);
    let step = Step { from: t, to: t + h, start: *x, end, start_rate: k1.state, end_rate: k4.state };
    (step, k1.sides != k4.sides)
}
