//! How a log is to be read: the `[log]` section of a campaign, the Python keywords and the command's options alike.
//!
//! The default is plain CSV: comma, decimal point, UTF-8, SI units, body axes forward-starboard-down, earth axes
//! north-east-down, nothing missing, time increasing. Every deviation has to be said here; nothing is guessed.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::columns;
use super::earth_velocity::VELOCITIES;

/// Reading options. Unknown keys are refused.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LogOptions {
    /// Character between fields, ASCII.
    pub delimiter: char,
    /// Decimal mark: `.` or `,`.
    pub decimal: char,
    /// Lines that begin with this text are skipped.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub comment: Option<String>,
    /// Whether the line below the header holds the units of the columns.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub unit_row: bool,
    /// Canonical name → where it stands in the file.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub columns: BTreeMap<String, ColumnSource>,
    /// Unit of `t`; wins over a unit in the header.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_unit: Option<TimeUnit>,
    /// How `t` is written; a number unless said otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_format: Option<TimeFormat>,
    /// What an empty or NaN cell means.
    pub missing: Missing,
    /// Further texts that mean "no value" (`N/A`, `-32.768`); a number matches however it is written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub missing_values: Vec<String>,
    /// What a value means that a slower sensor's channel only repeats.
    pub repeated: Repeated,
    /// What to do with a row that repeats the time stamp before it.
    pub duplicates: Duplicates,
    /// Sort the rows by time.
    pub sort: bool,
    /// What to do with a last row that is cut short.
    pub truncated: Truncated,
    /// Body axes of the file.
    pub body_frame: BodyFrame,
    /// Earth axes of the file.
    pub earth_frame: EarthFrame,
    /// Whether `x`, `y`, `z` are integrated velocity or measured apart from it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_source: Option<PositionSource>,
    /// What `u`, `v`, `w` are measured against.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_reference: Option<VelocityReference>,
    /// Longest record accepted, bytes. The default, 1 MiB, holds ten thousand columns and stops a file without line ends.
    pub max_line_bytes: usize,
    /// Most columns accepted.
    pub max_columns: usize,
}

impl Default for LogOptions {
    fn default() -> LogOptions {
        LogOptions {
            delimiter: ',',
            decimal: '.',
            comment: None,
            unit_row: false,
            columns: BTreeMap::new(),
            time_unit: None,
            time_format: None,
            missing: Missing::Error,
            missing_values: Vec::new(),
            repeated: Repeated::Auto,
            duplicates: Duplicates::Error,
            sort: false,
            truncated: Truncated::Error,
            body_frame: BodyFrame::Frd,
            earth_frame: EarthFrame::Ned,
            position_source: None,
            velocity_reference: None,
            max_line_bytes: 1 << 20,
            max_columns: 10_000,
        }
    }
}

/// Where a channel stands in the file: `"Yaw rate [deg/s]"` or `{name = "Yaw rate", unit = "deg/s", sign = -1}`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColumnSource {
    /// Header in the file, with or without its `[unit]`.
    pub name: String,
    /// Unit in the file; wins over one in the header.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Factor after the conversion of units, finite and not zero.
    pub scale: f64,
    /// Sign: 1 or −1.
    pub sign: i8,
    /// Axes of this channel alone; `u`, `v`, `w` in earth axes are turned to body axes by the attitude.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<Frame>,
}

impl From<&str> for ColumnSource {
    fn from(name: &str) -> ColumnSource {
        ColumnSource { name: name.to_string(), unit: None, scale: 1.0, sign: 1, frame: None }
    }
}

/// The table form of [`ColumnSource`].
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ColumnTable {
    name: String,
    unit: Option<String>,
    #[serde(default = "one")]
    scale: f64,
    #[serde(default = "plus")]
    sign: i8,
    frame: Option<Frame>,
}

const fn one() -> f64 {
    1.0
}

const fn plus() -> i8 {
    1
}

impl<'de> Deserialize<'de> for ColumnSource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<ColumnSource, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = ColumnSource;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("the header of a column, or a table with name, unit, scale, sign, frame")
            }

            fn visit_str<E>(self, name: &str) -> Result<ColumnSource, E> {
                Ok(ColumnSource::from(name))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ColumnSource, A::Error> {
                let ColumnTable { name, unit, scale, sign, frame } =
                    ColumnTable::deserialize(MapAccessDeserializer::new(map))?;
                Ok(ColumnSource { name, unit, scale, sign, frame })
            }
        }
        deserializer.deserialize_any(Either)
    }
}

