//! The input of a plan.

use std::path::Path;

use super::codes;
use super::fit::Fit;
use super::load::Campaign;
use super::model_file::{ModelFile, ModelFileError};
use super::model_noise::ModelNoise;
use crate::envelope::Envelope;
use crate::estimate::filter_error::RandomForce;
use crate::estimate::output_error::OutputErrorOptions;
use crate::finding::Finding;
use crate::model::Model;
use crate::plan::Instruments;
use crate::thrust::thruster::Thruster;
use crate::vehicle::Vehicle;

/// The input of a plan: a model, and what is known about its vehicle and sensors.
#[derive(Debug, Clone)]
pub struct PlanSource {
    pub(super) model: Model,
    pub(super) vehicle: Vehicle,
    pub(super) envelope: Envelope,
    pub(super) sensors: Instruments,
    pub(super) thrusters: Vec<Thruster>,
    pub(super) covariance: Vec<Vec<f64>>,
    /// Random force on the vehicle, if a filter has estimated it.
    pub(super) forces: Option<Vec<RandomForce>>,
    pub(super) fitting: OutputErrorOptions,
    /// Warnings about the model, to stand before all others.
    pub(super) warnings: Vec<Finding>,
}

impl PlanSource {
    /// Returns the input from a model file; messages name `path`.
    ///
    /// # Errors
    /// [`ModelFileError`] if this version defines a term otherwise.
    pub fn of_file(file: &ModelFile, path: &Path) -> Result<PlanSource, ModelFileError> {
        Ok(PlanSource {
            model: file.model(&[], path)?,
            vehicle: file.vehicle.clone(),
            envelope: file.envelope.clone(),
            sensors: file.sensors.clone(),
            thrusters: file.thrusters.clone(),
            covariance: file.covariance.clone(),
            forces: file.noise.as_ref().map(ModelNoise::forces),
            fitting: OutputErrorOptions { join: true, ..OutputErrorOptions::default() },
            warnings: file.unsettled(&path.display().to_string()).into_iter().collect(),
        })
    }

    /// Returns the input from a campaign and its fit.
    pub fn of_fit(campaign: &Campaign, fit: &Fit) -> PlanSource {
        PlanSource {
            model: fit.model.clone(),
            vehicle: campaign.vehicle.clone(),
            envelope: fit.envelope.clone(),
            sensors: fit.instruments.clone(),
            thrusters: campaign.file.thrusters.clone(),
            covariance: fit.covariance.clone(),
            forces: fit.model_noise().as_ref().map(ModelNoise::forces),
            fitting: OutputErrorOptions { join: campaign.file.fit.join, ..campaign.options.output_error.clone() },
            warnings: fit.warnings.iter().filter(|f| f.code == codes::NOT_CONVERGED.code).cloned().collect(),
        }
    }
}
