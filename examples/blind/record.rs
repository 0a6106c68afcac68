//! What became of one campaign, and the file in which such records are kept.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use hydrosysid::discover::{Discovery, SearchOptions, Verdict, discover, gap};
use hydrosysid::estimate::output_error::{OutputErrorOptions, output_error};
use hydrosysid::model::Model;
use hydrosysid::run::{Role, Run};
use hydrosysid::tank::{Blind, BlindOptions, blind};

use crate::plan::Cell;

/// Gap over noise from which on it is asked how much of it was closed.
const CLOSING: f64 = 3.0;

/// One campaign.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Record {
    /// The cell.
    pub cell: String,
    /// The seed.
    pub seed: u64,
    /// Canonical names of what was hidden.
    pub hidden: Vec<String>,
    /// The verdict; `no answer` where the search ended in an error.
    pub verdict: String,
    /// What was named, each with what else is possible.
    pub named: Vec<(String, Vec<String>)>,
    /// Largest held-out gap over noise of the refitted baseline.
    pub before: f64,
    /// The same of the final model.
    pub after: f64,
    /// The same of the true model, refitted; where the first was above 3.
    pub truth: Option<f64>,
    /// Seconds of one core.
    pub seconds: f64,
}

impl Record {
    /// Makes the campaign of a cell and judges the answer to it; a search that ends in an error counts as judged.
    ///
    /// # Errors
    /// When the tank cannot make the campaign.
    pub fn make(cell: &Cell, seed: u64) -> Result<Record, String> {
        let campaign = blind(&BlindOptions { seed, ..cell.options.clone() }).map_err(|e| e.to_string())?;
        let model = campaign.model().map_err(|e| e.to_string())?;
        let fitting = OutputErrorOptions { position: true, ..OutputErrorOptions::default() };
        let clock = Clock::start();
        let answer = discover(&model, &campaign.runs, &[], &fitting, &SearchOptions::default());
        let seconds = clock.seconds();
        let Ok(answer) = answer else {
            // no answer is a miss, however large the gap
            let (hidden, none) = (campaign.hidden.clone(), f64::MAX);
            let verdict = "no answer".to_string();
            return Ok(Record {
                cell: cell.id(),
                seed,
                hidden,
                verdict,
                named: Vec::new(),
                before: none,
                after: none,
                truth: None,
                seconds,
            });
        };
        let before = ratio(&answer, 0);
        Ok(Record {
            cell: cell.id(),
            seed,
            hidden: campaign.hidden.clone(),
            verdict: match answer.verdict {
                Verdict::NothingMissing => "nothing_missing",
                Verdict::Explained => "explained",
                Verdict::PartlyExplained => "partly_explained",
                Verdict::Unexplained => "unexplained",
            }
            .to_string(),
            named: answer.effects.iter().map(|e| (e.id.clone(), e.also_possible.clone())).collect(),
            before,
            after: ratio(&answer, answer.gap.len() - 1),
            truth: if before > CLOSING { reachable(&campaign, &answer, &fitting) } else { None },
            seconds,
        })
    }
}

/// Largest held-out gap over noise after step `k`.
fn ratio(answer: &Discovery, k: usize) -> f64 {
    let step = &answer.gap[k];
    step.held_out_rms.iter().map(|(dof, rms)| rms / step.noise_floor[dof]).fold(0.0, f64::max)
}

/// The gap that the true model leaves once it is refitted; `None` where it cannot be.
fn reachable(campaign: &Blind, answer: &Discovery, fitting: &OutputErrorOptions) -> Option<f64> {
    let (train, held): (Vec<Run>, Vec<Run>) = campaign.runs.iter().cloned().partition(|r| r.role == Role::Train);
    let truth = on_train(&campaign.truth, &campaign.runs);
    let fit = output_error(&truth, &train, fitting).ok()?;
    let cut: Vec<bool> = held
        .iter()
        .map(|run| answer.warnings.iter().any(|w| w.code == "D102" && w.message.contains(&run.name)))
        .collect();
    let left = gap(&fit.model, &held, fitting, &cut).ok()?;
    Some(left.rms.iter().map(|(dof, rms)| rms / answer.gap[0].noise_floor[dof]).fold(0.0, f64::max))
}

/// The model with the values per run of the training runs alone.
fn on_train(truth: &Model, runs: &[Run]) -> Model {
    let mut model = truth.clone();
    for parameter in model.parameters.iter_mut().filter(|p| !p.per_run.is_empty()) {
        let values = parameter.per_run.iter().zip(runs).filter(|(_, run)| run.role == Role::Train).map(|(v, _)| *v);
        parameter.per_run = values.collect();
    }
    model
}

/// Time that this thread was on a core where the system tells it, else time that went by.
struct Clock {
    core: Option<f64>,
    wall: Instant,
}

impl Clock {
    fn start() -> Clock {
        Clock { core: on_core(), wall: Instant::now() }
    }

    fn seconds(&self) -> f64 {
        match (self.core, on_core()) {
            (Some(begin), Some(end)) => end - begin,
            _ => self.wall.elapsed().as_secs_f64(),
        }
    }
}

/// Seconds that this thread has been on a core (Linux).
fn on_core() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(nanoseconds * 1e-9)
}

/// The records of a file, by cell and seed; a last line that was cut short is left out.
pub fn read(path: &str) -> BTreeMap<(String, u64), Record> {
    let Ok(file) = File::open(path) else { return BTreeMap::new() };
    BufReader::new(file)
        .lines()
        .map_while(Result::ok)
        .filter_map(|line| serde_json::from_str::<Record>(&line).ok())
        .map(|record| ((record.cell.clone(), record.seed), record))
        .collect()
}

/// Adds a record to a file.
pub fn append(path: &str, record: &Record) -> Result<(), String> {
    let say = |e: &dyn std::fmt::Display| format!("{path}: {e}");
    let mut file = OpenOptions::new().create(true).append(true).open(path).map_err(|e| say(&e))?;
    let line = serde_json::to_string(record).map_err(|e| say(&e))?;
    writeln!(file, "{line}").map_err(|e| say(&e))
}
