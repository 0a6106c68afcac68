//! Runs of `kind = "bench"`: curve, dead time and lag of one thruster from its command and its
//! force over time.

use std::collections::BTreeMap;

use serde::Serialize;

use super::bench_command::command_of;
use super::codes;
use super::error::Error;
use super::load::Campaign;
use crate::finding::Finding;
use crate::run::{Run, Signal};
use crate::thrust::bench::{BenchFit, BenchRun, fit_bench};

/// Results of the bench runs of a campaign. Serialises as part of `hydrosysid fit --json`.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Bench {
    /// One entry per thruster.
    pub thrusters: Vec<BenchThruster>,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
}

/// One thruster on the bench.
#[derive(Debug, Clone, Serialize)]
pub struct BenchThruster {
    /// Name in the campaign, otherwise the column of its command.
    pub name: String,
    /// Names of its runs.
    pub runs: Vec<String>,
    /// Result of the fit.
    pub fit: BenchFit,
    /// The keys of its `[[thruster]]` table.
    pub tables: String,
}

impl Campaign {
    /// Refuses an analysis of the vehicle if every run is of a thruster on a bench.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn refuse_bench_alone(&self) -> Result<(), Error> {
        if !self.runs.is_empty() || self.benches.is_empty() {
            return Ok(());
        }
        let text = "all runs are of a thruster on a bench, none of the vehicle: `hydrosysid fit` estimates the \
                    thruster from them; add runs of the vehicle for anything else";
        Err(Error::Refused { findings: vec![Finding::new(&codes::BENCH_ALONE, text)] })
    }
}

/// Fits the bench runs of a campaign; runs with the same command column are fitted together.
pub fn bench(campaign: &Campaign) -> Bench {
    let mut groups: BTreeMap<String, Vec<&Run>> = BTreeMap::new();
    for run in &campaign.benches {
        groups.entry(command_of(run).unwrap_or_default()).or_default().push(run);
    }
    let mut found = Bench::default();
    for (column, runs) in groups {
        let thruster = column
            .get(1..)
            .and_then(|n| n.parse::<usize>().ok())
            .and_then(|n| campaign.file.thrusters.get(n.wrapping_sub(1)));
        let pairs: Vec<(Signal, Signal)> = runs.iter().filter_map(|run| together(run, &column)).collect();
        let rows: Vec<BenchRun<'_>> = pairs
            .iter()
            .map(|(command, force)| BenchRun { time: force.time(), command: command.values(), force: force.values() })
            .collect();
        let names: Vec<String> = runs.iter().map(|run| run.name.clone()).collect();
        match fit_bench(&rows, thruster.map_or(0.0, |t| t.deadband)) {
            Ok(fit) => {
                let name = thruster.map_or_else(|| column.clone(), |t| t.name.clone());
                let tables = tables(&fit);
                if !fit.converged {
                    let text = format!("the fit of the bench runs of {name} stopped before it converged");
                    found.warnings.push(Finding::new(&codes::NOT_CONVERGED, text));
                }
                found.thrusters.push(BenchThruster { name, runs: names, fit, tables });
            }
            Err(error) => {
                let text = format!("{}: {error}", names.join(", "));
                found.warnings.push(Finding::new(&codes::BENCH, text));
            }
        }
    }
    found
}

/// Returns command and force at the time stamps of the force; the command is held between its
/// samples.
fn together(run: &Run, column: &str) -> Option<(Signal, Signal)> {
    let (command, force) = (run.signal(column)?, run.signal("force")?);
    let held = |t: f64| {
        let after = command.time().partition_point(|s| *s <= t).max(1);
        command.values()[after - 1]
    };
    let values: Vec<f64> = force.time().iter().map(|t| held(*t)).collect();
    Some((Signal::new(force.shared_time().clone(), values), force.clone()))
}

/// Returns the keys of the `[[thruster]]` table of a vehicle file.
pub(super) fn tables(fit: &BenchFit) -> String {
    let Some([forward, reverse]) = fit.coefficients() else { return String::new() };
    let astern = if fit.reverse.is_none() { "   # not run astern: same curve as ahead" } else { "" };
    let lags = fit.lag_at.iter().map(|(n, lag)| format!("{:.4} ± {:.4} s at a command of {n:.2}", lag.value, lag.std));
    let lags: Vec<String> = lags.collect();
    format!(
        "forward = {{ a = {:.3}, b = {:.3} }}\nreverse = {{ a = {:.3}, b = {:.3} }}{astern}\ndeadband = {:.4}\n# dead time {:.4} ± {:.4} s, lag {}\n",
        forward.a,
        forward.b,
        reverse.a,
        reverse.b,
        fit.deadband.value,
        fit.delay.value,
        fit.delay.std,
        lags.join(", ")
    )
}
