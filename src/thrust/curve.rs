//! The thruster's curve, equation (1): axial force at bollard pull by the control voltage, and its
//! inverse.
//!
//! ```text
//! F = (a V'|V'| + b V') (V_s/V_ref)ⁿ,     V' = sign(V) max(0, |V| − c)
//! ```
//!
//! F is the force along the thruster's axis (N), V the control voltage (V) or a normalised command
//! (1), a (N/V²) and b (N/V) one pair for each direction, c the dead band (as V), V_s the supply
//! voltage (V). Without dead band and supply this is the paper's F = a V|V| + b V; the paper prints
//! a V² + b V per direction, and V|V| keeps the sign. Source: Avila, Donha and Adamowski, *Ocean
//! Engineering* 60 (2013) 81-94, eq. (1).

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The two coefficients of one direction.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coefficients {
    /// Quadratic coefficient a, N/V².
    pub a: f64,
    /// Linear coefficient b, N/V.
    pub b: f64,
}

/// Dependence of the thrust on the supply voltage: F ∝ (V_s/V_ref)ⁿ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Supply {
    /// Supply voltage V_ref at which the coefficients hold, V.
    pub reference: f64,
    /// Exponent n.
    pub exponent: f64,
}

impl Supply {
    /// The factor (V_s/V_ref)ⁿ on the thrust.
    pub fn factor(&self, supply: f64) -> f64 {
        (supply / self.reference).powf(self.exponent)
    }
}

/// A thruster's curve: two directions, dead band, limit of the command, supply.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThrustCurve {
    /// For V > 0.
    pub forward: Coefficients,
    /// For V < 0; positive coefficients here too give a negative force.
    pub reverse: Coefficients,
    /// Dead band c, as V.
    pub deadband: f64,
    /// Greatest |V| of the thruster; infinite if it is not known.
    pub max: f64,
    /// Dependence on the supply voltage; `None` if there is none.
    pub supply: Option<Supply>,
}

/// The command for a wanted force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// Control voltage V.
    pub voltage: f64,
    /// Force that it gives, N; the wanted one unless saturated.
    pub force: f64,
    /// Whether the wanted force exceeds the range of the thruster.
    pub saturated: bool,
}

/// The reason why a curve is impossible.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CurveError {
    /// A quantity is not finite.
    #[error("{key} = {value}: must be finite")]
    NotFinite {
        /// Which quantity.
        key: &'static str,
        /// The value.
        value: f64,
    },
    /// Thrust does not grow with the command.
    #[error("{direction} thrust falls as the command grows, near |V| = {voltage}, with a = {a} and b = {b}")]
    NotMonotone {
        /// `forward` or `reverse`.
        direction: &'static str,
        /// Where the slope 2aV + b is negative.
        voltage: f64,
        /// Quadratic coefficient, N/V².
        a: f64,
        /// Linear coefficient, N/V.
        b: f64,
    },
    /// The dead band is negative, or not below the limit of the command.
    #[error("deadband = {deadband}: must be at least 0 and below max = {max}")]
    BadDeadband {
        /// The dead band given.
        deadband: f64,
        /// The limit of the command.
        max: f64,
    },
    /// The reference of the supply is not a positive voltage.
    #[error("supply reference = {reference}: must be a positive number of volts")]
    BadReference {
        /// The given value, V.
        reference: f64,
    },
}

impl Coefficients {
    /// Whether both are 0, as if none are given.
    pub(super) fn are_none(&self) -> bool {
        self.a == 0.0 && self.b == 0.0
    }

    /// Force for V' ≥ 0, N.
    fn force(self, voltage: f64) -> f64 {
        (self.a * voltage + self.b) * voltage
    }

    /// V' ≥ 0 that gives a force ≥ 0, by the form of the root that does not cancel and also holds
    /// at a = 0. For b < 0 it is the branch beyond the dip. `None` beyond the crest of a curve with
    /// a < 0.
    fn voltage(self, force: f64) -> Option<f64> {
        let root = (self.b * self.b + 4.0 * self.a * force).sqrt();
        let voltage = if self.b < 0.0 {
            (root - self.b) / (2.0 * self.a)
        } else {
            2.0 * force / (self.b + root).max(f64::MIN_POSITIVE)
        };
        voltage.is_finite().then_some(voltage)
    }

    /// V' ≥ 0 beyond which thrust falls; infinite for an ordinary curve.
    fn crest(self) -> f64 {
        if self.a < 0.0 { (-self.b / (2.0 * self.a)).max(0.0) } else { f64::INFINITY }
    }
}

