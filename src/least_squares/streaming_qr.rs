//! Least squares of tall systems, folded block by block: memory is O(p²) for any number of rows.
//!
//! ```text
//! [H | y] = Q [R z; 0 ρ]      θ̂ = R⁻¹ z,   |e| = |ρ|,   HᵀH = RᵀR (never formed)
//! ```
//!
//! θ, its standard errors, R², rank and condition numbers all follow from R, z and ρ. Factors of
//! parts merge into that of the whole, so that parts can be folded in parallel: their borders and
//! the order of merging are fixed.

use std::ops::Range;

use rayon::prelude::*;

use super::column_monitor::ColumnMonitor;
use super::factor::{BLOCK, scaled, size, solve};
use super::scale::{exponent, times_power_of_two};
use super::solve::Fit;
use super::system::{LeastSquaresError, Names, check_finite};
use super::triangle::{LANES, Triangle};
use crate::simd::widest;

/// Rows of a part, which one thread folds.
const PART: usize = 1 << 15;

/// Number of powers of two by which a column may exceed its scale before the scale follows.
const OUTGROWN: i32 = 64;

/// A tall system that is folded into its factor.
#[derive(Debug, Clone)]
pub struct StreamingQr {
    names: Names,
    /// Columns of H, and y last, each times `2^(−exponent)`.
    triangle: Triangle,
    exponents: Vec<Option<i32>>,
    watch: ColumnMonitor,
    rows: usize,
    block: Vec<f64>,
}

impl StreamingQr {
    /// A system of `columns` unknowns without rows.
    ///
    /// # Errors
    /// [`LeastSquaresError::NoColumns`] if `columns` is 0.
    pub fn new(columns: usize, names: Names) -> Result<StreamingQr, LeastSquaresError> {
        if columns == 0 {
            return Err(LeastSquaresError::NoColumns);
        }
        let width = columns + 1;
        Ok(StreamingQr {
            names,
            triangle: Triangle::new(width),
            exponents: vec![None; width],
            watch: ColumnMonitor::new(width),
            rows: 0,
            block: Vec::new(),
        })
    }

    /// Folds further rows: `h` holds p columns, each as long as `y`.
    ///
    /// # Errors
    /// [`LeastSquaresError`] for shapes that do not fit and values that are not finite (the row
    /// counts from the first one folded); no row of the faulty block is folded.
    pub fn push(&mut self, h: &[&[f64]], y: &[f64]) -> Result<(), LeastSquaresError> {
        let width = self.triangle.width();
        if h.len() + 1 != width {
            return Err(LeastSquaresError::Width { found: h.len(), expected: width - 1 });
        }
        if let Some(j) = h.iter().position(|c| c.len() != y.len()) {
            let (found, expected) = (h[j].len(), y.len());
            return Err(LeastSquaresError::Length { column: self.names.column(j), found, expected });
        }
        let rows = (BLOCK / width).next_multiple_of(LANES);
        let mut columns: Vec<&[f64]> = Vec::with_capacity(width);
        for begin in (0..y.len()).step_by(rows) {
            let end = (begin + rows).min(y.len());
            columns.clear();
            columns.extend(h.iter().map(|c| &c[begin..end]));
            columns.push(&y[begin..end]);
            self.take(&columns)?;
        }
        Ok(())
    }

    /// Folds one block.
    fn take(&mut self, columns: &[&[f64]]) -> Result<(), LeastSquaresError> {
        let count = columns[0].len();
        for (j, column) in columns.iter().enumerate() {
            let (top, finite) = widest(
                #[inline(always)]
                || size(column),
            );
            if !finite {
                let response = j + 1 == columns.len();
                let name = || if response { self.names.response() } else { self.names.column(j) };
                check_finite(column, self.rows, name)?;
            }
            if top > 0.0 {
                self.grow(j, exponent(top));
            }
        }
        self.watch.look(columns);
        let rows = count.next_multiple_of(LANES);
        let mut block = std::mem::take(&mut self.block);
        block.resize(rows * columns.len(), 0.0);
        let (triangle, exponents) = (&mut self.triangle, &self.exponents);
        widest(
            #[inline(always)]
            || {
                for ((to, from), exponent) in block.chunks_exact_mut(rows).zip(columns).zip(exponents) {
                    scaled(to, from, exponent.unwrap_or(0));
                }
                triangle.fold(&mut block, rows);
            },
        );
        self.block = block;
        self.rows += count;
        Ok(())
    }

