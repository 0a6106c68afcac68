//! The verb `check`: a light for each topic of each log; with `--verbose` how often its sensors speak, how late they are.

use std::path::{Path, PathBuf};

use super::arguments as typed;
use super::failure::Failure;
use super::output::Output;
use super::table::{measured, number, table};
use super::verbs::reading;
use crate::campaign::{self, Check, CheckedLog, LoadOptions};
use crate::check::lag::Lag;
use crate::check::rates::ChannelRate;
use crate::check::{Light, Topic};

pub(super) fn check(a: &typed::Check, output: &Output) -> Result<(), Failure> {
    output.may_write(None)?;
    let campaigns = a.files.iter().filter(|f| f.is_dir() || f.extension().is_some_and(|e| e == "toml")).count();
    let busy = output.busy("reading logs");
    let found = match (campaigns, a.files.as_slice()) {
        (1, [campaign]) => campaign::check_campaign(campaign, LoadOptions { allow_outside: a.campaign.allow_outside })?,
        (0, logs) => {
            let paths: Vec<&Path> = logs.iter().map(PathBuf::as_path).collect();
            let columns: Vec<&str> = a.columns.iter().map(String::as_str).collect();
            campaign::check_logs(&paths, &reading(&a.reading)?, &columns)?
        }
        _ => return Err(Failure::Argument("give one campaign, or logs".into())),
    };
    busy.finish_and_clear();
    print_check(&found, output);
    output.json(&found)?;
    let told = output.tell(&found.warnings);
    if found.errors.is_empty() {
        return told;
    }
    let refused = found.logs.iter().filter(|log| log.verdict == Light::Red).count();
    Err(Failure::Refused { refused, what: "the logs", findings: found.errors })
}

/// The light in a word.
fn word(light: Option<Light>) -> String {
    light.map_or("-".into(), |light| format!("{light:?}").to_lowercase())
}

fn print_check(found: &Check, output: &Output) {
    let topics = Topic::ALL.map(|topic| format!("{topic:?}").to_lowercase());
    let mut heads = vec!["log", "check", "rows", "s", "stretches"];
    heads.extend(topics.iter().map(String::as_str));
    let row = |log: &CheckedLog| {
        let of = |topic: Topic| log.lights.iter().find(|l| l.topic == topic).and_then(|l| l.light);
        let mut row = vec![
            log.file.clone(),
            word(Some(log.verdict)),
            log.rows.to_string(),
            number(log.duration),
            log.segments.to_string(),
        ];
        row.extend(Topic::ALL.map(|topic| word(of(topic))));
        row
    };
    output.print(&table(&heads, &found.logs.iter().map(row).collect::<Vec<_>>()));
    if output.is_verbose() {
        print_rates(found, output);
    }
    let (warnings, errors) = (found.warnings.len(), found.errors.len());
    let shown = match found.verdict {
        Light::Green => "\x1b[1;32mgreen\x1b[0m",
        Light::Amber => "\x1b[1;33mamber\x1b[0m",
        Light::Red => "\x1b[1;31mred\x1b[0m",
    };
    let plural = if errors == 1 { "" } else { "s" };
    output.print(&format!("{shown}: {errors} error{plural}, {warnings} warnings and notes"));
}

/// Rates of the sensors, and pairs of channels that tell of each other.
fn print_rates(found: &Check, output: &Output) {
    let rows: Vec<Vec<String>> = found.logs.iter().flat_map(sensors).collect();
    if !rows.is_empty() {
        output.print(&table(&["log", "channels", "Hz", "rows/s", "gaps"], &rows));
    }
    let rows: Vec<Vec<String>> = found.logs.iter().flat_map(pairs).collect();
    if !rows.is_empty() {
        output.print(&table(&["log", "channel", "against", "factor", "against late by, s"], &rows));
    }
}

/// A row for all channels of a log that come at one rate.
fn sensors(log: &CheckedLog) -> Vec<Vec<String>> {
    let alike = |a: &ChannelRate, b: &ChannelRate| {
        (a.rate_hz / b.rate_hz - 1.0).abs() < 0.02 && (a.logged_hz / b.logged_hz - 1.0).abs() < 0.02 && a.gaps == b.gaps
    };
    let mut groups: Vec<Vec<&ChannelRate>> = Vec::new();
    for rate in &log.rates {
        match groups.iter_mut().find(|group| alike(group[0], rate)) {
            Some(group) => group.push(rate),
            None => groups.push(vec![rate]),
        }
    }
    let row = |group: Vec<&ChannelRate>| {
        let names: Vec<&str> = group.iter().map(|rate| rate.channel.as_str()).collect();
        let first = group[0];
        vec![log.file.clone(), names.join(" "), number(first.rate_hz), number(first.logged_hz), first.gaps.to_string()]
    };
    groups.into_iter().map(row).collect()
}

/// What is held against each other in a log: sensors with sensors, motion with commands.
fn pairs(log: &CheckedLog) -> Vec<Vec<String>> {
    let late = |lag: Option<Lag>| lag.map_or("-".into(), |lag| measured(lag.seconds, Some(lag.std)));
    let agreements = log.agreements.iter().map(|a| {
        vec![log.file.clone(), a.channel.clone(), a.against.clone(), measured(a.factor, Some(a.std)), late(a.lag)]
    });
    let answers = log
        .answers
        .iter()
        .map(|a| vec![log.file.clone(), a.channel.clone(), a.velocity.clone(), "-".into(), late(a.delay)]);
    agreements.chain(answers).collect()
}
