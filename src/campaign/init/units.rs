//! Conversion of a unit as it is written to one that the reader knows, with a factor if the reader
//! does not know it.

use super::{meaning, words};
use crate::log::columns::{self, Quantity};
use crate::log::options::ColumnSource;

/// Units that the reader does not know: quantity, name, unit that it knows instead, factor.
const OTHERS: &[(Quantity, &str, &str, f64)] = &[
    (Quantity::Velocity, "km/h", "m/s", 1.0 / 3.6),
    (Quantity::Velocity, "ft/s", "m/s", 0.3048),
    (Quantity::Position, "mm", "m", 1e-3),
    (Quantity::Position, "cm", "m", 1e-2),
    (Quantity::Position, "ft", "m", 0.3048),
    (Quantity::Position, "dm", "m", 0.1),
    // of fresh water, 9 806.65 N/m3: in sea water the depth is 1/40 less
    (Quantity::Position, "Pa", "m", 1.0 / 9806.65),
    (Quantity::Position, "hPa", "m", 1e2 / 9806.65),
    (Quantity::Position, "mbar", "m", 1e2 / 9806.65),
    (Quantity::Position, "kPa", "m", 1e3 / 9806.65),
    (Quantity::Position, "dbar", "m", 1e4 / 9806.65),
    (Quantity::Position, "bar", "m", 1e5 / 9806.65),
    (Quantity::Rate, "rpm", "rad/s", std::f64::consts::TAU / 60.0),
    (Quantity::Rate, "rps", "rad/s", std::f64::consts::TAU),
    (Quantity::Rate, "mrad/s", "rad/s", 1e-3),
    (Quantity::Rate, "deg/min", "deg/s", 1.0 / 60.0),
    (Quantity::Angle, "mrad", "rad", 1e-3),
    (Quantity::Position, "km", "m", 1e3),
    // for a force "kn" is not the knot
    (Quantity::Force, "kN", "N", 1e3),
    (Quantity::Force, "kn", "N", 1e3),
    (Quantity::Force, "mN", "N", 1e-3),
    (Quantity::Force, "gf", "N", 9.806_65e-3),
    (Quantity::Moment, "kN*m", "N*m", 1e3),
    (Quantity::Moment, "mN*m", "N*m", 1e-3),
    (Quantity::Command, "%", "1", 0.01),
    (Quantity::Command, "rpm", "1", 1.0),
    (Quantity::Command, "rps", "1", 60.0),
    (Quantity::Command, "rad/s", "1", 60.0 / std::f64::consts::TAU),
];

/// Texts that stand for a unit and mean none.
const NONE: [&str; 3] = ["-", "1", "%"];

/// Whether a unit says that a command is a part of the full command.
pub fn is_part(unit: &str) -> bool {
    NONE.contains(&unit)
}

/// The unit that the reader knows instead of this one, and the factor.
fn other(quantity: Quantity, unit: &str) -> Option<(&'static str, f64)> {
    let found = OTHERS.iter().find(|(q, name, ..)| (*q, *name) == (quantity, unit))?;
    Some((found.2, found.3))
}

/// Whether a quantity can be read in a unit.
pub fn is_read(quantity: Quantity, unit: &str) -> bool {
    quantity.unit(unit).is_some() || other(quantity, unit).is_some()
}

/// Whether a word alone is a unit of any quantity.
pub fn is_unit(word: &str) -> bool {
    use Quantity::{Angle, Command, Force, Moment, Position, Rate, Time, Velocity};
    let all = [Time, Position, Angle, Velocity, Rate, Force, Moment, Command];
    // case matters for a single letter: `v` is a velocity, `V` a volt
    let unit = if word.chars().count() == 1 { word.to_string() } else { words::spelled(word) };
    let unit = unit.trim_matches(['[', ']', '(', ')']);
    all.into_iter().any(|quantity| is_read(quantity, unit))
}

/// Factor from this unit to turns a minute; 1 without a unit.
pub fn turns_a_minute(unit: Option<&str>) -> f64 {
    unit.filter(|unit| *unit != "%").and_then(|unit| other(Quantity::Command, unit)).map_or(1.0, |(_, factor)| factor)
}

/// The unit in brackets after a name if none of the quantities can be read in it, else `None`.
/// Words that say where a column comes from are no units, and neither is the last word of a name:
/// the m of `yaw_m` may mean measured.
pub fn unknown<'a>(quantities: &[Quantity], header: &str, unit: Option<&'a str>) -> Option<&'a str> {
    let stated = unit.filter(|_| header.trim_end().ends_with([']', ')']))?;
    let is_word = |word: &str| meaning::is_filler(&word.to_lowercase());
    let is_none = NONE.contains(&stated) || !stated.chars().any(|c| c.is_alphabetic() || c == '°') || is_word(stated);
    let known = |quantity: &Quantity| *quantity == Quantity::Time || is_read(*quantity, stated);
    (!is_none && !quantities.is_empty() && !quantities.iter().any(known)).then_some(stated)
}

