//! A covariance kept as P = U D Uᵀ: it cannot lose definiteness.
//!
//! ```text
//! prediction:  P ← F P Fᵀ + W Wᵀ      Y = [F U, W] made orthogonal row by row, weights (D, 1)
//! update:      s = c P cᵀ + R,  K = P cᵀ/s,  P ← P − K Kᵀ s
//! ```
//!
//! U is unit upper triangular, D diagonal and not negative. Thornton's modified weighted Gram-Schmidt and Bierman's
//! scalar update: Bierman, *Factorization Methods for Discrete Sequential Estimation* (1977), chapters V and VI.
//! `L` covariances side by side, one a lane.

use crate::noise::Noise;
use crate::simd::{Lanes, Wide};

/// Times which a variance that is nothing underflows to 0: below 1e-113. A state that nothing drives, as the memory of a lag,
/// forgets what was not known of its beginning, and the inverse of what is left after 350 time constants is no number.
const NOTHING: f64 = 1e-210;

/// `L` factored covariances of `n` states.
#[derive(Debug, Clone)]
pub(super) struct Covariance<const L: usize> {
    n: usize,
    /// Row-major; what stands above the diagonal is read.
    u: Lanes<L>,
    d: Lanes<L>,
}

impl<const L: usize> Covariance<L> {
    /// Uncorrelated states of these variances.
    pub fn diagonal(variances: &[[f64; L]]) -> Covariance<L> {
        let n = variances.len();
        Covariance { n, u: Lanes::zeros(n * n), d: Lanes::of(variances) }
    }

    /// Diagonal of D: the variances of states that are uncorrelated.
    pub fn variances(&self) -> impl Iterator<Item = [f64; L]> {
        self.d.iter().copied()
    }

    /// P ← Y D̃ Yᵀ for Y in `work`; Y is used up.
    #[inline(always)]
    fn orthogonalise<W: Wide<L>>(&mut self, wide: W, work: &mut Work<L>) {
        let n = self.n;
        let Work { y, weights, weighted, first } = work;
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
            self.d[j] = wide.store(wide.only_where(length, known));
            let inverse = wide.only_where(wide.div(wide.splat(1.0), length), known);
            for i in 0..j {
                let other = &mut above[i * columns..(i + 1) * columns];
                let mut product = wide.splat(0.0);
                for range in filled.clone() {
                    for k in range {
                        product = wide.plus(product, wide.load(&weighted[k]), wide.load(&other[k]));
                    }
                }
                let u = wide.mul(product, inverse);
                self.u[i * n + j] = wide.store(u);
                for range in filled.clone() {
                    for k in range {
                        other[k] = wide.store(wide.sub(wide.load(&other[k]), wide.mul(u, wide.load(&row[k]))));
                    }
                }
            }
        }
    }

    /// P ← F P Fᵀ + W Wᵀ; `f` is `n × n`, `w` is `n × columns`, both row-major. `work` is room to calculate in.
    #[inline(always)]
    pub fn predict<W: Wide<L>>(&mut self, wide: W, f: &[[f64; L]], w: &[[f64; L]], work: &mut Work<L>) {
        let n = self.n;
        let columns = work.weights.len();
        let noise = columns - n;
        for (i, First { column, .. }) in work.first.iter().enumerate() {
            let row = &mut work.y[i * columns..(i + 1) * columns];
            row[..*column].fill([0.0; L]);
            for j in *column..n {
                // column j of U is 1 at j and stands above it
                let mut sum = wide.load(&f[i * n + j]);
                for k in *column..j {
                    sum = wide.plus(sum, wide.load(&f[i * n + k]), wide.load(&self.u[k * n + j]));
                }
                row[j] = wide.store(sum);
            }
            row[n..].copy_from_slice(&w[i * noise..(i + 1) * noise]);
        }
        work.weights[..n].copy_from_slice(&self.d);
        self.orthogonalise(wide, work);
    }

    /// Takes a measurement of c·x with the variance `r` into account; returns s = c P cᵀ + r and writes the gain P cᵀ/s.
    /// `at`: the states, in order, outside of which `c` is 0. A lane whose `c` is 0 stays as it is.
    #[inline(always)]
    pub fn update<W: Wide<L>>(
        &mut self,
        wide: W,
        (c, at): (&[[f64; L]], &[usize]),
        r: W::Value,
        gain: &mut [[f64; L]],
    ) -> W::Value {
        let n = self.n;
        let mut alpha = r;
        let first = at.first().copied().unwrap_or(n);
        gain[..first].fill([0.0; L]);
        // f = Uᵀc from the last on, because column j is read before it changes
        for j in first..n {
            let mut f = wide.load(&c[j]);
            for i in at.iter().take_while(|i| **i < j) {
                f = wide.plus(f, wide.load(&self.u[i * n + j]), wide.load(&c[*i]));
            }
            let d = wide.load(&self.d[j]);
            let v = wide.mul(d, f);
            let before = alpha;
            alpha = wide.plus(alpha, f, v);
            self.d[j] = wide.store(wide.mul(d, wide.div(before, alpha)));
            let lambda = wide.div(wide.neg(f), before);
            for i in 0..j {
                let u = wide.load(&self.u[i * n + j]);
                let b = wide.load(&gain[i]);
                self.u[i * n + j] = wide.store(wide.plus(u, lambda, b));
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

/// Where a row of F, and of W, begins: before, it is 0.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct First {
    /// Column of F; a row that does not begin at 0 begins at its diagonal, and so do all below it.
    pub column: usize,
    /// Column of W; it does not fall from a row to the next.
    pub source: usize,
}

/// Room in which a prediction is calculated.
#[derive(Debug)]
pub(super) struct Work<const L: usize> {
    y: Lanes<L>,
    weights: Lanes<L>,
    weighted: Lanes<L>,
    first: Vec<First>,
}

impl<const L: usize> Work<L> {
    /// For states whose rows of F and W begin at `first`, and `noise` columns of noise.
    pub fn new(first: Vec<First>, noise: usize) -> Work<L> {
        let (n, columns) = (first.len(), first.len() + noise);
        let weights = Lanes::of(&vec![[1.0; L]; columns]);
        Work { y: Lanes::zeros(n * columns), weights, weighted: Lanes::zeros(columns), first }
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.first.len()
    }
}

impl Covariance<1> {
    /// A sample of this covariance, U √D z.
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

    /// A state that is driven by nothing and decays: long after its beginning, its variance is 0, and those of others are numbers.
    #[test]
    fn exact_covariance_of_a_state_that_is_forgotten() {
        let mut p = Covariance::<2>::diagonal(&[[1.0; 2], [1e4; 2]]);
        let mut work = Work::new(vec![First::default(), First { column: 1, source: 1 }], 1);
        let (f, w) = ([[0.9; 2], [0.1; 2], [0.0; 2], [0.7; 2]], [[0.5; 2], [0.0; 2]]);
        for _ in 0..2000 {
            p.predict(Plain, &f, &w, &mut work);
            assert!((0..2).all(|lane| full(&p, lane).iter().all(|x| x.is_finite())));
        }
        let stationary = 0.25 / (1.0 - 0.81);
        assert!((full(&p, 0)[(0, 0)] - stationary).abs() < 1e-12 * stationary && full(&p, 0)[(1, 1)] == 0.0);
    }

    /// The textbook's formulas in full matrices: the same but for roundings. A lane without a measurement stays.
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
        let mut work = Work::new(first.clone(), q);
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
            // what the last sample left there does not count
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
