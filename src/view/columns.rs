//! The columns of a log: the channel of each, and the light that the check gives it.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::answer::{Answer, Refusal};
use super::edit::columns::{self as edit, Place};
use super::outline::runs_of;
use super::workspace::Workspace;
use crate::campaign::file::{CampaignFile, RunTable};
use crate::campaign::{first_rows, run_names};
use crate::check::{Light, TopicLight};
use crate::finding::{Finding, Severity};
use crate::frame::Dof;
use crate::log::LogOptions;
use crate::log::columns::{quantity, split_header};
use crate::log::options::ColumnSource;

/// Number of values shown of each column.
const SAMPLES: usize = 3;

#[derive(Serialize)]
struct Columns {
    log: String,
    verdict: Option<Light>,
    lights: Vec<TopicLight>,
    files: Vec<File>,
    /// Names that a column can be given.
    channels: Vec<Channel>,
    /// Findings about the log that belong to none of its columns.
    findings: Vec<Finding>,
}

#[derive(Serialize)]
struct File {
    file: String,
    /// Place of its options: `[log]`, or a table of its own.
    options: &'static str,
    columns: Vec<Column>,
}

#[derive(Serialize)]
struct Column {
    header: String,
    samples: Vec<String>,
    channel: String,
    /// Whether the channel is a known quantity.
    known: bool,
    unit: String,
    sign: i8,
    light: Light,
    findings: Vec<Finding>,
}

#[derive(Serialize)]
struct Channel {
    name: String,
    units: Vec<&'static str>,
}

/// The options with which a log of a run is read, and their place.
fn options<'a>(campaign: &'a CampaignFile, index: usize, run: &'a RunTable, file: usize) -> (&'a LogOptions, Place) {
    match (&run.files[file].log, &run.log) {
        (Some(own), _) => (own, Place::File(index, file)),
        (None, Some(own)) => (own, Place::Run(index)),
        (None, None) => (&campaign.log, Place::Campaign),
    }
}

/// The channel of a header, with its entry in the options.
fn channel_of<'a>(header: &'a str, options: &'a LogOptions) -> (&'a str, Option<&'a ColumnSource>) {
    let base = split_header(header).0;
    let said = options.columns.iter().find(|(_, source)| is_of(source, header));
    said.map_or((base, None), |(channel, source)| (channel.as_str(), Some(source)))
}

fn is_of(source: &ColumnSource, header: &str) -> bool {
    source.name.trim() == header || source.name.trim() == split_header(header).0
}

/// The columns of a log.
pub(super) fn columns(workspace: &Workspace, log: &str) -> Result<Answer, Refusal> {
    let campaign = workspace.campaign_file()?;
    let runs = runs_of(&campaign, log)?;
    let check = workspace.check()?;
    let all = run_names(&campaign.runs);
    let names: BTreeSet<&str> = runs.iter().map(|(index, _)| all[*index].as_str()).collect();
    let told = check.errors.iter().chain(&check.warnings);
    let own: Vec<&Finding> = told.filter(|f| f.run.as_deref().is_some_and(|run| names.contains(run))).collect();
    let (index, run) = runs[0];
    let mut files = Vec::new();
    for (k, file) in run.files.iter().enumerate() {
        let (options, place) = options(&campaign, index, run, k);
        let rows = first_rows(&campaign.path_of(file), options)
            .map_err(|e| Refusal::unusable(format!("{} cannot be read: {e}", file.file)))?;
        let column = |(at, header): (usize, &String)| {
            let samples = rows.rows.iter().take(SAMPLES).filter_map(|row| row.get(at).cloned()).collect();
            column(header, samples, options, &own)
        };
        let options = if place == Place::Campaign { "[log]" } else { "a separate table" };
        let columns = rows.headers.iter().enumerate().filter(|(_, h)| !h.is_empty()).map(column).collect();
        files.push(File { file: file.file.clone(), options, columns });
    }
    let shown = |f: &&Finding| files.iter().flat_map(|file| &file.columns).any(|column| column.findings.contains(f));
    let findings: Vec<Finding> = own.into_iter().filter(|f| !shown(f)).cloned().collect();
    let checked: Vec<_> = check.logs.iter().filter(|log| names.contains(log.file.as_str())).collect();
    let channels = channels(&files);
    Ok(Answer::json(&Columns {
        log: log.to_string(),
        verdict: checked.iter().map(|log| log.verdict).max(),
        lights: checked.first().map(|log| log.lights.clone()).unwrap_or_default(),
        files,
        channels,
        findings,
    }))
}

