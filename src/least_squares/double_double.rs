//! Sums and products in twice the precision of a double.
//!
//! ```text
//! x = hi + lo,  |lo| ≤ ½ ulp(hi)        a + b = s + e and a·b = p + e exactly (Knuth; Dekker and Veltkamp)
//! ```
//!
//! Dekker, *Numerische Mathematik* 18 (1971) 224. Without fused multiply-add, which is slow on
//! processors that lack it. Valid while no product exceeds the range of a double: the caller
//! scales.

use std::ops::{Add, Mul, Neg, Sub};

/// An unevaluated sum of two doubles, about 32 digits.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct DoubleDouble {
    hi: f64,
    lo: f64,
}

impl DoubleDouble {
    /// The nearest double.
    pub fn value(self) -> f64 {
        self.hi
    }

    /// a·b without rounding.
    #[inline]
    pub fn product(a: f64, b: f64) -> DoubleDouble {
        let ((a1, a2), (b1, b2)) = (split(a), split(b));
        let hi = a * b;
        DoubleDouble { hi, lo: ((a1 * b1 - hi) + a1 * b2 + a2 * b1) + a2 * b2 }
    }

    /// a + b, |a| ≥ |b|.
    #[inline]
    fn ordered(a: f64, b: f64) -> DoubleDouble {
        let hi = a + b;
        DoubleDouble { hi, lo: b - (hi - a) }
    }
}

/// Two halves of 26 bits that sum to x.
#[inline(always)]
pub(super) fn split(x: f64) -> (f64, f64) {
    let c = 134_217_729.0 * x;
    let high = c - (c - x);
    (high, x - high)
}

impl From<f64> for DoubleDouble {
    fn from(x: f64) -> DoubleDouble {
        DoubleDouble { hi: x, lo: 0.0 }
    }
}

impl Add for DoubleDouble {
    type Output = DoubleDouble;
    #[inline]
    fn add(self, b: DoubleDouble) -> DoubleDouble {
        let sum = |a: f64, b: f64| {
            let s = a + b;
            let t = s - a;
            (s, (a - (s - t)) + (b - t))
        };
        let ((s, e), (t, f)) = (sum(self.hi, b.hi), sum(self.lo, b.lo));
        let first = DoubleDouble::ordered(s, e + t);
        DoubleDouble::ordered(first.hi, first.lo + f)
    }
}

impl Neg for DoubleDouble {
    type Output = DoubleDouble;
    #[inline]
    fn neg(self) -> DoubleDouble {
        DoubleDouble { hi: -self.hi, lo: -self.lo }
    }
}

impl Sub for DoubleDouble {
    type Output = DoubleDouble;
    #[inline]
    fn sub(self, b: DoubleDouble) -> DoubleDouble {
        self + -b
    }
}

impl Mul<f64> for DoubleDouble {
    type Output = DoubleDouble;
    #[inline]
    fn mul(self, b: f64) -> DoubleDouble {
        let p = DoubleDouble::product(self.hi, b);
        DoubleDouble::ordered(p.hi, p.lo + self.lo * b)
    }
}

impl Mul for DoubleDouble {
    type Output = DoubleDouble;
    #[inline]
    fn mul(self, b: DoubleDouble) -> DoubleDouble {
        let p = DoubleDouble::product(self.hi, b.hi);
        DoubleDouble::ordered(p.hi, p.lo + (self.hi * b.lo + self.lo * b.hi))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_products_and_sums() {
        // (1 + 2⁻⁵²)² = 1 + 2⁻⁵¹ + 2⁻¹⁰⁴
        let x = 1.0 + f64::EPSILON;
        let square = DoubleDouble::product(x, x);
        assert_eq!((square.hi, square.lo), (1.0 + 2.0 * f64::EPSILON, f64::EPSILON * f64::EPSILON));
        // what a double loses in 1e16 + 1 − 1e16 is kept
        let sum = DoubleDouble::from(1e16) + DoubleDouble::from(1.0) - DoubleDouble::from(1e16);
        assert_eq!(sum.value(), 1.0);
    }

    #[test]
    fn products_of_pairs_to_thirty_digits() {
        // (1 + x)(1 − x) = 1 − x², x = 2⁻⁶⁰: all three are pairs of doubles
        let x = 2.0_f64.powi(-60);
        let (one, small) = (DoubleDouble::from(1.0), DoubleDouble::from(x));
        let rest = (one + small) * (one - small) - one;
        assert!((rest.value() + x * x).abs() < 1e-31);
        assert_eq!(((one + small) * 3.0 - DoubleDouble::from(3.0)).value(), 3.0 * x);
    }
}
