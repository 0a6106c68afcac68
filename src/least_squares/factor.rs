//! The factor of a block of rows, and the solution of a factor.
//!
//! ```text
//! [H | y] diag(2^(−e)) = Q [R z; 0 ρ]        θ̂ = R⁻¹ z,   |e| = |ρ|
//! ```
//!
//! Columns are scaled by powers of two, which is exact: factors of parts can be stacked, and
//! nothing overflows.

use std::ops::Range;

use faer::Mat;

use super::pivoted::Pivoted;
use super::scale::{greatest, length_exponent, times_power_of_two};
use super::solve::{Fit, Frame, RSquared, Scaled, dependent, outer};
use super::system::{LeastSquaresError, Names};
use super::triangle::{LANES, Triangle};
use crate::simd::widest;

/// Number of values that are folded at once, 24 KiB: they stay in the nearest cache.
pub(super) const BLOCK: usize = 3072;

/// Factor of the rows `range` of finite columns, each times `2^(−exponent)`.
pub(super) fn factor_of(columns: &[&[f64]], range: Range<usize>, exponents: &[i32], block: &mut Vec<f64>) -> Triangle {
    let mut triangle = Triangle::new(columns.len());
    let step = (BLOCK / columns.len()).next_multiple_of(LANES);
    for begin in range.clone().step_by(step) {
        let count = step.min(range.end - begin);
        let rows = count.next_multiple_of(LANES);
        block.resize(rows * columns.len(), 0.0);
        widest(
            #[inline(always)]
            || {
                for ((to, from), exponent) in block.chunks_exact_mut(rows).zip(columns).zip(exponents) {
                    scaled(to, &from[begin..begin + count], *exponent);
                }
                triangle.fold(block, rows);
            },
        );
    }
    triangle
}

/// Writes 2^(−exponent) times a column, then zeros.
#[inline(always)]
pub(super) fn scaled(to: &mut [f64], from: &[f64], exponent: i32) {
    let scale = times_power_of_two(1.0, -exponent);
    if scale.is_normal() {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = from * scale);
    } else {
        // a power beyond the range of a double is applied in two steps
        to.iter_mut().zip(from).for_each(|(to, from)| *to = times_power_of_two(*from, -exponent));
    }
    to[from.len()..].fill(0.0);
}

/// Greatest |x|, and whether all values are finite.
#[inline(always)]
pub(super) fn size(x: &[f64]) -> (f64, bool) {
    let (mut top, mut rest) = ([0.0_f64; LANES], [0.0_f64; LANES]);
    let chunks = x.chunks_exact(LANES);
    let last = chunks.remainder();
    for chunk in chunks {
        for lane in 0..LANES {
            let x = chunk[lane].abs();
            top[lane] = if x > top[lane] { x } else { top[lane] };
            rest[lane] += x * 0.0;
        }
    }
    let top = greatest(last).max(greatest(&top));
    (top, rest.iter().chain(last).all(|x| x.is_finite()))
}

/// Solves a factor of [H | y]; `constant` is the column with the same value in all rows.
pub(super) fn solve(
    triangle: &Triangle,
    exponents: &[Option<i32>],
    rows: usize,
    constant: Option<usize>,
    names: &Names,
) -> Result<Fit, LeastSquaresError> {
    let p = triangle.width() - 1;
    // columns of length 1 to 2, for which the rank is judged
    let column = |j: usize| triangle.column(j).collect::<Vec<f64>>();
    let lengths: Vec<i32> = (0..=p).map(|j| length_exponent(&column(j))).collect();
    let unit = |i: usize, j: usize| times_power_of_two(triangle.at(i, j), -lengths[j]);
    let square = Mat::from_fn(p, p, unit);
    let pivoted = Pivoted::of(square.as_ref(), rows).map_err(|found| dependent(&found, names))?;
    let response: Vec<f64> = (0..=p).map(|i| unit(i, p)).collect();
    let w = pivoted.inverse_factor();
    // a constant column reduces y to y minus its mean
    let left = match constant {
        None => response.clone(),
        Some(c) => {
            let mean =
                (0..p).map(|i| unit(i, c) * response[i]).sum::<f64>() / (0..p).map(|i| unit(i, c).powi(2)).sum::<f64>();
            (0..=p).map(|i| response[i] - mean * if i < p { unit(i, c) } else { 0.0 }).collect()
        }
    };
    let scaled = Scaled {
        coefficients: pivoted.solve(&pivoted.project(&response[..p])),
        inverse: outer(&w),
        square: response[p].powi(2),
        total: left.iter().map(|y| y * y).sum(),
        kind: if constant.is_some() { RSquared::Centred } else { RSquared::Uncentred },
        rows,
        refined: false,
    };
    let all: Vec<i32> = exponents.iter().zip(&lengths).map(|(e, l)| e.unwrap_or(0) + l).collect();
    scaled.into_fit(&pivoted, Frame { w, exponents: all[..p].to_vec(), y_exponent: all[p] }, names)
}
