//! `fit` of a campaign with bench runs of thrusters only, and the vehicle file that it makes.

use std::path::Path;

use serde::Serialize;

use super::answer;
use super::arguments as typed;
use super::failure::Failure;
use super::output::Output;
use super::table::{measured, number, table};
use super::verbs::load;
use crate::campaign::file::{CampaignFile, ReadOptions};
use crate::campaign::{self, Bench, Error};
use crate::run::RunKind;
use crate::thrust::bench::Value;

/// The result for JSON.
#[derive(Debug, Serialize)]
pub(super) struct Alone {
    format: u32,
    estimator: &'static str,
    bench: Bench,
}

/// The fit of the bench runs of a campaign that has no others; `None` for any other campaign.
pub(super) fn alone(a: &typed::Fit, output: &Output) -> Result<Option<Alone>, Failure> {
    let read = ReadOptions { allow_outside: a.loading.allow_outside, ..ReadOptions::default() };
    let file = CampaignFile::read(&a.campaign, &read).map_err(Error::File)?;
    if file.runs.iter().any(|run| run.kind != RunKind::Bench) {
        return Ok(None);
    }
    // refused before the work
    if a.model.is_some() && a.vehicle.is_none() {
        return Err(Failure::Argument(
            "bench runs produce a vehicle file, which extends an existing vehicle: add --vehicle NAME, as listed by \
             `hydrosysid vehicles`, or a vehicle file"
                .into(),
        ));
    }
    let loaded = load(&a.campaign, &a.loading, output)?;
    let bench = output.working("fitting", || campaign::bench(&loaded))?;
    Ok(Some(Alone { format: 1, estimator: "bench", bench }))
}

impl Alone {
    pub fn hand_over(&self, a: &typed::Fit, output: &Output) -> Result<(), Failure> {
        print(&self.bench, output);
        output.json(self)?;
        output.tell(&self.bench.warnings)?;
        match (&a.model, &a.vehicle) {
            (Some(path), Some(vehicle)) => self.write_vehicle(path, vehicle, output),
            _ => {
                let command = format!("hydrosysid fit {} --model ours.toml --vehicle NAME", a.campaign.display());
                answer::next(&command, output);
                Ok(())
            }
        }
    }

    fn write_vehicle(&self, path: &Path, vehicle: &str, output: &Output) -> Result<(), Failure> {
        let known = campaign::vehicle(vehicle)?;
        let made = campaign::bench_vehicle(&self.bench, &known, path)?;
        output.write(path, made.text.as_bytes())?;
        output.print(&format!("written: {}, which extends {vehicle}", path.display()));
        for guess in &made.guesses {
            output.print(&format!("guessed: {guess}"));
        }
        answer::next(&format!("hydrosysid init LOGS --vehicle {}", path.display()), output);
        Ok(())
    }
}

fn print(bench: &Bench, output: &Output) {
    let told = |v: Value| measured(v.value, Some(v.std).filter(|std| *std > 0.0));
    for thruster in &bench.thrusters {
        let fit = &thruster.fit;
        let mut rows: Vec<Vec<String>> = Vec::new();
        for (way, pair) in [("forward", fit.forward), ("reverse", fit.reverse)] {
            for (symbol, value) in ["a", "b"].iter().zip(pair.into_iter().flatten()) {
                rows.push(vec![format!("{way} {symbol}"), told(value), "N".into()]);
            }
        }
        rows.push(vec!["dead band".into(), told(fit.deadband), "of the command".into()]);
        rows.push(vec!["dead time".into(), told(fit.delay), "s".into()]);
        for (name, value, unit) in
            [("lag near rest", fit.lag, "s"), ("faster with speed, κ", fit.lag_slope, "1/command")]
        {
            rows.extend(value.map(|v| vec![name.into(), told(v), unit.into()]));
        }
        for (at, value) in &fit.lag_at {
            rows.push(vec![format!("lag at {}", number(*at)), told(*value), "s".into()]);
        }
        for (name, value, unit) in
            fit.ringing.iter().flat_map(|[f, z]| [("bench rings at", *f, "Hz"), ("its damping", *z, "1")])
        {
            rows.push(vec![name.into(), told(value), unit.into()]);
        }
        output.print(&format!("{} ({} runs)", thruster.name, thruster.runs.len()));
        output.print(&table(&["of the thruster", "value ± std", "unit"], &rows));
        output.print(&format!(
            "{:.1} % of the force explained, residuals {} N; for the vehicle file:\n{}",
            100.0 * fit.explained,
            number(fit.rms),
            thruster.tables
        ));
    }
}
