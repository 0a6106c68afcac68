//! How a log is to be read: the `[log]` section of a campaign, the Python keywords and the command's options alike.
//!
//! The default is plain CSV: comma, decimal point, UTF-8, SI units, body axes forward-starboard-down, earth axes
//! north-east-down, nothing missing, time increasing. Every deviation has to be said here; nothing is guessed.

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

impl LogOptions {
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
