//! Step 6: names are tested again once more is known.
//!
//! ```text
//! −2 ln L(without) − (−2 ln L(with))      beyond chance still, beside the others; and greater than with what came second
//! ```

use super::candidate::Candidate;
use super::held_out::fall;
use super::refit::{afresh, beside, merit};
use super::rules::broken;
use super::screen::log_survival;
use super::searched::{BehavesLike, Search};
use super::task::{TIE, Task};
use crate::estimate::filter_error::{FilterErrorFit, filter_error, filter_error_from};
use crate::estimate::output_error::OutputErrorError;
use crate::estimate::started;
use crate::model::{Model, Term};

/// Tries the runners-up to each of the first `count` names in its place once more is known: a lone name may have
/// absorbed the effect of two others.
pub(super) fn rivalled(found: &mut Search, task: &Task<'_>, count: usize) -> Result<(), OutputErrorError> {
    for k in 0..count {
        for (rival, mut model) in std::mem::take(&mut found.added[k].rivals) {
            let mut later = found.added[k + 1..].iter().map(|a| &a.candidate);
            if !later.all(|c| c.add_to(&mut model, c.probes.first().map_or(&[], Vec::as_slice)).is_ok()) {
                continue;
            }
            // names have been added or removed since it was a runner-up
            if !is_in_its_stead(&model, found.last_fit(), &found.added[k].candidate, &rival.candidate) {
                continue;
            }
            let (last, noise) = (found.last_fit(), afresh(&found.steps[k].fit.noise));
            let Ok(fit) = filter_error_from(&model, task.train, noise, &beside(last, task)) else { continue };
            let gain = merit(last, &fit, last.cost - fit.cost) + fall(last, &fit, task)?;
            let tied = gain.abs() < TIE;
            if gain > 0.0 {
                let former = std::mem::replace(&mut found.added[k], rival).candidate.name();
                found.added[k].also_possible.extend(tied.then(|| former.clone()));
                found.removed.push(former);
                if let Some(step) = found.steps.last_mut() {
                    step.fit = fit;
                }
                break;
            }
            found.added[k].also_possible.extend(tied.then(|| rival.candidate.name()));
        }
    }
    Ok(())
}

/// Whether `model` is that of `last` with `rival` in place of a name.
fn is_in_its_stead(model: &Model, last: &FilterErrorFit, name: &Candidate, rival: &Candidate) -> bool {
    let expected = name.taken_out_of(&last.model);
    let stands = |term: &Term| model.term(&term.name()).is_some();
    expected.terms.iter().all(stands) && expected.terms.len() + rival.terms.len() == model.terms.len()
}

/// Tests the first `count` names again once more is known. A name that is no longer worth its parameters, or whose
/// parameters now break a rule of physics, has stood in for something else.
pub(super) fn backward(found: &mut Search, task: &Task<'_>, mut count: usize) {
    let mut k = 0;
    while k < count {
        let name = found.added[k].candidate.name();
        let fit = found.last_fit();
        let level = beside(fit, task);
        let model = found.added[k].candidate.taken_out_of(&fit.model);
        let mut without = filter_error_from(&model, task.train, fit.noise.clone(), &level);
        if found.astray || without.is_err() {
            let anew = filter_error(&started(&model, task.train), task.train, &level);
            without = match (without, anew) {
                (Ok(near), Ok(anew)) => Ok(if anew.cost < near.cost { anew } else { near }),
                (near, anew) => near.or(anew),
            };
        }
        let gain = without.as_ref().map_or(f64::INFINITY, |without| merit(without, fit, without.cost - fit.cost));
        let unknowns = |fit: &FilterErrorFit| fit.filtered.problem.unknowns.len();
        let parameters = without.as_ref().map_or(1, |without| unknowns(fit).saturating_sub(unknowns(without)));
        let needed = log_survival(gain, parameters) <= found.screen.threshold;
        // even beside the others a name still needs physics
        let flaw = broken(&model, fit, &found.added[k].candidate);
        match (needed && flaw.is_none(), without) {
            (false, Ok(without)) => {
                found.added.remove(k);
                count -= 1;
                if let Some(last) = found.steps.last_mut() {
                    last.fit = without;
                }
                if let Some(why) = flaw.filter(|_| needed) {
                    found.behaves_like.push(BehavesLike { id: name.clone(), why, gain });
                }
                found.removed.push(name);
            }
            _ => k += 1,
        }
    }
}
