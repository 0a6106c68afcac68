//! A model in which something begins or changes in one part of the log: from an instant on, or in one run.
//!
//! ```text
//! (θ, s, t₀) = argmin −2 ln L          s: what begins or changes ([`Since`]), from a block of samples to one of them
//! ```
//!
//! It is borne out as an event if little or nothing remains beside it, if what begins gains less by a tenth where it acts
//! all along, and if no effect that is present throughout explains nine tenths of it: in the one run that goes astern,
//! weaker reverse thrust looks like weak thrust.

use std::sync::Arc;

use super::candidate::Candidate;
use super::constancy::{RunInstant, changed};
use super::parts::Part;
use super::refit::{afresh, beside};
use super::screen::Screen;
use super::task::{ROUGH, TIE, Task, asked, screened};
use crate::effects::{Effect, Event, Place, Since};
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions, cost_of, filter_error_from};
use crate::estimate::output_error::OutputErrorError;
use crate::model::Model;
use crate::run::{Run, Signal};

/// Candidates, and their scores beside a fit.
pub(super) type Scored<'a> = (&'a [Candidate], &'a Screen);

/// Channel of every run that is 1 where the effects act.
const SINCE: &str = "1(t ≥ t₀)";

/// Number of instants that are tried within a block on each side of the one found.
const INSTANTS: usize = 8;

/// Maximum number of times that a likelier instant is looked for elsewhere.
const CLIMBS: usize = 4;

/// Share of the gain of an event that may remain beside it, and by which it must exceed the gain of the same effect or of
/// another one all along: a thruster wired the wrong way round is not exactly opposite if its forces astern differ from
/// those ahead.
const LEFT: f64 = 0.1;

/// Number of effects present throughout that are fitted instead of an event, the best by score: the score of a strong one
/// promises less than it gains.
const RIVALS: usize = 4;

/// What begins or changes, with the value from which its parameter is fitted, as a difference from that at which nothing
/// does.
#[derive(Clone)]
pub(super) struct Beginning {
    pub what: What,
    pub start: f64,
    /// Key of a parameter that is one for several effects.
    pub tie: Option<&'static str>,
}

/// What begins or changes.
#[derive(Clone)]
pub(super) enum What {
    /// An effect that is not in the model.
    Effect(Arc<dyn Effect>, Place),
    /// A term of the model.
    Term(usize, Event),
}

/// The model with what has begun or changed.
pub(super) struct Begun {
    pub part: Part,
    pub runs: Vec<Run>,
    pub fit: FilterErrorFit,
    /// Index of the first parameter that is new.
    pub first_new: usize,
}

impl Beginning {
    /// Adds it to a model; `None` if it cannot stand there.
    fn add_to(&self, model: &mut Model) -> Option<()> {
        let known = model.parameters.len();
        let since = |effect: &Arc<dyn Effect>, event| {
            let since = Since::of(effect.clone(), event, SINCE);
            Arc::new(if let Some(key) = self.tie { since.tied(key) } else { since })
        };
        match &self.what {
            What::Effect(effect, place) => {
                model.add(since(effect, Event::Begins), *place).ok()?;
            }
            What::Term(k, event) => model.change(*k, since(&model.terms[*k].effect, *event)),
        }
        for parameter in &mut model.parameters[known..] {
            parameter.value = (parameter.spec.neutral + self.start).clamp(parameter.min, parameter.max);
        }
        Some(())
    }
}

impl Begun {
    /// Fits the model of `fit` with `beginnings` within `part`; `None` if it cannot be fitted.
    pub fn at(part: Part, beginnings: &[Beginning], fit: &FilterErrorFit, task: &Task<'_>) -> Option<Begun> {
        let (mut model, first_new) = (fit.model.clone(), fit.model.parameters.len());
        beginnings.iter().try_for_each(|beginning| beginning.add_to(&mut model))?;
        let runs = marked(task.train, &part);
        let rough = FilterErrorOptions { tolerance: ROUGH, told: false, ..beside(fit, task) };
        let fit = filter_error_from(&model, &runs, afresh(&fit.noise), &rough).ok()?;
        Some(Begun { part, runs, fit, first_new })
    }

