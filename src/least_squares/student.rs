//! Quantiles of Student's t, which make intervals from few rows wider than those of a normal
//! distribution.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Number of degrees of freedom above which the quantile is that of a normal with two terms of 1/ν,
/// accurate to eleven digits: the search of `statrs` loses digits there, 7 % at 10⁷, and does not
/// end at 10⁸.
const MANY: f64 = 1e4;

/// The quantile of Student's t with `freedom` degrees of freedom below which the share `below`
/// lies; NaN if `below` is not between 0 and 1 or there is no degree of freedom.
pub fn student_quantile(below: f64, freedom: f64) -> f64 {
    if !(below > 0.0 && below < 1.0) {
        return f64::NAN;
    }
    if freedom > MANY {
        // Abramowitz and Stegun, 26.7.5
        let z = Normal::standard().inverse_cdf(below);
        let first = (z.powi(3) + z) / 4.0;
        let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
        return z + first / freedom + second / freedom.powi(2);
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |t| t.inverse_cdf(below))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_the_tables() {
        // Abramowitz and Stegun, table 26.10
        for (freedom, quantile) in [
            (1.0, 12.706),
            (2.0, 4.303),
            (3.0, 3.182),
            (10.0, 2.228),
            (30.0, 2.042),
            (120.0, 1.980),
            (1e7, 1.960),
            (1e9, 1.960),
        ] {
            let found = student_quantile(0.975, freedom);
            assert!((found - quantile).abs() < 6e-4, "{freedom}: {found}, printed {quantile}");
        }
        let (few, many) = (student_quantile(0.975, MANY), student_quantile(0.975, MANY * (1.0 + 1e-12)));
        assert!((few - many).abs() < 1e-11, "{few} and {many}, where one formula follows the other");
        for (below, freedom) in [(0.975, 0.0), (1.0, 3.0), (f64::NAN, 3.0)] {
            assert!(student_quantile(below, freedom).is_nan());
        }
    }
}