    /// Adapts the scale of column `j` to a value with this exponent.
    fn grow(&mut self, j: usize, exponent: i32) {
        match self.exponents[j] {
            None => self.exponents[j] = Some(exponent),
            Some(now) if exponent > now + OUTGROWN => self.rescale(j, exponent),
            Some(_) => {}
        }
    }

    fn rescale(&mut self, j: usize, exponent: i32) {
        let shift = self.exponents[j].unwrap_or(exponent) - exponent;
        self.triangle.scale_column(j, |x| times_power_of_two(x, shift));
        self.exponents[j] = Some(exponent);
    }

    /// Merges the rows that another system with the same columns has folded.
    ///
    /// # Errors
    /// [`LeastSquaresError::Width`] if it has another number of columns.
    pub fn merge(&mut self, mut other: StreamingQr) -> Result<(), LeastSquaresError> {
        let width = self.triangle.width();
        if other.triangle.width() != width {
            return Err(LeastSquaresError::Width { found: other.triangle.width() - 1, expected: width - 1 });
        }
        for j in 0..width {
            match (self.exponents[j], other.exponents[j]) {
                (Some(a), Some(b)) if a < b => self.rescale(j, b),
                (Some(a), Some(b)) if a > b => other.rescale(j, a),
                (None, Some(b)) => self.exponents[j] = Some(b),
                _ => {}
            }
        }
        let mut block = std::mem::take(&mut self.block);
        let triangle = &mut self.triangle;
        widest(
            #[inline(always)]
            || triangle.fold_all(std::iter::once((1.0, &other.triangle)), &mut block),
        );
        self.block = block;
        self.watch.merge(&other.watch);
        self.rows += other.rows;
        Ok(())
    }

    /// Folds a system in memory on all cores; the result does not depend on their number.
    ///
    /// # Errors
    /// As [`StreamingQr::push`].
    pub fn of(h: &[&[f64]], y: &[f64], names: &Names) -> Result<StreamingQr, LeastSquaresError> {
        let part = |k: usize| {
            let range = k * PART..((k + 1) * PART).min(y.len());
            let columns: Vec<&[f64]> = h.iter().map(|c| &c[range.clone()]).collect();
            let mut part = StreamingQr::new(h.len(), names.clone())?;
            part.rows = range.start;
            part.push(&columns, &y[range.clone()])?;
            part.rows = range.len();
            Ok(part)
        };
        if let Some(j) = h.iter().position(|c| c.len() != y.len()) {
            let (found, expected) = (h[j].len(), y.len());
            return Err(LeastSquaresError::Length { column: names.column(j), found, expected });
        }
        StreamingQr::merged(h.len(), names, (0..y.len().div_ceil(PART)).into_par_iter().map(part).collect())
    }

    /// Folds a system of any memory layout on all cores: `fill` writes some rows of a column of H.
    /// The result is that of [`StreamingQr::of`] to the bit.
    ///
    /// # Errors
    /// As [`StreamingQr::push`].
    pub fn of_filled(
        columns: usize,
        fill: &(impl Fn(Range<usize>, usize, &mut [f64]) + Sync),
        y: &[f64],
        names: &Names,
    ) -> Result<StreamingQr, LeastSquaresError> {
        let height = (BLOCK / (columns + 1)).next_multiple_of(LANES);
        let part = |k: usize| {
            let range = k * PART..((k + 1) * PART).min(y.len());
            let mut part = StreamingQr::new(columns, names.clone())?;
            let mut block = vec![0.0; columns * height];
            part.rows = range.start;
            for begin in range.clone().step_by(height) {
                let rows = begin..(begin + height).min(range.end);
                for (j, column) in block.chunks_exact_mut(height).enumerate() {
                    fill(rows.clone(), j, &mut column[..rows.len()]);
                }
                let filled = block.chunks_exact(height).map(|column| &column[..rows.len()]);
                let whole: Vec<&[f64]> = filled.chain([&y[rows.clone()]]).collect();
                part.take(&whole)?;
            }
            part.rows = range.len();
            Ok(part)
        };
        StreamingQr::merged(columns, names, (0..y.len().div_ceil(PART)).into_par_iter().map(part).collect())
    }

    fn merged(
        columns: usize,
        names: &Names,
        parts: Vec<Result<StreamingQr, LeastSquaresError>>,
    ) -> Result<StreamingQr, LeastSquaresError> {
        let mut whole = StreamingQr::new(columns, names.clone())?;
        for part in parts {
            whole.merge(part?)?;
        }
        Ok(whole)
    }

    /// Number of unknowns.
    pub fn columns(&self) -> usize {
        self.triangle.width() - 1
    }

