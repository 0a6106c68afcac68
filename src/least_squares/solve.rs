//! Linear least squares, with the figures that are needed to judge a result.
//!
//! ```text
//! θ̂ = argmin |y − H θ|²                                   Avila et al. (2013), eq. 11 to 13
//! σ_θ = √diag((HᵀH)⁻¹ σ̂²)                                 eq. 14: valid for independent residuals
//! σ̂² = |y − H θ̂|²/(n − p)                                 eq. 15
//! ```
//!
//! The method is Householder QR with pivoting on columns scaled by powers of two; HᵀH is never
//! formed. Small or badly conditioned systems are refined with residuals in twice the precision.
//! Long ones are folded block by block.

use std::ops::Range;

use faer::Mat;

use super::pivoted::{Dependence, Pivoted};
use super::refine::refine;
use super::scale::{length_exponent, times_power_of_two};
use super::streaming_qr::StreamingQr;
use super::system::{LeastSquaresError, Names, check_apart, check_shape, check_values, is_constant};

/// Number of entries above which a system is folded block by block.
const TALL: usize = 1 << 15;

/// Definition of R².
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RSquared {
    /// 1 − |e|²/Σ(y − ȳ)²: there is a constant column.
    Centred,
    /// 1 − |e|²/Σy²: there is none.
    Uncentred,
}

/// When a solution is refined with residuals in twice the precision. Refined coefficients and
/// standard errors are exact for the given doubles to the last digit; plain ones lose about log₁₀
/// cond(H) digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Refinement {
    /// If it costs little (up to 4096 entries) or gains much (scaled condition above 1e6, up to a
    /// million entries).
    #[default]
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

impl Refinement {
    fn is_due(self, entries: usize, condition_scaled: f64) -> bool {
        match self {
            Refinement::Always => true,
            Refinement::Never => false,
            Refinement::Auto => entries <= 4096 || (entries <= 1_000_000 && condition_scaled > 1e6),
        }
    }
}

/// Options of the solution.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LeastSquaresOptions {
    /// Names for messages.
    pub names: Names,
    /// Refinement.
    pub refinement: Refinement,
}

/// A solved system of `n` rows and `p` unknowns.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// θ̂, (p).
    pub coefficients: Vec<f64>,
    /// σ_θ of eq. 14, (p).
    pub standard_errors: Vec<f64>,
    /// (HᵀH)⁻¹ σ̂², (p, p). An entry outside the range of a double is infinite or 0, though its
    /// standard error is not.
    pub covariance: Vec<Vec<f64>>,
    /// σ̂ of eq. 15, unit of y.
    pub residual_std: f64,
    /// R².
    pub r_squared: f64,
    /// Definition of R².
    pub r_squared_kind: RSquared,
    /// cond(HᵀH) = cond(H)², as the paper prints it; infinite outside the range of a double.
    pub condition_number: f64,
    /// cond(H) with columns of unit length: the measure for accuracy, independent of units.
    pub condition_number_scaled: f64,
    /// Rank of H: always the number of unknowns, because a lower rank is an error.
    pub rank: usize,
    /// Number of rows.
    pub rows: usize,
    /// Whether the solution was refined.
    pub refined: bool,
    pub(super) frame: Frame,
}

/// Coordinates in which H has orthonormal columns: (HᵀH)⁻¹ = D W Wᵀ D, D = diag(2^(−eⱼ)).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Frame {
    pub w: Vec<Vec<f64>>,
    pub exponents: Vec<i32>,
    pub y_exponent: i32,
}

impl Fit {
    /// e = y − H θ̂, (n).
    ///
    /// # Errors
    /// [`LeastSquaresError`] if the shapes are not those of the fit.
    pub fn residuals(&self, h: &[&[f64]], y: &[f64]) -> Result<Vec<f64>, LeastSquaresError> {
        if h.len() != self.coefficients.len() {
            return Err(LeastSquaresError::Width { found: h.len(), expected: self.coefficients.len() });
        }
        check_shape(h, y, &Names::default())?;
        let mut residuals = y.to_vec();
        for (column, theta) in h.iter().zip(&self.coefficients) {
            for (e, x) in residuals.iter_mut().zip(*column) {
                *e -= theta * x;
            }
        }
        Ok(residuals)
    }
}

/// A solution in scaled coordinates.
pub(super) struct Scaled {
    pub coefficients: Vec<f64>,
    /// (HᵀH)⁻¹.
    pub inverse: Vec<Vec<f64>>,
    /// |e|².
    pub square: f64,
    /// Σ(y − ȳ)² or Σy².
    pub total: f64,
    pub kind: RSquared,
    pub rows: usize,
    pub refined: bool,
}

