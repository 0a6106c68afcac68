//! Rows folded into a triangular factor, several problems side by side.
//!
//! ```text
//! [R; rows] = Q R′      by Householder reflections; Q is not kept
//! ```
//!
//! Golub and Van Loan, *Matrix Computations*, 4th ed., 5.1 and 6.5. Memory is O(n²) however many rows come.

use crate::simd::{Lanes, Plain, Wide};

/// `L` triangular factors of `n` columns, into which rows are folded.
#[derive(Debug, Clone)]
pub struct Fold<const L: usize, W = Plain> {
    wide: W,
    n: usize,
    /// Row-major, upper triangle; the diagonal is not negative.
    r: Lanes<L>,
    /// Rows that wait to be folded, column by column, with room for a block in each column.
    block: Lanes<L>,
    /// Number of rows that wait.
    rows: usize,
}

/// Rows that are folded at once: enough to pay for a reflection, few enough to keep five columns in
/// the nearest cache.
const BLOCK: usize = 64;

impl<const L: usize> Fold<L> {
    /// An empty factor of `n` columns.
    pub fn new(n: usize) -> Fold<L> {
        Fold::with(Plain, n)
    }
}

impl<const L: usize, W: Wide<L>> Fold<L, W> {
    /// An empty factor of `n` columns that is worked on in these registers.
    pub fn with(wide: W, n: usize) -> Fold<L, W> {
        Fold { wide, n, r: Lanes::zeros(n * n), block: Lanes::zeros(BLOCK * n), rows: 0 }
    }

    /// Adds a row of `n` values; the block is folded when it is full.
    #[inline(always)]
    pub fn push(&mut self, row: impl Iterator<Item = [f64; L]>) {
        let mut count = 0;
        for (column, value) in self.block.chunks_exact_mut(BLOCK).zip(row) {
            column[self.rows] = value;
            count += 1;
        }
        debug_assert_eq!(count, self.n, "a row has n values");
        self.rows += 1;
        if self.rows == BLOCK {
            self.fold();
        }
    }

    /// Element (i, j) of the factor.
    #[inline(always)]
    pub fn at(&self, i: usize, j: usize) -> [f64; L] {
        self.r[i * self.n + j]
    }

    /// Folds the rows that wait.
    #[inline(always)]
    pub fn fold(&mut self) {
        let (n, wide) = (self.n, self.wide);
        for j in 0..n {
            let (until, after) = self.block.split_at_mut((j + 1) * BLOCK);
            let v = &mut until[j * BLOCK..][..self.rows];
            let s = square(wide, v);
            // the reflection that maps (r_jj, x) to (μ, 0): v₀ without cancellation,
            // β = 2 v₀²/(s + v₀²); none if there is nothing to map
            let (alpha, two) = (wide.load(&self.r[j * n + j]), wide.splat(2.0));
            let mu = wide.sqrt(wide.plus(s, alpha, alpha));
            let v0 = wide.div(s, wide.sub(wide.splat(0.0), wide.add(alpha, mu)));
            let square = wide.mul(v0, v0);
            let beta = wide.only_where(wide.div(wide.mul(two, square), wide.add(s, square)), s);
            let inverse = wide.only_where(wide.div(wide.splat(1.0), v0), s);
            self.r[j * n + j] = wide.store(mu);
            v.iter_mut().for_each(|x| *x = wide.store(wide.mul(wide.load(x), inverse)));
            let mut heads = &mut self.r[j * n + j + 1..(j + 1) * n];
            let mut columns = after;
            while heads.len() >= 4 {
                let (now, rest) = columns.split_at_mut(4 * BLOCK);
                let (head, others) = heads.split_at_mut(4);
                reflect::<4, L, W>(wide, v, beta, head, now);
                (columns, heads) = (rest, others);
            }
            for (head, column) in heads.as_chunks_mut::<1>().0.iter_mut().zip(columns.chunks_exact_mut(BLOCK)) {
                reflect::<1, L, W>(wide, v, beta, head, column);
            }
        }
        self.rows = 0;
    }
}

/// Σ x²
#[inline(always)]
fn square<const L: usize, W: Wide<L>>(wide: W, x: &[[f64; L]]) -> W::Value {
    // sums that do not wait for each other
    let (four, rest) = x.as_chunks::<4>();
    let mut sums = [wide.splat(0.0); 4];
    for x in four {
        for k in 0..4 {
            let x = wide.load(&x[k]);
            sums[k] = wide.plus(sums[k], x, x);
        }
    }
    let mut sum = wide.add(wide.add(sums[0], sums[1]), wide.add(sums[2], sums[3]));
    for x in rest {
        let x = wide.load(x);
        sum = wide.plus(sum, x, x);
    }
    sum
}

