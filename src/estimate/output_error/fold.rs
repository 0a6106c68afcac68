//! Rows folded into a triangular factor, several problems side by side.
//!
//! ```text
//! [R; rows] = Q R′      by Householder reflections; Q is not kept
//! ```
//!
//! Golub and Van Loan, *Matrix Computations*, 4th ed., 5.1 and 6.5. Memory is O(n²) however many rows come.

/// `L` triangular factors of `n` columns that rows are folded into.
#[derive(Debug, Clone)]
pub struct Fold<const L: usize> {
    n: usize,
    /// Row-major, upper triangle.
    r: Vec<[f64; L]>,
    /// Rows that wait to be folded, row-major.
    block: Vec<[f64; L]>,
    /// Folded columns: elimination stops after this many, what is left of the rows is summed up as products.
    limit: usize,
}

/// Rows that are folded at once: enough to pay for a reflection, few enough for the nearest cache.
const BLOCK: usize = 96;

impl<const L: usize> Fold<L> {
    /// An empty factor of `n` columns.
    pub fn new(n: usize) -> Fold<L> {
        Fold { n, r: vec![[0.0; L]; n * n], block: Vec::with_capacity((BLOCK + 1) * n), limit: n }
    }

    /// Adds a row of `n` values; the block is folded when it is full.
    #[inline(always)]
    pub fn push(&mut self, row: impl Iterator<Item = [f64; L]>) {
        self.block.extend(row);
        debug_assert_eq!(self.block.len() % self.n, 0, "a row has n values");
        if self.block.len() >= BLOCK * self.n {
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
        let n = self.n;
        let rows = self.block.len() / n;
        let mut dots = vec![[0.0; L]; n];
        for j in 0..self.limit {
            let mut s = [0.0; L];
            for i in 0..rows {
                let x = self.block[i * n + j];
                for lane in 0..L {
                    s[lane] += x[lane] * x[lane];
                }
            }
            // the reflection that maps (r_jj, x) to (μ, 0): v₀ without cancellation, β = 2 v₀²/(s + v₀²)
            let diagonal = self.r[j * n + j];
            let (mut inverse, mut beta, mut mu) = ([0.0; L], [0.0; L], diagonal);
            for lane in 0..L {
                if s[lane] > 0.0 {
                    let alpha = diagonal[lane];
                    mu[lane] = (alpha * alpha + s[lane]).sqrt();
                    let v0 = if alpha <= 0.0 { alpha - mu[lane] } else { -s[lane] / (alpha + mu[lane]) };
                    beta[lane] = 2.0 * v0 * v0 / (s[lane] + v0 * v0);
                    inverse[lane] = 1.0 / v0;
                }
            }
            self.r[j * n + j] = mu;
            let (head, dots) = (&mut self.r[j * n + j + 1..(j + 1) * n], &mut dots[j + 1..]);
            dots.copy_from_slice(head);
            for row in self.block.chunks_exact_mut(n) {
                for lane in 0..L {
                    row[j][lane] *= inverse[lane];
                }
                let (v, rest) = (row[j], &row[j + 1..]);
                for (dot, x) in dots.iter_mut().zip(rest) {
                    for lane in 0..L {
                        dot[lane] += v[lane] * x[lane];
                    }
                }
            }
            for (head, dot) in head.iter_mut().zip(dots.iter_mut()) {
                for lane in 0..L {
                    dot[lane] *= beta[lane];
                    head[lane] -= dot[lane];
                }
            }
            for row in self.block.chunks_exact_mut(n) {
                let v = row[j];
                for (x, dot) in row[j + 1..].iter_mut().zip(dots.iter()) {
                    for lane in 0..L {
                        x[lane] -= v[lane] * dot[lane];
                    }
                }
            }
        }
        self.block.clear();
    }
}

impl Fold<1> {
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
