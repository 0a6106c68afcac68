//! The verb `monitor`: comparison of a fitted model with new logs.

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

/// Monitoring of logs by a model. Serialises as `hydrosysid monitor --json`.
#[derive(Debug, Clone, Serialize)]
pub struct Monitored {
    /// Format of the result: 1.
    pub format: u32,
    /// Result of the monitoring, `warnings` included.
    #[serde(flatten)]
    pub watch: Watch,
    /// Noise of the model, and the accuracy with which it predicts these logs; absent if it has
    /// none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
}

/// Returns a campaign of new logs of the vehicle of a model file, with one run per log. The logs
/// are read with the options `log`; without it, each is read like the log of the fit that has its
/// name or its columns. The thrusters are those of the model file. With `like`, a campaign of the
/// same vehicle, the reading options (without `log`), the thrusters, the stated noise and the
/// options of the fit are those of `like`.
///
/// # Errors
/// [`Error`] if a log cannot be read or lacks what the model reads.
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
    // bollard tables are relative to the folder of the other campaign
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

/// Monitors `model` along the runs of free motion of a campaign; `envelope` is that of its fit.
///
/// # Errors
/// [`Error`] if a run lacks what the model reads.
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
