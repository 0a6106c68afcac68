//! A covariance kept as P = U D Uᵀ: it cannot lose definiteness.
//!
//! ```text
//! prediction:  P ← F P Fᵀ + W Wᵀ      Y = [F U, W] made orthogonal row by row, weights (D, 1)
//! update:      s = c P cᵀ + R,  K = P cᵀ/s,  P ← P − K Kᵀ s
//! ```
//!
//! U is unit upper triangular, D diagonal and not negative. Thornton's modified weighted
//! Gram-Schmidt and Bierman's scalar update: Bierman, *Factorization Methods for Discrete
//! Sequential Estimation* (1977), chapters V and VI. `L` covariances side by side, one a lane.

use std::ops::Range;

use crate::noise::Noise;
use crate::simd::{Lanes, Wide};

/// Factor with which a variance that counts as zero underflows to 0: one below 1e-113. A state that
/// nothing drives, such as the memory of a lag, forgets the uncertainty of its initial value, and
/// after 350 time constants the inverse of the remaining variance is not a finite number.
const NOTHING: f64 = 1e-210;

/// `L` factored covariances of `n` states.
#[derive(Debug, Clone)]
pub(super) struct Covariance<const L: usize> {
    n: usize,
    /// Row-major; only elements above the diagonal are read.
    u: Lanes<L>,
    d: Lanes<L>,
}

impl<const L: usize> Covariance<L> {
    /// The covariance of uncorrelated states with these variances.
    pub fn diagonal(variances: &[[f64; L]]) -> Covariance<L> {
        let n = variances.len();
        Covariance { n, u: Lanes::zeros(n * n), d: Lanes::of(variances) }
    }

    /// Diagonal of D: the variances, if the states are uncorrelated.
    pub fn variances(&self) -> impl Iterator<Item = [f64; L]> {
        self.d.iter().copied()
    }

    /// P ← Y D̃ Yᵀ for Y in `work`, which is overwritten.
    #[inline(always)]
    fn orthogonalise<W: Wide<L>>(&mut self, wide: W, work: &mut Work<L>) {
        let n = self.n;
        let Work { y, weights, weighted, first, .. } = work;
        let (y, weights, weighted) = (&mut y[..], &weights[..], &mut weighted[..]);
        let (own_u, own_d) = (&mut self.u[..], &mut self.d[..]);
        let columns = weights.len();
        for j in (0..n).rev() {
            let (above, row) = y.split_at_mut(j * columns);
            let row = &row[..columns];
            let First { column, source } = first[j];
            let filled = [column..n, n + source..columns];
            let mut length = wide.splat(0.0);
            for range in filled.clone() {
                for k in range {
                    let x = wide.load(&row[k]);
                    let scaled = wide.mul(x, wide.load(&weights[k]));
                    weighted[k] = wide.store(scaled);
                    length = wide.plus(length, x, scaled);
                }
            }
            let known = wide.mul(length, wide.splat(NOTHING));
            own_d[j] = wide.store(wide.only_where(length, known));
            let inverse = wide.only_where(wide.div(wide.splat(1.0), length), known);
            // several rows at a time: their sums do not wait for each other
            let (mut i, mut others) = (0, above);
            while others.len() >= 4 * columns {
                let (now, rest) = others.split_at_mut(4 * columns);
                let u = against::<4, L, W>(wide, (row, weighted, inverse), &filled, now);
                (0..4).for_each(|k| own_u[(i + k) * n + j] = u[k]);
                (i, others) = (i + 4, rest);
            }
            for other in others.chunks_exact_mut(columns) {
                [own_u[i * n + j]] = against::<1, L, W>(wide, (row, weighted, inverse), &filled, other);
                i += 1;
            }
        }
    }

