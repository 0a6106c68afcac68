//! Step 3: a candidate is refitted in full, from the last model and, if that leads nowhere, from the log.
//!
//! ```text
//! −2 ln L(θ, noise)  →  min        from θ̂ of the last model and its half of the forces;  from the log
//! ```

use std::cmp::Ordering;

use super::candidate::Candidate;
use super::focus::{Start, nearest};
use super::pushed::is_hopeless;
use super::rules::is_nothing;
use super::screen::{Score, beyond_chance};
use super::searched::Search;
use super::task::{ROUGH, TIE, Task};
use crate::effects::Scope;
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions, NoiseModel, filter_error, filter_error_from};
use crate::estimate::output_error::OutputErrorError;
use crate::estimate::started;
use crate::model::{Model, Parameter};

/// Share of the best candidate's gain so far below which another candidate is given up: neither held-out runs nor a
/// second effect beside it make up for half.
const HOPEFUL: f64 = 0.5;

/// Share of the fall of −2 ln L predicted by its score below which a refit has ended in another maximum and is
/// restarted from the log: if the baseline is far from the truth, its values are no good start.
const PROMISE: f64 = 0.5;

/// Fall of −2 ln L that a parameter must be worth when names are compared: Akaike's two, doubled because names are
/// chosen after looking at the data.
const PENALTY: f64 = 4.0;

/// A candidate refitted in full.
pub(super) struct Contender {
    pub score: Score,
    pub fit: FilterErrorFit,
    pub gain: f64,
    /// Fall of −2 ln L on held-out runs.
    pub held_out: f64,
    pub held_out_cost: f64,
}

/// Criterion by which names are compared.
#[derive(Clone, Copy)]
pub(super) struct Standing {
    /// Fall of −2 ln L, including that of held-out runs, minus the penalty for the parameters.
    pub worth: f64,
    /// The same with −2 ln L of those runs in place of its fall, which is infinite if the last model diverges there.
    likely: f64,
}

impl Standing {
    /// Order of two: the one worth more comes first; of two that are both worth infinitely much, the likelier one.
    pub fn before(&self, other: &Standing) -> Ordering {
        other.worth.total_cmp(&self.worth).then_with(|| other.likely.total_cmp(&self.likely))
    }
}

impl Contender {
    /// Standing of the contender, reduced by `off`.
    pub fn standing(&self, off: f64) -> Standing {
        let own = self.gain - PENALTY * self.score.parameters as f64 - off;
        Standing { worth: own + self.held_out, likely: own - self.held_out_cost }
    }
}

/// Fall of −2 ln L from one fit to another, minus the part due to the unknown initial states of the runs
/// ([`FilterErrorFit::of_beginnings`]).
pub(super) fn merit(from: &FilterErrorFit, to: &FilterErrorFit, gain: f64) -> f64 {
    gain - (from.of_beginnings() - to.of_beginnings())
}

/// Refits a candidate from the last model. It is also refitted from the log in three cases: the first refit falls
/// short of what the score promised; the score is significant, but the refitted parameters are within three standard
/// deviations of zero; or two thrusters are swapped, so that the last model is wrong throughout. If the last model is
/// of a vehicle that its commands do not move, it is refitted from the log alone. A candidate that promises less than
/// `best` has gained, or less than chance gives, is not restarted: the last model is a good start, and what remains
/// is scored again. Nor is one whose restart was in vain beside fewer names. `None` if its gain cannot reach half of
/// that of `best`, the best one so far, or, unless its score is significant, cannot exceed chance.
pub(super) fn refitted(
    found: &mut Search,
    here: &FilterErrorFit,
    start: Start,
    best: Option<&Contender>,
    task: &Task<'_>,
) -> Option<Contender> {
    let Start { candidate, score } = start;
    let is_sure = score.log_p < found.screen.threshold;
    // a candidate whose score is significant may have far to go
    let needed = if is_sure { f64::NEG_INFINITY } else { beyond_chance(found.screen.threshold, score.parameters) };
    let rough = FilterErrorOptions { tolerance: ROUGH, bar: bar(here, best, needed), ..beside(here, task) };
    let mut model = nearest(&candidate, here, &score, task)?;
    let won = |fit: FilterErrorFit| (here.cost - fit.cost, fit);
    let near = (!is_hopeless(here, task.train)).then(|| from_here(found, here, &mut model, &rough, task));
    let far = match &near {
        Some(Ok(fit)) => here.cost - fit.cost,
        Some(Err(OutputErrorError::GivenUp { cost, .. })) => here.cost - cost,
        Some(Err(_)) | None => f64::NEG_INFINITY,
    };
    let given_up = matches!(&near, Some(Err(OutputErrorError::GivenUp { .. })));
    let outdone = given_up && best.map_or(needed, |best| best.gain.max(needed)) > score.statistic;
    let near = near.and_then(Result::ok);
    // if the score is significant and the refit is not, something runs away, as the scale of all forces does if the
    // last model makes no use of the commands
    let lost = is_sure && near.as_ref().is_some_and(|fit| is_nothing(&here.model, &fit.model));
    let mut best = near.map(won);
    let falls_short = (far < PROMISE * score.statistic && !outdone) || lost || is_exchange(&candidate);
    if falls_short && !found.was_in_vain(&candidate) {
        match filter_error(&started(&model, task.train), task.train, &rough).map(won) {
            Ok(anew) if anew.0 > far => {
                found.astray |= anew.0 > far + TIE;
                best = Some(anew);
            }
            // beside another best candidate it might have continued
            Err(OutputErrorError::GivenUp { .. }) => {}
            _ => found.vain.push((candidate.clone(), found.steps.len())),
        }
    }
    let (gain, fit) = best?;
    Some(Contender { score, fit, gain, held_out: 0.0, held_out_cost: 0.0 })
}