impl ThrustCurve {
    /// The paper's curve: no dead band, no limit, no supply.
    pub const fn new(forward: Coefficients, reverse: Coefficients) -> ThrustCurve {
        ThrustCurve { forward, reverse, deadband: 0.0, max: f64::INFINITY, supply: None }
    }

    /// Force under a control voltage at the reference supply, N. A command beyond the limit counts
    /// as the limit.
    pub fn force(&self, voltage: f64) -> f64 {
        let side = if voltage < 0.0 { self.reverse } else { self.forward };
        let beyond = (voltage.abs().min(self.max) - self.deadband).max(0.0);
        side.force(beyond) * voltage.signum()
    }

    /// Force at a supply voltage (V), N: the one at the reference supply times (V_s/V_ref)ⁿ.
    pub fn force_at(&self, voltage: f64, supply: f64) -> f64 {
        self.force(voltage) * self.factor(supply)
    }

    /// The control voltage that gives a wanted force (N) at the reference supply.
    ///
    /// No force needs no voltage; any other force needs one beyond the dead band. A force out of
    /// reach gives the command with the greatest thrust in that direction, marked as saturated.
    pub fn inverse(&self, force: f64) -> Command {
        let side = if force < 0.0 { self.reverse } else { self.forward };
        if force.abs() <= 0.0 {
            return Command { voltage: 0.0, force: 0.0, saturated: false };
        }
        let most = side.crest().min(self.max - self.deadband);
        match side.voltage(force.abs()).filter(|v| *v <= most) {
            Some(beyond) => Command { voltage: (self.deadband + beyond).copysign(force), force, saturated: false },
            None => {
                let voltage = (self.deadband + most).copysign(force);
                // the greatest force may exceed itself by rounding
                let reached = self.force(voltage);
                let saturated = (force - reached).abs() > 1e-12 * reached.abs();
                Command { voltage, force: reached, saturated }
            }
        }
    }

    /// The control voltage that gives a wanted force (N) at a supply voltage (V).
    pub fn inverse_at(&self, force: f64, supply: f64) -> Command {
        let factor = self.factor(supply);
        let command = self.inverse(force / factor);
        Command { force: if command.saturated { command.force * factor } else { force }, ..command }
    }

    /// Greatest force in each direction, (reverse ≤ 0, forward ≥ 0), N, at the reference supply;
    /// infinite without a limit.
    pub fn range(&self) -> (f64, f64) {
        let most = |side: Coefficients| {
            let voltage = side.crest().min(self.max - self.deadband);
            if voltage.is_finite() { side.force(voltage) } else { f64::INFINITY }
        };
        (-most(self.reverse), most(self.forward))
    }

    fn factor(&self, supply: f64) -> f64 {
        self.supply.map_or(1.0, |s| s.factor(supply))
    }

