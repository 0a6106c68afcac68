//! The refits of `fit --bootstrap` and `fit --monte-carlo`.

use serde::Serialize;

use super::arguments as typed;
use super::failure::Failure;
use super::output::Output;
use super::table::{measured, number, table};
use crate::campaign::{self, Campaign, Estimator, Fit, Resampler, Resampling};
use crate::progress::{Watch, watched};

/// A fit with its refits, for JSON.
#[derive(Serialize)]
pub(super) struct Scattered<'a> {
    #[serde(flatten)]
    pub fit: &'a Fit,
    pub resampling: &'a Resampling,
}

/// The requested refits, printed as a table.
pub(super) fn refits(
    a: &typed::Fit,
    loaded: &Campaign,
    estimator: Estimator,
    output: &Output,
) -> Result<Option<Resampling>, Failure> {
    let (method, draws) = match (a.bootstrap, a.monte_carlo) {
        (Some(draws), _) => (Resampler::Bootstrap, draws),
        (None, Some(draws)) => (Resampler::MonteCarlo, draws),
        (None, None) => return Ok(None),
    };
    let bar = output.counted("refitting", draws);
    let shown = bar.clone();
    let watch = Watch::new(move |step| shown.set_position(step.done as u64));
    let found = watched(&watch, || campaign::resample(loaded, estimator, method, draws))??;
    bar.finish_and_clear();
    let rows: Vec<Vec<String>> = found
        .parameters
        .iter()
        .map(|p| {
            vec![
                p.term.clone(),
                p.name.clone(),
                p.run.clone().unwrap_or_default(),
                measured(p.value, Some(p.std)),
                number(p.mean - p.value),
                format!("{} to {}", number(p.interval[0]), number(p.interval[1])),
                p.unit.clone(),
            ]
        })
        .collect();
    output.print(&table(&["term", "symbol", "run", "value ± std of draws", "bias", "95 % of draws", "unit"], &rows));
    let what = if method == Resampler::Bootstrap { "block bootstrap" } else { "Monte Carlo" };
    output.print(&format!("{what}: {} refits, {} without a solution, seed {}", found.draws, found.failed, found.seed));
    Ok(Some(found))
}
