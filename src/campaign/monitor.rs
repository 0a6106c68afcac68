//! The verb `monitor`: a fitted model along new logs.

use std::path::Path;

use serde::Serialize;

use super::error::Error;
use super::file::{CampaignFile, RunFile, RunTable};
use super::load::Campaign;
use super::model_file::ModelFile;
use super::noise::Noise;
use super::prediction::foretold;
use super::reading::{reading_of, readings};
use crate::envelope::{self, Envelope};
use crate::finding::Finding;
use crate::log::LogOptions;
use crate::model::Model;
use crate::monitor::{self, MonitorOptions, Watch};
use crate::run::{Role, RunKind};

/// A model watched along logs. Serialises as `hydrosysid monitor --json`.
#[derive(Debug, Clone, Serialize)]
pub struct Monitored {
    /// Format of the result: 1.
    pub format: u32,
    /// What was found; `warnings` are among it.
    #[serde(flatten)]
    pub watch: Watch,
    /// The noise that the model brings, and how it predicts these logs; absent where it brings none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
}

/// New logs as runs of the vehicle of a model file: one run a log. They are read as `log` says, or else each as those of the
/// fit were, by its name or its columns; thrusters are those of the model file. With `like`, a campaign of the same vehicle,
/// both are that one's, and its noise.
///
/// # Errors
/// [`Error`] when a log cannot be read or lacks what the model reads.
pub fn new_logs(
    file: &ModelFile,
    logs: &[&Path],
    log: Option<&LogOptions>,
    like: Option<&CampaignFile>,
) -> Result<Campaign, Error> {
    let here = std::env::current_dir().unwrap_or_default();
    let ways = like.map_or_else(|| file.readings.clone(), readings);
    let mut told = Vec::new();
    let mut run = |path: &&Path| {
        let way = if log.is_none() { reading_of(path, &ways) } else { None };
        told.extend(way.iter().filter_map(|(_, finding)| finding.clone()));
        RunTable {
            // absolute: the campaign has no folder
            files: vec![RunFile { file: here.join(path).display().to_string(), ..RunFile::default() }],
            kind: RunKind::Free,
            role: Role::Validate,
            log: way.map(|(options, _)| options.clone()),
            ..RunTable::default()
        }
    };
    let runs = logs.iter().map(&mut run).collect();
    let of_model =
        || CampaignFile { thrusters: file.thrusters.clone(), log: file.log.clone(), ..CampaignFile::default() };
    let like = like.cloned().unwrap_or_else(of_model);
    // bollard tables lie where the other campaign does
    let folder = here.join(like.folder());
    let mut thrusters = like.thrusters;
    for table in thrusters.iter_mut().filter_map(|thruster| thruster.bollard.as_mut()) {
        table.file = folder.join(&table.file).display().to_string();
    }
    let campaign = CampaignFile {
        vehicle: file.vehicle.clone(),
        water: file.water,
        model: file.model.clone(),
        effects: file.effects.clone(),
        observed: file.observed.clone(),
        efficiency: file.efficiency.clone(),
        noise: like.noise,
        thrusters,
        log: log.cloned().unwrap_or(like.log),
        fit: like.fit,
        runs,
        ..CampaignFile::default()
    };
    let mut campaign = Campaign::from_file(campaign)?.with_noise(file.noise.clone());
    campaign.findings.splice(..0, told);
    for (run, path) in campaign.runs.iter_mut().zip(logs) {
        run.name = path.display().to_string();
    }
    Ok(campaign)
}

/// Watches `model` along the runs of free motion of a campaign; `envelope` holds the velocities between which it was
/// fitted.
///
/// # Errors
/// [`Error`] when a run lacks what the model reads.
pub fn monitor(
    campaign: &Campaign,
    model: &Model,
    envelope: &Envelope,
    options: &MonitorOptions,
) -> Result<Monitored, Error> {
    let runs = campaign.motion(None);
    let fitting = &campaign.options.output_error;
    let found = match &campaign.noise {
        Some(_) => foretold(campaign, model, &runs)?,
        None => None,
    };
    let known = found.as_ref().zip(campaign.noise.as_ref()).map(|(f, noise)| noise.known(&f.filtered));
    let mut watch = monitor::watch(model, known.as_ref(), &runs, fitting, options)?;
    let told = campaign.findings.iter().filter(|f| f.code != super::codes::NO_VALIDATION.code).cloned();
    let mut warnings: Vec<Finding> = told.collect();
    warnings.append(&mut watch.warnings);
    warnings.extend(runs.iter().flat_map(|run| envelope::beyond(run, envelope)));
    watch.warnings = warnings;
    Ok(Monitored { format: 1, watch, noise: found.map(|f| f.found) })
}
