//! The table of coverage: do 95 % intervals hold the truth 95 % of the time, and is the estimate as good as can be?
//!
//! `cargo run --release --example coverage -- [--campaigns N] [--first SEED] [--segment SECONDS] [--write FILE]`
//!
//! A 3-DOF bench: the large vehicle of the tank, drawn anew in each campaign, six training runs of 90 s logged at 3 Hz,
//! with 1, 5 and 20 times the noise of a DVL (1 mm/s; 0.6 mrad/s, 0.1°, 1 cm). Errors are divided by the Cramér-Rao
//! bound of their own campaign before they are squared and averaged.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use hydrosysid::estimate::output_error::{OutputErrorOptions, StdMethod, cramer_rao, output_error};
use hydrosysid::estimate::{IntegralOptions, StdMethod as RowStd, integral_least_squares, started};
use hydrosysid::model::Model;
use hydrosysid::run::{Role, Run};
use hydrosysid::tank::{BlindOptions, blind};
use rayon::prelude::*;

/// Noise in units of a DVL's 1 mm/s; the tank's own unit is five times that.
const LEVELS: [f64; 3] = [1.0, 5.0, 20.0];
const TANK_UNIT: f64 = 5.0;

/// What is asked of the command.
struct Arguments {
    campaigns: u64,
    first: u64,
    segment: f64,
    write: Option<String>,
}

fn arguments() -> Result<Arguments, String> {
    let mut found =
        Arguments { campaigns: 420, first: 10_000, segment: OutputErrorOptions::default().segment, write: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        let number = |text: String| text.parse().map_err(|_| format!("{word} takes a whole number"));
        match word.as_str() {
            "--campaigns" => found.campaigns = number(value()?)?,
            "--first" => found.first = number(value()?)?,
            "--segment" => found.segment = value()?.parse().map_err(|_| "--segment takes seconds".to_string())?,
            "--write" => found.write = Some(value()?),
            other => {
                return Err(format!(
                    "unknown argument {other}: --campaigns N, --first SEED, --segment SECONDS, --write FILE"
                ));
            }
        }
    }
    Ok(found)
}

/// One parameter of one campaign.
struct Outcome {
    name: String,
    /// Error over the Cramér-Rao bound: output error, trapezoid.
    error: [f64; 2],
    /// Error over its own standard deviation: output error, trapezoid with HAC, trapezoid by (14).
    score: [f64; 3],
    method: StdMethod,
    /// Whether the segments were joined to whole runs.
    joined: bool,
}

fn campaign(seed: u64, level: f64, segment: f64) -> Result<Vec<Outcome>, String> {
    let text = |e: &dyn std::fmt::Display| format!("seed {seed}, {level} DVL: {e}");
    let options = BlindOptions { seed, rate: 3.0, noise: level / TANK_UNIT, ..BlindOptions::default() };
    let train = |runs: Vec<Run>| runs.into_iter().filter(|r| r.role == Role::Train).collect::<Vec<Run>>();
    let noisy = blind(&options).map_err(|e| text(&e))?;
    let model = noisy.model().map_err(|e| text(&e))?;
    let runs = train(noisy.runs);
    let clean = train(blind(&BlindOptions { noise: 0.0, ..options }).map_err(|e| text(&e))?.runs);
    let fitting = OutputErrorOptions { position: true, join: true, segment, ..OutputErrorOptions::default() };
    let fit = output_error(&started(&model, &runs), &runs, &fitting).map_err(|e| text(&e))?;
    let known = OutputErrorOptions { sigma: Some(sigma(level)), ..fitting };
    let bound = cramer_rao(&noisy.truth, &clean, &known).map_err(|e| text(&e))?;
    let (rows, paper) = trapezoid(&model, &runs).map_err(|e| text(&e))?;
    let p = fit.problem.unknowns.len();
    let all = fit.problem.unknowns.iter().enumerate().map(|(k, unknown)| {
        let found = &fit.model.parameters[unknown.parameter];
        let truth = noisy.truth.value(&found.term).ok_or_else(|| format!("{} has no truth", found.term))?;
        let least = bound[k * p + k].sqrt();
        let row = &rows.parameters[unknown.parameter];
        let (own, off) = (found.value - truth, row.value - truth);
        Ok(Outcome {
            // a bar would end the cell of the table
            name: format!("{} of {}", found.spec.name.replace('|', "\\|"), found.term),
            error: [own / least, off / least],
            score: [
                own / found.std.unwrap_or(f64::NAN),
                off / row.std.unwrap_or(f64::NAN),
                off / paper.parameters[unknown.parameter].std.unwrap_or(f64::NAN),
            ],
            method: fit.std_method,
            joined: fit.problem.segments.len() == runs.len(),
        })
    });
    all.collect()
}

