//! The quickest time constants of a motion, which limit the steps of the integrator.
//!
//! ```text
//! T = 1 / max(|λ|, |ω|),   λ: eigenvalues of ∂f/∂ν, and of ∂f/∂memories, ω: turn rates, at the logged motion
//! ```
//!
//! For one degree of freedom T = m / (d_L + 2 d_Q |ν|). With steps of h the Runge-Kutta scheme has
//! a relative error of the decay rate of (h/T)⁴/120, towards slower decay: 0.05 % for half of the
//! time constant, 0.8 % for the whole.

use nalgebra::DMatrix;

use super::free_run::with_jacobian_at;
use super::{QUICKEST, Track};
use crate::chain::StateId;
use crate::dynamics::Dynamics;
use crate::eigenvalues::eigenvalues;

/// Distance of the instants that are evaluated, s.
const APART: f64 = 1.0;

/// Number of later samples that are searched to derive an unmeasured velocity from its pose.
const ASIDE: usize = 5;

/// Shortest time constant of a motion that steps follow, s. With steps of half of it the rate of a
/// time constant of 0.05 s has an error of 0.05 %, and of half of that 1 %. Vehicles are slower;
/// quicker motions that a search tries need no better.
const QUICKEST_MOTION: f64 = 0.05;

/// The quickest time constant of the motion of `track`, and of its memories, near each grid point,
/// s; at least 0.05 and [`QUICKEST`], infinite if nothing decays and nothing turns. `dynamics` must
/// have the Jacobian by its states.
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
            // no eigenvalue exceeds the norm; a norm that is not finite limits no step
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
        // between two instants the quicker of the two counts
        let quickest = rates[i].max(rates.get(i + 1).copied().unwrap_or(0.0));
        let end = instants.get(i + 1).copied().unwrap_or(track.time.len());
        constants.resize(constants.len() + end - begin, 1.0 / quickest);
    }
    constants
}

/// The state near a grid point by the log: as measured, else from the pose, else 0.
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
            // the speed, taken along any axis of the body
            let speed = || ["x", "y", "z"].iter().filter_map(|axis| change(axis)).reduce(f64::hypot);
            if dof.is_rotation() { change(dof.position()) } else { speed() }
        }),
        StateId::Position(_) => id.channel().and_then(&near).map(|(_, x)| x),
        StateId::Quaternion(component) => Some(if *component == 0 { 1.0 } else { 0.0 }),
        StateId::Memory { .. } => None,
    };
    dynamics.states.iter().map(|id| value(id).unwrap_or(0.0)).collect()
}
