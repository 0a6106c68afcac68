//! The known columns of a log, their quantities, and the units in which they can be read.
//!
//! Inside the crate everything is SI; units are converted here and nowhere else. Sources of the
//! factors: knot 1852 m/h and kilogram-force 9.80665 N exact by definition, pound-force
//! 4.4482216152605 N and foot 0.3048 m (NIST SP 811).

use crate::frame::Dof;

/// Quantity that a column measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Time, s.
    Time,
    /// Position, m.
    Position,
    /// Angle, rad.
    Angle,
    /// Velocity, m/s.
    Velocity,
    /// Angular rate, rad/s.
    Rate,
    /// Force, N.
    Force,
    /// Moment, N·m.
    Moment,
    /// Control voltage or normalised command of a thruster; a pulse width stays in µs until the
    /// thruster is known.
    Command,
}

/// A unit and its conversion to SI: `x_SI = x · times / over`. Two numbers, because x/1000 rounds
/// better than x · 0.001.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Name as in a header.
    pub name: &'static str,
    /// Factor.
    pub times: f64,
    /// Divisor.
    pub over: f64,
}

const fn unit(name: &'static str, times: f64, over: f64) -> Unit {
    Unit { name, times, over }
}

const POUND: f64 = 4.448_221_615_260_5;

impl Quantity {
    /// Units in which this quantity can be read; the first is the default.
    pub const fn units(self) -> &'static [Unit] {
        const DEGREE: f64 = std::f64::consts::PI;
        match self {
            Quantity::Time => {
                const {
                    &[
                        unit("s", 1.0, 1.0),
                        unit("ms", 1.0, 1e3),
                        unit("us", 1.0, 1e6),
                        unit("ns", 1.0, 1e9),
                        unit("min", 60.0, 1.0),
                        unit("h", 3600.0, 1.0),
                    ]
                }
            }
            Quantity::Position => const { &[unit("m", 1.0, 1.0)] },
            Quantity::Angle => const { &[unit("rad", 1.0, 1.0), unit("deg", DEGREE, 180.0)] },
            Quantity::Velocity => {
                const { &[unit("m/s", 1.0, 1.0), unit("mm/s", 1.0, 1e3), unit("cm/s", 1.0, 1e2), unit("kn", 1852.0, 3600.0)] }
            }
            Quantity::Rate => const { &[unit("rad/s", 1.0, 1.0), unit("deg/s", DEGREE, 180.0)] },
            Quantity::Force => const { &[unit("N", 1.0, 1.0), unit("kgf", 9.80665, 1.0), unit("lbf", POUND, 1.0)] },
            Quantity::Moment => {
                const { &[unit("N*m", 1.0, 1.0), unit("kgf*m", 9.80665, 1.0), unit("lbf*ft", POUND * 0.3048, 1.0)] }
            }
            Quantity::Command => const { &[unit("V", 1.0, 1.0), unit("1", 1.0, 1.0), unit("us", 1.0, 1.0)] },
        }
    }

    /// Returns the unit of this name, in any of its usual spellings; `None` if the quantity is not
    /// read in it.
    pub fn unit(self, name: &str) -> Option<Unit> {
        let plain: String = name.chars().filter(|c| !c.is_whitespace()).collect();
        let name = match plain.as_str() {
            "µs" | "μs" => "us",
            "-" => "1",
            "°" => "deg",
            "°/s" => "deg/s",
            "Nm" | "N·m" | "N.m" => "N*m",
            other => other,
        };
        self.units().iter().find(|u| u.name == name).copied()
    }

    /// Returns the accepted units as a list for people: `m/s, mm/s, cm/s, kn`.
    pub fn accepted(self) -> String {
        self.units().iter().map(|u| u.name).collect::<Vec<_>>().join(", ")
    }
}