    /// Checks that a thruster can have this curve.
    ///
    /// # Errors
    /// A value that is not finite (except `max`); thrust that falls as the command grows from the
    /// dead band to `max`; a dead band that is negative or not below `max`; a reference supply that
    /// is not positive.
    pub fn validate(&self) -> Result<(), CurveError> {
        for (direction, c) in [("forward", self.forward), ("reverse", self.reverse)] {
            for (key, value) in [("a", c.a), ("b", c.b)] {
                if !value.is_finite() {
                    return Err(CurveError::NotFinite { key, value });
                }
            }
            let end = self.max - self.deadband;
            let slope_at_end = if end.is_finite() { 2.0 * c.a * end + c.b } else { c.a };
            if c.b < 0.0 || slope_at_end < 0.0 || (c.a <= 0.0 && c.b <= 0.0) {
                let voltage = if c.b < 0.0 { self.deadband } else { self.max };
                return Err(CurveError::NotMonotone { direction, voltage, a: c.a, b: c.b });
            }
        }
        if self.deadband.is_nan() || self.deadband < 0.0 || self.max.is_nan() || self.deadband >= self.max {
            return Err(CurveError::BadDeadband { deadband: self.deadband, max: self.max });
        }
        match self.supply {
            Some(s) if !(s.reference.is_finite() && s.reference > 0.0) => {
                Err(CurveError::BadReference { reference: s.reference })
            }
            Some(s) if !s.exponent.is_finite() => Err(CurveError::NotFinite { key: "exponent", value: s.exponent }),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Fig. 5 of the paper: one thruster of LAURS.
    const PAPER: ThrustCurve = ThrustCurve::new(Coefficients { a: 11.53, b: 4.21 }, Coefficients { a: 7.87, b: 4.68 });

    #[test]
    fn paper_thruster() {
        PAPER.validate().unwrap();
        // 11.53·4 + 4.21·2 and −(7.87·4 + 4.68·2), by hand
        assert!((PAPER.force(2.0) - 54.54).abs() < 1e-12);
        assert!((PAPER.force(-2.0) + 40.84).abs() < 1e-12);
        assert!(PAPER.force(0.0).abs() < f64::MIN_POSITIVE);
        assert_eq!(PAPER.range(), (f64::NEG_INFINITY, f64::INFINITY));
    }

    proptest! {
        #[test]
        fn law_inverse_then_curve_is_identity(
            a in 0.1..50.0_f64, b in 0.0..50.0_f64, c in 0.0..0.3_f64, n in -0.5..2.5_f64,
            supply in 8.0..22.0_f64, part in -1.0..1.0_f64,
        ) {
            let sides = (Coefficients { a, b }, Coefficients { a: 0.7 * a, b: 0.8 * b });
            let supply_law = Some(Supply { reference: 16.0, exponent: n });
            let curve = ThrustCurve { deadband: c, max: 4.0, supply: supply_law, ..ThrustCurve::new(sides.0, sides.1) };
            prop_assert!(curve.validate().is_ok());
            let force = part * if part < 0.0 { -curve.range().0 } else { curve.range().1 } * curve.factor(supply);
            let command = curve.inverse_at(force, supply);
            prop_assert!(!command.saturated);
            // near V' = 0 the dead band is subtracted again: absolute rounding of V times the slope
            let tolerance = 1e-13 * (a + b + 1.0) * curve.factor(supply) + 1e-12 * force.abs();
            prop_assert!((curve.force_at(command.voltage, supply) - force).abs() <= tolerance);
            // and the other way round, beyond the dead band
            let voltage = (c + (4.0 - c) * part.abs()).copysign(part);
            let back = curve.inverse_at(curve.force_at(voltage, supply), supply).voltage;
            // for b = 0 the square root loses half the digits next to V' = 0
            prop_assert!((back - voltage).abs() < 1e-7);
        }
    }

    #[test]
    fn saturation_is_reported() {
        let curve = ThrustCurve { max: 5.0, deadband: 0.1, ..PAPER };
        let (least, most) = curve.range();
        for (wanted, limit, end) in [(1000.0, most, 5.0), (-1000.0, least, -5.0)] {
            let command = curve.inverse(wanted);
            assert!(command.saturated);
            assert!((command.force - limit).abs() < 1e-12 * limit.abs() && (command.voltage - end).abs() < 1e-15);
        }
        assert!(!curve.inverse(most).saturated && !curve.inverse(least).saturated);
        // a command beyond the limit gives no more
        assert!((curve.force(9.0) - most).abs() < 1e-12 * most);
    }

    #[test]
    fn the_dead_band_gives_nothing_and_is_jumped() {
        let curve = ThrustCurve { deadband: 0.4, ..PAPER };
        assert!(curve.force(0.39).abs() <= 0.0 && curve.force(-0.4).abs() <= 0.0);
        assert!(curve.inverse(1e-6).voltage > 0.4 && curve.inverse(-1e-6).voltage < -0.4);
        assert!(curve.inverse(0.0).voltage.abs() <= 0.0);
    }

    #[test]
    fn a_curve_that_turns_over_saturates_at_its_crest() {
        let round = Coefficients { a: -1.0, b: 10.0 };
        let curve = ThrustCurve::new(round, round);
        assert!(matches!(curve.validate(), Err(CurveError::NotMonotone { direction: "forward", .. })));
        assert!(ThrustCurve { max: 4.0, ..curve }.validate().is_ok());
        let command = curve.inverse(30.0);
        assert!(command.saturated && (command.voltage - 5.0).abs() < 1e-12 && (command.force - 25.0).abs() < 1e-12);
    }

    #[test]
    fn impossible_curves_are_refused() {
        let with = |forward: Coefficients| ThrustCurve::new(forward, PAPER.reverse).validate().unwrap_err();
        assert!(matches!(with(Coefficients { a: 11.0, b: -4.0 }), CurveError::NotMonotone { .. }));
        assert!(matches!(with(Coefficients { a: 0.0, b: 0.0 }), CurveError::NotMonotone { .. }));
        assert!(matches!(with(Coefficients { a: f64::NAN, b: 1.0 }), CurveError::NotFinite { key: "a", .. }));
        let wide = ThrustCurve { deadband: 1.0, max: 1.0, ..PAPER };
        assert!(matches!(wide.validate(), Err(CurveError::BadDeadband { .. })));
        let dead = ThrustCurve { supply: Some(Supply { reference: 0.0, exponent: 1.0 }), ..PAPER };
        assert!(matches!(dead.validate(), Err(CurveError::BadReference { .. })));
    }
}
