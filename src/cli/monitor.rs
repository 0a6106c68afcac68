//! The verb `monitor`: checks a model on new logs.

use std::path::Path;

use super::answer;
use super::arguments::Monitor;
use super::failure::Failure;
use super::output::Output;
use super::table::{number, size, table};
use super::verbs::reading;
use crate::campaign::file::{CampaignFile, ReadOptions};
use crate::campaign::{self, Error, ModelFile};
use crate::monitor::{MonitorOptions, Reason, Watch, Window};
use crate::wording::{count, probability};

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
    let campaign = campaign::new_logs(&file, &logs, log.as_ref(), like.as_ref())?
        .under_model(&file, &a.model.display().to_string());
    busy.finish_and_clear();
    let model = file.model_for(&campaign, &a.model)?;
    let busy = output.busy("watching");
    let options = MonitorOptions { window: a.window, level: a.level };
    let found = campaign::monitor(&campaign, &model, &file.envelope, &options)?;
    busy.finish_and_clear();
    print(&found.watch, output);
    output.json(&found)?;
    output.tell(&found.watch.warnings)?;
    let (model, first) = (a.model.display(), a.logs[0].display());
    // a model that fits is used; one that does not is fitted anew
    let next = match found.watch.fits {
        true => format!("hydrosysid export {model} --to kalman -o filter.json"),
        false => format!("hydrosysid init {first} -o anew"),
    };
    answer::next(&next, output);
    Ok(())
}

/// Maximum number of windows in the table: those that are off, or all of a short log.
const SHOWN: usize = 24;

fn print(watch: &Watch, output: &Output) {
    answer::verdict(&verdict(watch), output);
    if !watch.reasons.is_empty() {
        let heads = ["likely reason", "parameter", "from", "to", "explains %", "what it means"];
        let rows: Vec<Vec<String>> = watch.reasons.iter().map(reason).collect();
        // the verdict contains the meaning of the best reason
        let columns = if output.is_verbose() { heads.len() } else { heads.len() - 1 };
        let rows: Vec<Vec<String>> = rows.into_iter().map(|row| row[..columns].to_vec()).collect();
        output.print(&table(&heads[..columns], &rows));
    } else {
        each_run(watch, output);
    }
    if output.is_verbose() {
        windows(watch, output);
    }
}

/// Whether the model still fits; if not, since when and why.
fn verdict(watch: &Watch) -> String {
    let off = watch.windows.iter().filter(|w| w.off).count();
    let windows = count(watch.windows.len(), "window");
    if watch.fits {
        return format!("the model still fits: {off} of {windows} {} off", if off == 1 { "is" } else { "are" });
    }
    let first = watch.changes.iter().max_by(|a, b| a.times_noise.total_cmp(&b.times_noise));
    let since = first.map_or(String::new(), |c| {
        format!(
            " Most in {} of {} from {:.1} s on: {} times the expected error.",
            c.dof,
            c.run,
            c.from,
            size(c.times_noise)
        )
    });
    let why = watch.reasons.first().map_or(String::new(), |r| {
        format!(
            " Likely reason: {}, which explains {:.0} % of it.",
            r.meaning.trim_end_matches('.'),
            100.0 * r.explained
        )
    });
    format!("the model no longer fits: {off} of {windows} are off.{since}{why}")
}

/// One row per run and degree of freedom.
fn each_run(watch: &Watch, output: &Output) {
    let mut groups: Vec<Vec<&Window>> = Vec::new();
    for window in &watch.windows {
        match groups.iter_mut().find(|group| group[0].run == window.run && group[0].dof == window.dof) {
            Some(group) => group.push(window),
            None => groups.push(vec![window]),
        }
    }
    let row = |group: &Vec<&Window>| {
        let rms =
            |f: &dyn Fn(&Window) -> f64| (group.iter().map(|w| f(w).powi(2)).sum::<f64>() / group.len() as f64).sqrt();
        let least = group.iter().map(|w| w.p_value).fold(1.0, f64::min);
        vec![
            group[0].run.clone(),
            group[0].dof.to_string(),
            format!("{} of {}", group.iter().filter(|w| w.off).count(), group.len()),
            size(rms(&|w| w.rms)),
            size(rms(&|w| w.noise)),
            probability(least),
        ]
    };
    let rows: Vec<Vec<String>> = groups.iter().map(row).collect();
    if !rows.is_empty() {
        output.print(&table(&["run", "dof", "windows off", "rms", "expected", "least p"], &rows));
    }
}

fn windows(watch: &Watch, output: &Output) {
    let off = watch.windows.iter().filter(|w| w.off);
    let shown: Vec<&Window> = if watch.windows.len() <= SHOWN { watch.windows.iter().collect() } else { off.collect() };
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
                probability(w.p_value),
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