    /// The same rows with the right-hand side and column `column` exchanged.
    #[must_use]
    pub fn exchanged(&self, column: usize) -> StreamingQr {
        let p = self.columns();
        let places: Vec<usize> = (0..=p)
            .map(|j| {
                if j == column {
                    p
                } else if j == p {
                    column
                } else {
                    j
                }
            })
            .collect();
        self.placed(&places, p + 1, 0)
    }

    /// The same rows times `weight`, with column j at the index `places[j]` of `width` columns; the
    /// others are 0.
    #[must_use]
    pub fn embedded(&self, places: &[usize], width: usize, weight: f64) -> StreamingQr {
        let places: Vec<usize> = places.iter().copied().chain([width]).collect();
        // the mantissa is multiplied into the rows, so that no square exceeds the range of a double
        let power = exponent(weight);
        let mut wide = self.placed(&places, width + 1, power);
        let rest = times_power_of_two(weight, -power);
        (0..=width).for_each(|j| wide.triangle.scale_column(j, |x| rest * x));
        wide
    }

    /// The same rows with the unknown of `column` held at `value`: its part moves to the right-hand
    /// side.
    ///
    /// # Errors
    /// [`LeastSquaresError::NoColumns`] if no other column is left.
    pub fn held(&self, column: usize, value: f64) -> Result<StreamingQr, LeastSquaresError> {
        let p = self.columns();
        let kept: Vec<usize> = (0..p).filter(|j| *j != column).collect();
        let names = Names { columns: kept.iter().map(|j| self.names.column(*j)).collect(), ..self.names.clone() };
        let mut held = StreamingQr::new(kept.len(), names)?;
        let alone: Vec<f64> = (0..p).map(|j| if j == column { value } else { 0.0 }).collect();
        let rest = self.residual_rows(&alone);
        let top = rest.iter().fold(0.0, |top: f64, x| top.max(x.abs()));
        held.exponents = kept.iter().map(|j| self.exponents[*j]).chain([(top > 0.0).then(|| exponent(top))]).collect();
        let scale = -held.exponents[p - 1].unwrap_or(0);
        let row = |i: usize| -> Vec<f64> {
            kept.iter().map(|j| self.triangle.at(i, *j)).chain([times_power_of_two(rest[i], scale)]).collect()
        };
        held.triangle = Triangle::of_rows(p, &(0..=p).map(row).collect::<Vec<_>>());
        held.watch = self.watch.kept(&kept);
        held.rows = self.rows;
        Ok(held)
    }

    fn placed(&self, places: &[usize], width: usize, power: i32) -> StreamingQr {
        let mut exponents = vec![None; width];
        let mut rows = vec![vec![0.0; width]; self.triangle.width()];
        for (j, place) in places.iter().enumerate() {
            exponents[*place] = self.exponents[j].map(|e| e + power);
            for (i, row) in rows.iter_mut().enumerate() {
                row[*place] = self.triangle.at(i, j);
            }
        }
        let names = (0..width - 1).map(|k| match places.iter().position(|p| *p == k) {
            Some(j) if j < self.columns() => self.names.column(j),
            _ => self.names.response(),
        });
        StreamingQr {
            names: Names { columns: names.collect(), response: None },
            triangle: Triangle::of_rows(width, &rows),
            exponents,
            watch: self.watch.placed(places, width),
            rows: self.rows,
            block: Vec::new(),
        }
    }

    /// Root mean square of y − H θ.
    pub fn residual_rms(&self, theta: &[f64]) -> f64 {
        let square: f64 = self.residual_rows(theta).iter().map(|e| e * e).sum();
        (square / self.rows.max(1) as f64).sqrt()
    }

    /// Qᵀ(y − H θ), p + 1 values.
    fn residual_rows(&self, theta: &[f64]) -> Vec<f64> {
        let p = self.columns();
        let entry = |i: usize, j: usize| times_power_of_two(self.triangle.at(i, j), self.exponents[j].unwrap_or(0));
        (0..=p).map(|i| entry(i, p) - (0..p).map(|j| entry(i, j) * theta[j]).sum::<f64>()).collect()
    }

    /// Hᵀ(y − H θ), each entry times `2^(−exponents[j])`.
    pub(super) fn score(&self, theta: &[f64], exponents: &[i32]) -> Vec<f64> {
        let left = self.residual_rows(theta);
        let scaled = |j: usize| {
            let shift = self.exponents[j].unwrap_or(0) - exponents[j];
            move |x: f64| times_power_of_two(x, shift)
        };
        (0..self.columns()).map(|j| self.triangle.column(j).zip(&left).map(|(h, e)| scaled(j)(h) * e).sum()).collect()
    }

