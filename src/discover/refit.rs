//! Step 3: a candidate refitted in full, from where the last model is and, where that leads nowhere, from the log.
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

/// Share of the gain of the best candidate so far, below which another one is given up: neither runs that took no part nor a
/// second effect beside it make up for half.
const HOPEFUL: f64 = 0.5;

/// Share of the fall of −2 ln L that its score promised, below which a refit has ended on another hill and is begun anew
/// from the log: where the baseline is far from the truth its values are no start.
const PROMISE: f64 = 0.5;

/// Fall of −2 ln L that a parameter has to be worth beside another name's: Akaike's two, doubled because names are
/// chosen after looking.
const PENALTY: f64 = 4.0;

/// A candidate refitted in full.
pub(super) struct Contender {
    pub score: Score,
    pub fit: FilterErrorFit,
    pub gain: f64,
    /// Fall of −2 ln L on runs that took no part, and what it is there.
    pub held_out: f64,
    pub held_out_cost: f64,
}

/// What names are compared by.
#[derive(Clone, Copy)]
pub(super) struct Standing {
    /// Fall of −2 ln L, that of runs that took no part included, less the price of the parameters.
    pub worth: f64,
    /// The same with −2 ln L of those runs itself in place of its fall, which is infinite where the last model runs away there.
    likely: f64,
}

impl Standing {
    /// Which of two comes first: the one that is worth more, and of two that are worth any amount the likelier one.
    pub fn before(&self, other: &Standing) -> Ordering {
        other.worth.total_cmp(&self.worth).then_with(|| other.likely.total_cmp(&self.likely))
    }
}

impl Contender {
    /// Where it stands, less what `off` takes.
    pub fn standing(&self, off: f64) -> Standing {
        let own = self.gain - PENALTY * self.score.parameters as f64 - off;
        Standing { worth: own + self.held_out, likely: own - self.held_out_cost }
    }
}

/// By how much −2 ln L falls from one fit to another, less what the unknown beginnings of the runs make of it
/// ([`FilterErrorFit::of_beginnings`]).
pub(super) fn merit(from: &FilterErrorFit, to: &FilterErrorFit, gain: f64) -> f64 {
    gain - (from.of_beginnings() - to.of_beginnings())
}

/// A candidate refitted from where the last model is; and from the log, where that leads less far than its score promised, to
/// a name that is within three deviations of nothing, or two thrusters are exchanged, beside which nothing of the last model
/// is true. From the log alone where the last model is of a vehicle that its commands do not move. What promised less than
/// `best` has already gained from the last model, or than chance makes, is not begun anew: that model is a start, and what is left comes
/// up again. Nor is what has been begun anew in vain beside fewer names.
/// `None` where it has no hope of half of what `best`, the best one so far, has gained, nor, where its score promises
/// no more, of more than chance makes.
pub(super) fn refitted(
    found: &mut Search,
    here: &FilterErrorFit,
    start: Start,
    best: Option<&Contender>,
    task: &Task<'_>,
) -> Option<Contender> {
    let Start { candidate, score } = start;
    let is_sure = score.log_p < found.screen.threshold;
    // what its score is sure of may have far to go
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
    // what the score is sure of and the refit is not hangs on something that runs away, as the scale of all forces does where
    // the last model makes no use of the commands
    let lost = is_sure && near.as_ref().is_some_and(|fit| is_nothing(&here.model, &fit.model));
    let mut best = near.map(won);
    let falls_short = (far < PROMISE * score.statistic && !outdone) || lost || is_exchange(&candidate);
    if falls_short && !found.was_in_vain(&candidate) {
        match filter_error(&started(&model, task.train), task.train, &rough).map(won) {
            Ok(anew) if anew.0 > far => {
                found.astray |= anew.0 > far + TIE;
                best = Some(anew);
            }
            // beside another best one it might have gone on
            Err(OutputErrorError::GivenUp { .. }) => {}
            _ => found.vain.push((candidate.clone(), found.steps.len())),
        }
    }
    let (gain, fit) = best?;
    Some(Contender { score, fit, gain, held_out: 0.0, held_out_cost: 0.0 })
}

/// `model`, which has a candidate in it, fitted from where the last one is. Where nothing is left of a name that stands, that goes.
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

/// The name that stands of which nothing is left beside a candidate whose refit failed with `error`: it has stood in for that.
fn nothing_beside<'a>(found: &'a Search, error: &OutputErrorError) -> Option<&'a Candidate> {
    let OutputErrorError::NotIdentified { parameters, .. } = error else { return None };
    let model = &found.last_fit().model;
    let is_lost = |p: &&Parameter| parameters.contains(&p.full_name());
    let lost: Vec<&Parameter> = model.parameters.iter().filter(is_lost).collect();
    found.added.iter().map(|added| &added.candidate).find(|candidate| lost.iter().any(|p| candidate.holds(&p.term)))
}

/// The model of `fit` fitted from the log; `None` where that is no better. A fit that began at the values of a model that lacked
/// a name may end on a hill of its own, and what is left there is given other names: asked where a random force is left that is
/// no turbulence, or a candidate.
pub(super) fn anew(fit: &FilterErrorFit, task: &Task<'_>) -> Option<FilterErrorFit> {
    let anew = filter_error(&started(&fit.model, task.train), task.train, &level(task)).ok()?;
    (anew.plain < fit.plain - TIE).then_some(anew)
}

/// −2 ln L that a candidate has to come below, which has to gain as much as `needed`.
fn bar(here: &FilterErrorFit, best: Option<&Contender>, needed: f64) -> f64 {
    let hopeful = best.filter(|b| b.gain > 0.0).map(|best| HOPEFUL * (here.cost - best.fit.cost));
    here.cost - hopeful.unwrap_or(f64::NEG_INFINITY).max(needed)
}

/// Whether two thrusters are exchanged.
pub(super) fn is_exchange(candidate: &Candidate) -> bool {
    !candidate.has_parameters() && candidate.terms[0].0.about().scope == Scope::Thrusters
}

/// How a fit is done that is held against another one: as that was, with the same innovations held back.
pub(super) fn beside(other: &FilterErrorFit, task: &Task<'_>) -> FilterErrorOptions {
    FilterErrorOptions { limit: Some(other.limit), ..level(task) }
}

/// Both sides of a ratio of likelihoods have the same noise, every force and no colour, converge as tightly, and take their steps
/// in turns: what a baseline has taken up of what is missing at its top is slow to go.
pub(super) fn level(task: &Task<'_>) -> FilterErrorOptions {
    FilterErrorOptions { refine: false, higher: f64::INFINITY, ..task.fitting.clone() }
}

/// Noise from which a fit with another name starts: forces at half of what they were without it, because a name that is
/// true takes most of them away.
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
