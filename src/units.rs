//! Physical dimensions as exponents of kilogram, metre and second.
//!
//! Inside the crate everything is SI; a [`Dimension`] is what a number's unit *is*, so that a test can prove that
//! a formula is dimensionally right. An angle has no dimension (a radian is 1).

use std::fmt;

/// Exponents of kg, m and s: `X_u|u|` in kg/m is `Dimension::new(1, -1, 0)`.
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
        Dimension::new(self.kg + other.kg, self.m + other.m, self.s + other.s)
    }

    /// Dimension of a quotient.
    pub const fn over(self, other: Dimension) -> Dimension {
        Dimension::new(self.kg - other.kg, self.m - other.m, self.s - other.s)
    }

    /// Dimension of an integer power.
    pub const fn power(self, n: i8) -> Dimension {
        Dimension::new(self.kg * n, self.m * n, self.s * n)
    }
}

impl fmt::Display for Dimension {
    /// As a user writes it: `kg/m`, `N`, `N*m`, `m/s`, `1`.
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
                .filter(|(_, n)| n * sign > 0)
                .map(|(name, n)| if n.abs() == 1 { name.to_string() } else { format!("{name}{}", n.abs()) })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_print_as_users_write_them() {
        assert_eq!(Dimension::new(1, -1, 0).to_string(), "kg/m");
        assert_eq!(Dimension::new(1, 2, -1).to_string(), "kg*m2/s");
        assert_eq!(Dimension::RATE.to_string(), "1/s");
        assert_eq!(Dimension::FORCE.times(Dimension::LENGTH), Dimension::MOMENT);
    }
}
