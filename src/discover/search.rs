//! The search: score all candidates, refit the best, keep what the data confirm, and again.
//!
//! 1. fit the model by output error on segments;
//! 2. score every absent effect ([`super::score`]), judge it against chance ([`super::judge`]);
//! 3. refit the few best in full; the one that lowers the cost most, its number of parameters counted, is added;
//! 4. drop what is no longer needed: an effect may have stood in for two;
//! 5. stop when no candidate is beyond chance, or when none of them helps on the run that it has not seen.

use std::sync::Arc;

use super::{Candidate, Evidence, candidates, judge, score};
use crate::effects::{Effect, Family, Place};
use crate::estimate::output_error::{OutputErrorError, OutputErrorFit, OutputErrorOptions, Problem, fit_from};
use crate::model::Model;
use crate::progress;
use crate::run::Run;

/// How the search is done.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchOptions {
    /// Probability of adding anything when nothing is missing.
    pub level: f64,
    /// Greatest number of effects to add.
    pub most: usize,
    /// Number of candidates that are refitted in full at each step.
    pub refits: usize,
    /// Candidates within this fall of the cost, in units of the inflated noise, are possible as well: about three
    /// standard deviations of the difference of two names for one signal.
    pub tie: f64,
    /// Families of the catalogue that are searched; users' own effects always are.
    pub families: Vec<Family>,
}

impl Default for SearchOptions {
    fn default() -> SearchOptions {
        let families = vec![Family::Body, Family::Actuator, Family::Environment, Family::Sensor];
        SearchOptions { level: 0.003, most: 6, refits: 6, tie: 9.0, families }
    }
}

/// An effect that was added.
#[derive(Debug, Clone)]
pub struct Added {
    /// The candidate.
    pub candidate: Candidate,
    /// What spoke for it.
    pub evidence: Evidence,
    /// Names of the others that the data allow.
    pub also_possible: Vec<String>,
    /// Fall of the cost by the refit, in units of the noise variance.
    pub gain: f64,
}

/// One state of the search: the model after `added` effects.
#[derive(Debug, Clone)]
pub struct Step {
    /// Name of what was added; `None` for the baseline.
    pub name: Option<String>,
    /// The fit.
    pub fit: OutputErrorFit,
}

/// What the search found.
#[derive(Debug, Clone)]
pub struct Search {
    /// Baseline, then one entry an effect added.
    pub steps: Vec<Step>,
    /// Effects that stand in the final model, in the order in which they came.
    pub added: Vec<Added>,
    /// Names of effects that were added and dropped again.
    pub removed: Vec<String>,
    /// Evidence of all candidates at the last step, best first.
    pub last: Vec<(String, Evidence)>,
}

impl Search {
    /// The final fit.
    pub fn last_fit(&self) -> &OutputErrorFit {
        &self.steps.last().expect("the baseline is a step").fit
    }
}

/// Searches for what `baseline` lacks on `runs`; `own` are candidates of the user.
///
/// # Errors
/// [`OutputErrorError`] when the baseline cannot be fitted.
pub fn search(
    baseline: &Model,
    runs: &[Run],
    own: &[(Arc<dyn Effect>, Place)],
    fitting: &OutputErrorOptions,
    options: &SearchOptions,
) -> Result<Search, OutputErrorError> {
    progress::tell("fitting the baseline", 0, 0);
    let (fit, mut at) = settle(baseline, runs, fitting)?;
    let mut found =
        Search { steps: vec![Step { name: None, fit }], added: Vec::new(), removed: Vec::new(), last: Vec::new() };
    while found.added.len() < options.most {
        let current = found.last_fit().clone();
        let list = asked(&current.model, runs, own, options);
        let (probes, products) = score(&current, runs, &list, &at)?;
        let mut evidence = judge(&current.problem, &products, &probes);
        evidence.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        found.last = evidence.iter().map(|e| (list[e.candidate].name(), e.clone())).collect();
        let Some((added, mut fit)) = best(&current, runs, &list, &evidence, &at, options) else { break };
        if at.segment < fitting.segment {
            (fit, at) = settle(&fit.model, runs, fitting)?;
        }
        found.steps.push(Step { name: Some(added.candidate.name()), fit });
        found.added.push(added);
        prune(&mut found, runs, &at)?;
        exchange(&mut found, runs, own, &at, options)?;
    }
    Ok(found)
}

