//! One trajectory by the classical Runge-Kutta scheme, its states in the lanes of one register.
//!
//! The scheme is that of [`integrate`](super::integrate). There lanes are trajectories; where there is but one, the
//! states themselves are the lanes: ẋ = c₀ + Σ cₖ aₖ + Σ cₖ aₖ bₖ with vectors c of all states.

use super::Track;
use crate::dynamics::{Dynamics, Functions, Source};
use crate::progress;
use crate::symbolic::{Dense, Four, Plain, Registers};

/// Steps from one look at whether the work is still wanted to the next: some hundred microseconds.
const STEPS_A_LOOK: usize = 4096;

/// Simulates grid points `first` to `last` of a track from the states `x0` and hands over grid point, states and
/// outputs. `false` where the model has more than 16 states or outputs or is too large, and nothing was done.
pub(super) fn sail_single(
    dynamics: &Dynamics,
    track: &Track,
    theta: &[f64],
    x0: &[f64],
    (first, last): (usize, usize),
    emit: &mut impl FnMut(usize, &[f64], &[f64]),
) -> bool {
    match dynamics.states.len().max(dynamics.outputs.len()) {
        0..=4 => sail::<1>(dynamics, track, theta, x0, (first, last), emit),
        5..=8 => sail::<2>(dynamics, track, theta, x0, (first, last), emit),
        9..=16 => sail::<4>(dynamics, track, theta, x0, (first, last), emit),
        _ => false,
    }
}

fn dense<const Q: usize>(functions: &Functions, theta: &[f64], states: usize) -> Option<Dense<Q>> {
    let mut registers: Registers<1> = functions.plan.registers();
    for (slot, source) in functions.sources.iter().enumerate() {
        if let Source::Parameter(p) = *source {
            functions.plan.set(&mut registers, slot, [theta[p]]);
        }
    }
    functions.plan.prepare(&mut registers);
    Dense::of(&functions.plan, &registers, states)
}

fn sail<const Q: usize>(
    dynamics: &Dynamics,
    track: &Track,
    theta: &[f64],
    x0: &[f64],
    range: (usize, usize),
    emit: &mut impl FnMut(usize, &[f64], &[f64]),
) -> bool {
    let nx = dynamics.states.len();
    let (Some(mut rates), Some(mut observe)) =
        (dense::<Q>(&dynamics.rates, theta, nx), dense::<Q>(&dynamics.observation, theta, nx))
    else {
        return false;
    };
    // builds with debug assertions compile the plain version alone, which builds faster
    #[cfg(all(target_arch = "x86_64", not(debug_assertions)))]
    if let Some(four) = pulp::x86::V3::try_new() {
        super::widest(
            #[inline(always)]
            || steps(four, dynamics, track, &mut rates, &mut observe, x0, range, emit),
        );
        return true;
    }
    steps(Plain, dynamics, track, &mut rates, &mut observe, x0, range, emit);
    true
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
    emit: &mut impl FnMut(usize, &[f64], &[f64]),
) {
    let (nx, ny, slots) = (dynamics.states.len(), dynamics.outputs.len(), dynamics.inputs.len());
    let at = |k: usize| x0.get(k).copied().unwrap_or(0.0);
    let mut x = [four.splat(0.0); Q];
    for q in 0..Q {
        x[q] = four.load(&[at(4 * q), at(4 * q + 1), at(4 * q + 2), at(4 * q + 3)]);
    }
    let substeps = track.steps_to[first + 1]..track.steps_to[last + 1];
    let tables = track.inputs[3 * slots * substeps.start..3 * slots * substeps.end].chunks_exact((3 * slots).max(1));
    // without inputs there is no table to walk along
    let tables = tables.map(Some).chain(std::iter::repeat(None));
    let mut emit = |k: usize, x: &[F::Value; Q], y: &[F::Value; Q]| {
        let mut both = [[[0.0; 4]; Q]; 2];
        for q in 0..Q {
            both[0][q] = four.store(x[q]);
            both[1][q] = four.store(y[q]);
        }
        emit(k, &both[0].as_flattened()[..nx], &both[1].as_flattened()[..ny]);
    };

    put(observe, &track.inputs_at[first * slots..(first + 1) * slots]);
    let y = observe.evaluate(four, &x);
    emit(first, &x, &y);
    for (k, (substep, table)) in track.substeps[substeps].iter().zip(tables).enumerate() {
        if k % STEPS_A_LOOK == 0 {
            progress::look();
        }
        let (begin, rest) = table.unwrap_or_default().split_at(slots);
        let (middle, end) = rest.split_at(slots);
        let half = four.splat(0.5 * substep.step);
        let (step, sixth) = (four.splat(substep.step), four.splat(substep.step / 6.0));
        put(rates, begin);
        let k1 = rates.evaluate(four, &x);
        put(rates, middle);
        let k2 = rates.evaluate(four, &plus(four, &x, half, &k1));
        let k3 = rates.evaluate(four, &plus(four, &x, half, &k2));
        put(rates, end);
        let k4 = rates.evaluate(four, &plus(four, &x, step, &k3));
        let (one, two) = (four.splat(1.0), four.splat(2.0));
        let all = plus(four, &plus(four, &k1, one, &k4), two, &plus(four, &k2, one, &k3));
        x = plus(four, &x, sixth, &all);
        if let Some(at) = substep.ends_at {
            put(observe, end);
            let y = observe.evaluate(four, &x);
            emit(at, &x, &y);
        }
    }
}

#[inline(always)]
fn put<const Q: usize>(to: &mut Dense<Q>, from: &[f64]) {
    to.inputs().iter_mut().zip(from).for_each(|(to, x)| *to = [*x]);
}

/// a + factor·b
#[inline(always)]
fn plus<F: Four, const Q: usize>(four: F, a: &[F::Value; Q], factor: F::Value, b: &[F::Value; Q]) -> [F::Value; Q] {
    let mut sum = *a;
    for q in 0..Q {
        sum[q] = four.add(a[q], four.mul(factor, b[q]));
    }
    sum
}
