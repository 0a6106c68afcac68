//! The search, as a section of a paper:
//!
//! 1. the baseline is fitted by filter error, its noise included;
//! 2. one pass scores every absent effect ([`super::screen`]);
//! 3. the best few are refitted with the noise free ([`super::refit`]); the likelihood ratio decides, against the same chance
//!    of a false name;
//! 4. runs that took no part must agree ([`super::held_out`]);
//! 5. a name needs physics ([`super::rules`]): what helps but breaks a rule is told as "behaves like";
//! 6. each name is put to the test again once another is known ([`super::again`]), and against those that came second to it;
//!    the noise starts afresh with every name, because a random force that was estimated without it would stay inflated and
//!    bend the parameters;
//!
//! and again from 2 until no candidate is beyond chance.

use std::collections::VecDeque;
use std::sync::Arc;

use super::again::{backward, rivalled};
use super::candidate::{Candidate, candidates, spoken_for};
use super::focus::{Start, starts};
use super::held_out::{HeldOut, agree};
use super::refit::{Contender, anew, is_exchange, level, merit, refitted};
use super::rivalry::may_replace;
use super::rules::{BEYOND, broken, brought, is_apart};
use super::screen::{INDISTINGUISHABLE, Score, Screen, log_survival, screen};
use super::slow_force;
use super::timed::begun;
use super::verdict::{overwhelmed, pushed_hard};
use crate::effects::{Effect, Family, Place, Scope, named};
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions, filter_error, filter_error_from};
use crate::estimate::moved_by_thrust;
use crate::estimate::output_error::OutputErrorError;
use crate::model::{Model, Parameter};
use crate::progress;
use crate::run::{Run, commanded_rms};
use crate::units::Dimension;

/// How the search is done.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchOptions {
    /// Probability of a name where nothing is missing, before held-out runs are asked.
    pub level: f64,
    /// Greatest number of effects to add.
    pub most: usize,
    /// Families of the catalogue that are searched; users' own effects always are.
    pub families: Vec<Family>,
    /// Seed of what is drawn by chance.
    pub seed: u64,
}

impl Default for SearchOptions {
    fn default() -> SearchOptions {
        let families = vec![Family::Body, Family::Actuator, Family::Environment, Family::Sensor];
        SearchOptions { level: 0.01, most: 5, families, seed: 1 }
    }
}

/// Candidates that are refitted in full: the truth was among the best four in simulation, and the fifth of a real glider.
const REFITS: usize = 6;

/// Names within this of −2 ln L are both possible: three deviations of the difference of two names for one signal.
pub(super) const TIE: f64 = 9.0;

/// A screened p-value that is this many times too great may be right in full: ln 20.
const NEARLY: f64 = 3.0;

pub use crate::wording::LEAST_P;

/// Rivals of a name that are asked again once another name is known.
const RIVALS: usize = 2;

/// Names that broke a rule and are told.
pub(super) const BEHAVES: usize = 2;

/// An effect that was added.
#[derive(Debug, Clone)]
pub struct Added {
    /// The candidate.
    pub candidate: Candidate,
    /// Names of the others that the data allow.
    pub also_possible: Vec<String>,
    /// Fall of −2 ln L by the refit.
    pub gain: f64,
    /// Probability of as much by chance, of all candidates.
    pub p_value: f64,
    /// Fall of −2 ln L on the runs that took no part.
    pub held_out_gain: f64,
    /// Share of its signal that a refit of the model leaves.
    pub left: f64,
    /// What came second to it and broke no rule, each with the model that held it in its stead.
    pub(super) rivals: Vec<(Added, Model)>,
}

/// What helped and broke a rule.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct BehavesLike {
    /// `id`, `id@dof` or `id@dof:other`.
    pub id: String,
    /// Which rule, in words.
    pub why: String,
    /// Fall of −2 ln L.
    pub gain: f64,
}

impl BehavesLike {
    /// `behaves like the Munk moment (coriolis_yaw), but …`.
    pub fn told(&self) -> String {
        format!("behaves like {}, but {}", named(&self.id), self.why)
    }
}

/// One state of the search.
#[derive(Debug, Clone)]
pub struct Step {
    /// Name of what was added; `None` for the baseline.
    pub name: Option<String>,
    /// The fit.
    pub fit: FilterErrorFit,
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
    /// What helped and broke a rule, the most helpful first.
    pub behaves_like: Vec<BehavesLike>,
    /// Whether a fit from the log was better than one from the last model: that one was far from the truth.
    pub astray: bool,
    /// Whether what moves the vehicle is not its commands: nothing is named then.
    pub hopeless: bool,
    /// Candidates at the last step.
    pub candidates: Vec<Candidate>,
    /// Their scores.
    pub screen: Screen,
}

