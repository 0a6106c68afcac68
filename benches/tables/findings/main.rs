//! Table of findings of `check` on logs with injected faults and on sound logs.
//!
//! `cargo run --release --example findings -- [--seeds N] [--first SEED] [--only TEXT] [--write FILE]`
//!
//! The logs are those of the plant (`plant/`), which shares no code with the checks. `judge.rs`
//! defines hits and false findings.

mod estimates;
mod faults;
mod judge;
#[path = "../over_seeds/mod.rs"]
mod over_seeds;
mod table;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use estimates::ESTIMATES;
use faults::FAULTS;
use judge::{Base, SOUND, of_sound};
use over_seeds::Arguments;

fn main() -> Result<(), String> {
    let asked = Arguments::read(20, 70_001)?;
    let seeds = asked.first..asked.first + asked.seeds;
    let base = Base::sail(seeds.clone())?;
    let mut text = format!(
        "# What `check` finds\n\nMade by `make findings` on logs of the independent plant: {} logs a fault from seed {} on, two \
         vehicles in turn. A *hit* is a finding of\none of the codes that are right for the fault; a sound log has a *false \
         finding* where any warning or error is raised on it.\n",
        asked.seeds, asked.first
    );
    let (mut section, mut all, mut hit) = ("", 0, 0);
    for (number, fault) in FAULTS.iter().chain(&ESTIMATES).enumerate().filter(|(_, f)| f.name.contains(&asked.only)) {
        if fault.section != section {
            section = fault.section;
            let _ = write!(text, "\n## {section}\n\n| fault | right are | hits |\n|---|---|---|\n");
        }
        let (found, of, missed) = base.hits(number, fault)?;
        missed.iter().for_each(|(codes, n)| eprintln!("missed {n}: {}: {codes}", fault.name));
        let _ = writeln!(text, "| {} | {} | {found} of {of} |", fault.name, fault.codes.join(", "));
        all += of;
        hit += found;
    }
    let _ = write!(text, "\n## Sound logs\n\n| logs | n | with a false finding |\n|---|---|---|\n");
    let (mut sound, mut wrong) = (0, 0);
    for (name, way) in SOUND {
        let told = of_sound(seeds.clone(), way, name)?;
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        told.iter().flatten().for_each(|code| *counts.entry(code).or_insert(0) += 1);
        let which: Vec<String> = counts.iter().map(|(code, n)| format!("{n} {code}")).collect();
        let with = told.iter().filter(|codes| !codes.is_empty()).count();
        let which = if which.is_empty() { String::new() } else { format!(" ({})", which.join(", ")) };
        let _ = writeln!(text, "| {name} | {} | {with}{which} |", told.len());
        sound += told.len();
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
