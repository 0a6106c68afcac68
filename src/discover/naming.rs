//! Steps 3 to 5 for one name: the best few of a screen are refitted, and the best that passes all tests gets the name.
//!
//! ```text
//! p(−2 ln L(without) + 2 ln L(with)) ≤ level over all candidates;   held-out runs agree;   no rule of nature is broken
//! ```

use std::collections::VecDeque;

use super::candidate::{Candidate, spoken_for};
use super::focus::{Start, higher, starts};
use super::held_out::{HeldOut, NOT_SHOWN, agree};
use super::pushed::{is_hopeless, is_slow, is_slow_within_a_run, pushed_hard};
use super::refit::{Contender, anew, is_exchange, level, merit, refitted};
use super::rivalry::{may_replace, missing_beside};
use super::rules::{BEYOND, broken, brought, is_apart};
use super::screen::{Score, log_survival};
use super::searched::{Added, BehavesLike, Search};
use super::slow_force;
use super::task::{TIE, Task};
use crate::effects::{Family, Scope};
use crate::estimate::filter_error::{FilterErrorFit, filter_error_from};
use crate::estimate::output_error::OutputErrorError;
use crate::model::{Model, Parameter, name_of};
use crate::progress;
use crate::units::Dimension;
use crate::wording::LEAST_P;

/// Number of candidates refitted in full: in simulation the truth was among the best four, for a real glider fifth.
const REFITS: usize = 6;

/// ln of the factor (20) by which a screened p-value may exceed the threshold: a full refit may still bring it below.
const NEARLY: f64 = 3.0;

/// Number of rivals of a name that are tested again once another name is known.
const RIVALS: usize = 2;

/// Returns the next name that passes all tests, with its fit.
///
/// A candidate with its own value in every run follows anything that comes and goes, so it is tested last. But whether
/// a named effect differs from run to run is tested at once, before other names stand in for the difference.
pub(super) fn next_name(
    found: &mut Search,
    task: &Task<'_>,
) -> Result<Option<(Added, FilterErrorFit)>, OutputErrorError> {
    for asked in [Asked::InStead, Asked::Common, Asked::Own] {
        let any = found.candidates.iter().any(|c| asked.of(c, &found.added));
        if let Some(next) = if any { name_among(found, task, asked)? } else { None } {
            return Ok(Some(next));
        }
    }
    Ok(None)
}

/// Groups of candidates that are tested together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Asked {
    /// Those that would replace a name, with values of their own in every run.
    InStead,
    /// Those with one value for all runs.
    Common,
    /// Those with a value of their own in every run.
    Own,
}

impl Asked {
    fn of(self, candidate: &Candidate, added: &[Added]) -> bool {
        let former = || candidate.in_stead_of.as_ref().map(|(effect, place)| name_of(effect.about().id, *place));
        match self {
            Asked::InStead => former().is_some_and(|former| added.iter().any(|a| a.candidate.holds(&former))),
            Asked::Common => !candidate.has_own_values(),
            Asked::Own => candidate.has_own_values(),
        }
    }
}

