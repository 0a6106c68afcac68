//! Effects missing in the model that appear at an instant, or in one run alone: a failed thruster, a payload, a trim.
//!
//! ```text
//! α(t) = α·1(t ≥ t₀)          (α, t₀) = argmin −2 ln L, begun where z² of all parts of the log is greatest ([`super::parts`])
//! ```
//!
//! Searched if one part of the log tells more than the whole, or if the parameters of a last model make up for
//! something with different values in different parts of the log. An effect is reported if no change of a parameter of
//! the model explains as much, and if it is borne out as an event ([`super::begun`]).

use super::begun::{Beginning, Begun, Scored, What};
use super::candidate::Candidate;
use super::columns::{InBlocks, in_blocks};
use super::constancy::{ChangedParameter, changed};
use super::parts::{BLOCK, Greatest, LEVEL, Log, beyond, by_chance, divided};
use super::task::{TIE, Task};
use crate::chain::{Nature, memory_count, nature_at};
use crate::estimate::filter_error::FilterErrorFit;
use crate::estimate::output_error::OutputErrorError;
use crate::model::Model;
use crate::symbolic::Graph;

/// Number of effects that are refitted, the most significant first: a model that is biased by the new effect gives two
/// effects that act alike similar scores.
const REFITS: usize = 3;

/// Number of effects that are tested before anything is named, the least probable by chance first: an effect that
/// begins in the middle of a log also shows over all of it.
const LIKELY: usize = 12;

/// The effect of `list`, not in the model of `fit`, that has begun, if nothing is beyond chance beside it.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub(super) fn appeared(
    fit: &FilterErrorFit,
    scored: Scored<'_>,
    task: &Task<'_>,
) -> Result<Option<ChangedParameter>, OutputErrorError> {
    let list: Vec<Candidate> = scored.0.iter().filter(|c| may_begin(c, &fit.model)).cloned().collect();
    begun((fit, scored), &list, task, 0.0)
}

/// The same before anything is named: among the effects that show most over the whole log, one that gains more from an
/// instant on.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub(super) fn appeared_first(
    fit: &FilterErrorFit,
    (list, screen): Scored<'_>,
    task: &Task<'_>,
) -> Result<Option<ChangedParameter>, OutputErrorError> {
    if !screen.asks() {
        return Ok(None);
    }
    let best = screen.best_probes().into_iter().map(|score| &list[score.candidate]);
    let best: Vec<Candidate> = best.filter(|c| may_begin(c, &fit.model)).take(LIKELY).cloned().collect();
    begun((fit, (list, screen)), &best, task, all_along((list, screen)))
}

/// The greatest score of an effect that is present throughout: of `list`, without those that have a value of their own
/// in every run, which follow anything that comes and goes.
pub(super) fn all_along((list, screen): Scored<'_>) -> f64 {
    let same = screen.scores.iter().filter(|score| !list[score.candidate].has_own_values());
    same.map(|score| score.statistic).fold(0.0, f64::max)
}

