//! Effects missing in the model that appear at an instant, or in one run alone: a failed thruster, a payload, a trim.
//!
//! ```text
//! α(t) = α·1(t ≥ t₀)          (α, t₀) = argmin −2 ln L, begun where z² of all parts of the log is greatest ([`super::parts`])
//! ```
//!
//! Searched if one part of the log tells more than the whole, or if the parameters of a last model make up for
//! something with different values in different parts of the log. An effect is reported if the same effect all along
//! gains less by a tenth, if no change of a parameter of the model explains as much, and if nothing or little
//! remains: in the model with it no parameter changes any more, and no other effect is beyond chance.

use std::sync::Arc;

use super::candidate::Candidate;
use super::columns::{InBlocks, in_blocks};
use super::constancy::{ChangedParameter, changed};
use super::parts::{BLOCK, Greatest, LEVEL, Log, Part, beyond, divided};
use super::refit::{afresh, beside};
use super::screen::Screen;
use super::task::{ROUGH, TIE, Task, asked, screened};
use crate::chain::{Nature, memory_count, nature_at};
use crate::effects::Since;
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions, cost_of, filter_error_from};
use crate::estimate::output_error::OutputErrorError;
use crate::model::Model;
use crate::run::{Run, Signal};
use crate::symbolic::Graph;

/// Channel of every run that is 1 where the effect acts.
const SINCE: &str = "1(t ≥ t₀)";

/// Number of effects that are refitted, the most significant first: a model that is biased by the new effect gives two
/// effects that act alike similar scores.
const REFITS: usize = 3;

/// Number of effects that are tested before anything is named, the least probable by chance first: an effect that
/// begins in the middle of a log also shows over all of it.
const LIKELY: usize = 12;

/// Share of the gain of a beginning that may remain beside it, and by which it must exceed the gain of the same
/// effect all along: a thruster wired the wrong way round is not exactly opposite if its forces astern differ from
/// those ahead.
const LEFT: f64 = 0.1;

/// Number of instants that are tried within a block on each side of the one found.
const INSTANTS: usize = 8;

/// The model with the effect that has begun.
struct Begun {
    part: Part,
    runs: Vec<Run>,
    fit: FilterErrorFit,
}

/// The effect of `list`, not in the model of `fit`, that has begun, if nothing is beyond chance beside it.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub(super) fn appeared(
    fit: &FilterErrorFit,
    list: &[Candidate],
    task: &Task<'_>,
) -> Result<Option<ChangedParameter>, OutputErrorError> {
    let list: Vec<Candidate> = list.iter().filter(|c| may_begin(c, &fit.model)).cloned().collect();
    begun(fit, &list, task, 0.0)
}

/// The same before anything is named: among the effects that show most over the whole log, one that gains more from an
/// instant on.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub(super) fn appeared_first(
    fit: &FilterErrorFit,
    (list, screen): (&[Candidate], &Screen),
    task: &Task<'_>,
) -> Result<Option<ChangedParameter>, OutputErrorError> {
    if !screen.asks() {
        return Ok(None);
    }
    let best = screen.best_probes().into_iter().map(|score| &list[score.candidate]);
    let best: Vec<Candidate> = best.filter(|c| may_begin(c, &fit.model)).take(LIKELY).cloned().collect();
    // a value of its own in every run follows anything that comes and goes
    let same = screen.scores.iter().filter(|score| !list[score.candidate].has_own_values());
    let all_along = same.map(|score| score.statistic).fold(0.0, f64::max);
    begun(fit, &best, task, all_along)
}

