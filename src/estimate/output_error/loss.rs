//! The cost of a residual: its square, or less if it is large, so that outliers do not dominate the
//! fit.
//!
//! ```text
//! squares   ρ = r²
//! Huber     ρ = r² within k = 1.345, 2 k |r| − k² beyond                    ψ = r, k sign r
//! Student   ρ = (ν + 1) ln(1 + r²/ν), ν = 4                                 ψ = (ν + 1) r/(ν + r²)
//! ```
//!
//! r is the residual in units of its sensor's noise; ψ = ½ dρ/dr. The fit minimises Σρ as the sum
//! of squares of s = sign(r) √ρ, whose Jacobian is that of r times ψ/s: Gauss-Newton then has the
//! right gradient. Huber, *Robust Statistics* (1981): 95 % as efficient as squares if noise is
//! Gaussian; Lange, Little and Taylor, *JASA* 84 (1989) 881.

use serde::{Deserialize, Serialize};

/// The cost of a residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Loss {
    /// Its square: best if noise is Gaussian.
    #[default]
    Squares,
    /// Huber's: an outlier pulls no more than a residual of 1.345 σ.
    Huber,
    /// Student's with four degrees of freedom: the farther off an outlier, the less it pulls. It
    /// needs a good start.
    Student,
}

/// Number of σ beyond which Huber's loss grows linearly: 95 % as efficient as squares if the noise
/// is Gaussian.
pub(crate) const HUBER: f64 = 1.345;

/// Degrees of freedom of Student's distribution.
const STUDENT: f64 = 4.0;

/// A residual as transformed by its loss.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RobustResidual {
    /// s = sign(r) √ρ(r).
    pub value: f64,
    /// ds/dr.
    pub slope: f64,
    /// dψ/dr.
    pub bend: f64,
}

impl Loss {
    /// The residual `r`, in units of σ, under this loss.
    #[inline(always)]
    pub(super) fn temper(self, r: f64) -> RobustResidual {
        match self {
            Loss::Squares => RobustResidual { value: r, slope: 1.0, bend: 1.0 },
            Loss::Huber if r.abs() <= HUBER => RobustResidual { value: r, slope: 1.0, bend: 1.0 },
            Loss::Huber => {
                let size = (2.0 * HUBER * r.abs() - HUBER * HUBER).sqrt();
                RobustResidual { value: size.copysign(r), slope: HUBER / size, bend: 0.0 }
            }
            Loss::Student => {
                let square = r * r;
                let size = ((STUDENT + 1.0) * (square / STUDENT).ln_1p()).sqrt();
                let psi = (STUDENT + 1.0) * r / (STUDENT + square);
                // the limit at 0, where ψ/s is 0/0
                let slope = if size < 1e-8 { ((STUDENT + 1.0) / STUDENT).sqrt() } else { psi.abs() / size };
                let bend = (STUDENT + 1.0) * (STUDENT - square) / (STUDENT + square).powi(2);
                RobustResidual { value: size.copysign(r), slope, bend }
            }
        }
    }

    /// Whether the pull of outliers is limited.
    pub fn is_robust(self) -> bool {
        self != Loss::Squares
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ψ = s ds/dr is half the slope of s², and `bend` is the slope of ψ: central differences,
    /// accurate to the step squared.
    #[test]
    fn law_slopes_are_slopes() {
        let h = 1e-5;
        for loss in [Loss::Squares, Loss::Huber, Loss::Student] {
            for r in [-7.0, -1.5, -0.3, 1e-3, 0.9, 1.2, 2.0, 30.0] {
                let at = |r: f64| loss.temper(r);
                let psi = |r: f64| at(r).value * at(r).slope;
                let slope = (at(r + h).value - at(r - h).value) / (2.0 * h);
                let rho = (at(r + h).value.powi(2) - at(r - h).value.powi(2)) / (4.0 * h);
                let bend = (psi(r + h) - psi(r - h)) / (2.0 * h);
                assert!((at(r).slope - slope).abs() < 1e-7, "{loss:?} {r}");
                assert!((psi(r) - rho).abs() < 1e-7, "{loss:?} {r}");
                assert!((at(r).bend - bend).abs() < 1e-6, "{loss:?} {r}");
            }
        }
    }

    #[test]
    fn outliers_pull_no_more_than_they_may() {
        let pull = |loss: Loss, r: f64| loss.temper(r).value * loss.temper(r).slope;
        assert!((pull(Loss::Huber, 100.0) - HUBER).abs() < 1e-12);
        assert!(pull(Loss::Student, 100.0) < pull(Loss::Student, 2.0));
        assert_eq!(Loss::Student.temper(0.0).value, 0.0);
    }
}
