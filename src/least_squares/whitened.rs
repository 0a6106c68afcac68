//! Many solutions of one system with different weights of its blocks of rows, each at the cost of a
//! sum.
//!
//! ```text
//! H = Q R,  S_b = H_b R⁻¹,  e_b = y_b − H_b θ̂        θ = θ̂ + R⁻¹ δ,   (Σ n_b S_bᵀS_b) δ = Σ n_b S_bᵀe_b
//! ```
//!
//! Σ S_bᵀS_b = I: in the coordinates of the whole the products lose no digits, and the unknown is a
//! correction. If the blocks that count leave a direction nearly undetermined,
//! [`Whitened::solution`] returns `None`.

use super::triangle::Triangle;
use crate::simd::widest;

/// Least pivot of Σ n_b S_bᵀS_b, where the whole has 1 in every direction: a smaller one costs more
/// than four digits.
const LEAST_PIVOT: f64 = 1e-4;

/// Products of blocks in the coordinates of the whole.
#[derive(Debug)]
pub(super) struct Whitened {
    whole: Triangle,
    /// θ̂
    solution: Vec<f64>,
    /// For each block S_bᵀS_b, its upper triangle row by row, then S_bᵀe_b.
    products: Vec<f64>,
    /// The same for the rows that always count.
    always: Vec<f64>,
}

impl Whitened {
    /// The products for blocks with these factors of [H | y], and the factor of all their rows. The
    /// rows of `always` count once in every solution. `None` if the whole does not determine the
    /// unknowns.
    pub fn of(whole: Triangle, always: &Triangle, factors: &[Triangle]) -> Option<Whitened> {
        let solution = whole.solution()?;
        let mut whitened = Whitened { whole, solution, products: Vec::new(), always: Vec::new() };
        whitened.always = whitened.products_of(always);
        whitened.products = factors.iter().flat_map(|factor| whitened.products_of(factor)).collect();
        Some(whitened)
    }

    fn products_of(&self, factor: &Triangle) -> Vec<f64> {
        let p = self.solution.len();
        let rows: Vec<(Vec<f64>, f64)> = (0..=p)
            .map(|i| {
                let mut s = vec![0.0; p];
                for j in i..p {
                    let known: f64 = (i..j).map(|k| s[k] * self.whole.at(k, j)).sum();
                    s[j] = (factor.at(i, j) - known) / self.whole.at(j, j);
                }
                let explained: f64 = (i..p).map(|j| factor.at(i, j) * self.solution[j]).sum();
                (s, factor.at(i, p) - explained)
            })
            .collect();
        let squares = (0..p).flat_map(|j| (j..p).map(move |k| (j, k)));
        let squares = squares.map(|(j, k)| rows.iter().map(|(s, _)| s[j] * s[k]).sum());
        squares.chain((0..p).map(|j| rows.iter().map(|(s, e)| s[j] * e).sum())).collect()
    }

    /// θ if block b counts `counts[b]` times; `sums` is working memory. `None` if these blocks
    /// leave θ nearly undetermined.
    pub fn solution(&self, counts: &[u32], sums: &mut Vec<f64>) -> Option<Vec<f64>> {
        let p = self.solution.len();
        sums.clone_from(&self.always);
        widest(
            #[inline(always)]
            || {
                for (products, count) in self.products.chunks_exact(self.always.len()).zip(counts) {
                    let count = f64::from(*count);
                    for (sum, x) in sums.iter_mut().zip(products) {
                        *sum += count * x;
                    }
                }
            },
        );
        // Cholesky's factor in place of the products, row by row: U, UᵀU = Σ n_b S_bᵀS_b
        let (upper, right) = sums.split_at_mut(p * (p + 1) / 2);
        let at = |i: usize, j: usize| i * p - i * (i + 1) / 2 + j;
        for i in 0..p {
            for k in 0..i {
                let factor = upper[at(k, i)];
                for j in i..p {
                    upper[at(i, j)] -= factor * upper[at(k, j)];
                }
                right[i] -= factor * right[k];
            }
            let pivot = upper[at(i, i)];
            // NaN is no valid pivot
            if pivot.is_nan() || pivot < LEAST_PIVOT {
                return None;
            }
            let inverse = 1.0 / pivot.sqrt();
            (i..p).for_each(|j| upper[at(i, j)] *= inverse);
            right[i] *= inverse;
        }
        for i in (0..p).rev() {
            let known: f64 = (i + 1..p).map(|j| upper[at(i, j)] * right[j]).sum();
            right[i] = (right[i] - known) / upper[at(i, i)];
        }
        let mut theta = right.to_vec();
        for i in (0..p).rev() {
            let known: f64 = (i + 1..p).map(|j| self.whole.at(i, j) * theta[j]).sum();
            theta[i] = (theta[i] - known) / self.whole.at(i, i);
        }
        theta.iter_mut().zip(&self.solution).for_each(|(change, whole)| *change += whole);
        Some(theta)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(k: usize) -> Vec<Vec<f64>> {
        let value = |i: usize, j: usize| ((k * 7 + i * 3 + j * j * 5 + i * i * (j + 1)) % 11) as f64 - 4.0;
        (0..6).map(|i| (0..4).map(|j| value(i, j)).collect()).collect()
    }

    /// Against the stacked factors of the blocks that count, solved by QR: equal up to a few
    /// roundings.
    #[test]
    fn law_a_solution_is_that_of_the_stacked_rows() {
        let blocks: Vec<Vec<Vec<f64>>> = (0..7).map(block).collect();
        let factors: Vec<Triangle> = blocks.iter().map(|rows| Triangle::of_rows(4, rows)).collect();
        let always = Triangle::of_rows(4, &[vec![0.5, 0.25, -1.0, 2.0]]);
        let stacked = |counts: &[u32]| {
            let mut rows = vec![vec![0.5, 0.25, -1.0, 2.0]];
            for (block, count) in blocks.iter().zip(counts) {
                (0..*count).for_each(|_| rows.extend(block.iter().cloned()));
            }
            Triangle::of_rows(4, &rows)
        };
        let whitened = Whitened::of(stacked(&[1; 7]), &always, &factors).unwrap();
        for counts in [[1; 7], [0, 2, 1, 0, 3, 1, 0], [5, 0, 0, 0, 0, 0, 2]] {
            let (found, exact) =
                (whitened.solution(&counts, &mut Vec::new()).unwrap(), stacked(&counts).solution().unwrap());
            for (a, b) in found.iter().zip(exact) {
                assert!((a - b).abs() < 1e-13 * b.abs().max(1.0), "{a} {b}");
            }
        }
        assert!(whitened.solution(&[0; 7], &mut Vec::new()).is_none(), "one row for three unknowns");
    }
}
