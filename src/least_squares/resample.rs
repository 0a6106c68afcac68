//! Refits on resampled blocks of rows: the block bootstrap.
//!
//! ```text
//! RᵀR = Σ_b n_b R_bᵀR_b      n_b: how often block b was drawn; Σ n_b = number of blocks
//! ```
//!
//! Each block is factored once. A refit sums p (p + 3)/2 products for each block
//! ([`super::whitened`]) or, if its blocks nearly lack a direction, stacks p + 1 rows for each
//! block, times √n_b: its cost does not depend on the number of rows. Blocks longer than the memory
//! of the residuals keep their correlation: Künsch, *Annals of Statistics* 17 (1989) 1217. Draws
//! come from streams of one seed, so that they do not depend on the number of threads.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::factor::factor_of;
use super::system::{LeastSquaresError, Names, check_apart, check_shape, check_values};
use super::triangle::Triangle;
use super::whitened::Whitened;
use crate::noise::Noise;
use crate::progress::{look, tell};
use crate::simd::widest;

/// Name of this work in progress reports.
pub(crate) const REFITTING: &str = "refitting";

/// Estimates of refits.
#[derive(Debug, Clone, PartialEq)]
pub struct Draws {
    /// Estimates of all unknowns, one list for each refit.
    pub values: Vec<Vec<f64>>,
    /// Number of each of these refits.
    pub numbers: Vec<u64>,
    /// Refits that had no solution and are left out.
    pub failed: usize,
}

impl Draws {
    /// The draws of the refits with these numbers, in order.
    pub(crate) fn of(numbers: Range<u64>, found: Vec<Option<Vec<f64>>>) -> Draws {
        let count = found.len();
        let (numbers, values): (Vec<u64>, Vec<Vec<f64>>) =
            numbers.zip(found).filter_map(|(number, found)| Some((number, found?))).unzip();
        Draws { failed: count - values.len(), numbers, values }
    }

    /// Mean of unknown `k`.
    pub fn mean(&self, k: usize) -> f64 {
        self.values.iter().map(|v| v[k]).sum::<f64>() / self.values.len() as f64
    }

    /// Covariance of the unknowns `i` and `j`.
    pub fn covariance(&self, i: usize, j: usize) -> f64 {
        let (mean_i, mean_j) = (self.mean(i), self.mean(j));
        let sum: f64 = self.values.iter().map(|v| (v[i] - mean_i) * (v[j] - mean_j)).sum();
        sum / (self.values.len() as f64 - 1.0)
    }

    /// Standard deviation of unknown `k`.
    pub fn std(&self, k: usize) -> f64 {
        self.covariance(k, k).sqrt()
    }

    /// Quantile of unknown `k` at the share `level` of the draws, linear between draws; NaN without
    /// draws.
    pub fn quantile(&self, k: usize, level: f64) -> f64 {
        let mut sorted: Vec<f64> = self.values.iter().map(|v| v[k]).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
        let at = level.clamp(0.0, 1.0) * last as f64;
        let (low, part) = (at.floor() as usize, at.fract());
        sorted[low] + part * (sorted[(low + 1).min(last)] - sorted[low])
    }
}

/// A system H θ = y whose blocks of rows are factored separately.
#[derive(Debug, Clone)]
pub struct Blocks {
    factors: Vec<Triangle>,
    exponents: Vec<i32>,
}

impl Blocks {
    /// Factors blocks of `length` rows, the last one shorter; on all cores.
    ///
    /// # Errors
    /// [`LeastSquaresError`], as for the whole system; [`LeastSquaresError::TooFewBlocks`] for
    /// fewer than two blocks.
    pub fn of(h: &[&[f64]], y: &[f64], length: usize, names: &Names) -> Result<Blocks, LeastSquaresError> {
        check_shape(h, y, names)?;
        check_values(h, y, names)?;
        check_apart(h, names)?;
        let length = length.max(1);
        let count = y.len().div_ceil(length);
        if count < 2 {
            return Err(LeastSquaresError::TooFewBlocks { rows: y.len(), length });
        }
        let columns: Vec<&[f64]> = h.iter().copied().chain([y]).collect();
        let exponents: Vec<i32> = columns.iter().map(|c| super::scale::length_exponent(c)).collect();
        let range = |b: usize| b * length..((b + 1) * length).min(y.len());
        let factors = (0..count)
            .into_par_iter()
            .map_init(Vec::new, |buffer, b| factor_of(&columns, range(b), &exponents, buffer))
            .collect();
        Ok(Blocks { factors, exponents })
    }

    /// θ of `draws` refits, each on as many blocks as there are, drawn with replacement.
    pub fn bootstrap(&self, draws: usize, seed: u64) -> Draws {
        let p = self.exponents.len() - 1;
        let mut found = resample(&Triangle::new(p + 1), &self.factors, 0..draws as u64, seed);
        let unit = |j: usize| self.exponents[p] - self.exponents[j];
        for value in &mut found.values {
            for (j, x) in value.iter_mut().enumerate() {
                *x = super::scale::times_power_of_two(*x, unit(j));
            }
        }
        found
    }
}

/// The factor of `always` and of the blocks, each as often as `counts` says.
fn stacked(always: &Triangle, factors: &[Triangle], counts: &[u32], buffer: &mut Vec<f64>) -> Triangle {
    let mut triangle = always.clone();
    let drawn = || factors.iter().zip(counts).filter(|(_, n)| **n > 0).map(|(f, n)| (f64::from(*n).sqrt(), f));
    widest(
        #[inline(always)]
        || triangle.fold_all(drawn(), buffer),
    );
    triangle
}

