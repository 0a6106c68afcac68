//! A curve that was fitted to a bollard table, and the thrust under slightly different
//! coefficients.
//!
//! ```text
//! V = curve⁻¹(F_nom)          F' = curve'(V)
//! ```
//!
//! The change of an estimate when a coefficient changes by its standard deviation is the
//! uncertainty that it inherits. The command is computed back from the nominal force, so that a run
//! needs its forces only.

use super::curve::{Supply, ThrustCurve};
use super::fit::CurveFit;
use crate::noise::Noise;

/// Increase of each coefficient of a curve, in the order of [`CurveFit::covariance`].
pub type Moves = [f64; MeasuredCurve::COEFFICIENTS];

/// A curve that was fitted to a table, and the thrusters that have it.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredCurve {
    /// The table.
    pub file: String,
    /// Indices of the thrusters, from 0.
    pub thrusters: Vec<usize>,
    /// The curve with its standard deviations.
    pub fit: CurveFit,
}

impl MeasuredCurve {
    /// Number of coefficients that may be uncertain, in the order of [`CurveFit::covariance`].
    pub const COEFFICIENTS: usize = 6;

    /// Value of a coefficient.
    pub fn value(&self, coefficient: usize) -> f64 {
        let exponent = self.fit.exponent.map_or(0.0, |n| n.value);
        let (forward, reverse) = (self.fit.forward, self.fit.reverse);
        [forward.a.value, forward.b.value, reverse.a.value, reverse.b.value, self.fit.deadband.value, exponent]
            [coefficient]
    }

    /// The increase of one coefficient by `by`.
    pub fn one(coefficient: usize, by: f64) -> Moves {
        std::array::from_fn(|k| if k == coefficient { by } else { 0.0 })
    }

    /// A random draw of the coefficients' errors: L n with L Lᵀ = Σ and n standard normal.
    pub fn drawn(&self, noise: &mut Noise) -> Moves {
        let covariance = &self.fit.covariance;
        let mut factor = [[0.0; Self::COEFFICIENTS]; Self::COEFFICIENTS];
        for i in 0..Self::COEFFICIENTS {
            for j in 0..=i {
                let sum: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
                let left = covariance[i][j] - sum;
                // a coefficient that is certain, or determined by others, has no share of its own
                factor[i][j] = match i == j {
                    true => left.max(0.0).sqrt(),
                    false if factor[j][j] > 0.0 => left / factor[j][j],
                    false => 0.0,
                };
            }
        }
        let normal: Moves = std::array::from_fn(|_| noise.normal());
        std::array::from_fn(|i| (0..=i).map(|k| factor[i][k] * normal[k]).sum())
    }
}

/// `curve` with each coefficient increased by its entry of `by`.
fn moved(mut curve: ThrustCurve, by: &Moves) -> ThrustCurve {
    curve.forward.a += by[0];
    curve.forward.b += by[1];
    curve.reverse.a += by[2];
    curve.reverse.b += by[3];
    curve.deadband += by[4];
    curve.supply = curve.supply.map(|s| Supply { exponent: s.exponent + by[5], ..s });
    curve
}

/// The force (N) that the command of a nominal `force` would give if the coefficients of `curve`
/// were greater by `by`. `supply`: voltage at that instant, if it is logged.
pub fn reshaped(curve: &ThrustCurve, by: &Moves, force: f64, supply: Option<f64>) -> f64 {
    let factor = |curve: &ThrustCurve| supply.zip(curve.supply).map_or(1.0, |(volts, s)| s.factor(volts));
    let command = curve.inverse(force / factor(curve)).voltage;
    let other = moved(*curve, by);
    other.force(command) * factor(&other)
}

#[cfg(test)]
mod tests {
    use super::super::curve::Coefficients;
    use super::*;

    #[test]
    fn exact_force_of_another_curve() {
        let supply = Some(Supply { reference: 16.0, exponent: 1.0 });
        let curve = ThrustCurve {
            deadband: 0.1,
            supply,
            ..ThrustCurve::new(Coefficients { a: 30.0, b: 12.0 }, Coefficients { a: 20.0, b: 10.0 })
        };
        for (command, volts) in [(0.7, Some(14.0)), (-0.6, Some(18.0)), (0.4, None), (0.05, None)] {
            let told = |curve: &ThrustCurve| volts.map_or(curve.force(command), |v| curve.force_at(command, v));
            for coefficient in 0..MeasuredCurve::COEFFICIENTS {
                let by = MeasuredCurve::one(coefficient, 0.03);
                let expected = told(&moved(curve, &by));
                let found = reshaped(&curve, &by, told(&curve), volts);
                // inside the dead band there is no force from which to compute a command
                assert!((found - expected).abs() < 1e-12 * 30.0, "{command} {coefficient}: {found} {expected}");
            }
        }
    }
}