/// The best name that passes all tests, among the candidates that are `asked`.
///
/// The runs of the fit and the held-out runs decide together: if a random force has absorbed most of the missing
/// effect, the runs of the fit alone cannot decide between a name and similar ones.
fn name_among(
    found: &mut Search,
    task: &Task<'_>,
    asked: Asked,
) -> Result<Option<(Added, FilterErrorFit)>, OutputErrorError> {
    let here = found.last_fit().clone();
    let (threshold, hopeless) = (found.screen.threshold, is_hopeless(&here, task.train));
    let is_asked = |score: &Score| {
        let candidate = &found.candidates[score.candidate];
        let of_kind = asked.of(candidate, &found.added) && (!hopeless || candidate.family() == Family::Actuator);
        of_kind && candidate.is_possible(score)
    };
    let mut best = found.screen.best_probes_among(is_asked);
    best.retain(|score| score.log_p < threshold + NEARLY);
    // two swapped thrusters leave a baseline whose scores mean little: every pair is refitted
    let (first, later) = best.split_at(best.len().min(REFITS));
    let exchanged = later.iter().copied().filter(|score| is_exchange(&found.candidates[score.candidate]));
    let mut best: Vec<Score> = first.iter().copied().chain(exchanged).cloned().collect();
    let slow = if asked == Asked::Common { is_slow } else { is_slow_within_a_run };
    best.extend(slow_force::hidden(found, &best, is_asked, slow, task)?);
    let mut contenders: Vec<Contender> = Vec::new();
    let beyond = |c: &Contender| log_survival(c.gain, c.score.parameters) <= threshold;
    let mut starts: VecDeque<Start> = starts(&here, &best, &found.candidates, task).into();
    while let Some(start) = starts.pop_front() {
        progress::tell("refitting the best candidates", contenders.len(), best.len());
        let best = contenders.iter().max_by(|a, b| a.gain.total_cmp(&b.gain));
        let before = best.map_or(0.0, |best| best.gain);
        let Some(contender) = refitted(found, &here, start, best, task) else { continue };
        if contender.gain > before && beyond(&contender) {
            let left: Vec<Candidate> = starts.iter().map(|start| start.candidate.clone()).collect();
            let mut may = may_replace(&contender, &here, &left, threshold, task).into_iter();
            let promises = |start: &Start| start.score.statistic > contender.gain || is_exchange(&start.candidate);
            starts.retain(|start| may.next().unwrap_or(true) || promises(start));
        }
        match contenders.iter_mut().find(|known| known.score.candidate == contender.score.candidate) {
            Some(known) if known.gain < contender.gain => *known = contender,
            Some(_) => {}
            None => contenders.push(contender),
        }
    }
    contenders.retain_mut(|c| {
        beyond(c) && {
            c.gain = merit(&here, &c.fit, c.gain);
            beyond(c)
        }
    });
    let (mut names, mut unjudged): (Vec<Contender>, Option<Contender>) = (Vec::new(), None);
    for mut contender in contenders {
        let candidate = &found.candidates[contender.score.candidate];
        let HeldOut { gain, cost, against } = agree(candidate, &here, &contender.fit, task)?;
        (contender.held_out, contender.held_out_cost) = (gain, cost);
        match broken(&here.model, &contender.fit, candidate).or(against) {
            None => names.push(contender),
            Some(why) => {
                let is_unjudged = why == NOT_SHOWN;
                found.behaves_like.push(BehavesLike { id: candidate.name(), why, gain: contender.gain });
                if is_unjudged && unjudged.as_ref().is_none_or(|best| best.gain < contender.gain) {
                    unjudged = Some(contender);
                }
            }
        }
    }
    if let Some(best) = &unjudged {
        without_stand_ins(&mut names, best, &found.candidates, threshold, task);
    }
    let of_thruster = |c: &Contender| found.candidates[c.score.candidate].terms[0].0.about().scope == Scope::Thrusters;
    let makes_thrust = |c: &Contender| makes_thrust(&here.model, &c.fit.model, of_thruster(c));
    let standing = |c: &Contender| c.standing(if makes_thrust(c) { TIE } else { 0.0 });
    names.sort_by(|a, b| standing(a).before(&standing(b)));
    simplest_first(&mut names, &here.model, task.options.level);
    let name_of = |c: &Contender| found.candidates[c.score.candidate].name();
    let added = |c: &Contender| Added {
        candidate: found.candidates[c.score.candidate].clone(),
        also_possible: spoken_for(&name_of(c)).collect(),
        gain: c.gain,
        p_value: p_of_all(log_survival(c.gain, c.score.parameters), threshold, task.options.level),
        held_out_gain: c.held_out,
        left: c.score.left,
        rivals: Vec::new(),
    };
    for (k, first) in names.iter().enumerate() {
        let top = match at_the_top(first, &here, &found.candidates[first.score.candidate], task)? {
            Ok(top) => top,
            Err(why) => {
                found.behaves_like.push(BehavesLike { id: name_of(first), why, gain: first.gain });
                continue;
            }
        };
        let (mut named, fit) = (added(&top), top.fit);
        let pushed = !pushed_hard(&fit.noise.forces, task.train).is_empty();
        let fit = match pushed.then(|| anew(&fit, task)).flatten() {
            Some(better) => {
                found.astray = true;
                better
            }
            None => fit,
        };
        let others = &names[k + 1..];
        let tied = others.iter().filter(|other| standing(first).worth - other.standing(0.0).worth < TIE).map(name_of);
        named.also_possible.extend(tied);
        named.rivals = others.iter().take(RIVALS).map(|c| (added(c), c.fit.model.clone())).collect();
        return Ok(Some((named, fit)));
    }
    Ok(None)
}

/// Refits a contender to convergence, with its shape where it is likeliest once the name is known, or returns the
/// reason why it is no name there. A parameter that the rough refit left may vanish, and a higher maximum is judged
/// like the first one.
fn at_the_top(
    rough: &Contender,
    here: &FilterErrorFit,
    candidate: &Candidate,
    task: &Task<'_>,
) -> Result<Result<Contender, String>, OutputErrorError> {
    let tight = filter_error_from(&rough.fit.model, task.train, rough.fit.noise.clone(), &level(task));
    let (fit, score) = match tight {
        Ok(fit) => (fit, rough.score.clone()),
        Err(error) => return Ok(Err(format!("next to the rest of the model it is not determined: {error}"))),
    };
    let Some(fit) = higher(&here.model, &fit, candidate, task.train, &level(task)) else {
        let Contender { gain, held_out, held_out_cost, .. } = *rough;
        return Ok(Ok(Contender { score, fit, gain, held_out, held_out_cost }));
    };
    let HeldOut { gain: held_out, cost: held_out_cost, against } = agree(candidate, here, &fit, task)?;
    let gain = merit(here, &fit, here.cost - fit.cost);
    Ok(match broken(&here.model, &fit, candidate).or(against) {
        Some(why) => Err(why),
        None => Ok(Contender { score, fit, gain, held_out, held_out_cost }),
    })
}

