//! Initial states of the segments: how they follow a step of the unknowns, and how they are found
//! alone.
//!
//! ```text
//! δx = −Rₓ⁻¹ Rₓθ δθ + d      (RₓᵀRₓ + λ D) d = −Rₓᵀ rₓ      D = diag RₓᵀRₓ, segment by segment
//! ```
//!
//! If motion is unstable, the full step of one segment can overshoot although all others are near
//! their best. λ damps only the segment's own share. With a step of the unknowns every state goes
//! along in full, because the step counts on it. Marquardt, *SIAM Journal on Applied Mathematics*
//! 11 (1963) 431-441.

use nalgebra::{DMatrix, DVector};

use super::{Linearised, OutputErrorOptions, Problem};
use crate::model::Model;

/// Damping from which on a segment is given up.
const HOPELESS: f64 = 1e8;

/// Initial states after a `step` of the unknowns; each segment's own step is damped by its
/// `damping`.
pub(super) fn follow(
    problem: &Problem,
    segments: &[Linearised],
    x0: &[Vec<f64>],
    step: &[f64],
    damping: &[f64],
) -> Vec<Vec<f64>> {
    let nx = problem.dynamics.states.len();
    segments
        .iter()
        .zip(&problem.segments)
        .zip(x0)
        .zip(damping)
        .map(|(((segment, stretch), x), damping)| {
            let columns = problem.columns_of(stretch.track);
            let by_theta =
                |i: usize| -columns.iter().enumerate().map(|(d, c)| segment.at(i, nx + d) * step[*c]).sum::<f64>();
            let with: Vec<f64> = full(segment, &(0..nx).map(by_theta).collect::<Vec<f64>>());
            let wanted: Vec<f64> = (0..nx).map(|i| -segment.at(i, segment.n - 1)).collect();
            let own = if *damping > 0.0 { held_back(segment, &wanted, *damping) } else { full(segment, &wanted) };
            x.iter().zip(with).zip(own).map(|((x, with), own)| x + with + own).collect()
        })
        .collect()
}

/// δx of Rₓ δx = wanted; 0 for a state without information.
fn full(segment: &Linearised, wanted: &[f64]) -> Vec<f64> {
    let nx = wanted.len();
    let mut delta = vec![0.0; nx];
    for i in (0..nx).rev() {
        let by_state: f64 = (i + 1..nx).map(|j| segment.at(i, j) * delta[j]).sum();
        let pivot = segment.at(i, i);
        let size: f64 = (0..=i).map(|k| segment.at(k, i).powi(2)).sum::<f64>().sqrt();
        if pivot.abs() > 1e-9 * size {
            delta[i] = (wanted[i] - by_state) / pivot;
        }
    }
    delta
}

/// δx of (RₓᵀRₓ + λ D) δx = Rₓᵀ wanted.
fn held_back(segment: &Linearised, wanted: &[f64], damping: f64) -> Vec<f64> {
    let nx = wanted.len();
    let r = DMatrix::from_fn(nx, nx, |i, j| if i <= j { segment.at(i, j) } else { 0.0 });
    let mut a = r.transpose() * &r;
    for i in 0..nx {
        a[(i, i)] = (a[(i, i)] * (1.0 + damping)).max(f64::MIN_POSITIVE);
    }
    let b = r.transpose() * DVector::from_column_slice(wanted);
    a.cholesky().map_or(vec![0.0; nx], |factor| factor.solve(&b).iter().copied().collect())
}

/// Increases the damping of the segments whose own cost rose in a step that was refused.
pub(super) fn hold_back(damping: &mut [f64], before: &[Linearised], after: &[Linearised]) {
    for ((damping, before), after) in damping.iter_mut().zip(before).zip(after) {
        let fell = after.cost() <= before.cost();
        if !fell {
            *damping = f64::max(*damping * 10.0, 1e-2);
        }
    }
}

/// Reduces the damping of each segment after a step that was accepted.
pub(super) fn ease(damping: &mut [f64]) {
    for damping in damping {
        *damping = if *damping > 1e-3 { *damping * 0.1 } else { 0.0 };
    }
}

/// Finds the initial states with the parameters held, each segment for itself, so that one that is
/// far off does not keep the others from their best. Returns them with the segments linearised
/// there and the number of steps.
pub(super) fn settle(
    problem: &Problem,
    model: &Model,
    mut x0: Vec<Vec<f64>>,
    mut current: Vec<Linearised>,
    options: &OutputErrorOptions,
) -> (Vec<Vec<f64>>, Vec<Linearised>, usize) {
    let nx = problem.dynamics.states.len();
    let mut damping = vec![0.0; current.len()];
    let promise = |s: &Linearised| (0..nx).map(|i| s.at(i, s.n - 1).powi(2)).sum::<f64>();
    for step in 0..options.iterations {
        let open = current.iter().zip(&damping).any(|(s, d)| promise(s) > options.tolerance && *d < HOPELESS);
        if !open {
            return (x0, current, step);
        }
        let trial = follow(problem, &current, &x0, &[], &damping);
        let next = problem.linearise(model, &trial);
        for (((damping, current), x), (next, moved)) in
            damping.iter_mut().zip(&mut current).zip(&mut x0).zip(next.into_iter().zip(trial))
        {
            let fell = next.cost() <= current.cost();
            if fell {
                (*current, *x) = (next, moved);
                ease(std::slice::from_mut(damping));
            } else {
                *damping = f64::max(*damping * 10.0, 1e-2);
            }
        }
    }
    (x0, current, options.iterations)
}
