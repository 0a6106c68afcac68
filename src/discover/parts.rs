//! Parts of a log and their scores: the sums and the test of [`super::constancy`].
//!
//! ```text
//! z² = S_j²/C,   C = A_jj − A_j· (Σ A)⁻¹ A·j          over a part;  the greatest of all parts and parameters counts
//! ```
//!
//! A parameter that is not estimated, because its effect is not in the model, has columns in S and A but none in (Σ
//! A)⁻¹: the estimated parameters absorb part of it, and it absorbs nothing.

use std::collections::BTreeSet;

use faer::Mat;
use nalgebra::DMatrix;

use super::screen::{log_survival, root};
use crate::estimate::filter_error::FilterErrorFit;
use crate::noise::Noise;
use crate::run::Run;

/// Number of samples of a block.
pub(super) const BLOCK: usize = 256;

/// Maximum number of blocks of a log: instants are resolved to one block.
const MOST_BLOCKS: usize = 256;

/// Number of draws of the greatest z² by chance.
const DRAWS: usize = 1000;

/// Stream of the seed for the draws.
const STREAM: u64 = 0xc057;

/// Probability of a change by chance, over all parameters and parts, below which it is reported. With whiteness and
/// predictions, at one in a thousand each, a correct model is doubted less than once in a hundred times.
pub(super) const LEVEL: f64 = 5e-3;

/// Least share of a parameter's information that a part of the log must hold: below it, z² depends on a few samples,
/// and on the correlation of their residuals.
const LEAST_SHARE: f64 = 0.02;

/// Sums of a part of the log.
#[derive(Clone)]
pub(super) struct Sums {
    /// One column.
    pub(super) s: DMatrix<f64>,
    pub(super) a: DMatrix<f64>,
}

/// A part of the log, as blocks, and its run and first instant.
#[derive(Clone)]
pub(super) struct Part {
    pub(super) blocks: std::ops::Range<usize>,
    pub(super) run: usize,
    pub(super) from: Option<f64>,
}

/// The log in blocks over the unknowns, one run after the other, with the tested parts and unknowns.
pub(super) struct Log {
    blocks: Vec<Sums>,
    pub(super) parts: Vec<Part>,
    /// The unknowns that are estimated: all but those of effects that are not in the model.
    estimated: Vec<usize>,
    /// The unknowns that are tested.
    asked: Vec<usize>,
    /// Information of the priors.
    priors: Vec<(usize, f64)>,
    /// (Σ A)⁻¹ over the estimated, priors included; 0 elsewhere.
    inverse: DMatrix<f64>,
    /// C of each part: unknowns and their information after projection on the others.
    left: Vec<Vec<(usize, f64)>>,
}

/// The greatest z².
pub(super) struct Greatest {
    pub(super) z2: f64,
    pub(super) part: usize,
    pub(super) unknown: usize,
    pub(super) s: f64,
    pub(super) c: f64,
}

/// A change of several unknowns: how much each changes with it.
pub(super) type Direction = Vec<(usize, f64)>;

/// The changes that raise the likelihood most in a part.
pub(super) struct Together {
    pub(super) part: usize,
    /// Fall of −2 ln L, beyond chance.
    pub(super) gain: f64,
    /// Each direction on which the part holds information, and how far along it the unknowns are there.
    pub(super) changes: Vec<(usize, f64)>,
}

impl Log {
    /// Builds the log from blocks, one run after the other; `estimated` are the estimated unknowns, `asked` may change.
    pub(super) fn of(
        blocks: Vec<Sums>,
        parts: Vec<Part>,
        (estimated, asked): (Vec<usize>, Vec<usize>),
        priors: Vec<(usize, f64)>,
    ) -> Option<Log> {
        let p = blocks.first()?.a.nrows();
        let until = sums(blocks.iter().map(|block| &block.a), DMatrix::zeros(p, p));
        let all = &until[blocks.len()];
        let mut total = all.clone();
        priors.iter().for_each(|(k, information)| total[(*k, *k)] += information);
        let inverse_of = total.select_rows(&estimated).select_columns(&estimated).cholesky()?.inverse();
        let mut inverse = DMatrix::zeros(p, p);
        for (i, to_i) in estimated.iter().enumerate() {
            for (j, to_j) in estimated.iter().enumerate() {
                inverse[(*to_i, *to_j)] = inverse_of[(i, j)];
            }
        }
        let left = |part: &Part| {
            let a = &until[part.blocks.end] - &until[part.blocks.start];
            let of = |j: &usize| {
                let c = a[(*j, *j)] - (a.row(*j) * &inverse * a.column(*j))[0];
                (c > LEAST_SHARE * all[(*j, *j)]).then_some((*j, c))
            };
            asked.iter().filter_map(of).collect()
        };
        let left = parts.iter().map(left).collect();
        Some(Log { blocks, parts, estimated, asked, priors, inverse, left })
    }

