//! The table of hits, misses and false names: discovery on campaigns in which effects are hidden.
//!
//! `cargo run --release --example blind -- [--seeds N] [--first SEED] [--only TEXT] [--records FILE] [--write FILE]
//! [--for SECONDS] [--campaigns FOLDER] [--peer FILE]`
//!
//! Each row is a kind of campaign, judged over seeds and both vehicles. *Exact*: a member of the true class is named
//! for each hidden effect and nothing else, a class being what the answer itself lists in `also_possible`; how often the
//! truth is the first name of its class stands beside it. *Listed*: each hidden effect is named or stands in
//! `also_possible`. Judged are campaigns whose held-out gap, after the baseline's own best refit, is at least 1.5 times
//! the noise in some degree of freedom; the others count as too small to see. Gap closed: median over campaigns whose
//! gap was above 3 times the noise, as share of what the refit of the true model closes. Intervals are Wilson's, 95 %.
//! Seconds are those of one core. Records are kept, so that a run that was stopped goes on where it was. `--campaigns`
//! writes the campaigns as folders instead of judging them; `benches/peers/pysindy_blind.py` answers those, and its answers
//! (`--peer`) stand in the same table.

mod matrix;
mod peer;
mod plan;
mod record;
mod table;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use peer::Peer;
use plan::{Cell, cells};
use record::{Record, append, read};

/// What is asked of the command.
struct Arguments {
    seeds: u64,
    first: u64,
    only: Option<String>,
    records: String,
    write: Option<String>,
    seconds: f64,
    campaigns: Option<String>,
    peer: String,
}

fn arguments() -> Result<Arguments, String> {
    let mut found = Arguments {
        seeds: 20,
        first: 3001,
        only: None,
        records: "target/blind.jsonl".into(),
        write: None,
        seconds: f64::INFINITY,
        campaigns: None,
        peer: "target/blind-pysindy.jsonl".into(),
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        let number = |text: String| text.parse::<u64>().map_err(|_| format!("{word} takes a whole number, not {text}"));
        match word.as_str() {
            "--seeds" => found.seeds = number(value()?)?,
            "--first" => found.first = number(value()?)?,
            "--for" => found.seconds = number(value()?)? as f64,
            "--only" => found.only = Some(value()?),
            "--records" => found.records = value()?,
            "--write" => found.write = Some(value()?),
            "--campaigns" => found.campaigns = Some(value()?),
            "--peer" => found.peer = value()?,
            other => {
                return Err(format!(
                    "unknown argument {other}: --seeds N, --first SEED, --only TEXT, --records FILE, --write FILE, --for SECONDS, --campaigns FOLDER, \
                     --peer FILE"
                ));
            }
        }
    }
    Ok(found)
}

/// All campaigns, in such an order that every row has its share at any time.
fn tasks(cells: &[Cell], first: u64) -> Vec<(&Cell, u64)> {
    let mut all: Vec<(f64, &Cell, u64)> = cells
        .iter()
        .flat_map(|cell| (0..cell.seeds).map(move |k| ((k as f64 + 0.5) / cell.seeds as f64, cell, first + k)))
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.into_iter().map(|(_, cell, seed)| (cell, seed)).collect()
}

/// Makes and judges the campaigns that have no record yet, one on each core.
fn work(asked: &Arguments, all: &[Cell]) -> Result<(), String> {
    let known = read(&asked.records);
    let todo: Vec<(&Cell, u64)> =
        tasks(all, asked.first).into_iter().filter(|(cell, seed)| !known.contains_key(&(cell.id(), *seed))).collect();
    eprintln!("{} campaigns, {} of them known", todo.len() + known.len(), known.len());
    let (next, done, file) = (AtomicUsize::new(0), AtomicUsize::new(0), Mutex::new(()));
    let begin = Instant::now();
    let worker = || {
        while begin.elapsed().as_secs_f64() < asked.seconds {
            let Some((cell, seed)) = todo.get(next.fetch_add(1, Ordering::Relaxed)) else { return };
            match Record::make(cell, *seed) {
                Ok(record) => {
                    let _one_at_a_time = file.lock();
                    if let Err(reason) = append(&asked.records, &record) {
                        eprintln!("{reason}");
                    }
                }
                Err(reason) => eprintln!("{}, seed {seed}: {reason}", cell.id()),
            }
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            if count.is_multiple_of(50) {
                eprintln!("{count} of {} after {:.0} s", todo.len(), begin.elapsed().as_secs_f64());
            }
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let alone = || rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|e| e.to_string());
    let pools = (0..cores).map(|_| alone()).collect::<Result<Vec<_>, _>>()?;
    std::thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| pool.install(worker));
        }
    });
    Ok(())
}

fn main() -> Result<(), String> {
    let asked = arguments()?;
    let mut all = cells(asked.seeds);
    all.retain(|cell| asked.only.as_ref().is_none_or(|only| cell.id().contains(only.as_str())));
    if let Some(folder) = &asked.campaigns {
        let count = peer::write(folder, &all, asked.first)?;
        println!("{count} campaigns in {folder}");
        return Ok(());
    }
    work(&asked, &all)?;
    let records = read(&asked.records);
    let mut text = format!(
        "# Discovery on campaigns in which effects are hidden\n\nMade by `make blind` from {} campaigns, seeds from {} on, \
         two vehicles (190 kg, 11.5 kg). How a row is judged: the heading of `examples/blind/main.rs`; what pysindy is given \
         (the true values of the nominal model among it): that of `benches/peers/pysindy_blind.py`.\n",
        records.len(),
        asked.first
    );
    text += &table::table(&all, &records, &Peer::read(&asked.peer)?);
    if asked.only.is_none() {
        text += &matrix::matrix(asked.first)?;
    }
    match asked.write {
        Some(path) => std::fs::write(&path, text).map_err(|e| format!("{path}: {e}")),
        None => {
            println!("{text}");
            Ok(())
        }
    }
}
