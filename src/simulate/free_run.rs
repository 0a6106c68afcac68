//! Simulation of a whole run from one initial state.

use crate::dynamics::{Dynamics, Functions, Source};
use crate::model::Model;
use crate::simd::Plain;
use crate::symbolic::Registers;

use super::single::sail_single;
use super::{Stretch, Track, Trajectory, integrate_fast};

/// Largest distance of a simulated value from the measured one, in the unit of the channel.
const REACH: f64 = 1e3;

/// The simulated value, limited to a thousand units from the measured one: the error of a diverging
/// simulation is bounded, and the same whether it ends in infinity or in NaN.
pub fn in_reach(simulated: f64, measured: f64) -> f64 {
    if simulated.is_finite() { simulated.clamp(measured - REACH, measured + REACH) } else { measured + REACH }
}

/// Values of the model's parameters in the run `run`.
pub fn values_in_run(model: &Model, run: usize) -> Vec<f64> {
    model.parameters.iter().map(|p| p.per_run.get(run).copied().unwrap_or(p.value)).collect()
}

/// Quasi-steady values of the memory states at grid point `k` if the other states are `x`.
pub fn memory_start(dynamics: &Dynamics, track: &Track, theta: &[f64], k: usize, x: &[f64]) -> Vec<f64> {
    values_at(&dynamics.start, dynamics, track, theta, k, x)
}

/// Values of `functions` of a compiled model at grid point `k` in the state `x`; states that `x`
/// does not have are 0.
pub fn values_at(
    functions: &Functions,
    dynamics: &Dynamics,
    track: &Track,
    theta: &[f64],
    k: usize,
    x: &[f64],
) -> Vec<f64> {
    let mut values = with_jacobian_at(functions, dynamics, track, theta, k, x);
    values.truncate(functions.count);
    values
}

/// [`values_at`], followed by the entries of the Jacobians of `functions`.
pub(super) fn with_jacobian_at(
    functions: &Functions,
    dynamics: &Dynamics,
    track: &Track,
    theta: &[f64],
    k: usize,
    x: &[f64],
) -> Vec<f64> {
    let slots = dynamics.inputs.len();
    let mut registers: Registers<1> = functions.plan.registers();
    for (slot, source) in functions.sources.iter().enumerate() {
        let value = match *source {
            Source::State(i) => x.get(i).copied().unwrap_or(0.0),
            Source::Parameter(p) => theta[p],
            Source::Input(i) => track.inputs_at[k * slots + i],
        };
        functions.plan.set(&mut registers, slot, [value]);
    }
    functions.plan.prepare(&mut registers);
    functions.plan.evaluate(Plain, &mut registers);
    let count = functions.count + functions.by_state.len() + functions.by_parameter.len();
    (0..count).map(|k| functions.plan.output(&registers, k)[0]).collect()
}

/// Simulates the stretch of `track` from grid point `first` to `last` from the state `x0`
/// (velocities and positions; memory starts quasi-steady).
pub fn free_run(
    dynamics: &Dynamics,
    track: &Track,
    theta: &[f64],
    x0: &[f64],
    first: usize,
    last: usize,
) -> Trajectory {
    let mut x = x0.to_vec();
    x.truncate(dynamics.states.len() - dynamics.memories());
    let memory = memory_start(dynamics, track, theta, first, &x);
    x.extend(memory);
    if let Some(done) = sail_single(dynamics, track, theta, &x, (first, last)) {
        return done;
    }
    let points = last + 1 - first;
    let mut result = Trajectory {
        time: Vec::with_capacity(points),
        outputs: Vec::with_capacity(points * dynamics.outputs.len()),
        states: Vec::with_capacity(points * dynamics.states.len()),
    };
    let theta: Vec<[f64; 1]> = theta.iter().map(|v| [*v]).collect();
    let start: Vec<[f64; 1]> = x.iter().map(|v| [*v]).collect();
    let stretch = [Some(Stretch { track: 0, first, last })];
    integrate_fast(dynamics, std::slice::from_ref(track), &stretch, &theta, &start, false, &mut |at| {
        if let [Some(k)] = *at.grid {
            result.time.push(track.time[k]);
            result.outputs.extend(at.outputs.iter().map(|y| y[0]));
            result.states.extend(at.states.iter().map(|x| x[0]));
        }
    });
    result
}