    /// P ← F P Fᵀ + W Wᵀ; `f` is `n × n`, `w` is `n × columns`, both row-major. `work` is scratch
    /// space.
    #[inline(always)]
    pub fn predict<W: Wide<L>>(&mut self, wide: W, f: &[[f64; L]], w: &[[f64; L]], work: &mut Work<L>) {
        let n = self.n;
        let columns = work.weights.len();
        let noise = columns - n;
        let (y, u) = (&mut work.y[..], &self.u[..]);
        for (i, filled) in work.filled.iter().enumerate() {
            let row = &mut y[i * columns..(i + 1) * columns];
            let f = &f[i * n..(i + 1) * n];
            row[..n].copy_from_slice(f);
            // column j of U is 1 at j, and nonzero otherwise only above it
            for k in filled {
                let f = wide.load(&f[*k]);
                for (to, u) in row[k + 1..n].iter_mut().zip(&u[k * n + k + 1..(k + 1) * n]) {
                    *to = wide.store(wide.plus(wide.load(to), f, wide.load(u)));
                }
            }
            row[n..].copy_from_slice(&w[i * noise..(i + 1) * noise]);
        }
        work.weights[..n].copy_from_slice(&self.d);
        self.orthogonalise(wide, work);
    }

    /// Takes a measurement of c·x with the variance `r` into account; returns s = c P cᵀ + r and
    /// writes the gain P cᵀ/s. `at` lists, in order, the states outside which `c` is 0. A lane
    /// whose `c` is 0 is not changed.
    #[inline(always)]
    pub fn update<W: Wide<L>>(
        &mut self,
        wide: W,
        (c, at): (&[[f64; L]], &[usize]),
        r: W::Value,
        gain: &mut [[f64; L]],
    ) -> W::Value {
        let n = self.n;
        let (own_u, own_d) = (&mut self.u[..], &mut self.d[..]);
        let mut alpha = r;
        let first = at.first().copied().unwrap_or(n);
        wide.clear(&mut gain[..first]);
        // f = Uᵀc, element by element: column j is read for f before it changes
        for j in first..n {
            let mut f = wide.load(&c[j]);
            for i in at.iter().take_while(|i| **i < j) {
                f = wide.plus(f, wide.load(&own_u[i * n + j]), wide.load(&c[*i]));
            }
            let d = wide.load(&own_d[j]);
            let v = wide.mul(d, f);
            let before = alpha;
            alpha = wide.plus(alpha, f, v);
            own_d[j] = wide.store(wide.mul(d, wide.div(before, alpha)));
            let lambda = wide.div(wide.neg(f), before);
            for i in 0..j {
                let u = wide.load(&own_u[i * n + j]);
                let b = wide.load(&gain[i]);
                own_u[i * n + j] = wide.store(wide.plus(u, lambda, b));
                gain[i] = wide.store(wide.plus(b, u, v));
            }
            gain[j] = wide.store(v);
        }
        let inverse = wide.div(wide.splat(1.0), alpha);
        for k in gain[..n].iter_mut() {
            *k = wide.store(wide.mul(wide.load(k), inverse));
        }
        alpha
    }

    /// Column `j` of P.
    #[inline(always)]
    pub fn column<W: Wide<L>>(&self, wide: W, j: usize, to: &mut [[f64; L]]) {
        let n = self.n;
        // U has 1 on its diagonal
        for (i, to) in to.iter_mut().enumerate() {
            let own = i.max(j);
            let mut sum = wide.load(&self.d[own]);
            if own > i {
                sum = wide.mul(sum, wide.load(&self.u[i * n + own]));
            }
            if own > j {
                sum = wide.mul(sum, wide.load(&self.u[j * n + own]));
            }
            for k in own + 1..n {
                let weighted = wide.mul(wide.load(&self.u[i * n + k]), wide.load(&self.d[k]));
                sum = wide.plus(sum, weighted, wide.load(&self.u[j * n + k]));
            }
            *to = wide.store(sum);
        }
    }

    /// c P cᵀ
    #[inline(always)]
    pub fn variance<W: Wide<L>>(&self, wide: W, c: &[[f64; L]]) -> W::Value {
        let n = self.n;
        let mut sum = wide.splat(0.0);
        for j in 0..n {
            let mut f = wide.load(&c[j]);
            for i in 0..j {
                f = wide.plus(f, wide.load(&self.u[i * n + j]), wide.load(&c[i]));
            }
            sum = wide.plus(sum, wide.mul(f, f), wide.load(&self.d[j]));
        }
        sum
    }
}