impl Search {
    /// Whether the greatest number of names has ended it while another candidate was beyond chance.
    pub fn is_cut_short(&self, options: &SearchOptions) -> bool {
        self.added.len() >= options.most && self.screen.asks()
    }

    /// The final fit.
    pub fn last_fit(&self) -> &FilterErrorFit {
        &self.steps[self.steps.len() - 1].fit
    }
}

/// What the search works on.
pub(super) struct Task<'a> {
    pub train: &'a [Run],
    pub held: &'a [Run],
    pub own: &'a [(Arc<dyn Effect>, Place)],
    pub fitting: &'a FilterErrorOptions,
    pub options: &'a SearchOptions,
}

/// Searches for what `baseline` lacks.
///
/// # Errors
/// [`OutputErrorError`] when the baseline cannot be fitted.
pub(super) fn search(baseline: &Model, task: &Task<'_>) -> Result<Search, OutputErrorError> {
    progress::tell("fitting the baseline", 0, 0);
    let fitted =
        |model: &Model| filter_error(&begun(model, task.train, task.fitting, task.options), task.train, &level(task));
    let fit = match fitted(baseline) {
        Err(OutputErrorError::NotIdentified { .. }) => fitted(&moved_by_thrust(baseline, task.train))?,
        fit => fit?,
    };
    let list = asked(&fit.model, task);
    let screen = screened(&fit, &list, task)?;
    let mut found = Search {
        steps: vec![Step { name: None, fit }],
        added: Vec::new(),
        removed: Vec::new(),
        behaves_like: Vec::new(),
        astray: false,
        hopeless: false,
        candidates: list,
        screen,
    };
    while found.added.len() < task.options.most {
        let Some((added, fit)) = next_name(&mut found, task)? else { break };
        progress::tell(format!("found {}", added.candidate.name()), found.added.len() + 1, 0);
        found.steps.push(Step { name: Some(added.candidate.name()), fit });
        found.added.push(added);
        let earlier = found.added.len() - 1;
        rivalled(&mut found, task, earlier)?;
        backward(&mut found, task, earlier);
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
    found.hopeless = is_hopeless(found.last_fit(), task);
    if !found.hopeless {
        refine(&mut found, task);
    }
    found.behaves_like.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    found.behaves_like.dedup_by(|a, b| a.id == b.id);
    let named: Vec<String> = found.added.iter().map(|a| a.candidate.name()).collect();
    found.behaves_like.retain(|b| !named.contains(&b.id));
    found.behaves_like.truncate(BEHAVES);
    Ok(found)
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

/// Whether what moves the vehicle is not its commands, in half of the degrees of freedom that are commanded or more: nothing
/// tells a force from the inertia there, and fits go astray for hours. Only what is done with the commands may mend it: two
/// thrusters that are exchanged make nonsense of them.
pub(super) fn is_hopeless(fit: &FilterErrorFit, task: &Task<'_>) -> bool {
    let commanded = fit.model.dofs.iter().filter(|dof| commanded_rms(task.train, **dof).is_some()).count();
    let lost = overwhelmed(&fit.noise.forces, task.train).len();
    lost > 0 && 2 * lost >= commanded
}

pub(super) fn screened(fit: &FilterErrorFit, list: &[Candidate], task: &Task<'_>) -> Result<Screen, OutputErrorError> {
    progress::tell(format!("judging {} candidates", list.len()), 0, 0);
    screen(fit, task.train, list, &task.fitting.base, (task.options.level, task.options.seed))
}

/// The candidates of the families that are searched, and the user's own.
pub(super) fn asked(model: &Model, task: &Task<'_>) -> Vec<Candidate> {
    let mut list = candidates(model, task.train, task.own);
    // thrusters come with the campaign, too, but their effects are those of the catalogue
    let of_user = |c: &Candidate| {
        let about = c.terms[0].0.about();
        about.scope != Scope::Thrusters && task.own.iter().any(|(effect, _)| effect.about().id == about.id)
    };
    list.retain(|c| task.options.families.contains(&c.family()) || of_user(c));
    list
}

/// Whether a parameter of a candidate has a value of its own in every run.
pub(super) fn has_own_values(candidate: &Candidate) -> bool {
    candidate.terms.iter().any(|(effect, place)| effect.parameters(*place).iter().any(|spec| spec.per_run))
}

/// The last fit with its noise refined: forces that are none taken out, sensors coloured where they are. Where there are
/// colours, every name is put to the test again.
fn refine(found: &mut Search, task: &Task<'_>) {
    progress::tell("the noise of the last model", 0, 0);
    let last = found.last_fit();
    // where a parameter is lost among the colours the noise stays as plain as it was
    let Ok(refined) = filter_error_from(&last.model, task.train, last.noise.clone(), task.fitting) else { return };
    let coloured = refined.noise.coloured().next().is_some();
    if let Some(step) = found.steps.last_mut() {
        step.fit = refined;
    }
    if coloured {
        backward(found, task, found.added.len());
    }
}

/// The next name that survives everything, with its fit.
///
/// What has a value of its own in every run follows anything that comes and goes: it is asked when nothing else is left.
fn next_name(found: &mut Search, task: &Task<'_>) -> Result<Option<(Added, FilterErrorFit)>, OutputErrorError> {
    match name_among(found, task, false)? {
        Some(next) => Ok(Some(next)),
        None => name_among(found, task, true),
    }
}

/// The best name that survives everything, of candidates with (`own`) or without a value of their own in every run.
///
/// The runs of the fit and those that took no part are asked together: a random force that has taken up most of what is
/// missing leaves the first undecided between a name and its like.
fn name_among(
    found: &mut Search,
    task: &Task<'_>,
    own: bool,
) -> Result<Option<(Added, FilterErrorFit)>, OutputErrorError> {
    let here = found.last_fit().clone();
    let (threshold, hopeless) = (found.screen.threshold, is_hopeless(&here, task));
    let mut best = found.screen.best_probes();
    let is_asked = |score: &Score| {
        let candidate = &found.candidates[score.candidate];
        let of_kind = has_own_values(candidate) == own && (!hopeless || candidate.family() == Family::Actuator);
        of_kind && candidate.is_possible(score)
    };
    best.retain(|score| score.log_p < threshold + NEARLY && is_asked(score));
    // two thrusters that are exchanged leave a baseline of which scores say little: each two of them are asked
    let (first, later) = best.split_at(best.len().min(REFITS));
    let exchanged = later.iter().copied().filter(|score| is_exchange(&found.candidates[score.candidate]));
    let mut best: Vec<Score> = first.iter().copied().chain(exchanged).cloned().collect();
    best.extend(slow_force::hidden(found, &best, is_asked, task)?);
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
    let mut names: Vec<Contender> = Vec::new();
    for mut contender in contenders {
        let candidate = &found.candidates[contender.score.candidate];
        let HeldOut { gain, cost, against } = agree(&here, &contender.fit, task)?;
        (contender.held_out, contender.held_out_cost) = (gain, cost);
        match broken(&here.model, &contender.fit, candidate).or(against) {
            None => names.push(contender),
            Some(why) => {
                found.behaves_like.push(BehavesLike { id: candidate.name(), why, gain: contender.gain });
            }
        }
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
    let tight = |c: &Contender| filter_error_from(&c.fit.model, task.train, c.fit.noise.clone(), &level(task));
    for (k, first) in names.iter().enumerate() {
        // what the rough refit has left between its neighbours may be nothing at the maximum
        let fit = match tight(first) {
            Ok(fit) => fit,
            Err(error) => {
                let why = format!("beside the rest of the model it is not determined: {error}");
                found.behaves_like.push(BehavesLike { id: name_of(first), why, gain: first.gain });
                continue;
            }
        };
        let pushed = !pushed_hard(&fit.noise.forces, task.train).is_empty();
        let fit = match pushed.then(|| anew(&fit, task)).flatten() {
            Some(better) => {
                found.astray = true;
                better
            }
            None => fit,
        };
        let others = &names[k + 1..];
        let mut named = added(first);
        let tied = others.iter().filter(|other| standing(first).worth - other.standing(0.0).worth < TIE).map(name_of);
        named.also_possible.extend(tied);
        named.rivals = others.iter().take(RIVALS).map(|c| (added(c), c.fit.model.clone())).collect();
        return Ok(Some((named, fit)));
    }
    Ok(None)
}

/// Puts before the first name one that has fewer parameters and explains the runs of the fit as well, where what the first has more
/// is nothing: the offset of a compass before a deviation that does not hang on the heading. By what those parameters are off it
/// may stand first on a held-out run of a vehicle that turns by itself.
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

/// Whether a scale of the thrust that a name brings is above one, or a share of one thruster (`of_thruster`) that is lost below
/// nothing, beyond three deviations. Thrust is lost on its way to the water more often than made; in a model whose inertias are
/// open the scale of one degree of freedom is what any of them lacks, and of two thrusters one that has lost a third leaves the
/// other half as strong again: of names for one signal it comes last.
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

/// The probability over all candidates: as many independent ones as the threshold stands for. Never 0, which no data can
/// say: [`LEAST_P`] stands for all that is below it.
pub(super) fn p_of_all(log_p: f64, threshold: f64, level: f64) -> f64 {
    (level * (log_p - threshold).exp()).clamp(LEAST_P, 1.0)
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
        // the share of a thruster that is lost: below nothing it is made
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