/// The candidates of the families that are searched, and the user's own.
fn asked(model: &Model, runs: &[Run], own: &[(Arc<dyn Effect>, Place)], options: &SearchOptions) -> Vec<Candidate> {
    let mut list = candidates(model, runs, own);
    let of_user = |c: &Candidate| own.iter().any(|(effect, _)| effect.about().id == c.terms[0].0.about().id);
    list.retain(|c| options.families.contains(&c.family()) || of_user(c));
    list
}

/// Residual variance over that of the noise from which on segments are cut short.
const ROUGH: f64 = 25.0;

/// Fits a model on segments of the wanted length; where it is so far from the data that a long segment can lead into a
/// wrong valley, on segments of a third of it. Returns the fit with the options it was made with.
fn settle(
    model: &Model,
    runs: &[Run],
    fitting: &OutputErrorOptions,
) -> Result<(OutputErrorFit, OutputErrorOptions), OutputErrorError> {
    let attempt = |options: &OutputErrorOptions| {
        let problem = Problem::new(model, runs, options)?;
        let x0 = problem.initial_states(model);
        fit_from(model, problem, x0, options)
    };
    let whole = attempt(fitting);
    if whole.as_ref().is_ok_and(|fit| noise_level(fit) < ROUGH) {
        return whole.map(|fit| (fit, fitting.clone()));
    }
    for parts in [3.0, 8.0] {
        let short = OutputErrorOptions { segment: fitting.segment / parts, ..fitting.clone() };
        if let Ok(fit) = attempt(&short) {
            return Ok((fit, short));
        }
    }
    whole.map(|fit| (fit, fitting.clone()))
}

/// Fall of the cost less what as many parameters of nothing would bring, in units of the inflated noise.
fn worth(evidence: &Evidence) -> f64 {
    evidence.explained / evidence.inflation - penalty(evidence.parameters)
}

/// What a parameter has to bring to be worth it, in units of the inflated noise.
fn penalty(parameters: usize) -> f64 {
    4.0 * parameters as f64
}

/// Refits the best candidates in full and returns the one to add, with its fit; `None` when nothing is to be added.
fn best(
    current: &OutputErrorFit,
    runs: &[Run],
    list: &[Candidate],
    evidence: &[Evidence],
    fitting: &OutputErrorOptions,
    options: &SearchOptions,
) -> Option<(Added, OutputErrorFit)> {
    let mut tried: Vec<(usize, OutputErrorFit, &Evidence)> = Vec::new();
    let convincing = |e: &&Evidence| e.p_value <= options.level && generalises(e);
    for e in evidence.iter().filter(convincing) {
        if tried.iter().any(|(c, ..)| *c == e.candidate) {
            continue;
        }
        if tried.len() == options.refits {
            break;
        }
        progress::tell(format!("fitting with {}", list[e.candidate].name()), tried.len(), options.refits);
        if let Some(fit) = refit(current, runs, &list[e.candidate], e, fitting) {
            tried.push((e.candidate, fit, e));
        }
    }
    let net =
        |fit: &OutputErrorFit, e: &Evidence| (current.cost - fit.cost) - e.inflation.max(1.0) * penalty(e.parameters);
    tried.sort_by(|a, b| net(&b.1, b.2).total_cmp(&net(&a.1, a.2)));
    let (first, fit, e) = tried.first()?;
    // noise as the better model sees it
    let inflation = noise_level(fit).max(1.0);
    let gain = current.cost - fit.cost;
    if gain < inflation * (penalty(e.parameters) + 10.0) {
        return None;
    }
    let mut also_possible: Vec<String> = tried[1..]
        .iter()
        .filter(|(_, other, _)| other.cost - fit.cost < inflation * options.tie)
        .map(|(c, ..)| list[*c].name())
        .collect();
    if list[*first].name() == "thrust_delay" {
        also_possible.push("sensor_delay".into());
    }
    let added = Added { candidate: list[*first].clone(), evidence: (*e).clone(), also_possible, gain };
    Some((added, fit.clone()))
}

/// Whether the candidate helps on runs that it has not seen: in sum, and not by one run alone where several speak.
fn generalises(evidence: &Evidence) -> bool {
    let gains = &evidence.left_out_gain;
    if gains.is_empty() {
        return true;
    }
    gains.iter().sum::<f64>() > 0.0
}

