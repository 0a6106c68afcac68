//! The table of findings: what `check` says of logs into which faults are put, and of sound ones.
//!
//! `cargo run --release --example findings -- [--seeds N] [--first SEED] [--only TEXT] [--write FILE]`
//!
//! The logs are those of the plant (`plant/`), which shares no code with the checks: runs of a vehicle of 190 kg and one of
//! 11.5 kg in turn that move in all three degrees of freedom of the plane. A *hit* is a finding of one of the codes that
//! are right for the fault. A sound log has a *false finding* where one of the codes of any fault is raised on it.

mod faults;
#[path = "../over_seeds/mod.rs"]
mod over_seeds;
mod table;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use faults::FAULTS;
use hydrosysid::campaign::check_logs;
use hydrosysid::log::LogOptions;
use hydrosysid_plant::{Campaign, Dof, Pilots, RandomForce, Suite, Vehicle};
use over_seeds::Arguments;
use rayon::prelude::*;
use table::Table;

/// Ways of sailing whose logs are sound.
const SOUND: [(&str, Sailing); 5] = [
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
    ("under a controller", |c| Campaign { pilots: Pilots::Closed, ..c }),
];

type Sailing = fn(Campaign) -> Campaign;

/// The logs of a campaign, as CSV.
fn logs(seed: u64, way: Sailing) -> Result<Vec<String>, String> {
    let name = if seed.is_multiple_of(2) { "laurs" } else { "small" };
    let vehicle = Vehicle::named(name).ok_or("the plant has this vehicle")?;
    let sailed = way(Campaign { seed, ..Campaign::new(vehicle, &Dof::PLANE) }).sail().map_err(|e| e.to_string())?;
    Ok(sailed.logs.iter().map(|log| log.csv("V")).collect())
}

/// The codes that are raised on a log.
fn raised(csv: &str, place: &Path, options: &LogOptions) -> Result<Vec<String>, String> {
    std::fs::write(place, csv).map_err(|e| e.to_string())?;
    let found = check_logs(&[place], options, &[]).map_err(|e| e.to_string());
    let _ = std::fs::remove_file(place);
    let found = found?;
    Ok(found.errors.iter().chain(&found.warnings).map(|f| f.code.to_string()).collect())
}

fn place(name: &str) -> std::path::PathBuf {
    std::env::temp_dir().join(format!("hydrosysid-findings-{}-{name}.csv", std::process::id()))
}

/// Hits of a fault, and the codes of the misses.
fn hits(fault: &faults::Fault, number: usize, sound: &[String]) -> Result<(usize, BTreeMap<String, usize>), String> {
    let one = |(k, csv): (usize, &String)| {
        let spoilt = (fault.inject)(Table::read(csv), k + 31 * number);
        let codes = raised(&spoilt, &place(&format!("{number}-{k}")), &LogOptions::default())?;
        let hit = codes.iter().any(|code| fault.codes.contains(&code.as_str()));
        Ok((hit, if hit { String::new() } else { codes.join(" ") }))
    };
    let found: Vec<Result<(bool, String), String>> = sound.par_iter().enumerate().map(one).collect();
    let found = found.into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut missed = BTreeMap::new();
    found.iter().filter(|(hit, _)| !hit).for_each(|(_, codes)| *missed.entry(codes.clone()).or_insert(0) += 1);
    Ok((found.iter().filter(|(hit, _)| *hit).count(), missed))
}

fn main() -> Result<(), String> {
    let asked = Arguments::read(20, 70_001)?;
    let seeds = || asked.first..asked.first + asked.seeds;
    let sail = |way: Sailing| -> Result<Vec<Vec<String>>, String> {
        let all: Vec<_> = seeds().into_par_iter().map(|seed| logs(seed, way)).collect();
        all.into_iter().collect()
    };
    // the last runs of a campaign move in all degrees of freedom
    let moving: Vec<String> = sail(|c| c)?.into_iter().filter_map(|mut logs| logs.pop()).collect();
    let mut text = format!(
        "# What `check` finds\n\nMade by `make findings` on logs of the independent plant: {} logs a fault from seed {} on, two \
         vehicles in turn. How a row is judged: the heading of `examples/findings/main.rs`.\n",
        moving.len(),
        asked.first
    );
    let (mut section, mut all, mut hit) = ("", 0, 0);
    for (number, fault) in FAULTS.iter().enumerate().filter(|(_, f)| f.name.contains(&asked.only)) {
        if fault.section != section {
            section = fault.section;
            let _ = write!(text, "\n## {section}\n\n| fault | right are | hits |\n|---|---|---|\n");
        }
        let (found, missed) = hits(fault, number, &moving)?;
        missed.iter().for_each(|(codes, n)| eprintln!("missed {n}: {}: {codes}", fault.name));
        let _ = writeln!(text, "| {} | {} | {found} of {} |", fault.name, fault.codes.join(", "), moving.len());
        all += moving.len();
        hit += found;
    }
    let _ = write!(text, "\n## Sound logs\n\n| logs | n | with a false finding |\n|---|---|---|\n");
    let (mut sound, mut wrong) = (0, 0);
    let claims = |code: &String| FAULTS.iter().any(|fault| fault.codes.contains(&code.as_str()));
    for (name, way) in SOUND {
        let logs: Vec<String> = sail(way)?.into_iter().flatten().collect();
        let options: LogOptions =
            serde_json::from_value(serde_json::json!({"missing": "no_sample"})).map_err(|e| e.to_string())?;
        let one = |(k, csv): (usize, &String)| {
            Ok(raised(csv, &place(&format!("sound-{k}")), &options)?.into_iter().filter(claims).collect::<Vec<_>>())
        };
        let told: Vec<Result<Vec<String>, String>> = logs.par_iter().enumerate().map(one).collect();
        let told = told.into_iter().collect::<Result<Vec<_>, _>>()?;
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        told.iter().flatten().for_each(|code| *counts.entry(code).or_insert(0) += 1);
        let which: Vec<String> = counts.iter().map(|(code, n)| format!("{n} {code}")).collect();
        let with = told.iter().filter(|codes| !codes.is_empty()).count();
        let which = if which.is_empty() { String::new() } else { format!(" ({})", which.join(", ")) };
        let _ = writeln!(text, "| {name} | {} | {with}{which} |", logs.len());
        sound += logs.len();
        wrong += with;
    }
    let share = |part: usize, of: usize| 100.0 * part as f64 / of.max(1) as f64;
    let _ = write!(
        text,
        "\nOf {all} faults {hit} are told ({:.1} %); of {sound} sound logs {wrong} have a false finding ({:.2} %).\n",
        share(hit, all),
        share(wrong, sound)
    );
    match asked.write {
        Some(path) => std::fs::write(&path, text).map_err(|e| format!("{path}: {e}")),
        None => {
            println!("{text}");
            Ok(())
        }
    }
}
