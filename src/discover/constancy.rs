//! Step 7, second half: a parameter of nature is the same at all times.
//!
//! ```text
//! S = Σ Gᵀe,  A = Σ GᵀG over a part of the log,   C = A_jj − A_j· (Σ A)⁻¹ A·j       G = ∂e/∂θ /√s at the estimate
//! z² = S_j²/C,   δ = −S_j/C                        what θ_j is more there than elsewhere; δ ± 1/√C
//! ```
//!
//! A part is all that comes after an instant (weed, a payload, a motor that fails), or one run (a wrong sign, another
//! trim); of a value that a run has for itself, what comes after an instant of that run (a current that turns with the
//! tide). Over the whole log S is nothing, because the estimate is the likelihood's greatest. The greatest z² of all parts
//! and parameters is compared with what chance makes of the greatest one, drawn from N(0, A) of every block. A name that
//! stands in for something else may follow the whole log on average, but not every part of it. Where it is one parameter
//! that changes once, nothing is left beside that change as an unknown of its own; where the equations are of another shape
//! than nature, every part wants other values, and none of them is told as a change. Nyblom, *Journal of the American
//! Statistical Association* 84 (1989) 223-230; Hansen, *Journal of Policy Modeling* 14 (1992) 517-533.

use nalgebra::DMatrix;
use serde::Serialize;

use super::screen::{log_survival, root};
use crate::estimate::filter_error::FilterErrorFit;
use crate::noise::Noise;
use crate::run::Run;
use crate::wording::digits;

/// Draws of the greatest z² by chance.
const DRAWS: usize = 1000;

/// The draws are of this stream of the seed.
const STREAM: u64 = 0xc057;

/// Samples of a block.
const BLOCK: usize = 256;

/// Blocks into which a log is divided at most: instants are told to one of them.
const MOST_BLOCKS: usize = 256;

/// Probability of a change by chance, of all parameters and parts, below which it is told: with whiteness and predictions, at
/// one in a thousand each, a model that is right is doubted less than once in a hundred times.
const LEVEL: f64 = 5e-3;

/// A part of the log that holds less than this share of a parameter's information says nothing of it: its z² is that of a
/// few samples, which the correlation of what is left decides.
const LEAST_SHARE: f64 = 0.02;

/// A parameter that is not the same at all times.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChangedParameter {
    /// Effect and symbol.
    pub parameter: String,
    /// Run in which it is another, or from which on.
    pub run: String,
    /// Instant from which on it is another, s of the run, to a block of samples; `None` where it is of this run alone.
    pub from: Option<f64>,
    /// What it is more there than elsewhere.
    pub change: f64,
    /// Deviation of that.
    pub std: f64,
    /// Its unit.
    pub unit: String,
    /// Probability of as much by chance, of all parameters and parts.
    pub p_value: f64,
    /// By how much −2 ln L falls, beyond chance, with values of their own for all parameters in that part.
    pub gain: f64,
    /// Whether this change is all: beside it no other parameter or part wants another value, and no effect that stands in raises
    /// the likelihood by more. Where it is not, no value has changed: the equations have another shape than what acts there.
    pub alone: bool,
}

impl ChangedParameter {
    /// `Not the same at all times: k_r of linear_drag@yaw is 0.83 ± 0.03 kg*m2/s more from 31 s of run04 on.`, or where it shows
    /// most that no one value fits.
    pub fn told(&self) -> String {
        if self.alone {
            return format!("Not the same at all times: {}.", self.change_in_words());
        }
        let (effect, symbol) = self.parameter.split_once(' ').unwrap_or((&self.parameter, ""));
        let at = self.from.map_or(format!("in {}", self.run), |from| format!("from {from:.0} s of {} on", self.run));
        format!(
            "The parameters make up for it with other values in one part of the log than in another, {symbol} of {effect} most, {at}."
        )
    }

    /// A change that raises the likelihood by less than some stand-in, `gains` the fall of −2 ln L with each, is but another one.
    pub(super) fn stand_beside(&mut self, gains: impl Iterator<Item = f64>) {
        self.alone &= gains.fold(0.0, f64::max) < self.gain;
    }