impl Scaled {
    /// Converts the solution to the units of the caller.
    pub fn into_fit(self, pivoted: &Pivoted, frame: Frame, names: &Names) -> Result<Fit, LeastSquaresError> {
        let p = self.coefficients.len();
        let unit = |j: usize, x: f64| times_power_of_two(x, frame.y_exponent - frame.exponents[j]);
        let coefficients: Vec<f64> = self.coefficients.iter().enumerate().map(|(j, x)| unit(j, *x)).collect();
        if let Some(j) = coefficients.iter().position(|x| !x.is_finite()) {
            return Err(LeastSquaresError::OutOfRange { column: names.column(j) });
        }
        let sigma = (self.square / (self.rows - p) as f64).sqrt();
        let entry = |i: usize, j: usize| unit(i, unit(j, self.inverse[i][j] * sigma * sigma));
        Ok(Fit {
            standard_errors: (0..p).map(|j| unit(j, self.inverse[j][j].sqrt() * sigma)).collect(),
            covariance: (0..p).map(|i| (0..p).map(|j| entry(i, j)).collect()).collect(),
            residual_std: times_power_of_two(sigma, frame.y_exponent),
            r_squared: 1.0 - self.square / self.total,
            r_squared_kind: self.kind,
            condition_number: pivoted.condition_raw(&frame.exponents).powi(2),
            condition_number_scaled: pivoted.condition_scaled(),
            rank: p,
            rows: self.rows,
            refined: self.refined,
            coefficients,
            frame,
        })
    }
}

/// W Wᵀ.
pub(super) fn outer(w: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum();
    w.iter().map(|a| w.iter().map(|b| product(a, b)).collect()).collect()
}

pub(super) fn dependent(found: &Dependence, names: &Names) -> LeastSquaresError {
    let others = found.others.iter().map(|j| names.column(*j)).collect();
    LeastSquaresError::Dependent { column: names.column(found.column), others, rank: found.rank }
}

/// Solves H θ = y with defaults; `h` holds the p columns of H, each of n values.
///
/// # Errors
/// [`LeastSquaresError`] for wrong shapes, too few rows, values that are not finite, zero or
/// dependent columns, a right-hand side that does not vary, and coefficients out of range.
pub fn least_squares(h: &[&[f64]], y: &[f64]) -> Result<Fit, LeastSquaresError> {
    least_squares_with(h, y, &LeastSquaresOptions::default())
}

/// Solves H θ = y; `h` holds the p columns of H, each of n values.
///
/// # Errors
/// As [`least_squares`], with the given names.
pub fn least_squares_with(h: &[&[f64]], y: &[f64], options: &LeastSquaresOptions) -> Result<Fit, LeastSquaresError> {
    let names = &options.names;
    check_shape(h, y, names)?;
    let entries = h.len() * y.len();
    if entries > TALL && options.refinement != Refinement::Always {
        let fit = StreamingQr::of(h, y, names)?.fit()?;
        if !options.refinement.is_due(entries, fit.condition_number_scaled) {
            return Ok(fit);
        }
    }
    dense_qr(h, y, options)
}

/// Solves a system by one QR of all rows.
fn dense_qr(h: &[&[f64]], y: &[f64], options: &LeastSquaresOptions) -> Result<Fit, LeastSquaresError> {
    let names = &options.names;
    check_values(h, y, names)?;
    check_apart(h, names)?;
    let exponents: Vec<i32> = h.iter().map(|c| length_exponent(c)).collect();
    let y_exponent = length_exponent(y);
    let (n, p) = (y.len(), h.len());
    let scaled = Mat::from_fn(n, p, |i, j| times_power_of_two(h[j][i], -exponents[j]));
    let response: Vec<f64> = y.iter().map(|y| times_power_of_two(*y, -y_exponent)).collect();
    let kind = if h.iter().any(|c| is_constant(c)) { RSquared::Centred } else { RSquared::Uncentred };
    let total = total_square(&response, y, kind, names)?;
    let pivoted = Pivoted::of(scaled.as_ref(), n).map_err(|found| dependent(&found, names))?;
    let w = pivoted.inverse_factor();
    let coefficients = pivoted.solve(&pivoted.project(&response));
    let square =
        (0..n).map(|i| (response[i] - (0..p).map(|j| scaled[(i, j)] * coefficients[j]).sum::<f64>()).powi(2)).sum();
    let mut solved = Scaled { coefficients, inverse: outer(&w), square, total, kind, rows: n, refined: false };
    if options.refinement.is_due(n * p, pivoted.condition_scaled())
        && let Some(better) = refine(&scaled, &response, &pivoted)
    {
        solved = Scaled {
            coefficients: better.coefficients,
            inverse: better.inverse,
            square: better.square,
            refined: true,
            ..solved
        };
    }
    solved.into_fit(&pivoted, Frame { w, exponents, y_exponent }, names)
}

