//! Physical dimensions as exponents of kilogram, metre and second.
//!
//! All quantities inside the crate are SI. A [`Dimension`] is the unit of a number, so that a test
//! can check a formula for dimensional consistency. An angle has no dimension (a radian is 1).

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Exponents of kg, m and s: `X_u|u|` in kg/m is `Dimension::new(1, -1, 0)`. Exponents saturate at
/// the limits of `i8`: a formula that reaches them has a unit that differs from all known ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Dimension {
    /// Exponent of the kilogram.
    pub kg: i8,
    /// Exponent of the metre.
    pub m: i8,
    /// Exponent of the second.
    pub s: i8,
}

impl Dimension {
    /// A pure number or an angle.
    pub const ONE: Dimension = Dimension::new(0, 0, 0);
    /// Length, m.
    pub const LENGTH: Dimension = Dimension::new(0, 1, 0);
    /// Time, s.
    pub const TIME: Dimension = Dimension::new(0, 0, 1);
    /// Mass, kg.
    pub const MASS: Dimension = Dimension::new(1, 0, 0);
    /// Velocity, m/s.
    pub const VELOCITY: Dimension = Dimension::new(0, 1, -1);
    /// Angular rate, rad/s.
    pub const RATE: Dimension = Dimension::new(0, 0, -1);
    /// Force, N.
    pub const FORCE: Dimension = Dimension::new(1, 1, -2);
    /// Moment, N·m.
    pub const MOMENT: Dimension = Dimension::new(1, 2, -2);

    /// From the three exponents.
    pub const fn new(kg: i8, m: i8, s: i8) -> Dimension {
        Dimension { kg, m, s }
    }

    /// Dimension of a product.
    pub const fn times(self, other: Dimension) -> Dimension {
        Dimension::new(self.kg.saturating_add(other.kg), self.m.saturating_add(other.m), self.s.saturating_add(other.s))
    }

    /// Dimension of a quotient.
    pub const fn over(self, other: Dimension) -> Dimension {
        Dimension::new(self.kg.saturating_sub(other.kg), self.m.saturating_sub(other.m), self.s.saturating_sub(other.s))
    }

    /// Dimension of an integer power.
    pub const fn power(self, n: i8) -> Dimension {
        Dimension::new(self.kg.saturating_mul(n), self.m.saturating_mul(n), self.s.saturating_mul(n))
    }
}

impl fmt::Display for Dimension {
    /// Writes the unit as users do: `kg/m`, `N`, `N*m`, `m/s`, `1`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Dimension::ONE => return f.write_str("1"),
            Dimension::FORCE => return f.write_str("N"),
            Dimension::MOMENT => return f.write_str("N*m"),
            _ => {}
        }
        let part = |sign: i8| -> Vec<String> {
            [("kg", self.kg), ("m", self.m), ("s", self.s)]
                .into_iter()
                .filter(|(_, n)| n.signum() == sign)
                .map(
                    |(name, n)| {
                        if n.unsigned_abs() == 1 { name.to_string() } else { format!("{name}{}", n.unsigned_abs()) }
                    },
                )
                .collect()
        };
        let (above, below) = (part(1), part(-1));
        if above.is_empty() {
            f.write_str("1")?;
        }
        f.write_str(&above.join("*"))?;
        for unit in below {
            write!(f, "/{unit}")?;
        }
        Ok(())
    }
}

/// Error of a text that is no unit of kilogram, metre and second.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{unit:?} is no SI unit: `{part}` is none of 1, kg, m, s, N, rad, each with a power, as in `kg/m` or `N*m*s2`")]
pub struct UnitError {
    /// The whole text.
    pub unit: String,
    /// The part that was not understood.
    pub part: String,
}

impl FromStr for Dimension {
    type Err = UnitError;

