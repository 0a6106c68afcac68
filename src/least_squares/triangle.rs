//! A triangular factor into which blocks of rows are folded.
//!
//! ```text
//! [R; X] = Q R'      by Householder reflections, column by column; Q is not kept
//! ```
//!
//! Golub and Van Loan, *Matrix Computations*, 4th ed., 5.1 and 6.5. Blocks are stored by columns,
//! and sums run in [`LANES`] lanes in a fixed order: the results are the same on every machine.

/// Number of sums that run side by side; the rows of a block are a multiple of it.
pub(super) const LANES: usize = 32;

/// Least |x|² that is folded: with columns of size near 1, smaller ones are below all rounding.
const LEAST_SQUARE: f64 = 1e-290;

/// Least diagonal of R relative to its column: a smaller one is rounding.
const LEAST_PIVOT: f64 = 1e-13;

/// R of `n` columns.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Triangle {
    n: usize,
    /// Row-major; 0 below the diagonal.
    r: Vec<f64>,
}

impl Triangle {
    /// The factor of no rows.
    pub fn new(n: usize) -> Triangle {
        Triangle { n, r: vec![0.0; n * n] }
    }

    /// The factor of a few rows of `n` values of size near 1.
    pub fn of_rows(n: usize, rows: &[Vec<f64>]) -> Triangle {
        let mut triangle = Triangle::new(n);
        let height = rows.len().next_multiple_of(LANES);
        let mut block = vec![0.0; height * n];
        for (i, row) in rows.iter().enumerate() {
            for (j, x) in row.iter().enumerate() {
                block[j * height + i] = *x;
            }
        }
        if height > 0 {
            triangle.fold(&mut block, height);
        }
        triangle
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.n
    }

    /// Element (i, j).
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.r[i * self.n + j]
    }

    /// Column `j`, n values.
    pub fn column(&self, j: usize) -> impl Iterator<Item = f64> + '_ {
        self.r.iter().skip(j).step_by(self.n).copied()
    }

    /// Multiplies column `j`.
    pub fn scale_column(&mut self, j: usize, by: impl Fn(f64) -> f64) {
        self.r.iter_mut().skip(j).step_by(self.n).for_each(|x| *x = by(*x));
    }

    /// Folds a block of `n` columns of `rows` values (a multiple of [`LANES`]; rows of zeros have
    /// no effect), one column after the other. The block is overwritten.
    #[inline(always)]
    pub fn fold(&mut self, block: &mut [f64], rows: usize) {
        let n = self.n;
        for j in 0..n {
            let (head, tail) = block.split_at_mut((j + 1) * rows);
            let x = &head[j * rows..];
            let square = dot(x, x);
            if square < LEAST_SQUARE {
                continue;
            }
            // the reflection that maps (r_jj, x) to (μ, 0): v = (v₀, x), v₀ without cancellation
            let row = &mut self.r[j * n..(j + 1) * n];
            let diagonal = row[j];
            let length = (diagonal * diagonal + square).sqrt();
            let v0 = if diagonal <= 0.0 { diagonal - length } else { -square / (diagonal + length) };
            let factor = 2.0 / (square + v0 * v0);
            row[j] = length;
            for (y, r) in tail.chunks_exact_mut(rows).zip(&mut row[j + 1..]) {
                let w = factor * (*r * v0 + dot(x, y));
                *r -= w * v0;
                for (y, x) in y.iter_mut().zip(x) {
                    *y -= w * x;
                }
            }
        }
    }

    /// Solves R x = z for the leading columns, z being the last one; `None` if a diagonal entry is
    /// nearly 0.
    pub fn solution(&self) -> Option<Vec<f64>> {
        let p = self.n - 1;
        let mut x = vec![0.0; p];
        for i in (0..p).rev() {
            let length = self.column(i).fold(0.0, |m: f64, r| m.max(r.abs()));
            let pivot = self.at(i, i);
            if pivot.abs() <= LEAST_PIVOT * length {
                return None;
            }
            let known: f64 = (i + 1..p).map(|j| self.at(i, j) * x[j]).sum();
            x[i] = (self.at(i, p) - known) / pivot;
        }
        Some(x)
    }

    /// Folds the rows of other factors with the same number of columns, each times its weight.
    #[inline(always)]
    pub fn fold_all<'a>(&mut self, others: impl Iterator<Item = (f64, &'a Triangle)>, block: &mut Vec<f64>) {
        let n = self.n;
        let others: Vec<(f64, &Triangle)> = others.collect();
        let rows = (others.len() * n).next_multiple_of(LANES);
        block.clear();
        block.resize(rows * n, 0.0);
        for (k, (weight, other)) in others.into_iter().enumerate() {
            for j in 0..n {
                for i in 0..=j {
                    block[j * rows + k * n + i] = weight * other.at(i, j);
                }
            }
        }
        self.fold(block, rows);
    }
}

/// aᵀb, summed in lanes.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for (a, b) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            sums[lane] += sums[lane + half];
        }
        half /= 2;
    }
    sums[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(rows: usize, n: usize, seed: usize) -> Vec<f64> {
        (0..rows * n).map(|k| ((k * 31 + seed * 17 + k * k % 7) % 23) as f64 - 11.0).collect()
    }

    /// RᵀR = Σ XᵀX, integers, to rounding.
    #[test]
    fn law_all_products_are_kept() {
        let (n, rows) = (4, 64);
        let blocks = [block(rows, n, 1), block(rows, n, 2)];
        let mut whole = Triangle::new(n);
        let mut parts = Vec::new();
        for x in &blocks {
            whole.fold(&mut x.clone(), rows);
            let mut part = Triangle::new(n);
            part.fold(&mut x.clone(), rows);
            parts.push(part);
        }
        let mut merged = Triangle::new(n);
        merged.fold_all(parts.iter().map(|part| (1.0, part)), &mut Vec::new());
        for a in 0..n {
            for b in 0..n {
                let exact: f64 =
                    blocks.iter().flat_map(|x| (0..rows).map(move |i| x[a * rows + i] * x[b * rows + i])).sum();
                for r in [&whole, &merged] {
                    let found: f64 = (0..n).map(|i| r.at(i, a) * r.at(i, b)).sum();
                    assert!((found - exact).abs() < 1e-13 * 128.0 * 121.0, "{a} {b}: {found} {exact}");
                }
            }
        }
    }

    #[test]
    fn rows_of_zeros_and_vanishing_rows_change_nothing() {
        let mut r = Triangle::new(2);
        r.fold(&mut block(32, 2, 3), 32);
        let before = r.clone();
        r.fold(&mut vec![0.0; 64], 32);
        r.fold(&mut vec![1e-170; 64], 32);
        assert_eq!(r, before);
    }
}
