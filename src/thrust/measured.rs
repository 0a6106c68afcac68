//! A curve found from a bollard table, and the thrust that slightly other coefficients would have given.
//!
//! ```text
//! V = curve⁻¹(F_nom)          F' = curve'(V)
//! ```
//!
//! How far an estimate moves as a coefficient moves by its deviation is how much of that deviation it takes over. The
//! command is taken back from the nominal force, so that a run needs no more than its forces.

use super::curve::{Supply, ThrustCurve};
use super::fit::CurveFit;

/// A curve that was found from a table, and the thrusters that have it.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredCurve {
    /// The table.
    pub file: String,
    /// Numbers of the thrusters, counted from 0.
    pub thrusters: Vec<usize>,
    /// The curve and what is known of it.
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
}

/// `curve` with one coefficient greater by `by`.
fn moved(mut curve: ThrustCurve, coefficient: usize, by: f64) -> ThrustCurve {
    match coefficient {
        0 => curve.forward.a += by,
        1 => curve.forward.b += by,
        2 => curve.reverse.a += by,
        3 => curve.reverse.b += by,
        4 => curve.deadband += by,
        _ => curve.supply = curve.supply.map(|s| Supply { exponent: s.exponent + by, ..s }),
    }
    curve
}

/// The force (N) that the command of a nominal `force` would give were one coefficient of `curve` greater by `by`;
/// `supply` the voltage at that instant where it is logged.
pub fn reshaped(curve: &ThrustCurve, coefficient: usize, by: f64, force: f64, supply: Option<f64>) -> f64 {
    let factor = |curve: &ThrustCurve| supply.zip(curve.supply).map_or(1.0, |(volts, s)| s.factor(volts));
    let command = curve.inverse(force / factor(curve)).voltage;
    let other = moved(*curve, coefficient, by);
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
                let expected = told(&moved(curve, coefficient, 0.03));
                let found = reshaped(&curve, coefficient, 0.03, told(&curve), volts);
                // in the dead band there is no force to take a command from
                assert!((found - expected).abs() < 1e-12 * 30.0, "{command} {coefficient}: {found} {expected}");
            }
        }
    }
}