    /// Parses the output of [`Dimension`]: 1, kg, m, s, N and rad, joined by `*` or `·` and `/`,
    /// each with a power of one digit (`m2`, `m^2`, `m²`). Only the factor directly after a `/` is
    /// in the denominator.
    fn from_str(unit: &str) -> Result<Dimension, UnitError> {
        let error = |part: &str| UnitError { unit: unit.to_string(), part: part.to_string() };
        if unit.trim().is_empty() || unit.trim_end().ends_with(['*', '·', '/']) {
            return Err(error(""));
        }
        let mut sum = [0_i32; 3];
        let mut sign = 1;
        for factor in unit.split_inclusive(['*', '·', '/']) {
            let part = factor.trim_end_matches(['*', '·', '/']).trim();
            let plain = part.replace('²', "2").replace('³', "3");
            let (symbol, power) = match plain.char_indices().last() {
                Some((at, digit)) if at > 0 && digit.is_ascii_digit() => (&plain[..at], digit.to_digit(10)),
                _ => (plain.as_str(), Some(1)),
            };
            let exponents = match symbol.trim_end_matches('^') {
                "1" | "rad" => [0, 0, 0],
                "kg" => [1, 0, 0],
                "m" => [0, 1, 0],
                "s" => [0, 0, 1],
                "N" => [1, 1, -2],
                _ => return Err(error(part)),
            };
            let power = sign * power.and_then(|p| i32::try_from(p).ok()).ok_or_else(|| error(part))?;
            for (total, exponent) in sum.iter_mut().zip(exponents) {
                *total += power * exponent;
            }
            // beyond this it is no physical unit, and products of dimensions must stay in range
            if sum.iter().any(|total| total.abs() > 12) {
                return Err(error(part));
            }
            sign = if factor.ends_with('/') { -1 } else { 1 };
        }
        let [kg, m, s] = sum.map(|n| n as i8);
        Ok(Dimension { kg, m, s })
    }
}

impl Serialize for Dimension {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Dimension {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Dimension, D::Error> {
        struct Unit;
        impl serde::de::Visitor<'_> for Unit {
            type Value = Dimension;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an SI unit such as \"kg/m\"")
            }

            fn visit_str<E: serde::de::Error>(self, unit: &str) -> Result<Dimension, E> {
                unit.parse().map_err(E::custom)
            }
        }
        deserializer.deserialize_str(Unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `((u^15)^15)` of a user's formula.
    #[test]
    fn a_power_of_a_power_has_a_unit_that_is_none() {
        let beyond = Dimension::VELOCITY.power(15).power(15);
        assert_eq!((beyond, beyond.to_string().as_str()), (Dimension::new(0, 127, -128), "m127/s128"));
        assert_eq!(beyond.times(beyond), beyond);
        assert_ne!(beyond.over(Dimension::VELOCITY), Dimension::VELOCITY);
    }

    #[test]
    fn law_a_printed_unit_reads_back() {
        for (kg, m, s) in
            [(0, 0, 0), (1, -1, 0), (1, 1, -2), (1, 2, -2), (0, 1, -1), (0, 0, -1), (1, 2, -1), (-1, 0, 2)]
        {
            let dimension = Dimension::new(kg, m, s);
            assert_eq!(dimension.to_string().parse(), Ok(dimension), "{dimension}");
        }
    }

    #[test]
    fn units_read_as_users_write_them() {
        assert_eq!("kg·m²/s".parse(), Ok(Dimension::new(1, 2, -1)));
        assert_eq!("N*s^2 / m^2".parse(), Ok(Dimension::new(1, -1, 0)));
        assert_eq!("rad/s".parse(), Ok(Dimension::RATE));
        for (unit, part) in [("", ""), ("kg/", ""), ("lbf", "lbf"), ("kg/furlong", "furlong"), ("m9*m9", "m9")] {
            assert_eq!(unit.parse::<Dimension>().unwrap_err().part, part, "{unit}");
        }
    }

    #[test]
    fn units_print_as_users_write_them() {
        assert_eq!(Dimension::new(1, -1, 0).to_string(), "kg/m");
        assert_eq!(Dimension::new(1, 2, -1).to_string(), "kg*m2/s");
        assert_eq!(Dimension::RATE.to_string(), "1/s");
        assert_eq!(Dimension::FORCE.times(Dimension::LENGTH), Dimension::MOMENT);
    }
}