/// Solves H θ = y for an H of any memory layout: `fill(rows, j, to)` writes these rows of column j.
/// Long systems are read in place, block by block.
///
/// # Errors
/// As [`least_squares_with`].
pub fn least_squares_filled(
    columns: usize,
    fill: &(impl Fn(Range<usize>, usize, &mut [f64]) + Sync),
    y: &[f64],
    options: &LeastSquaresOptions,
) -> Result<Fit, LeastSquaresError> {
    let entries = columns * y.len();
    if columns > 0 && entries > TALL && options.refinement != Refinement::Always {
        let fit = StreamingQr::of_filled(columns, fill, y, &options.names)?.fit()?;
        if !options.refinement.is_due(entries, fit.condition_number_scaled) {
            return Ok(fit);
        }
    }
    let column = |j: usize| {
        let mut values = vec![0.0; y.len()];
        fill(0..y.len(), j, &mut values);
        values
    };
    let turned: Vec<Vec<f64>> = (0..columns).map(column).collect();
    let slices: Vec<&[f64]> = turned.iter().map(Vec::as_slice).collect();
    least_squares_with(&slices, y, options)
}

/// Solves H θ = y for an H by rows, as NumPy stores it: `h` holds n·p values.
///
/// # Errors
/// As [`least_squares_with`], and [`LeastSquaresError::Width`] if `h` does not split into rows of
/// `columns` values.
pub fn least_squares_rows(
    h: &[f64],
    columns: usize,
    y: &[f64],
    options: &LeastSquaresOptions,
) -> Result<Fit, LeastSquaresError> {
    if columns == 0 {
        return Err(LeastSquaresError::NoColumns);
    }
    if !h.len().is_multiple_of(columns) {
        return Err(LeastSquaresError::Width { found: h.len(), expected: columns });
    }
    if h.len() != columns * y.len() {
        let (column, found) = (options.names.column(0), h.len() / columns);
        return Err(LeastSquaresError::Length { column, found, expected: y.len() });
    }
    let fill = |rows: Range<usize>, j: usize, to: &mut [f64]| {
        let lines = h[rows.start * columns..rows.end * columns].chunks_exact(columns);
        to.iter_mut().zip(lines).for_each(|(to, line)| *to = line[j]);
    };
    least_squares_filled(columns, &fill, y, options)
}