    /// Checks that no column is zero, and no two are the same up to a factor.
    ///
    /// # Errors
    /// [`LeastSquaresError::ZeroColumn`] and [`LeastSquaresError::Proportional`].
    pub fn judge(&self) -> Result<(), LeastSquaresError> {
        self.watch.judge(&self.names)
    }

    /// The first column with the same value in all rows.
    pub(super) fn constant(&self) -> Option<usize> {
        (0..self.columns()).find(|j| self.watch.constant(*j).is_some())
    }

    /// The solution of all rows folded so far.
    ///
    /// # Errors
    /// [`LeastSquaresError`] for too few rows, zero or dependent columns, a right-hand side that
    /// does not vary, and coefficients out of range.
    pub fn fit(&self) -> Result<Fit, LeastSquaresError> {
        let (p, names) = (self.triangle.width() - 1, &self.names);
        if self.rows <= p {
            return Err(LeastSquaresError::TooFewRows { rows: self.rows, columns: names.all(p) });
        }
        self.watch.judge(names)?;
        let constant = self.constant();
        let zero = self.watch.constant(p) == Some(0.0);
        if zero || (constant.is_some() && self.watch.constant(p).is_some()) {
            return Err(LeastSquaresError::NoVariance { column: names.response(), zero });
        }
        solve(&self.triangle, &self.exponents, self.rows, constant, names)
    }
}

#[cfg(test)]
mod tests {
    use super::super::solve::{LeastSquaresOptions, RSquared, Refinement, least_squares_with};
    use super::*;

    /// Columns like those of a campaign: 1, u, u|u|, with units apart by 1e12, and a right-hand
    /// side with noise.
    fn system(n: usize) -> (Vec<Vec<f64>>, Vec<f64>) {
        let u = |k: usize| 0.5 + 0.3 * (0.021 * k as f64).sin() + 0.1 * (0.37 * k as f64).cos();
        let noise = |k: usize| (k as f64 * 12.9898).sin() * 43_758.547 % 1.0;
        let h = vec![vec![1e-6; n], (0..n).map(u).collect(), (0..n).map(|k| 1e6 * u(k) * u(k).abs()).collect()];
        let y = (0..n).map(|k| 3.0 + 2.0 * u(k) - 5.0 * u(k) * u(k).abs() + 0.01 * noise(k)).collect();
        (h, y)
    }

    fn slices(h: &[Vec<f64>]) -> Vec<&[f64]> {
        h.iter().map(Vec::as_slice).collect()
    }

    /// Both are QR of the same columns: they agree to about ε cond, here 1e-16 times 1e2, with a
    /// margin for the sums of rows.
    #[test]
    fn the_same_numbers_as_a_factorisation_in_one_piece() {
        let (h, y) = system(20_000);
        let options = LeastSquaresOptions { refinement: Refinement::Always, ..LeastSquaresOptions::default() };
        let exact = least_squares_with(&slices(&h), &y, &options).unwrap();
        let tall = StreamingQr::of(&slices(&h), &y, &Names::default()).unwrap().fit().unwrap();
        let close = |a: f64, b: f64, what: &str| assert!((a / b - 1.0).abs() < 1e-11, "{what}: {a} {b}");
        for j in 0..3 {
            close(tall.coefficients[j], exact.coefficients[j], "coefficient");
            close(tall.standard_errors[j], exact.standard_errors[j], "standard error");
            close(tall.covariance[j][0], exact.covariance[j][0], "covariance");
        }
        close(tall.residual_std, exact.residual_std, "residual");
        close(tall.r_squared, exact.r_squared, "R squared");
        close(tall.condition_number, exact.condition_number, "condition");
        close(tall.condition_number_scaled, exact.condition_number_scaled, "scaled condition");
        assert_eq!((tall.rank, tall.rows, tall.r_squared_kind), (3, 20_000, RSquared::Centred));
    }