/// Makes `N` rows of Y orthogonal to `row`, and returns the coefficient of each:
/// u = ⟨weighted, other⟩/length, other ← other − u row.
#[inline(always)]
fn against<const N: usize, const L: usize, W: Wide<L>>(
    wide: W,
    (row, weighted, inverse): (&[[f64; L]], &[[f64; L]], W::Value),
    filled: &[Range<usize>; 2],
    others: &mut [[f64; L]],
) -> [[f64; L]; N] {
    let columns = row.len();
    let mut u = [wide.splat(0.0); N];
    for range in filled {
        for k in range.clone() {
            let weighted = wide.load(&weighted[k]);
            for i in 0..N {
                u[i] = wide.plus(u[i], weighted, wide.load(&others[i * columns + k]));
            }
        }
    }
    for i in 0..N {
        u[i] = wide.mul(u[i], inverse);
    }
    for range in filled {
        for k in range.clone() {
            let row = wide.load(&row[k]);
            for i in 0..N {
                let other = &mut others[i * columns + k];
                *other = wide.store(wide.sub(wide.load(other), wide.mul(u[i], row)));
            }
        }
    }
    let mut left = [[0.0; L]; N];
    for i in 0..N {
        left[i] = wide.store(u[i]);
    }
    left
}

/// First element of a row of F, and of W, that may be nonzero.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct First {
    /// Column of F. A row that does not begin at 0 begins at its diagonal, and so do all rows below
    /// it.
    pub column: usize,
    /// Column of W; it does not decrease from one row to the next.
    pub source: usize,
}

/// Work space of a prediction.
#[derive(Debug)]
pub(super) struct Work<const L: usize> {
    y: Lanes<L>,
    weights: Lanes<L>,
    weighted: Lanes<L>,
    first: Vec<First>,
    filled: Vec<Vec<usize>>,
}

impl<const L: usize> Work<L> {
    /// For states whose rows of F and W begin at `first`, and `noise` columns of noise; `filled`
    /// gives, in order, the columns in which each row of F may be nonzero.
    pub fn new(first: Vec<First>, filled: Vec<Vec<usize>>, noise: usize) -> Work<L> {
        let (n, columns) = (first.len(), first.len() + noise);
        let weights = Lanes::of(&vec![[1.0; L]; columns]);
        Work { y: Lanes::zeros(n * columns), weights, weighted: Lanes::zeros(columns), first, filled }
    }

    /// Columns in which row `i` of F may be nonzero.
    #[inline(always)]
    pub fn filled(&self, i: usize) -> &[usize] {
        &self.filled[i]
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.first.len()
    }
}