/// Residual variance over the assumed one.
pub(super) fn noise_level(fit: &OutputErrorFit) -> f64 {
    let states = fit.problem.dynamics.states.len() - fit.problem.dynamics.memories();
    fit.cost / (fit.samples as f64 - (states * fit.problem.segments.len()) as f64).max(1.0)
}

/// The model with the candidate in it, fitted from what the linearisation says.
fn refit(
    current: &OutputErrorFit,
    runs: &[Run],
    candidate: &Candidate,
    evidence: &Evidence,
    fitting: &OutputErrorOptions,
) -> Option<OutputErrorFit> {
    let mut model = current.model.clone();
    let before = model.parameters.len();
    candidate.add_to(&mut model, &candidate.probes[evidence.probe]).ok()?;
    let direct = candidate.probes.len() == 1;
    let moved: Vec<usize> = (before..model.parameters.len())
        .filter(|p| !candidate.blended && (direct || model.parameters[*p].spec.is_linear()))
        .collect();
    let per_run = moved.iter().any(|p| model.parameters[*p].spec.per_run);
    for (k, p) in moved.iter().enumerate() {
        let parameter = &mut model.parameters[*p];
        let clamp = |x: f64| x.clamp(parameter.min, parameter.max);
        if per_run {
            let values = evidence.beta.chunks(moved.len()).map(|run| parameter.spec.neutral + run[k]).collect();
            parameter.per_run = values;
        } else {
            parameter.value = clamp(parameter.spec.neutral + evidence.beta[k]);
        }
    }
    let problem = Problem::new(&model, runs, fitting).ok()?;
    let problem = Problem { sigma: current.problem.sigma.clone(), ..problem };
    let states = problem.dynamics.states.len() - problem.dynamics.memories();
    let mut x0 = problem.initial_states(&model);
    for (new, old) in x0.iter_mut().zip(&current.initial_states) {
        new[..states].copy_from_slice(&old[..states]);
    }
    fit_from(&model, problem, x0, fitting).ok().filter(|fit| fit.cost.is_finite())
}

/// Puts earlier effects to the test again: with a later one known, another name may fit better than the first that came.
fn exchange(
    found: &mut Search,
    runs: &[Run],
    own: &[(Arc<dyn Effect>, Place)],
    fitting: &OutputErrorOptions,
    options: &SearchOptions,
) -> Result<(), OutputErrorError> {
    for k in 0..found.added.len().saturating_sub(1) {
        let current = found.last_fit().clone();
        let known = found.added[k].candidate.name();
        let model = without(&current.model, &found.added[k].candidate);
        let problem = Problem::new(&model, runs, fitting)?;
        let problem = Problem { sigma: current.problem.sigma.clone(), ..problem };
        let x0 = problem.initial_states(&model);
        let Ok(before) = fit_from(&model, problem, x0, fitting) else { continue };
        let list = asked(&before.model, runs, own, options);
        let (probes, products) = score(&before, runs, &list, fitting)?;
        let mut evidence = judge(&before.problem, &products, &probes);
        evidence.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        let Some((added, fit)) = best(&before, runs, &list, &evidence, fitting, options) else { continue };
        let gain = current.cost - fit.cost;
        if added.candidate.name() != known && gain > noise_level(&fit).max(1.0) * options.tie {
            found.removed.push(known);
            found.added[k] = added;
            if let Some(step) = found.steps.last_mut() {
                step.fit = fit;
            }
        }
    }
    Ok(())
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

/// Drops effects without which the fit is hardly worse.
fn prune(found: &mut Search, runs: &[Run], fitting: &OutputErrorOptions) -> Result<(), OutputErrorError> {
    loop {
        let current = found.last_fit().clone();
        let level = noise_level(&current).max(1.0);
        let mut weakest: Option<(usize, OutputErrorFit)> = None;
        // the effect that has just come is not questioned
        for (k, added) in found.added.iter().enumerate().take(found.added.len().saturating_sub(1)) {
            let model = without(&current.model, &added.candidate);
            let problem = Problem::new(&model, runs, fitting)?;
            let problem = Problem { sigma: current.problem.sigma.clone(), ..problem };
            let x0 = problem.initial_states(&model);
            let Ok(fit) = fit_from(&model, problem, x0, fitting) else { continue };
            let loss = fit.cost - current.cost;
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