/// Fits `model`, which contains a candidate, from the last one. A name of which nothing remains beside it is removed.
fn from_here(
    found: &Search,
    here: &FilterErrorFit,
    model: &mut Model,
    rough: &FilterErrorOptions,
    task: &Task<'_>,
) -> Result<FilterErrorFit, OutputErrorError> {
    let fitted = |model: &Model| filter_error_from(model, task.train, afresh(&here.noise), rough);
    let near = fitted(model);
    match near.as_ref().err().and_then(|error| nothing_beside(found, error)) {
        Some(lost) => {
            lost.remove_from(model);
            fitted(model)
        }
        None => near,
    }
}

/// The name that is no longer identified beside a candidate whose refit failed with `error`: it has stood in for that.
fn nothing_beside<'a>(found: &'a Search, error: &OutputErrorError) -> Option<&'a Candidate> {
    let OutputErrorError::NotIdentified { parameters, .. } = error else { return None };
    let model = &found.last_fit().model;
    let is_lost = |p: &&Parameter| parameters.contains(&p.full_name());
    let lost: Vec<&Parameter> = model.parameters.iter().filter(is_lost).collect();
    found.added.iter().map(|added| &added.candidate).find(|candidate| lost.iter().any(|p| candidate.holds(&p.term)))
}

/// The model of `fit` fitted from the log; `None` if that is no better. A fit that started at the values of a model
/// without a name may end in a local maximum of its own, where the rest is given wrong names. It is used if a
/// candidate remains beyond chance, or a random force that is too large for turbulence.
pub(super) fn anew(fit: &FilterErrorFit, task: &Task<'_>) -> Option<FilterErrorFit> {
    let anew = filter_error(&started(&fit.model, task.train), task.train, &level(task)).ok()?;
    (anew.plain < fit.plain - TIE).then_some(anew)
}

/// −2 ln L below which a candidate must come; its gain must be at least `needed`.
fn bar(here: &FilterErrorFit, best: Option<&Contender>, needed: f64) -> f64 {
    let hopeful = best.filter(|b| b.gain > 0.0).map(|best| HOPEFUL * (here.cost - best.fit.cost));
    here.cost - hopeful.unwrap_or(f64::NEG_INFINITY).max(needed)
}

/// Whether the candidate swaps two thrusters.
pub(super) fn is_exchange(candidate: &Candidate) -> bool {
    !candidate.has_parameters() && candidate.terms[0].0.about().scope == Scope::Thrusters
}

/// Options of a fit that is compared with another one: as that one, with the same limit for innovations.
pub(super) fn beside(other: &FilterErrorFit, task: &Task<'_>) -> FilterErrorOptions {
    FilterErrorOptions { limit: Some(other.limit), ..level(task) }
}

/// Options for both sides of a likelihood ratio: the same noise, with every force and no coloured part, the same
/// tolerance, and steps in turns, since whatever a baseline at its maximum has absorbed of the missing effect is slow
/// to leave again.
pub(super) fn level(task: &Task<'_>) -> FilterErrorOptions {
    FilterErrorOptions { refine: false, higher: f64::INFINITY, ..task.fitting.clone() }
}

/// Noise from which a fit with another name starts: forces at half of their value without it, because a true name
/// removes most of them.
pub(super) fn afresh(noise: &NoiseModel) -> NoiseModel {
    let mut fresh = noise.clone();
    fresh.forces.iter_mut().for_each(|f| f.rms *= 0.5);
    fresh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_worth_any_amount_are_told_apart_by_what_they_are_likely() {
        let standing = |own: f64, held_out: f64, cost: f64| Standing { worth: own + held_out, likely: own - cost };
        // of a campaign with two thrusters exchanged, on which the baseline runs away
        let mut names = [
            standing(22_795.0, f64::INFINITY, -14_892.0),
            standing(31_117.0, f64::INFINITY, -25_034.0),
            standing(23_354.0, f64::INFINITY, -15_094.0),
            standing(40_000.0, 9_000.0, -24_000.0),
        ];
        names.sort_by(Standing::before);
        assert_eq!(names.map(|s| s.likely), [56_151.0, 38_448.0, 37_687.0, 64_000.0]);
        // where it does not, what the name is worth decides
        let mut names = [standing(10.0, 50.0, -80.0), standing(90.0, 40.0, -10.0)];
        names.sort_by(Standing::before);
        assert_eq!(names.map(|s| s.worth), [130.0, 60.0]);
    }
}
