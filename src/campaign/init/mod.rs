//! The command `init`: writes a commented campaign from logs as they come off the vehicle.
//!
//! It always writes a campaign. What a log states is taken over. What names, units, ranges and
//! relations of columns suggest is a guess: its comment begins with `# guessed:` and gives the
//! reason. Columns that could not be placed are listed in a comment.

mod alike;
mod altitude;
mod attempts;
pub(super) mod commands;
mod degrees;
mod dives;
mod drives;
mod dvl_axes;
mod fins;
mod geometry;
mod held;
mod kinds;
mod layout;
mod meaning;
mod parts;
mod priors;
mod reading;
mod reading_options;
mod roles;
mod ros;
mod speeds;
mod stamps;
mod text;
mod told;
mod turning;
mod units;
mod values;
pub(super) mod words;

pub use layout::{Layout as FirstRows, of as first_rows};

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::error::Error;
use super::vehicles::{KnownVehicle, vehicle};
use crate::log::LogOptions;
use crate::log::options::Missing;
use crate::vehicle::Vehicle;

/// Known properties of the vehicle, SI. An absent one is taken from the vehicle file, else written
/// as a comment.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InitFacts {
    /// Name shown to people; empty for that of the vehicle file.
    pub name: String,
    /// Dry mass, kg.
    pub mass: Option<f64>,
    /// Displaced volume, m³.
    pub volume: Option<f64>,
    /// Weight, N.
    pub weight: Option<f64>,
    /// Buoyancy, N.
    pub buoyancy: Option<f64>,
    /// Characteristic length, m.
    pub length: Option<f64>,
}

impl InitFacts {
    /// Checks that all figures are possible.
    ///
    /// # Errors
    /// [`Error::Asked`] if a figure is not positive and finite.
    fn validate(&self) -> Result<(), Error> {
        let InitFacts { mass, volume, weight, buoyancy, length, .. } = *self;
        let vehicle = Vehicle { mass, volume, weight, buoyancy, length, ..Vehicle::default() };
        vehicle.validate().map_err(|e| Error::Asked(e.to_string()))
    }
}

/// `text` as a TOML string: Rust escapes other characters in other ways.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// Facts that the converter of a log of another format found in it.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Learned {
    /// Guesses and remarks, one comment each.
    pub guessed: Vec<String>,
    /// FRAME_CONFIG of ArduSub.
    pub ardusub_frame: Option<i64>,
    /// Directions of thrusters 1, 2, …: 1 or −1.
    pub directions: Vec<i64>,
    /// Neutral pulse widths of thrusters 1, 2, …, µs, where the autopilot states another one than
    /// the usual.
    pub neutral: Vec<Option<f64>>,
    /// Span from the neutral to the limit of the pulses, µs.
    pub span: Option<f64>,
    /// Logs that were converted from another format: SI units under canonical names; a cell without
    /// a sample is empty.
    pub converted: Vec<String>,
    /// Stretches under a controller by log, in the words for the campaign.
    pub closed_loop: BTreeMap<String, Vec<String>>,
    /// Fields of a log that became no channel, by log.
    pub not_placed: BTreeMap<String, Vec<String>>,
}

/// The input of `init`.
#[derive(Debug, Clone, Default)]
pub struct InitRequest {
    /// Logs: the path to read, and the path as the campaign names it.
    pub logs: Vec<(PathBuf, String)>,
    /// Known properties of the vehicle.
    pub facts: InitFacts,
    /// A vehicle that comes with the program, or a vehicle file.
    pub vehicle: Option<String>,
    /// Reading options that the user has given.
    pub options: LogOptions,
    /// Facts from the conversion of logs.
    pub learned: Learned,
}

