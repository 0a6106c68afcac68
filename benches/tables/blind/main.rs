//! Table of hits, misses and false names of discovery, on campaigns of the independent plant with
//! hidden effects.
//!
//! `cargo run --release --example blind -- [--seeds N] [--first SEED] [--only TEXT] [--write FILE]`
//!
//! The truth is the plant (`plant/`), which shares no code with the search. Each campaign is
//! written as a folder and read like that of a user. Seeds alternate between a vehicle of 190 kg
//! and one of 11.5 kg; one of 13.5 kg has six degrees of freedom. *Exact*: each hidden effect is
//! found by its name, by an effect whose `also_possible` lists it, or by that of its group (net
//! weight, the righting moment), and nothing else is found. *Listed*: each hidden effect is found
//! as for *exact*, or is in `behaves_like`. *False names*: effects found that match no hidden one.
//! Seconds are those of one core (median).

mod cells;
mod drawn;
#[path = "../over_seeds/mod.rs"]
mod over_seeds;

use std::fmt::Write as _;

use cells::{Cell, cells};
use hydrosysid::campaign::{Campaign, LoadOptions, discover};
use hydrosysid::discover::{Discovery, FoundEffect, Verdict};
use over_seeds::Arguments;
use rayon::prelude::*;

/// Result of one campaign, compared with its hidden effects.
struct Outcome {
    verdict: Verdict,
    exact: bool,
    listed: bool,
    false_names: usize,
    told: String,
    seconds: f64,
}

fn one(cell: &Cell, seed: u64) -> Result<Outcome, String> {
    let campaign = (cell.campaign)(seed);
    let hidden: Vec<String> = campaign.hidden.iter().map(|h| h.name.clone()).collect();
    let sailed = campaign.sail().map_err(|e| e.to_string())?;
    let folder = std::env::temp_dir().join(format!("hydrosysid-blind-{}-{seed}", std::process::id()));
    let written = sailed.write(&folder).map_err(|e| e.to_string());
    let loaded = written.and_then(|()| {
        Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).map_err(|e| e.to_string())
    });
    let _ = std::fs::remove_dir_all(&folder);
    let campaign = loaded?;
    let begin = cpu_time::ThreadTime::now();
    let found = discover(&campaign).map_err(|e| e.to_string())?;
    Ok(judged(&hidden, &found, seed, begin.elapsed().as_secs_f64()))
}

/// All hidden effects for which a found one is right: its name, those that the data cannot
/// distinguish from it, and those of its group, which follow it in the names to adopt.
fn names<'a>(effect: &'a FoundEffect, found: &'a Discovery) -> Vec<&'a String> {
    let from_it = found.adopt.iter().skip_while(|name| **name != effect.id).skip(1);
    let group = from_it.take_while(|name| found.effects.iter().all(|other| other.id != **name));
    std::iter::once(&effect.id).chain(&effect.also_possible).chain(group).collect()
}

fn judged(all: &[String], found: &Discovery, seed: u64, seconds: f64) -> Outcome {
    let matches = |effect: &FoundEffect, hidden: &String| names(effect, found).contains(&hidden);
    let named = |hidden: &String| found.effects.iter().any(|e| matches(e, hidden));
    let false_names = found.effects.iter().filter(|e| !all.iter().any(|h| matches(e, h))).count();
    let behaves = |hidden: &String| found.behaves_like.iter().any(|b| b.id == *hidden);
    let told: Vec<&str> = found.effects.iter().map(|e| e.id.as_str()).collect();
    Outcome {
        verdict: found.verdict,
        exact: all.iter().all(named) && false_names == 0,
        listed: all.iter().all(|h| named(h) || behaves(h)),
        false_names,
        told: format!(
            "seed {seed}: {} hidden: {:?} {}",
            if all.is_empty() { "nothing".into() } else { all.join(" ") },
            found.verdict,
            told.join(" ")
        ),
        seconds,
    }
}

fn main() -> Result<(), String> {
    let asked = Arguments::read(20, 90_001)?;
    let mut text = format!(
        "# Discovery on campaigns in which effects are hidden\n\nMade by `make blind` on the independent plant: {} seeds a \
         row from {} on, two vehicles in turn. How a row is judged: the heading of `benches/tables/blind/main.rs`.\n",
        asked.seeds, asked.first
    );
    let alone = || rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|e| e.to_string());
    let mut section = "";
    for cell in cells().iter().filter(|c| c.name.contains(&asked.only) || c.section.contains(&asked.only)) {
        if cell.section != section {
            section = cell.section;
            let _ = write!(
                text,
                "\n## {section}\n\n| row | n | exact | listed | with a false name | nothing missing | explained | partly | \
                 unexplained | failed | s |\n|---|---|---|---|---|---|---|---|---|---|---|\n"
            );
        }
        let results: Vec<Result<Outcome, String>> = (asked.first..asked.first + asked.seeds)
            .into_par_iter()
            .map(|seed| alone()?.install(|| one(cell, seed)).map_err(|e| format!("{}, seed {seed}: {e}", cell.name)))
            .collect();
        let failed = results.iter().filter(|r| r.is_err()).count();
        let outcomes: Vec<&Outcome> = results.iter().filter_map(|r| r.as_ref().ok()).collect();
        results.iter().filter_map(|r| r.as_ref().err()).for_each(|e| eprintln!("{e}"));
        for outcome in outcomes.iter().filter(|o| !cell.named || !o.exact) {
            eprintln!("{}: {}", cell.name, outcome.told);
        }
        let count = |f: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|o| f(o)).count();
        let mut seconds: Vec<f64> = outcomes.iter().map(|o| o.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        let exact = if cell.named { count(&|o| o.exact).to_string() } else { "-".into() };
        let row = format!(
            "| {} | {} | {exact} | {} | {} | {} | {} | {} | {} | {failed} | {:.2} |\n",
            cell.name,
            outcomes.len(),
            count(&|o| o.listed),
            count(&|o| o.false_names > 0),
            count(&|o| o.verdict == Verdict::NothingMissing),
            count(&|o| o.verdict == Verdict::Explained),
            count(&|o| o.verdict == Verdict::PartlyExplained),
            count(&|o| o.verdict == Verdict::Unexplained),
            seconds.get(seconds.len() / 2).copied().unwrap_or(0.0),
        );
        eprint!("{row}");
        text += &row;
    }
    match asked.write {
        Some(path) => std::fs::write(&path, text).map_err(|e| format!("{path}: {e}")),
        None => {
            println!("{text}");
            Ok(())
        }
    }
}