    #[test]
    fn law_results_do_not_depend_on_threads() {
        let (h, y) = system(3 * PART + 77);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| StreamingQr::of(&slices(&h), &y, &Names::default()).unwrap().fit().unwrap())
        };
        assert_eq!(with(1), with(2));
    }

    /// A held unknown moves to the right-hand side: as in a fit of the rows without that column.
    /// Equal up to rounding.
    #[test]
    fn a_held_unknown_is_one_of_the_right_hand_side() {
        let (h, y) = system(5_000);
        let tall = StreamingQr::of(&slices(&h), &y, &Names::default()).unwrap();
        let held = tall.held(1, 2.5).unwrap();
        let rest: Vec<f64> = y.iter().zip(&h[1]).map(|(y, u)| y - 2.5 * u).collect();
        let two = [h[0].clone(), h[2].clone()];
        let straight = StreamingQr::of(&slices(&two), &rest, &Names::default()).unwrap();
        held.judge().unwrap();
        let (a, b) = (held.fit().unwrap(), straight.fit().unwrap());
        for j in 0..2 {
            assert!((a.coefficients[j] / b.coefficients[j] - 1.0).abs() < 1e-10);
            assert!((a.standard_errors[j] / b.standard_errors[j] - 1.0).abs() < 1e-10);
        }
        assert_eq!((held.rows, held.columns()), (5_000, 2));
        let last = held.held(0, 1.0).unwrap().held(0, 1.0);
        assert!(matches!(last, Err(LeastSquaresError::NoColumns)));
    }

    #[test]
    fn blocks_of_any_size_make_one_system() {
        let (h, y) = system(5_000);
        let whole = StreamingQr::of(&slices(&h), &y, &Names::default()).unwrap().fit().unwrap();
        let mut pieces = StreamingQr::new(3, Names::default()).unwrap();
        let mut begin = 0;
        for length in [1, 2, 700, 0, 31, 4_266] {
            let part: Vec<&[f64]> = h.iter().map(|c| &c[begin..begin + length]).collect();
            pieces.push(&part, &y[begin..begin + length]).unwrap();
            begin += length;
        }
        let pieces = pieces.fit().unwrap();
        assert_eq!((begin, pieces.rows), (5_000, whole.rows));
        for j in 0..3 {
            // another order of the same sums
            assert!((pieces.coefficients[j] / whole.coefficients[j] - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn scales_that_grow_on_the_way_are_followed() {
        // a column that begins at 1e-200 and ends at 1e150, beside a right-hand side twice as large
        let x: Vec<f64> = (0..400).map(|k| 10f64.powf(-200.0 + 350.0 * f64::from(k) / 399.0)).collect();
        let y: Vec<f64> = x.iter().map(|x| 2.0 * x).collect();
        let mut tall = StreamingQr::new(1, Names::default()).unwrap();
        for (x, y) in x.chunks(40).zip(y.chunks(40)) {
            tall.push(&[x], y).unwrap();
        }
        let fit = tall.fit().unwrap();
        assert!((fit.coefficients[0] - 2.0).abs() < 1e-14, "{}", fit.coefficients[0]);
    }

    #[test]
    fn what_cannot_be_solved_is_named() {
        let names = Names { columns: vec!["u".into(), "u|u|".into()], response: Some("tau_u".into()) };
        let x: Vec<f64> = (0..100).map(|k| f64::from(k) + 1.0).collect();
        let square: Vec<f64> = x.iter().map(|x| x * x).collect();
        let fit =
            |h: &[&[f64]], y: &[f64]| StreamingQr::of(h, y, &names).and_then(|t| t.fit()).unwrap_err().to_string();
        assert!(fit(&[&x, &vec![0.0; 100]], &x).contains("`u|u|` is zero"));
        assert!(fit(&[&x, &x.iter().map(|x| 3.0 * x).collect::<Vec<_>>()], &square).contains("same up to a factor"));
        assert!(fit(&[&[1.0; 100], &[4.0; 100]], &x).contains("both constant"));
        assert!(fit(&[&[1.0; 100], &x], &[4.0; 100]).contains("`tau_u` is constant"));
        assert!(fit(&[&x[..2], &square[..2]], &x[..2]).contains("2 rows for the 2 unknowns"));
        assert!(fit(&[&x[..2], &square], &x).contains("has 2 rows"));
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for at in [3, 99] {
                let mut broken = x.clone();
                broken[at] = bad;
                assert!(fit(&[&x, &broken], &square).contains(&format!("`u|u|`, row {at} ")));
            }
        }
        assert!(matches!(StreamingQr::new(0, Names::default()), Err(LeastSquaresError::NoColumns)));
        let sum: Vec<f64> = x.iter().zip(&square).map(|(a, b)| 2.0 * a - b).collect();
        let three = StreamingQr::of(&[&x, &square, &sum], &[1.0; 100], &Names::default()).unwrap().fit().unwrap_err();
        assert!(matches!(three, LeastSquaresError::Dependent { rank: 2, .. }), "{three}");
    }
}
