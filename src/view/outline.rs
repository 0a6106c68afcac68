//! Outline of the campaign, as the page shows it, and the progress of the work.

use serde::Serialize;

use super::answer::{Answer, Refusal};
use super::effects::{self, Family};
use super::task::Progress;
use super::workspace::Workspace;
use crate::campaign::file::{CampaignFile, RunTable};
use crate::campaign::{known_vehicles, run_names};
use crate::frame::Dof;
use crate::run::{Role, RunKind};

/// Content of the campaign file, as far as the page shows it.
#[derive(Serialize)]
struct Outline {
    format: u32,
    file: String,
    /// Whether the file exists.
    exists: bool,
    stamp: String,
    can_undo: bool,
    /// Why the file cannot be used.
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<Refusal>,
    text: String,
    /// Vehicles that come with the program, for a campaign that does not exist yet.
    vehicles: Vec<String>,
    #[serde(flatten)]
    said: Said,
}

/// Content of a usable file.
#[derive(Default, Serialize)]
struct Said {
    vehicle: String,
    mass: Option<f64>,
    dofs: Vec<Dof>,
    estimator: Option<&'static str>,
    logs: Vec<Log>,
    effects: Vec<Family>,
}

/// A log, or the logs of one dive, with its used stretches.
#[derive(Serialize)]
struct Log {
    file: String,
    files: Vec<String>,
    stretches: Vec<Stretch>,
}

/// A `[[run]]` table.
#[derive(Serialize)]
struct Stretch {
    /// Its place in the file.
    run: usize,
    /// Its name in results.
    name: String,
    role: Role,
    kind: RunKind,
    from: Option<f64>,
    to: Option<f64>,
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    condition: Option<String>,
}

/// Names of the logs of a run.
fn files(run: &RunTable) -> Vec<String> {
    run.files.iter().map(|log| log.file.clone()).collect()
}

/// The runs of the log `file`, by their place in the campaign.
pub(super) fn runs_of<'a>(campaign: &'a CampaignFile, file: &str) -> Result<Vec<(usize, &'a RunTable)>, Refusal> {
    let of = |run: &RunTable| run.files.first().is_some_and(|log| log.file == file);
    let found: Vec<(usize, &RunTable)> = campaign.runs.iter().enumerate().filter(|(_, run)| of(run)).collect();
    match found.is_empty() {
        true => Err(Refusal::absent(format!("the campaign has no log {file:?}"))),
        false => Ok(found),
    }
}

impl Said {
    fn of(file: &CampaignFile) -> Said {
        let mut logs: Vec<Log> = Vec::new();
        for ((index, run), name) in file.runs.iter().enumerate().zip(run_names(&file.runs)) {
            let files = files(run);
            let stretch = Stretch {
                run: index,
                name,
                role: run.role,
                kind: run.kind,
                from: run.from,
                to: run.to,
                condition: run.condition.clone(),
            };
            match logs.iter_mut().find(|log| log.files == files) {
                Some(log) => log.stretches.push(stretch),
                None => {
                    logs.push(Log {
                        file: files.first().cloned().unwrap_or_default(),
                        files,
                        stretches: vec![stretch],
                    });
                }
            }
        }
        Said {
            vehicle: file.vehicle.name.clone(),
            mass: file.vehicle.mass,
            dofs: file.model.dofs.clone(),
            estimator: file.fit.estimator.map(|e| e.name()),
            logs,
            effects: effects::families(file),
        }
    }
}

/// The outline of the campaign.
pub(super) fn outline(workspace: &Workspace) -> Result<Answer, Refusal> {
    let exists = workspace.file.is_file();
    let read = if exists { Some(workspace.campaign_file()) } else { None };
    let (said, problem) = match read {
        None => (Said::default(), None),
        Some(Ok(file)) => (Said::of(&file), None),
        Some(Err(refusal)) => (Said::default(), Some(refusal)),
    };
    Ok(Answer::json(&Outline {
        format: 1,
        file: workspace.file.display().to_string(),
        exists,
        stamp: workspace.stamp()?,
        can_undo: workspace.can_undo(),
        problem,
        text: workspace.text()?,
        vehicles: known_vehicles().into_iter().map(|known| known.id).collect(),
        said,
    }))
}

/// Progress of the work, and the stamp that tells whether the page shows the current campaign.
#[derive(Serialize)]
struct AllProgress {
    stamp: String,
    fit: Progress,
    discovery: Progress,
    report: Progress,
}

/// Progress of the work.
pub(super) fn progress(workspace: &Workspace) -> Result<Answer, Refusal> {
    Ok(Answer::json(&AllProgress {
        stamp: workspace.stamp()?,
        fit: workspace.fit.progress(),
        discovery: workspace.discovery.progress(),
        report: workspace.report.progress(),
    }))
}
