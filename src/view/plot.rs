//! A log over time, with its used stretches.

use std::collections::BTreeMap;

use serde::Serialize;

use super::answer::{Answer, Refusal};
use super::outline::runs_of;
use super::workspace::Workspace;
use crate::campaign::Error;
use crate::campaign::file::CampaignFile;
use crate::frame::Dof;
use crate::log;
use crate::report::{Axis, Chart, Curves, Figure, Label, Panel, Series, Span, figure};
use crate::run::{Role, Signal};

#[derive(Serialize)]
struct Plot {
    figure: String,
    channel: String,
    below: String,
    channels: Vec<String>,
    from: f64,
    to: f64,
    /// Roles of the stretches that are shaded, in their order.
    roles: Vec<Role>,
}

/// The channels of a log, with a common clock.
fn signals(campaign: &CampaignFile, index: usize) -> Result<BTreeMap<String, Signal>, Refusal> {
    let run = &campaign.runs[index];
    let mut all = BTreeMap::new();
    for file in &run.files {
        let options = file.log.as_ref().or(run.log.as_ref()).unwrap_or(&campaign.log);
        let read = log::read(campaign.path_of(file), options, &["t"])
            .map_err(|source| Error::Log { run: file.file.clone(), source })?;
        for (name, signal) in read.signals {
            let time: Vec<f64> = signal.time().iter().map(|t| t + file.clock_offset).collect();
            all.insert(name, Signal::new(time.into(), signal.values().to_vec()));
        }
    }
    Ok(all)
}

/// The default channels: the first velocity or position that changes, and the first command that
/// changes.
fn usual(campaign: &CampaignFile, signals: &BTreeMap<String, Signal>) -> [String; 2] {
    let dofs = campaign.model.dofs.iter().copied().chain(Dof::ALL);
    let told = |name: &str| -> bool {
        signals.get(name).is_some_and(|s| s.values().windows(2).any(|w| w[0].to_bits() != w[1].to_bits()))
    };
    let first_told = |names: Vec<&str>| names.into_iter().find(|name| told(name)).map(str::to_string);
    let motion = first_told(dofs.clone().map(Dof::velocity).chain(dofs.clone().map(Dof::position)).collect());
    let numbered = signals.keys().map(String::as_str).filter(|name| name.starts_with(['V', 'F']));
    let mut commands: Vec<&str> = dofs.map(Dof::force).collect();
    commands.extend(numbered);
    let command = first_told(commands);
    let first = signals.keys().next().cloned().unwrap_or_default();
    [motion.unwrap_or(first), command.unwrap_or_default()]
}

fn panel(name: &str, signals: &BTreeMap<String, Signal>) -> Option<Panel> {
    let signal = signals.get(name)?;
    let unit = match log::columns::quantity(name) {
        // a pulse width is not converted
        Some(log::columns::Quantity::Command) | None => "",
        Some(measured) => measured.units().first().map_or("", |unit| unit.name),
    };
    let series = Series::line("", signal.time().to_vec(), signal.values().to_vec());
    Some(Panel { y: Axis::new(Label::symbol(name), unit), series: vec![series], floor: None })
}

/// The plot of a log.
pub(super) fn plot(workspace: &Workspace, log: &str, channel: &str, below: &str) -> Result<Answer, Refusal> {
    let campaign = workspace.campaign_file()?;
    let runs = runs_of(&campaign, log)?;
    let signals = signals(&campaign, runs[0].0)?;
    let ends = signals.values().filter_map(|s| Some((*s.time().first()?, *s.time().last()?)));
    let (from, to) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (c, d)| (a.min(c), b.max(d)));
    if from > to {
        return Err(Refusal::unusable(format!("{log} has no channel that could be plotted")));
    }
    let known = |name: &str| signals.contains_key(name);
    let [motion, command] = usual(&campaign, &signals);
    let channel = if known(channel) { channel.to_string() } else { motion };
    // no channel below ("-") is a choice too
    let below = if below == "-" || known(below) { below.to_string() } else { command };
    let panels: Vec<Panel> = [&channel, &below].into_iter().filter_map(|name| panel(name, &signals)).collect();
    let span = |(_, run): &(usize, &crate::campaign::file::RunTable)| Span {
        from: run.from.unwrap_or(from).max(from),
        to: run.to.unwrap_or(to).min(to),
        label: String::new(),
    };
    let chart = Curves { x: Axis::new("time", "s"), panels, spans: runs.iter().map(span).collect() };
    let shown = Figure { title: log.to_string(), caption: String::new(), chart: Chart::Curves(chart) };
    Ok(Answer::json(&Plot {
        figure: figure(&shown, "log"),
        channel,
        below,
        channels: signals.keys().cloned().collect(),
        from,
        to,
        roles: runs.iter().map(|(_, run)| run.role).collect(),
    }))
}