    fn change_in_words(&self) -> String {
        let (effect, symbol) = self.parameter.split_once(' ').unwrap_or((&self.parameter, ""));
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        let more = if self.change < 0.0 { "less" } else { "more" };
        let size = format!("{} ± {}{unit} {more}", digits(self.change.abs()), digits(self.std));
        match self.from {
            Some(from) => format!("{symbol} of {effect} is {size} from {from:.0} s of {} on", self.run),
            None => format!("{symbol} of {effect} is {size} in {} than elsewhere", self.run),
        }
    }
}

/// The parameter of `fit` that is surely not the same at all times, the surest of those whose effect `asked` wants.
pub(super) fn changed(
    fit: &FilterErrorFit,
    runs: &[Run],
    seed: u64,
    asked: impl Fn(&str) -> bool,
) -> Option<ChangedParameter> {
    most_changed(fit, runs, seed, asked).filter(|found| found.p_value < LEVEL)
}

/// Sums of a part of the log.
#[derive(Clone)]
struct Sums {
    /// One column.
    s: DMatrix<f64>,
    a: DMatrix<f64>,
}

/// A part of the log, as blocks, and how it is told.
#[derive(Clone)]
struct Part {
    blocks: std::ops::Range<usize>,
    run: usize,
    from: Option<f64>,
}

/// The parameter of `fit` that changes by most between parts of `runs`, with how probable as much is by chance.
fn most_changed(
    fit: &FilterErrorFit,
    runs: &[Run],
    seed: u64,
    asked: impl Fn(&str) -> bool,
) -> Option<ChangedParameter> {
    let log = Log::new(fit, runs, asked)?;
    let found = log.own()?;
    let p_value = beyond(found.z2, &log.drawn(log.by_chance(seed)));
    let apart = if p_value < LEVEL { log.apart(&found) } else { None };
    let part = &log.parts[found.part];
    let parameter = &fit.model.parameters[fit.filtered.problem.unknowns[found.unknown].parameter];
    Some(ChangedParameter {
        parameter: format!("{} {}", parameter.term, parameter.spec.name),
        run: runs[part.run].name.clone(),
        from: part.from,
        change: -found.s / found.c,
        std: 1.0 / found.c.sqrt(),
        unit: parameter.spec.dimension.to_string(),
        p_value,
        alone: apart.as_ref().and_then(|apart| apart.is_alone(&log, seed)).unwrap_or(false),
        gain: apart.as_ref().map_or(found.z2, |apart| apart.gain),
    })
}

/// The log in blocks over the unknowns, one run after the other, and what is asked of it.
struct Log {
    blocks: Vec<Sums>,
    parts: Vec<Part>,
    /// The unknowns that are asked.
    asked: Vec<usize>,
    /// Information of the priors.
    priors: Vec<(usize, f64)>,
    /// (Σ A)⁻¹, priors included.
    inverse: DMatrix<f64>,
    /// C of each part: unknowns and what the others' change leaves of their information.
    left: Vec<Vec<(usize, f64)>>,
}

/// The greatest z².
struct Greatest {
    z2: f64,
    part: usize,
    unknown: usize,
    s: f64,
    c: f64,
}

impl Log {
    fn new(fit: &FilterErrorFit, runs: &[Run], asked: impl Fn(&str) -> bool) -> Option<Log> {
        let (blocks, parts) = divided(fit, runs);
        let unknowns = fit.filtered.problem.unknowns.iter().enumerate();
        let asked = unknowns.filter(|(_, u)| asked(&fit.model.parameters[u.parameter].term)).map(|(k, _)| k).collect();
        Log::of(blocks, parts, asked, fit.priors().collect())
    }

    fn of(blocks: Vec<Sums>, parts: Vec<Part>, asked: Vec<usize>, priors: Vec<(usize, f64)>) -> Option<Log> {
        let p = blocks.first()?.a.nrows();
        let until = sums(blocks.iter().map(|block| &block.a), DMatrix::zeros(p, p));
        let all = &until[blocks.len()];
        let mut total = all.clone();
        priors.iter().for_each(|(k, information)| total[(*k, *k)] += information);
        let inverse = total.cholesky()?.inverse();
        let left = |part: &Part| {
            let a = &until[part.blocks.end] - &until[part.blocks.start];
            let of = |j: &usize| {
                let c = a[(*j, *j)] - (a.row(*j) * &inverse * a.column(*j))[0];
                (c > LEAST_SHARE * all[(*j, *j)]).then_some((*j, c))
            };
            asked.iter().filter_map(of).collect()
        };
        let left = parts.iter().map(left).collect();
        Some(Log { blocks, parts, asked, priors, inverse, left })
    }

