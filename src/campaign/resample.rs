//! The verb `fit` with `--bootstrap` or `--monte-carlo`: scatter of the estimates, found by refits.
//!
//! The bootstrap draws stretches of the training runs with replacement, in the staged procedure
//! whole runs of each kind. Monte Carlo fits data that the fitted model has generated, for filter
//! error with its random force. [`OutputErrorFit`](crate::estimate::output_error::OutputErrorFit)
//! and [`FilterErrorFit`](crate::estimate::filter_error::FilterErrorFit) describe what each
//! requires.

mod made;
mod rows;

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::discover;
use super::error::Error;
use super::file::Estimator;
use super::fit::filter_error::options as filter_error_options;
use super::fit::thrust;
use super::load::{Campaign, moves};
use crate::discover::fitted;
use crate::estimate::filter_error::filter_error_from;
use crate::estimate::output_error::{OutputErrorOptions, Unknown, output_error, value};
use crate::estimate::{Draws, started};
use crate::model::{Model, Parameter};
use crate::noise::Noise;
use crate::run::{Role, Run};

/// Source of the data of refits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Resampler {
    /// Stretches of the training runs, drawn with replacement.
    Bootstrap,
    /// Motion of the fitted model with new noise.
    MonteCarlo,
}

/// Selection of the refits. Each has a number and is the same whichever others are made, so that
/// several processes can share them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refits {
    /// Their numbers.
    pub numbers: Range<u64>,
    /// Seed of the draws; that of the campaign if absent.
    pub seed: Option<u64>,
}

impl From<usize> for Refits {
    /// Returns the first `draws` refits, with the seed of the campaign.
    fn from(draws: usize) -> Refits {
        Refits { numbers: 0..draws as u64, seed: None }
    }
}

/// Refits of a campaign. Serialises as `resampling` in `hydrosysid fit --json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Resampling {
    /// Format of the result: 1.
    pub format: u32,
    /// Source of the data.
    pub method: Resampler,
    /// Number of refits that took part.
    pub draws: usize,
    /// Number of refits without a solution, which are left out.
    pub failed: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Scatter of each free parameter, in the order of the model.
    pub parameters: Vec<Scatter>,
    /// Number of each refit that took part.
    #[serde(skip)]
    pub numbers: Vec<u64>,
    /// Estimates of each refit that took part, in the order of `parameters`.
    #[serde(skip)]
    pub samples: Vec<Vec<f64>>,
}

/// Scatter of the refits of one parameter, SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scatter {
    /// Name of its term: `id`, `id@dof`, `id@dof:other`.
    pub term: String,
    /// Symbol.
    pub name: String,
    /// Run to which the value belongs; absent for a common one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run: Option<String>,
    /// Estimate that the draws start from.
    pub value: f64,
    /// Mean of the draws; its difference from `value` is the bias.
    pub mean: f64,
    /// Standard deviation of the draws.
    pub std: f64,
    /// 2.5 % and 97.5 % quantiles of the draws.
    pub interval: [f64; 2],
    /// Unit.
    pub unit: String,
}

impl Scatter {
    /// Returns the scatter of unknown `k` of the draws, a value of this parameter.
    fn of(parameter: &Parameter, run: Option<String>, value: f64, k: usize, draws: &Draws) -> Scatter {
        Scatter {
            term: parameter.term.clone(),
            name: parameter.spec.name.clone(),
            run,
            value,
            mean: draws.mean(k),
            std: draws.std(k),
            interval: [0.025, 0.975].map(|level| draws.quantile(k, level)),
            unit: parameter.spec.dimension.to_string(),
        }
    }
}

/// Refits the campaign's model by the estimator of a fit, on all cores. Each refit draws the
/// thruster curves that come from bollard tables anew, from their uncertainty; the staged procedure
/// also draws a given η_inter that has a standard deviation.
///
/// # Errors
/// [`Error`] if there is no run of free motion to fit, the data does not determine the parameters,
/// or a bootstrap has too few stretches or runs of a kind to draw from; [`Error::Asked`] for a
/// request that the estimator cannot meet.
pub fn resample(
    campaign: &Campaign,
    estimator: Estimator,
    method: Resampler,
    refits: impl Into<Refits>,
) -> Result<Resampling, Error> {
    match estimator {
        Estimator::FilterError => by_filter_error(campaign, method, refits.into()),
        Estimator::OutputError => by_output_error(campaign, method, refits.into()),
        Estimator::Integral | Estimator::Staged => rows::by_rows(campaign, estimator, method, refits.into()),
    }
}

