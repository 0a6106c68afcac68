//! Candidates refitted in full: the few that the scores put first, each by output error, the best of them kept.
//!
//! A linearisation at a model that is far off can put a wrong name first and call the right one unsure. Two steps of the
//! fit from where the linearisation points show what a candidate is worth; whoever cannot come near the best any more
//! is left there, and of the others the better half goes on by as many steps, until the last few are fitted to the end.

use super::confirm::p_of_refit;
use super::freedom::fair_cost;
use super::search::{Added, SearchOptions, noise_level, penalty};
use super::{Candidate, Evidence};
use crate::estimate::output_error::{OutputErrorFit, OutputErrorOptions, Problem, fit_from, normal_factor};
use crate::progress;
use crate::run::Run;

/// Steps of the fit before the first comparison.
const HEAT: usize = 2;

/// So many are fitted to the end.
const LAST: usize = 3;

/// A candidate that explains less than this share of what the best one does is not refitted.
const SHARE: f64 = 0.1;

/// Noise level from which on candidates are refitted that the linearisation is not sure of.
pub(super) const MISFIT: f64 = 1.3;

/// Noise level below which a model leaves nothing to others.
const AT_THE_NOISE: f64 = 1.05;

/// How many of those.
const UNSURE: usize = 4;

/// A candidate refitted.
struct Tried<'a> {
    candidate: usize,
    evidence: &'a Evidence,
    fit: OutputErrorFit,
}

impl Tried<'_> {
    /// Fall of the cost less what its parameters would bring by chance.
    fn net(&self, before: f64, cost: f64) -> f64 {
        (before - cost) - self.evidence.inflation.max(1.0) * penalty(self.evidence.parameters)
    }
}

/// Refits the best candidates in full and returns the one to add, with its fit; `None` when nothing is to be added.
/// `evidence` is sorted, best first.
pub(super) fn best(
    current: &OutputErrorFit,
    runs: &[Run],
    list: &[Candidate],
    evidence: &[Evidence],
    fitting: &OutputErrorOptions,
    options: &SearchOptions,
) -> Option<(Added, OutputErrorFit)> {
    let tried = contest(current, runs, list, shortlist(current, evidence, options), fitting, options);
    let count = evidence.len() as f64;
    let accepted = |t: &&Tried<'_>| {
        let gain = fair_cost(current) - fair_cost(&t.fit);
        let inflation = noise_level(&t.fit).max(1.0);
        let sure = t.evidence.p_value <= options.level && generalises(t.evidence);
        gain >= inflation * (penalty(t.evidence.parameters) + 10.0)
            && (sure || p_of_refit(current, &t.fit, count) <= options.level)
    };
    let first = tried.iter().find(accepted)?;
    // noise as the better model sees it
    let inflation = noise_level(&first.fit).max(1.0);
    let mut also_possible: Vec<String> = tried
        .iter()
        .filter(|t| t.candidate != first.candidate && (t.fit.cost - first.fit.cost) < inflation * options.tie)
        .map(|t| list[t.candidate].name())
        .filter(|name| *name != list[first.candidate].name())
        .collect();
    if list[first.candidate].name() == "thrust_delay" {
        also_possible.push("sensor_delay".into());
    }
    let mut evidence = first.evidence.clone();
    evidence.p_value = evidence.p_value.min(p_of_refit(current, &first.fit, count));
    let gain = current.cost - first.fit.cost;
    Some((Added { candidate: list[first.candidate].clone(), evidence, also_possible, gain }, first.fit.clone()))
}

/// What is worth a refit: what is significant; where the model is far from the data, also what explains most there.
fn shortlist<'a>(current: &OutputErrorFit, evidence: &'a [Evidence], options: &SearchOptions) -> Vec<&'a Evidence> {
    let mut short: Vec<&Evidence> = Vec::new();
    let convincing = evidence.iter().filter(|e| e.p_value <= options.level && generalises(e));
    for e in convincing {
        if short.len() < options.refits && short.iter().all(|s| s.candidate != e.candidate) {
            short.push(e);
        }
    }
    if noise_level(current) > MISFIT {
        let mut by_fall: Vec<&Evidence> = evidence.iter().collect();
        by_fall.sort_by(|a, b| b.explained.total_cmp(&a.explained));
        let room = short.len() + UNSURE;
        for e in by_fall {
            if short.len() < room && short.iter().all(|s| s.candidate != e.candidate) {
                short.push(e);
            }
        }
    }
    let most = short.iter().map(|e| e.explained).fold(0.0, f64::max);
    short.retain(|e| e.explained >= SHARE * most);
    short
}