/// Deviation of each sensor, SI.
fn sigma(level: f64) -> BTreeMap<String, f64> {
    let degree = f64::to_radians(1.0);
    let units = [("u", 0.005), ("v", 0.005), ("r", 0.003), ("x", 0.05), ("y", 0.05), ("psi", 0.5 * degree)];
    units.into_iter().map(|(name, s)| (name.to_string(), s * level / TANK_UNIT)).collect()
}

/// One-sample trapezoids, with the deviations of HAC and those of (14).
fn trapezoid(model: &Model, runs: &[Run]) -> Result<(Model, Model), hydrosysid::estimate::IntegralError> {
    let all: Vec<&Run> = runs.iter().collect();
    let by = |std| integral_least_squares(&all, model, IntegralOptions { std, ..IntegralOptions::default() });
    Ok((by(RowStd::Hac)?.0, by(RowStd::Paper)?.0))
}

/// Half the width of a 95 % interval in standard deviations.
const TWO_SIDED_95: f64 = 1.959_964;

struct Row {
    inside: [usize; 3],
    square: [f64; 2],
    count: usize,
}

impl Row {
    fn of<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> Row {
        let mut row = Row { inside: [0; 3], square: [0.0; 2], count: 0 };
        for outcome in outcomes {
            for (inside, score) in row.inside.iter_mut().zip(outcome.score) {
                *inside += usize::from(score.abs() < TWO_SIDED_95);
            }
            for (square, error) in row.square.iter_mut().zip(outcome.error) {
                *square += error * error;
            }
            row.count += 1;
        }
        row
    }

    fn print(&self, name: &str) -> String {
        let share = |k: usize| 100.0 * self.inside[k] as f64 / self.count as f64;
        let rms = |k: usize| (self.square[k] / self.count as f64).sqrt();
        format!("| {name} | {:.1} | {:.3} | {:.1} | {:.1} | {:.2} |\n", share(0), rms(0), share(1), share(2), rms(1))
    }
}

fn main() -> Result<(), String> {
    let asked = arguments()?;
    let mut text = format!(
        "# Coverage\n\nMade by `make coverage`: {} campaigns at each noise level, other seeds at each, from {}. How: the heading of \
         `examples/coverage.rs`.\n\nPer cent of 95 % intervals that hold the truth (a share of 95 % has a standard error \
         of {:.1} % in one row), and root-mean-square error over the Cramér-Rao bound.\n",
        asked.campaigns,
        asked.first,
        100.0 * (0.95 * 0.05 / asked.campaigns as f64).sqrt()
    );
    for (k, level) in LEVELS.into_iter().enumerate() {
        let first = asked.first + k as u64 * asked.campaigns;
        let seeds: Vec<u64> = (first..first + asked.campaigns).collect();
        let results: Vec<_> = seeds.into_par_iter().map(|seed| campaign(seed, level, asked.segment)).collect();
        let mut outcomes = Vec::new();
        let mut failed = 0;
        for result in results {
            match result {
                Ok(found) => outcomes.extend(found),
                Err(reason) => {
                    eprintln!("{reason}");
                    failed += 1;
                }
            }
        }
        let clusters = outcomes.iter().filter(|o| o.method == StdMethod::Clusters).count();
        let _ = write!(
            text,
            "\n## {level} × DVL\n\n| parameter | output error, inside % | RMSE/bound | trapezoid HAC, inside % | \
             trapezoid (14), inside % | trapezoid RMSE/bound |\n|---|---|---|---|---|---|\n"
        );
        let mut names: Vec<&String> = outcomes.iter().map(|o| &o.name).collect();
        names.sort();
        names.dedup();
        for name in names {
            text += &Row::of(outcomes.iter().filter(|o| o.name == *name)).print(name);
        }
        text += &Row::of(outcomes.iter()).print("**all**");
        let _ = writeln!(
            text,
            "\n{failed} campaigns without a fit; {:.1} % of the deviations from clusters of residuals; {:.1} % of fits with \
             whole runs as segments.",
            100.0 * clusters as f64 / outcomes.len().max(1) as f64,
            100.0 * outcomes.iter().filter(|o| o.joined).count() as f64 / outcomes.len().max(1) as f64
        );
        eprintln!("{level} × DVL: done");
    }
    match asked.write {
        Some(path) => std::fs::write(&path, text).map_err(|e| format!("{path}: {e}")),
        None => {
            println!("{text}");
            Ok(())
        }
    }
}