    /// The log with all estimated and tested unknowns freed in the part that was `found`: an event may change more
    /// than one parameter.
    pub(super) fn apart(&self, found: &Greatest) -> Option<Apart> {
        let part = self.parts[found.part].blocks.clone();
        let own = self.left[found.part].iter().map(|(unknown, _)| *unknown);
        let own: Vec<usize> = own.filter(|j| self.estimated.contains(j)).collect();
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
        let p = self.inverse.nrows();
        let estimated = self.estimated.iter().copied().chain(p..p + own.len()).collect();
        let log = Log::of(blocks, self.parts.clone(), (estimated, self.asked.clone()), self.priors.clone())?;
        // chance gives one per parameter
        let gain = fall(&log) - fall(self) - own.len() as f64;
        Some(Apart { log, part, freed: own, gain })
    }

    /// The greatest z² of the log itself.
    pub(super) fn own(&self) -> Option<Greatest> {
        self.greatest(self.blocks.iter().map(|block| block.s.clone()).collect()).pop().flatten()
    }

    /// The part in which the likelihood gains most if the unknowns change along `directions`, along the first in any case.
    pub(super) fn together(&self, directions: &[Direction]) -> Option<Together> {
        let p = self.inverse.nrows();
        let mut d = DMatrix::zeros(p, directions.len());
        for (column, direction) in directions.iter().enumerate() {
            direction.iter().for_each(|(unknown, weight)| d[(*unknown, column)] += weight);
        }
        let scores = self.centred(self.blocks.iter().map(|block| block.s.clone()).collect());
        let information = sums(self.blocks.iter().map(|block| &block.a), DMatrix::zeros(p, p));
        let all = d.transpose() * &information[self.blocks.len()] * &d;
        let of = |(part, Part { blocks, .. }): (usize, &Part)| {
            let columns = (&information[blocks.end] - &information[blocks.start]) * &d;
            let s = d.transpose() * (&scores[blocks.end] - &scores[blocks.start]);
            let c = d.transpose() * &columns - columns.transpose() * &self.inverse * &columns;
            let own: Vec<usize> = (0..d.ncols()).filter(|k| c[(*k, *k)] > LEAST_SHARE * all[(*k, *k)]).collect();
            let s = s.select_rows(&own);
            let change = -c.select_rows(&own).select_columns(&own).cholesky()?.solve(&s);
            // chance gives one per direction
            let gain = -s.dot(&change) - own.len() as f64;
            let changes: Vec<(usize, f64)> = own.into_iter().zip(change.iter().copied()).collect();
            changes.first().is_some_and(|(first, _)| *first == 0).then_some(Together { part, gain, changes })
        };
        self.parts.iter().enumerate().filter_map(of).max_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    /// Draws of S under chance, block by block, one column per draw.
    pub(super) fn by_chance(&self, seed: u64) -> Vec<DMatrix<f64>> {
        let mut noise = Noise::new(seed, STREAM);
        let drawn = |block: &Sums| {
            // rounding may leave a block without a root: its columns are then drawn independently
            let alone = || DMatrix::from_diagonal(&block.a.diagonal().map(|a| a.max(0.0).sqrt()));
            root(&block.a).unwrap_or_else(alone) * DMatrix::from_fn(block.a.nrows(), DRAWS, |_, _| noise.normal())
        };
        self.blocks.iter().map(drawn).collect()
    }

    /// The greatest z² of each draw, smallest first.
    pub(super) fn drawn(&self, scores: Vec<DMatrix<f64>>) -> Vec<f64> {
        let mut drawn: Vec<f64> = self.greatest(scores).into_iter().flatten().map(|g| g.z2).collect();
        drawn.sort_by(f64::total_cmp);
        drawn
    }

    /// The greatest z² of each column of the blocks' S, after removing the effect of a step of the estimate.
    fn greatest(&self, scores: Vec<DMatrix<f64>>) -> Vec<Option<Greatest>> {
        let until = self.centred(scores);
        let of = |column: usize| self.of_column(&until, column).max_by(|a, b| a.z2.total_cmp(&b.z2));
        (0..until[0].ncols()).map(of).collect()
    }

    /// The greatest z² of each unknown of the log itself, in descending order.
    pub(super) fn own_of_each(&self) -> Vec<Greatest> {
        let until = self.centred(self.blocks.iter().map(|block| block.s.clone()).collect());
        let mut all: Vec<Greatest> = self.of_column(&until, 0).collect();
        all.sort_by(|a, b| b.z2.total_cmp(&a.z2));
        let mut seen = BTreeSet::new();
        all.retain(|g| seen.insert(g.unknown));
        all
    }

    /// Cumulative sums of the blocks' S, after removing the effect of a step of the estimate.
    fn centred(&self, scores: Vec<DMatrix<f64>>) -> Vec<DMatrix<f64>> {
        let none = DMatrix::zeros(self.inverse.nrows(), scores.first().map_or(0, DMatrix::ncols));
        let step = &self.inverse * scores.iter().fold(none.clone(), |sum, s| sum + s);
        let centred: Vec<DMatrix<f64>> =
            scores.into_iter().zip(&self.blocks).map(|(s, block)| s - &block.a * &step).collect();
        sums(centred.iter(), none)
    }

    /// z² of every part and every unknown on which it holds information.
    fn of_column<'a>(&'a self, until: &'a [DMatrix<f64>], column: usize) -> impl Iterator<Item = Greatest> + 'a {
        self.left.iter().enumerate().flat_map(move |(part, left)| {
            let blocks = &self.parts[part].blocks;
            let (first, last) = (&until[blocks.start], &until[blocks.end]);
            left.iter().map(move |(unknown, c)| {
                let s = last[(*unknown, column)] - first[(*unknown, column)];
                Greatest { z2: s * s / c, part, unknown: *unknown, s, c: *c }
            })
        })
    }
}

/// `rows` of a block, with those of the unknowns `own` repeated below; the copies are 0 outside of the part.
fn with_own(rows: &DMatrix<f64>, own: &[usize], is_in_part: bool) -> DMatrix<f64> {
    let (p, more) = (rows.nrows(), own.len());
    let mut all = rows.clone().resize_vertically(p + more, 0.0);
    if is_in_part {
        all.rows_mut(p, more).copy_from(&rows.select_rows(own));
    }
    all
}

/// A log in a part of which some parameters have values of their own.
pub(super) struct Apart {
    log: Log,
    part: std::ops::Range<usize>,
    /// The unknowns with values of their own.
    freed: Vec<usize>,
    /// Fall of −2 ln L with them, beyond chance.
    pub(super) gain: f64,
}

impl Apart {
    /// Whether nothing else changes beyond chance beside it; `of` is the log without the freed unknowns.
    pub(super) fn is_alone(&self, of: &Log, seed: u64) -> Option<bool> {
        let beside = self.log.own()?;
        let drawn = of.by_chance(seed).into_iter().enumerate();
        let drawn = drawn.map(|(k, s)| with_own(&s, &self.freed, self.part.contains(&k))).collect();
        // an instant is resolved to a block: of m blocks the first may be unchanged, and the rest differ from their
        // mean by 1/m
        Some(beside.z2 * self.part.len() as f64 <= self.gain || beyond(beside.z2, &self.log.drawn(drawn)) >= LEVEL)
    }
}

/// Cumulative sums of a series, from the empty sum on.
fn sums<'a>(series: impl Iterator<Item = &'a DMatrix<f64>>, none: DMatrix<f64>) -> Vec<DMatrix<f64>> {
    let mut until = vec![none];
    series.for_each(|next| until.push(&until[until.len() - 1] + next));
    until
}

