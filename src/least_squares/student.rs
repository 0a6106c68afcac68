//! Quantiles of Student's t, by which intervals of few rows are wider than those of a normal.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// The quantile of Student's t with this many degrees of freedom below which lies the share `below`; NaN where `below` is
/// not between 0 and 1 or there is no degree of freedom.
pub fn student_quantile(below: f64, freedom: f64) -> f64 {
    if !(below > 0.0 && below < 1.0) {
        return f64::NAN;
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |t| t.inverse_cdf(below))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_the_tables() {
        // Abramowitz and Stegun, table 26.10
        for (freedom, quantile) in
            [(1.0, 12.706), (2.0, 4.303), (3.0, 3.182), (10.0, 2.228), (30.0, 2.042), (120.0, 1.980), (1e7, 1.960)]
        {
            let found = student_quantile(0.975, freedom);
            assert!((found - quantile).abs() < 6e-4, "{freedom}: {found}, printed {quantile}");
        }
        for (below, freedom) in [(0.975, 0.0), (1.0, 3.0), (f64::NAN, 3.0)] {
            assert!(student_quantile(below, freedom).is_nan());
        }
    }
}
