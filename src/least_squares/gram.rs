//! Products of the columns of a tall system in twice the precision, and what follows from them to the last digit.
//!
//! ```text
//! G = [H | y]ᵀ [H | y]        N x = b  with  N = HᵀH, b = Hᵀy:  x ← x + (HᵀH)⁻¹ (b − N x),   |e|² = yᵀy − xᵀ(b + (b − N x))
//! ```
//!
//! A product of two doubles and its rounding are both summed (Ogita, Rump and Oishi, *SIAM J. Sci. Comput.* 26 (2005)
//! 1955), in one pass over the rows. N squares the condition of H, so that x is right to about 32 − 2 log₁₀ cond(H)
//! digits: more than a double holds while cond(H) is below [`WELL_CONDITIONED`]. Corrections come from the QR at hand.

use std::ops::Range;

use rayon::prelude::*;

use super::double_double::{DoubleDouble, split};
use super::factor::scaled;
use super::solve::Fit;
use crate::simd::widest;

/// cond(H), columns of unit length, up to which the products determine the solution to the last digit.
pub(super) const WELL_CONDITIONED: f64 = 1e6;

/// Rows of a part, summed by one thread.
const PART: usize = 1 << 15;

/// Sums that run side by side.
const LANES: usize = 16;

/// Rows that are split and multiplied while they are near.
const BLOCK: usize = 256;

/// Corrections at most; each gains −log₁₀(ε cond²) digits, 4 or more.
const STEPS: usize = 12;

/// A symmetric matrix of products, (p + 1)².
#[derive(Debug, Clone)]
pub struct Gram(Vec<Vec<DoubleDouble>>);

/// Sums of one pair of columns in lanes: rounded, and what the rounding left.
type Sums = [[f64; LANES]; 2];

/// Sums on their way into a [`Gram`], part by part.
#[derive(Debug, Clone)]
pub struct Products {
    sums: Vec<Sums>,
    width: usize,
}

impl Products {
    /// No row yet of `width` columns, the right-hand side among them.
    pub fn new(width: usize) -> Products {
        Products { sums: vec![[[0.0; LANES]; 2]; width * (width + 1) / 2], width }
    }

    /// Takes rows in, scaled as `fit` has found their columns to be.
    pub fn add(&mut self, h: &[&[f64]], y: &[f64], fit: &Fit) {
        let columns: Vec<&[f64]> = h.iter().copied().chain([y]).collect();
        self.take(&columns, &fit.all_exponents(), 0..y.len());
    }

    fn take(&mut self, columns: &[&[f64]], exponents: &[i32], rows: Range<usize>) {
        // values of a block and their halves
        let mut blocks = [0, 1, 2].map(|_| vec![0.0; BLOCK * self.width]);
        for begin in rows.clone().step_by(BLOCK) {
            let end = (begin + BLOCK).min(rows.end);
            widest(
                #[inline(always)]
                || block(columns, exponents, begin..end, &mut blocks, &mut self.sums),
            );
        }
    }

    /// All parts together, in their order.
    pub fn merged(parts: Vec<Products>) -> Gram {
        let width = parts.first().map_or(0, |part| part.width);
        let mut all = vec![vec![DoubleDouble::default(); width]; width];
        for part in parts {
            let mut sums = part.sums.iter().map(|s| {
                let all =
                    s[0].iter().zip(&s[1]).map(|(sum, rest)| DoubleDouble::from(*sum) + DoubleDouble::from(*rest));
                all.fold(DoubleDouble::default(), |a, b| a + b)
            });
            for i in 0..width {
                for (j, sum) in (i..width).zip(&mut sums) {
                    all[i][j] = all[i][j] + sum;
                    all[j][i] = all[i][j];
                }
            }
        }
        Gram(all)
    }
}

impl Gram {
    /// Of columns times `2^(−exponent)`; on all cores, the result does not depend on their number.
    pub(super) fn of(columns: &[&[f64]], exponents: &[i32]) -> Gram {
        let (rows, width) = (columns[0].len(), columns.len());
        let part = |k: usize| {
            let mut products = Products::new(width);
            products.take(columns, exponents, k * PART..((k + 1) * PART).min(rows));
            products
        };
        Products::merged((0..rows.div_ceil(PART)).into_par_iter().map(part).collect())
    }

    /// Number of unknowns.
    fn unknowns(&self) -> usize {
        self.0.len() - 1
    }

