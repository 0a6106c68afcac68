//! The verb `init`: a commented campaign from logs as they come off the vehicle.
//!
//! It always writes. What a log says plainly is taken; what names, units, ranges and relations of columns suggest is a
//! guess, marked by a comment that begins with `# guessed:` and says why; what could not be placed stands in a comment.

pub(super) mod commands;
mod dives;
mod geometry;
mod layout;
mod meaning;
mod reading;
mod text;
mod units;
mod values;
pub(super) mod words;

pub use layout::{Layout as FirstRows, of as first_rows};

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;

use super::error::Error;
use super::vehicles::{KnownVehicle, vehicle};
use crate::log::LogOptions;
use crate::vehicle::Vehicle;

/// What is known of the vehicle, SI; what is absent is that of the vehicle file, else written as a comment.
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
    /// Refuses figures that cannot be.
    ///
    /// # Errors
    /// [`Error::Asked`] for one that is not positive and finite.
    fn validate(&self) -> Result<(), Error> {
        let InitFacts { mass, volume, weight, buoyancy, length, .. } = *self;
        let vehicle = Vehicle { mass, volume, weight, buoyancy, length, ..Vehicle::default() };
        vehicle.validate().map_err(|e| Error::Asked(e.to_string()))
    }
}

/// A TOML string: Rust escapes other characters in other ways.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// What whoever converted a log of another format has learned from it.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Learned {
    /// Guesses and remarks, one comment each.
    pub guessed: Vec<String>,
    /// FRAME_CONFIG of ArduSub.
    pub ardusub_frame: Option<i64>,
    /// Directions of thrusters 1, 2, …: 1 or −1.
    pub directions: Vec<i64>,
    /// Reading options of all logs.
    pub log: Option<LogOptions>,
    /// Stretches under a controller by log, as they shall be told.
    pub closed_loop: BTreeMap<String, Vec<String>>,
}

/// What `init` works on.
#[derive(Debug, Clone, Default)]
pub struct InitRequest {
    /// Logs: the path to read and the text that is to stand in the campaign.
    pub logs: Vec<(PathBuf, String)>,
    /// What is known of the vehicle.
    pub facts: InitFacts,
    /// Vehicle that comes with the program, or a vehicle file.
    pub vehicle: Option<String>,
    /// Reading options that somebody has said.
    pub options: LogOptions,
    /// What was learned where a log was converted.
    pub learned: Learned,
}

/// A campaign that was written.
#[derive(Debug, Clone, Default)]
pub struct Scaffold {
    /// Text of the campaign.
    pub text: String,
    /// Number of guesses in it.
    pub guesses: usize,
    /// Files that the campaign needs beside it, such as bollard tables of a vehicle file: where they are, how it names them.
    pub companions: Vec<(PathBuf, String)>,
    /// Logs that could not be read, each with the reason; they stand in the text as comments.
    pub unread: Vec<String>,
}

/// The text of a campaign over logs.
///
/// # Errors
/// [`Error::Vehicle`] for a vehicle that is not known. A log that cannot be read is told in the text.
pub fn init(request: &InitRequest) -> Result<Scaffold, Error> {
    request.facts.validate()?;
    let mut given = request.options.clone();
    if let Some(learned) = request.learned.log.as_ref().filter(|_| given == LogOptions::default()) {
        given.clone_from(learned);
    }
    let known = match (&request.vehicle, request.learned.ardusub_frame) {
        (Some(name), _) => Some((vehicle(name)?, None)),
        (None, Some(frame)) => super::vehicles::known_vehicles()
            .into_iter()
            .find(|known| known.file.ardusub_frame == Some(frame))
            .map(|known| (known, Some(format!("the log's FRAME_CONFIG = {frame} is the frame of this vehicle")))),
        (None, None) => None,
    };
    let understood: Vec<reading::Understood> =
        request.logs.iter().map(|(path, shown)| reading::understand(path, shown, &given)).collect();
    let dives = dives::of(&understood);
    let companions = known.as_ref().map(|(known, _)| companions(known)).unwrap_or_default();
    let text =
        text::Draft { request, given: &given, vehicle: known.as_ref(), logs: &understood, dives: &dives }.write();
    let unread = understood.iter().filter(|log| log.log.is_none());
    let unread = unread.map(|log| format!("{}: {}", log.shown, log.refused.join("; "))).collect();
    Ok(Scaffold { guesses: text.matches("# guessed:").count(), text, companions, unread })
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
