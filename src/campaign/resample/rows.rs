//! Refits by rows: integral least squares and the staged procedure, on blocks of the runs or on
//! generated runs.
//!
//! Blocks are whole runs of one kind that show one degree of freedom, drawn with replacement among
//! themselves, so that no stage loses its data. If there are fewer than three of them, the blocks
//! are stretches with the length of a cluster. A steady or towed run is one row, which cannot be
//! cut. Integral least squares does not distinguish kinds: it always draws stretches.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::super::error::Error;
use super::super::file::Estimator;
use super::super::fit::{Fit, FitOptions, fit, integral_again, thrust};
use super::super::load::{Campaign, with_nominal_forces};
use super::made::Made;
use super::{Refits, Resampler, Resampling, Scatter};
use crate::estimate::Draws;
use crate::estimate::output_error::OutputErrorError;
use crate::frame::Dof;
use crate::least_squares::REFITTING;
use crate::model::Model;
use crate::noise::Noise;
use crate::procedure::{is_powered, shown, staged};
use crate::progress::{look, tell};
use crate::run::{Role, Run, RunKind};

/// Least number of runs or blocks to draw from: fewer whole runs are cut, fewer blocks are refused.
const FEWEST: usize = 3;

/// What the runs of one group have in common: their kind, the degree of freedom that they show, and
/// thrust under tow.
type Key = (RunKind, Option<Dof>, bool);

/// Source of the data of a refit.
enum Source {
    /// Blocks of each kind, drawn among themselves.
    Blocks(Vec<Vec<Run>>),
    /// Logs that the fitted model has generated.
    Made(Made),
}

impl Source {
    fn draw(&self, noise: &mut Noise) -> Vec<Run> {
        match self {
            Source::Made(made) => made.logged(noise),
            Source::Blocks(groups) => groups
                .iter()
                .flat_map(|blocks| {
                    (0..blocks.len()).map(|_| noise.below(blocks.len())).map(|k| blocks[k].clone()).collect::<Vec<_>>()
                })
                .collect(),
        }
    }
}

/// Returns the scatter of the estimates of a fit by rows over these refits.
pub(super) fn by_rows(
    campaign: &Campaign,
    estimator: Estimator,
    method: Resampler,
    refits: Refits,
) -> Result<Resampling, Error> {
    let fitted = fit(campaign, FitOptions { estimator: Some(estimator) })?;
    let model = &fitted.model;
    if let Some(p) = model.parameters.iter().find(|p| p.spec.per_run && !p.fixed) {
        let text = format!("{} of `{}` has a value in each run, but a draw has no runs", p.spec.name, p.term);
        return Err(Error::Asked(text));
    }
    let seed = refits.seed.unwrap_or(campaign.options.seed);
    let source = source(campaign, estimator, method, &fitted)?;
    let found: Vec<usize> = (0..model.parameters.len())
        .filter(|p| !model.parameters[*p].fixed && model.parameters[*p].std.is_some())
        .collect();
    let (done, count) = (AtomicUsize::new(0), refits.numbers.clone().count());
    let refit = |draw: u64| -> Option<Vec<f64>> {
        look();
        let mut noise = Noise::new(seed, draw);
        let runs = source.draw(&mut noise);
        let model = again(campaign, estimator, &runs, &mut noise);
        tell(REFITTING, done.fetch_add(1, Ordering::Relaxed) + 1, count);
        let refitted = model.ok()?.parameters;
        found.iter().map(|p| refitted[*p].std.map(|_| refitted[*p].value)).collect()
    };
    let first = refits.numbers.start;
    let all = Draws::of(refits.numbers, (0..count).into_par_iter().map(|k| refit(first + k as u64)).collect());
    let scatter =
        |(k, p): (usize, &usize)| Scatter::of(&model.parameters[*p], None, model.parameters[*p].value, k, &all);
    Ok(Resampling {
        format: 1,
        method,
        draws: all.values.len(),
        failed: all.failed,
        seed,
        parameters: found.iter().enumerate().map(scatter).collect(),
        numbers: all.numbers,
        samples: all.values,
    })
}

