//! The classical Runge-Kutta scheme for several stretches side by side.
//!
//! ```text
//!   0  |
//!  1/2 | 1/2
//!  1/2 |  0   1/2
//!   1  |  0    0    1
//!  ----+--------------------
//!      | 1/6  1/3  1/3  1/6
//! ```
//!
//! Kutta, *Zeitschrift für Mathematik und Physik* 46 (1901) 435-453. Sensitivities S = ∂x/∂(x₀, θ)
//! go through the same stages: Ṡ = A S + B is the derivative of the scheme itself, so that they are
//! exact for the discrete solution.

use super::evaluator::{Evaluator, prepared};
use super::feed::Feed;
use super::{Stretch, Track};
use crate::dynamics::Dynamics;
use crate::progress;
use crate::simd::{Lanes, Machine, Wide, Widths, Work};
use crate::symbolic::Ends;

/// Number of steps between two checks for cancellation: some hundred microseconds.
const STEPS_A_LOOK: usize = 64;

/// The results at the grid points of the lanes.
#[derive(Debug)]
pub struct Emission<'a, const L: usize> {
    /// Grid point of each lane; `None` for a lane between grid points or at its end.
    pub grid: &'a [Option<usize>; L],
    /// States.
    pub states: &'a [[f64; L]],
    /// Outputs.
    pub outputs: &'a [[f64; L]],
    /// ∂output/∂(x₀, θ), row by row: `outputs × (states + directions)`; empty without sensitivities.
    pub jacobian: &'a [[f64; L]],
}

/// The four stages: weight, distance of the next stage from the beginning in steps, and the instant
/// of its inputs if they change.
const STAGES: [(f64, f64, Option<usize>); 4] =
    [(1.0, 0.5, Some(1)), (2.0, 0.5, None), (2.0, 1.0, Some(2)), (1.0, 0.0, None)];

/// The arguments of an integration of `L` stretches side by side.
struct Integration<'a, 'e, const L: usize, E: FnMut(&Emission<'_, L>) + ?Sized> {
    dynamics: &'a Dynamics,
    tracks: &'a [Track],
    stretches: &'a [Option<Stretch>; L],
    theta: &'a [[f64; L]],
    x0: &'a [[f64; L]],
    sensitivities: bool,
    emit: &'e mut E,
}

impl<const L: usize, E: FnMut(&Emission<'_, L>) + ?Sized> Work<L> for Integration<'_, '_, L, E> {
    type Output = ();
    #[inline(always)]
    fn with<W: Wide<L>>(self, wide: W) {
        let Integration { dynamics, tracks, stretches, theta, x0, sensitivities, emit } = self;
        integrate(wide, dynamics, tracks, stretches, theta, x0, sensitivities, emit);
    }
}

