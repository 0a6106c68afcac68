//! Earlier names put to the test again, once later ones are known.

use std::sync::Arc;

use super::freedom::fair_cost;
use super::refit::best;
use super::search::{Search, SearchOptions, Step, asked, noise_level, penalty, worth};
use super::{Candidate, judge, score};
use crate::effects::{Effect, Place};
use crate::estimate::output_error::{OutputErrorError, OutputErrorFit, OutputErrorOptions, Problem, fit_from};
use crate::model::Model;
use crate::run::Run;

/// Puts earlier effects to the test again: with a later one known, another name may fit better than the first that came.
/// Returns whether a name was exchanged.
pub(super) fn exchange(
    found: &mut Search,
    runs: &[Run],
    own: &[(Arc<dyn Effect>, Place)],
    fitting: &OutputErrorOptions,
    options: &SearchOptions,
) -> Result<bool, OutputErrorError> {
    for k in 0..found.added.len().saturating_sub(1) {
        let current = found.last_fit().clone();
        let known = found.added[k].candidate.name();
        let Some(before) = fit_without(&current, &found.added[k].candidate, runs, fitting)? else { continue };
        let list = asked(&before.model, runs, own, options);
        let (probes, products) = score(&before, runs, &list, fitting)?;
        let mut evidence = judge(&before.problem, &products, &probes);
        evidence.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        let Some((added, fit)) = best(&before, runs, &list, &evidence, fitting, options) else { continue };
        let gain = fair_cost(&current) - fair_cost(&fit);
        if added.candidate.name() != known && gain > noise_level(&fit).max(1.0) * options.tie {
            found.removed.push(known);
            found.steps.push(Step { name: Some(added.candidate.name()), fit });
            found.added[k] = added;
            return Ok(true);
        }
    }
    Ok(false)
}

/// Drops effects without which the fit is hardly worse; the `latest` ones, which have just come, are not questioned.
pub(super) fn prune(
    found: &mut Search,
    runs: &[Run],
    fitting: &OutputErrorOptions,
    latest: usize,
) -> Result<(), OutputErrorError> {
    loop {
        let current = found.last_fit().clone();
        let level = noise_level(&current).max(1.0);
        let mut weakest: Option<(usize, OutputErrorFit)> = None;
        for (k, added) in found.added.iter().enumerate().take(found.added.len().saturating_sub(latest)) {
            let Some(fit) = fit_without(&current, &added.candidate, runs, fitting)? else { continue };
            let loss = fair_cost(&fit) - fair_cost(&current);
            if loss < level * (penalty(added.evidence.parameters) + 10.0)
                && weakest.as_ref().is_none_or(|(_, best)| fit.cost < best.cost)
            {
                weakest = Some((k, fit));
            }
        }
        let Some((k, fit)) = weakest else { return Ok(()) };
        let dropped = found.added.remove(k);
        found.removed.push(dropped.candidate.name());
        if let Some(step) = found.steps.last_mut() {
            step.fit = fit;
        }
    }
}

/// The fit of the model without the terms of a candidate, started from the fit with them; `None` where it fails.
fn fit_without(
    current: &OutputErrorFit,
    candidate: &Candidate,
    runs: &[Run],
    fitting: &OutputErrorOptions,
) -> Result<Option<OutputErrorFit>, OutputErrorError> {
    let model = without(&current.model, candidate);
    let problem = Problem::new(&model, runs, fitting)?;
    let (sigma, segments) = (current.problem.sigma.clone(), current.problem.segments.clone());
    let problem = Problem { sigma, segments, ..problem };
    let mut x0 = problem.initial_states(&model);
    let states = problem.free_states();
    for (new, old) in x0.iter_mut().zip(&current.initial_states) {
        new[..states].copy_from_slice(&old[..states]);
    }
    Ok(fit_from(&model, problem, x0, fitting).ok())
}

/// The model without the terms of a candidate.
fn without(model: &Model, candidate: &Candidate) -> Model {
    let mut model = model.clone();
    for (effect, place) in &candidate.terms {
        if let Some(term) = model.term(&crate::model::name_of(effect.about().id, *place)) {
            model.remove(term);
        }
    }
    model
}
