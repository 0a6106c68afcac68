//! The search, as a section of a paper:
//!
//! 1. the baseline is fitted by filter error, its noise included;
//! 2. one pass scores every absent effect ([`super::screen`]);
//!    where one that begins at an instant tells more than any would all along, and leaves nothing, that is the answer
//!    ([`super::appeared`]);
//! 3. the best few are refitted with the noise free ([`super::naming`], [`super::refit`]); the likelihood ratio decides, against the
//!    same chance of a false name;
//! 4. runs that took no part must agree ([`super::held_out`]);
//! 5. a name needs physics ([`super::rules`]): what helps but breaks a rule is told as "behaves like";
//! 6. each name is put to the test again once another is known ([`super::again`]), and against those that came second to it;
//!    the noise starts afresh with every name, because a random force that was estimated without it would stay inflated and
//!    bend the parameters;
//!
//! and again from 2 until no candidate is beyond chance.

use super::again::{backward, rivalled};
use super::appeared::appeared_first;
use super::candidate::Candidate;
use super::naming::next_name;
use super::pushed::is_hopeless;
use super::refit::{anew, beside, level};
use super::rules::broken;
use super::screen::{INDISTINGUISHABLE, Screen};
use super::searched::{Added, BEHAVES, Search, Step};
use super::task::{Task, asked, screened};
use super::timed;
use crate::estimate::filter_error::{FilterErrorFit, filter_error_from};
use crate::estimate::moved_by_thrust;
use crate::estimate::output_error::OutputErrorError;
use crate::model::{Model, name_of};
use crate::progress;

/// Steps a name, at most: names that come and go.
const TURNS: usize = 4;

/// Searches for what `baseline` lacks.
///
/// # Errors
/// [`OutputErrorError`] when the baseline cannot be fitted.
pub(super) fn search(baseline: &Model, task: &Task<'_>) -> Result<Search, OutputErrorError> {
    progress::tell("fitting the baseline", 0, 0);
    let fitted = |model: &Model| timed::fitted(model, task.train, &level(task), task.options);
    let bounded = moved_by_thrust(baseline, task.train);
    let fit = match fitted(baseline) {
        Err(OutputErrorError::NotIdentified { .. }) => fitted(&bounded)?,
        // whether one that has run away is seen to be not identified, its rounding decides
        Ok(fit) if is_beyond(&fit.model, &bounded) => fitted(&bounded).unwrap_or(fit),
        fit => fit?,
    };
    let fit = at_rest(fit, task);
    let list = asked(&fit.model, task);
    let screen = screened(&fit, &list, task)?;
    let mut found = Search {
        steps: vec![Step { name: None, fit }],
        added: Vec::new(),
        removed: Vec::new(),
        behaves_like: Vec::new(),
        astray: false,
        appeared: None,
        hopeless: false,
        vain: Vec::new(),
        candidates: list,
        screen,
    };
    found.appeared = appeared_first(found.last_fit(), (&found.candidates, &found.screen), task)?;
    if found.appeared.is_some() {
        return Ok(found);
    }
    while found.added.len() < task.options.most && found.steps.len() < TURNS * task.options.most {
        let Some((added, fit)) = next_name(&mut found, task)? else { break };
        progress::tell(format!("found {}", added.candidate.name()), found.added.len() + 1, 0);
        let removed = found.removed.len();
        found.take(added, fit);
        // beside a baseline that is still on its way any name gains; without it the fit has come farther since
        let earlier = found.added.len() - usize::from(found.steps[0].fit.converged);
        rivalled(&mut found, task, earlier)?;
        backward(&mut found, task, earlier);
        if found.removed.len() > removed {
            found.vain.clear();
        }
        let (mut list, mut screen) = asked_beside(&found, task)?;
        if let Some(better) = screen.asks().then(|| anew(found.last_fit(), task)).flatten() {
            found.astray = true;
            if let Some(step) = found.steps.last_mut() {
                step.fit = better;
            }
            (list, screen) = asked_beside(&found, task)?;
        }
        same_signal(&mut found, &list, &screen);
        (found.candidates, found.screen) = (list, screen);
    }
    found.hopeless = is_hopeless(found.last_fit(), task.train);
    if !found.hopeless {
        let names = found.added.len();
        refine(&mut found, task);
        if found.added.len() < names {
            (found.candidates, found.screen) = asked_beside(&found, task)?;
        }
    }
    found.behaves_like.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    found.behaves_like.dedup_by(|a, b| a.id == b.id);
    let named: Vec<String> = found.added.iter().map(|a| a.candidate.name()).collect();
    // what has a name in the same shape, or with values of its own in every run, is no other thing
    let same = found
        .added
        .iter()
        .flat_map(|a| &a.candidate.terms)
        .filter_map(|(effect, place)| Some(name_of(effect.same_in_all_runs()?, *place)));
    let known: Vec<String> = same.chain(named).collect();
    found.behaves_like.retain(|b| !known.contains(&b.id));
    found.behaves_like.truncate(BEHAVES);
    Ok(found)
}

