//! Start of a refit: shape parameters from a grid eight times as fine about their best probe.
//!
//! ```text
//! probe ← argmin p(probe)   on the grid, then between its neighbours        under Q, and under Q with forces at a tenth
//! ```
//!
//! An instant, a time constant or a threshold that starts one mesh away from the truth may end in another local
//! maximum of the likelihood. A random force that has absorbed the missing effect blurs the maxima, so they are also
//! computed with a small force. If that gives another maximum there are two starts, unless the second is worse than
//! the first and than the last model.

use super::candidate::Candidate;
use super::rules::is_new;
use super::screen::{Score, screen};
use super::task::{ROUGH, Task};
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions, cost_of, filter_error_from};
use crate::model::{Model, Parameter};
use crate::run::Run;

/// Factor on the forces for the second search of maxima, a hundredth of their power. Chosen in simulation: with it the
/// instant at which a thruster fails stood out, while the full force hid it.
const QUIET: f64 = 0.1;

/// Steps of a profile between two values of a grid: for instants in a minute two per second, as often as commands turn.
const PROFILE: u32 = 8;

/// A candidate, and the score of the probe at which it starts.
#[derive(Debug, Clone)]
pub(super) struct Start {
    pub candidate: Candidate,
    pub score: Score,
}

impl Start {
    /// Value of its only shape parameter.
    fn shape(&self) -> f64 {
        self.candidate.probes[self.score.probe][0]
    }

    /// Distance of two neighbours on the grid before refinement: the finer one spans two such distances.
    fn mesh(&self) -> f64 {
        let ends = self.candidate.probes.first().zip(self.candidate.probes.last());
        ends.map_or(0.0, |(first, last)| 0.5 * (last[0] - first[0]).abs())
    }

    /// The better of this start and another one of the same candidate.
    fn or_better(self, other: Option<Start>) -> Start {
        match other {
            Some(other) if other.score.log_p < self.score.log_p => other,
            _ => self,
        }
    }
}

/// Starts of the candidates that `best` scores (indices refer to `list`), in its order; a shape may have two starts.
pub(super) fn starts(here: &FilterErrorFit, best: &[Score], list: &[Candidate], task: &Task<'_>) -> Vec<Start> {
    let start = |score: &Score| Start { candidate: list[score.candidate].clone(), score: score.clone() };
    let usual: Vec<Start> = best.iter().map(start).collect();
    let has_grid = |s: &Start| s.candidate.nearer(s.score.probe).is_some();
    let shaped: Vec<Start> = usual.iter().filter(|s| has_grid(s)).cloned().collect();
    let mut quiet = here.clone();
    quiet.noise.forces.iter_mut().for_each(|f| f.rms *= QUIET);
    let coarse = scored(&quiet, shaped.iter().map(|s| s.candidate.clone()).collect(), task);
    let coarse: Vec<Start> = shaped.iter().zip(coarse).map(|(s, found)| found.unwrap_or_else(|| s.clone())).collect();
    let mut fine = finer(here, &shaped, task).into_iter().zip(finer(&quiet, &coarse, task));
    let cost = |start: &Start| {
        let begun = nearest(&start.candidate, here, &start.score, task);
        begun.map_or(f64::INFINITY, |model| cost_here(&model, here, task))
    };
    let mut all = Vec::new();
    for one in usual {
        let index = one.score.candidate;
        let mut of_list = |mut start: Start| {
            start.score.candidate = index;
            all.push(start);
        };
        match has_grid(&one).then(|| fine.next()).flatten() {
            Some((loud, mut quiet)) => {
                // closer than half a mesh they lead to the same maximum
                let differs = (quiet.shape() - loud.shape()).abs() > 0.5 * quiet.mesh();
                // with a tenth of the forces a score locates the maximum but does not give its height
                (quiet.score.statistic, quiet.score.log_p) = (loud.score.statistic, loud.score.log_p);
                let lost = differs && cost(&quiet) > cost(&loud).max(cost_here(&here.model, here, task));
                of_list(loud);
                if differs && !lost {
                    of_list(quiet);
                }
            }
            None => of_list(one),
        }
    }
    all
}

