//! The verb `check`: a light for each log and its faults; with `--verbose` a light for each topic,
//! the sample rates of the sensors and their delays.

use std::path::{Path, PathBuf};

use super::answer;
use super::arguments as typed;
use super::failure::Failure;
use super::output::Output;
use super::table::{measured, number, table};
use super::verbs::reading;
use crate::campaign::{self, Check, CheckedLog, LoadOptions};
use crate::check::codes::AT_REST;
use crate::check::lag::Lag;
use crate::check::rates::ChannelRate;
use crate::check::{Light, Topic};
use crate::finding::{Finding, Severity};
use crate::wording::count;

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
    output.tell(&found.warnings)?;
    answer::next(&next(a, &found, campaigns == 1), output);
    if found.errors.is_empty() {
        return Ok(());
    }
    let refused = found.logs.iter().filter(|log| log.verdict == Light::Red).count();
    Err(Failure::Refused { refused, what: "the logs", findings: found.errors })
}

/// The next command: the meaning of the worst finding if nothing moves or the light is red,
/// otherwise the fit of the campaign, or `init` for logs without one.
fn next(a: &typed::Check, found: &Check, is_campaign: bool) -> String {
    let worst = found.errors.iter().chain(found.warnings.iter().filter(|w| w.severity != Severity::Note)).next();
    let files: Vec<String> = a.files.iter().map(|file| file.display().to_string()).collect();
    // if nothing moves, a fit does not help
    let resting: Vec<&Finding> = found.warnings.iter().filter(|w| w.code == AT_REST.code).collect();
    if let Some(at_rest) = resting.first().filter(|_| resting.len() >= found.logs.len()) {
        return format!("hydrosysid explain {}", at_rest.code);
    }
    match worst.filter(|_| found.verdict == Light::Red) {
        Some(worst) => format!("hydrosysid explain {}", worst.code),
        None if is_campaign => format!("hydrosysid fit {}", files.concat()),
        None => format!("hydrosysid init {} -o campaign", files.join(" ")),
    }
}

/// The light as a word.
fn word(light: Option<Light>) -> String {
    light.map_or("-".into(), |light| format!("{light:?}").to_lowercase())
}

fn print_check(found: &Check, output: &Output) {
    let shown = match found.verdict {
        Light::Green => "\x1b[1;32mgreen\x1b[0m",
        Light::Amber => "\x1b[1;33mamber\x1b[0m",
        Light::Red => "\x1b[1;31mred\x1b[0m",
    };
    output.print(&format!("{shown}: {}", verdict(found)));
    let row =
        |log: &CheckedLog| vec![log.file.clone(), word(Some(log.verdict)), number(log.duration), wrong(log, found)];
    let rows: Vec<Vec<String>> = found.logs.iter().map(row).collect();
    if !rows.is_empty() {
        output.print(&table(&["log", "light", "s", "what is wrong"], &rows));
    }
    if output.is_verbose() {
        print_topics(found, output);
        print_rates(found, output);
    }
}

/// The number of logs with each light, and its meaning for a fit.
fn verdict(found: &Check) -> String {
    let of = |light: Light| found.logs.iter().filter(|log| log.verdict == light).count();
    let logs = count(found.logs.len(), "log");
    if found.logs.is_empty() && found.verdict != Light::Red {
        return "no run of a moving vehicle to check: bench runs are judged by `fit`".into();
    }
    match (of(Light::Red), of(Light::Amber), found.verdict) {
        (0, 0, Light::Green) => format!("nothing in {logs} argues against a fit"),
        (0, 0, Light::Amber) => {
            format!("nothing in {logs} by itself argues against a fit, but the campaign needs attention")
        }
        (0, 0, Light::Red) => "the campaign cannot be used as it is".into(),
        (0, amber, _) => {
            part(amber, "needs attention", "need attention", found.logs.len()) + " before a fit can be trusted"
        }
        (red, _, _) if found.errors.is_empty() => {
            part(red, "is faulty; correct it before a fit", "are faulty; correct them before a fit", found.logs.len())
        }
        (red, ..) => part(
            red,
            "cannot be used as it is; correct it before a fit",
            "cannot be used as they are; correct them before a fit",
            found.logs.len(),
        ),
    }
}

/// `2 of 6 logs need attention`, `1 of 6 logs needs …`, `the log needs …`.
fn part(some: usize, of_one: &str, of_many: &str, all: usize) -> String {
    match (some, all) {
        (1, 1) => format!("the log {of_one}"),
        (1, _) => format!("1 of {} {of_one}", count(all, "log")),
        _ => format!("{some} of {} {of_many}", count(all, "log")),
    }
}

/// Kinds of the findings of a log, errors first; if there are none, the topics whose light is not
/// green.
fn wrong(log: &CheckedLog, found: &Check) -> String {
    let of_log = |f: &&Finding| f.run.as_ref().or(f.file.as_ref()) == Some(&log.file) && f.severity != Severity::Note;
    let mut kinds: Vec<(&str, usize)> = Vec::new();
    for finding in found.errors.iter().chain(&found.warnings).filter(of_log) {
        match kinds.iter_mut().find(|(kind, _)| *kind == finding.kind) {
            Some((_, times)) => *times += 1,
            None => kinds.push((finding.kind, 1)),
        }
    }
    let told = |(kind, times): &(&str, usize)| match times {
        1 => kind.replace('-', " "),
        n => format!("{} ({n})", kind.replace('-', " ")),
    };
    if !kinds.is_empty() {
        return kinds.iter().map(told).collect::<Vec<_>>().join(", ");
    }
    let dim = log.lights.iter().filter(|l| l.light.is_some_and(|light| light != Light::Green));
    dim.map(|l| format!("{:?}", l.topic).to_lowercase()).collect::<Vec<_>>().join(", ")
}

/// A light for each topic of each log.
fn print_topics(found: &Check, output: &Output) {
    let topics = Topic::ALL.map(|topic| format!("{topic:?}").to_lowercase());
    let mut heads = vec!["log", "rows", "stretches"];
    heads.extend(topics.iter().map(String::as_str));
    let row = |log: &CheckedLog| {
        let of = |topic: Topic| log.lights.iter().find(|l| l.topic == topic).and_then(|l| l.light);
        let mut row = vec![log.file.clone(), log.rows.to_string(), log.segments.to_string()];
        row.extend(Topic::ALL.map(|topic| word(of(topic))));
        row
    };
    output.print(&table(&heads, &found.logs.iter().map(row).collect::<Vec<_>>()));
}

/// Prints the rates of the sensors, and pairs of channels that can be compared.
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

/// One row per group of channels of a log with the same rate.
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

/// The comparisons within a log: sensors with sensors, motion with commands.
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

#[cfg(test)]
mod tests {
    use super::part;

    #[test]
    fn one_log_of_several_is_one() {
        let told = |some, all| part(some, "asks", "ask", all);
        assert_eq!([told(1, 1), told(1, 6), told(3, 6)], ["the log asks", "1 of 6 logs asks", "3 of 6 logs ask"]);
    }
}
