//! Step 4: held-out runs must agree.
//!
//! ```text
//! Δ = −2 ln L(held out; θ̂, η̂) without the name less that with it       a name is confirmed where Δ > 1
//! d = E²_with − E²_without, 8 s ahead, of those that share no time    and no E is worse: d̄ √n / s_d ≤ t of n − 1, Pr(t) = 0.01/channels
//! ```
//!
//! The test uses the noise of the fit. If a name fails it, the test uses a noise that is estimated on the held-out
//! runs for each model: another day has other gusts, and a model with half of the missing effects has the narrow
//! noise of the runs it could follow, under which it would look worse than a model that follows none.
//!
//! Held-out runs that do not show an effect at all (an asymmetry of the drag, and none goes astern) neither confirm
//! nor refuse it, and the answer says so.
//!
//! If no run has the role `validate`, each run is predicted with the parameters that the others give
//! ([`FilterErrorFit::left_out_cost`]). A parameter with its own value in every run (the phase of a wave) is
//! estimated on the first half of a run and judged on the second:
//!
//! ```text
//! −2 ln L(second half | first half) = −2 ln L(run; θ of the first half) + 2 ln L(first half; θ of the first half)
//! Δ > −2 ln 0.025 = 7.4        under the noise of the fit, or one that is estimated on the first halves
//! ```
//!
//! No other run can confirm such a name, and a slow random force begins every run like a wave: the second halves
//! alone must confirm it. The likelihood ratio of data that took no part in either fit has the mean 1 if the name is
//! wrong, so exp(Δ/2) exceeds 1/0.025 at most five times in two hundred, under each of the two noises (Wasserman,
//! Ramdas and Balakrishnan 2020, *Universal inference*).

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::candidate::Candidate;
use super::refit::beside;
use super::task::{ROUGH, Task};
use crate::estimate::filter_error::{
    FilterErrorFit, FilterErrorOptions, Filtered, Forecast, NoiseModel, cost_of, filter_error_from, first_halves,
};
use crate::estimate::output_error::OutputErrorError;
use crate::model::Model;
use crate::run::Run;

/// Horizon at which predictions are compared, s.
const AHEAD: f64 = 8.0;

/// Maximum probability that a wrong name is confirmed by second halves alone.
const BY_HALVES: f64 = 0.05;

/// Relative growth of the error up to which it counts as unchanged.
const SAME: f64 = 0.05;

/// Maximum probability that a name which predicts as well as before seems to predict some channel worse.
const WORSE: f64 = 0.01;

/// Fall of −2 ln L on held-out runs below which they do not show a name: chance gives as much, and confirms nothing.
const UNSEEN: f64 = 1.0;

/// Objection to a name that held-out runs do not show.
pub(super) const NOT_SHOWN: &str = "no held-out run shows it: hold out one that does";

/// Result of the test of a name on held-out runs.
#[derive(Debug, Clone)]
pub(super) struct HeldOut {
    /// Fall of −2 ln L on them; infinite if the model without the name diverges there.
    pub gain: f64,
    /// Their −2 ln L with the name.
    pub cost: f64,
    /// Objection, if they do not agree.
    pub against: Option<String>,
}

/// −2 ln L of held-out runs; with `halved`, of their second halves, per-run values being estimated on the first.
/// Infinite if the model diverges there.
fn others_cost(
    fit: &FilterErrorFit,
    runs: &[Run],
    halved: bool,
    fitting: &FilterErrorOptions,
) -> Result<f64, OutputErrorError> {
    let model = match fit.on_others(runs, fitting) {
        Err(OutputErrorError::Diverges { .. }) => return Ok(f64::INFINITY),
        model => model?,
    };
    let noise = fit.noise.elsewhere(&model, runs);
    match halved {
        true => second_halves(&model, runs, (&noise, fit.limit), fitting),
        false => cost_of(&model, runs, (&noise, fit.limit), fitting),
    }
}

/// −2 ln L of the second halves of runs, given the first ones.
fn second_halves(
    model: &Model,
    runs: &[Run],
    under: (&NoiseModel, f64),
    fitting: &FilterErrorOptions,
) -> Result<f64, OutputErrorError> {
    Ok(cost_of(model, runs, under, fitting)? - cost_of(model, &first_halves(runs), under, fitting)?)
}

