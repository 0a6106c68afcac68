//! Candidates that may replace the best one so far.
//!
//! ```text
//! A, A':  information on the parameters β that the best one brought, beside the model's others; beside the rival's α too
//! 1 − λ_min(A⁻¹ A'):  the most of a direction of β that α can take over                     all at the fit with the best one in
//! ```
//!
//! A rival that could be the truth instead of the best one takes over most of the signal of β, or is still missing
//! with the best one in the model. A candidate that does neither, and promised less than the best one has gained, is
//! not refitted: the refit would be given up after some twenty passes, as it gains less than half. And a candidate
//! that is not missing beside one that gains more does not replace it if the judging runs do not show that one.

use nalgebra::DMatrix;

use super::candidate::Candidate;
use super::columns::{Assembled, Columns, in_chunks};
use super::refit::Contender;
use super::rules::is_new;
use super::screen::{log_survival, project};
use super::task::Task;
use crate::estimate::filter_error::FilterErrorFit;

/// Share of the signal of the best one that a rival must take over.
const TAKES_OVER: f64 = 0.5;

/// For each of `candidates`, whether it may replace `best`, which was added to `here`, or is missing beside it, that
/// is, its ln p is below `threshold`. True if it cannot be judged.
pub(super) fn may_replace(
    best: &Contender,
    here: &FilterErrorFit,
    candidates: &[Candidate],
    threshold: f64,
    task: &Task<'_>,
) -> Vec<bool> {
    let fit = &best.fit;
    let unknowns = &fit.filtered.problem.unknowns;
    let is_brought = |k: &usize| is_new(&here.model, &fit.model.parameters[unknowns[*k].parameter]);
    let brought: Vec<usize> = (0..unknowns.len()).filter(is_brought).collect();
    if brought.is_empty() || candidates.is_empty() {
        return vec![true; candidates.len()];
    }
    of_a_probe(fit, candidates, task, |total, unknowns, at| {
        Some(taken_over(total, unknowns, &brought, at)? >= TAKES_OVER || log_p(total, unknowns, at)? <= threshold)
    })
}

/// For each of `candidates`, whether it is missing beside `best`, that is, its ln p is below `threshold`. True if it
/// cannot be judged.
pub(super) fn missing_beside(best: &Contender, candidates: &[Candidate], threshold: f64, task: &Task<'_>) -> Vec<bool> {
    of_a_probe(&best.fit, candidates, task, |total, unknowns, at| Some(log_p(total, unknowns, at)? <= threshold))
}

/// For each of `candidates`, whether `judge` is true for one of its probes. Its arguments are the products beside a
/// fit, the number of unknowns, which come first in them, and the probe's columns. True if it cannot be judged.
fn of_a_probe(
    fit: &FilterErrorFit,
    candidates: &[Candidate],
    task: &Task<'_>,
    judge: impl Fn(&DMatrix<f64>, usize, &[usize]) -> Option<bool> + Sync,
) -> Vec<bool> {
    let judged = |_: usize, columns: Columns| -> Vec<(usize, bool)> {
        let Assembled { total, unknowns, probes } = columns.assembled(fit);
        let says = |at: Vec<usize>| judge(&total, unknowns, &at).unwrap_or(true);
        probes.into_iter().map(|(probe, at)| (probe.candidate, says(at.collect()))).collect()
    };
    let mut all: Vec<Option<bool>> = vec![None; candidates.len()];
    let parts = in_chunks(fit.into(), task.train, candidates, &task.fitting.base, judged).unwrap_or_default();
    for (candidate, says) in parts.into_iter().flatten() {
        all[candidate] = Some(all[candidate].unwrap_or(false) || says);
    }
    all.into_iter().map(|says| says.unwrap_or(true)).collect()
}

/// 1 − λ_min(A⁻¹ A'); β are those of the first `unknowns` columns that were `brought`, α the columns `at`.
fn taken_over(total: &DMatrix<f64>, unknowns: usize, brought: &[usize], at: &[usize]) -> Option<f64> {
    let others: Vec<usize> = (0..unknowns).filter(|k| !brought.contains(k)).collect();
    let beside = |more: &[usize]| {
        let order: Vec<usize> = others.iter().chain(more).chain(brought).copied().collect();
        project(&picked(total, &order), others.len() + more.len())
    };
    let l = beside(&[])?.cholesky()?.l();
    let half = l.solve_lower_triangular(&beside(at)?)?;
    Some(1.0 - l.solve_lower_triangular(&half.transpose())?.symmetric_eigenvalues().min())
}

/// ln p of α in the residual of the model; the last column holds the innovations.
fn log_p(total: &DMatrix<f64>, unknowns: usize, at: &[usize]) -> Option<f64> {
    let order: Vec<usize> = (0..unknowns).chain(at.iter().copied()).chain([total.nrows() - 1]).collect();
    let (own, m) = (project(&picked(total, &order), unknowns)?, at.len());
    let b = own.view((0, m), (m, 1)).column(0).into_owned();
    let statistic = b.dot(&own.view((0, 0), (m, m)).into_owned().cholesky()?.solve(&b));
    Some(log_survival(statistic, m))
}

/// Rows and columns of a symmetric matrix, in this order.
fn picked(total: &DMatrix<f64>, order: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(order.len(), order.len(), |i, j| total[(order[i], order[j])])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns: one of the model, one that was brought, two rivals of it, and innovations that are three times the
    /// second rival. The first rival is at 30° to the column that was brought, plus a share of the model's column.
    #[test]
    fn a_rival_takes_over_the_square_of_the_cosine() {
        let x = DMatrix::from_fn(4, 5, |i, j| match (i, j) {
            (0, 0) | (1, 1) | (3, 3) => 1.0,
            (0, 2) => 0.7,
            (1, 2) => 30f64.to_radians().cos(),
            (2, 2) => 30f64.to_radians().sin(),
            (3, 4) => 3.0,
            _ => 0.0,
        });
        let total = x.transpose() * x;
        assert!((taken_over(&total, 2, &[1], &[2]).unwrap() - 0.75).abs() < 1e-12);
        assert!(taken_over(&total, 2, &[1], &[3]).unwrap().abs() < 1e-12);
        assert!((log_p(&total, 2, &[3]).unwrap() - log_survival(9.0, 1)).abs() < 1e-12);
        assert!(log_p(&total, 2, &[2]).unwrap().abs() < 1e-12, "of the innovations it shows nothing");
    }
}
