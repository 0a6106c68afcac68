//! The verb `fit` with `--bootstrap` or `--monte-carlo`: how far estimates scatter, shown rather than computed.
//!
//! The bootstrap draws stretches of the training runs with replacement; Monte Carlo fits data that the fitted model made.
//! See [`OutputErrorFit`] for what each asks.

use serde::{Deserialize, Serialize};

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::error::Error;
use super::file::Estimator;
use super::fit::again;
use super::load::{Campaign, moves};
use crate::estimate::output_error::{OutputErrorError, OutputErrorFit, OutputErrorOptions, output_error};
use crate::estimate::{Draws, started};
use crate::least_squares::REFITTING;
use crate::noise::Noise;
use crate::progress::tell;
use crate::run::{Role, Run};

/// How refits get their data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Resampler {
    /// Stretches of the training runs, drawn with replacement.
    Bootstrap,
    /// The fitted model's own motion with fresh noise.
    MonteCarlo,
}

/// Refits of a campaign. Serialises as `resampling` in `hydrosysid fit --json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Resampling {
    /// Format of the result: 1.
    pub format: u32,
    /// Where the data came from.
    pub method: Resampler,
    /// Refits that took part.
    pub draws: usize,
    /// Refits without a solution, left out.
    pub failed: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Scatter of each free parameter, in the order of the model.
    pub parameters: Vec<Scatter>,
}

/// How far the refits of one parameter scatter, SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scatter {
    /// Name of its term: `id`, `id@dof`, `id@dof:other`.
    pub term: String,
    /// Symbol.
    pub name: String,
    /// The run whose value it is; absent for a common one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run: Option<String>,
    /// Estimate that the draws start from.
    pub value: f64,
    /// Mean of the draws: what it is off `value` is bias.
    pub mean: f64,
    /// Standard deviation of the draws.
    pub std: f64,
    /// 2.5 and 97.5 per cent of the draws lie below.
    pub interval: [f64; 2],
    /// Unit.
    pub unit: String,
}

/// Refits the campaign's model by the estimator of a fit, `draws` times, on all cores. Integral least squares is refitted
/// on stretches alone; the staged procedure has too few rows a stage to draw from.
///
/// # Errors
/// [`Error`] when there is no run of free motion to fit, the data does not determine the parameters, or a bootstrap has
/// too few stretches to draw from; [`Error::Asked`] for what an estimator cannot be asked.
pub fn resample(
    campaign: &Campaign,
    estimator: Estimator,
    method: Resampler,
    draws: usize,
) -> Result<Resampling, Error> {
    match (estimator, method) {
        (Estimator::OutputError, _) => by_output_error(campaign, method, draws),
        (Estimator::Integral, Resampler::Bootstrap) => by_rows(campaign, draws),
        (Estimator::Integral, Resampler::MonteCarlo) => Err(Error::Asked(
            "--monte-carlo simulates the fitted model, which integral least squares does not: take --bootstrap, or \
             --estimator output_error"
                .into(),
        )),
        (Estimator::Staged, _) => Err(Error::Asked(
            "the staged procedure has a handful of rows in some of its stages, too few to draw from: its deviations are \
             those of the delta method; take --estimator integral or output_error for refits"
                .into(),
        )),
    }
}

