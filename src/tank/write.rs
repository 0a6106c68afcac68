//! A campaign of the tank as a folder: `campaign.toml`, one CSV per run, and the true values in
//! `truth.json`.

use std::io::Write;
use std::path::Path;

use serde::Serialize;
use serde_json::{Value, json};
use thiserror::Error;

use super::{Blind, derived};
use crate::atomic_file;
use crate::effects::Coriolis;
use crate::frame::Dof;
use crate::log::{WriteError, write};
use crate::model::{Interpolation, Model};
use crate::run::{Role, Run, RunKind};
use crate::vehicle::{Vehicle, Water};

/// Error while a campaign is written.
#[derive(Debug, Error)]
pub enum FolderError {
    /// A file or the folder cannot be made.
    #[error("{file}: {source}")]
    File {
        /// Its name.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A log cannot be written.
    #[error(transparent)]
    Log(#[from] WriteError),
    /// A number does not fit TOML.
    #[error("campaign.toml: {0}")]
    Toml(#[from] toml::ser::Error),
}

/// The campaign file, as far as the tank fills it.
#[derive(Debug, Clone, Serialize)]
pub(super) struct CampaignTables {
    pub(super) format: u32,
    pub(super) vehicle: Vehicle,
    pub(super) water: Water,
    pub(super) model: ModelTables,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) efficiency: Option<EfficiencyTables>,
    pub(super) log: LogTables,
    #[serde(rename = "parameter", skip_serializing_if = "Vec::is_empty")]
    pub(super) parameters: Vec<HeldParameter>,
    #[serde(rename = "run")]
    pub(super) runs: Vec<RunTables>,
}

#[derive(Debug, Clone, Serialize)]
pub(super) struct ModelTables {
    pub(super) dofs: Vec<Dof>,
    pub(super) effects: Vec<String>,
    pub(super) coriolis: Coriolis,
    pub(super) input: Interpolation,
}

#[derive(Debug, Clone, Serialize)]
pub(super) struct EfficiencyTables {
    pub(super) eta_adv: AdvanceTables,
}

#[derive(Debug, Clone, Serialize)]
pub(super) struct AdvanceTables {
    pub(super) slope: f64,
    pub(super) intercept: f64,
    pub(super) valid: [f64; 2],
}

#[derive(Debug, Clone, Serialize)]
pub(super) struct LogTables {
    /// `no_sample` if sensors have different rates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) missing: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) position_source: Option<&'static str>,
    pub(super) velocity_reference: &'static str,
}

#[derive(Debug, Clone, Serialize)]
pub(super) struct HeldParameter {
    pub(super) effect: String,
    pub(super) value: f64,
    pub(super) fixed: bool,
}

#[derive(Debug, Clone, Serialize)]
pub(super) struct RunTables {
    file: String,
    kind: RunKind,
    role: Role,
}

impl RunTables {
    pub(super) fn of(runs: &[Run]) -> Vec<RunTables> {
        runs.iter().map(|run| RunTables { file: run.name.clone(), kind: run.kind, role: run.role }).collect()
    }
}

/// The true values of a model: effect, symbol, value, unit, and the values in each run if they
/// differ.
pub(super) fn values(model: &Model) -> Value {
    let value = |p: &crate::model::Parameter| {
        let mut entry = json!({
            "effect": p.term,
            "name": p.spec.name,
            "value": p.value,
            "unit": p.spec.dimension.to_string(),
        });
        if !p.per_run.is_empty() {
            entry["per_run"] = json!(p.per_run);
        }
        entry
    };
    model.parameters.iter().map(value).collect()
}

/// Writes the folder; existing files are replaced.
pub(super) fn write_folder(
    folder: &Path,
    tables: &CampaignTables,
    runs: &[Run],
    truth: &Value,
) -> Result<(), FolderError> {
    let failed = |path: &Path| {
        let file = path.display().to_string();
        move |source| FolderError::File { file, source }
    };
    std::fs::create_dir_all(folder).map_err(failed(folder))?;
    let text = |name: &str, text: String| {
        let path = folder.join(name);
        atomic_file::write(&path, |file| file.write_all(text.as_bytes())).map_err(failed(&path))
    };
    text("campaign.toml", toml::to_string(tables)?)?;
    text("truth.json", format!("{truth:#}\n"))?;
    for run in runs {
        let mut logged = run.clone();
        logged.signals.retain(|name, _| !derived(name));
        write(&logged, folder.join(&run.name))?;
    }
    Ok(())
}

impl Blind {
    /// Writes the campaign to a folder, with the hidden effects and the true values in
    /// `truth.json`; existing files are replaced.
    ///
    /// # Errors
    /// [`FolderError`] if the folder or a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), FolderError> {
        let tables = CampaignTables {
            format: 1,
            vehicle: self.vehicle.clone(),
            water: Water::default(),
            model: ModelTables {
                dofs: self.dofs.clone(),
                effects: self.baseline.clone(),
                coriolis: Coriolis::Tied,
                input: self.truth.input,
            },
            efficiency: None,
            log: LogTables { missing: None, position_source: Some("independent"), velocity_reference: "ground" },
            parameters: Vec::new(),
            runs: RunTables::of(&self.runs),
        };
        let truth = json!({ "hidden": self.hidden, "parameters": values(&self.truth) });
        write_folder(folder, &tables, &self.runs, &truth)
    }
}

/// Makes a blind campaign and writes it to a folder.
///
/// # Errors
/// [`WriteBlindError`]: the errors of [`super::blind()`] and [`Blind::write`].
pub fn write_blind(folder: &Path, options: &super::BlindOptions) -> Result<Blind, WriteBlindError> {
    let campaign = super::blind(options)?;
    campaign.write(folder)?;
    Ok(campaign)
}

/// Error while a blind campaign is made and written.
#[derive(Debug, Error)]
pub enum WriteBlindError {
    /// It could not be made.
    #[error(transparent)]
    Tank(#[from] super::TankError),
    /// It could not be written.
    #[error(transparent)]
    Folder(#[from] FolderError),
}

#[cfg(test)]
mod tests {
    use super::super::{BlindOptions, Hidden};
    use super::*;
    use crate::log::{LogOptions, read};

    #[test]
    fn what_is_written_is_read_back() {
        let folder = std::env::temp_dir().join(format!("hydrosysid_tank_{}", std::process::id()));
        let hidden = vec![Hidden::new("coriolis_yaw", 1.0), Hidden::new("wave@sway", 0.5)];
        let options = BlindOptions { duration: 5.0, hidden, ..BlindOptions::default() };
        let campaign = write_blind(&folder, &options).unwrap();
        let table: toml::Table = std::fs::read_to_string(folder.join("campaign.toml")).unwrap().parse().unwrap();
        assert_eq!(table["run"].as_array().unwrap().len(), 9);
        assert!(!table["model"]["effects"].as_array().unwrap().iter().any(|e| e.as_str() == Some("coriolis_yaw")));
        assert_eq!(table["vehicle"].clone().try_into::<Vehicle>().unwrap(), campaign.vehicle);
        let truth: Value = serde_json::from_slice(&std::fs::read(folder.join("truth.json")).unwrap()).unwrap();
        assert_eq!(truth["hidden"], json!(["coriolis_yaw", "wave@sway"]));
        for run in &campaign.runs {
            let back = read(folder.join(&run.name), &LogOptions::default(), &["t", "u", "tau_u"]).unwrap();
            for (name, signal) in run.signals.iter().filter(|(name, _)| !derived(name)) {
                assert_eq!(back.signals.get(name), Some(signal), "{name} of {}", run.name);
            }
            assert!(back.signals.keys().all(|name| !derived(name)));
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
