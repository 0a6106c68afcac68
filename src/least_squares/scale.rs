//! Scaling of columns to a length near 1 by powers of two, which is exact.
//!
//! ```text
//! h'ⱼ = 2^(−eⱼ) hⱼ,   1 ≤ |h'ⱼ| < 2        θⱼ = 2^(e_y − eⱼ) θ'ⱼ
//! ```
//!
//! Squares of 1e200 or 1e-200 are outside the range of a double; those of h' are not.

/// Exponent e of 2^e ≤ |x| < 2^(e + 1), x finite and not 0.
pub(super) fn exponent(x: f64) -> i32 {
    const BIAS: i32 = 1023;
    // subnormal numbers are first brought into the normal range
    let (x, shift) = if x.is_normal() { (x, 0) } else { (x * 18_014_398_509_481_984.0, 54) };
    ((x.to_bits() >> 52) & 0x7ff) as i32 - BIAS - shift
}

/// 2^k x; 0 or infinity beyond the range.
#[inline]
pub(super) fn times_power_of_two(x: f64, k: i32) -> f64 {
    const BIAS: i32 = 1023;
    let power = |k: i32| f64::from_bits(((k + BIAS) as u64) << 52);
    // in two steps: 2^k itself may be outside the range; no two doubles differ by more than 2^2098
    let k = k.clamp(-2040, 2040);
    let half = k / 2;
    x * power(half) * power(k - half)
}

/// Greatest |x| of finite values.
pub(super) fn greatest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// The exponent that brings `x` to a length of 1 to 2; 0 for a column of zeros.
pub(super) fn length_exponent(x: &[f64]) -> i32 {
    let greatest = greatest(x);
    if greatest == 0.0 {
        return 0;
    }
    let first = exponent(greatest);
    let square: f64 = x.iter().map(|x| times_power_of_two(*x, -first).powi(2)).sum();
    first + exponent(square.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_of_extreme_numbers() {
        for (x, e) in [(1.0, 0), (1.99, 0), (-2.0, 1), (0.75, -1), (f64::MAX, 1023), (5e-324, -1074), (1e-310, -1030)] {
            assert_eq!(exponent(x), e, "{x}");
        }
        assert_eq!(times_power_of_two(5e-324, 1074), 1.0);
        assert_eq!(times_power_of_two(1.5, 1023 + 1023), f64::INFINITY);
        assert_eq!(times_power_of_two(times_power_of_two(3.25e-200, 600), -600), 3.25e-200);
    }

    #[test]
    fn length_is_between_one_and_two() {
        for scale in [1e-200, 1.0, 1e200] {
            let x: Vec<f64> = (1..100).map(|k| scale * f64::from(k)).collect();
            let e = length_exponent(&x);
            let length = x.iter().map(|x| times_power_of_two(*x, -e).powi(2)).sum::<f64>().sqrt();
            assert!((1.0..2.0).contains(&length), "{length}");
        }
        assert_eq!(length_exponent(&[0.0, 0.0]), 0);
    }
}
