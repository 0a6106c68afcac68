//! Which candidates may stand in the place of the best one so far.
//!
//! ```text
//! A, A':  information on the parameters β that the best one brought, beside the model's others; beside the rival's α too
//! 1 − λ_min(A⁻¹ A'):  the most of a direction of β that α can take over                     all at the fit with the best one in
//! ```
//!
//! A rival that could be the truth in the place of the best one takes over most of β's signal, or is still missing with the best
//! one in. What does neither, and promised less than the best one has gained, is not refitted: after some twenty passes the refit
//! would have been given up, as one that gains less than half.

use nalgebra::DMatrix;

use super::candidate::Candidate;
use super::columns::{Columns, in_chunks};
use super::refit::Contender;
use super::rules::is_new;
use super::screen::{log_survival, project};
use super::search::Task;
use crate::estimate::filter_error::FilterErrorFit;

/// Share of the signal of the best one that a rival has to take over.
const TAKES_OVER: f64 = 0.5;

/// For each of `candidates`, whether it may stand in the place of `best`, which was added to `here`, or is missing beside it:
/// beyond chance as the logarithm of a probability below `threshold` is. Where it cannot be judged, it may.
pub(super) fn may_replace(
    best: &Contender,
    here: &FilterErrorFit,
    candidates: &[Candidate],
    threshold: f64,
    task: &Task<'_>,
) -> Vec<bool> {
    let fit = &best.fit;
    let brought: Vec<usize> = (0..fit.filtered.problem.unknowns.len())
        .filter(|k| is_new(&here.model, &fit.model.parameters[fit.filtered.problem.unknowns[*k].parameter]))
        .collect();
    if brought.is_empty() || candidates.is_empty() {
        return vec![true; candidates.len()];
    }
    let judge = |_: usize, columns: Columns| judged(fit, &columns, &brought, threshold);
    let mut may: Vec<Option<bool>> = vec![None; candidates.len()];
    let parts = in_chunks(fit.into(), task.train, candidates, &task.fitting.base, judge).unwrap_or_default();
    for (candidate, able) in parts.into_iter().flatten() {
        may[candidate] = Some(may[candidate].unwrap_or(false) || able);
    }
    may.into_iter().map(|able| able.unwrap_or(true)).collect()
}

/// Each probe's candidate, and whether it takes over what `brought` does, or is missing.
fn judged(fit: &FilterErrorFit, columns: &Columns, brought: &[usize], threshold: f64) -> Vec<(usize, bool)> {
    let assembled = columns.assembled(fit);
    let (total, e) = (&assembled.total, assembled.total.nrows() - 1);
    let others: Vec<usize> = (0..assembled.unknowns).filter(|k| !brought.contains(k)).collect();
    let able = |at: Vec<usize>| -> Option<bool> {
        let beside = |more: &[usize]| {
            let order: Vec<usize> = others.iter().chain(more).chain(brought).copied().collect();
            project(&picked(total, &order), others.len() + more.len())
        };
        let (alone, shared) = (beside(&[])?, beside(&at)?);
        let l = alone.cholesky()?.l();
        let half = l.solve_lower_triangular(&shared)?;
        let left = l.solve_lower_triangular(&half.transpose())?.symmetric_eigenvalues().min();
        let order: Vec<usize> = (0..assembled.unknowns).chain(at.iter().copied()).chain([e]).collect();
        let own = project(&picked(total, &order), assembled.unknowns)?;
        let m = at.len();
        let b = own.view((0, m), (m, 1)).column(0).into_owned();
        let statistic = b.dot(&own.view((0, 0), (m, m)).into_owned().cholesky()?.solve(&b));
        Some(1.0 - left >= TAKES_OVER || log_survival(statistic, m) <= threshold)
    };
    assembled.probes.iter().map(|(probe, at)| (probe.candidate, able(at.clone().collect()).unwrap_or(true))).collect()
}

/// Rows and columns of a symmetric matrix, in this order.
fn picked(total: &DMatrix<f64>, order: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(order.len(), order.len(), |i, j| total[(order[i], order[j])])
}