    /// The same with all that is asked as unknowns of their own in the part of what was `found`: what happens at an instant may
    /// change more than one parameter.
    fn apart(&self, found: &Greatest) -> Option<Apart> {
        let part = self.parts[found.part].blocks.clone();
        let own: Vec<usize> = self.left[found.part].iter().map(|(unknown, _)| *unknown).collect();
        let enlarged = |(k, block): (usize, &Sums)| {
            let s = with_own(&block.s, &own, part.contains(&k));
            // both ways: rows, then columns
            let a = with_own(&with_own(&block.a, &own, part.contains(&k)).transpose(), &own, part.contains(&k));
            Sums { s, a }
        };
        let blocks: Vec<Sums> = self.blocks.iter().enumerate().map(enlarged).collect();
        let fall = |log: &Log| {
            let s = log.blocks.iter().fold(DMatrix::zeros(log.inverse.nrows(), 1), |sum, block| sum + &block.s);
            (s.transpose() * &log.inverse * &s)[0]
        };
        let log = Log::of(blocks, self.parts.clone(), self.asked.clone(), self.priors.clone())?;
        // chance gives one a parameter
        let gain = fall(&log) - fall(self) - own.len() as f64;
        Some(Apart { log, part, freed: own, gain })
    }

    /// The greatest z² of the log itself.
    fn own(&self) -> Option<Greatest> {
        self.greatest(self.blocks.iter().map(|block| block.s.clone()).collect()).pop().flatten()
    }

    /// What chance makes of S, block by block, a column a draw.
    fn by_chance(&self, seed: u64) -> Vec<DMatrix<f64>> {
        let mut noise = Noise::new(seed, STREAM);
        let drawn = |block: &Sums| {
            // roundings may leave a block without a root: its columns are then drawn each by itself
            let alone = || DMatrix::from_diagonal(&block.a.diagonal().map(|a| a.max(0.0).sqrt()));
            root(&block.a).unwrap_or_else(alone) * DMatrix::from_fn(block.a.nrows(), DRAWS, |_, _| noise.normal())
        };
        self.blocks.iter().map(drawn).collect()
    }

    /// What it makes of the greatest z², smallest first.
    fn drawn(&self, scores: Vec<DMatrix<f64>>) -> Vec<f64> {
        let mut drawn: Vec<f64> = self.greatest(scores).into_iter().flatten().map(|g| g.z2).collect();
        drawn.sort_by(f64::total_cmp);
        drawn
    }

    /// The greatest z² of each column of the blocks' S, less what a step of the estimate takes out over all.
    fn greatest(&self, scores: Vec<DMatrix<f64>>) -> Vec<Option<Greatest>> {
        let none = DMatrix::zeros(self.inverse.nrows(), scores.first().map_or(0, DMatrix::ncols));
        let step = &self.inverse * scores.iter().fold(none.clone(), |sum, s| sum + s);
        let centred: Vec<DMatrix<f64>> =
            scores.into_iter().zip(&self.blocks).map(|(s, block)| s - &block.a * &step).collect();
        let until = sums(centred.iter(), none);
        let of = |column: usize| {
            let of_part = |(part, left): (usize, &Vec<(usize, f64)>)| {
                let blocks = &self.parts[part].blocks;
                let (first, last) = (&until[blocks.start], &until[blocks.end]);
                let of = |(unknown, c): &(usize, f64)| {
                    let s = last[(*unknown, column)] - first[(*unknown, column)];
                    Greatest { z2: s * s / c, part, unknown: *unknown, s, c: *c }
                };
                left.iter().map(of).collect::<Vec<_>>()
            };
            self.left.iter().enumerate().flat_map(of_part).max_by(|a, b| a.z2.total_cmp(&b.z2))
        };
        (0..step.ncols()).map(of).collect()
    }
}

/// `rows` of a block with those of the unknowns `own` once more below, which are 0 outside of the part.
fn with_own(rows: &DMatrix<f64>, own: &[usize], is_in_part: bool) -> DMatrix<f64> {
    let (p, more) = (rows.nrows(), own.len());
    let mut all = rows.clone().resize_vertically(p + more, 0.0);
    if is_in_part {
        all.rows_mut(p, more).copy_from(&rows.select_rows(own));
    }
    all
}