/// The effect of `list` that has begun, with a z² beyond `least`.
fn begun(
    (fit, scored): (&FilterErrorFit, Scored<'_>),
    list: &[Candidate],
    task: &Task<'_>,
    least: f64,
) -> Result<Option<ChangedParameter>, OutputErrorError> {
    let InBlocks { probes, products } = in_blocks(fit.into(), task.train, list, &task.fitting.base, BLOCK)?;
    let (blocks, parts) = divided(fit, task.train, &products, probes.len());
    let estimated = fit.filtered.problem.unknowns.len();
    let all: Vec<usize> = (0..estimated + probes.len()).collect();
    let absent = all[estimated..].to_vec();
    let Some(log) = Log::of(blocks, parts, ((0..estimated).collect(), absent), fit.priors().collect()) else {
        return Ok(None);
    };
    let begun = |found: &Greatest| {
        let candidate = &list[probes[found.unknown - estimated].candidate];
        let (effect, place) = candidate.terms[0].clone();
        let beginning = Beginning { what: What::Effect(effect, place), start: -found.s / found.c, tie: None };
        let begun = Begun::at(log.parts[found.part].clone(), std::slice::from_ref(&beginning), fit, task)?;
        Some((found.z2, candidate, beginning, begun))
    };
    let first = log.own_of_each();
    let all = first.iter().take_while(|found| found.z2 > least).take(REFITS).filter_map(begun);
    let mut all: Vec<(f64, &Candidate, Beginning, Begun)> = all.collect();
    all.sort_by(|a, b| a.3.fit.cost.total_cmp(&b.3.fit.cost));
    let mut all = all.into_iter();
    let Some((z2, candidate, beginning, begun)) = all.next() else { return Ok(None) };
    // if two are equally good, neither is the answer
    if all.next().is_some_and(|(.., second)| second.fit.cost < begun.fit.cost + TIE) {
        return Ok(None);
    }
    let (begun, between) = begun.likeliest(&log.parts, task);
    let gain = fit.cost - begun.fit.cost;
    let chance = by_chance(1, (log.parts.len() * list.len()) as f64);
    // twice the limit of chance: near to it any effect absorbs a little of another one
    if gain < 2.0 * chance {
        return Ok(None);
    }
    let p_value = beyond(z2, &log.drawn(log.by_chance(task.options.seed)));
    if p_value >= LEVEL {
        return Ok(None);
    }
    // a parameter of the model that changes is the simpler answer
    let own = changed(fit, task.train, task.options.seed, |_| true).filter(|changed| changed.alone);
    if own.is_some_and(|own| (own.change / own.std).powi(2) > z2) {
        return Ok(None);
    }
    let Some(left) = begun.borne_out((&[beginning], chance), (fit, scored), task)? else { return Ok(None) };
    Ok(begun.fit.model.parameters.last().map(|parameter| ChangedParameter {
        parameter: format!("{} {}", candidate.name(), parameter.spec.name),
        run: task.train[begun.part.run].name.clone(),
        from: begun.part.from,
        between,
        change: parameter.value - parameter.spec.neutral,
        std: parameter.std.unwrap_or(f64::NAN),
        unit: parameter.spec.dimension.to_string(),
        p_value,
        gain,
        alone: left <= 0.0,
        absent: true,
        neutral: parameter.spec.neutral,
        relative: false,
    }))
}

/// Whether an effect can begin at an instant: it is proportional to one number, has no memory, and does not depend on
/// the hull's shape, which is there all along.
fn may_begin(candidate: &Candidate, model: &Model) -> bool {
    let [(effect, place)] = &candidate.terms[..] else { return false };
    if !matches!(nature_at(effect.as_ref(), *place, model), Nature::Other | Nature::Steady | Nature::Restoring) {
        return false;
    }
    let remembers = memory_count(&Graph::new(), model, effect.as_ref(), *place) > 0;
    let is_one = matches!(&effect.parameters(*place)[..], [spec] if spec.is_linear() && !spec.per_run);
    is_one && !remembers && !candidate.blended && candidate.in_stead_of.is_none()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::candidates;
    use crate::effects::Coriolis;
    use crate::frame::Dof;
    use crate::run::{Run, Signal};

    #[test]
    fn the_shape_of_a_hull_and_what_remembers_do_not_begin() {
        let model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        let mut run = Run::default();
        for channel in ["u", "tau_u"] {
            run.signals.insert(channel.into(), Signal::new(vec![0.0, 5.0, 10.0].into(), vec![0.0, 1.0, 0.0]));
        }
        let list = candidates(&model, &[run], &[]);
        let begins = |id: &str| {
            let of = list.iter().find(|c| c.name() == id).unwrap_or_else(|| panic!("{id} is no candidate"));
            may_begin(of, &model)
        };
        assert!(begins("bias@surge") && begins("thrust_reverse_loss@surge") && begins("thrust_interaction_loss@surge"));
        assert!(!begins("quadratic_drag@surge") && !begins("drag_asymmetry@surge"));
        assert!(!begins("thrust_lag") && !begins("thruster_fault@surge") && !begins("fluid_memory@surge"));
    }
}
