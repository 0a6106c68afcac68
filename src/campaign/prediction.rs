//! Predictions of runs by a model and its noise: one sample, 2 s and 8 s ahead, and free, each with
//! the error to expect.
//!
//! The noise is the one that belongs to the model. A model without noise, such as one from the
//! literature, gets the noise that explains the runs best with its parameters held.

use super::error::Error;
use super::fit::filter_error::options;
use super::load::Campaign;
use super::model_noise::ModelNoise;
use super::noise::{self, ForceFound, HeldBack, Noise};
use crate::estimate::filter_error::{FilterErrorOptions, Filtered, Forecast, filter_error};
use crate::estimate::output_error::OutputErrorError;
use crate::model::Model;
use crate::progress::tell;
use crate::run::{Run, commanded_rms};

/// Limit in standard deviations beyond which an innovation of known noise is an outlier: it moves
/// the state less, the farther off it is.
pub(super) const LIMIT: f64 = 5.0;

/// Runs with the predictions of a model and its noise.
pub(super) struct Foretold {
    /// The runs.
    pub filtered: Filtered,
    /// The forecasts, one per stretch without a gap.
    pub forecasts: Vec<Forecast>,
    /// Noise and prediction errors for the result.
    pub found: Noise,
}

/// Predicts `runs` by `model` with its parameters held; `None` if the model is so wrong that no
/// filter can follow them.
///
/// # Errors
/// [`Error`] if a run lacks what the model reads.
pub(super) fn foretold(campaign: &Campaign, model: &Model, runs: &[Run]) -> Result<Option<Foretold>, Error> {
    if runs.is_empty() {
        return Ok(None);
    }
    let model = noise::with_parameters_fixed(model);
    let stated = &campaign.file.noise.sensors;
    let base = &campaign.options.output_error;
    let (filtered, noise, limit, force, held_back) = match &campaign.noise {
        Some(known) => {
            let filtered = Filtered::new(&model, runs, base)?;
            let force = told(known, runs, filtered.sample_time());
            let noise = known.of(&filtered).elsewhere(&model, runs);
            (Filtered::begun(&model, runs, (&noise, LIMIT), base)?, noise, LIMIT, force, None)
        }
        None => {
            tell("the noise of the runs", 0, 0);
            let asked = FilterErrorOptions { told: true, ..options(campaign) };
            let fit = match filter_error(&model, runs, &asked) {
                Err(OutputErrorError::Diverges { .. } | OutputErrorError::TooFewSamples { .. }) => return Ok(None),
                fit => fit?,
            };
            let (force, held_back) = (noise::forces(&fit, runs), HeldBack::of(&fit));
            (fit.filtered, fit.noise, fit.limit, force, held_back)
        }
    };
    let forecasts = filtered.forecast(&model, &noise, limit);
    let found = Noise {
        force,
        sensors: noise::sensors(&filtered, &noise, stated, &forecasts),
        innovations_white: noise::white(&forecasts),
        held_back,
        prediction: noise::predicted(&filtered, &forecasts),
    };
    Ok(Some(Foretold { filtered, forecasts, found }))
}

/// Returns the random forces of a model, compared with the thrust of these runs.
fn told(known: &ModelNoise, runs: &[Run], sample_time: f64) -> Vec<ForceFound> {
    let one = |f: &super::model_noise::ModelForce| ForceFound {
        dof: f.dof,
        rms: f.rms,
        std: f.std,
        unit: if f.dof.is_rotation() { "N*m" } else { "N" },
        correlation_time: f.correlation_time,
        correlation_time_std: f.correlation_time_std,
        share_of_thrust: commanded_rms(runs, f.dof).map(|thrust| f.rms / thrust),
        only_intensity: f.correlation_time < sample_time,
    };
    known.force.iter().map(one).collect()
}
