//! Validation of the reading options: an invalid value is refused with what would be right.

use super::columns;
use super::earth_velocity::VELOCITIES;
use super::options::{ColumnSource, LogOptions};

/// An invalid option.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OptionsError {
    /// The delimiter could be part of a number or a name.
    #[error(
        "delimiter = {0:?}: it must be one ASCII character other than a letter, digit, quote, sign or line end, such \
         as \",\", \";\" or \"\\t\""
    )]
    Delimiter(char),
    /// The decimal mark is neither point nor comma.
    #[error("decimal = {0:?}: it must be \".\" or \",\"")]
    Decimal(char),
    /// Delimiter and decimal mark are the same.
    #[error("delimiter and decimal are both {0:?}: a delimiter could not be told from a decimal mark")]
    DelimiterIsDecimal(char),
    /// The comment mark is empty.
    #[error("comment = \"\": every line would be a comment")]
    EmptyComment,
    /// A scale that is zero or not finite.
    #[error("columns.{column}: scale = {scale} must be finite and not 0")]
    Scale {
        /// Canonical name.
        column: String,
        /// The value given.
        scale: f64,
    },
    /// A sign other than 1 or −1.
    #[error("columns.{column}: sign = {sign} must be 1 or -1")]
    Sign {
        /// Canonical name.
        column: String,
        /// The value given.
        sign: i8,
    },
    /// A negative sign or scale of the time, or a scale of dates, durations or times of day.
    #[error(
        "columns.t: time accepts a unit (s, ms, us, ns, min, h) and a positive scale, but no sign; dates, durations \
         and times of day accept none of these"
    )]
    TimeScale,
    /// A unit in which the column is not read.
    #[error("columns.{column}: unit = {unit:?} is not one of {accepted}")]
    Unit {
        /// Canonical name.
        column: String,
        /// The value given.
        unit: String,
        /// The accepted units.
        accepted: String,
    },
    /// Two canonical names refer to the same column.
    #[error("columns.{first} and columns.{second} both name the column {header:?}")]
    SameHeader {
        /// One canonical name.
        first: String,
        /// The other.
        second: String,
        /// The header both name.
        header: String,
    },
    /// Velocities with different earth axes, or only some of them along earth axes.
    #[error("columns.{0}: velocities along earth axes are rotated together: give the same frame for u, v and w")]
    VelocityFrames(&'static str),
    /// Velocities along earth axes in a log that is read piece by piece.
    #[error(
        "columns.u: velocities along earth axes cannot be rotated in a log that is too large to keep: `hydrosysid \
         convert` it first"
    )]
    StreamedVelocity,
    /// Channels computed from others in a log that is read piece by piece.
    #[error(
        "columns: a log that is too large to keep cannot compute positions from latitude and longitude, angles from a \
         quaternion, or velocities from speed and course"
    )]
    StreamedDerived,
    /// `time_unit` together with `time_format`.
    #[error("time_unit and time_format exclude each other: dates and times of day have no unit")]
    UnitOfDate,
    /// A limit of zero.
    #[error("{0} must be at least 1")]
    Limit(&'static str),
}

impl LogOptions {
    /// Refuses invalid values.
    ///
    /// # Errors
    /// The first invalid value, with what would be right.
    pub fn validate(&self) -> Result<(), OptionsError> {
        self.validate_each()?;
        let frame = self.earth_velocity();
        let other = |name: &&str| self.columns.get(*name).and_then(|source| source.frame?.earth()) != frame;
        VELOCITIES.into_iter().find(other).map_or(Ok(()), |name| Err(OptionsError::VelocityFrames(name)))
    }