/// Removes names that gain less than `best`, which no held-out run shows, and that are not missing beside it. They
/// stand in for it, and held-out runs confirm them only because they bias the rest of the model less.
fn without_stand_ins(
    names: &mut Vec<Contender>,
    best: &Contender,
    candidates: &[Candidate],
    threshold: f64,
    task: &Task<'_>,
) {
    let lesser: Vec<Candidate> =
        names.iter().filter(|c| c.gain < best.gain).map(|c| candidates[c.score.candidate].clone()).collect();
    if lesser.is_empty() {
        return;
    }
    let mut missing = missing_beside(best, &lesser, threshold, task).into_iter();
    names.retain(|c| c.gain >= best.gain || missing.next().unwrap_or(true));
}

/// Puts first a name that has fewer parameters and explains the runs of the fit as well, if the extra parameters of
/// the first name are insignificant: the offset of a compass before a deviation that does not depend on the heading.
/// The errors of those parameters may have put the other first, on a held-out run of a vehicle that turns by itself.
fn simplest_first(names: &mut [Contender], before: &Model, level: f64) {
    let Some((first, others)) = names.split_first() else { return };
    let counts = brought(before, &first.fit.model).into_iter().filter(|p| is_apart(p)).count();
    let is_simpler = |c: &Contender| {
        let more = first.score.parameters.saturating_sub(c.score.parameters);
        more > 0 && counts <= c.score.parameters && log_survival(first.gain - c.gain, more) > level.ln()
    };
    if let Some(k) = others.iter().position(is_simpler) {
        names[..=k + 1].rotate_right(1);
    }
}

/// Whether a thrust scale that a name adds is above one, or the lost share of one thruster (`of_thruster`) below
/// zero, by more than three standard deviations. Thrust is lost on its way to the water more often than gained. If
/// the inertias are free, a scale of one degree of freedom makes up for a loss in any other; if one of two thrusters
/// has lost a third, the other looks half as strong again. Such a name comes last among names for one signal.
fn makes_thrust(before: &Model, after: &Model, of_thruster: bool) -> bool {
    let is_share = |p: &&Parameter| p.spec.is_linear() && p.spec.dimension == Dimension::ONE;
    let made = |p: &Parameter| match (p.spec.neutral > 0.0, of_thruster) {
        (true, _) => p.value - p.spec.neutral,
        (false, true) => -p.value,
        (false, false) => 0.0,
    };
    let new = brought(before, after).into_iter().filter(is_share);
    new.into_iter().any(|p| made(p) > BEYOND * p.std.unwrap_or(f64::INFINITY))
}

/// Probability over all candidates, counted as the number of independent ones that the threshold implies. Never 0,
/// which no data can show: [`LEAST_P`] replaces everything below it.
pub(super) fn p_of_all(log_p: f64, threshold: f64, level: f64) -> f64 {
    (level * (log_p - threshold).exp()).clamp(LEAST_P, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::frame::Dof;

    #[test]
    fn a_scale_above_one_makes_thrust_and_one_below_loses_it() {
        let before = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia"]).unwrap();
        let mut after =
            Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "thrust_interaction_loss"]).unwrap();
        let scale = after.parameter_of("thrust_interaction_loss@surge").unwrap();
        let mut with = |value: f64, std: f64| {
            (after.parameters[scale].value, after.parameters[scale].std) = (value, Some(std));
            makes_thrust(&before, &after, false)
        };
        assert!(with(2.0, 0.02));
        assert!(!with(1.05, 0.02), "chance");
        assert!(!with(0.7, 0.02));
        // lost share of a thruster: below zero thrust is gained
        after.parameters[scale].spec.neutral = 0.0;
        let mut lost = |share: f64, of_thruster: bool| {
            after.parameters[scale].value = share;
            makes_thrust(&before, &after, of_thruster)
        };
        assert!(lost(-0.45, true) && !lost(0.3, true) && !lost(-0.01, true));
        assert!(!lost(-0.45, false), "of what is no thruster's");
        let drag = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        assert!(!makes_thrust(&before, &drag, false));
    }
}
