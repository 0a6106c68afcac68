//! The verb `monitor`: a model along new logs.

use std::path::Path;

use super::arguments::Monitor;
use super::failure::Failure;
use super::output::Output;
use super::table::{chance, number, size, table};
use super::verbs::reading;
use crate::campaign::file::{CampaignFile, ReadOptions};
use crate::campaign::{self, Error, ModelFile};
use crate::monitor::{MonitorOptions, Reason, Watch};

pub(super) fn monitor(a: &Monitor, output: &Output) -> Result<(), Failure> {
    output.may_write(None)?;
    for (name, value, most) in [("window", a.window, f64::MAX), ("level", a.level, 0.5)] {
        if !(value > 0.0 && value <= most) {
            return Err(Failure::Argument(format!("--{name} {value}: must be above 0 and at most {most}")));
        }
    }
    let file = ModelFile::read(&a.model)?;
    let read = ReadOptions { look_for_files: false, allow_outside: true, ..ReadOptions::default() };
    let like = a.campaign.as_deref().map(|path| CampaignFile::read(path, &read)).transpose().map_err(Error::File)?;
    let log = if a.reading.options.is_empty() { None } else { Some(reading(&a.reading)?) };
    let logs: Vec<&Path> = a.logs.iter().map(|p| p.as_path()).collect();
    let busy = output.busy("reading logs");
    let campaign = campaign::new_logs(&file, &logs, log.as_ref(), like.as_ref())?;
    busy.finish_and_clear();
    let model = file.model(&campaign.runs, &a.model)?;
    let busy = output.busy("watching");
    let options = MonitorOptions { window: a.window, level: a.level };
    let found = campaign::monitor(&campaign, &model, &file.envelope, &options)?;
    busy.finish_and_clear();
    print(&found.watch, output);
    output.json(&found)?;
    output.tell(&found.watch.warnings)
}

/// Windows in a table: those that are off, or all of a short log.
const SHOWN: usize = 24;

fn print(watch: &Watch, output: &Output) {
    let off: Vec<_> = watch.windows.iter().filter(|w| w.off).collect();
    let shown: Vec<_> = if watch.windows.len() <= SHOWN { watch.windows.iter().collect() } else { off.clone() };
    let rows: Vec<Vec<String>> = shown
        .iter()
        .take(SHOWN)
        .map(|w| {
            vec![
                w.run.clone(),
                w.dof.to_string(),
                format!("{:.1}", w.from),
                format!("{:.1}", w.to),
                size(w.rms),
                size(w.mean),
                size(w.noise),
                chance(w.p_value),
                if w.off { "off".into() } else { String::new() },
            ]
        })
        .collect();
    if !rows.is_empty() {
        output.print(&table(&["run", "dof", "from s", "to s", "rms", "mean", "expected", "p", ""], &rows));
    }
    if shown.len() > SHOWN {
        output.print(&format!("and {} more: --json has them all", shown.len() - SHOWN));
    }
    let verdict = if watch.fits { "the model still fits" } else { "the model no longer fits" };
    output.print(&format!("{verdict}: {} of {} windows are off", off.len(), watch.windows.len()));
    let rows: Vec<Vec<String>> = watch.reasons.iter().map(reason).collect();
    if !rows.is_empty() {
        output.print(&table(&["likely reason", "parameter", "from", "to", "explains %", "what it means"], &rows));
    }
}

fn reason(r: &Reason) -> Vec<String> {
    let value = |x: Option<f64>| x.map(number).unwrap_or_default();
    vec![
        r.id.clone(),
        format!("{} [{}]", r.parameter, r.unit),
        value(r.before),
        value(r.after),
        format!("{:.0}", 100.0 * r.explained),
        r.meaning.clone(),
    ]
}