/// Returns the quantity that the column of this canonical name measures; `None` for an auxiliary channel.
pub fn quantity(name: &str) -> Option<Quantity> {
    match name {
        "t" => return Some(Quantity::Time),
        "force" => return Some(Quantity::Force),
        _ => {}
    }
    for dof in Dof::ALL {
        let turn = dof.is_rotation();
        if name == dof.velocity() {
            return Some(if turn { Quantity::Rate } else { Quantity::Velocity });
        }
        if name == dof.position() {
            return Some(if turn { Quantity::Angle } else { Quantity::Position });
        }
        if name == dof.force() || name == dof.load() {
            return Some(if turn { Quantity::Moment } else { Quantity::Force });
        }
    }
    let (first, number) = name.split_at_checked(1)?;
    let numbered = !number.starts_with('0') && !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
    match first {
        "V" if numbered => Some(Quantity::Command),
        "F" if numbered => Some(Quantity::Force),
        _ => None,
    }
}

/// Splits a header `name [unit]` into name and unit; the unit is `None` without brackets. Digits in
/// brackets directly after a name are no unit: `data[0]` is the name of an element, but `V1 [1]` is
/// a command as a fraction of full command.
pub fn split_header(header: &str) -> (&str, Option<&str>) {
    let header = header.trim();
    match header.strip_suffix(']').and_then(|h| h.rsplit_once('[')) {
        Some((name, number)) if !name.ends_with(char::is_whitespace) && is_number(number) => (header, None),
        Some((name, unit)) if !name.trim().is_empty() => (name.trim_end(), Some(unit.trim())),
        _ => (header, None),
    }
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

/// Returns the unit of this name if a known quantity is read in it: an auxiliary channel with such
/// a unit is converted to SI too.
pub fn any_unit(name: &str) -> Option<Unit> {
    use Quantity::{Angle, Force, Moment, Position, Rate, Velocity};
    [Position, Angle, Velocity, Rate, Force, Moment].into_iter().find_map(|q| q.unit(name))
}

/// Returns the SI unit of values read in `unit`: `m/s` for `cm/s`.
pub fn si_name(unit: Unit) -> &'static str {
    use Quantity::{Angle, Force, Moment, Position, Rate, Velocity};
    let same = |q: &Quantity| q.unit(unit.name).is_some();
    [Position, Angle, Velocity, Rate, Force, Moment].into_iter().find(same).map_or("", |q| q.units()[0].name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_names_have_their_quantity() {
        assert_eq!(quantity("tau_r"), Some(Quantity::Moment));
        assert_eq!(quantity("load_w"), Some(Quantity::Force));
        assert_eq!(quantity("psi"), Some(Quantity::Angle));
        assert_eq!(quantity("V12"), Some(Quantity::Command));
        assert_eq!(quantity("F1"), Some(Quantity::Force));
        for auxiliary in ["V", "V0", "V1a", "Vx", "depth", "", "°", "supply_V"] {
            assert_eq!(quantity(auxiliary), None, "{auxiliary}");
        }
    }

    #[test]
    fn headers_split_into_name_and_unit() {
        assert_eq!(split_header(" u [kn] "), ("u", Some("kn")));
        assert_eq!(split_header("Yaw rate[deg/s]"), ("Yaw rate", Some("deg/s")));
        assert_eq!(split_header("u"), ("u", None));
        assert_eq!(split_header("[m]"), ("[m]", None));
        assert_eq!(split_header("data[12]"), ("data[12]", None));
        assert_eq!(split_header("V1 [1]"), ("V1", Some("1")));
    }

    #[test]
    fn units_have_their_spellings_and_no_others() {
        assert_eq!(Quantity::Moment.unit("Nm").map(|u| u.name), Some("N*m"));
        assert_eq!(Quantity::Rate.unit("°/s").map(|u| u.name), Some("deg/s"));
        assert_eq!(Quantity::Velocity.unit("km/h"), None);
        assert_eq!(Quantity::Moment.unit("kgf"), None);
    }
}