/// The campaign that `init` writes.
#[derive(Debug, Clone, Default)]
pub struct Scaffold {
    /// Text of the campaign.
    pub text: String,
    /// Number of guesses in it.
    pub guesses: usize,
    /// Files that the campaign needs beside it, such as bollard tables of a vehicle file: source
    /// path, and name in the campaign.
    pub companions: Vec<(PathBuf, String)>,
    /// Logs that could not be read, each with the reason; the text lists them in comments.
    pub unread: Vec<String>,
    /// Message if no degree of freedom moves under a command.
    pub idle: Option<String>,
    /// Degrees of freedom that are logged in part: a command or a measurement is missing.
    pub left_out: Vec<String>,
}

impl Scaffold {
    /// Messages to show before the user reads the text, a line each.
    pub fn warnings(&self) -> Vec<String> {
        self.unread.iter().map(|log| format!("not read: {log}")).chain(self.idle.clone()).collect()
    }
}

/// Writes the text of a campaign over logs.
///
/// # Errors
/// [`Error::Vehicle`] for an unknown vehicle. A log that cannot be read is no error: the text
/// reports it.
pub fn init(request: &InitRequest) -> Result<Scaffold, Error> {
    request.facts.validate()?;
    // the converter has applied the given options on columns and axes already
    let made = LogOptions { missing: Missing::NoSample, ..LogOptions::default() };
    let given = |shown: &String| if request.learned.converted.contains(shown) { &made } else { &request.options };
    let known = match (&request.vehicle, request.learned.ardusub_frame) {
        (Some(name), _) => Some((vehicle(name)?, None)),
        (None, Some(frame)) => super::vehicles::known_vehicles()
            .into_iter()
            .find(|known| known.file.ardusub_frame == Some(frame))
            .map(|known| (known, Some(format!("the log's FRAME_CONFIG = {frame} is the frame of this vehicle")))),
        (None, None) => None,
    };
    let mut understood: Vec<reading::Understood> =
        request.logs.iter().map(|(path, shown)| reading::understand(path, shown, given(shown))).collect();
    let paths: Vec<&Path> = request.logs.iter().map(|(path, _)| path.as_path()).collect();
    let full_rpm = known.as_ref().and_then(|(known, _)| known.file.full_rpm);
    let thrusters = known.as_ref().map(|(known, _)| known.file.thrusters.len()).filter(|count| *count > 0);
    reading::settle(&mut understood, &paths, thrusters, full_rpm);
    let dives = dives::of(&understood);
    let companions = known.as_ref().map(|(known, _)| companions(known)).unwrap_or_default();
    let text::Written { text, idle, left_out } =
        text::Draft { request, given: &request.options, vehicle: known.as_ref(), logs: &understood, dives: &dives }
            .write();
    let unread = understood.iter().filter(|log| log.log.is_none());
    let unread = unread.map(|log| format!("{}: {}", log.shown, log.refused.join("; "))).collect();
    Ok(Scaffold { guesses: text.matches("# guessed:").count(), text, companions, unread, idle, left_out })
}

/// Byte offset of the first place where the text of a campaign reports an unread log.
pub(super) fn unread_mark(text: &str) -> Option<usize> {
    let mark = format!("\n{}", text::NOT_READ);
    text.find(&mark).map(|at| at + 1)
}

/// Whether a campaign was written by `init` from logs of which none could be read: replacing it
/// loses nothing.
pub fn holds_no_run(text: &str) -> bool {
    let is_without = |table: toml::Table| !table.contains_key("run");
    text.starts_with(text::HEAD) && unread_mark(text).is_some() && toml::from_str(text).is_ok_and(is_without)
}

/// Bollard tables that the thrusters of a vehicle file name.
fn companions(known: &KnownVehicle) -> Vec<(PathBuf, String)> {
    let Some(folder) = &known.folder else { return Vec::new() };
    let mut files: Vec<String> =
        known.file.thrusters.iter().filter_map(|t| t.bollard.as_ref().map(|b| b.file.clone())).collect();
    files.sort();
    files.dedup();
    files.into_iter().map(|file| (folder.join(&file), file)).collect()
}
