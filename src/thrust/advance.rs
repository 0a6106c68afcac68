//! Loss of thrust by advance, equation (17): a propeller that moves through the water gives less
//! thrust than at bollard pull.
//!
//! ```text
//! η_adv = slope |v_a| + intercept,     not below 0
//! ```
//!
//! v_a is the advance speed (m/s), positive where the thruster moves in the direction in which it
//! pushes. The paper's line is −0.1946 |v_a| + 0.9967, measured from 0 to 1 m/s with thrust along
//! the motion; it does not cover thrust against the motion. Outside of the measured range the line
//! is extrapolated, and the result says so. Source: Avila, Donha and Adamowski, *Ocean Engineering*
//! 60 (2013) 81-94, eq. (17).

use serde::{Deserialize, Serialize};

use super::efficiency::EfficiencyError;
use super::fit::Estimate;
use crate::least_squares::{LeastSquaresError, least_squares};

/// The line η_adv with the range of its measured advance speeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AdvanceLoss {
    /// Slope, s/m; negative.
    pub slope: f64,
    /// Efficiency at rest, 1.
    pub intercept: f64,
    /// Least and greatest advance speed measured, m/s.
    pub valid: [f64; 2],
}

/// Coverage of an efficiency by measurements. The order is that of decreasing trust: of several
/// thrusters the greatest counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Coverage {
    /// The advance speed is inside the measured range.
    Covered,
    /// The advance speed is outside of the measured range.
    OutOfRange,
    /// The thruster pushes against its motion, which the line does not describe.
    AgainstMotion,
}

/// An efficiency, and its coverage by measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Advance {
    /// η_adv, 0 or more.
    pub efficiency: f64,
    /// Coverage at this advance speed.
    pub coverage: Coverage,
}

impl AdvanceLoss {
    /// The paper's line, eq. (17).
    pub const PAPER: AdvanceLoss = AdvanceLoss { slope: -0.1946, intercept: 0.9967, valid: [0.0, 1.0] };

    /// η_adv at an advance speed, m/s, positive where the thruster moves in the direction in which
    /// it pushes.
    pub fn at(&self, v_a: f64) -> Advance {
        let coverage = match v_a.abs() {
            speed if speed < self.valid[0] || speed > self.valid[1] => Coverage::OutOfRange,
            _ => Coverage::Covered,
        };
        let coverage = if v_a < 0.0 { Coverage::AgainstMotion } else { coverage };
        Advance { efficiency: (self.slope * v_a.abs() + self.intercept).max(0.0), coverage }
    }

    /// Checks the line.
    ///
    /// # Errors
    /// A value that is not finite, an efficiency at rest that is not positive, a range that is
    /// empty or begins below 0.
    pub fn validate(&self) -> Result<(), EfficiencyError> {
        let [least, most] = self.valid;
        let finite = [self.slope, self.intercept, least, most].iter().all(|x| x.is_finite());
        if !finite || self.intercept <= 0.0 || least < 0.0 || most <= least {
            return Err(EfficiencyError::BadAdvance { loss: *self });
        }
        Ok(())
    }
}

/// A fitted line η_adv.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdvanceFit {
    /// The line, valid between the least and greatest speed of the data.
    pub loss: AdvanceLoss,
    /// Slope, s/m.
    pub slope: Estimate,
    /// Efficiency at rest, 1.
    pub intercept: Estimate,
    /// Standard deviation of the residual, 1.
    pub residual_std: f64,
}

/// Fits the line to measured efficiencies: `efficiency` is the thrust at each advance speed `v_a`
/// (m/s, the sign does not matter) over the thrust of the same command at bollard pull.
///
/// # Errors
/// Lists of different length, values that are not finite, fewer than 3 rows or only one speed.
pub fn fit_advance(v_a: &[f64], efficiency: &[f64]) -> Result<AdvanceFit, EfficiencyError> {
    EfficiencyError::check(("advance speed", v_a), ("efficiency", efficiency), 3)?;
    let speed: Vec<f64> = v_a.iter().map(|v| v.abs()).collect();
    let (values, stds, residual_std) = match least_squares(&[&speed, &vec![1.0; speed.len()]], efficiency) {
        Ok(fit) => (fit.coefficients, fit.standard_errors, fit.residual_std),
        // the same efficiency at different speeds: a line without slope and without scatter
        Err(LeastSquaresError::NoVariance { .. }) => (vec![0.0, efficiency[0]], vec![0.0; 2], 0.0),
        Err(_) => return Err(EfficiencyError::NotIdentifiable { needs: "two different advance speeds" }),
    };
    let [slope, intercept] = [0, 1].map(|i| Estimate { value: values[i], std: stds[i] });
    let valid = speed.iter().fold([f64::INFINITY, 0.0_f64], |[low, high], v| [low.min(*v), high.max(*v)]);
    let loss = AdvanceLoss { slope: slope.value, intercept: intercept.value, valid };
    Ok(AdvanceFit { loss, slope, intercept, residual_std })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_line_and_its_range() {
        let at = |v| AdvanceLoss::PAPER.at(v);
        // −0.1946·0.748 + 0.9967, by hand: the speed of the paper's Fig. 7
        assert!((at(0.748).efficiency - 0.851_139_2).abs() < 1e-12);
        assert_eq!(at(0.748).coverage, Coverage::Covered);
        assert_eq!(at(1.2).coverage, Coverage::OutOfRange);
        assert_eq!(at(-0.3).coverage, Coverage::AgainstMotion);
        assert!((at(-0.3).efficiency - at(0.3).efficiency).abs() <= 0.0);
        // beyond 5.1 m/s the line would push backwards
        assert!(at(6.0).efficiency.abs() <= 0.0);
    }

    #[test]
    fn exact_line_is_found_with_its_range() {
        let speed = [0.0, 0.25, -0.5, 0.75, 1.0];
        let efficiency = speed.map(|v: f64| AdvanceLoss::PAPER.at(v.abs()).efficiency);
        let fit = fit_advance(&speed, &efficiency).unwrap();
        // no noise: rounding only
        assert!((fit.loss.slope + 0.1946).abs() < 1e-14 && (fit.loss.intercept - 0.9967).abs() < 1e-14);
        assert_eq!(fit.loss.valid, [0.0, 1.0]);
        assert!(fit.residual_std < 1e-14);
        let flat = fit_advance(&[0.0, 0.5, 1.0], &[0.9; 3]).unwrap();
        assert_eq!((flat.loss.slope, flat.loss.intercept), (0.0, 0.9));
        assert!(matches!(fit_advance(&[0.5; 4], &[0.9; 4]), Err(EfficiencyError::NotIdentifiable { .. })));
    }

    #[test]
    fn lines_that_cannot_be_are_refused() {
        for loss in [
            AdvanceLoss { intercept: 0.0, ..AdvanceLoss::PAPER },
            AdvanceLoss { slope: f64::NAN, ..AdvanceLoss::PAPER },
            AdvanceLoss { valid: [1.0, 0.0], ..AdvanceLoss::PAPER },
            AdvanceLoss { valid: [-1.0, 1.0], ..AdvanceLoss::PAPER },
        ] {
            assert!(loss.validate().is_err(), "{loss:?}");
        }
        AdvanceLoss::PAPER.validate().unwrap();
    }
}
