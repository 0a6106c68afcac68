//! Integration of one trajectory by the classical Runge-Kutta scheme, its states in the lanes of
//! one register.
//!
//! The scheme is that of [`integrate`](super::integrate). There the lanes are trajectories; with
//! one trajectory the lanes are its states, see [`Dense`].

use super::{Track, Trajectory};
use crate::dynamics::{Dynamics, Functions, Source};
use crate::progress;
use crate::simd::{Four, Plain};
use crate::symbolic::{Dense, Registers};

/// Number of steps between two checks for cancellation: some hundred microseconds.
const STEPS_A_LOOK: usize = 4096;

/// Simulates the grid points of `range` of a track, both ends included, from the states `x0`.
/// `None` if the model has more than 16 states or outputs or is too large.
pub(super) fn sail_single(
    dynamics: &Dynamics,
    track: &Track,
    theta: &[f64],
    x0: &[f64],
    range: (usize, usize),
) -> Option<Trajectory> {
    match dynamics.states.len().max(dynamics.outputs.len()) {
        0..=4 => sail::<1>(dynamics, track, theta, x0, range),
        5..=8 => sail::<2>(dynamics, track, theta, x0, range),
        9..=16 => sail::<4>(dynamics, track, theta, x0, range),
        _ => None,
    }
}

/// Rows of `width` numbers. Each row is written in whole vectors of four, and the excess is
/// removed.
struct Table {
    values: Vec<f64>,
    width: usize,
}

impl Table {
    fn new(rows: usize, width: usize, fours: usize) -> Table {
        Table { values: Vec::with_capacity(rows * width + 4 * fours), width }
    }

    #[inline(always)]
    fn push<F: Four, const Q: usize>(&mut self, four: F, x: &[F::Value; Q]) {
        let end = self.values.len() + self.width;
        let mut row = [[0.0; 4]; Q];
        for q in 0..Q {
            row[q] = four.store(x[q]);
        }
        self.values.extend_from_slice(row.as_flattened());
        self.values.truncate(end);
    }
}

fn dense<const Q: usize>(functions: &Functions, theta: &[f64]) -> Option<Dense<Q>> {
    let mut registers: Registers<1> = functions.plan.registers();
    for (slot, source) in functions.sources.iter().enumerate() {
        if let Source::Parameter(p) = *source {
            functions.plan.set(&mut registers, slot, [theta[p]]);
        }
    }
    functions.plan.prepare(&mut registers);
    Dense::of(&functions.plan, &registers)
}

fn sail<const Q: usize>(
    dynamics: &Dynamics,
    track: &Track,
    theta: &[f64],
    x0: &[f64],
    range: (usize, usize),
) -> Option<Trajectory> {
    let (nx, points) = (dynamics.states.len(), range.1 + 1 - range.0);
    let mut rates = dense::<Q>(&dynamics.rates, theta)?;
    let mut observe = dense::<Q>(&dynamics.observation, theta)?;
    let mut tables = [Table::new(points, nx, Q), Table::new(points, dynamics.outputs.len(), Q)];
    let done = |tables: [Table; 2]| {
        let [states, outputs] = tables.map(|table| table.values);
        Some(Trajectory { time: track.time[range.0..=range.1].to_vec(), states, outputs })
    };
    // builds with debug assertions compile the plain version alone, which builds faster
    #[cfg(all(target_arch = "x86_64", not(debug_assertions)))]
    if let Some(four) = pulp::x86::V3::try_new() {
        crate::simd::widest(
            #[inline(always)]
            || steps(four, dynamics, track, &mut rates, &mut observe, x0, range, &mut tables),
        );
        return done(tables);
    }
    steps(Plain, dynamics, track, &mut rates, &mut observe, x0, range, &mut tables);
    done(tables)
}

#[inline(always)]
#[allow(clippy::too_many_arguments)] // the working memory of one call, handed through
fn steps<F: Four, const Q: usize>(
    four: F,
    dynamics: &Dynamics,
    track: &Track,
    rates: &mut Dense<Q>,
    observe: &mut Dense<Q>,
    x0: &[f64],
    (first, last): (usize, usize),
    [states, outputs]: &mut [Table; 2],
) {
    let slots = dynamics.inputs.len();
    let at = |k: usize| x0.get(k).copied().unwrap_or(0.0);
    let mut x = [four.splat(0.0); Q];
    for q in 0..Q {
        x[q] = four.load(&[at(4 * q), at(4 * q + 1), at(4 * q + 2), at(4 * q + 3)]);
    }
    let substeps = track.steps_to[first + 1]..track.steps_to[last + 1];
    let tables = track.inputs[3 * slots * substeps.start..3 * slots * substeps.end].chunks_exact((3 * slots).max(1));
    // without inputs there is no table
    let tables = tables.map(Some).chain(std::iter::repeat(None));
    let at_first = &track.inputs_at[first * slots..(first + 1) * slots];
    // outputs that are the states themselves need no computation
    let sees_states = dynamics.observation.plan.is_states(dynamics.outputs.len());
    let mut seen = observe.drive(four, at_first);
    states.push(four, &x);
    outputs.push(four, &observe.evaluate(four, &seen, &x));
    // the inputs for which the rates were driven last
    let (mut driven, mut with) = (rates.drive(four, at_first), at_first);
    for (k, (substep, table)) in track.substeps[substeps].iter().zip(tables).enumerate() {
        if k % STEPS_A_LOOK == 0 {
            progress::look();
        }
        let (begin, rest) = table.unwrap_or_default().split_at(slots);
        let (middle, end) = rest.split_at(slots);
        let half = four.splat(0.5 * substep.step);
        let (step, sixth, two) = (four.splat(substep.step), four.splat(substep.step / 6.0), four.splat(2.0));
        if begin != with {
            driven = rates.drive(four, begin);
        }
        let k1 = rates.evaluate(four, &driven, &x);
        let driven_there = rates.drive(four, middle);
        let k2 = rates.evaluate(four, &driven_there, &plus(four, &x, half, &k1));
        let k3 = rates.evaluate(four, &driven_there, &plus(four, &x, half, &k2));
        // summed before the last stage, so that little has to wait for it
        let before = plus(four, &plus(four, &k1, two, &k2), two, &k3);
        let before = plus(four, &x, sixth, &before);
        (driven, with) = (rates.drive(four, end), end);
        let k4 = rates.evaluate(four, &driven, &plus(four, &x, step, &k3));
        x = plus(four, &before, sixth, &k4);
        if substep.ends_at.is_some() {
            states.push(four, &x);
            if sees_states {
                outputs.push(four, &x);
                continue;
            }
            if observe.is_driven() {
                seen = observe.drive(four, end);
            }
            outputs.push(four, &observe.evaluate(four, &seen, &x));
        }
    }
}

/// a + factor·b
#[inline(always)]
fn plus<F: Four, const Q: usize>(four: F, a: &[F::Value; Q], factor: F::Value, b: &[F::Value; Q]) -> [F::Value; Q] {
    let mut sum = *a;
    for q in 0..Q {
        sum[q] = four.fused(factor, b[q], a[q]);
    }
    sum
}
