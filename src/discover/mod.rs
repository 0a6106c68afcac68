//! Finding what is missing: where simulation and data disagree, which effect closes the gap, and how far.

mod candidate;
mod carried;
mod colour;
mod confirm;
mod discovery;
mod enlarged;
mod evidence;
mod freedom;
mod gap;
mod held_out;
mod left_open;
mod left_over;
mod next;
mod products;
mod refit;
mod residual;
mod revise;
mod score;
mod search;
mod settle;
mod stand_in;
mod thin;
mod whereabouts;

use std::collections::BTreeSet;

pub use candidate::{Candidate, candidates};
pub use discovery::{
    CODES, Discovery, FoundEffect, FoundParameter, GapOfRun, GapStep, LogFinding, SmallestVisible, TIED_ROW, Verdict,
    discover,
};
pub use evidence::{Evidence, INDISTINGUISHABLE, judge};
pub use gap::{Gap, floor, gap};
pub use left_open::{left_open, unstable};
pub use products::{Own, Products};
pub use residual::{Change, Dependence, Residual, residuals};
pub use score::{Probe, score};
pub use search::{Added, Search, SearchOptions, Step, search};
pub use whereabouts::{Where, whereabouts};

use crate::run::Run;

/// Channels that every run has.
pub(crate) fn common_channels(runs: &[Run]) -> BTreeSet<String> {
    let mut all: BTreeSet<String> = runs.first().map(|r| r.signals.keys().cloned().collect()).unwrap_or_default();
    all.retain(|name| runs.iter().all(|run| run.signal(name).is_some_and(|s| !s.is_empty())));
    all
}