/// Σ(y − ȳ)² or Σy² of the scaled right-hand side.
fn total_square(scaled: &[f64], y: &[f64], kind: RSquared, names: &Names) -> Result<f64, LeastSquaresError> {
    let zero = y.iter().all(|y| *y == 0.0);
    if zero || (kind == RSquared::Centred && is_constant(y)) {
        return Err(LeastSquaresError::NoVariance { column: names.response(), zero });
    }
    let mean = match kind {
        RSquared::Centred => scaled.iter().sum::<f64>() / scaled.len() as f64,
        RSquared::Uncentred => 0.0,
    };
    // the second sum is 0 but for the rounding of the mean
    let (square, rest) = scaled.iter().fold((0.0, 0.0), |(s, r), y| (s + (y - mean).powi(2), r + (y - mean)));
    Ok(if kind == RSquared::Centred { square - rest * rest / scaled.len() as f64 } else { square })
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 5] = [0.0, 1.0, 2.0, 3.0, 4.0];
    const Y: [f64; 5] = [1.0, 3.0, 2.0, 5.0, 4.0];

    #[test]
    fn exact_line_through_five_points() {
        // by hand 1.4 + 0.8 x, Σe² = 3.6, σ² = 1.2, cov = σ² [30 −10; −10 5]/50; HᵀH has
        // eigenvalues (35 ± √1025)/2
        let fit = least_squares(&[&[1.0; 5], &X], &Y).unwrap();
        let close = |a: f64, b: f64| assert!((a - b).abs() <= 4e-15 * b.abs(), "{a} {b}");
        close(fit.coefficients[0], 1.4);
        close(fit.coefficients[1], 0.8);
        close(fit.residual_std, 1.2_f64.sqrt());
        close(fit.standard_errors[1], 0.12_f64.sqrt());
        close(fit.covariance[0][1], -0.24);
        close(fit.r_squared, 0.64);
        let root = 1025.0_f64.sqrt();
        close(fit.condition_number, (35.0 + root) / (35.0 - root));
        assert_eq!((fit.rank, fit.rows, fit.r_squared_kind), (2, 5, RSquared::Centred));
        let residuals = fit.residuals(&[&[1.0; 5], &X], &Y).unwrap();
        close(residuals.iter().map(|e| e * e).sum(), 3.6);
    }

    #[test]
    fn rows_and_columns_are_one_system() {
        let flat: Vec<f64> = X.iter().flat_map(|x| [1.0, *x]).collect();
        let options = LeastSquaresOptions::default();
        assert_eq!(least_squares_rows(&flat, 2, &Y, &options), least_squares(&[&[1.0; 5], &X], &Y));
        // long enough for several parts, the last of them broken off
        let long: Vec<f64> = (0..300_000).map(|k| f64::from(k % 977).sin() + f64::from(k) * 1e-6).collect();
        let columns: Vec<Vec<f64>> = (0..3).map(|j| long.iter().skip(j).step_by(3).copied().collect()).collect();
        let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let y: Vec<f64> = (0..100_000).map(|k| f64::from(k).cos()).collect();
        assert_eq!(least_squares_rows(&long, 3, &y, &options), least_squares(&slices, &y));
        let wrong = least_squares_rows(&flat[1..], 2, &Y, &options).unwrap_err();
        assert_eq!(wrong, LeastSquaresError::Width { found: 9, expected: 2 });
    }

    #[test]
    fn extreme_scales_keep_every_digit() {
        // 1e200 and 1e-200 are no powers of two: the columns are rounded, so is the answer
        let wide = |scale: f64, x: &[f64]| x.iter().map(|x| scale * x).collect::<Vec<f64>>();
        for (a, b, c) in [(1e200, 1e-200, 1.0), (1e-200, 1e-200, 1e-200), (1e200, 1e200, 1e200), (1.0, 1e150, 1e-150)] {
            let fit = least_squares(&[&wide(a, &[1.0; 5]), &wide(b, &X)], &wide(c, &Y)).unwrap();
            let close = |found: f64, exact: f64| assert!((found / exact - 1.0).abs() < 1e-14, "{found} {exact}");
            close(fit.coefficients[1], 0.8 * c / b);
            close(fit.standard_errors[1], 0.12_f64.sqrt() * (c / b));
            close(fit.residual_std, 1.2_f64.sqrt() * c);
            close(fit.condition_number_scaled, least_squares(&[&[1.0; 5], &X], &Y).unwrap().condition_number_scaled);
        }
        let beyond = least_squares(&[&wide(1e-200, &[1.0; 5]), &X], &wide(1e200, &Y)).unwrap_err();
        assert_eq!(beyond, LeastSquaresError::OutOfRange { column: "column 0".into() });
    }

    #[test]
    fn what_cannot_be_solved_is_named() {
        let one: &[f64] = &[1.0; 5];
        let fails = |h: &[&[f64]], y: &[f64]| least_squares(h, y).unwrap_err().to_string();
        assert_eq!(fails(&[], &Y), "there is no column: nothing to estimate");
        assert!(fails(&[one, &X[..4]], &Y).contains("`column 1` has 4 rows"));
        assert!(fails(&[one, &X], &Y[..2]).contains("has 5 rows, the right-hand side has 2"));
        assert!(fails(&[&one[..2], &X[..2]], &Y[..2]).contains("at least 3 rows"));
        assert!(fails(&[one, &[0.0; 5]], &Y).contains("`column 1` is zero"));
        assert!(fails(&[one, &[7.0; 5]], &Y).contains("both constant"));
        assert!(fails(&[&X, one], &[3.0; 5]).contains("`y` is constant"));
        assert!(fails(&[&X], &[0.0; 5]).contains("`y` is zero"));
        for bad in [f64::NAN, f64::INFINITY] {
            let mut h = X;
            h[3] = bad;
            assert!(fails(&[one, &h], &Y).contains("`column 1`, row 3"));
            assert!(fails(&[one, &X], &h).contains("`y`, row 3"));
        }
        let third: Vec<f64> = X.iter().map(|x| 3.0 * x - 2.0).collect();
        assert!(fails(&[one, &X, &third], &Y).contains("(rank 2)"));
    }
}