/// First noise stream from which curves are drawn.
const CURVES: u64 = 1 << 32;

/// Returns the training runs of free motion.
fn motions(campaign: &Campaign) -> Vec<Run> {
    campaign.motion(Some(Role::Train))
}

fn by_output_error(campaign: &Campaign, method: Resampler, refits: Refits) -> Result<Resampling, Error> {
    let runs = motions(campaign);
    // whole runs are too few to draw from
    let join = campaign.file.fit.join && method == Resampler::MonteCarlo;
    let options = OutputErrorOptions { join, ..campaign.options.output_error.clone() };
    let fit = output_error(&started(&campaign.model, &runs), &runs, &options)?;
    let seed = refits.seed.unwrap_or(campaign.options.seed);
    let found = match method {
        Resampler::Bootstrap => {
            let found = fit.bootstrap(refits.numbers, seed, options.cluster)?;
            with_curves(campaign, &runs, found, seed, |runs| Ok(fit.response(runs, &options)?))?
        }
        Resampler::MonteCarlo => {
            fit.monte_carlo_under(&options, refits.numbers, seed, |draw| under_curves(campaign, &runs, seed, draw))
        }
    };
    Ok(described((&fit.model, &fit.problem.unknowns), found, method, seed, &runs))
}

fn by_filter_error(campaign: &Campaign, method: Resampler, refits: Refits) -> Result<Resampling, Error> {
    let runs = motions(campaign);
    let options = filter_error_options(campaign);
    let fit = fitted(&campaign.model, &runs, &options, &discover::options(campaign))?;
    let unknowns = &fit.filtered.problem.unknowns;
    let seed = refits.seed.unwrap_or(campaign.options.seed);
    let found = match method {
        Resampler::Bootstrap => {
            let found = fit.bootstrap(refits.numbers, seed, options.base.cluster)?;
            with_curves(campaign, &runs, found, seed, |runs| {
                let moved = filter_error_from(&fit.model, runs, fit.noise.clone(), &fit.nearby(&options))?.model;
                Ok(unknowns.iter().map(|u| value(&moved, *u) - value(&fit.model, *u)).collect())
            })?
        }
        Resampler::MonteCarlo => {
            fit.monte_carlo_under(&options, refits.numbers, seed, |draw| under_curves(campaign, &runs, seed, draw))
        }
    };
    Ok(described((&fit.model, unknowns), found, method, seed, &runs))
}

/// Adds to each draw the change of the estimates by thruster curves drawn for it; `response`
/// returns the change of the estimates for runs with the forces of a moved curve.
fn with_curves(
    campaign: &Campaign,
    runs: &[Run],
    mut found: Draws,
    seed: u64,
    response: impl Fn(&[Run]) -> Result<Vec<f64>, Error>,
) -> Result<Draws, Error> {
    let slopes = thrust::slopes(campaign, runs, response)?;
    for (draw, values) in found.numbers.iter().zip(&mut found.values) {
        let mut noise = Noise::new(seed, CURVES + draw);
        for slopes in &slopes {
            values.iter_mut().zip(slopes.drawn(&mut noise)).for_each(|(value, by)| *value += by);
        }
    }
    Ok(found)
}

/// Returns the runs with the forces of curves drawn for this refit; `None` if no curve was
/// measured.
fn under_curves(campaign: &Campaign, runs: &[Run], seed: u64, draw: u64) -> Option<Vec<Run>> {
    let curves = thrust::drawn(campaign, &mut Noise::new(seed, CURVES + draw));
    (!curves.is_empty()).then(|| runs.iter().map(|run| thrust::under(campaign, run, &curves)).collect())
}

fn described(
    (model, unknowns): (&Model, &[Unknown]),
    found: Draws,
    method: Resampler,
    seed: u64,
    runs: &[Run],
) -> Resampling {
    let scatter = |(k, unknown): (usize, &Unknown)| {
        let parameter = &model.parameters[unknown.parameter];
        let own = unknown.run.and_then(|run| parameter.per_run.get(run));
        let name = unknown.run.map(|run| runs[run].name.clone());
        Scatter::of(parameter, name, own.copied().unwrap_or(parameter.value), k, &found)
    };
    Resampling {
        format: 1,
        method,
        draws: found.values.len(),
        failed: found.failed,
        seed,
        parameters: unknowns.iter().enumerate().map(scatter).collect(),
        numbers: found.numbers,
        samples: found.values,
    }
}