/// The last model with a candidate started at its probe, or at the share of it that its score estimates, whichever is
/// likelier: if the truth is far from the probe, the share saves the longer part of the climb.
pub(super) fn nearest(candidate: &Candidate, here: &FilterErrorFit, score: &Score, task: &Task<'_>) -> Option<Model> {
    let at_probe = candidate.started(&here.model, score)?;
    let Some(in_part) = candidate.started_in_part(&here.model, score) else { return Some(at_probe) };
    let cost = |model: &Model| cost_here(model, here, task);
    Some(if cost(&in_part) < cost(&at_probe) { in_part } else { at_probe })
}

/// −2 ln L of the runs of the fit for another model with the noise of `here`; infinite if it diverges.
fn cost_here(model: &Model, here: &FilterErrorFit, task: &Task<'_>) -> f64 {
    cost_of(model, task.train, (&here.noise, here.limit), task.fitting).unwrap_or(f64::INFINITY)
}

/// The model of `with`, a fit that contains `candidate` beyond `before`, with its only shape moved to the maximum of
/// the likelihood along the grid and all else kept; `None` if it is there already. A model without the name has
/// biased values, and so seems the place of the name: an instant may have settled on the slope of a command.
fn elsewhere(before: &Model, with: &FilterErrorFit, candidate: &Candidate) -> Option<Model> {
    let is_shape = |p: &Parameter| is_new(before, p) && !p.spec.is_linear();
    let shape = with.model.parameters.iter().position(is_shape)?;
    // a delay or a lag has one smooth maximum, and its inputs would have to be read anew at each value; per-run
    // phases fit one period only
    let is_asked = !candidate.blended && !candidate.has_own_values();
    let mut grid = candidate.grid().filter(|grid| grid.len() > 1 && is_asked)?;
    grid.sort_by(f64::total_cmp);
    let known = &with.model.parameters[shape];
    let between = |ends: &[f64]| {
        let (low, high) = (ends[0], ends[1]);
        (0..PROFILE).map(move |i| low + (high - low) * f64::from(i) / f64::from(PROFILE))
    };
    let mut along: Vec<f64> = grid.windows(2).flat_map(between).chain(grid.last().copied()).collect();
    along.retain(|value| (known.min..=known.max).contains(value));
    along.push(known.value);
    let at = |value: f64| {
        let mut model = with.model.clone();
        model.parameters[shape].value = value;
        model
    };
    let mut models: Vec<Model> = along.into_iter().map(at).collect();
    let costs = with.costs_at(&models);
    let least = (0..costs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))?;
    (costs[least] < *costs.last()?).then(|| models.swap_remove(least))
}

/// A fit with `candidate` beyond `before`, restarted where its shape is likeliest; `None` if it is no better.
pub(super) fn higher(
    before: &Model,
    fit: &FilterErrorFit,
    candidate: &Candidate,
    runs: &[Run],
    options: &FilterErrorOptions,
) -> Option<FilterErrorFit> {
    let begun = elsewhere(before, fit, candidate)?;
    let other = filter_error_from(&begun, runs, fit.noise.clone(), options).ok()?;
    (other.plain < fit.plain - ROUGH).then_some(other)
}

/// The best probe of each candidate under a fit.
fn scored(fit: &FilterErrorFit, candidates: Vec<Candidate>, task: &Task<'_>) -> Vec<Option<Start>> {
    if candidates.is_empty() {
        return Vec::new();
    }
    let (options, base) = (task.options, &task.fitting.base);
    let scores = screen(fit, task.train, &candidates, base, (options.level, options.seed)).map(|s| s.scores);
    // the first score of each candidate is its best one
    let scores = scores.unwrap_or_default();
    let of = |(k, candidate)| Some(Start { candidate, score: scores.iter().find(|s| s.candidate == k)?.clone() });
    candidates.into_iter().enumerate().map(of).collect()
}

/// The same starts on the finer grid.
fn finer(fit: &FilterErrorFit, starts: &[Start], task: &Task<'_>) -> Vec<Start> {
    let near = |s: &Start| s.candidate.nearer(s.score.probe).unwrap_or_else(|| s.candidate.clone());
    let found = scored(fit, starts.iter().map(near).collect(), task);
    starts.iter().cloned().zip(found).map(|(start, found)| start.or_better(found)).collect()
}
