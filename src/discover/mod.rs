//! Search for missing effects: where simulation and data disagree, which effect closes the gap, and by how much.

mod again;
mod appeared;
mod begun;
mod between_rows;
mod candidate;
mod columns;
mod constancy;
mod disagreement;
mod discovery;
mod enlarged;
mod focus;
mod found;
mod gap;
mod held_out;
mod judged;
mod lacking;
mod naming;
mod next;
mod parts;
mod pushed;
mod refit;
mod residual;
mod rivalry;
mod roles;
mod rules;
mod screen;
mod search;
mod searched;
mod simulated_states;
mod slow_force;
mod stepped;
mod surrogate;
mod task;
mod timed;
mod verdict;

use std::collections::BTreeSet;

pub use candidate::{Candidate, candidates};
pub use columns::{Columns, ModelOnRuns, Probe, in_chunks};
pub use constancy::{ChangedParameter, RunInstant};
pub use disagreement::{Where, disagreement};
pub use discovery::{CODES, Discovery, LogFinding, NO_NAME};
pub use found::{AS_A_WHOLE, FoundEffect, FoundParameter, SmallestVisible};
pub use gap::{GapForce, GapOfRun, GapPrediction, GapStep};
pub use lacking::{Lacking, lacking};
pub use residual::{Change, Dependence, Residual, residuals};
pub use roles::discover;
pub use screen::{Score, Screen, screen};
pub use searched::{Added, BehavesLike, Search, Step};
pub use task::SearchOptions;
pub use timed::{begun, fitted};
pub use verdict::Verdict;

use crate::run::Run;
pub use crate::wording::LEAST_P;

/// Channels that every run logs.
pub(crate) fn common_channels(runs: &[Run]) -> BTreeSet<String> {
    let mut all: BTreeSet<String> = runs.first().map(|r| r.signals.keys().cloned().collect()).unwrap_or_default();
    all.retain(|name| runs.iter().all(|run| run.signal(name).is_some_and(|s| !s.is_empty())));
    all
}