/// A log in a part of which parameters have values of their own.
struct Apart {
    log: Log,
    part: std::ops::Range<usize>,
    /// The unknowns that have.
    freed: Vec<usize>,
    /// By how much −2 ln L falls with them, beyond chance.
    gain: f64,
}

impl Apart {
    /// Whether nothing that is beyond chance changes beside it; `of` is the log without them.
    fn is_alone(&self, of: &Log, seed: u64) -> Option<bool> {
        let beside = self.log.own()?;
        let drawn = of.by_chance(seed).into_iter().enumerate();
        let drawn = drawn.map(|(k, s)| with_own(&s, &self.freed, self.part.contains(&k))).collect();
        // an instant is told to a block: of m blocks the first may be as before, and the rest differ from their mean by 1/m
        Some(beside.z2 * self.part.len() as f64 <= self.gain || beyond(beside.z2, &self.log.drawn(drawn)) >= LEVEL)
    }
}

/// What the first k of a series sum to, for every k from 0 on.
fn sums<'a>(series: impl Iterator<Item = &'a DMatrix<f64>>, none: DMatrix<f64>) -> Vec<DMatrix<f64>> {
    let mut until = vec![none];
    series.for_each(|next| until.push(&until[until.len() - 1] + next));
    until
}

/// The probability that the greatest z² is beyond `z2`: counted, and where none is beyond, by the tail of as many independent
/// parts as the draws stand for.
fn beyond(z2: f64, drawn: &[f64]) -> f64 {
    let count = drawn.iter().filter(|d| **d > z2).count();
    if count > 0 || drawn.is_empty() {
        return count as f64 / drawn.len().max(1) as f64;
    }
    let middle = drawn[drawn.len() / 2];
    let independent = (0.5f64.ln() - log_survival(middle, 1)).exp();
    (independent * log_survival(z2, 1).exp()).min(1.0 / drawn.len() as f64)
}

