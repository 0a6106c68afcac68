//! The classical Runge-Kutta scheme, several stretches side by side.
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
//! Kutta, *Zeitschrift für Mathematik und Physik* 46 (1901) 435-453. Sensitivities S = ∂x/∂(x₀, θ) go through the same
//! stages: Ṡ = A S + B is the derivative of the scheme itself, so that they are exact for the discrete solution.

use super::Track;
use crate::dynamics::{Dynamics, Functions, Source};
use crate::progress;
use crate::symbolic::{Lanes, Registers};

/// Steps from one look at whether the work is still wanted to the next: some hundred microseconds.
const STEPS_A_LOOK: usize = 64;

/// A stretch of a track: grid points `first` to `last`, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stretch {
    /// Index of the track.
    pub track: usize,
    /// First grid point.
    pub first: usize,
    /// Last grid point.
    pub last: usize,
}

/// What is handed over at each grid point of each lane.
#[derive(Debug)]
pub struct Emission<'a, const L: usize> {
    /// Grid point each lane stands at; `None` for a lane that stands at none or is done.
    pub grid: [Option<usize>; L],
    /// States.
    pub states: &'a [[f64; L]],
    /// Outputs.
    pub outputs: &'a [[f64; L]],
    /// ∂output/∂(x₀, θ), row by row: `outputs × (states + directions)`; empty without sensitivities.
    pub jacobian: &'a [[f64; L]],
}

/// Registers of one set of functions: first the states, then the inputs.
struct Machine<'a, const L: usize> {
    functions: &'a Functions,
    registers: Registers<L>,
}

