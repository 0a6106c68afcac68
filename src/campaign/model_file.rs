//! A fitted model as a file: values with their uncertainty, their source and the range in which
//! they hold.
//!
//! TOML, or JSON if the name ends in `.json`. It is written by `fit` and read back by `simulate`
//! and `compare`.

mod check;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::baseline;
use super::codes;
use super::error::Error;
use super::file::{
    CampaignFile, EffectRole, EffectTable, Estimator, ModelTable, ObserveTable, ParameterTable, is_default,
};
use super::fit::Fit;
use super::load::Campaign;
use super::model_noise::ModelNoise;
use super::reading::{Reading, readings};
use crate::effects::EffectName;
use crate::envelope::Envelope;
use crate::finding::Finding;
use crate::log::LogOptions;
use crate::model::Model;
use crate::plan::Instruments;
use crate::run::Run;
use crate::text_file;
use crate::thrust::efficiency::Efficiency;
use crate::thrust::thruster::Thruster;
use crate::units::Dimension;
use crate::vehicle::{Vehicle, Water};

/// Format that this version reads and writes.
pub const FORMAT: u32 = 1;

/// A model with its provenance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelFile {
    /// Format of the file: 1.
    pub format: u32,
    /// Version of the program that wrote it.
    pub hydrosysid: String,
    /// Campaign that it comes from.
    pub campaign: String,
    /// Estimator of the fit.
    pub estimator: Estimator,
    /// Method of the standard deviations.
    pub std_method: String,
    /// Whether the fit converged; if not, the values mean nothing.
    #[serde(default = "yes", skip_serializing_if = "is_yes")]
    pub converged: bool,
    /// Properties of the dry vehicle.
    pub vehicle: Vehicle,
    /// The water.
    pub water: Water,
    /// Degrees of freedom, terms, and interpolation of the inputs between samples.
    pub model: ModelTable,
    /// Reading options of the logs of the fit, if one set served for all: new logs are read with
    /// it.
    #[serde(default, skip_serializing_if = "is_default")]
    pub log: LogOptions,
    /// Reading options of the logs of the fit, if there are several sets.
    #[serde(default, rename = "reading", skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<Reading>,
    /// The vehicle's thrusters, with the curves that the fit used.
    #[serde(default, rename = "thruster", skip_serializing_if = "Vec::is_empty")]
    pub thrusters: Vec<Thruster>,
    /// Losses of thrust for which the values hold.
    #[serde(default)]
    pub efficiency: Efficiency,
    /// Speeds, angles, forces and amplitudes of the runs of the fit, SI: beyond them the model extrapolates.
    #[serde(default)]
    pub envelope: Envelope,
    /// Noise and rate of the channels of the runs of the fit: the sensors that a plan assumes.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sensors: Instruments,
    /// Random force and sensor noise that the fit has estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<ModelNoise>,
    /// The user's own effects among the terms.
    #[serde(default, rename = "effect", skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectTable>,
    /// The observed functions of the states that it predicts.
    #[serde(default, rename = "observe", skip_serializing_if = "Vec::is_empty")]
    pub observed: Vec<ObserveTable>,
    /// Parameters that are tied to another one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tied: Vec<ParameterTable>,
    /// The parameters.
    #[serde(rename = "parameter")]
    pub parameters: Vec<ModelParameter>,
    /// Covariance in the order of the parameters, SI.
    pub covariance: Vec<Vec<f64>>,
}

/// One parameter of a model file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelParameter {
    /// Term that reads it: `quadratic_drag@surge`.
    pub effect: String,
    /// Symbol.
    pub name: String,
    /// Value, SI.
    pub value: f64,
    /// Standard deviation, SI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std: Option<f64>,
    /// Unit.
    pub unit: Dimension,
    /// Whether it was held fixed.
    #[serde(default)]
    pub fixed: bool,
    /// Values of a parameter that has its own in each run, by the name of the run.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub per_run: BTreeMap<String, f64>,
}

