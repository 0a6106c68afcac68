//! Channels computed from other quantities of the log, where `[log.columns]` names these.
//!
//! ```text
//! latitude, longitude  →  x, y               metres north and east of the first fix        [`geodetic`]
//! qw, qx, qy, qz       →  phi, theta, psi    angles of the rotation from body to earth      [`quaternion`]
//! sog, cog             →  u, v               speed and course over ground, by the heading   [`ground`]
//! v_north, v_east      →  u, v               north and east over ground, by the heading     [`ground`]
//! ```
//!
//! A sample is a row that has values in all columns of the group. Rows that only repeat the last
//! sample of a slower sensor are no samples, as for any measured channel.

pub mod geodetic;
mod ground;
mod quaternion;

use std::collections::BTreeMap;

use super::check;
use super::options::{LogOptions, Repeated};
use crate::run::Signal;

/// Values of one sample, in the order of the channels of the group; the rest is 0.
type Sample = [f64; 3];

/// Samples computed for a group, `None` where a row is no measurement; and a sentence that says how.
type Told = Result<(Vec<Option<Sample>>, String), DerivedError>;

/// A group of columns, and the channels computed from them.
struct Group {
    sources: &'static [&'static str],
    gives: &'static [&'static str],
    /// SI unit of the channels.
    unit: &'static str,
    tell: fn(&Columns<'_>) -> Told,
}

const GROUPS: [Group; 4] = [
    Group { sources: &["latitude", "longitude"], gives: &["x", "y"], unit: "m", tell: geodetic::tell },
    Group { sources: &["qw", "qx", "qy", "qz"], gives: &["phi", "theta", "psi"], unit: "rad", tell: quaternion::tell },
    Group { sources: &["sog", "cog"], gives: &["u", "v"], unit: "m/s", tell: ground::tell },
    Group { sources: &["v_north", "v_east"], gives: &["u", "v"], unit: "m/s", tell: ground::tell_components },
];

/// The columns of a group at their common time stamps.
struct Columns<'a> {
    time: Vec<f64>,
    /// One list per column, in the order of the group.
    values: Vec<Vec<f64>>,
    /// Whether each column was read as an angle in radians.
    radians: Vec<bool>,
    signals: &'a BTreeMap<String, Signal>,
    options: &'a LogOptions,
}

/// Reason why a group gives no channels.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DerivedError {
    /// Only a part of the group is named in `[log.columns]`.
    #[error("{has} gives {gives} only together with {lacks}: name the columns of those, too")]
    Part {
        /// The channels of the group.
        gives: String,
        /// The columns that are named.
        has: String,
        /// The columns that are not named.
        lacks: String,
    },
    /// The log has a column for a channel of the group.
    #[error("{gives} is a column of the log, and also computed from {by}: leave one of them out")]
    Twice {
        /// The channel.
        gives: &'static str,
        /// The columns of the group.
        by: String,
    },
    /// The columns have no time stamp in common.
    #[error("{0} never occur in the same row")]
    Apart(String),
    /// A latitude or longitude out of range.
    #[error(
        "{column} = {value} at t = {time} s is not an angle within ±{most} degrees; autopilots write 1e-7 degrees: \
         columns.{column} = {{ name = \"its header\", scale = 1e-7 }}"
    )]
    NoDegrees {
        /// The column.
        column: &'static str,
        /// Its value.
        value: f64,
        /// The largest possible value.
        most: f64,
        /// Time stamp, s.
        time: f64,
    },
    /// No row has a fix.
    #[error("latitude and longitude are 0 in every row: there is no fix")]
    NoFix,
    /// Four numbers that are no rotation.
    #[error(
        "qw, qx, qy, qz have the norm {length} at t = {time} s; a rotation has norm 1: are these its four columns?"
    )]
    NoRotation {
        /// Length of the quaternion.
        length: f64,
        /// Time stamp, s.
        time: f64,
    },
    /// Velocities over ground without a heading.
    #[error("velocities over ground need the heading to become u and v, and there is no psi at the same time")]
    NoHeading,
}

/// Whether `[log.columns]` names a column of any group.
pub fn is_asked(options: &LogOptions) -> bool {
    GROUPS.iter().flat_map(|group| group.sources).any(|source| options.columns.contains_key(*source))
}

/// Returns the columns that the file must have for the channels `required`: those of a group in
/// place of its channels.
pub fn required<'a>(options: &LogOptions, required: &[&'a str]) -> Vec<&'a str> {
    let mut needed = required.to_vec();
    for group in GROUPS.iter().filter(|group| group.is_said(options)) {
        needed.retain(|name| !group.gives.contains(name));
        needed.extend(group.sources);
    }
    needed
}