impl<'a, const L: usize> Machine<'a, L> {
    fn new(functions: &'a Functions, theta: &[[f64; L]]) -> Machine<'a, L> {
        let mut registers = functions.plan.registers::<L>();
        for (slot, source) in functions.sources.iter().enumerate() {
            if let Source::Parameter(p) = *source {
                functions.plan.set(&mut registers, slot, theta[p]);
            }
        }
        functions.plan.prepare(&mut registers);
        Machine { functions, registers }
    }

    /// The states that the next evaluation reads, and the values of the last one.
    #[inline(always)]
    fn ends(&mut self, states: usize) -> (&mut [[f64; L]], &[[f64; L]]) {
        let (leaves, values) = self.functions.plan.ends(&mut self.registers);
        (&mut leaves[..states], &values[..self.functions.count])
    }

    #[inline(always)]
    fn put_inputs(&mut self, states: usize, input: &[[f64; L]]) {
        let (leaves, _) = self.functions.plan.ends(&mut self.registers);
        leaves[states..].iter_mut().zip(input).for_each(|(to, from)| *to = *from);
    }

    #[inline(always)]
    fn evaluate(&mut self) {
        self.functions.plan.evaluate(&mut self.registers);
    }

    #[inline(always)]
    fn value(&self, k: usize) -> [f64; L] {
        self.functions.plan.output(&self.registers, k)
    }

    /// out = J S (+ the direct part), for a Jacobian J = [by_state | by_parameter] and S with `width` columns.
    #[inline(always)]
    fn chain(&self, s: &[[f64; L]], states: usize, width: usize, out: &mut [[f64; L]]) {
        out.fill([0.0; L]);
        let mut k = self.functions.count;
        for entry in &self.functions.by_state {
            let a = self.value(k);
            k += 1;
            let from = &s[entry.column * width..(entry.column + 1) * width];
            let to = &mut out[entry.row * width..(entry.row + 1) * width];
            for (to, from) in to.iter_mut().zip(from) {
                *to = std::array::from_fn(|i| to[i] + a[i] * from[i]);
            }
        }
        for entry in &self.functions.by_parameter {
            let b = self.value(k);
            k += 1;
            let to = &mut out[entry.row * width + states + entry.column];
            *to = std::array::from_fn(|i| to[i] + b[i]);
        }
    }
}

/// to = from + factor · rate, lane by lane.
#[inline(always)]
fn ahead<const L: usize>(to: &mut [[f64; L]], from: &[[f64; L]], factor: [f64; L], rate: &[[f64; L]]) {
    for ((to, from), rate) in to.iter_mut().zip(from).zip(rate) {
        *to = std::array::from_fn(|i| from[i] + factor[i] * rate[i]);
    }
}

/// sum += weight · rate, lane by lane.
#[inline(always)]
fn gather<const L: usize>(sum: &mut [[f64; L]], weight: [f64; L], rate: &[[f64; L]]) {
    for (sum, rate) in sum.iter_mut().zip(rate) {
        *sum = std::array::from_fn(|i| sum[i] + weight[i] * rate[i]);
    }
}

/// [`integrate`] with the widest vector units that the machine has.
pub fn integrate_fast<const L: usize>(
    dynamics: &Dynamics,
    tracks: &[Track],
    stretches: &[Option<Stretch>; L],
    theta: &[[f64; L]],
    x0: &[[f64; L]],
    sensitivities: bool,
    emit: &mut (impl FnMut(&Emission<'_, L>) + ?Sized),
) {
    super::widest(
        #[inline(always)]
        || integrate(dynamics, tracks, stretches, theta, x0, sensitivities, emit),
    );
}

/// Integrates `L` stretches side by side from the states `x0` with the parameters `theta` (each a value a lane) and
/// hands over every grid point of each, the first included. With `sensitivities` also the Jacobian of the outputs by
/// initial states and directions.
#[inline(always)]
pub fn integrate<const L: usize>(
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
    let slots = dynamics.inputs.len();
    let mut rates = Machine::<L>::new(&dynamics.rates, theta);
    let mut observe = Machine::<L>::new(&dynamics.observation, theta);

    let mut x = Lanes::of(x0);
    let mut s = Lanes::zeros(nx * width);
    for k in 0..nx.min(width) {
        s[k * width + k] = [1.0; L];
    }
    let mut sum_x = Lanes::zeros(nx);
    // the first stage reads the state itself
    rates.ends(nx).0.copy_from_slice(&x);
    let (mut ss, mut ks, mut sum_s) = (s.clone(), s.clone(), s.clone());
    let mut jacobian = Lanes::zeros(ny * width);

    let range = |lane: usize| {
        stretches[lane]
            .map_or((0, 0), |s| (tracks[s.track].steps_to[s.first + 1], tracks[s.track].steps_to[s.last + 1]))
    };
    let ranges: [(usize, usize); L] = std::array::from_fn(range);
    let longest = ranges.iter().map(|(a, b)| b - a).max().unwrap_or(0);

    // inputs at the beginning, in the middle and at the end of a step; those of the next are read one step ahead
    let mut inputs = Lanes::zeros(3 * slots);
    let mut next = inputs.clone();
    let first: [Option<usize>; L] = std::array::from_fn(|lane| stretches[lane].map(|s| s.first));
    for (lane, stretch) in stretches.iter().enumerate() {
        if let Some(stretch) = stretch {
            let at = &tracks[stretch.track].inputs_at[stretch.first * slots..(stretch.first + 1) * slots];
            for (slot, value) in inputs.iter_mut().zip(at) {
                slot[lane] = *value;
            }
        }
    }
    let alike = stretches.iter().all(|s| *s == stretches[0]);
    let read = |step: usize, inputs: &mut [[f64; L]]| {
        if alike {
            read_shared(tracks, stretches[0], ranges[0], step, slots, inputs);
        } else {
            read_inputs(tracks, stretches, &ranges, step, slots, inputs);
        }
    };
    read(0, &mut next);
    let mut grid = first;
    let mut at_hand = 0;
    for step in 0..=longest {
        if grid.iter().any(Option::is_some) {
            observe.put_inputs(nx, &inputs[at_hand..at_hand + slots]);
            hand_over(&mut observe, grid, &x, &s, (nx, width), &mut jacobian, emit);
        }
        if step == longest {
            break;
        }
        if step % STEPS_A_LOOK == 0 {
            progress::look();
        }
        at_hand = 2 * slots;
        std::mem::swap(&mut inputs, &mut next);
        read(step + 1, &mut next);
        let substep = |lane: usize| {
            let (begin, end) = ranges[lane];
            let stretch = stretches[lane].filter(|_| begin + step < end);
            stretch.map_or((0.0, None), |s| {
                let substep = &tracks[s.track].substeps[begin + step];
                (substep.step, substep.ends_at)
            })
        };
        let mut h = [0.0; L];
        if alike {
            let (step, ends_at) = substep(0);
            (h, grid) = ([step; L], [ends_at; L]);
        } else {
            for lane in 0..L {
                (h[lane], grid[lane]) = substep(lane);
            }
        }
        sum_x.iter_mut().for_each(|sum| *sum = [0.0; L]);
        if width > 0 {
            ss.copy_from_slice(&s);
            sum_s.fill([0.0; L]);
        }
        // third of the step, weight of the stage, how far the next one stands from the begin
        for (stage, (third, weight, next)) in
            [(0usize, 1.0, 0.5), (1, 2.0, 0.5), (1, 2.0, 1.0), (2, 1.0, 0.0)].into_iter().enumerate()
        {
            if stage != 2 {
                rates.put_inputs(nx, &inputs[third * slots..(third + 1) * slots]);
            }
            rates.evaluate();
            let (share, reach) = (h.map(|h| h * weight / 6.0), h.map(|h| h * next));
            let (states, rate) = rates.ends(nx);
            gather(&mut sum_x, share, rate);
            if stage < 3 {
                ahead(states, &x, reach, rate);
            } else {
                gather(&mut x, [1.0; L], &sum_x);
                states.iter_mut().zip(x.iter()).for_each(|(to, from)| *to = *from);
            }
            if width > 0 {
                rates.chain(&ss, nx, width, &mut ks);
                gather(&mut sum_s, share, &ks);
                if stage < 3 {
                    ahead(&mut ss, &s, reach, &ks);
                } else {
                    gather(&mut s, [1.0; L], &sum_s);
                }
            }
        }
    }
}

/// Inputs of the step `step` where all lanes sail the same stretch.
#[inline(always)]
fn read_shared<const L: usize>(
    tracks: &[Track],
    stretch: Option<Stretch>,
    (begin, end): (usize, usize),
    step: usize,
    slots: usize,
    inputs: &mut [[f64; L]],
) {
    if let (Some(stretch), true) = (stretch, begin + step < end) {
        let row = (begin + step) * 3 * slots;
        let table = &tracks[stretch.track].inputs[row..row + 3 * slots];
        for (slot, value) in inputs.iter_mut().zip(table) {
            *slot = [*value; L];
        }
    }
}

/// Inputs of the step `step` of every lane; those of lanes that are done stay.
#[inline(always)]
fn read_inputs<const L: usize>(
    tracks: &[Track],
    stretches: &[Option<Stretch>; L],
    ranges: &[(usize, usize); L],
    step: usize,
    slots: usize,
    inputs: &mut [[f64; L]],
) {
    for lane in 0..L {
        let (begin, end) = ranges[lane];
        if let (Some(stretch), true) = (stretches[lane], begin + step < end) {
            let row = (begin + step) * 3 * slots;
            let table = &tracks[stretch.track].inputs[row..row + 3 * slots];
            for (slot, value) in inputs.iter_mut().zip(table) {
                slot[lane] = *value;
            }
        }
    }
}

#[inline(always)]
fn hand_over<const L: usize>(
    observe: &mut Machine<'_, L>,
    grid: [Option<usize>; L],
    x: &[[f64; L]],
    s: &[[f64; L]],
    (nx, width): (usize, usize),
    jacobian: &mut [[f64; L]],
    emit: &mut (impl FnMut(&Emission<'_, L>) + ?Sized),
) {
    observe.ends(nx).0.iter_mut().zip(x).for_each(|(to, from)| *to = *from);
    observe.evaluate();
    if width > 0 {
        observe.chain(s, nx, width, jacobian);
    }
    emit(&Emission { grid, states: x, outputs: observe.ends(nx).1, jacobian });
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

    /// u = U tanh(t/T) under a constant force, with U = √(F/k), T = m/√(kF); classical RK4 at a hundredth of T is good to
    /// some 1e-10 of U.
    #[test]
    fn exact_start_from_rest_under_constant_force() {
        let (m, k, force) = (300.0, 130.0, 145.0);
        let (top, constant) = (f64::sqrt(force / k), m / f64::sqrt(k * force));
        let result = simulate(&surge(m, 0.0, k), &run(&|_| force, 0.02, 1000), Interpolation::Linear);
        for (t, u) in result.time.iter().zip(&result.outputs) {
            assert!((u - top * (t / constant).tanh()).abs() < 1e-9 * top, "t = {t}");
        }
    }

    /// One trajectory has its states in the lanes, several have themselves there: the same but for roundings of 1e-16.
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

    /// Sensitivities are the derivative of the discrete solution: central differences agree to their own accuracy.
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
