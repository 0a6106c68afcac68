//! Columns that give a channel together: latitude and longitude, a quaternion, speed and course
//! over ground.
//!
//! They are used if no single column gives the position, the heading or the velocity.
//! `[log.columns]` then names all of them, and the reader computes the channels
//! ([`crate::log::derived`]).

use std::collections::BTreeMap;

use super::layout::Layout;
use super::reading::Understood;
use super::units;
use super::words::Words;
use crate::log::columns;

/// The best-fitting header of each column of a group.
#[derive(Debug, Default)]
pub struct Told {
    of: BTreeMap<&'static str, (String, Words)>,
}

/// The groups of the reader: their columns, and the channels that they give if nothing else does.
const GROUPS: [(&[&str], &[&str]); 3] = [
    (&["latitude", "longitude"], &["x", "y"]),
    (&["qw", "qx", "qy", "qz"], &["phi", "theta", "psi"]),
    // after the quaternion: it may give the heading that rotates them
    (&["v_north", "v_east"], &["u", "v"]),
];

/// Number above which an angle is a count of 1e-7 degrees, as autopilots write it.
const NO_DEGREES: f64 = 360.0;

const SPEED: [&str; 4] = ["sog", "speed over ground", "ground speed", "gps speed"];
const COURSE: [&str; 2] = ["cog", "course over ground"];

impl Told {
    /// Takes a header whose name means a column of a group; returns whether it does.
    pub fn take(&mut self, channel: &'static str, header: &str, words: &Words) -> bool {
        let is_part = GROUPS.iter().any(|(sources, _)| sources.contains(&channel));
        if is_part {
            self.of.entry(channel).or_insert_with(|| (header.to_string(), words.clone()));
        }
        is_part
    }

    /// Notes a header that is speed or course over ground; it may also be another channel.
    pub fn note_ground(&mut self, header: &str, words: &Words) {
        let name = words.words.join(" ");
        for (channel, phrases) in [("sog", &SPEED[..]), ("cog", &COURSE[..])] {
            if phrases.iter().any(|p| name == *p || name.ends_with(&format!(" {p}"))) {
                self.of.entry(channel).or_insert_with(|| (header.to_string(), words.clone()));
            }
        }
    }

    /// Whether a complete group gives this channel.
    pub fn tells(&self, channel: &str) -> bool {
        let whole = |sources: &[&str]| sources.iter().all(|source| self.of.contains_key(source));
        GROUPS.iter().any(|(sources, gives)| gives.contains(&channel) && whole(sources))
    }

    fn header(&self, channel: &str) -> Option<&str> {
        self.of.get(channel).map(|(header, _)| header.as_str())
    }
}

impl Understood {
    /// Places the groups that give what no column gives. `own`: channels that have a column.
    /// Headers that are not used go to `left`.
    pub(super) fn place_told(&mut self, told: &Told, layout: &Layout, own: &mut Vec<String>, left: &mut Vec<String>) {
        for (sources, gives) in GROUPS {
            let headers: Vec<&str> = sources.iter().filter_map(|s| told.header(s)).collect();
            let has = |name: &str| own.iter().any(|o| o == name);
            let told_else = gives.iter().any(|name| has(name)) || gives.contains(&"u") && !has("psi");
            if headers.len() < sources.len() || told_else {
                left.extend(headers.into_iter().map(str::to_string));
                continue;
            }
            for name in sources {
                let Some((header, words)) = told.of.get(name) else { continue };
                let (mut source, _) = units::source(name, header, words.unit.as_deref(), 1);
                let mut why = format!("{header:?} is {name} by its name; together they give {}", gives.join(", "));
                if *name == "latitude" || *name == "longitude" {
                    if layout.greatest(header) > NO_DEGREES {
                        source.scale = 1e-7;
                        why += "; numbers of that size are in 1e-7 degrees";
                    }
                } else if told.of.get("qw").is_some_and(|(_, words)| words.words.last().is_some_and(|w| w == "0")) {
                    why += "; the first of the four is assumed to be w";
                }
                self.options.columns.insert((*name).to_string(), source);
                self.guess(format!("columns.{name}"), why);
            }
            own.extend(gives.iter().map(|name| (*name).to_string()));
        }
        self.place_ground(told, own);
    }

    /// Places speed and course over ground as surge and sway if there is a heading other than the
    /// course.
    fn place_ground(&mut self, told: &Told, own: &mut Vec<String>) {
        let (Some((speed, speed_words)), Some((course, course_words))) = (told.of.get("sog"), told.of.get("cog"))
        else {
            return;
        };
        let is_of = |channel: &str, header: &str| {
            let written = self.options.columns.get(channel).map_or(channel, |source| source.name.as_str());
            written == header || written == columns::split_header(header).0
        };
        let has = |channel: &str| own.iter().any(|o| o == channel);
        let surge = has("u") && !is_of("u", speed);
        if surge || has("v") || !has("psi") || is_of("psi", course) {
            return;
        }
        let (source, how) = units::source("u", speed, speed_words.unit.as_deref(), 1);
        let how = match speed_words.unit {
            Some(_) => how,
            None => "; m/s is assumed, its name gives no unit (unit = \"kn\" if they are knots)".to_string(),
        };
        self.options.columns.remove("u");
        self.reasons.remove("columns.u");
        for channel in ["u", "psi"] {
            if let Some(choices) = self.choices.get_mut(channel) {
                choices.retain(|other| other.name != *speed && other.name != *course);
            }
        }
        self.options.columns.insert("sog".into(), source);
        self.guess(
            "columns.sog",
            format!("{speed:?} is the speed over ground by its name; with the course it gives u, v{how}"),
        );
        let (source, _) = units::source("cog", course, course_words.unit.as_deref(), 1);
        self.options.columns.insert("cog".into(), source);
        self.guess("columns.cog", format!("{course:?} is the course over ground by its name, clockwise from north"));
        own.extend(["u", "v"].map(String::from));
    }
}
