//! Iterative refinement of a least-squares solution and of its standard errors.
//!
//! ```text
//! r + H x = f,   Hᵀ r = g        f = y, g = 0:    x = θ̂, r the residual
//!                                f = 0, g = −eⱼ:  x = (HᵀH)⁻¹ eⱼ
//! ```
//!
//! Both unknowns are corrected together: the residuals of both equations are summed in twice the
//! precision, and the correction comes from the available QR. A residual that is large compared
//! with the solution is then no obstacle (Björck, *BIT* 7 (1967) 257; Demmel, Hida, Riedy and Li,
//! *ACM TOMS* 35 (2009) 28). It works while ε cond(H), columns of unit length, is below 1.

use faer::Mat;

use super::double_double::DoubleDouble;
use super::pivoted::Pivoted;

/// Maximum number of corrections; each gains −log₁₀(ε cond) digits, about 6 for the worst of the
/// reference sets.
const STEPS: usize = 30;

/// x and r of the augmented system.
struct Solution {
    x: Vec<DoubleDouble>,
    r: Vec<DoubleDouble>,
}

/// Refined coefficients, (HᵀH)⁻¹ and |y − H θ̂|², all for scaled columns.
pub(super) struct Refined {
    pub coefficients: Vec<f64>,
    pub inverse: Vec<Vec<f64>>,
    pub square: f64,
}

/// Refines the solution of `h` θ = `y`; `None` if the corrections do not shrink, as with ε cond(H)
/// near 1.
pub(super) fn refine(h: &Mat<f64>, y: &[f64], pivoted: &Pivoted) -> Option<Refined> {
    let (n, p) = (h.nrows(), h.ncols());
    let fit = solve(h, pivoted, y, &vec![0.0; p])?;
    let nothing = vec![0.0; n];
    let mut inverse = Vec::with_capacity(p);
    for j in 0..p {
        let mut g = vec![0.0; p];
        g[j] = -1.0;
        inverse.push(values(&solve(h, pivoted, &nothing, &g)?.x));
    }
    let square = fit.r.iter().fold(DoubleDouble::default(), |sum, r| sum + *r * *r);
    Some(Refined { coefficients: values(&fit.x), inverse, square: square.value() })
}

fn values(x: &[DoubleDouble]) -> Vec<f64> {
    x.iter().map(|x| x.value()).collect()
}

/// Solves r + H x = f, Hᵀ r = g to about 30 digits.
fn solve(h: &Mat<f64>, pivoted: &Pivoted, f: &[f64], g: &[f64]) -> Option<Solution> {
    let zero = DoubleDouble::default();
    let mut at = Solution { x: vec![zero; g.len()], r: vec![zero; f.len()] };
    let mut last = f64::INFINITY;
    for _ in 0..STEPS {
        let (left_f, left_g) = left(h, f, g, &at);
        let (dx, dr) = correction(pivoted, &left_f, &left_g);
        for (x, d) in at.x.iter_mut().zip(&dx) {
            *x = *x + DoubleDouble::from(*d);
        }
        for (r, d) in at.r.iter_mut().zip(&dr) {
            *r = *r + DoubleDouble::from(*d);
        }
        let size = change(&at.x, &dx);
        // this correction changes no digit of the result, and the next one would be smaller still
        if size < 2.0_f64.powi(-80) {
            return Some(at);
        }
        if !(size.is_finite()) || size > 0.5 * last {
            // the correction shrinks no more: at the limit of twice the precision, or it never did
            return (size < 2.0_f64.powi(-60)).then_some(at);
        }
        last = size;
    }
    None
}