/// The effect of `list` that has begun, with a z² beyond `least`.
fn begun(
    fit: &FilterErrorFit,
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
        let begun = Begun::at(log.parts[found.part].clone(), candidate, -found.s / found.c, fit, task)?;
        Some((found.z2, candidate, begun))
    };
    let first = log.own_of_each();
    let all = first.iter().take_while(|found| found.z2 > least).take(REFITS).filter_map(begun);
    let mut all: Vec<(f64, &Candidate, Begun)> = all.collect();
    all.sort_by(|a, b| a.2.fit.cost.total_cmp(&b.2.fit.cost));
    let mut all = all.into_iter();
    let Some((z2, candidate, begun)) = all.next() else { return Ok(None) };
    // if two are equally good, neither is the answer
    if all.next().is_some_and(|(_, _, second)| second.fit.cost < begun.fit.cost + TIE) {
        return Ok(None);
    }
    let begun = begun.likeliest(&log.parts, task);
    let gain = fit.cost - begun.fit.cost;
    let tried = (log.parts.len() * list.len()) as f64;
    let by_chance = 2.0 * (tried / LEVEL).ln();
    // twice the limit of chance: near to it any effect absorbs a little of another one
    if gain < 2.0 * by_chance || begun.more_than_all_along(task) < LEFT * gain + by_chance {
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
    let left = begun.left(task)?;
    if left > LEFT * gain {
        return Ok(None);
    }
    Ok(begun.fit.model.parameters.last().map(|parameter| ChangedParameter {
        parameter: format!("{} {}", candidate.name(), parameter.spec.name),
        run: task.train[begun.part.run].name.clone(),
        from: begun.part.from,
        change: parameter.value - parameter.spec.neutral,
        std: parameter.std.unwrap_or(f64::NAN),
        unit: parameter.spec.dimension.to_string(),
        p_value,
        gain,
        alone: left <= 0.0,
        absent: true,
        neutral: parameter.spec.neutral,
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

impl Begun {
    /// Fits `candidate`, added to the model of `fit` within `part`, from the start value `by`.
    fn at(part: Part, candidate: &Candidate, by: f64, fit: &FilterErrorFit, task: &Task<'_>) -> Option<Begun> {
        let mut model = fit.model.clone();
        let (effect, place) = &candidate.terms[0];
        model.add(Arc::new(Since::of(effect.clone(), SINCE)), *place).ok()?;
        let parameter = model.parameters.last_mut()?;
        parameter.value = (parameter.spec.neutral + by).clamp(parameter.min, parameter.max);
        let runs = marked(task.train, &part);
        let rough = FilterErrorOptions { tolerance: ROUGH, told: false, ..beside(fit, task) };
        let fit = filter_error_from(&model, &runs, afresh(&fit.noise), &rough).ok()?;
        Some(Begun { part, runs, fit })
    }

    /// Fall of −2 ln L beyond that of the same effect all along, which may gain nothing in the rest of the log.
    fn more_than_all_along(&self, task: &Task<'_>) -> f64 {
        let all = Part { run: 0, from: Some(f64::NEG_INFINITY), ..self.part.clone() };
        let runs = marked(task.train, &all);
        let fit = filter_error_from(&self.fit.model, &runs, self.fit.noise.clone(), &beside(&self.fit, task));
        fit.map_or(f64::INFINITY, |fit| fit.cost - self.fit.cost)
    }

    /// Fall of −2 ln L, beyond chance, that remains beside it: by a parameter that still changes, or by another effect.
    fn left(&self, task: &Task<'_>) -> Result<f64, OutputErrorError> {
        let task = Task { train: &self.runs, ..*task };
        let changes = changed(&self.fit, &self.runs, task.options.seed, |_| true).map_or(0.0, |changed| changed.gain);
        let beside = screened(&self.fit, &asked(&self.fit.model, &task), &task)?;
        let best = beside.scores.first().filter(|_| beside.asks()).map_or(0.0, |score| score.statistic);
        Ok(changes.max(best))
    }

    /// The same from the likeliest instant within a block of the one found, or in its run alone if that is as likely.
    fn likeliest(self, parts: &[Part], task: &Task<'_>) -> Begun {
        let Some(here) = self.part.from else { return self };
        let apart = parts.iter().filter(|part| part.run == self.part.run).filter_map(|part| part.from);
        let apart = apart.map(|from| (from - here).abs()).filter(|apart| *apart > 0.0);
        let Some(block) = apart.reduce(f64::min) else { return self };
        let costing = |part: Part| {
            let (known, runs) = ((&self.fit.noise, self.fit.limit), marked(task.train, &part));
            cost_of(&self.fit.model, &runs, known, task.fitting).ok().map(|cost| (cost, part))
        };
        let least = |a: &(f64, Part), b: &(f64, Part)| a.0.total_cmp(&b.0);
        let start = task.train[self.part.run].span().map_or(here, |(first, _)| first);
        let from = |k: usize| (here + block * (k as f64 / INSTANTS as f64 - 1.0)).max(start);
        let instants = (0..=2 * INSTANTS).map(|k| Part { from: Some(from(k)), ..self.part.clone() });
        let Some(likeliest) = instants.filter_map(costing).min_by(least) else { return self };
        // near the end of a run it may be the next run
        let runs = self.part.run..task.train.len().min(self.part.run + 2);
        let of_run = runs.map(|run| Part { run, from: None, ..self.part.clone() }).filter_map(costing).min_by(least);
        let (_, part) = of_run.filter(|(cost, _)| *cost < likeliest.0 + TIE).unwrap_or(likeliest);
        let runs = marked(task.train, &part);
        match filter_error_from(&self.fit.model, &runs, self.fit.noise.clone(), &beside(&self.fit, task)) {
            Ok(fit) if fit.cost < self.fit.cost + TIE => Begun { part, runs, fit },
            _ => self,
        }
    }
}

/// The runs with a channel that is 1 in a part: from its instant on and in all later runs, or in its run alone.
fn marked(runs: &[Run], part: &Part) -> Vec<Run> {
    /// Width of the edge, s.
    const EDGE: f64 = 1e-3;
    let of = |(k, run): (usize, &Run)| {
        let ends = run.signals.values().filter(|s| !s.is_empty()).map(|s| (s.time()[0], s.time()[s.len() - 1]));
        let (first, last) =
            ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (from, to)| (a.min(from), b.max(to)));
        let constant = |value: f64| Signal::new(vec![first, last].into(), vec![value; 2]);
        let signal = match part.from {
            Some(from) if k == part.run && from > first && from + EDGE < last => {
                Signal::new(vec![first, from, from + EDGE, last].into(), vec![0.0, 0.0, 1.0, 1.0])
            }
            Some(_) => constant(f64::from(u8::from(k >= part.run))),
            None => constant(f64::from(u8::from(k == part.run))),
        };
        let mut marked = run.clone();
        marked.signals.insert(SINCE.into(), signal);
        marked
    };
    runs.iter().enumerate().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::candidates;
    use crate::effects::Coriolis;
    use crate::frame::Dof;

    fn runs() -> Vec<Run> {
        let of = |name: &str| {
            let mut run = Run { name: name.into(), ..Run::default() };
            for channel in ["u", "tau_u"] {
                run.signals.insert(channel.into(), Signal::new(vec![0.0, 5.0, 10.0].into(), vec![0.0, 1.0, 0.0]));
            }
            run
        };
        ["a", "b", "c"].map(of).to_vec()
    }

    #[test]
    fn a_part_is_marked_in_every_run() {
        let at = |part: &Part, k: usize, t: f64| {
            let marked = marked(&runs(), part);
            let signal = marked[k].signal(SINCE).unwrap();
            signal.values()[signal.time().partition_point(|time| *time <= t) - 1]
        };
        let part = |run, from| Part { blocks: 0..1, run, from };
        let begun = part(1, Some(4.0));
        assert_eq!(
            [at(&begun, 0, 9.0), at(&begun, 1, 3.9), at(&begun, 1, 4.1), at(&begun, 2, 0.0)],
            [0.0, 0.0, 1.0, 1.0]
        );
        let alone = part(1, None);
        assert_eq!([at(&alone, 0, 5.0), at(&alone, 1, 5.0), at(&alone, 2, 5.0)], [0.0, 1.0, 0.0]);
        let all = part(0, Some(f64::NEG_INFINITY));
        assert!((0..3).all(|k| at(&all, k, 0.0) > 0.5));
    }

    #[test]
    fn the_shape_of_a_hull_and_what_remembers_do_not_begin() {
        let model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        let list = candidates(&model, &runs(), &[]);
        let begins = |id: &str| {
            let of = list.iter().find(|c| c.name() == id).unwrap_or_else(|| panic!("{id} is no candidate"));
            may_begin(of, &model)
        };
        assert!(begins("bias@surge") && begins("thrust_reverse_loss@surge") && begins("thrust_interaction_loss@surge"));
        assert!(!begins("quadratic_drag@surge") && !begins("drag_asymmetry@surge"));
        assert!(!begins("thrust_lag") && !begins("thruster_fault@surge") && !begins("fluid_memory@surge"));
    }
}
