//! Held-out runs join the fit if the runs of the fit do not show what is missing.
//!
//! ```text
//! fails on held-out runs H, |H| ≥ 2:   fit + the worse half of H  →  search again;   an answer where that leaves nothing open
//! ```
//!
//! A campaign that moves each degree of freedom alone shows no Coriolis force, but its held-out zig-zags do. An
//! effect that is found with half of them is the answer if it also corrects the other half: runs on which the model
//! failed and that took no part.

use std::sync::Arc;

use super::discovery::{Discovery, TOOK_PART, searched};
use super::task::{SearchOptions, Task};
use super::verdict::Verdict;
use crate::effects::{Effect, Place};
use crate::estimate::filter_error::FilterErrorOptions;
use crate::estimate::output_error::OutputErrorError;
use crate::finding::Finding;
use crate::model::Model;
use crate::run::{Role, Run};

/// Finds what `baseline` lacks on `runs`. Runs with the role `validate` take no part in the search and judge it; if
/// there are none, each run judges an estimate without it. If only held-out runs show what is missing, the worse half
/// of them joins the fit and the others judge.
///
/// # Errors
/// [`OutputErrorError`] when the baseline cannot be fitted or a run lacks what it reads.
pub fn discover(
    baseline: &Model,
    runs: &[Run],
    own: &[(Arc<dyn Effect>, Place)],
    fitting: &FilterErrorOptions,
    options: &SearchOptions,
) -> Result<Discovery, OutputErrorError> {
    let searched = |runs: &[Run]| {
        let (train, held): (Vec<Run>, Vec<Run>) = runs.iter().cloned().partition(|run| run.role == Role::Train);
        searched(baseline, &Task { train: &train, held: &held, own, fitting, options })
    };
    let first = searched(runs)?;
    let part = first.erring[..first.erring.len() / 2].to_vec();
    if part.is_empty() || !first.moved_otherwise.is_empty() {
        return Ok(first);
    }
    let taking_part = |run: &Run| match part.contains(&run.name) {
        true => Run { role: Role::Train, ..run.clone() },
        false => run.clone(),
    };
    let runs: Vec<Run> = runs.iter().map(taking_part).collect();
    match searched(&runs) {
        Ok(mut found) if matches!(found.verdict, Verdict::Explained | Verdict::NothingMissing) => {
            found.with_runs_that_took_part(part, "the runs of the fit alone do not explain the held-out runs");
            Ok(found)
        }
        // without a complete explanation the first search is the better answer, with the runs as the user divided them
        _ => Ok(first),
    }
}

impl Discovery {
    /// Records which held-out runs took part, and why.
    pub(crate) fn with_runs_that_took_part(&mut self, part: Vec<String>, why: &str) {
        let text = format!(
            "{} took part in the fit of this search, although held out: {why}; give {} role = \"train\" before the \
             model is fitted",
            part.join(", "),
            if part.len() > 1 { "them" } else { "it" }
        );
        self.warnings.insert(0, Finding::new(&TOOK_PART, text));
        self.took_part.extend(part);
    }
}