/// The reason why a model file cannot be used.
#[derive(Debug, Error)]
pub enum ModelFileError {
    /// The file cannot be read.
    #[error("{}: {}", .file.display(), super::file::io_text(*.kind))]
    CannotRead {
        /// The file.
        file: PathBuf,
        /// The cause.
        kind: std::io::ErrorKind,
    },
    /// The file is no model file.
    #[error("{}: {message}", .file.display())]
    Syntax {
        /// The file.
        file: PathBuf,
        /// Message of the parser, with line and column.
        message: String,
    },
    /// A campaign file where a model file is wanted.
    #[error(
        "{}: this is a campaign file, not a model file: fit the campaign first (`hydrosysid fit {0} --model \
         model.toml`)",
        .file.display()
    )]
    Campaign {
        /// The file.
        file: PathBuf,
    },
    /// A value that no fit writes.
    #[error("{}{}: {key}: {message}", .file.display(), place.map(|(line, column)| format!(":{line}:{column}")).unwrap_or_default())]
    Value {
        /// The file.
        file: PathBuf,
        /// Line and column, from 1; `None` in JSON.
        place: Option<(usize, usize)>,
        /// The key.
        key: String,
        /// What is wrong with it.
        message: String,
    },
    /// A format that this version does not know.
    #[error("{}: format {found} is not known: this version reads format 1", .file.display())]
    Format {
        /// The file.
        file: PathBuf,
        /// The format found.
        found: u32,
    },
    /// The terms make no model.
    #[error("{}: {source}", .file.display())]
    Model {
        /// The file.
        file: PathBuf,
        /// The cause.
        source: Box<Error>,
    },
    /// A parameter that none of the terms has, or one that is missing.
    #[error(
        "{}: `{effect}` has the parameter `{name}` in this file or in this version, but not in both",
        .file.display()
    )]
    Parameter {
        /// The file.
        file: PathBuf,
        /// The term.
        effect: String,
        /// The symbol.
        name: String,
    },
}

