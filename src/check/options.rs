//! Options of a check.

use serde::{Deserialize, Serialize};

use crate::frame::Dof;
use crate::run::Run;
use crate::thrust::thruster::Thruster;

/// Options of the check. Unknown keys are refused.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CheckOptions {
    /// Degrees of freedom that the run should show; if empty, those whose own command varies, or
    /// which move without a command of their own.
    pub dofs: Vec<Dof>,
    /// Degrees of freedom of the model that the run is for; all if empty.
    pub model: Vec<Dof>,
    /// Whether the velocities are those through the water: then they give no path over ground.
    pub through_water: bool,
    /// Whether the model contains a lag of the thrusters: a late answer is then no finding.
    pub lag_is_known: bool,
    /// Whether the model contains the lever arm of a sensor: a lever arm between position and
    /// velocity is then no finding.
    pub arm_is_known: bool,
    /// The vehicle's thrusters, in the order of `V1`, `F1`, …: without them the signs of their
    /// commands are not checked.
    pub thrusters: Vec<Thruster>,
    /// Column of latitude, deg; found by its name if absent.
    pub latitude: Option<String>,
    /// Column of longitude, deg; found by its name if absent.
    pub longitude: Option<String>,
    /// Column of metres north; `x` if absent.
    pub north: Option<String>,
    /// Column of metres east; `y` if absent.
    pub east: Option<String>,
    /// Column of the course over ground, deg; found by its name if absent.
    pub course: Option<String>,
    /// Column of the speed over ground, m/s; found by its name if absent.
    pub speed: Option<String>,
}

/// Columns of a satellite receiver, if present.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Geodetic {
    /// Latitude, deg.
    pub latitude: Option<String>,
    /// Longitude, deg.
    pub longitude: Option<String>,
    /// Metres north.
    pub north: Option<String>,
    /// Metres east.
    pub east: Option<String>,
    /// Course over ground, deg.
    pub course: Option<String>,
    /// Speed over ground, m/s.
    pub speed: Option<String>,
    /// Columns that were found by their names.
    pub guessed: Vec<String>,
}

impl Geodetic {
    /// Returns the columns named in the options, or else found by their names in the run.
    pub fn of(run: &Run, options: &CheckOptions) -> Geodetic {
        let mut guessed = Vec::new();
        let mut column = |said: &Option<String>, known: Option<&str>, names: &[&str]| {
            if let Some(name) = said {
                return run.signals.contains_key(name).then(|| name.clone());
            }
            if let Some(name) = known.filter(|n| run.signals.contains_key(*n)) {
                return Some(name.to_string());
            }
            let like = |have: &&String| {
                let have = have.to_lowercase();
                names.iter().any(|n| have.strip_prefix(n).is_some_and(|rest| rest.is_empty() || rest.starts_with('_')))
            };
            let found = run.signals.keys().find(like).cloned();
            guessed.extend(found.clone());
            found
        };
        let (latitude, longitude) = (
            column(&options.latitude, None, &["latitude", "lat"]),
            column(&options.longitude, None, &["longitude", "lon", "lng"]),
        );
        let (north, east) = (
            column(&options.north, Some("x"), &["north", "northing"]),
            column(&options.east, Some("y"), &["east", "easting"]),
        );
        let course = column(&options.course, None, &["course", "course_over_ground", "cog"]);
        let speed = column(&options.speed, None, &["speed_over_ground", "sog", "ground_speed", "groundspeed"]);
        Geodetic { latitude, longitude, north, east, course, speed, guessed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Signal;

    #[test]
    fn names_are_recognised_and_said() {
        let mut run = Run::default();
        for name in ["latitude_deg", "longitude_deg", "north_m_file", "y", "course_deg", "platform", "longest"] {
            run.signals.insert(name.into(), Signal::new(vec![0.0].into(), vec![0.0]));
        }
        let g = Geodetic::of(&run, &CheckOptions::default());
        assert_eq!(g.latitude.as_deref(), Some("latitude_deg"));
        assert_eq!(g.east.as_deref(), Some("y"));
        assert_eq!(g.speed, None);
        assert_eq!(g.guessed, ["latitude_deg", "longitude_deg", "north_m_file", "course_deg"]);
        let told = CheckOptions { course: Some("nowhere".into()), ..CheckOptions::default() };
        assert_eq!(Geodetic::of(&run, &told).course, None);
    }
}