    /// Refuses values that are invalid on their own, without the test that `u`, `v` and `w` have
    /// the same earth axes: a caller may ask for one of them alone.
    ///
    /// # Errors
    /// The first invalid value, with what would be right.
    pub fn validate_each(&self) -> Result<(), OptionsError> {
        let d = self.delimiter;
        let part_of_text = d.is_ascii_alphanumeric() || matches!(d, '"' | '\n' | '\r' | '\0' | '+' | '-' | '_');
        if !d.is_ascii() || part_of_text {
            return Err(OptionsError::Delimiter(d));
        }
        if !matches!(self.decimal, '.' | ',') {
            return Err(OptionsError::Decimal(self.decimal));
        }
        if d == self.decimal {
            return Err(OptionsError::DelimiterIsDecimal(d));
        }
        if self.comment.as_deref().is_some_and(|c| c.trim().is_empty()) {
            return Err(OptionsError::EmptyComment);
        }
        if self.time_unit.is_some() && self.time_format.is_some() {
            return Err(OptionsError::UnitOfDate);
        }
        for (limit, name) in [(self.max_line_bytes, "max_line_bytes"), (self.max_columns, "max_columns")] {
            if limit == 0 {
                return Err(OptionsError::Limit(name));
            }
        }
        self.columns.iter().try_for_each(|(column, source)| self.validate_column(column, source))
    }

    fn validate_column(&self, column: &str, source: &ColumnSource) -> Result<(), OptionsError> {
        let (column, header) = (column.to_string(), source.name.trim());
        if !source.scale.is_finite() || source.scale == 0.0 {
            return Err(OptionsError::Scale { column, scale: source.scale });
        }
        if source.sign.abs() != 1 {
            return Err(OptionsError::Sign { column, sign: source.sign });
        }
        let is_scaled = (source.scale - 1.0).abs() > 0.0;
        if column == "t" && (source.sign != 1 || source.scale < 0.0 || is_scaled && self.time_format.is_some()) {
            return Err(OptionsError::TimeScale);
        }
        if let (Some(unit), Some(quantity)) = (&source.unit, columns::quantity(&column))
            && quantity.unit(unit).is_none()
        {
            return Err(OptionsError::Unit { column, unit: unit.clone(), accepted: quantity.accepted() });
        }
        match self.columns.iter().find(|(other, s)| **other < column && s.name.trim() == header) {
            Some((first, _)) => {
                Err(OptionsError::SameHeader { first: first.clone(), second: column, header: header.to_string() })
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::options::EarthFrame;

    #[test]
    fn velocities_along_earth_axes_are_three() {
        let read = |text: &str| toml::from_str::<LogOptions>(text).unwrap();
        let of = |c: &str, f: &str| format!("columns.{c} = {{ name = \"{c}\", frame = \"{f}\" }}\n");
        let ned = read(&(of("u", "ned") + &of("v", "ned") + &of("w", "ned")));
        ned.validate().unwrap();
        assert_eq!(ned.earth_velocity(), Some(EarthFrame::Ned));
        let mixed = read(&(of("u", "ned") + &of("v", "ned") + &of("w", "frd")));
        assert_eq!(mixed.validate(), Err(OptionsError::VelocityFrames("w")));
        assert_eq!(read(&of("r", "flu")).earth_velocity(), None);
    }

    #[test]
    fn impossible_values_are_refused() {
        let refused = |text: &str| toml::from_str::<LogOptions>(text).unwrap().validate().unwrap_err();
        assert_eq!(refused("delimiter = \"e\""), OptionsError::Delimiter('e'));
        assert_eq!(refused("decimal = \",\""), OptionsError::DelimiterIsDecimal(','));
        assert_eq!(refused("comment = \" \""), OptionsError::EmptyComment);
        assert_eq!(refused("max_columns = 0"), OptionsError::Limit("max_columns"));
        assert_eq!(refused("columns.t = { name = \"t\", scale = -2.0 }"), OptionsError::TimeScale);
        assert_eq!(refused("columns.t = { name = \"t\", sign = -1 }"), OptionsError::TimeScale);
        let dated = "time_format = \"iso8601\"\ncolumns.t = { name = \"t\", scale = 2.0 }";
        assert_eq!(refused(dated), OptionsError::TimeScale);
        let unit = refused("columns.r = { name = \"gyro\", unit = \"grad/s\" }").to_string();
        assert!(unit.contains("deg/s") && unit.contains("grad/s"), "{unit}");
        assert!(matches!(refused("columns = { u = \"a\", v = \"a\" }"), OptionsError::SameHeader { .. }));
    }
}
