//! The search, step by step as in a paper:
//!
//! 1. the baseline is fitted by filter error, its noise included;
//! 2. one pass scores every absent effect ([`super::screen`]);
//!    if the data contradict what the commands do between their rows, the search goes on with the other interpolation
//!    ([`super::between_rows`]);
//!    if an effect that begins at an instant explains more than any effect present throughout, and nothing remains, it
//!    is the answer ([`super::appeared`]);
//! 3. the best few are refitted with the noise free ([`super::naming`], [`super::refit`]); the likelihood ratio
//!    decides, at the same probability of a false name;
//! 4. held-out runs must agree ([`super::held_out`]);
//! 5. a name needs physics ([`super::rules`]): an effect that helps but breaks a rule is reported as "behaves like";
//! 6. each name is tested again once another is known ([`super::again`]), and against its runners-up; the noise starts
//!    afresh with every name, because a random force that was estimated without it would stay inflated and bias the
//!    parameters;
//!
//! and again from 2 until no candidate is beyond chance.

use super::again::{backward, rivalled};
use super::appeared::{all_along, appeared_first};
use super::between_rows::{held_instead, otherwise, otherwise_delayed};
use super::candidate::Candidate;
use super::constancy::likelier;
use super::naming::next_name;
use super::pushed::is_hopeless;
use super::refit::{anew, beside, level};
use super::rules::broken;
use super::screen::{INDISTINGUISHABLE, Screen};
use super::searched::{Added, BEHAVES, Search, Step};
use super::stepped::stepped;
use super::task::{Task, asked, screened};
use super::timed;
use crate::estimate::filter_error::{FilterErrorFit, filter_error_from};
use crate::estimate::moved_by_thrust;
use crate::estimate::output_error::OutputErrorError;
use crate::model::{Model, name_of};
use crate::progress;

/// Maximum number of steps per allowed name: a name may be added and removed again.
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
        // rounding decides whether a fit that has run away is reported as not identified
        Ok(fit) if is_beyond(&fit.model, &bounded) => fitted(&bounded).unwrap_or(fit),
        fit => fit?,
    };
    let mut fit = at_rest(fit, task);
    let mut list = asked(&fit.model, task);
    let mut screen = screened(&fit, &list, task)?;
    if let Some(other) = otherwise(&fit, (&list, &screen), task) {
        fit = at_rest(other, task);
        list = asked(&fit.model, task);
        screen = screened(&fit, &list, task)?;
    }
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
    // one force of several that weaken together may explain most of it
    let is_open = found.screen.asks() && found.appeared.as_ref().is_none_or(|appeared| !appeared.alone);
    if is_open && !is_hopeless(found.last_fit(), task.train) {
        let scored = (&found.candidates[..], &found.screen);
        let stepped = stepped((found.last_fit(), scored), task, all_along(scored))?;
        found.appeared = likelier(found.appeared.take(), stepped);
    }
    if found.appeared.is_some() {
        return Ok(found);
    }
    while found.added.len() < task.options.most && found.steps.len() < TURNS * task.options.most {
        let Some((added, fit)) = next_name(&mut found, task)? else { break };
        progress::tell(format!("found {}", added.candidate.name()), found.added.len() + 1, 0);
        let removed = found.removed.len();
        if let Some(held) = held_instead(found.last_fit(), &fit, task) {
            if let Some(step) = found.steps.last_mut() {
                step.fit = held;
            }
            (found.candidates, found.screen) = asked_beside(&found, task)?;
            continue;
        }
        let is_delay = added.candidate.terms.iter().any(|(effect, _)| effect.delays_command().is_some());
        let fit = Some(&fit).filter(|_| is_delay).and_then(|fit| otherwise_delayed(fit, task)).unwrap_or(fit);
        found.take(added, fit);
        // beside a baseline that has not converged any name gains: test the newest too, as the fit without it has
        // improved since
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
    // an effect that is named already, in the same form or with its own value in every run, is not reported as another
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

/// Continues the fit of the baseline until it converges or a few further climbs bring no gain: what the baseline could
/// still gain by itself would otherwise count as the gain of the first name.
fn at_rest(mut fit: FilterErrorFit, task: &Task<'_>) -> FilterErrorFit {
    /// Maximum number of climbs by which a fit is continued.
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

/// Candidates beside the names found so far, and their scores.
fn asked_beside(found: &Search, task: &Task<'_>) -> Result<(Vec<Candidate>, Screen), OutputErrorError> {
    let fit = found.last_fit();
    let mut list = asked(&fit.model, task);
    // a name that broke a rule beside the others would be added and removed again
    list.retain(|c| !found.removed.contains(&c.name()) || found.behaves_like.iter().all(|b| b.id != c.name()));
    let screen = screened(fit, &list, task)?;
    Ok((list, screen))
}

/// Refines the noise of the last fit: removes random forces that are none, and makes sensor noise coloured where it
/// is. If some noise is coloured, or a name now breaks a rule of physics, every name is tested again.
fn refine(found: &mut Search, task: &Task<'_>) {
    progress::tell("estimating the noise of the last model", 0, 0);
    let last = found.last_fit();
    // if a parameter is no longer identified with coloured noise, the noise stays as it was
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

/// Adds to the newest effect's alternatives those candidates that it has made indistinguishable from the model: a
/// candidate that had a signal of its own before and has none now is the same effect to this data.
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

/// Whether a parameter of `model` exceeds its upper bound in `bounded`.
fn is_beyond(model: &Model, bounded: &Model) -> bool {
    model.parameters.iter().zip(&bounded.parameters).any(|(p, bounded)| p.value > bounded.max)
}
