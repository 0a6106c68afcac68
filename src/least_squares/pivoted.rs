//! The pivoted QR factorisation of a design matrix: rank, inverse, condition.
//!
//! ```text
//! H Π = Q R  (Householder, columns of length near 1)        (HᵀH)⁻¹ = W Wᵀ,   W = Π R⁻¹
//! ```
//!
//! Golub and Van Loan, *Matrix Computations*, 4th ed., 5.4.2. HᵀH is never formed. The
//! factorisation is faer's.

use faer::{Mat, MatRef};

use super::scale::times_power_of_two;
use super::singular::singular_ratio;

/// A column that is a combination of others, by index.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Dependence {
    pub column: usize,
    pub others: Vec<usize>,
    pub rank: usize,
}

/// Q, R and Π of a matrix of full column rank.
pub(super) struct Pivoted {
    /// Orthonormal columns: those of the matrix times R⁻¹.
    pub q: Mat<f64>,
    r: Mat<f64>,
    /// Position → column.
    order: Vec<usize>,
}

impl Pivoted {
    /// Factors `h`, columns of length near 1; `rows` is the number of rows that went into it.
    pub fn of(h: MatRef<'_, f64>, rows: usize) -> Result<Pivoted, Dependence> {
        let qr = h.col_piv_qr();
        let (order, r) = (qr.P().arrays().0.to_vec(), qr.thin_R().to_owned());
        let pivoted = Pivoted { q: qr.compute_thin_Q(), r, order };
        match pivoted.dependence(rows) {
            Some(dependence) => Err(dependence),
            None => Ok(pivoted),
        }
    }

    fn dependence(&self, rows: usize) -> Option<Dependence> {
        let p = self.order.len();
        // the rounding error of a Householder step grows with the root of the rows; ten times that
        // covers the worst case
        let tolerance = 10.0 * f64::EPSILON * (p as f64 + (rows as f64).sqrt());
        let length = |j: usize| self.r.col(j).norm_l2();
        let rank = (0..p).find(|k| self.r[(*k, *k)].abs() <= tolerance * length(*k))?;
        let combination = self.solve_leading(rank, |i| self.r[(i, rank)]);
        let takes_part = |i: &usize| (combination[*i] * length(*i)).abs() > 1e-6 * length(rank);
        let others = (0..rank).filter(takes_part).map(|i| self.order[i]).collect();
        Some(Dependence { column: self.order[rank], others, rank })
    }

    /// Solves the leading `k` rows of R x = b.
    fn solve_leading(&self, k: usize, b: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut x = vec![0.0; k];
        for i in (0..k).rev() {
            let known: f64 = (i + 1..k).map(|j| self.r[(i, j)] * x[j]).sum();
            x[i] = (b(i) - known) / self.r[(i, i)];
        }
        x
    }

    /// Π R⁻¹ b: the coefficients, in the order of the columns, for b = Qᵀy.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let x = self.solve_leading(b.len(), |i| b[i]);
        let mut theta = vec![0.0; b.len()];
        for (position, column) in self.order.iter().enumerate() {
            theta[*column] = x[position];
        }
        theta
    }

    /// R⁻ᵀ Πᵀ g.
    pub fn solve_transposed(&self, g: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; g.len()];
        for i in 0..g.len() {
            let known: f64 = (0..i).map(|j| self.r[(j, i)] * x[j]).sum();
            x[i] = (g[self.order[i]] - known) / self.r[(i, i)];
        }
        x
    }

    /// Qᵀ y.
    pub fn project(&self, y: &[f64]) -> Vec<f64> {
        self.q.col_iter().map(|q| q.iter().zip(y).map(|(q, y)| q * y).sum()).collect()
    }

    /// W by rows, one row for each column of the matrix.
    pub fn inverse_factor(&self) -> Vec<Vec<f64>> {
        let p = self.order.len();
        let mut w = vec![vec![0.0; p]; p];
        for k in 0..p {
            let x = self.solve_leading(k + 1, |i| f64::from(u8::from(i == k)));
            for (position, x) in x.into_iter().enumerate() {
                w[self.order[position]][k] = x;
            }
        }
        w
    }

    /// cond(H) for columns of unit length.
    pub fn condition_scaled(&self) -> f64 {
        let length: Vec<f64> = self.r.col_iter().map(|c| c.norm_l2()).collect();
        self.condition(|position, x| x / length[position])
    }

    /// cond(H) of the matrix whose columns were scaled by `2^(−exponents)`; infinite if its square
    /// would be infinite.
    pub fn condition_raw(&self, exponents: &[i32]) -> f64 {
        let greatest = exponents.iter().copied().max().unwrap_or(0);
        let least = exponents.iter().copied().min().unwrap_or(0);
        // columns whose lengths differ by 2^k give a condition number of at least 2^(k − 1), whose
        // square is printed
        if greatest - least > 520 {
            return f64::INFINITY;
        }
        let middle = (greatest + least) / 2;
        self.condition(|position, x| times_power_of_two(x, exponents[self.order[position]] - middle))
    }

    fn condition(&self, scaled: impl Fn(usize, f64) -> f64) -> f64 {
        let p = self.order.len();
        let columns = (0..p).map(|j| (0..p).map(|i| if i <= j { scaled(j, self.r[(i, j)]) } else { 0.0 }).collect());
        singular_ratio(columns.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(n: usize) -> Mat<f64> {
        Mat::from_fn(n, 3, |i, j| ((i * (j + 2) + j * j) % 11) as f64 - 4.0)
    }

    #[test]
    fn exact_coefficients_and_inverse() {
        let h = columns(40);
        let y: Vec<f64> = (0..40).map(|i| 2.0 * h[(i, 0)] - h[(i, 1)] + 0.5 * h[(i, 2)]).collect();
        let pivoted = Pivoted::of(h.as_ref(), 40).unwrap();
        let theta = pivoted.solve(&pivoted.project(&y));
        for (found, exact) in theta.iter().zip([2.0, -1.0, 0.5]) {
            assert!((found - exact).abs() < 1e-14);
        }
        // HᵀH W Wᵀ = 1
        let w = pivoted.inverse_factor();
        let gram = h.transpose() * &h;
        for i in 0..3 {
            for j in 0..3 {
                let entry: f64 = (0..3).map(|k| gram[(i, k)] * (0..3).map(|l| w[k][l] * w[j][l]).sum::<f64>()).sum();
                assert!((entry - f64::from(u8::from(i == j))).abs() < 1e-13);
            }
        }
        let g = [1.0, -2.0, 3.0];
        let u = pivoted.solve_transposed(&g);
        let v: Vec<f64> = (0..3).map(|l| (0..3).map(|k| w[k][l] * g[k]).sum()).collect();
        assert!(u.iter().zip(&v).all(|(a, b)| (a - b).abs() < 1e-14));
    }

    #[test]
    fn dependent_columns_are_named() {
        let mut h = Mat::zeros(40, 4);
        h.as_mut().subcols_mut(0, 3).copy_from(columns(40));
        for i in 0..40 {
            h[(i, 3)] = h[(i, 0)] - 3.0 * h[(i, 2)];
        }
        let found = Pivoted::of(h.as_ref(), 40).err().unwrap();
        let mut group = found.others.clone();
        group.push(found.column);
        group.sort_unstable();
        assert_eq!((group, found.rank), (vec![0, 2, 3], 3));
    }
}
