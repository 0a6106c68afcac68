//! The search: score all candidates, refit the best, keep what the data confirm, and again.
//!
//! 1. fit the model by output error on segments;
//! 2. score every absent effect ([`super::score`]), judge it against chance ([`super::judge`]);
//! 3. refit the few best in full; the one that lowers the cost most, its number of parameters counted, is added;
//! 4. drop what is no longer needed: an effect may have stood in for two;
//! 5. when no candidate is beyond chance, or none of them helps on the run that it has not seen, put the earlier names
//!    to the test again with the later ones known ([`super::revise`]), and go on from there until nothing changes.

use std::sync::Arc;

use super::refit::{MISFIT, best};
use super::revise::{exchange, prune};
use super::settle::{Settled, settle};
use super::{Candidate, Evidence, candidates, judge, score};
use crate::effects::{Effect, Family, Place};
use crate::estimate::output_error::{OutputErrorError, OutputErrorFit, OutputErrorOptions};
use crate::estimate::started;
use crate::model::{Model, Parameter};
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
    /// The same of whole rows of −C(ν)ν, which have no parameter of their own.
    pub rows: Vec<(String, Evidence)>,
    /// Greatest length of the segments of the last fit, s: shorter than asked for where the model is far from the data.
    pub segment: f64,
    /// Longest step of the integrator, s: shorter than asked for where the noise is so small that it would show.
    pub longest_step: f64,
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
    let Settled { fit, options: mut at, mut rough } = settle(baseline, runs, fitting)?;
    let mut found = Search {
        steps: vec![Step { name: None, fit }],
        added: Vec::new(),
        removed: Vec::new(),
        last: Vec::new(),
        rows: Vec::new(),
        segment: at.segment,
        longest_step: at.longest_step,
    };
    let mut exchanges = 0;
    loop {
        let current = found.last_fit().clone();
        let list = asked(&current.model, runs, own, options);
        let (probes, products) = score(&current, runs, &list, &at)?;
        let mut evidence = judge(&current.problem, &products, &probes);
        evidence.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        // a row as a whole has the name of its leading product
        let named = |e: &Evidence| (list[e.candidate].name(), e.clone());
        let (of_products, of_rows): (Vec<&Evidence>, Vec<&Evidence>) =
            evidence.iter().partition(|e| list[e.candidate].has_parameters());
        found.rows = of_rows.into_iter().map(named).collect();
        let scored = of_products.into_iter().map(named).collect();
        let before = std::mem::replace(&mut found.last, scored);
        let latest = found.steps.last().and_then(|step| step.name.clone());
        if let Some(newest) = found.added.last_mut().filter(|a| Some(a.candidate.name()) == latest) {
            same_as(newest, &before, &found.last, &list);
        }
        let room = found.added.len() < options.most;
        let next = if room { best(&current, runs, &list, &evidence, &at, options) } else { None };
        let Some((added, mut fit)) = next else {
            // each exchange lowers the cost by more than a tie, so that this ends; the bound is for rounding
            exchanges += 1;
            if exchanges > options.most || !exchange(&mut found, runs, own, &at, options)? {
                prune(&mut found, runs, &at, 0)?;
                break;
            }
            prune(&mut found, runs, &at, 1)?;
            continue;
        };
        // where nothing better comes of it, it stays as it was found
        if rough && let Ok(settled) = settle(&fit.model, runs, fitting) {
            Settled { fit, options: at, rough } = settled;
        }
        // a fit that came from values no vehicle has may have gone astray: the log itself starts another
        if noise_level(&fit) > MISFIT
            && feeds_motion(&fit.model)
            && let Ok(anew) = settle(&started(&fit.model, runs), runs, fitting)
            && noise_level(&anew.fit) < noise_level(&fit)
        {
            Settled { fit, options: at, rough } = anew;
        }
        found.steps.push(Step { name: Some(added.candidate.name()), fit });
        found.added.push(added);
        prune(&mut found, runs, &at, 1)?;
    }
    (found.segment, found.longest_step) = (at.segment, at.longest_step);
    Ok(found)
}

/// The candidates of the families that are searched, and the user's own.
pub(super) fn asked(
    model: &Model,
    runs: &[Run],
    own: &[(Arc<dyn Effect>, Place)],
    options: &SearchOptions,
) -> Vec<Candidate> {
    let mut list = candidates(model, runs, own);
    let of_user = |c: &Candidate| own.iter().any(|(effect, _)| effect.about().id == c.terms[0].0.about().id);
    list.retain(|c| options.families.contains(&c.family()) || of_user(c));
    list
}

/// Whether an inertia or a drag of the model would feed the motion.
fn feeds_motion(model: &Model) -> bool {
    let dissipates = |p: &&Parameter| matches!(p.effect.as_str(), "inertia" | "linear_drag" | "quadratic_drag");
    model.parameters.iter().filter(dissipates).any(|p| !p.fixed && p.value < 0.0)
}

/// Lists with the effect that was added last those that it has made impossible to tell from the model: what had a signal
/// of its own before and has none any more is the same effect to this data.
fn same_as(newest: &mut Added, before: &[(String, Evidence)], now: &[(String, Evidence)], list: &[Candidate]) {
    for (name, _) in before {
        let gone = now.iter().all(|(other, _)| other != name) && list.iter().any(|c| c.name() == *name);
        if gone && !newest.also_possible.contains(name) {
            newest.also_possible.push(name.clone());
        }
    }
}

/// Fall of the cost less what as many parameters of nothing would bring, in units of the inflated noise.
pub(super) fn worth(evidence: &Evidence) -> f64 {
    evidence.explained / evidence.inflation - penalty(evidence.parameters)
}

/// What a parameter has to bring to be worth it, in units of the inflated noise.
pub(super) fn penalty(parameters: usize) -> f64 {
    4.0 * parameters as f64
}

/// Residual variance over the assumed one.
pub(super) fn noise_level(fit: &OutputErrorFit) -> f64 {
    let states = fit.problem.free_states();
    fit.cost / (fit.samples as f64 - (states * fit.problem.segments.len()) as f64).max(1.0)
}