/// The log in blocks over the unknowns, one run after the other, and the parts of it that are asked.
fn divided(fit: &FilterErrorFit, runs: &[Run]) -> (Vec<Sums>, Vec<Part>) {
    let problem = &fit.filtered.problem;
    let p = problem.unknowns.len();
    let products = fit.filtered.products_in_blocks(&fit.model, &fit.noise, fit.limit, BLOCK);
    let (mut blocks, mut starts): (Vec<Sums>, Vec<(usize, f64)>) = (Vec::new(), Vec::new());
    let together = products.iter().map(Vec::len).sum::<usize>().div_ceil(MOST_BLOCKS).max(1);
    for (stretch, products) in problem.segments.iter().zip(&products) {
        let columns = problem.columns_of(stretch.track);
        let track = &problem.tracks[stretch.track];
        let (from, to) = (track.time[stretch.first], track.time[stretch.last]);
        for (k, products_of) in products.chunks(together).enumerate() {
            let mut block = Sums { s: DMatrix::zeros(p, 1), a: DMatrix::zeros(p, p) };
            for product in products_of {
                for (i, to_i) in columns.iter().enumerate() {
                    block.s[(*to_i, 0)] += product[(i, columns.len())];
                    for (j, to_j) in columns.iter().enumerate() {
                        block.a[(*to_i, *to_j)] += product[(i, j)];
                    }
                }
            }
            let share = (k * together) as f64 / products.len() as f64;
            starts.push((track.run, from + (to - from) * share));
            blocks.push(block);
        }
    }
    let after = |k: usize| Part { blocks: k..blocks.len(), run: starts[k].0, from: Some(starts[k].1) };
    let mut parts: Vec<Part> = (1..blocks.len()).map(after).collect();
    let runs_alone = (0..runs.len()).filter_map(|run| {
        let first = starts.iter().position(|(r, _)| *r == run)?;
        let count = starts.iter().filter(|(r, _)| *r == run).count();
        (count < blocks.len()).then_some(Part { blocks: first..first + count, run, from: None })
    });
    parts.extend(runs_alone);
    (blocks, parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::estimate::filter_error::{FilterErrorOptions, filter_error};
    use crate::frame::Dof;
    use crate::model::Model;
    use crate::run::Signal;

    /// Two runs of 10 u̇ + 8 u = τ by Euler's rule at 20 Hz under white noise, the drag `share` times as large from 20 s of
    /// the second run on, and fitted with one drag.
    fn fitted(share: f64, seed: u64) -> (FilterErrorFit, Vec<Run>) {
        let mut noise = Noise::new(seed, 1);
        let mut runs = Vec::new();
        for run in 0..2 {
            let time: Vec<f64> = (0..800).map(|k| 0.05 * f64::from(k)).collect();
            let tau: Vec<f64> = time.iter().map(|t| 12.0 * (0.5 * t).sin() + 6.0 * (1.3 * t).cos()).collect();
            let mut u = 0.0;
            let logged = time.iter().zip(&tau).map(|(t, tau)| {
                let now = u;
                let drag = if run == 1 && *t >= 20.0 { 8.0 * share } else { 8.0 };
                (0..50).for_each(|_| u += 0.001 * (tau - drag * u) / 10.0);
                now + 0.01 * noise.normal()
            });
            let logged: Vec<f64> = logged.collect();
            let mut made = Run { name: format!("run{run}"), ..Run::default() };
            made.signals.insert("u".into(), Signal::new(time.clone().into(), logged));
            made.signals.insert("tau_u".into(), Signal::new(time.into(), tau));
            runs.push(made);
        }
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        model.input = crate::model::Interpolation::Hold;
        model.parameters.iter_mut().for_each(|p| p.value = 9.0);
        (filter_error(&model, &runs, &FilterErrorOptions::default()).unwrap(), runs)
    }

    /// The drag, the instant to a block (256 samples, 12.8 s), and by how much to three deviations.
    #[test]
    fn a_drag_that_changes_at_an_instant_is_told_with_the_instant() {
        let (fit, runs) = fitted(1.2, 5);
        let found = changed(&fit, &runs, 1, |_| true).unwrap();
        assert_eq!((found.parameter.as_str(), found.run.as_str()), ("linear_drag@surge k_u", "run1"));
        assert!((found.from.unwrap() - 20.0).abs() < 12.8, "{found:?}");
        assert!(found.p_value < 1e-6 && found.change > 0.8 && found.change < 2.4, "{found:?}");
        let beside = |gain: f64| {
            let mut found = found.clone();
            found.stand_beside(std::iter::once(gain));
            found.alone
        };
        // two parameters, of which the other one takes no part: less than its one of chance
        assert!(found.gain > (found.change / found.std).powi(2) - 2.0, "{found:?}");
        assert!(beside(0.9 * found.gain) && !beside(1.1 * found.gain));
        assert!(found.alone && found.told().contains(": k_u of linear_drag@surge is 1."), "{}", found.told());
    }

    /// Eight blocks that tell one parameter alike, with S of ±10: it changes once, or there and back again and again as where a
    /// linear drag is fitted to a bent one in a log that is slow and fast by turns.
    #[test]
    fn equations_of_another_shape_are_no_change_of_a_parameter() {
        let is_alone = |signs: [f64; 8]| {
            let block =
                |sign: f64| Sums { s: DMatrix::from_element(1, 1, 10.0 * sign), a: DMatrix::from_element(1, 1, 1.0) };
            let parts = (1..8).map(|k| Part { blocks: k..8, run: 0, from: Some(k as f64) }).collect();
            let log = Log::of(signs.into_iter().map(block).collect(), parts, vec![0], Vec::new()).unwrap();
            log.apart(&log.own().unwrap()).unwrap().is_alone(&log, 1).unwrap()
        };
        assert!(is_alone([1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0]));
        assert!(!is_alone([1.0, 1.0, -1.0, -1.0, 1.0, 1.0, -1.0, -1.0]));
        let told =
            ChangedParameter { alone: false, ..changed(&fitted(1.2, 5).0, &fitted(1.2, 5).1, 1, |_| true).unwrap() };
        assert!(told.told().contains("make up for it with other values"), "{}", told.told());
    }

    /// Ten campaigns in which nothing changes: their p are spread over (0, 1), and none is so small that it is told.
    #[test]
    fn where_nothing_changes_p_is_spread() {
        let p: Vec<f64> = (0..10)
            .map(|seed| {
                let (fit, runs) = fitted(1.0, seed);
                most_changed(&fit, &runs, 1, |_| true).unwrap().p_value
            })
            .collect();
        assert!(p.iter().all(|p| *p >= LEVEL), "{p:?}");
        let mean = p.iter().sum::<f64>() / 10.0;
        // 0.5 ± 0.09 of ten uniform numbers, to three deviations
        assert!((mean - 0.5).abs() < 0.27, "{p:?}");
    }
}
