//! Answers of another package to the same campaigns, in the same table.
//!
//! [`write`] writes campaigns as folders with an index; a script of `benches/peers/` answers them in a file of lines
//! `{"cell": …, "seed": …, "named": […], "seconds": …}`; [`Peer::record`] puts such an answer in the place of ours. Which
//! campaigns count is decided by our record of them, as for ourselves.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use serde::Deserialize;

use hydrosysid::tank::{BlindOptions, write_blind};

use crate::plan::Cell;
use crate::record::Record;

/// Name of the rows.
pub const NAME: &str = "pysindy, weak form";

/// One answer.
#[derive(Debug, Deserialize)]
pub struct Answer {
    cell: String,
    seed: u64,
    named: Vec<String>,
    /// Whether the library of the peer holds a term for everything that is hidden.
    #[serde(default)]
    pub held: bool,
    seconds: f64,
}

/// All answers, by cell and seed.
#[derive(Debug, Default)]
pub struct Peer(BTreeMap<(String, u64), Answer>);

impl Peer {
    /// Reads a file of answers; none where there is no file.
    pub fn read(path: &str) -> Result<Peer, String> {
        let Ok(text) = std::fs::read_to_string(path) else { return Ok(Peer::default()) };
        let one = |(k, line): (usize, &str)| {
            let answer: Answer = serde_json::from_str(line).map_err(|e| format!("{path}:{}: {e}", k + 1))?;
            Ok(((answer.cell.clone(), answer.seed), answer))
        };
        Ok(Peer(text.lines().enumerate().map(one).collect::<Result<_, String>>()?))
    }

    /// Our record with the peer's answer in it, and whether its library holds what is hidden.
    pub fn record(&self, ours: &Record) -> Option<(Record, bool)> {
        let answer = self.0.get(&(ours.cell.clone(), ours.seed))?;
        let verdict = if answer.named.is_empty() { "nothing_missing" } else { "explained" };
        let record = Record {
            named: answer.named.iter().map(|name| (name.clone(), Vec::new())).collect(),
            verdict: verdict.to_string(),
            truth: None,
            seconds: answer.seconds,
            ..ours.clone()
        };
        Some((record, answer.held))
    }
}

/// Writes the planar campaigns of `cells` as folders under `folder`, with `index.jsonl`.
pub fn write(folder: &str, cells: &[Cell], first: u64) -> Result<usize, String> {
    let say = |e: &dyn std::fmt::Display| format!("{folder}: {e}");
    std::fs::create_dir_all(folder).map_err(|e| say(&e))?;
    let mut index = std::fs::File::create(Path::new(folder).join("index.jsonl")).map_err(|e| say(&e))?;
    let mut count = 0;
    for cell in cells.iter().filter(|cell| !cell.options.six) {
        for seed in first..first + cell.seeds {
            let name = format!("{count:05}");
            let options = BlindOptions { seed, ..cell.options.clone() };
            write_blind(&Path::new(folder).join(&name), &options).map_err(|e| say(&e))?;
            let line = serde_json::json!({ "cell": cell.id(), "seed": seed, "folder": name });
            writeln!(index, "{line}").map_err(|e| say(&e))?;
            count += 1;
        }
    }
    Ok(count)
}