    /// Number of parameters that are new.
    pub fn count(&self) -> usize {
        self.fit.model.parameters.len() - self.first_new
    }

    /// The fall of −2 ln L, beyond chance, that remains beside the event; `None` if it is too much, if what begins acts all
    /// along, or if another effect that is present throughout explains as much. `fit` is the model without the event,
    /// `scored` are the candidates beside it; an event of `beginnings` gains up to `chance` by chance.
    ///
    /// # Errors
    /// [`OutputErrorError`] when a run lacks what a candidate reads.
    pub fn borne_out(
        &self,
        (beginnings, chance): (&[Beginning], f64),
        (fit, scored): (&FilterErrorFit, Scored<'_>),
        task: &Task<'_>,
    ) -> Result<Option<f64>, OutputErrorError> {
        let gain = fit.cost - self.fit.cost;
        let left = self.left(task)?;
        let is_event = left <= LEFT * gain
            && self.cost_all_along(beginnings, fit, task) >= self.fit.cost + LEFT * gain + chance
            && cost_throughout(fit, scored, task) >= self.fit.cost + LEFT * gain;
        Ok(is_event.then_some(left))
    }

    /// −2 ln L if the effects of `beginnings` that the model of `fit` lacks act all along; infinite if it lacks none.
    fn cost_all_along(&self, beginnings: &[Beginning], fit: &FilterErrorFit, task: &Task<'_>) -> f64 {
        let lacking = beginnings.iter().filter(|beginning| matches!(beginning.what, What::Effect(..)));
        let lacking: Vec<Beginning> = lacking.cloned().collect();
        let all = Part { run: 0, from: Some(f64::NEG_INFINITY), ..self.part.clone() };
        let fitted = (!lacking.is_empty()).then(|| Begun::at(all, &lacking, fit, task)).flatten();
        fitted.map_or(f64::INFINITY, |all| all.fit.cost)
    }

    /// Fall of −2 ln L, beyond chance, that remains beside it: by a parameter that still changes, or by another effect.
    fn left(&self, task: &Task<'_>) -> Result<f64, OutputErrorError> {
        let task = Task { train: &self.runs, ..*task };
        let changes = changed(&self.fit, &self.runs, task.options.seed, |_| true).map_or(0.0, |changed| changed.gain);
        let beside = screened(&self.fit, &asked(&self.fit.model, &task), &task)?;
        let best = beside.scores.first().filter(|_| beside.asks()).map_or(0.0, |score| score.statistic);
        Ok(changes.max(best))
    }

    /// The same from the likeliest instant, to a sample, or in its run alone if that is as likely; and the earliest and the
    /// latest instant that the data do not tell from it.
    pub fn likeliest(self, parts: &[Part], task: &Task<'_>) -> (Begun, Vec<RunInstant>) {
        let mut instants: Vec<&Part> = parts.iter().filter(|part| part.from.is_some()).collect();
        instants.sort_by_key(|part| part.blocks.start);
        let (mut begun, mut between) = (self.finer(&instants, task), Vec::new());
        for _ in 0..CLIMBS {
            let (better, likely) = begun.as_likely(&instants, task);
            between = likely;
            match better {
                Some(better) => begun = better.finer(&instants, task),
                None => break,
            }
        }
        (begun, between)
    }

    /// The same from the likeliest instant within a block, or in its run alone if that is as likely.
    fn finer(self, instants: &[&Part], task: &Task<'_>) -> Begun {
        let Some(here) = self.part.from else { return self };
        let apart = instants.iter().filter(|part| part.run == self.part.run).filter_map(|part| part.from);
        // a run of one or two blocks has no other instant
        let ends = task.train[self.part.run].span().into_iter().flat_map(|(start, end)| [start, end]);
        let apart = apart.chain(ends).map(|from| (from - here).abs()).filter(|apart| *apart > 0.0);
        let Some(mut within) = apart.reduce(f64::min) else { return self };
        // near the end of a run it may be the next run
        let runs = self.part.run..task.train.len().min(self.part.run + 2);
        let alone: Vec<Part> = runs.map(|run| Part { run, from: None, ..self.part.clone() }).collect();
        let mut begun = self.nearer((here, within), &alone, task);
        let sample = begun.sample_time();
        while let Some(from) = begun.part.from.filter(|_| within > sample) {
            within /= INSTANTS as f64;
            begun = begun.nearer((from, within), &[], task);
        }
        begun
    }

    /// Goes from block to block, both ways, as long as another instant is as likely, fitted anew at each: the other
    /// parameters make up for a wrong instant. The likeliest of them, if it is likelier, and the earliest and the latest;
    /// neither for what acts in one run alone.
    fn as_likely(&self, instants: &[&Part], task: &Task<'_>) -> (Option<Begun>, Vec<RunInstant>) {
        if self.part.from.is_none() {
            return (None, Vec::new());
        }
        let here = (self.part.run, self.part.from);
        let before: Vec<&Part> = instants.iter().rev().copied().filter(|part| (part.run, part.from) < here).collect();
        let after: Vec<&Part> = instants.iter().copied().filter(|part| (part.run, part.from) > here).collect();
        let (mut likeliest, mut least) = (None, self.fit.cost);
        let ends = [before, after].map(|parts| {
            let is_as_likely = |k: usize| {
                let Some(moved) = self.moved(parts[k].clone(), task).filter(|moved| moved.fit.cost < least + TIE)
                else {
                    return false;
                };
                if moved.fit.cost < least - ROUGH {
                    least = moved.fit.cost;
                    likeliest = Some(moved);
                }
                true
            };
            furthest(parts.len(), is_as_likely).map_or(&self.part, |k| parts[k])
        });
        let is_told = (ends[0].run, ends[0].from) == (ends[1].run, ends[1].from);
        let told = |part: &Part| Some(RunInstant { run: task.train[part.run].name.clone(), at: part.from? });
        let between = if is_told { Vec::new() } else { ends.into_iter().filter_map(told).collect() };
        (likeliest, between)
    }

    /// The same in another part; `None` if it cannot be fitted.
    fn moved(&self, part: Part, task: &Task<'_>) -> Option<Begun> {
        let runs = marked(task.train, &part);
        let fit = filter_error_from(&self.fit.model, &runs, self.fit.noise.clone(), &beside(&self.fit, task)).ok()?;
        Some(Begun { part, runs, fit, first_new: self.first_new })
    }

    /// Mean time between the rows of the part's run, s.
    fn sample_time(&self) -> f64 {
        let tracks = self.fit.filtered.problem.tracks.iter().filter(|track| track.run == self.part.run);
        let spans = tracks.filter_map(|track| Some((track.time.last()? - track.time.first()?, track.time.len() - 1)));
        let (seconds, steps) = spans.fold((0.0, 0), |(t, n), (span, count)| (t + span, n + count));
        seconds / steps.max(1) as f64
    }

    /// The same from the likeliest of the instants within `within` of `from`, or in one of the parts `alone`; as it is
    /// if none can be fitted better.
    fn nearer(self, (from, within): (f64, f64), alone: &[Part], task: &Task<'_>) -> Begun {
        let costing = |part: Part| {
            let (known, runs) = ((&self.fit.noise, self.fit.limit), marked(task.train, &part));
            cost_of(&self.fit.model, &runs, known, task.fitting).ok().map(|cost| (cost, part))
        };
        let least = |a: &(f64, Part), b: &(f64, Part)| a.0.total_cmp(&b.0);
        let (start, end) = task.train[self.part.run].span().unwrap_or((from, from));
        let at = |k: usize| (from + within * (k as f64 / INSTANTS as f64 - 1.0)).clamp(start, end);
        let instants = (0..=2 * INSTANTS).map(|k| Part { from: Some(at(k)), ..self.part.clone() });
        let Some(likeliest) = instants.filter_map(costing).min_by(least) else { return self };
        let of_run = alone.iter().cloned().filter_map(costing).min_by(least);
        let (_, part) = of_run.filter(|(cost, _)| *cost < likeliest.0 + TIE).unwrap_or(likeliest);
        if (part.run, part.from) == (self.part.run, self.part.from) {
            return self;
        }
        match self.moved(part, task) {
            Some(moved) if moved.fit.cost < self.fit.cost + TIE => moved,
            _ => self,
        }
    }
}

/// The least −2 ln L of the model of `fit` with one of the effects that are most significant throughout.
fn cost_throughout(fit: &FilterErrorFit, (candidates, screen): Scored<'_>, task: &Task<'_>) -> f64 {
    let rough = FilterErrorOptions { tolerance: ROUGH, told: false, ..beside(fit, task) };
    let best = screen.best_probes().into_iter().filter(|score| {
        let candidate = &candidates[score.candidate];
        !candidate.has_own_values() && candidate.is_possible(score)
    });
    let costs = best.take(RIVALS).filter_map(|score| {
        let model = candidates[score.candidate].started(&fit.model, score)?;
        Some(filter_error_from(&model, task.train, afresh(&fit.noise), &rough).ok()?.cost)
    });
    costs.fold(f64::INFINITY, f64::min)
}

/// The furthest of `count` steps that `holds`, if it holds up to somewhere: tried in steps that double, then halve.
fn furthest(count: usize, mut holds: impl FnMut(usize) -> bool) -> Option<usize> {
    let (mut reached, mut step) = (0, 1);
    let mut beyond = count + 1;
    // `reached` steps hold, `beyond` do not
    while reached + 1 < beyond {
        let next = (reached + step).min(if beyond > count { count } else { reached.midpoint(beyond) });
        if holds(next - 1) {
            (reached, step) = (next, 2 * step);
        } else {
            beyond = next;
        }
    }
    reached.checked_sub(1)
}

/// The runs with a channel that is 1 in a part: from its instant on and in all later runs, or in its run alone.
fn marked(runs: &[Run], part: &Part) -> Vec<Run> {
    /// Width of the edge, s.
    const EDGE: f64 = 1e-3;
    let of = |(k, run): (usize, &Run)| {
        let (first, last) = run.span().unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
        let constant = |value: f64| Signal::new(vec![first, last].into(), vec![value; 2]);
        let signal = match part.from {
            Some(from) if k == part.run && from > first && from + EDGE < last => {
                Signal::new(vec![first, from, from + EDGE, last].into(), vec![0.0, 0.0, 1.0, 1.0])
            }
            // an instant before the first sample or after the last one
            Some(from) if k == part.run => constant(f64::from(u8::from(from <= first))),
            Some(_) => constant(f64::from(u8::from(k > part.run))),
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

    /// Of 200 steps every limit is found in at most 16 trials.
    #[test]
    fn the_furthest_step_is_found_in_few_trials() {
        for limit in 0..=200 {
            let mut trials = 0;
            let found = furthest(200, |k| {
                trials += 1;
                k < limit
            });
            assert_eq!(found, limit.checked_sub(1));
            assert!(trials <= 16, "{limit}: {trials}");
        }
        assert_eq!(furthest(0, |_| true), None);
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
        // an instant after the last sample is that of the next run
        let last = part(1, Some(10.0));
        assert_eq!([at(&last, 0, 5.0), at(&last, 1, 5.0), at(&last, 2, 5.0)], [0.0, 0.0, 1.0]);
        let alone = part(1, None);
        assert_eq!([at(&alone, 0, 5.0), at(&alone, 1, 5.0), at(&alone, 2, 5.0)], [0.0, 1.0, 0.0]);
        let all = part(0, Some(f64::NEG_INFINITY));
        assert!((0..3).all(|k| at(&all, k, 0.0) > 0.5));
    }
}