/// The fit of the baseline where it has come to rest, or as far as some more climbs lead: what it would still gain by itself would
/// be the gain of the first name.
fn at_rest(mut fit: FilterErrorFit, task: &Task<'_>) -> FilterErrorFit {
    /// Climbs that a fit goes on for.
    const CLIMBS: usize = 4;
    for _ in 0..CLIMBS {
        if fit.converged {
            break;
        }
        match filter_error_from(&fit.model, task.train, fit.noise.clone(), &beside(&fit, task)) {
            Ok(further) if further.cost < fit.cost => fit = further,
            _ => break,
        }
    }
    fit
}

/// What is asked beside the names that stand, and its scores.
fn asked_beside(found: &Search, task: &Task<'_>) -> Result<(Vec<Candidate>, Screen), OutputErrorError> {
    let fit = found.last_fit();
    let mut list = asked(&fit.model, task);
    // what broke a rule beside the others would come again, and go again
    list.retain(|c| !found.removed.contains(&c.name()) || found.behaves_like.iter().all(|b| b.id != c.name()));
    let screen = screened(fit, &list, task)?;
    Ok((list, screen))
}

/// The last fit with its noise refined: forces that are none taken out, sensors coloured where they are. Where there are
/// colours, or a name is not what nature allows any more, every name is put to the test again.
fn refine(found: &mut Search, task: &Task<'_>) {
    progress::tell("the noise of the last model", 0, 0);
    let last = found.last_fit();
    // where a parameter is lost among the colours the noise stays as plain as it was
    let Ok(refined) = filter_error_from(&last.model, task.train, last.noise.clone(), task.fitting) else { return };
    let coloured = refined.noise.coloured().next().is_some();
    if let Some(step) = found.steps.last_mut() {
        step.fit = refined;
    }
    let fit = found.last_fit();
    let is_flawed = |added: &Added| broken(&added.candidate.taken_out_of(&fit.model), fit, &added.candidate).is_some();
    if coloured || found.added.iter().any(is_flawed) {
        backward(found, task, found.added.len());
    }
}

/// Lists with the effect that was added last those that it has made impossible to tell from the model: what had a signal
/// of its own before and has none any more is the same effect to this data.
fn same_signal(found: &mut Search, list: &[Candidate], now: &Screen) {
    let scored = |screen: &Screen, list: &[Candidate]| -> Vec<String> {
        screen.scores.iter().filter(|s| s.left >= INDISTINGUISHABLE).map(|s| list[s.candidate].name()).collect()
    };
    let (before, after) = (scored(&found.screen, &found.candidates), scored(now, list));
    let Some(newest) = found.added.last_mut() else { return };
    for name in before {
        let gone = !after.contains(&name) && list.iter().any(|c| c.name() == name);
        if gone && !newest.also_possible.contains(&name) && name != newest.candidate.name() {
            newest.also_possible.push(name);
        }
    }
}

/// Whether a parameter of `model` is beyond what it is kept below in `bounded`.
fn is_beyond(model: &Model, bounded: &Model) -> bool {
    model.parameters.iter().zip(&bounded.parameters).any(|(p, bounded)| p.value > bounded.max)
}