/// Whether held-out runs show a candidate: removing it, with all other parameters kept, changes their −2 ln L.
fn is_shown(candidate: &Candidate, with: &FilterErrorFit, task: &Task<'_>) -> Result<bool, OutputErrorError> {
    let model = with.on_others(task.held, task.fitting)?;
    let noise = with.noise.elsewhere(&model, task.held);
    let cost = |model: &Model| cost_of(model, task.held, (&noise, with.limit), task.fitting);
    Ok((cost(&candidate.taken_out_of(&model))? - cost(&model)?).abs() >= UNSEEN)
}

/// Tests whether `with`, which contains `candidate`, predicts the held-out runs better than `without`.
pub(super) fn agree(
    candidate: &Candidate,
    without: &FilterErrorFit,
    with: &FilterErrorFit,
    task: &Task<'_>,
) -> Result<HeldOut, OutputErrorError> {
    let (before, cost) = costs(without, with, task)?;
    let mut gain = before - cost;
    // a name may pass under either of two noises, so each gets half of the probability
    let least = if own_values(with) > own_values(without) { -2.0 * (0.5 * BY_HALVES).ln() } else { UNSEEN };
    if gain.is_nan() || gain <= least {
        gain = fall_under_own_noise(without, with, task).unwrap_or(gain);
    }
    if gain.is_nan() || gain <= least {
        let against = if task.held.is_empty() {
            "in cross-validation it predicts the run left out no better than the model without it"
        } else if is_shown(candidate, with, task).unwrap_or(true) {
            "it predicts the held-out runs no better than by chance"
        } else {
            NOT_SHOWN
        };
        return Ok(HeldOut { gain, cost, against: Some(against.to_string()) });
    }
    let against = match task.held {
        [] => None,
        runs => worse(without, with, (runs, task.fitting))?,
    };
    let told = |channel| format!("it predicts the held-out runs worse {AHEAD} s ahead, in `{channel}`");
    Ok(HeldOut { gain, cost, against: against.map(told) })
}

/// Fall of −2 ln L of the held-out runs, with the noise of each model estimated on them; a lower bound if the fit
/// without the name is given up because it cannot come near any more. If runs are judged by halves, the noise is
/// estimated on the first ones. `None` if no run is held out, or if a fit of the noise fails.
fn fall_under_own_noise(without: &FilterErrorFit, with: &FilterErrorFit, task: &Task<'_>) -> Option<f64> {
    if judged_by_halves(without, with) {
        let cost = |fit: &FilterErrorFit| second_halves_under_own_noise(fit, without, task);
        return Some(cost(without)? - cost(with)?);
    }
    if task.held.is_empty() {
        return None;
    }
    let own_noise = |fit: &FilterErrorFit, bar: f64| -> Result<FilterErrorFit, OutputErrorError> {
        let model = fit.on_others(task.held, task.fitting)?;
        let options = FilterErrorOptions { tolerance: ROUGH, bar, ..beside(without, task) };
        filter_error_from(&model, task.held, fit.noise.elsewhere(&model, task.held), &options)
    };
    let with = own_noise(with, f64::INFINITY).ok()?;
    match own_noise(without, with.cost + UNSEEN) {
        Ok(without) => Some(without.cost - with.cost),
        Err(OutputErrorError::GivenUp { cost, .. }) => Some(cost - with.cost),
        Err(_) => None,
    }
}

/// [`second_halves`] under a noise that is estimated on the first halves.
fn second_halves_under_own_noise(fit: &FilterErrorFit, without: &FilterErrorFit, task: &Task<'_>) -> Option<f64> {
    let runs = others(task);
    let model = fit.on_others(runs, task.fitting).ok()?;
    let (first, options) = (first_halves(runs), FilterErrorOptions { tolerance: ROUGH, ..beside(without, task) });
    let noise = filter_error_from(&model, &first, fit.noise.elsewhere(&model, &first), &options).ok()?.noise;
    second_halves(&model, runs, (&noise, fit.limit), task.fitting).ok()
}

/// The held-out runs; if there are none, the runs of the fit, which are then judged by halves.
fn others<'a>(task: &Task<'a>) -> &'a [Run] {
    if task.held.is_empty() { task.train } else { task.held }
}