/// Solutions of the resamplings with the numbers `draws`, for blocks with these factors of [H | y];
/// the rows of `always` are in all.
pub(crate) fn resample(always: &Triangle, factors: &[Triangle], draws: Range<u64>, seed: u64) -> Draws {
    let (done, count) = (AtomicUsize::new(0), draws.clone().count());
    let whole = stacked(always, factors, &vec![1; factors.len()], &mut Vec::new());
    let whitened = Whitened::of(whole, always, factors);
    let found: Vec<Option<Vec<f64>>> = (0..count)
        .into_par_iter()
        .map_init(Vec::new, |buffer, k| {
            look();
            let counts = drawn(factors.len(), seed, draws.start + k as u64);
            let solution = whitened.as_ref().and_then(|whitened| whitened.solution(&counts, buffer));
            let solution = solution.or_else(|| stacked(always, factors, &counts, buffer).solution());
            tell(REFITTING, done.fetch_add(1, Ordering::Relaxed) + 1, count);
            solution
        })
        .collect();
    Draws::of(draws, found)
}

/// Number of times each of `count` blocks is drawn.
fn drawn(count: usize, seed: u64, stream: u64) -> Vec<u32> {
    let mut noise = Noise::new(seed, stream);
    let mut counts = vec![0; count];
    for _ in 0..count {
        counts[noise.below(count)] += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::solve::least_squares;
    use super::*;
    use crate::progress::{Watch, watched};

    fn uniform(k: usize) -> f64 {
        (k as f64 * 12.9898).sin() * 43_758.547 % 1.0
    }

    #[test]
    fn a_refit_on_blocks_is_the_fit_of_their_rows() {
        let n = 90;
        let x: Vec<f64> = (0..n).map(|k| 0.1 * k as f64).collect();
        let one = vec![1.0; n];
        let y: Vec<f64> = (0..n).map(|k| 2.0 - 3.0 * x[k] + uniform(k)).collect();
        let blocks = Blocks::of(&[&one, &x], &y, 20, &Names::default()).unwrap();
        assert_eq!(blocks.factors.len(), 5);
        let rows: Vec<usize> = (20..40).chain(20..40).chain(80..90).collect();
        let pick = |v: &[f64]| rows.iter().map(|k| v[*k]).collect::<Vec<f64>>();
        let direct = least_squares(&[&pick(&one), &pick(&x)], &pick(&y)).unwrap();
        let factor = stacked(&Triangle::new(3), &blocks.factors, &[0, 2, 0, 0, 1], &mut Vec::new());
        let found = factor.solution().unwrap();
        for j in 0..2 {
            let unit = 2.0_f64.powi(blocks.exponents[2] - blocks.exponents[j]);
            assert!((unit * found[j] / direct.coefficients[j] - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn law_independent_noise_scatters_as_equation_14_says() {
        let n = 4_000;
        let x: Vec<f64> = (0..n).map(|k| (0.01 * k as f64).sin()).collect();
        let y: Vec<f64> = (0..n).map(|k| 2.0 * x[k] + uniform(k)).collect();
        let fit = least_squares(&[&x], &y).unwrap();
        let blocks = Blocks::of(&[&x], &y, 20, &Names::default()).unwrap();
        let told = Arc::new(AtomicUsize::new(0));
        let hear = told.clone();
        let watch = Watch::new(move |_| {
            hear.fetch_add(1, Ordering::Relaxed);
        });
        let draws = watched(&watch, || blocks.bootstrap(2_000, 1)).unwrap();
        assert_eq!((draws.values.len(), draws.failed, told.load(Ordering::Relaxed)), (2_000, 0, 2_000));
        // 200 blocks: the bootstrap's own variance scatters by √(2/200) = 10 %, its deviation by half of that
        assert!((draws.std(0) / fit.standard_errors[0] - 1.0).abs() < 0.15, "{}", draws.std(0));
        assert!((draws.mean(0) - fit.coefficients[0]).abs() < 0.2 * draws.std(0));
        let (low, high) = (draws.quantile(0, 0.025), draws.quantile(0, 0.975));
        assert!(((high - low) / (3.92 * draws.std(0)) - 1.0).abs() < 0.1);
    }

    #[test]
    fn law_draws_do_not_depend_on_threads() {
        let x: Vec<f64> = (0..300).map(uniform).collect();
        let y: Vec<f64> = (0..300).map(|k| x[k] + uniform(k + 1000)).collect();
        let blocks = Blocks::of(&[&x], &y, 7, &Names::default()).unwrap();
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| blocks.bootstrap(50, 9))
        };
        assert_eq!(with(1), with(2));
    }

    #[test]
    fn what_cannot_be_resampled_is_told() {
        let (x, y) = ([1.0, 2.0, 4.0], [1.0, 2.0, 3.0]);
        let refused = Blocks::of(&[&x], &y, 3, &Names::default()).unwrap_err();
        assert_eq!(refused, LeastSquaresError::TooFewBlocks { rows: 3, length: 3 });
        assert!(matches!(
            Blocks::of(&[&x], &[1.0, f64::NAN, 2.0], 1, &Names::default()),
            Err(LeastSquaresError::NotFinite { row: 1, .. })
        ));
    }
}