/// Returns the model from drawn runs, with thruster curves drawn from the uncertainty of their
/// tables.
fn again(campaign: &Campaign, estimator: Estimator, runs: &[Run], noise: &mut Noise) -> Result<Model, Error> {
    let curves = thrust::drawn(campaign, noise);
    match estimator {
        Estimator::Staged => {
            let mut stage = campaign.file.stage.clone();
            stage.direct.skip = true;
            let mut efficiency = campaign.file.efficiency.clone();
            for entry in &mut efficiency.eta_inter.0 {
                entry.value += entry.std.unwrap_or(0.0) * noise.normal();
            }
            let runs: Vec<Run> = runs.iter().map(|run| thrust::nominal_under(campaign, run, &curves)).collect();
            let bench = crate::procedure::Bench { efficiency: &efficiency, ..campaign.bench() };
            Ok(staged(&runs, &campaign.model, bench, &stage)?.model)
        }
        _ => {
            let runs: Vec<Run> = runs.iter().map(|run| thrust::under(campaign, run, &curves)).collect();
            integral_again(campaign, &runs)
        }
    }
}

fn source(campaign: &Campaign, estimator: Estimator, method: Resampler, fitted: &Fit) -> Result<Source, Error> {
    let runs: Vec<(usize, Run)> = match estimator {
        Estimator::Staged => with_nominal_forces(campaign.runs.clone())
            .into_iter()
            .enumerate()
            .filter(|(_, run)| run.role == Role::Train)
            .collect(),
        _ => {
            let used = |(_, run): &(usize, &Run)| run.role == Role::Train && super::moves(run.kind);
            campaign.runs.iter().enumerate().filter(used).map(|(k, run)| (k, run.clone())).collect()
        }
    };
    if method == Resampler::MonteCarlo {
        return Ok(Source::Made(Made::of(campaign, fitted, runs)?));
    }
    let length = campaign.options.output_error.cluster;
    let runs: Vec<Run> = runs.into_iter().map(|(_, run)| run).collect();
    if estimator == Estimator::Integral {
        let stretches: Vec<Run> = runs.iter().flat_map(|run| cut(run, length)).collect();
        return match stretches.len() {
            0 | 1 => Err(OutputErrorError::TooFewClusters { clusters: stretches.len() }.into()),
            _ => Ok(Source::Blocks(vec![stretches])),
        };
    }
    let mut groups: Vec<(Key, Vec<Run>)> = Vec::new();
    for run in runs {
        let dof = shown(&run, &campaign.model.dofs);
        let key = (run.kind, dof, run.kind == RunKind::Towing && dof.is_some_and(|dof| is_powered(&run, dof)));
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, group)) => group.push(run),
            None => groups.push((key, vec![run])),
        }
    }
    let blocks = |((kind, dof, _), group): (Key, Vec<Run>)| {
        let whole = group.len() >= FEWEST || matches!(kind, RunKind::ConstantVelocity | RunKind::Towing);
        let blocks: Vec<Run> =
            if whole { group.clone() } else { group.iter().flat_map(|run| cut(run, length)).collect() };
        if blocks.len() >= FEWEST {
            return Ok(blocks);
        }
        let names: Vec<&str> = group.iter().map(|run| run.name.as_str()).collect();
        Err(Error::Asked(format!(
            "a bootstrap resamples runs within each kind, and of {} there {}: {} blocks say nothing of their spread; \
             use --monte-carlo",
            dof.map_or_else(|| "these".to_string(), |dof| format!("those that show {dof} as these do")),
            if names.len() == 1 { format!("is `{}` alone", names[0]) } else { format!("are {}", names.join(", ")) },
            blocks.len()
        )))
    };
    Ok(Source::Blocks(groups.into_iter().map(blocks).collect::<Result<_, _>>()?))
}

/// Cuts a run into stretches of about `length` seconds, long enough to be independent of each
/// other.
fn cut(run: &Run, length: f64) -> Vec<Run> {
    let Some((from, to)) = run.span() else { return Vec::new() };
    let parts = ((to - from) / length).round().max(1.0);
    let border = |k: f64| from + (to - from) * k / parts;
    (0..parts as usize).map(|k| run.between(border(k as f64), border(k as f64 + 1.0))).collect()
}