    /// Solves N x = b; `correct` solves it to some digits. `None` when corrections do not shrink.
    fn solve(
        &self,
        b: &[DoubleDouble],
        correct: &impl Fn(&[f64]) -> Vec<f64>,
    ) -> Option<(Vec<DoubleDouble>, Vec<DoubleDouble>)> {
        let p = self.unknowns();
        let mut x = vec![DoubleDouble::default(); p];
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let left: Vec<DoubleDouble> =
                (0..p).map(|i| (0..p).fold(b[i], |sum, j| sum - self.0[i][j] * x[j])).collect();
            let dx = correct(&left.iter().map(|x| x.value()).collect::<Vec<_>>());
            let top = x.iter().fold(0.0, |m: f64, x| m.max(x.value().abs()));
            let mut size = 0.0_f64;
            for (x, d) in x.iter_mut().zip(&dx) {
                *x = *x + DoubleDouble::from(*d);
                // one that is 0 has no relative error: 2⁻⁴⁰ of the greatest is the least size counted
                let floor = 2.0_f64.powi(-40) * top.max(x.value().abs());
                size = size.max(if *d == 0.0 { 0.0 } else { d.abs() / x.value().abs().max(floor) });
            }
            if size < 2.0_f64.powi(-60) {
                return Some((x, left));
            }
            if !size.is_finite() || size > 0.5 * last {
                return None;
            }
            last = size;
        }
        None
    }

    /// Coefficients, (HᵀH)⁻¹ and |y − Hx|²; `correct` is a multiplication by (HᵀH)⁻¹ to some digits. `None` when the
    /// products do not determine them.
    pub(super) fn refined(&self, correct: impl Fn(&[f64]) -> Vec<f64>) -> Option<(Vec<f64>, Vec<Vec<f64>>, f64)> {
        let p = self.unknowns();
        let b: Vec<DoubleDouble> = (0..p).map(|i| self.0[i][p]).collect();
        let (x, left) = self.solve(&b, &correct)?;
        // yᵀy − xᵀb − xᵀ(b − N x): errors of x enter squared
        let square = (0..p).fold(self.0[p][p], |sum, i| sum - x[i] * (b[i] + left[i]));
        // what is left of y must stand above the rounding of its square by more digits than a double has
        if square.value() <= 1e-12 * self.0[p][p].value() {
            return None;
        }
        let mut inverse = Vec::with_capacity(p);
        for j in 0..p {
            let unit: Vec<DoubleDouble> = (0..p).map(|i| DoubleDouble::from(f64::from(u8::from(i == j)))).collect();
            inverse.push(self.solve(&unit, &correct)?.0.iter().map(|x| x.value()).collect());
        }
        Some((x.iter().map(|x| x.value()).collect(), inverse, square.value()))
    }

    /// Σy², or Σ(y − ȳ)² where column `constant` holds one value in all rows.
    pub(super) fn total(&self, constant: Option<usize>) -> f64 {
        let p = self.unknowns();
        let square = self.0[p][p];
        match constant {
            None => square.value(),
            Some(c) => {
                let (along, length) = (self.0[c][p], self.0[c][c].value());
                // (cᵀy)²/cᵀc to some 30 digits: a quotient and what it leaves
                let first = along.value() / length;
                let rest = (along - self.0[c][c] * first).value() / length;
                let mean = DoubleDouble::from(first) + DoubleDouble::from(rest);
                (square - along * mean).value()
            }
        }
    }
}

/// Adds the products of a block of rows.
#[inline(always)]
fn block<'a>(
    columns: &[&[f64]],
    exponents: &[i32],
    rows: Range<usize>,
    [values, high, low]: &'a mut [Vec<f64>; 3],
    sums: &mut [Sums],
) {
    let height = rows.len().next_multiple_of(LANES);
    for (j, (column, exponent)) in columns.iter().zip(exponents).enumerate() {
        let at = j * BLOCK..j * BLOCK + height;
        scaled(&mut values[at.clone()], &column[rows.clone()], *exponent);
        let halves = high[at.clone()].iter_mut().zip(&mut low[at.clone()]);
        for (x, (high, low)) in values[at].iter().zip(halves) {
            (*high, *low) = split(*x);
        }
    }
    let (values, high, low) = (&*values, &*high, &*low);
    let mut sums = sums.iter_mut();
    for i in 0..columns.len() {
        for (j, sums) in (i..columns.len()).zip(&mut sums) {
            let (a, b) = (i * BLOCK..i * BLOCK + height, j * BLOCK..j * BLOCK + height);
            let chunks = |x: &'a [f64], at: &Range<usize>| x[at.clone()].as_chunks::<LANES>().0.iter();
            let first = chunks(values, &a).zip(chunks(high, &a)).zip(chunks(low, &a));
            let second = chunks(values, &b).zip(chunks(high, &b)).zip(chunks(low, &b));
            let [mut sum, mut rest] = *sums;
            for (((a, a1), a2), ((b, b1), b2)) in first.zip(second) {
                for l in 0..LANES {
                    let p = a[l] * b[l];
                    let e = ((a1[l] * b1[l] - p) + a1[l] * b2[l] + a2[l] * b1[l]) + a2[l] * b2[l];
                    let s = sum[l] + p;
                    let t = s - sum[l];
                    rest[l] += ((sum[l] - (s - t)) + (p - t)) + e;
                    sum[l] = s;
                }
            }
            *sums = [sum, rest];
        }
    }
}