fn column(header: &str, samples: Vec<String>, options: &LogOptions, told: &[&Finding]) -> Column {
    let (channel, source) = channel_of(header, options);
    let measured = quantity(channel);
    let unit = source.and_then(|s| s.unit.clone()).or_else(|| split_header(header).1.map(str::to_string));
    let usual = measured.and_then(|q| q.units().first()).map_or("", |unit| unit.name);
    let named =
        |f: &Finding| f.column.as_deref().is_some_and(|c| [channel, header, split_header(header).0].contains(&c));
    let findings: Vec<Finding> = told.iter().filter(|f| named(f)).map(|f| (*f).clone()).collect();
    let light = match findings.iter().map(|f| f.severity).max() {
        Some(Severity::Error) => Light::Red,
        Some(Severity::Warning) => Light::Amber,
        _ => Light::Green,
    };
    let plain = unit.as_deref().and_then(|unit| measured?.unit(unit)).map(|unit| unit.name.to_string());
    Column {
        header: header.to_string(),
        samples,
        channel: channel.to_string(),
        known: measured.is_some(),
        unit: plain.or(unit).unwrap_or_else(|| usual.to_string()),
        sign: source.map_or(1, |s| s.sign),
        light,
        findings,
    }
}

/// Names to choose from: the known channels, and as many thrusters as there are columns, at most
/// 12.
fn channels(files: &[File]) -> Vec<Channel> {
    let mut names: Vec<String> = vec!["t".into()];
    for list in [Dof::velocity, Dof::position, Dof::force] {
        names.extend(Dof::ALL.map(list).map(str::to_string));
    }
    let most = files.iter().map(|f| f.columns.len()).max().unwrap_or(0).min(12);
    names.extend((1..=most).map(|k| format!("V{k}")));
    names.extend((1..=most).map(|k| format!("F{k}")));
    names.extend(Dof::ALL.map(Dof::load).map(str::to_string));
    names.extend(["force", "supply_V", "rudder", "stern_plane", "propeller_n"].map(str::to_string));
    let units = |name: &str| quantity(name).map_or_else(Vec::new, |q| q.units().iter().map(|unit| unit.name).collect());
    names.into_iter().map(|name| Channel { units: units(&name), name }).collect()
}

/// The new assignment of a column.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Mapping {
    log: String,
    /// Index of the log, if the run has several.
    #[serde(default)]
    file: usize,
    header: String,
    /// Its channel; empty to keep the column's own name.
    channel: String,
    #[serde(default)]
    unit: Option<String>,
    #[serde(default)]
    flipped: bool,
}

/// Assigns a column, for every run of its log.
pub(super) fn set(workspace: &Workspace, mapping: &Mapping) -> Result<(), Refusal> {
    let campaign = workspace.campaign_file()?;
    let runs = runs_of(&campaign, &mapping.log)?;
    let (index, run) = runs[0];
    if mapping.file >= run.files.len() {
        return Err(Refusal::absent("the run has no such log"));
    }
    let (now, place) = options(&campaign, index, run, mapping.file);
    let mut columns = now.columns.clone();
    let before = columns.iter().find(|(_, source)| is_of(source, &mapping.header));
    let (scale, frame) = before.map_or((1.0, None), |(_, source)| (source.scale, source.frame));
    columns.retain(|_, source| !is_of(source, &mapping.header));
    let (base, own_unit) = split_header(&mapping.header);
    let channel = mapping.channel.trim();
    let usual = quantity(channel).and_then(|q| q.units().first()).map(|unit| unit.name);
    let unit = mapping.unit.clone().filter(|unit| !unit.is_empty() && Some(unit.as_str()) != own_unit.or(usual));
    let usual_way = frame.is_none() && unit.is_none() && !mapping.flipped;
    if channel == base && usual_way && scale.to_bits() == 1.0_f64.to_bits() {
        columns.remove(channel);
    } else if !channel.is_empty() && channel != base || !usual_way {
        let name = if channel.is_empty() { base } else { channel };
        let sign = if mapping.flipped { -1 } else { 1 };
        columns.insert(name.to_string(), ColumnSource { name: mapping.header.clone(), unit, scale, sign, frame });
    }
    let places: Vec<Place> = match place {
        Place::Campaign if shared(&campaign, &mapping.header) => vec![Place::Campaign],
        Place::File(..) => runs.iter().map(|(index, _)| Place::File(*index, mapping.file)).collect(),
        _ => runs.iter().map(|(index, _)| Place::Run(*index)).collect(),
    };
    workspace.edit(|text| places.iter().try_fold(text.to_string(), |text, place| edit::set(&text, *place, &columns)))
}

/// Whether every log that is read with the campaign's own options has this column.
fn shared(campaign: &CampaignFile, header: &str) -> bool {
    let plain = campaign.runs.iter().filter(|run| run.log.is_none());
    let mut logs = plain.flat_map(|run| run.files.iter().filter(|file| file.log.is_none()));
    logs.all(|log| {
        let rows = first_rows(&campaign.path_of(log), &campaign.log);
        rows.is_ok_and(|rows| rows.headers.iter().any(|h| h == header))
    })
}