/// [`integrate`] with the widest registers of the machine.
pub fn integrate_fast<const L: usize>(
    dynamics: &Dynamics,
    tracks: &[Track],
    stretches: &[Option<Stretch>; L],
    theta: &[[f64; L]],
    x0: &[[f64; L]],
    sensitivities: bool,
    emit: &mut (impl FnMut(&Emission<'_, L>) + ?Sized),
) where
    Machine: Widths<L>,
{
    Machine::widest(Integration { dynamics, tracks, stretches, theta, x0, sensitivities, emit });
}

/// Integrates `L` stretches side by side from the states `x0` with the parameters `theta` (each
/// with a value for every lane). Calls `emit` at every grid point, the first included; with
/// `sensitivities` also with the Jacobian of the outputs by initial states and directions.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // what is integrated, with which registers
pub fn integrate<const L: usize, W: Wide<L>>(
    wide: W,
    dynamics: &Dynamics,
    tracks: &[Track],
    stretches: &[Option<Stretch>; L],
    theta: &[[f64; L]],
    x0: &[[f64; L]],
    sensitivities: bool,
    emit: &mut (impl FnMut(&Emission<'_, L>) + ?Sized),
) {
    let (nx, ny) = (dynamics.states.len(), dynamics.outputs.len());
    let width = if sensitivities { nx + dynamics.directions.len() } else { 0 };
    let [mut rates, mut observe] = [&dynamics.rates, &dynamics.observation].map(|f| prepared(f, theta));
    let mut rates = Evaluator::new(&dynamics.rates, &mut rates, nx, width);
    let mut observe = Evaluator::new(&dynamics.observation, &mut observe, nx, width);

    // slices are taken once: the memory does not move from here on
    let (mut x, mut s, mut sum_x) = (Lanes::of(x0), Lanes::<L>::zeros(nx * width), Lanes::<L>::zeros(nx));
    let (x, s, sum_x) = (&mut x[..nx], &mut s[..], &mut sum_x[..nx]);
    for k in 0..nx.min(width) {
        s[k * width + k] = [1.0; L];
    }
    // the first stage reads the state itself
    let Ends { states, sizes, .. } = rates.ends();
    for ((state, size), x) in states.iter_mut().zip(sizes).zip(x.iter()) {
        (*state, *size) = (*x, x.map(f64::abs));
    }
    // S at this stage, at the next one, and Σ b k
    let (mut here, mut there, mut sum_s) = (Lanes::of(s), Lanes::of(s), Lanes::<L>::zeros(nx * width));
    let (mut here, mut there, sum_s) = (&mut here[..], &mut there[..], &mut sum_s[..]);
    let (mut direct, mut seen) = (Lanes::<L>::zeros(nx * width), Lanes::<L>::zeros(ny * width));
    let mut jacobian = Lanes::<L>::zeros(ny * width);
    let (direct, seen, jacobian) = (&mut direct[..], &mut seen[..], &mut jacobian[..]);

    // outputs that are the states themselves need no computation
    let sees_states = dynamics.observation.plan.is_states(ny);
    let mut feed = Feed::new(tracks, stretches, dynamics.inputs.len());
    let (mut at_hand, longest) = (0, feed.steps());
    for step in 0..=longest {
        let on_grid = feed.grid.iter().any(Option::is_some);
        if on_grid && sees_states {
            let jacobian = &here[..ny * width];
            emit(&Emission { grid: &feed.grid, states: x, outputs: &x[..ny], jacobian });
        } else if on_grid {
            let Ends { states, sizes, others, .. } = observe.ends();
            feed.put(wide, at_hand, others);
            for ((state, size), x) in states.iter_mut().zip(sizes).zip(x.iter()) {
                (*state, *size) = (*x, wide.store(wide.abs(wide.load(x))));
            }
            observe.evaluate(wide);
            if width > 0 {
                observe.chain(
                    wide,
                    here,
                    seen,
                    #[inline(always)]
                    |k, g| jacobian[k] = wide.store(g),
                );
            }
            emit(&Emission { grid: &feed.grid, states: x, outputs: &observe.ends().values[..ny], jacobian });
        }
        if step == longest {
            break;
        }
        if step % STEPS_A_LOOK == 0 {
            progress::look();
        }
        feed.go_on(step);
        let h = wide.load(&feed.h);
        at_hand = 2;
        feed.put(wide, 0, rates.ends().others);
        for (stage, (weight, next, instant)) in STAGES.into_iter().enumerate() {
            rates.evaluate(wide);
            let (share, reach) = (wide.mul(h, wide.splat(weight / 6.0)), wide.mul(h, wide.splat(next)));
            let Ends { states, sizes, others, values } = rates.ends();
            let (states, sizes, values) = (&mut states[..nx], &mut sizes[..nx], &values[..nx]);
            for k in 0..nx {
                let rate = wide.load(&values[k]);
                let before = if stage == 0 { wide.splat(0.0) } else { wide.load(&sum_x[k]) };
                let after = wide.plus(before, share, rate);
                let next = if stage < 3 {
                    sum_x[k] = wide.store(after);
                    wide.plus(wide.load(&x[k]), reach, rate)
                } else {
                    let next = wide.add(wide.load(&x[k]), after);
                    x[k] = wide.store(next);
                    next
                };
                (states[k], sizes[k]) = (wide.store(next), wide.store(wide.abs(next)));
            }
            if let Some(instant) = instant {
                feed.put(wide, instant, others);
            }
            if width > 0 {
                rates.chain(
                    wide,
                    here,
                    direct,
                    #[inline(always)]
                    |k, rate| {
                        let before = if stage == 0 { wide.splat(0.0) } else { wide.load(&sum_s[k]) };
                        let after = wide.plus(before, share, rate);
                        if stage < 3 {
                            sum_s[k] = wide.store(after);
                            there[k] = wide.store(wide.plus(wide.load(&s[k]), reach, rate));
                        } else {
                            s[k] = wide.store(wide.add(wide.load(&s[k]), after));
                            there[k] = s[k];
                        }
                    },
                );
                std::mem::swap(&mut here, &mut there);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::{Trajectory, free_run};
    use super::*;
    use crate::chain::Available;
    use crate::effects::Coriolis;
    use crate::frame::Dof;
    use crate::model::{Interpolation, Model};
    use crate::run::{Run, Signal};

    fn surge(m: f64, linear: f64, quadratic: f64) -> Model {
        let effects = ["inertia", "linear_drag", "quadratic_drag"];
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &effects).unwrap();
        for (name, value) in [("inertia", m), ("linear_drag", linear), ("quadratic_drag", quadratic)] {
            assert!(model.set(&format!("{name}@surge"), value));
        }
        model
    }

    fn run(tau: &dyn Fn(f64) -> f64, step: f64, n: usize) -> Run {
        let time: std::sync::Arc<[f64]> = (0..=n).map(|k| step * k as f64).collect();
        let mut run = Run::default();
        let values: Vec<f64> = time.iter().map(|t| tau(*t)).collect();
        run.signals.insert("tau_u".into(), Signal::new(time.clone(), values));
        run.signals.insert("u".into(), Signal::new(time, vec![0.0; n + 1]));
        run
    }

    fn simulate(model: &Model, run: &Run, input: Interpolation) -> Trajectory {
        let available = Available { channels: run.signals.keys().cloned().collect(), ..Available::default() };
        let observed: BTreeSet<String> = ["u".to_string()].into();
        let dynamics = Dynamics::compile(model, &available, &observed, &[]);
        let track = Track::new(run, 0, &dynamics, &model.values(), input, 10.0).unwrap();
        free_run(&dynamics, &track, &model.values(), &[0.0], 0, track.time.len() - 1)
    }

    /// u = U tanh(t/T) under a constant force, with U = √(F/k), T = m/√(kF); classical RK4 with
    /// steps of T/100 has an error of about 1e-10 of U.
    #[test]
    fn exact_start_from_rest_under_constant_force() {
        let (m, k, force) = (300.0, 130.0, 145.0);
        let (top, constant) = (f64::sqrt(force / k), m / f64::sqrt(k * force));
        let result = simulate(&surge(m, 0.0, k), &run(&|_| force, 0.02, 1000), Interpolation::Linear);
        for (t, u) in result.time.iter().zip(&result.outputs) {
            assert!((u - top * (t / constant).tanh()).abs() < 1e-9 * top, "t = {t}");
        }
    }

    /// With one trajectory the lanes are the states, with several they are the trajectories: the
    /// results agree but for roundings of 1e-16.
    #[test]
    fn law_single_and_side_by_side_agree() {
        let model = surge(841.93, 82.3, 309.07);
        let run = run(&|t| 185.7 + 145.3 * (t / 4.0).sin(), 0.1, 300);
        let available = Available { channels: run.signals.keys().cloned().collect(), ..Available::default() };
        let dynamics = Dynamics::compile(&model, &available, &["u".to_string()].into(), &[]);
        let theta = model.values();
        let track = Track::new(&run, 0, &dynamics, &theta, Interpolation::Linear, 0.03).unwrap();
        let last = track.time.len() - 1;
        let single = free_run(&dynamics, &track, &theta, &[0.2], 3, last);
        let lanes: Vec<[f64; 2]> = theta.iter().map(|v| [*v; 2]).collect();
        let stretches = [Some(Stretch { track: 0, first: 3, last }), Some(Stretch { track: 0, first: 0, last: 2 })];
        let (mut k, tracks) = (0, std::slice::from_ref(&track));
        integrate_fast(&dynamics, tracks, &stretches, &lanes, &[[0.2; 2]], false, &mut |at: &Emission<'_, 2>| {
            let found = at.outputs[0][0];
            if at.grid[0].is_some() {
                assert!((single.outputs[k] - found).abs() < 1e-14, "{k}: {} and {found}", single.outputs[k]);
                k += 1;
            }
        });
        assert_eq!((k, single.time.len(), single.time[0]), (last - 2, last - 2, track.time[3]));
    }

    /// Sensitivities are the derivative of the discrete solution: central differences agree to
    /// their own accuracy.
    #[test]
    fn law_sensitivities_agree_with_differences() {
        let model = surge(841.93, 82.3, 309.07);
        let run = run(&|t| 185.7 + 145.3 * (t / 4.0).sin(), 0.1, 100);
        let available = Available { channels: run.signals.keys().cloned().collect(), ..Available::default() };
        let observed: BTreeSet<String> = ["u".to_string()].into();
        let dynamics = Dynamics::compile(&model, &available, &observed, &model.free());
        let theta = model.values();
        let track = Track::new(&run, 0, &dynamics, &theta, Interpolation::Linear, 0.1).unwrap();
        let last = track.time.len() - 1;
        let end = |theta: &[f64], u0: f64| *free_run(&dynamics, &track, theta, &[u0], 0, last).outputs.last().unwrap();
        let lanes: Vec<[f64; 2]> = theta.iter().map(|v| [*v; 2]).collect();
        let stretch = Some(Stretch { track: 0, first: 0, last });
        let mut found = Vec::new();
        let tracks = std::slice::from_ref(&track);
        integrate_fast(&dynamics, tracks, &[stretch; 2], &lanes, &[[0.1; 2]], true, &mut |at: &Emission<'_, 2>| {
            if at.grid[1] == Some(last) {
                found = at.jacobian.iter().map(|g| g[1]).collect();
            }
        });
        assert_eq!(found.len(), 4);
        for (k, exact) in found.iter().enumerate() {
            let (mut up, mut down, mut u_up, mut u_down) = (theta.clone(), theta.clone(), 0.1, 0.1);
            let h = if k == 0 { 1e-6 } else { theta[k - 1] * 1e-6 };
            if k == 0 {
                (u_up, u_down) = (0.1 + h, 0.1 - h);
            } else {
                (up[k - 1], down[k - 1]) = (theta[k - 1] + h, theta[k - 1] - h);
            }
            let numeric = (end(&up, u_up) - end(&down, u_down)) / (2.0 * h);
            assert!((numeric - exact).abs() < 1e-6 * exact.abs().max(1e-6), "{k}: {exact} against {numeric}");
        }
    }
}
