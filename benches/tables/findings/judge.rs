//! Findings of `check` on logs of the plant: hits on logs with an injected fault, and false
//! findings on sound logs.
//!
//! A *hit* is a finding with one of the codes that are right for the fault. A sound log has a
//! *false finding* if any warning or error is raised on it; notes do not count.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hydrosysid::campaign::check_logs;
use hydrosysid::finding::Severity;
use hydrosysid::log::LogOptions;
use hydrosysid_plant::{Campaign, Commands, Dof, Pilots, RandomForce, Suite, Vehicle};
use rayon::prelude::*;

use super::estimates::SMOOTHINGS;
use super::faults::{Fault, Log};
use super::table::Table;

/// Change of an ordinary campaign.
pub type Sailing = fn(Campaign) -> Campaign;

/// Change of an ordinary campaign, as a closure.
type Way<'a> = &'a (dyn Fn(Campaign) -> Campaign + Sync);

/// Campaigns whose logs are sound.
pub const SOUND: [(&str, Sailing); 5] = [
    ("the ordinary instruments", |c| c),
    ("a random force of 5 % of the thrust", |c| Campaign { force: RandomForce { share: 0.05, correlation: 1.0 }, ..c }),
    ("noise of twice the ordinary", |c| Campaign {
        instruments: Suite { noise: 2.0, ..Suite::default() }.instruments(&Dof::PLANE),
        ..c
    }),
    ("a velocity at 4 Hz, the others at 10", |c| Campaign {
        instruments: Suite { dvl_rate: Some(4.0), ..Suite::default() }.instruments(&Dof::PLANE),
        ..c
    }),
    ("commands of single thrusters", |c| Campaign { commands: Commands::Thrusters, ..c }),
];

/// The logs of the campaign of a seed, as CSV; seeds alternate between a vehicle of 190 kg and one
/// of 11.5 kg.
///
/// # Errors
/// Those of the plant.
pub fn logs(seed: u64, way: Way<'_>) -> Result<Vec<String>, String> {
    let name = if seed.is_multiple_of(2) { "laurs" } else { "small" };
    let vehicle = Vehicle::named(name).ok_or("the plant has this vehicle")?;
    let sailed = way(Campaign { seed, ..Campaign::new(vehicle, &Dof::PLANE) }).sail().map_err(|e| e.to_string())?;
    Ok(sailed.logs.iter().map(|log| log.csv("V")).collect())
}

/// The logs into which faults are injected, the last run of each campaign: a run that moves in all
/// degrees of freedom, the same under a controller, and the same with a smoothed heading.
pub struct Base {
    moving: Vec<String>,
    controlled: Vec<String>,
    smoothed: Vec<Vec<String>>,
}

impl Base {
    /// The logs of these seeds.
    ///
    /// # Errors
    /// Those of the plant.
    pub fn sail(seeds: std::ops::Range<u64>) -> Result<Base, String> {
        let last = |way: Way<'_>| -> Result<Vec<String>, String> {
            let all: Result<Vec<_>, String> = seeds.clone().into_par_iter().map(|seed| logs(seed, way)).collect();
            Ok(all?.into_iter().filter_map(|mut logs| logs.pop()).collect())
        };
        let smoothed = |smoothing: &f64| {
            let suite = Suite { smoothing: *smoothing, ..Suite::default() };
            last(&|c| Campaign { instruments: suite.instruments(&Dof::PLANE), ..c })
        };
        Ok(Base {
            moving: last(&|c| c)?,
            controlled: last(&|c| Campaign { pilots: Pilots::Closed, ..c })?,
            smoothed: SMOOTHINGS.iter().map(smoothed).collect::<Result<_, _>>()?,
        })
    }

    /// Number of hits of a fault, number of logs, and number of misses by the codes that they raised instead.
    ///
    /// # Errors
    /// A log that cannot be written.
    pub fn hits(&self, number: usize, fault: &Fault) -> Result<(usize, usize, BTreeMap<String, usize>), String> {
        let logs = match fault.log {
            Log::Moving => &self.moving,
            Log::Controlled => &self.controlled,
            Log::Smoothed(number) => &self.smoothed[number],
        };
        let one = |(k, csv): (usize, &String)| {
            let spoilt = (fault.inject)(Table::read(csv), k + 31 * number);
            let codes = raised(&spoilt, &place(&format!("{number}-{k}")), &LogOptions::default())?;
            let hit = codes.iter().any(|code| fault.codes.contains(&code.as_str()));
            Ok((hit, if hit { String::new() } else { codes.join(" ") }))
        };
        let found: Result<Vec<(bool, String)>, String> = logs.par_iter().enumerate().map(one).collect();
        let found = found?;
        let mut missed = BTreeMap::new();
        found.iter().filter(|(hit, _)| !hit).for_each(|(_, codes)| *missed.entry(codes.clone()).or_insert(0) += 1);
        Ok((found.iter().filter(|(hit, _)| *hit).count(), logs.len(), missed))
    }
}

/// The codes that are raised on each of the sound logs of these seeds.
///
/// # Errors
/// Those of the plant; a log that cannot be written.
pub fn of_sound(seeds: std::ops::Range<u64>, way: Sailing, name: &str) -> Result<Vec<Vec<String>>, String> {
    let logs: Result<Vec<_>, String> = seeds.into_par_iter().map(|seed| logs(seed, &way)).collect();
    let logs: Vec<String> = logs?.into_iter().flatten().collect();
    let options: LogOptions =
        serde_json::from_value(serde_json::json!({"missing": "no_sample"})).map_err(|e| e.to_string())?;
    let name: String = name.chars().filter(char::is_ascii_alphanumeric).collect();
    logs.par_iter().enumerate().map(|(k, csv)| raised(csv, &place(&format!("{name}-{k}")), &options)).collect()
}

/// The codes of errors and warnings that are raised on a log.
fn raised(csv: &str, place: &Path, options: &LogOptions) -> Result<Vec<String>, String> {
    std::fs::write(place, csv).map_err(|e| e.to_string())?;
    let found = check_logs(&[place], options, &[]).map_err(|e| e.to_string());
    let _ = std::fs::remove_file(place);
    let found = found?;
    let told = found.errors.iter().chain(&found.warnings).filter(|f| f.severity > Severity::Note);
    Ok(told.map(|f| f.code.to_string()).collect())
}

fn place(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("hydrosysid-findings-{}-{name}.csv", std::process::id()))
}
