//! Curvature of the likelihood learnt from the steps themselves (limited-memory BFGS).
//!
//! ```text
//! H₊ = (I − ρ s yᵀ) H (I − ρ y sᵀ) + ρ s sᵀ
//! s: a step,  y: change of the gradient over it,  ρ = 1/(yᵀ s)
//! ```
//!
//! Fisher's information is the curvature expected of a correct model, not the curvature of the data
//! at hand. If sensors have coloured noise, a search by the information alone creeps, with a fall
//! of a tenth and less per step, and does not converge. The last steps correct it, in a recursion
//! from the newest to the oldest and back. Nocedal, *Mathematics of Computation* 35 (1980) 773-782.

use nalgebra::DVector;

/// Number of steps that are remembered.
const REMEMBERED: usize = 10;

/// Cosine between a step and the change of the gradient, below which rounding and other changes
/// dominate.
const ALONG: f64 = 1e-3;

/// The last steps, and what they have shown of the curvature.
#[derive(Debug, Default, Clone)]
pub(super) struct QuasiNewton {
    /// Steps and changes of the gradient, the oldest first.
    pairs: Vec<(DVector<f64>, DVector<f64>)>,
    /// The point where the gradient was computed last, and that gradient.
    last: Option<(DVector<f64>, DVector<f64>)>,
    /// Whether each unknown stands at a bound.
    held: Vec<bool>,
}

impl QuasiNewton {
    /// Forgets everything, because another likelihood is climbed.
    pub fn forget(&mut self) {
        *self = QuasiNewton::default();
    }

    /// Skips the next change of the gradient, which is not due to a step alone.
    pub fn pause(&mut self) {
        self.last = None;
    }

    /// Learns from the gradient at a point; `held` marks the unknowns that stand at a bound.
    pub fn learn(&mut self, at: &DVector<f64>, gradient: &DVector<f64>, held: &[bool]) {
        if self.held != held {
            self.forget();
            self.held = held.to_vec();
        }
        if let Some((before, slope)) = self.last.take() {
            let (s, y) = (at - before, gradient - slope);
            if s.dot(&y) > ALONG * s.norm() * y.norm() {
                self.pairs.push((s, y));
                if self.pairs.len() > REMEMBERED {
                    self.pairs.remove(0);
                }
            }
        }
        self.last = Some((at.clone(), gradient.clone()));
    }

    /// −H g, where `base` applies H before any correction; `None` if no step is remembered, or
    /// `base` has no result.
    pub fn step(
        &self,
        gradient: &DVector<f64>,
        base: impl FnOnce(&DVector<f64>) -> Option<DVector<f64>>,
    ) -> Option<DVector<f64>> {
        if self.pairs.is_empty() {
            return None;
        }
        let mut q = gradient.clone();
        let mut shares = Vec::with_capacity(self.pairs.len());
        for (s, y) in self.pairs.iter().rev() {
            let share = s.dot(&q) / s.dot(y);
            q.axpy(-share, y, 1.0);
            shares.push(share);
        }
        let mut z = base(&q)?;
        for ((s, y), share) in self.pairs.iter().zip(shares.into_iter().rev()) {
            z.axpy(share - y.dot(&z) / s.dot(y), s, 1.0);
        }
        Some(-z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// f = ½ xᵀ A x from a curvature that is 1, 4 and 10 times the diagonal of A: with that
    /// curvature alone it takes more than a hundred steps, with remembered steps at most twenty.
    #[test]
    fn a_quadratic_of_another_curvature_is_climbed_in_twenty_steps() {
        let a = DMatrix::from_row_slice(3, 3, &[4.0, 1.0, 0.0, 1.0, 3.0, 0.5, 0.0, 0.5, 0.1]);
        let base = |g: &DVector<f64>| Some(DVector::from_vec(vec![g[0] / 4.0, g[1] / 12.0, g[2] / 1.0]));
        let steps = |remembers: bool| {
            let (mut x, mut quasi) = (DVector::from_vec(vec![1.0, -2.0, 3.0]), QuasiNewton::default());
            (0..1000).find(|_| {
                let g = &a * &x;
                quasi.learn(&x, &g, &[false; 3]);
                let learnt = quasi.step(&g, base).filter(|_| remembers);
                x += learnt.unwrap_or_else(|| -base(&g).unwrap_or_default());
                x.norm() < 1e-6
            })
        };
        let (with, without) = (steps(true), steps(false));
        assert!(with.is_some_and(|n| n <= 20), "{with:?}");
        assert!(without.is_none_or(|n| n > 100), "{without:?}");
    }

    #[test]
    fn a_change_of_bounds_forgets() {
        let point = |x: f64| DVector::from_vec(vec![x, 1.0]);
        let mut quasi = QuasiNewton::default();
        quasi.learn(&point(0.0), &point(0.0), &[false, false]);
        quasi.learn(&point(1.0), &point(2.0), &[false, false]);
        let base = |g: &DVector<f64>| Some(g.clone());
        // the secant condition: H y = s
        let step = quasi.step(&DVector::from_vec(vec![2.0, 0.0]), base).unwrap_or_default();
        assert!((step[0] + 1.0).abs() < 1e-12);
        quasi.learn(&point(1.5), &point(3.0), &[true, false]);
        assert!(quasi.step(&point(1.0), base).is_none());
        // a removed unknown makes it forget too, even after a pause
        quasi.learn(&point(2.0), &point(4.0), &[true, false]);
        quasi.pause();
        let one = DVector::from_vec(vec![1.0]);
        quasi.learn(&one, &one, &[true]);
        assert!(quasi.step(&one, base).is_none());
    }
}