/// Integral least squares on stretches of the runs drawn with replacement: as long as the clusters of output error, so
/// that they are independent of each other, and as many as there are.
fn by_rows(campaign: &Campaign, draws: usize) -> Result<Resampling, Error> {
    let runs = campaign.motion(Some(Role::Train));
    let (fitted, seed) = (again(campaign, Estimator::Integral, runs.clone(), 1)?, campaign.options.seed);
    if let Some(p) = fitted.parameters.iter().find(|p| p.spec.per_run && !p.fixed) {
        let text = format!("{} of `{}` has a value in each run, and a draw has no runs", p.spec.name, p.term);
        return Err(Error::Asked(text));
    }
    let mut stretches: Vec<Run> = Vec::new();
    for run in &runs {
        let Some((from, to)) = run.span() else { continue };
        let parts = ((to - from) / campaign.options.output_error.cluster).round().max(1.0);
        let border = |k: f64| from + (to - from) * k / parts;
        stretches.extend((0..parts as usize).map(|k| run.between(border(k as f64), border(k as f64 + 1.0))));
    }
    if stretches.len() < 2 {
        return Err(OutputErrorError::TooFewClusters { clusters: stretches.len() }.into());
    }
    let found: Vec<usize> = (0..fitted.parameters.len())
        .filter(|p| !fitted.parameters[*p].fixed && fitted.parameters[*p].std.is_some())
        .collect();
    let done = AtomicUsize::new(0);
    let refit = |draw: u64| -> Option<Vec<f64>> {
        let mut noise = Noise::new(seed, draw);
        let drawn = (0..stretches.len()).map(|_| stretches[noise.below(stretches.len())].clone()).collect();
        let model = again(campaign, Estimator::Integral, drawn, 1).ok();
        tell(REFITTING, done.fetch_add(1, Ordering::Relaxed) + 1, draws);
        model.map(|model| found.iter().map(|p| model.parameters[*p].value).collect())
    };
    let values: Vec<Vec<f64>> = (0..draws as u64).into_par_iter().filter_map(refit).collect();
    let all = Draws { failed: draws - values.len(), values };
    let scatter = |(k, p): (usize, &usize)| {
        let parameter = &fitted.parameters[*p];
        Scatter {
            term: parameter.term.clone(),
            name: parameter.spec.name.clone(),
            run: None,
            value: parameter.value,
            mean: all.mean(k),
            std: all.std(k),
            interval: [0.025, 0.975].map(|level| all.quantile(k, level)),
            unit: parameter.spec.dimension.to_string(),
        }
    };
    Ok(Resampling {
        format: 1,
        method: Resampler::Bootstrap,
        draws: all.values.len(),
        failed: all.failed,
        seed,
        parameters: found.iter().enumerate().map(scatter).collect(),
    })
}

fn by_output_error(campaign: &Campaign, method: Resampler, draws: usize) -> Result<Resampling, Error> {
    let used = |run: &&Run| run.role == Role::Train && moves(run.kind);
    let runs: Vec<Run> = campaign.runs.iter().filter(used).cloned().collect();
    // whole runs are too few to draw from
    let join = campaign.file.fit.join && method == Resampler::MonteCarlo;
    let options = OutputErrorOptions { join, ..campaign.options.output_error.clone() };
    let fit = output_error(&started(&campaign.model, &runs), &runs, &options)?;
    let seed = campaign.options.seed;
    let found = match method {
        Resampler::Bootstrap => fit.bootstrap(draws, seed, options.cluster)?,
        Resampler::MonteCarlo => fit.monte_carlo(&options, draws, seed),
    };
    Ok(described(&fit, &found, method, seed, &runs))
}

fn described(fit: &OutputErrorFit, found: &Draws, method: Resampler, seed: u64, runs: &[Run]) -> Resampling {
    let scatter = |(k, unknown): (usize, &crate::estimate::output_error::Unknown)| {
        let parameter = &fit.model.parameters[unknown.parameter];
        let own = unknown.run.and_then(|run| parameter.per_run.get(run));
        Scatter {
            term: parameter.term.clone(),
            name: parameter.spec.name.clone(),
            run: unknown.run.map(|run| runs[run].name.clone()),
            value: own.copied().unwrap_or(parameter.value),
            mean: found.mean(k),
            std: found.std(k),
            interval: [0.025, 0.975].map(|level| found.quantile(k, level)),
            unit: parameter.spec.dimension.to_string(),
        }
    };
    Resampling {
        format: 1,
        method,
        draws: found.values.len(),
        failed: found.failed,
        seed,
        parameters: fit.problem.unknowns.iter().enumerate().map(scatter).collect(),
    }
}
