//! Options for reading a log: the `[log]` section of a campaign, the Python keywords and the
//! options of the command.
//!
//! The default is plain CSV: comma, decimal point, UTF-8, SI units, body axes
//! forward-starboard-down, earth axes north-east-down, no missing values, increasing time. Every
//! deviation must be stated here; nothing is guessed.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

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
    /// Source of a channel in the file, by canonical name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub columns: BTreeMap<String, ColumnSource>,
    /// Unit of `t`; takes precedence over a unit in the header.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_unit: Option<TimeUnit>,
    /// Notation of `t`; a number by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_format: Option<TimeFormat>,
    /// Meaning of an empty cell or NaN.
    pub missing: Missing,
    /// Further texts that mean "no value" (`N/A`, `-32.768`); a number matches in any notation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub missing_values: Vec<String>,
    /// Meaning of a value that only repeats the last sample of a slower sensor.
    pub repeated: Repeated,
    /// Treatment of a row that repeats the previous time stamp.
    pub duplicates: Duplicates,
    /// Whether to sort the rows by time.
    pub sort: bool,
    /// Treatment of a last row that is cut short.
    pub truncated: Truncated,
    /// Body axes of the file.
    pub body_frame: BodyFrame,
    /// Earth axes of the file.
    pub earth_frame: EarthFrame,
    /// Whether `x`, `y`, `z` are integrated velocity or measured independently of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_source: Option<PositionSource>,
    /// Reference of `u`, `v`, `w`: ground or water.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_reference: Option<VelocityReference>,
    /// Length of the longest record accepted, bytes. The default, 1 MiB, holds ten thousand columns
    /// and stops a file without line ends.
    pub max_line_bytes: usize,
    /// Largest number of columns accepted.
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

/// Source of a channel in the file: `"Yaw rate [deg/s]"` or
/// `{name = "Yaw rate", unit = "deg/s", sign = -1}`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColumnSource {
    /// Header in the file, with or without its `[unit]`.
    pub name: String,
    /// Unit in the file; takes precedence over a unit in the header.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Factor applied after the conversion of units, finite and not zero.
    pub scale: f64,
    /// Sign: 1 or −1.
    pub sign: i8,
    /// Axes of this channel alone; `u`, `v`, `w` along earth axes are turned to body axes by the attitude.
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
    /// Number of these units in one second.
    pub const fn per_second(self) -> f64 {
        [1.0, 1e3, 1e6, 1e9, 1.0 / 60.0, 1.0 / 3600.0][self as usize]
    }

    /// Returns the unit of this name.
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

/// Notation of time stamps that are not numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum TimeFormat {
    /// `2024-07-01T10:40:00.100Z`.
    #[serde(rename = "iso8601")]
    Iso8601,
    /// `12.3 sec`, as MATLAB writes durations; also `ms`, `min`, `hr`, `days`.
    #[serde(rename = "duration")]
    Duration,
    /// `10:40:00.100`; continues over midnight.
    #[serde(rename = "time_of_day")]
    TimeOfDay,
}

choice! {
    /// Meaning of an empty cell, a NaN or one of `missing_values`.
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
    /// Meaning of a repeated value of a measured channel, if a slower sensor is written at the rate
    /// of the log.
    Repeated {
        /// No sample, if the whole log is read; a warning names the channels. A sample, if the log
        /// is read piece by piece.
        Auto,
        /// A sample like any other.
        Sample,
        /// This sensor has no new sample at this instant.
        NoSample,
    }
}

choice! {
    /// Treatment of a row that repeats the previous time stamp.
    Duplicates {
        /// The log is refused.
        Error,
        /// The first of these rows is kept.
        First,
    }
}

choice! {
    /// Treatment of a last row that is cut short.
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
    /// Returns the body axes of this frame, if it is one of the body.
    pub const fn body(self) -> Option<BodyFrame> {
        match self {
            Frame::Frd => Some(BodyFrame::Frd),
            Frame::Flu => Some(BodyFrame::Flu),
            Frame::Ned | Frame::Enu => None,
        }
    }

    /// Returns the earth axes of this frame, if it is one of the earth.
    pub const fn earth(self) -> Option<EarthFrame> {
        match self {
            Frame::Ned => Some(EarthFrame::Ned),
            Frame::Enu => Some(EarthFrame::Enu),
            Frame::Frd | Frame::Flu => None,
        }
    }
}

choice! {
    /// Source of the position.
    PositionSource {
        /// Integrated from velocity and heading: no independent information.
        DeadReckoned,
        /// Measured independently (acoustics, camera, GNSS).
        Independent,
    }
}

choice! {
    /// Reference of the velocity.
    VelocityReference {
        /// The bottom.
        Ground,
        /// The water.
        Water,
    }
}

impl LogOptions {
    /// Whether `u`, `v`, `w` are velocities through the water.
    pub fn is_through_water(&self) -> bool {
        self.velocity_reference == Some(VelocityReference::Water)
    }

    /// Returns the earth axes along which `u`, `v`, `w` are logged; `None` if they are along body axes.
    pub fn earth_velocity(&self) -> Option<EarthFrame> {
        VELOCITIES.into_iter().find_map(|name| self.columns.get(name)?.frame?.earth())
    }

    /// Returns the factor of the time stamps after their unit: the time of one row, if `t` counts rows.
    pub fn time_scale(&self) -> f64 {
        self.columns.get("t").map_or(1.0, |source| source.scale)
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
}