impl Covariance<1> {
    /// A random draw from this covariance, U √D z.
    pub fn drawn(&self, noise: &mut Noise) -> Vec<f64> {
        let z: Vec<f64> = self.d.iter().map(|d| d[0].max(0.0).sqrt() * noise.normal()).collect();
        (0..self.n).map(|i| z[i] + (i + 1..self.n).map(|j| self.u[i * self.n + j][0] * z[j]).sum::<f64>()).collect()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::simd::Plain;

    fn full(p: &Covariance<2>, lane: usize) -> DMatrix<f64> {
        let n = p.n;
        let u = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Equal => 1.0,
            std::cmp::Ordering::Less => p.u[i * n + j][lane],
            std::cmp::Ordering::Greater => 0.0,
        });
        let d = DMatrix::from_diagonal(&DVector::from_fn(n, |i, _| p.d[i][lane]));
        &u * d * u.transpose()
    }

    /// A state that decays and that nothing drives: long after its beginning, its variance is 0,
    /// and those of other states are finite.
    #[test]
    fn exact_covariance_of_a_state_that_is_forgotten() {
        let mut p = Covariance::<2>::diagonal(&[[1.0; 2], [1e4; 2]]);
        let first = vec![First::default(), First { column: 1, source: 1 }];
        let mut work = Work::new(first, vec![vec![0, 1], vec![1]], 1);
        let (f, w) = ([[0.9; 2], [0.1; 2], [0.0; 2], [0.7; 2]], [[0.5; 2], [0.0; 2]]);
        for _ in 0..2000 {
            p.predict(Plain, &f, &w, &mut work);
            assert!((0..2).all(|lane| full(&p, lane).iter().all(|x| x.is_finite())));
        }
        let stationary = 0.25 / (1.0 - 0.81);
        assert!((full(&p, 0)[(0, 0)] - stationary).abs() < 1e-12 * stationary && full(&p, 0)[(1, 1)] == 0.0);
    }

    /// The textbook formulas with full matrices, equal except for rounding. A lane without a
    /// measurement is not changed.
    #[test]
    fn exact_covariances_of_prediction_and_update() {
        let (n, q) = (4, 3);
        let mut p = Covariance::<2>::diagonal(&[[1.0, 0.0], [0.5, 2.0], [3.0, 1.0], [0.1, 0.2]]);
        // the last two states are processes with sources of their own
        let process = |column, source| First { column, source };
        let first = vec![First::default(), First::default(), process(2, 1), process(3, 2)];
        let dense = |row: usize, column: usize| first[row].column == 0 || row == column;
        let value = |k: usize| [((k * 7) % 5) as f64 - 1.5, ((k * 3) % 7) as f64 * 0.3];
        let f: Vec<[f64; 2]> = (0..n * n).map(|k| if dense(k / n, k % n) { value(k) } else { [0.0; 2] }).collect();
        let value = |k: usize| [(1 + (k * 5) % 3) as f64 * 0.2, ((k * 2) % 5) as f64 * 0.1];
        let driven = |k: usize| k % q >= first[k / q].source;
        let w: Vec<[f64; 2]> = (0..n * q).map(|k| if driven(k) { value(k) } else { [0.0; 2] }).collect();
        let filled = (0..n).map(|row| (0..n).filter(|column| dense(row, *column)).collect()).collect();
        let mut work = Work::new(first.clone(), filled, q);
        let mut exact: Vec<DMatrix<f64>> = (0..2).map(|lane| full(&p, lane)).collect();
        for step in 0..5 {
            p.predict(Plain, &f, &w, &mut work);
            for (lane, exact) in exact.iter_mut().enumerate() {
                let f = DMatrix::from_fn(n, n, |i, j| f[i * n + j][lane]);
                let w = DMatrix::from_fn(n, q, |i, j| w[i * q + j][lane]);
                *exact = &f * &*exact * f.transpose() + &w * w.transpose();
                assert!((full(&p, lane) - &*exact).norm() < 1e-12 * exact.norm(), "{step} {lane}");
            }
            let mut column = vec![[0.0; 2]; n];
            for j in 0..n {
                p.column(Plain, j, &mut column);
                assert!(
                    (0..n).all(|i| (column[i][0] - exact[0][(i, j)]).abs() < 1e-12 * exact[0].norm()),
                    "{step} {j}"
                );
            }
            let (c, at) = match step % 2 {
                0 => ([[1.0, 0.0], [0.0, 0.0], [-0.4, 0.0], [0.2, 0.0]], &[0, 2, 3][..]),
                _ => ([[0.0, 0.0], [0.7, 0.0], [0.0, 0.0], [0.2, 0.0]], &[1, 3][..]),
            };
            // what the last sample left there has no influence
            let mut gain = vec![[9.0; 2]; n];
            let told = p.variance(Plain, &c);
            let s = p.update(Plain, (&c, at), [0.3, 1.0], &mut gain);
            let row = DVector::from_fn(n, |i, _| c[i][0]);
            let variance = (row.transpose() * &exact[0] * &row)[0] + 0.3;
            let k = &exact[0] * &row / variance;
            assert!((s[0] - variance).abs() < 1e-12 * variance && (told[0] + 0.3 - variance).abs() < 1e-12 * variance);
            exact[0] = &exact[0] - &k * k.transpose() * variance;
            for i in 0..n {
                assert!((gain[i][0] - k[i]).abs() < 1e-12 * k.norm() && gain[i][1] == 0.0);
            }
            for (lane, exact) in exact.iter().enumerate() {
                assert!((full(&p, lane) - exact).norm() < 1e-11 * exact.norm(), "{step} {lane}");
            }
        }
    }
}
