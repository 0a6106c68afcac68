//! Meaning of a factor between two channels that should agree.
//!
//! ```text
//! f = channel/reference:  1 agrees, −1 is reversed, ±57.3, ±1000, … is in another unit, else another scale
//! ```

/// Factors of the units in which a velocity may be logged.
pub const VELOCITY: &[(f64, &str)] =
    &[(1e3, "mm/s"), (1e2, "cm/s"), (3600.0 / 1852.0, "kn"), (3.6, "km/h"), (1.0 / 0.3048, "ft/s")];
/// Factors of the units in which an angular rate may be logged, against an angle in radians; the
/// inverse means an angle in degrees.
pub const RATE: &[(f64, &str)] =
    &[(180.0 / std::f64::consts::PI, "deg/s"), (std::f64::consts::PI / 180.0, "rad/s while the angle is in deg")];

/// Meaning of a factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meaning {
    /// The channels agree.
    Agrees,
    /// The signs are opposite.
    Reversed,
    /// A unit, its name and factor, and whether the sign is opposite too.
    Unit(&'static str, f64, bool),
    /// None of these.
    Scale,
    /// Not determined by the data.
    Unknown,
}

/// Returns the meaning of `factor` with standard deviation `std`; a difference below `tolerance` is
/// ignored.
pub fn meaning(factor: f64, std: f64, tolerance: f64, units: &[(f64, &'static str)]) -> Meaning {
    /// Largest relative difference of a factor from that of a unit: sensors may have a scale error as well.
    const NEAR: f64 = 0.15;
    if !factor.is_finite() || !std.is_finite() || std > 0.1 * factor.abs() {
        return Meaning::Unknown;
    }
    let certain = tolerance.max(5.0 * std);
    if (factor - 1.0).abs() <= certain {
        return Meaning::Agrees;
    }
    if (factor + 1.0).abs() <= certain.max(0.35) {
        return Meaning::Reversed;
    }
    let near = |unit: &&(f64, &str)| (factor.abs() / unit.0 - 1.0).abs() <= NEAR;
    // the nearest one: km/h and ft/s are close to each other
    let off = |unit: &(f64, &str)| (factor.abs() / unit.0).ln().abs();
    match units.iter().filter(near).min_by(|a, b| off(a).total_cmp(&off(b))) {
        Some((unit, name)) => Meaning::Unit(name, unit.copysign(factor), factor < 0.0),
        None => Meaning::Scale,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meanings() {
        let of = |f| meaning(f, 0.002 * f64::abs(f), 0.1, RATE);
        assert_eq!(of(1.05), Meaning::Agrees);
        assert_eq!(of(-1.1), Meaning::Reversed);
        assert!(matches!(of(57.0), Meaning::Unit("deg/s", _, false)));
        assert!(matches!(of(-58.0), Meaning::Unit("deg/s", f, true) if f < -57.0));
        assert_eq!(of(1.4), Meaning::Scale);
        assert_eq!(meaning(1.4, 0.2, 0.1, RATE), Meaning::Unknown);
        assert!(matches!(meaning(1010.0, 5.0, 0.05, VELOCITY), Meaning::Unit("mm/s", _, false)));
    }
}