impl ModelFile {
    /// Returns the model file of a fit.
    pub fn of(campaign: &Campaign, fit: &Fit) -> ModelFile {
        let model = &fit.model;
        let effects: Vec<EffectName> = model.terms.iter().filter_map(|t| t.name().parse().ok()).collect();
        let own = campaign.file.effects.iter();
        let own: Vec<EffectTable> = own
            .filter(|e| effects.iter().any(|name| name.id == e.id))
            .map(|e| EffectTable { role: EffectRole::Baseline, ..e.clone() })
            .collect();
        let parameters = model.parameters.iter().zip(&fit.parameters).map(|(p, told)| ModelParameter {
            effect: p.term.clone(),
            name: p.spec.name.clone(),
            value: p.value,
            std: told.std,
            unit: p.spec.dimension,
            fixed: p.fixed,
            per_run: told.per_run.clone(),
        });
        ModelFile {
            format: FORMAT,
            hydrosysid: env!("CARGO_PKG_VERSION").into(),
            campaign: campaign.file.source.as_ref().map_or_else(String::new, |s| s.file.display().to_string()),
            estimator: fit.estimator,
            std_method: fit.std_method.clone(),
            converged: fit.converged,
            vehicle: campaign.vehicle.clone(),
            water: campaign.water,
            model: ModelTable {
                dofs: model.dofs.clone(),
                effects,
                coriolis: model.coriolis,
                input: model.input,
                undriven: campaign.file.model.undriven.clone(),
            },
            log: campaign.file.common_log().cloned().unwrap_or_default(),
            readings: if campaign.file.common_log().is_some() { Vec::new() } else { readings(&campaign.file) },
            thrusters: campaign.file.thrusters.clone(),
            efficiency: fit.efficiency.clone(),
            envelope: fit.envelope.clone(),
            sensors: fit.instruments.clone(),
            noise: fit.model_noise(),
            effects: own,
            observed: campaign.file.observed.clone(),
            tied: campaign.file.parameters.iter().filter(|p| p.tie.is_some()).cloned().collect(),
            parameters: parameters.collect(),
            covariance: fit.covariance.clone(),
        }
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// [`ModelFileError`].
    pub fn read(path: &Path) -> Result<ModelFile, ModelFileError> {
        let path = ModelFile::at(path);
        let text =
            text_file::read(&path).map_err(|e| ModelFileError::CannotRead { file: path.clone(), kind: e.kind() })?;
        ModelFile::from_text(&text, &path)
    }

    /// Returns the model file that a path stands for: for a folder, the `model.toml` in it.
    pub fn at(path: &Path) -> PathBuf {
        if path.is_dir() { path.join("model.toml") } else { path.to_path_buf() }
    }

    /// Reads the text of a model file as if it were that of `path`.
    ///
    /// # Errors
    /// [`ModelFileError`].
    pub fn from_text(text: &str, path: &Path) -> Result<ModelFile, ModelFileError> {
        let file = path.to_path_buf();
        let syntax = |message: String| ModelFileError::Syntax { file: file.clone(), message };
        // a campaign has runs, a model states which version wrote it
        let campaign = |table: toml::Table| table.contains_key("run") && !table.contains_key("hydrosysid");
        let model: ModelFile = match is_json(path) {
            true => serde_json::from_str(text).map_err(|e| syntax(e.to_string()))?,
            false if text.parse().is_ok_and(campaign) => return Err(ModelFileError::Campaign { file }),
            false => toml::from_str(text).map_err(|e| syntax(e.to_string()))?,
        };
        if model.format != FORMAT {
            return Err(ModelFileError::Format { file, found: model.format });
        }
        check::check(&model, text, path)?;
        Ok(model)
    }

    /// Returns the text of the file of this name: JSON if it ends in `.json`, otherwise TOML.
    ///
    /// # Errors
    /// None for a fitted model; otherwise the message of the writer.
    pub fn to_text(&self, path: &Path) -> Result<String, ModelFileError> {
        let syntax = |message: String| ModelFileError::Syntax { file: path.to_path_buf(), message };
        match is_json(path) {
            true => serde_json::to_string_pretty(self).map_err(|e| syntax(e.to_string())),
            false => toml::to_string(self).map_err(|e| syntax(e.to_string())),
        }
    }

    /// Returns the finding that the fit did not converge, which every verb reports first. `name` is
    /// that of the file.
    pub fn unsettled(&self, name: &str) -> Option<Finding> {
        let text = format!(
            "{name}: do not use these numbers, the fit that wrote this model did not converge: run `hydrosysid check` \
             on the campaign, and fit it again"
        );
        (!self.converged).then(|| Finding::new(&codes::MODEL_UNSETTLED, text))
    }

    /// Returns the model for the runs of a campaign, whose logs state what the velocities are
    /// relative to.
    ///
    /// # Errors
    /// As [`ModelFile::model`].
    pub fn model_for(&self, campaign: &Campaign, path: &Path) -> Result<Model, ModelFileError> {
        let mut model = self.model(&campaign.runs, path)?;
        model.through_water = campaign.model.through_water;
        Ok(model)
    }

    /// Returns the model for these runs; messages name `path`.
    ///
    /// # Errors
    /// [`ModelFileError`] if this version defines a term otherwise.
    pub fn model(&self, runs: &[Run], path: &Path) -> Result<Model, ModelFileError> {
        let file = path.to_path_buf();
        let campaign = CampaignFile {
            vehicle: self.vehicle.clone(),
            water: self.water,
            model: self.model.clone(),
            thrusters: self.thrusters.clone(),
            efficiency: self.efficiency.clone(),
            effects: self.effects.clone(),
            observed: self.observed.clone(),
            parameters: self.tied.clone(),
            ..CampaignFile::default()
        };
        let (mut model, _) = baseline::build(&campaign)
            .map_err(|e| ModelFileError::Model { file: file.clone(), source: Box::new(e) })?;
        let mut ways = self.readings.iter().map(|reading| &reading.log).chain([&self.log]);
        model.through_water = ways.any(LogOptions::is_through_water);
        let mut known = 0;
        for told in &self.parameters {
            let absent = || ModelFileError::Parameter {
                file: file.clone(),
                effect: told.effect.clone(),
                name: told.name.clone(),
            };
            let parameter = &mut model
                .parameters
                .iter_mut()
                .find(|p| p.term == told.effect && p.spec.name == told.name)
                .ok_or_else(absent)?;
            known += 1;
            parameter.value = told.value;
            parameter.std = told.std;
            parameter.fixed = told.fixed;
            if !told.per_run.is_empty() {
                parameter.per_run =
                    runs.iter().map(|run| told.per_run.get(&run.name).copied().unwrap_or(told.value)).collect();
            }
        }
        if known < model.parameters.len() {
            let told = |p: &&crate::model::Parameter| {
                !self.parameters.iter().any(|t| t.effect == p.term && t.name == p.spec.name)
            };
            if let Some(p) = model.parameters.iter().find(told) {
                return Err(ModelFileError::Parameter { file, effect: p.term.clone(), name: p.spec.name.clone() });
            }
        }
        Ok(model)
    }
}

impl Campaign {
    /// Returns the campaign under a model file of this name: with its losses of thrust, its noise
    /// and, before all others, the finding that its fit did not converge.
    #[must_use]
    pub fn under_model(&self, file: &ModelFile, name: &str) -> Campaign {
        let mut campaign = self.under(&file.efficiency).with_noise(file.noise.clone());
        campaign.findings.splice(..0, file.unsettled(name));
        campaign
    }
}

const fn yes() -> bool {
    true
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde gives a reference
const fn is_yes(value: &bool) -> bool {
    *value
}

fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"))
}