/// Whether runs are judged by halves: a per-run value is estimated on the first one.
fn judged_by_halves(one: &FilterErrorFit, other: &FilterErrorFit) -> bool {
    [one, other].into_iter().any(|fit| own_values(fit) > 0)
}

/// Number of parameters with a value of their own in every run.
fn own_values(fit: &FilterErrorFit) -> usize {
    fit.model.parameters.iter().filter(|p| p.spec.per_run).count()
}

/// Fall of −2 ln L of the held-out runs from one fit to another.
pub(super) fn fall(from: &FilterErrorFit, to: &FilterErrorFit, task: &Task<'_>) -> Result<f64, OutputErrorError> {
    costs(from, to, task).map(|(from, to)| from - to)
}

/// −2 ln L of the held-out runs with either fit.
fn costs(from: &FilterErrorFit, to: &FilterErrorFit, task: &Task<'_>) -> Result<(f64, f64), OutputErrorError> {
    let halved = judged_by_halves(from, to);
    if task.held.is_empty() && !halved {
        return Ok((from.left_out_cost(), to.left_out_cost()));
    }
    let runs = others(task);
    let cost = |fit: &FilterErrorFit| others_cost(fit, runs, halved, task.fitting);
    Ok((cost(from)?, cost(to)?))
}

/// The channel that is predicted significantly worse, if there is one.
fn worse(
    without: &FilterErrorFit,
    with: &FilterErrorFit,
    (runs, fitting): (&[Run], &FilterErrorOptions),
) -> Result<Option<String>, OutputErrorError> {
    let model = without.on_others(runs, fitting)?;
    let noise = without.noise.elsewhere(&model, runs);
    let filtered = Filtered::begun(&model, runs, (&noise, without.limit), &fitting.base)?;
    let before = filtered.forecast(&model, &noise, without.limit);
    let silent = filtered.silent(&without.noise);
    let model = with.on_others(runs, fitting)?;
    let noise = with.noise.elsewhere(&model, runs);
    let filtered = Filtered::begun(&model, runs, (&noise, with.limit), &fitting.base)?;
    let after = filtered.forecast(&model, &noise, with.limit);
    let outputs = filtered.problem.dynamics.outputs.iter().enumerate().filter(|(k, _)| !silent[*k]);
    let level = WORSE / outputs.clone().count().max(1) as f64;
    for (k, output) in outputs {
        let squares = |runs: &[Forecast]| -> Vec<f64> {
            runs.iter().flat_map(|run| run.channels[k].squares_apart(AHEAD)).collect()
        };
        if grows(&squares(&before), &squares(&after), level) {
            return Ok(Some(output.clone()));
        }
    }
    Ok(None)
}

/// Whether squares have grown, by more than chance produces in a share `level` of cases.
fn grows(before: &[f64], after: &[f64], level: f64) -> bool {
    let difference: Vec<f64> = after.iter().zip(before).map(|(a, b)| a - b).collect();
    let n = difference.len() as f64;
    let (sum, all): (f64, f64) = (difference.iter().sum(), before.iter().sum());
    let mean = sum / n;
    let variance = difference.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let beyond = StudentsT::new(0.0, 1.0, n - 1.0).map_or(f64::INFINITY, |t| t.inverse_cdf(1.0 - level));
    sum > all * ((1.0 + SAME) * (1.0 + SAME) - 1.0) && sum > beyond * (n * variance).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three runs of seven errors each: half as large again in one of twelve channels is as likely as not by chance.
    #[test]
    fn a_square_has_grown_where_chance_makes_no_such_thing() {
        let before: Vec<f64> = (0..21).map(|k| 1.0 + 0.5 * f64::from(k % 7)).collect();
        let by =
            |growth: fn(usize) -> f64| -> Vec<f64> { before.iter().enumerate().map(|(k, x)| x * growth(k)).collect() };
        assert!(grows(&before, &by(|_| 1.5), 0.01 / 12.0), "every one by a half");
        assert!(!grows(&before, &by(|_| 1.05), 0.01 / 12.0), "by less than counts");
        assert!(!grows(&before, &by(|k| if k == 3 { 10.0 } else { 1.0 }), 0.01 / 12.0), "one of them");
        assert!(!grows(&before, &by(|_| 0.5), 0.01 / 12.0), "they shrink");
        assert!(!grows(&[1.0], &[9.0], 0.01), "one says nothing of chance");
    }
}