/// Applies the reflection at (1, v) to `K` columns, each with its element of the factor.
#[inline(always)]
fn reflect<const K: usize, const L: usize, W: Wide<L>>(
    wide: W,
    v: &[[f64; L]],
    beta: W::Value,
    head: &mut [[f64; L]],
    columns: &mut [[f64; L]],
) {
    let mut dots = [wide.splat(0.0); K];
    for k in 0..K {
        dots[k] = wide.load(&head[k]);
    }
    let rows = v.len();
    for (row, v) in v.iter().enumerate() {
        let v = wide.load(v);
        for k in 0..K {
            dots[k] = wide.plus(dots[k], v, wide.load(&columns[k * BLOCK..][..rows][row]));
        }
    }
    for k in 0..K {
        dots[k] = wide.mul(dots[k], beta);
        head[k] = wide.store(wide.sub(wide.load(&head[k]), dots[k]));
        for (x, v) in columns[k * BLOCK..][..rows].iter_mut().zip(v) {
            *x = wide.store(wide.sub(wide.load(x), wide.mul(wide.load(v), dots[k])));
        }
    }
}

impl Fold<1> {
    /// Adds to element (i, j) of the factor.
    pub fn add(&mut self, i: usize, j: usize, more: f64) {
        self.r[i * self.n + j][0] += more;
    }

    /// Solves R x = b in the leading `n − 1` columns, b the last column; 0 for a column without information.
    pub fn solve(&self) -> Vec<f64> {
        let p = self.n - 1;
        let mut x = vec![0.0; p];
        for i in (0..p).rev() {
            let sum: f64 = (i + 1..p).map(|j| self.at(i, j)[0] * x[j]).sum();
            let pivot = self.at(i, i)[0];
            x[i] = if pivot == 0.0 { 0.0 } else { (self.at(i, p)[0] - sum) / pivot };
        }
        x
    }

    /// Inverse of the leading `p × p` triangle, row-major; `None` when a pivot is 0.
    pub fn inverse(&self, p: usize) -> Option<Vec<f64>> {
        let mut inverse = vec![0.0; p * p];
        for column in 0..p {
            for i in (0..=column).rev() {
                let pivot = self.at(i, i)[0];
                if pivot == 0.0 {
                    return None;
                }
                let sum: f64 = (i + 1..=column).map(|j| self.at(i, j)[0] * inverse[j * p + column]).sum();
                inverse[i * p + column] = (f64::from(u8::from(i == column)) - sum) / pivot;
            }
        }
        Some(inverse)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A factor of well-conditioned rows reproduces RᵀR = HᵀH to rounding.
    #[test]
    fn law_factor_keeps_all_products() {
        let n = 4;
        let rows: Vec<[f64; 4]> =
            (0..333).map(|k| std::array::from_fn(|j| ((k * 7 + j * 13 + k * j) % 17) as f64 - 8.0)).collect();
        let mut fold = Fold::<2>::new(n);
        for row in &rows {
            fold.push(row.iter().map(|x| [*x, 2.0 * x]));
        }
        fold.fold();
        for a in 0..n {
            for b in 0..n {
                let exact: f64 = rows.iter().map(|r| r[a] * r[b]).sum();
                let found: f64 = (0..n).filter(|i| *i <= a.min(b)).map(|i| fold.at(i, a)[0] * fold.at(i, b)[0]).sum();
                assert!((exact - found).abs() < 1e-10 * 333.0 * 64.0, "{a} {b}: {exact} {found}");
            }
        }
    }

    #[test]
    fn exact_solution_of_a_consistent_system() {
        let mut fold = Fold::<1>::new(3);
        for k in 0..50 {
            let (a, b) = (f64::from(k) - 20.0, f64::from(k % 7));
            fold.push([a, b, 3.0 * a - 0.5 * b].into_iter().map(|x| [x]));
        }
        fold.fold();
        let x = fold.solve();
        assert!((x[0] - 3.0).abs() < 1e-13 && (x[1] + 0.5).abs() < 1e-13);
        let inverse = fold.inverse(2).unwrap();
        assert!((inverse[0] * fold.at(0, 0)[0] - 1.0).abs() < 1e-15);
    }
}