macro_rules! choice {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $name { $($(#[$vdoc])* $variant),* }
    };
}

choice! {
    /// Unit of time stamps.
    TimeUnit {
        /// Second.
        S,
        /// Millisecond.
        Ms,
        /// Microsecond.
        Us,
        /// Nanosecond.
        Ns,
        /// Minute.
        Min,
        /// Hour.
        H,
    }
}

impl TimeUnit {
    /// How many of the unit make one second.
    pub const fn per_second(self) -> f64 {
        [1.0, 1e3, 1e6, 1e9, 1.0 / 60.0, 1.0 / 3600.0][self as usize]
    }

    /// The unit of this name.
    pub fn from_name(name: &str) -> Option<TimeUnit> {
        match name {
            "s" => Some(TimeUnit::S),
            "ms" => Some(TimeUnit::Ms),
            "us" | "µs" | "μs" => Some(TimeUnit::Us),
            "ns" => Some(TimeUnit::Ns),
            "min" => Some(TimeUnit::Min),
            "h" => Some(TimeUnit::H),
            _ => None,
        }
    }
}

/// How time stamps are written when they are not numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum TimeFormat {
    /// `2024-07-01T10:40:00.100Z`.
    #[serde(rename = "iso8601")]
    Iso8601,
    /// `12.3 sec`, as MATLAB writes durations; also `ms`, `min`, `hr`, `days`.
    #[serde(rename = "duration")]
    Duration,
    /// `10:40:00.100`, which goes on over midnight.
    #[serde(rename = "time_of_day")]
    TimeOfDay,
}

choice! {
    /// What an empty cell, a NaN or one of `missing_values` means.
    Missing {
        /// The log is refused.
        Error,
        /// The row is left out.
        Drop,
        /// This sensor has no new sample at this instant.
        NoSample,
    }
}

choice! {
    /// What a repeated value of a measured channel means where a slower sensor is written at the rate of the log.
    Repeated {
        /// No sample, where the whole log is read; a warning says which. A log that is read piece by piece takes them as samples.
        Auto,
        /// A sample like any other.
        Sample,
        /// This sensor has no new sample at this instant.
        NoSample,
    }
}

choice! {
    /// What to do with a row that repeats the time stamp before it.
    Duplicates {
        /// The log is refused.
        Error,
        /// The first of them is kept.
        First,
    }
}

choice! {
    /// What to do with a last row that is cut short.
    Truncated {
        /// The log is refused.
        Error,
        /// The row is left out.
        Drop,
    }
}

choice! {
    /// Body axes.
    BodyFrame {
        /// Forward, starboard, down.
        Frd,
        /// Forward, port, up.
        Flu,
    }
}

choice! {
    /// Earth axes.
    EarthFrame {
        /// North, east, down.
        Ned,
        /// East, north, up.
        Enu,
    }
}

choice! {
    /// Axes of one channel.
    Frame {
        /// Body: forward, starboard, down.
        Frd,
        /// Body: forward, port, up.
        Flu,
        /// Earth: north, east, down.
        Ned,
        /// Earth: east, north, up.
        Enu,
    }
}

impl Frame {
    /// The body axes that are meant, if any.
    pub const fn body(self) -> Option<BodyFrame> {
        match self {
            Frame::Frd => Some(BodyFrame::Frd),
            Frame::Flu => Some(BodyFrame::Flu),
            Frame::Ned | Frame::Enu => None,
        }
    }

    /// The earth axes that are meant, if any.
    pub const fn earth(self) -> Option<EarthFrame> {
        match self {
            Frame::Ned => Some(EarthFrame::Ned),
            Frame::Enu => Some(EarthFrame::Enu),
            Frame::Frd | Frame::Flu => None,
        }
    }
}

choice! {
    /// Where the position comes from.
    PositionSource {
        /// Integrated from velocity and heading: says nothing new.
        DeadReckoned,
        /// Measured apart (acoustics, camera, GNSS).
        Independent,
    }
}

choice! {
    /// What the velocity is measured against.
    VelocityReference {
        /// The bottom.
        Ground,
        /// The water.
        Water,
    }
}

/// An option that cannot be.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OptionsError {
    /// The delimiter could be part of a number or a name.
    #[error(
        "delimiter = {0:?}: it must be one ASCII character that is no letter, digit, quote, sign or line end, such as \",\", \";\" or \"\\t\""
    )]
    Delimiter(char),
    /// The decimal mark is neither point nor comma.
    #[error("decimal = {0:?}: it must be \".\" or \",\"")]
    Decimal(char),
    /// Delimiter and decimal mark are the same.
    #[error("delimiter and decimal are both {0:?}: a field could not be told from a decimal")]
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
    /// A sign that is none.
    #[error("columns.{column}: sign = {sign} must be 1 or -1")]
    Sign {
        /// Canonical name.
        column: String,
        /// The value given.
        sign: i8,
    },
    /// Time runs forward, and dates have no scale.
    #[error(
        "columns.t: time takes a unit (s, ms, us, ns, min, h) and a positive scale, no sign; dates, durations and times of day take none"
    )]
    TimeScale,
    /// A unit the column does not have.
    #[error("columns.{column}: unit = {unit:?} is not one of {accepted}")]
    Unit {
        /// Canonical name.
        column: String,
        /// The value given.
        unit: String,
        /// The accepted ones.
        accepted: String,
    },
    /// Two canonical names take the same column.
    #[error("columns.{first} and columns.{second} both name the column {header:?}")]
    SameHeader {
        /// One canonical name.
        first: String,
        /// The other.
        second: String,
        /// The header both name.
        header: String,
    },
    /// Velocities in different axes.
    #[error("columns.{0}: velocities along earth axes are turned together: say the same frame for u, v and w")]
    VelocityFrames(&'static str),
    /// Velocities along earth axes in a log that is read piece by piece.
    #[error(
        "columns.u: velocities along earth axes are not turned in a log that is too large to keep: `hydrosysid convert` it first"
    )]
    StreamedVelocity,
    /// Channels told by others in a log that is read piece by piece.
    #[error(
        "columns: positions by latitude and longitude, angles by a quaternion and velocities by speed and course are not told in a log that is too large to keep"
    )]
    StreamedDerived,
    /// `time_unit` with dates.
    #[error("time_unit and time_format exclude each other: dates and times of day have no unit")]
    UnitOfDate,
    /// A limit of zero.
    #[error("{0} must be at least 1")]
    Limit(&'static str),
}