/// Probability that the greatest z² exceeds `z2`: counted from the draws, or, if none exceeds it, from the tail of
/// the number of independent parts that the draws imply.
pub(super) fn beyond(z2: f64, drawn: &[f64]) -> f64 {
    let count = drawn.iter().filter(|d| **d > z2).count();
    if count > 0 || drawn.is_empty() {
        return count as f64 / drawn.len().max(1) as f64;
    }
    let middle = drawn[drawn.len() / 2];
    let independent = (0.5f64.ln() - log_survival(middle, 1)).exp();
    (independent * log_survival(z2, 1).exp()).min(1.0 / drawn.len() as f64)
}

/// Fall of −2 ln L by chance with `count` parameters more, in the best of `tried` parts and effects.
pub(super) fn by_chance(count: usize, tried: f64) -> f64 {
    count as f64 + 2.0 * (tried / LEVEL).ln()
}

/// Divides the log into blocks over the unknowns and `more` that are not in the model, one run after the other, and
/// returns them with the parts to be tested; `products` are those of each stretch, block by block.
pub(super) fn divided(
    fit: &FilterErrorFit,
    runs: &[Run],
    products: &[Vec<Mat<f64>>],
    more: usize,
) -> (Vec<Sums>, Vec<Part>) {
    let problem = &fit.filtered.problem;
    let p = problem.unknowns.len() + more;
    let (mut blocks, mut starts): (Vec<Sums>, Vec<(usize, f64)>) = (Vec::new(), Vec::new());
    let together = products.iter().map(Vec::len).sum::<usize>().div_ceil(MOST_BLOCKS).max(1);
    for (stretch, products) in problem.segments.iter().zip(products) {
        let columns: Vec<usize> = problem.columns_of(stretch.track).into_iter().chain(p - more..p).collect();
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

    /// Eight blocks with equal information on one parameter and S of ±10: it changes once, or repeatedly there and
    /// back, as if a linear drag is fitted to a nonlinear one in a log of alternating slow and fast motion.
    #[test]
    fn equations_of_another_shape_are_no_change_of_a_parameter() {
        let is_alone = |signs: [f64; 8]| {
            let block =
                |sign: f64| Sums { s: DMatrix::from_element(1, 1, 10.0 * sign), a: DMatrix::from_element(1, 1, 1.0) };
            let parts = (1..8).map(|k| Part { blocks: k..8, run: 0, from: Some(k as f64) }).collect();
            let log = Log::of(signs.into_iter().map(block).collect(), parts, (vec![0], vec![0]), Vec::new()).unwrap();
            log.apart(&log.own().unwrap()).unwrap().is_alone(&log, 1).unwrap()
        };
        assert!(is_alone([1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0]));
        assert!(!is_alone([1.0, 1.0, -1.0, -1.0, 1.0, 1.0, -1.0, -1.0]));
    }

    /// Two columns that are the same signal from the fifth block on. The first is estimated and also present before;
    /// the second is not estimated and begins there.
    #[test]
    fn what_is_not_in_the_model_may_begin_at_an_instant() {
        let block = |k: usize| {
            let late = f64::from(u8::from(k >= 4));
            // a drag of which 0.2 is missing from there on: over the whole log 0.1 of it is estimated
            let (s, a) = (if late > 0.0 { -10.0 } else { 10.0 }, 100.0);
            Sums {
                s: DMatrix::from_column_slice(2, 1, &[s, s * late]),
                a: DMatrix::from_row_slice(2, 2, &[a, a * late, a * late, a * late]),
            }
        };
        let parts = (1..8).map(|k| Part { blocks: k..8, run: 0, from: Some(k as f64) }).collect();
        let log = Log::of((0..8).map(block).collect(), parts, (vec![0], vec![0, 1]), Vec::new()).unwrap();
        let found = log.own().unwrap();
        assert_eq!(log.parts[found.part].from, Some(4.0));
        // δ = −S/C with S = −40 and C = 400 − 400²/800
        assert!((-found.s / found.c - 0.2).abs() < 1e-12, "{} {}", found.s, found.c);
        // the estimated parameter would have to change there by as much
        let of_each = log.own_of_each();
        assert!(of_each.len() == 2 && (of_each[0].z2 - of_each[1].z2).abs() < 1e-9);
        assert!(of_each.iter().any(|of| of.unknown == 1));
    }

    /// Two unknowns that both change by a fifth from the fifth block on, one of them twice as large, and one that does not
    /// change: together they gain twice what the changed ones gain alone, and the third gains nothing.
    #[test]
    fn a_change_of_several_unknowns_has_one_size() {
        let block = |k: usize| {
            let s = if k >= 4 { -10.0 } else { 10.0 };
            let a = [100.0, 25.0, 100.0];
            Sums {
                s: DMatrix::from_column_slice(3, 1, &[s, 0.5 * s, 0.0]),
                a: DMatrix::from_fn(3, 3, |i, j| if i == j { a[i] } else { 0.0 }),
            }
        };
        let parts = (1..8).map(|k| Part { blocks: k..8, run: 0, from: Some(k as f64) }).collect();
        let log = Log::of((0..8).map(block).collect(), parts, (vec![0, 1, 2], Vec::new()), Vec::new()).unwrap();
        let along = |directions: &[Direction]| {
            let found = log.together(directions).unwrap();
            (log.parts[found.part].from.unwrap(), found.gain + directions.len() as f64, found.changes)
        };
        // δ = −S/C with S = −40 and C = 400 − 400²/800 of the first, a quarter of C of the second
        let (from, alone, changes) = along(&[vec![(0, 1.0)]]);
        assert!((from, changes[0].0) == (4.0, 0) && (changes[0].1 - 0.2).abs() < 1e-12, "{changes:?}");
        let (from, both, changes) = along(&[vec![(0, 1.0), (1, 2.0)], vec![(2, 1.0)]]);
        assert!(from == 4.0 && (both / alone - 2.0).abs() < 1e-9, "{both} {alone}");
        assert!((changes[0].1 - 0.2).abs() < 1e-12 && changes[1].1.abs() < 1e-12, "{changes:?}");
    }
}
