//! The thorough part of a fit by rows: whether halves of the runs and longer windows give the same
//! estimates.

use std::collections::BTreeMap;

use statrs::distribution::{ContinuousCDF, Normal};

use super::codes;
use super::error::Error;
use super::file::Estimator;
use super::fit::{Fit, again};
use super::identifiability::{OtherWindow, halves_differ};
use super::load::{Campaign, moves};
use crate::finding::Finding;
use crate::model::Model;
use crate::run::{Role, Run, RunKind};

/// Lengths of the windows that are tried, in units of those of the fit.
const WINDOWS: [usize; 2] = [2, 4];

/// Adds halves and windows to the identifiability and the warnings of `fit`. Only runs whose motion
/// changes all the time are halved: a steady run is steady in one half only.
pub(super) fn examine(campaign: &Campaign, fit: &mut Fit) -> Result<(), Error> {
    let Some(mut found) = fit.identifiability.take() else { return Ok(()) };
    let estimator = fit.estimator;
    let train = |run: &&Run| run.role == Role::Train && (moves(run.kind) || estimator == Estimator::Staged);
    let runs: Vec<Run> = campaign.runs.iter().filter(train).cloned().collect();
    let refit = |runs: Vec<Run>, times: usize| again(campaign, estimator, runs, times);
    let halves: Option<[Model; 2]> = match (refit(half(&runs, 0), 1), refit(half(&runs, 1), 1)) {
        (Ok(first), Ok(second)) => Some([first, second]),
        // a half does not determine all parameters
        _ => None,
    };
    let limit = Normal::standard().inverse_cdf(1.0 - 0.01 / (2.0 * found.parameters.len().max(1) as f64));
    for one in &mut found.parameters {
        let Some(p) = fit.model.parameters.iter().position(|p| p.term == one.term && p.spec.name == one.name) else {
            continue;
        };
        let Some([first, second]) = halves.as_ref().map(|h| [0, 1].map(|k| &h[k].parameters[p])) else { continue };
        let deviation = first.std.unwrap_or(0.0).hypot(second.std.unwrap_or(0.0));
        // a parameter that is equal in both halves comes from runs that are not halved
        if deviation > 0.0 && (first.value - second.value).abs() > 0.0 {
            let z = (first.value - second.value) / deviation;
            (one.first_half, one.second_half, one.halves_z) = (Some(first.value), Some(second.value), Some(z));
            if z.abs() > limit {
                fit.warnings.push(halves_differ(&fit.model, p, [first.value, second.value], z));
            }
        }
    }
    for times in WINDOWS {
        let Ok(other) = refit(runs.clone(), times) else { continue };
        let mut change = BTreeMap::new();
        for one in &found.parameters {
            let at = |m: &Model| m.parameters.iter().position(|p| p.term == one.term && p.spec.name == one.name);
            let (Some(p), Some(q)) = (at(&fit.model), at(&other)) else { continue };
            let (now, then) = (&fit.model.parameters[p], &other.parameters[q]);
            let std = now.std.unwrap_or(0.0).max(then.std.unwrap_or(0.0));
            let ratio = if std > 0.0 { (then.value - now.value) / std } else { 0.0 };
            let name = fit.model.parameters[p].full_name();
            if ratio.abs() > 3.0 {
                let text = format!(
                    "{name}: with windows {times} times as long it is {:.4e} instead of {:.4e}, {:.1} standard errors \
                     away: noise of the velocities in the regressors, or something slow that the model lacks",
                    then.value,
                    now.value,
                    ratio.abs()
                );
                fit.warnings.push(Finding::new(&codes::WINDOW, text));
            }
            change.insert(name, ratio);
        }
        found.windows.push(OtherWindow { times, change });
    }
    fit.identifiability = Some(found);
    Ok(())
}

/// Returns the first or the second half of each run that moves all the time, and all other runs
/// whole.
fn half(runs: &[Run], which: usize) -> Vec<Run> {
    let cut = |run: &Run| match (run.kind, run.span()) {
        (RunKind::Oscillatory | RunKind::Zigzag | RunKind::Free, Some((from, to))) => {
            let middle = 0.5 * (from + to);
            let part = if which == 0 { run.between(from, middle) } else { run.between(middle, to) };
            Run { name: run.name.clone(), ..part }
        }
        _ => run.clone(),
    };
    runs.iter().map(cut).collect()
}