/// Refits all of `short`, those that fall behind not to the end; the best first.
fn contest<'a>(
    current: &OutputErrorFit,
    runs: &[Run],
    list: &[Candidate],
    short: Vec<&'a Evidence>,
    fitting: &OutputErrorOptions,
    options: &SearchOptions,
) -> Vec<Tried<'a>> {
    let heat = OutputErrorOptions { iterations: HEAT, ..fitting.clone() };
    let count = short.len();
    let start = |(k, evidence): (usize, &'a Evidence)| {
        progress::tell(format!("fitting with {}", list[evidence.candidate].name()), k, count);
        let fit = refit(current, runs, &list[evidence.candidate], evidence, &heat)?;
        Some(Tried { candidate: evidence.candidate, evidence, fit })
    };
    let mut tried: Vec<Tried<'a>> = Vec::new();
    for (k, evidence) in short.into_iter().enumerate() {
        // who has reached the noise leaves nothing to those whose signal explains much less
        let done =
            |t: &Tried<'_>| noise_level(&t.fit) < AT_THE_NOISE && evidence.explained < 0.5 * t.evidence.explained;
        if !tried.iter().any(done) {
            tried.extend(start((k, evidence)));
        }
    }
    let hoped = |t: &Tried<'_>| t.fit.cost - if t.fit.converged { 0.0 } else { 2.0 * promise(&t.fit) };
    // whom the scores put first may start far off, and is not given up for a slow start
    let Some(favourite) = tried.first().map(|t| t.candidate) else { return tried };
    let mut left = tried.len();
    let mut steps = HEAT;
    while steps < fitting.iterations {
        // a fit that begins anew looks for its damping anew, so that later rounds are longer
        steps *= 3;
        let round = OutputErrorOptions { iterations: steps.min(fitting.iterations), ..fitting.clone() };
        tried.sort_by(|a, b| b.net(current.cost, b.fit.cost).total_cmp(&a.net(current.cost, a.fit.cost)));
        let Some(lowest) = tried.iter().map(|t| t.fit.cost).min_by(f64::total_cmp) else { break };
        let near = |t: &Tried<'_>| hoped(t) < lowest + noise_level(&t.fit).max(1.0) * options.tie;
        // whoever stays in the second half is left where it is
        let open = |(k, t): (usize, &Tried<'_>)| !t.fit.converged && (k < left && near(t) || t.candidate == favourite);
        let going: Vec<usize> = tried.iter().enumerate().filter(|each| open(*each)).map(|(k, _)| k).collect();
        if going.is_empty() {
            break;
        }
        for k in going {
            let t = &mut tried[k];
            let states = t.fit.initial_states.clone();
            if let Ok(fit) = fit_from(&t.fit.model, t.fit.problem.clone(), states, &round) {
                t.fit = fit;
            }
        }
        left = left.div_ceil(2).max(LAST).min(tried.len());
    }
    let before = fair_cost(current);
    let mut net: Vec<(f64, Tried<'a>)> = tried.into_iter().map(|t| (t.net(before, fair_cost(&t.fit)), t)).collect();
    net.sort_by(|a, b| b.0.total_cmp(&a.0));
    net.into_iter().map(|(_, t)| t).collect()
}

/// Fall of the cost that one more step promises.
fn promise(fit: &OutputErrorFit) -> f64 {
    let factor = normal_factor(&fit.problem, &fit.model, &fit.linearised);
    let p = fit.problem.unknowns.len();
    (0..p).map(|i| factor.at(i, p)[0].powi(2)).sum()
}

/// Whether the candidate helps on runs that it has not seen, in sum.
fn generalises(evidence: &Evidence) -> bool {
    evidence.left_out_gain.is_empty() || evidence.left_out_gain.iter().sum::<f64>() > 0.0
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
    let (sigma, segments) = (current.problem.sigma.clone(), current.problem.segments.clone());
    let problem = Problem { sigma, segments, ..problem };
    let states = problem.free_states();
    let mut x0 = problem.initial_states(&model);
    for (new, old) in x0.iter_mut().zip(&current.initial_states) {
        new[..states].copy_from_slice(&old[..states]);
    }
    fit_from(&model, problem, x0, fitting).ok().filter(|fit| fit.cost.is_finite())
}
