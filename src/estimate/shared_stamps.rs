//! Rows of the regression if all channels share their stamps: nothing to look up, instants side by
//! side, parts on all cores.
//!
//! ```text
//! cₖ = πₖ − πₖ₋₁ − ½ (fₖ₋₁ + fₖ)(tₖ − tₖ₋₁)
//! ```
//!
//! A row reads two instants. Parts have fixed borders, so that the numbers do not depend on the
//! number of cores.

use rayon::prelude::*;

use super::regressor::LANES;
use crate::simd::{Plain, widest};
use crate::symbolic::{Plan, Registers};

/// Number of rows of a part, written by one thread.
const PART: usize = 1 << 14;

/// The inputs at every instant: slot of the plan, and one value for each instant.
pub(super) type Inputs<'a> = [(usize, &'a [f64])];

/// Writes the rows between neighbours of the instants `time`, which increase. The first outputs of
/// the plan are momenta, followed by as many forces. The first of each is the known part, whose
/// rows go with the opposite sign to the first of `columns`; the rows of the others go to the other
/// columns. Columns have `time.len() − 1` values.
pub(super) fn write_rows(
    plan: &Plan,
    registers: &Registers<LANES>,
    time: &[f64],
    inputs: &Inputs<'_>,
    columns: Vec<&mut [f64]>,
) {
    let mut parts: Vec<Vec<&mut [f64]>> = Vec::new();
    for column in columns {
        for (k, part) in column.chunks_mut(PART).enumerate() {
            match parts.get_mut(k) {
                Some(parts) => parts.push(part),
                None => parts.push(vec![part]),
            }
        }
    }
    parts.into_par_iter().enumerate().for_each(|(k, mut columns)| {
        let nodes = k * PART..k * PART + columns[0].len() + 1;
        let inputs: Vec<(usize, &[f64])> = inputs.iter().map(|(slot, x)| (*slot, &x[nodes.clone()])).collect();
        let mut registers = registers.clone();
        widest(
            #[inline(always)]
            || write_part(plan, &mut registers, &time[nodes], &inputs, &mut columns),
        );
    });
}

/// Number of instants whose rows are made and used while they are in the cache: 24 KiB for six
/// columns.
const NEAR: usize = 512;

/// The same rows, passed to `take` as they are made: columns and right-hand side of some hundred
/// rows at a time. Returns the state of each part, which `begin` starts and `take` updates.
///
/// # Errors
/// The error of `begin` or `take`, of the first part that has one.
pub(super) fn over_rows<S: Send, E: Send>(
    plan: &Plan,
    registers: &Registers<LANES>,
    time: &[f64],
    inputs: &Inputs<'_>,
    width: usize,
    begin: &(impl Fn() -> Result<S, E> + Sync),
    take: &(impl Fn(&mut S, &[&[f64]], &[f64]) -> Result<(), E> + Sync),
) -> Result<Vec<S>, E> {
    // one row fewer than instants
    let near = NEAR - 1;
    let part_rows = near * (PART / near);
    let rows = time.len() - 1;
    let part = |k: usize| {
        let (mut state, mut registers, mut block) = (begin()?, registers.clone(), vec![0.0; width * near]);
        for first in (k * part_rows..((k + 1) * part_rows).min(rows)).step_by(near) {
            let count = near.min(rows - first);
            let nodes = first..first + count + 1;
            let near: Vec<(usize, &[f64])> = inputs.iter().map(|(slot, x)| (*slot, &x[nodes.clone()])).collect();
            let mut columns: Vec<&mut [f64]> = block[..width * count].chunks_exact_mut(count).collect();
            widest(
                #[inline(always)]
                || write_part(plan, &mut registers, &time[nodes], &near, &mut columns),
            );
            let columns: Vec<&[f64]> = columns.into_iter().map(|column| &*column).collect();
            take(&mut state, &columns[1..], columns[0])?;
        }
        Ok(state)
    };
    let parts: Vec<Result<S, E>> = (0..rows.div_ceil(part_rows)).into_par_iter().map(part).collect();
    parts.into_iter().collect()
}

#[inline(always)]
fn write_part(
    plan: &Plan,
    registers: &mut Registers<LANES>,
    time: &[f64],
    inputs: &Inputs<'_>,
    columns: &mut [&mut [f64]],
) {
    let width = columns.len();
    let mut last_time = time[0];
    // momentum and force of the previous instant
    let mut last = vec![[0.0; 2]; width];
    for first in (0..time.len()).step_by(LANES) {
        let count = LANES.min(time.len() - first);
        for (slot, x) in inputs {
            plan.set(registers, *slot, lanes(&x[first..first + count]));
        }
        plan.evaluate(Plain, registers);
        let t = lanes(&time[first..first + count]);
        let mut dt = [0.0; LANES];
        for lane in 0..LANES {
            dt[lane] = t[lane] - if lane == 0 { last_time } else { t[lane - 1] };
        }
        // the very first instant ends no row
        let skip = usize::from(first == 0);
        for (j, column) in columns.iter_mut().enumerate() {
            let (momentum, force) = (plan.output(registers, j), plan.output(registers, width + j));
            let mut row = [0.0; LANES];
            for lane in 0..LANES {
                let [m, f] = if lane == 0 { last[j] } else { [momentum[lane - 1], force[lane - 1]] };
                row[lane] = momentum[lane] - m - 0.5 * (f + force[lane]) * dt[lane];
            }
            if j == 0 {
                row = row.map(|x| -x);
            }
            last[j] = [momentum[LANES - 1], force[LANES - 1]];
            // of known length except at both ends
            match column[first.max(1) - 1..].first_chunk_mut() {
                Some(to) if skip == 0 && count == LANES => *to = row,
                _ => column[first.max(1) - 1..first + count - 1].copy_from_slice(&row[skip..count]),
            }
        }
        last_time = t[LANES - 1];
    }
}

/// Up to [`LANES`] values, the last one repeated.
#[inline(always)]
fn lanes(x: &[f64]) -> [f64; LANES] {
    match x.first_chunk() {
        Some(all) => *all,
        None => std::array::from_fn(|k| x[k.min(x.len() - 1)]),
    }
}
