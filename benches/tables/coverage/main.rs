//! Table of coverage: how often the 95 % intervals of filter error cover the true value, and how
//! near the errors of the estimates are to the Cramér-Rao bound.
//!
//! `cargo run --release --example coverage -- [--seeds N] [--first SEED] [--only TEXT] [--write FILE]`
//!
//! The truth is the independent plant (`plant/`), which shares no code with the estimator. Each
//! campaign has a newly drawn vehicle, is written as a folder and read like that of a user. Errors
//! are divided by the Cramér-Rao bound of their own campaign at its true parameters, noise and
//! random force, before they are squared and averaged. As in the verb `fit`, standard deviations
//! include the shift of the parameters by an effect that the model lacks and that the innovations
//! show. Seconds are those of the fit alone.

mod cells;
#[path = "../over_seeds/mod.rs"]
mod over_seeds;

use std::fmt::Write as _;
use std::path::Path;

use cells::{Cell, cells};
use hydrosysid::campaign::{Campaign, LoadOptions};
use hydrosysid::discover::{SearchOptions, lacking};
use hydrosysid::estimate::filter_error::{
    FilterErrorOptions, NoiseModel, RandomForce, SensorNoise, bound, filter_error,
};
use hydrosysid::estimate::started;
use hydrosysid::frame::Dof;
use hydrosysid::run::{Role, Run};
use hydrosysid_plant::Sailed;
use over_seeds::Arguments;
use rayon::prelude::*;

/// Result of one campaign.
struct Outcome {
    /// Name of each parameter, with its error over its standard deviation and over the bound.
    errors: Vec<(String, f64, f64)>,
    /// Estimated rms over the true one, and estimated correlation time over the true one, for each
    /// true random force.
    force: Vec<(f64, f64)>,
    /// Largest estimated random force, as a share of the commanded one; false where there is no true force.
    false_force: f64,
    converged: bool,
    white: bool,
    seconds: f64,
}

fn one(cell: &Cell, seed: u64) -> Result<Outcome, String> {
    let text = |e: &dyn std::fmt::Display| format!("{}, seed {seed}: {e}", cell.name);
    let sailed = (cell.campaign)(seed).sail().map_err(|e| text(&e))?;
    let folder = std::env::temp_dir().join(format!("hydrosysid-coverage-{}-{seed}", std::process::id()));
    let loaded = read(&sailed, &folder);
    let _ = std::fs::remove_dir_all(&folder);
    let campaign = loaded.map_err(|e| text(&e))?;
    let runs: Vec<Run> = campaign.runs.iter().filter(|r| r.role == Role::Train).cloned().collect();
    let mut options = FilterErrorOptions { base: campaign.options.output_error.clone(), ..Default::default() };
    if let Some(factor) = cell.stated {
        let stated = sailed.truth.noise.iter().map(|(name, std)| (name.clone(), factor * std));
        options.base.sigma = Some(stated.collect());
    }
    let begin = cpu_time::ThreadTime::now();
    let fit = filter_error(&started(&campaign.model, &runs), &runs, &options).map_err(|e| text(&e))?;
    let seconds = begin.elapsed().as_secs_f64();
    let lacking =
        lacking(&fit, &runs, &campaign.candidates, &options, &SearchOptions::default()).map_err(|e| text(&e))?;
    let more = lacking.map(|lacking| lacking.covariance());
    let more = |parameter: usize| more.as_ref().map_or(0.0, |more| more[parameter][parameter]);

    let mut truth = fit.model.clone();
    let unknowns = fit.filtered.problem.unknowns.clone();
    for unknown in &unknowns {
        let parameter = &mut truth.parameters[unknown.parameter];
        let values = sailed.truth.values.iter();
        let of = values.filter(|v| v.effect == parameter.term).find(|v| v.name == parameter.spec.name);
        let of = of.map(|v| v.value).or_else(|| sailed.truth.value(&parameter.term));
        parameter.value = of.ok_or_else(|| text(&format!("no truth of {}", parameter.term)))?;
    }
    let least =
        bound(&truth, &runs, &true_noise(&sailed, &fit.filtered.problem.dynamics.outputs, &fit.noise), &options)
            .map_err(|e| text(&e))?;
    let p = unknowns.len();
    let errors = unknowns.iter().enumerate().map(|(k, u)| {
        let (found, true_one) = (&fit.model.parameters[u.parameter], &truth.parameters[u.parameter]);
        let error = found.value - true_one.value;
        let std = (found.std.unwrap_or(f64::NAN).powi(2) + more(u.parameter)).sqrt();
        (found.term.clone(), error / std, error / least[k * p + k].sqrt())
    });
    let found = |dof: &str| fit.noise.forces.iter().find(|f| f.dof.name() == dof);
    let with = sailed.truth.force.iter().filter(|f| f.rms > 0.0);
    let force = with.map(|f| found(f.dof.name()).map_or((0.0, 1.0), |g| (g.rms / f.rms, g.time / f.correlation)));
    let commanded = |dof: Dof| {
        let values = || runs.iter().filter_map(|r| r.signal(dof.force())).flat_map(|s| s.values());
        (values().map(|x| x * x).sum::<f64>() / values().count().max(1) as f64).sqrt()
    };
    let false_force = fit.noise.forces.iter().map(|f| f.rms / commanded(f.dof)).fold(0.0, f64::max);
    let forecasts = fit.filtered.forecast(&fit.model, &fit.noise, fit.limit);
    let channels = fit.noise.sensors.len();
    let white = (0..channels).all(|c| {
        let all = forecasts.iter().map(|f| f.channels[c].whiteness.clone()).reduce(|a, b| a.with(&b));
        all.is_none_or(|w| w.p_value() >= 0.01 / channels as f64)
    });
    Ok(Outcome {
        errors: errors.collect(),
        force: force.collect(),
        false_force,
        converged: fit.converged,
        white,
        seconds,
    })
}

