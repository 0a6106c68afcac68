//! The quickest time constants of a motion: what the steps of the integrator have to follow.
//!
//! ```text
//! T = 1 / max(|λ|, |ω|),   λ: eigenvalues of ∂f/∂ν, and of ∂f/∂memories, ω: turn rates, at the logged motion
//! ```
//!
//! For one degree of freedom T = m / (d_L + 2 d_Q |ν|). The Runge-Kutta scheme with steps of h decays by a rate that is
//! (h/T)⁴/120 of itself too small: 0.05 % with half of the time constant, 0.8 % with the whole.

use nalgebra::DMatrix;

use super::free_run::with_jacobian_at;
use super::{QUICKEST, Track};
use crate::chain::StateId;
use crate::dynamics::Dynamics;
use crate::eigenvalues::eigenvalues;

/// From one instant that is looked at to the next, s.
const APART: f64 = 1.0;

/// Samples on each side over which a velocity that is not measured is read off its pose.
const ASIDE: usize = 5;

/// Shortest time constant of a motion that steps follow, s: with half of it the rate of one of 0.05 s is good to 0.05 %, of one
/// half as long to 1 %. Vehicles are slower; what a search tries on its way is not worth more.
const QUICKEST_MOTION: f64 = 0.05;

/// The quickest time constant of the motion of `track` and of its memories about each of its grid points, s; at least 0.05 and
/// [`QUICKEST`], infinite where nothing decays and nothing turns. `dynamics` has the Jacobian by its states.
pub fn quickest_time_constants(dynamics: &Dynamics, track: &Track, theta: &[f64]) -> Vec<f64> {
    let states = || dynamics.states.iter().enumerate();
    let moving: Vec<usize> = states().filter(|(_, id)| matches!(id, StateId::Velocity(_))).map(|(k, _)| k).collect();
    let remembered: Vec<usize> =
        states().filter(|(_, id)| matches!(id, StateId::Memory { .. })).map(|(k, _)| k).collect();
    let blocks = [(moving, QUICKEST_MOTION), (remembered, QUICKEST)];
    let turns = |state: &[f64]| {
        let turning = states().filter(|(_, id)| matches!(id, StateId::Velocity(dof) if dof.is_rotation()));
        turning.map(|(k, _)| state[k].abs()).filter(|rate| rate.is_finite()).fold(0.0, f64::max)
    };
    let rate = |k: usize| {
        let state = state_near(dynamics, track, k);
        let values = with_jacobian_at(&dynamics.rates, dynamics, track, theta, k, &state);
        let slopes = &values[dynamics.rates.count..];
        let of = |(block, least): &(Vec<usize>, f64)| {
            let place = |state: usize| block.iter().position(|own| *own == state);
            let mut jacobian = DMatrix::<f64>::zeros(block.len(), block.len());
            for (entry, slope) in dynamics.rates.by_state.iter().zip(slopes) {
                if let (Some(row), Some(column)) = (place(entry.row), place(entry.column)) {
                    jacobian[(row, column)] = *slope;
                }
            }
            // no eigenvalue is beyond the norm; what is no number bounds no step
            let norm = jacobian.norm();
            let quickest = eigenvalues(&jacobian).map_or(if norm.is_finite() { norm } else { 0.0 }, |values| {
                values.iter().map(|value| value.norm()).fold(0.0, f64::max)
            });
            quickest.min(1.0 / least)
        };
        blocks.iter().map(of).fold(turns(&state).min(1.0 / QUICKEST_MOTION), f64::max)
    };
    let mut instants = vec![0];
    for (k, t) in track.time.iter().enumerate() {
        if t - track.time[instants[instants.len() - 1]] >= APART {
            instants.push(k);
        }
    }
    let rates: Vec<f64> = instants.iter().map(|k| rate(*k)).collect();
    let mut constants = Vec::with_capacity(track.time.len());
    for (i, begin) in instants.iter().enumerate() {
        // between two instants the motion is as quick as at either
        let quickest = rates[i].max(rates.get(i + 1).copied().unwrap_or(0.0));
        let end = instants.get(i + 1).copied().unwrap_or(track.time.len());
        constants.resize(constants.len() + end - begin, 1.0 / quickest);
    }
    constants
}

/// The state at a grid point as the log has it near there: measured, from the pose, or else 0.
fn state_near(dynamics: &Dynamics, track: &Track, k: usize) -> Vec<f64> {
    let width = dynamics.outputs.len();
    let sample = |channel: &str, around: std::ops::Range<usize>| {
        let output = dynamics.outputs.iter().position(|name| name == channel)?;
        let value = |k: usize| track.observed[k * width + output];
        around.clone().rev().find(|k| !value(*k).is_nan()).map(|k| (track.time[k], value(k)))
    };
    let near = |channel: &str| sample(channel, 0..k + 1);
    let change = |channel: &str| {
        let ((t0, x0), (t1, x1)) = (near(channel)?, sample(channel, k + 1..(k + 1 + ASIDE).min(track.time.len()))?);
        Some((x1 - x0) / (t1 - t0))
    };
    let value = |id: &StateId| match id {
        StateId::Velocity(dof) => near(dof.velocity()).map(|(_, v)| v).or_else(|| {
            // along whichever axis of the body
            let speed = || ["x", "y", "z"].iter().filter_map(|axis| change(axis)).reduce(f64::hypot);
            if dof.is_rotation() { change(dof.position()) } else { speed() }
        }),
        StateId::Position(_) => id.channel().and_then(&near).map(|(_, x)| x),
        StateId::Quaternion(component) => Some(if *component == 0 { 1.0 } else { 0.0 }),
        StateId::Memory { .. } => None,
    };
    dynamics.states.iter().map(|id| value(id).unwrap_or(0.0)).collect()
}