/// The remark on a column that is left out because its unit is not known.
pub fn left_out(channel: &str, header: &str, unit: &str) -> String {
    let usual = columns::quantity(channel).and_then(|q| q.units().first()).map_or("", |u| u.name);
    format!(
        "{header:?} would be {channel} by its name and is left out: the unit {unit:?} is not known. Write \
         columns.{channel} = {{ name = {header:?}, unit = {usual:?}, scale = … }}, where scale is one {unit} in {usual}"
    )
}

/// The column of a channel in `unit`, and the remark on the unit.
pub fn source(channel: &str, header: &str, unit: Option<&str>, sign: i8) -> (ColumnSource, String) {
    let mut source = ColumnSource { sign, ..ColumnSource::from(header) };
    let mut how = if sign < 0 { "; it counts upwards, so sign = -1".to_string() } else { String::new() };
    let Some(unit) = unit else { return (source, how) };
    let Some(quantity) = columns::quantity(channel) else {
        // a channel without a quantity is converted to SI, too, if its unit is known
        if columns::split_header(header).1.is_none() && columns::any_unit(unit).is_some() {
            source.unit = Some(unit.to_string());
        }
        return (source, how);
    };
    let bracketed = columns::split_header(header).1.and_then(|u| quantity.unit(u));
    if let Some(known) = quantity.unit(unit) {
        let usual = quantity.units().first().is_some_and(|u| u.name == known.name);
        if bracketed.is_none() && !usual {
            source.unit = Some(known.name.into());
            how += &format!("; {} according to the name", known.name);
        }
    } else if let Some((to, factor)) = other(quantity, unit) {
        source.unit = Some(to.into());
        source.scale = factor;
        how += &format!("; from {unit} with the factor {factor:.6}");
    } else if bracketed.is_none() {
        let usual = quantity.units().first().map_or("", |u| u.name);
        source.unit = Some(usual.into());
        how += &format!("; the unit {unit:?} is not known, {usual} is assumed");
    }
    (source, how)
}

/// A value in SI as the file writes it.
pub fn as_written(channel: &str, source: Option<&ColumnSource>, value: f64) -> String {
    let header = source.map_or(channel, |s| s.name.as_str());
    let unit = source.and_then(|s| s.unit.as_deref()).or(columns::split_header(header).1);
    let known = columns::quantity(channel).and_then(|q| unit.and_then(|u| q.unit(u)));
    let (times, over) = known.map_or((1.0, 1.0), |u| (u.times, u.over));
    let (scale, sign) = source.map_or((1.0, 1.0), |s| (s.scale, f64::from(s.sign)));
    let raw = value / scale * sign * over / times;
    // nine digits: removes the rounding errors of conversions there and back
    let short: f64 = format!("{raw:.8e}").parse().unwrap_or(raw);
    format!("{short}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_kept_translated_or_told() {
        let (deg, how) = source("psi", "yaw_deg", Some("deg"), 1);
        assert_eq!((deg.unit.as_deref(), deg.scale), (Some("deg"), 1.0));
        assert!(how.contains("deg"));
        let (km, _) = source("u", "speed [km/h]", Some("km/h"), 1);
        assert_eq!((km.unit.as_deref(), km.scale), (Some("m/s"), 1.0 / 3.6));
        assert_eq!(source("z", "depth [m]", Some("m"), 1).0, ColumnSource::from("depth [m]"));
        assert_eq!(source("r", "gyro [counts]", Some("counts"), 1).0.unit.as_deref(), Some("rad/s"));
        let (kilo, _) = source("tau_u", "Fx [kN]", Some("kN"), 1);
        assert_eq!((kilo.unit.as_deref(), kilo.scale), (Some("N"), 1e3));
        let (kilo, _) = source("tau_r", "Mz [kNm]", Some("kN*m"), 1);
        assert_eq!((kilo.unit.as_deref(), kilo.scale), (Some("N*m"), 1e3));
        assert_eq!(source("V1", "n1 [rps]", Some("rps"), 1).0.scale, 60.0);
        let there_and_back = as_written("psi", Some(&deg), (-9999.0_f64).to_radians());
        assert_eq!(there_and_back, "-9999");
    }

    #[test]
    fn a_unit_that_is_stated_and_unknown_is_told_from_a_word() {
        use Quantity::{Command, Force, Position, Time};
        assert_eq!(unknown(&[Force], "Fx [foo]", Some("foo")), Some("foo"));
        assert_eq!(unknown(&[Force], "Fx (foo)", Some("foo")), Some("foo"));
        for (quantity, header, unit) in [
            (Force, "Fx [kN]", "kN"),
            (Force, "Fx [-]", "-"),
            (Force, "Fx [%]", "%"),
            (Position, "pos_n", "N"),
            (Position, "x [ekf]", "ekf"),
            (Command, "cmd [-1..1]", "-1..1"),
            (Time, "t [ticks]", "ticks"),
        ] {
            assert_eq!(unknown(&[quantity], header, Some(unit)), None, "{header}");
        }
        let told = left_out("tau_u", "Fx [foo]", "foo");
        assert!(told.contains("columns.tau_u = { name = \"Fx [foo]\", unit = \"N\", scale = … }"), "{told}");
    }
}