impl LogOptions {
    /// Refuses values that cannot be meant.
    ///
    /// # Errors
    /// The first such value, with what would be right.
    pub fn validate(&self) -> Result<(), OptionsError> {
        self.validate_each()?;
        let frame = self.earth_velocity();
        let other = |name: &&str| self.columns.get(*name).and_then(|source| source.frame?.earth()) != frame;
        VELOCITIES.into_iter().find(other).map_or(Ok(()), |name| Err(OptionsError::VelocityFrames(name)))
    }

    /// Refuses values that cannot be meant, each by itself: one channel may be asked for without its neighbours.
    ///
    /// # Errors
    /// The first such value, with what would be right.
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

    /// Whether `u`, `v`, `w` are velocities through the water.
    pub fn is_through_water(&self) -> bool {
        self.velocity_reference == Some(VelocityReference::Water)
    }

    /// The earth axes that `u`, `v`, `w` are logged along, where they are.
    pub fn earth_velocity(&self) -> Option<EarthFrame> {
        VELOCITIES.into_iter().find_map(|name| self.columns.get(name)?.frame?.earth())
    }

    /// Factor of the time stamps after their unit: for a counter of rows the time that one takes.
    pub fn time_scale(&self) -> f64 {
        self.columns.get("t").map_or(1.0, |source| source.scale)
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

    #[test]
    fn a_campaign_section_reads_and_comes_back() {
        let text = "delimiter = \";\"\ndecimal = \",\"\nmissing = \"no_sample\"\ntime_unit = \"ns\"\nbody_frame = \"flu\"\n\
                    [columns]\nt = \"Time [s]\"\nr = { name = \"gyro z\", unit = \"deg/s\", sign = -1 }\n";
        let options: LogOptions = toml::from_str(text).unwrap();
        assert_eq!(options.columns["r"].sign, -1);
        assert_eq!(options.missing, Missing::NoSample);
        options.validate().unwrap();
        let again: LogOptions = toml::from_str(&toml::to_string(&options).unwrap()).unwrap();
        assert_eq!(again, options);
    }

    #[test]
    fn unknown_keys_are_refused_by_name() {
        let error = toml::from_str::<LogOptions>("delimitor = \";\"").unwrap_err().to_string();
        assert!(error.contains("delimitor"), "{error}");
        let error = toml::from_str::<LogOptions>("columns.r = { name = \"r\", units = \"deg/s\" }").unwrap_err();
        assert!(error.to_string().contains("units"), "{error}");
    }

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