/// The largest correction `d` relative to its coefficient, because a coefficient may be far smaller
/// than the others. The divisor is at least 2⁻⁴⁰ of the largest coefficient, because one that is 0
/// has no relative error. NaN if a correction is.
fn change(x: &[DoubleDouble], d: &[f64]) -> f64 {
    let floor = 2.0_f64.powi(-40) * x.iter().fold(0.0, |m: f64, x| m.max(x.value().abs()));
    let relative = |(x, d): (&DoubleDouble, &f64)| if *d == 0.0 { 0.0 } else { d.abs() / x.value().abs().max(floor) };
    x.iter().zip(d).map(relative).fold(0.0, |m: f64, r| if m.is_nan() || r <= m { m } else { r })
}

/// The residuals f − r − H x and g − Hᵀ r, summed in twice the precision.
fn left(h: &Mat<f64>, f: &[f64], g: &[f64], at: &Solution) -> (Vec<f64>, Vec<f64>) {
    let mut left_f: Vec<DoubleDouble> = f.iter().zip(&at.r).map(|(f, r)| DoubleDouble::from(*f) - *r).collect();
    let mut left_g = Vec::with_capacity(g.len());
    for (j, g) in g.iter().enumerate() {
        let mut sum = DoubleDouble::from(*g);
        for (i, h) in h.col(j).iter().enumerate() {
            left_f[i] = left_f[i] - at.x[j] * *h;
            sum = sum - at.r[i] * *h;
        }
        left_g.push(sum.value());
    }
    (values(&left_f), left_g)
}

/// Solves dr + H dx = f, Hᵀ dr = g by H Π = Q R, to the precision of a double.
fn correction(pivoted: &Pivoted, f: &[f64], g: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let along = pivoted.project(f);
    let u = pivoted.solve_transposed(g);
    let step: Vec<f64> = along.iter().zip(&u).map(|(a, u)| a - u).collect();
    let mut dr = f.to_vec();
    for (q, s) in pivoted.q.col_iter().zip(&step) {
        for (r, q) in dr.iter_mut().zip(q.iter()) {
            *r -= q * s;
        }
    }
    (pivoted.solve(&step), dr)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hilbert's matrix scaled to integers: (i + j + 1) divides 232 792 560 for all entries, and
    /// x = (1, …, 1) gives sums of integers, which are exact in doubles.
    #[test]
    fn exact_integers_of_a_hilbert_matrix() {
        let p = 8;
        let h = Mat::from_fn(12, p, |i, j| 232_792_560.0 / (i + j + 1) as f64 / 2.0_f64.powi(28));
        let y: Vec<f64> = (0..12).map(|i| (0..p).map(|j| h[(i, j)]).sum()).collect();
        let pivoted = Pivoted::of(h.as_ref(), 12).unwrap();
        let refined = refine(&h, &y, &pivoted).unwrap();
        assert_eq!(refined.coefficients, vec![1.0; p]);
        // 0 but for the rounding of thirty digits
        assert!(refined.square < 1e-60, "{}", refined.square);
        // plain: some 7 digits
        let plain = pivoted.solve(&pivoted.project(&y));
        assert!(plain.iter().any(|x| (x - 1.0).abs() > 1e-10));
    }

    #[test]
    fn coefficients_that_are_zero_are_found() {
        // x is odd and y even about the middle row: the slope is 0, though no row says so
        let h = Mat::from_fn(9, 2, |i, j| if j == 0 { 0.3 } else { (i as f64 - 4.0) / 7.0 });
        let y: Vec<f64> = (0..9).map(|i| (i as f64 - 4.0).powi(2) / 11.0).collect();
        let pivoted = Pivoted::of(h.as_ref(), 9).unwrap();
        let refined = refine(&h, &y, &pivoted).unwrap();
        assert!(refined.coefficients[1].abs() < 1e-30);
        assert!((refined.coefficients[0] * 0.3 - 60.0 / 99.0).abs() < 1e-15);
    }

    #[test]
    fn nan_ends() {
        let h = Mat::from_fn(6, 2, |i, j| (i + 1) as f64 * (j as f64 + 1.0) + j as f64);
        let pivoted = Pivoted::of(h.as_ref(), 6).unwrap();
        assert!(refine(&h, &[f64::NAN; 6], &pivoted).is_none());
    }
}