/// Adds the channels of the groups to `signals`; returns a sentence for each group that says how.
///
/// # Errors
/// See [`DerivedError`]; it comes with the first named column of the group.
pub fn tell(
    signals: &mut BTreeMap<String, Signal>,
    units: &mut BTreeMap<String, &'static str>,
    options: &LogOptions,
) -> Result<Vec<String>, (&'static str, DerivedError)> {
    let mut said = Vec::new();
    for group in &GROUPS {
        let has: Vec<&str> = group.sources.iter().copied().filter(|s| options.columns.contains_key(*s)).collect();
        let Some(first) = group.sources.iter().find(|s| has.contains(*s)) else { continue };
        let because = |error| (*first, error);
        if !group.is_said(options) {
            let lacks: Vec<&str> = group.sources.iter().copied().filter(|s| !has.contains(s)).collect();
            let (gives, has, lacks) = (group.gives.join(", "), has.join(", "), lacks.join(", "));
            return Err(because(DerivedError::Part { gives, has, lacks }));
        }
        if let Some(gives) = group.gives.iter().find(|name| signals.contains_key(**name)) {
            return Err(because(DerivedError::Twice { gives, by: group.sources.join(", ") }));
        }
        let columns = group
            .columns(signals, units, options)
            .ok_or_else(|| because(DerivedError::Apart(group.sources.join(", "))))?;
        let (samples, how) = (group.tell)(&columns).map_err(because)?;
        let kept: Vec<usize> = (0..samples.len()).filter(|k| samples[*k].is_some()).collect();
        let time: std::sync::Arc<[f64]> = kept.iter().map(|k| columns.time[*k]).collect();
        for (i, name) in group.gives.iter().enumerate() {
            let values: Vec<f64> = samples.iter().flatten().map(|sample| sample[i]).collect();
            signals.insert((*name).to_string(), Signal::new(time.clone(), values));
            units.insert((*name).to_string(), group.unit);
        }
        // the columns are not kept beside their channels
        for source in group.sources {
            signals.remove(*source);
            units.remove(*source);
        }
        said.push(how);
    }
    Ok(said)
}

impl Group {
    fn is_said(&self, options: &LogOptions) -> bool {
        self.sources.iter().all(|source| options.columns.contains_key(*source))
    }