fn read(sailed: &Sailed, folder: &Path) -> Result<Campaign, String> {
    sailed.write(folder).map_err(|e| e.to_string())?;
    Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).map_err(|e| e.to_string())
}

/// The true noise of the plant; for a sensor without a true value, the estimated one.
fn true_noise(sailed: &Sailed, outputs: &[String], found: &NoiseModel) -> NoiseModel {
    let sensor = |(name, found): (&String, &SensorNoise)| {
        sailed.truth.noise.get(name).map_or(*found, |std| SensorNoise { std: *std, coloured: None })
    };
    let forces = sailed.truth.force.iter().filter(|f| f.rms > 0.0).filter_map(|f| {
        let dof = Dof::from_name(f.dof.name())?;
        // a force that is new at every command sample and held over it
        let time = if f.correlation > 0.0 { f.correlation } else { 0.5 / sailed.campaign.command_rate };
        Some(RandomForce { dof, rms: f.rms, time })
    });
    NoiseModel { forces: forces.collect(), sensors: outputs.iter().zip(&found.sensors).map(sensor).collect() }
}

/// Half width of a 95 % interval, in standard deviations.
const TWO_SIDED_95: f64 = 1.959_964;

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// The row of a cell.
fn row(cell: &Cell, outcomes: &[Outcome], failed: usize) -> String {
    let inside = |list: &[&(String, f64, f64)]| {
        100.0 * list.iter().filter(|e| e.1.abs() < TWO_SIDED_95).count() as f64 / list.len().max(1) as f64
    };
    let all: Vec<&(String, f64, f64)> = outcomes.iter().flat_map(|o| &o.errors).collect();
    let mut names: Vec<&String> = all.iter().map(|e| &e.0).collect();
    names.sort();
    names.dedup();
    let of = |name: &String| all.iter().filter(|e| e.0 == *name).copied().collect::<Vec<_>>();
    let least = names.iter().map(|n| inside(&of(n))).fold(100.0, f64::min);
    let over = (all.iter().map(|e| e.2 * e.2).sum::<f64>() / all.len().max(1) as f64).sqrt();
    let force = median(outcomes.iter().flat_map(|o| o.force.iter().map(|f| f.0)).collect());
    let time = median(outcomes.iter().flat_map(|o| o.force.iter().filter(|f| f.0 > 0.0).map(|f| f.1)).collect());
    let none = outcomes.iter().filter(|o| o.false_force == 0.0).count();
    let told = match (force, time) {
        (Some(rms), Some(time)) if time.is_finite() => format!("{rms:.2}, {time:.2}"),
        (Some(rms), _) => format!("{rms:.2}, -"),
        _ => {
            let most = outcomes.iter().map(|o| 100.0 * o.false_force).fold(0.0, f64::max);
            format!("none in {none}; at most {most:.1} %")
        }
    };
    let count = |f: fn(&Outcome) -> bool| outcomes.iter().filter(|o| f(o)).count();
    format!(
        "| {} | {} | {:.1} | {least:.1} | {over:.2} | {told} | {} | {} | {failed} | {:.2} |\n",
        cell.name,
        outcomes.len(),
        inside(&all),
        count(|o| !o.converged),
        count(|o| o.white),
        median(outcomes.iter().map(|o| o.seconds).collect()).unwrap_or(0.0),
    )
}

fn main() -> Result<(), String> {
    let asked = Arguments::read(120, 50_000)?;
    let mut text = format!(
        "# Coverage\n\nMade by `make coverage` on the independent plant: {} campaigns a cell, seeds from {}, other seeds in \
         each cell. How: the heading of `benches/tables/coverage/main.rs`.\n\nPer cent of 95 % intervals of filter error that cover \
         the truth, of all parameters (a share of 95 % has a standard error of {:.1} %) and of the worst one; \
         root-mean-square error over the Cramér-Rao bound with the true random force; random force found over true (rms, \
         correlation time; medians); campaigns whose fit did not converge, whose innovations are white at 1 %, that \
         could not be fitted; seconds of one core (median).\n",
        asked.seeds,
        asked.first,
        100.0 * (0.95 * 0.05 / (9 * asked.seeds) as f64).sqrt()
    );
    let mut section = "";
    for (k, cell) in cells().iter().enumerate().filter(|(_, c)| c.name.contains(&asked.only)) {
        if cell.section != section {
            section = cell.section;
            let _ = write!(
                text,
                "\n## {section}\n\n| cell | n | inside % | least % | error/bound | force | not converged | white | failed | s |\n\
                 |---|---|---|---|---|---|---|---|---|---|\n"
            );
        }
        let first = asked.first + k as u64 * asked.seeds;
        let results: Vec<_> = (first..first + asked.seeds).into_par_iter().map(|seed| one(cell, seed)).collect();
        let (mut outcomes, mut failed) = (Vec::new(), 0);
        for result in results {
            match result {
                Ok(outcome) => outcomes.push(outcome),
                Err(reason) => {
                    eprintln!("{reason}");
                    failed += 1;
                }
            }
        }
        let row = row(cell, &outcomes, failed);
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
