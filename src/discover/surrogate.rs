//! Names in a model that fails: an effect that stands in for something else is no name, and is left out of the result.
//!
//! ```text
//! a name stands where   −2 ln L fell by it by half of all that it fell by,   and half of the gap that it met is closed
//! ```

use super::candidate::Candidate;
use super::gap::{GapStep, excess};
use super::refit::{afresh, level};
use super::searched::{BEHAVES, BehavesLike, Search, Step};
use super::task::{Task, asked, screened};
use crate::estimate::filter_error::{FilterErrorFit, filter_error_from};
use crate::estimate::output_error::OutputErrorError;

/// Least share of the fall of −2 ln L, and of the gap, for a name to remain in a model that fails: most of the
/// missing effect must be its own.
const MOST: f64 = 0.5;

/// Removes the names that stand in for something else, reports them as "behaves like", and returns them.
pub(super) fn surrogates(found: &mut Search, gap: &[GapStep]) -> Vec<Candidate> {
    let total: f64 = found.added.iter().map(|a| a.gain).sum();
    let closes = |id: &str| {
        let by_it = |steps: &[GapStep]| {
            steps[1].added.as_deref() == Some(id) && excess(&steps[1]) <= (1.0 - MOST) * excess(&steps[0])
        };
        gap.windows(2).any(by_it)
    };
    let (stand, fallen): (Vec<_>, Vec<_>) = std::mem::take(&mut found.added)
        .into_iter()
        .partition(|a| a.gain >= MOST * total && closes(&a.candidate.name()));
    found.added = stand;
    for added in &fallen {
        let why = "it may stand in for something else that the catalogue does not contain".to_string();
        found.behaves_like.push(BehavesLike { id: added.candidate.name(), why, gain: added.gain });
    }
    found.behaves_like.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    found.behaves_like.truncate(BEHAVES);
    fallen.into_iter().map(|added| added.candidate).collect()
}

/// Removes `fallen` from the model, which becomes the baseline, or that of the remaining names refitted; and scores the
/// candidates beside it.
///
/// # Errors
/// [`OutputErrorError`] when the runs lack what a candidate reads.
pub(super) fn leave_out(found: &mut Search, fallen: &[Candidate], task: &Task<'_>) -> Result<(), OutputErrorError> {
    let fit = found.added.last().and_then(|_| without(found.last_fit(), fallen, task));
    found.steps.truncate(1);
    match (found.added.last(), fit) {
        (Some(added), Some(fit)) => found.steps.push(Step { name: Some(added.candidate.name()), fit }),
        // if the rest cannot be fitted any more, no name remains
        _ => found.added.clear(),
    }
    let fit = found.last_fit();
    let list = asked(&fit.model, task);
    found.screen = screened(fit, &list, task)?;
    found.candidates = list;
    Ok(())
}

/// The last fit repeated without the terms of `fallen`.
fn without(last: &FilterErrorFit, fallen: &[Candidate], task: &Task<'_>) -> Option<FilterErrorFit> {
    let mut model = last.model.clone();
    fallen.iter().for_each(|candidate| candidate.remove_from(&mut model));
    filter_error_from(&model, task.train, afresh(&last.noise), &level(task)).ok()
}