    /// Returns the columns at the time stamps that all of them have, without repeated rows; `None`
    /// if there is no such stamp.
    fn columns<'a>(
        &self,
        signals: &'a BTreeMap<String, Signal>,
        units: &BTreeMap<String, &'static str>,
        options: &'a LogOptions,
    ) -> Option<Columns<'a>> {
        let of: Vec<&Signal> = self.sources.iter().map(|name| signals.get(*name)).collect::<Option<_>>()?;
        let (first, others) = of.split_first()?;
        let index = |signal: &Signal, t: f64| signal.time().binary_search_by(|s| s.total_cmp(&t)).ok();
        let together = first.time().iter().enumerate().filter_map(|(k, t)| {
            let others = others.iter().map(|signal| index(signal, *t)).collect::<Option<Vec<usize>>>()?;
            Some((*t, std::iter::once(k).chain(others).collect::<Vec<usize>>()))
        });
        let (mut time, rows): (Vec<f64>, Vec<Vec<usize>>) = together.unzip();
        let column = |i: usize| rows.iter().map(|row| of[i].values()[row[i]]).collect::<Vec<f64>>();
        let mut values: Vec<Vec<f64>> = (0..of.len()).map(column).collect();
        if options.repeated != Repeated::Sample {
            // a combination that repeats only where all columns do
            let all: Vec<f64> = (0..time.len())
                .map(|k| values.iter().enumerate().map(|(i, x)| x[k] * (i as f64 + 2.0).sqrt()).sum())
                .collect();
            if let Some(hold) = check::hold::of(&all) {
                let kept = hold.samples(&all);
                time = kept.iter().map(|k| time[*k]).collect();
                values.iter_mut().for_each(|x| *x = kept.iter().map(|k| x[*k]).collect());
            }
        }
        let radians = self.sources.iter().map(|name| units.get(*name) == Some(&"rad")).collect();
        (!time.is_empty()).then_some(Columns { time, values, radians, signals, options })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::{LogError, LogFile, read_from};

    fn log(columns: &str, text: &str, required: &[&str]) -> Result<LogFile, LogError> {
        let options: LogOptions = toml::from_str(&format!("missing = \"no_sample\"\n[columns]\n{columns}")).unwrap();
        read_from(text.as_bytes(), "log.csv", &options, required)
    }

    #[test]
    fn latitude_and_longitude_are_metres_of_the_first_fix() {
        let text = "t,lat,lon\n0,0,0\n1,380000000,-90000000\n2,380001000,-90000000\n3,380001000,-89999000\n";
        let columns = "latitude = { name = \"lat\", scale = 1e-7 }\nlongitude = { name = \"lon\", scale = 1e-7 }\n";
        let log = log(columns, text, &["t", "x", "y"]).unwrap();
        assert_eq!(log.signals["x"].time(), [1.0, 2.0, 3.0]);
        // 1e-4 degrees at 38 degrees on the ellipsoid: 110,996.5 and 87,832.4 m per degree (tables
        // of the WGS 84), to a millimetre
        for (name, metres) in [("x", [0.0, 11.0996, 11.0996]), ("y", [0.0, 0.0, 8.7832])] {
            for (x, m) in log.signals[name].values().iter().zip(metres) {
                assert!((x - m).abs() < 1e-3, "{name}: {x} for {m}");
            }
        }
        assert_eq!(log.units["x"], "m");
        let said: Vec<&str> = log.notes.iter().map(|note| note.message.as_str()).collect();
        assert!(said.iter().any(|s| s.contains("38.0000000") && s.contains("1 row without a fix")), "{said:?}");
    }

    #[test]
    fn degrees_that_are_none_are_refused_with_the_scale_that_is_missing() {
        let error = log(
            "latitude = \"lat\"\nlongitude = \"lon\"\n",
            "t,lat,lon\n0,380000000,-90000000\n1,380000001,0\n",
            &["t"],
        );
        let error = error.unwrap_err().to_string();
        assert!(error.contains("1e-7") && error.contains("380000000"), "{error}");
    }

    #[test]
    fn a_quaternion_tells_the_angles_and_a_part_of_it_does_not() {
        let (phi, theta, psi) = (0.2, -0.3, 2.5);
        let q = nalgebra::UnitQuaternion::from_euler_angles(phi, theta, psi);
        let row = |t: f64| format!("{t},{},{},{},{}\n", q.w, q.i, q.j, q.k);
        let text = format!("t,w,x1,y1,z1\n{}{}", row(0.0), row(1.0));
        let columns = "qw = \"w\"\nqx = \"x1\"\nqy = \"y1\"\nqz = \"z1\"\n";
        let read = log(columns, &text, &["t", "psi"]).unwrap();
        // written with all digits; rounding of a few operations
        for (name, angle) in [("phi", phi), ("theta", theta), ("psi", psi)] {
            assert!((read.signals[name].values()[1] - angle).abs() < 1e-14, "{name}");
        }
        let error = log("qw = \"w\"\nqx = \"x1\"\nqy = \"y1\"\n", &text, &["t"]).unwrap_err().to_string();
        assert!(error.contains("qz"), "{error}");
        let text = "t,w,x1,y1,z1,psi\n0,1,0,0,0,0\n1,1,0,0,0,0\n";
        let twice = log(columns, text, &["t"]).unwrap_err().to_string();
        assert!(twice.contains("psi is a column of the log"), "{twice}");
        let no_rotation = log(columns, "t,w,x1,y1,z1\n0,1,0,0,0\n1,9,0,0,0\n", &["t"]).unwrap_err().to_string();
        assert!(no_rotation.contains("norm 9 at t = 1"), "{no_rotation}");
    }

    #[test]
    fn speed_and_course_are_velocities_of_the_body_by_the_heading() {
        // heading east, course south of east: the vehicle moves to starboard
        let text = "t,hdg [deg],sog [kn],cog\n0,90,2,120\n1,90,2,120\n2,90,0,7\n";
        let columns = "psi = \"hdg\"\nsog = { name = \"sog\", unit = \"kn\" }\ncog = \"cog\"\n";
        let log = log(columns, text, &["t", "u", "v"]).unwrap();
        let knots = 1852.0 / 3600.0;
        for (name, x) in [("u", 3.0_f64.sqrt() * knots), ("v", knots)] {
            assert!((log.signals[name].values()[0] - x).abs() < 1e-14, "{name}");
            assert!(log.signals[name].values()[2].abs() < 1e-14);
        }
    }

    #[test]
    fn velocities_north_and_east_are_those_of_the_body_by_the_heading() {
        // heading east: east is ahead, north is to port
        let text = "t,hdg [deg],vn,ve\n0,90,0.5,2\n1,90,0,1\n";
        let columns = "psi = \"hdg\"\nv_north = \"vn\"\nv_east = \"ve\"\n";
        let log = log(columns, text, &["t", "u", "v"]).unwrap();
        for (name, x) in [("u", [2.0, 1.0]), ("v", [-0.5, 0.0])] {
            for (y, x) in log.signals[name].values().iter().zip(x) {
                assert!((y - x).abs() < 1e-14, "{name}: {y} for {x}");
            }
        }
    }

    #[test]
    fn speed_without_a_heading_is_refused() {
        let text = "t,sog,cog\n0,1,20\n1,1,30\n";
        let error = log("sog = \"sog\"\ncog = \"cog\"\n", text, &["t"]).unwrap_err().to_string();
        assert!(error.contains("heading"), "{error}");
    }

    #[test]
    fn what_is_repeated_is_one_fix() {
        let mut text = "t,lat,lon\n".to_string();
        for k in 0..200 {
            let fix = f64::from(k / 5);
            text += &format!(
                "{},{:.7},{:.7}\n",
                0.1 * f64::from(k),
                38.0 + 1e-5 * (fix + (3.0 * fix).sin()),
                9.0 + 1e-5 * (1.3 * fix).sin()
            );
        }
        let log = log("latitude = \"lat\"\nlongitude = \"lon\"\n", &text, &["t"]).unwrap();
        assert_eq!(log.signals["x"].len(), 40);
    }
}
