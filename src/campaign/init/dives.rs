//! Logs that belong to one dive: each holds what the others lack, over the same time.

use std::collections::BTreeSet;

use super::reading::Understood;
use crate::log::LogFile;
use crate::log::columns::quantity;

/// Groups of indices of logs, each of one dive, in the order of the logs.
pub fn of(logs: &[Understood]) -> Vec<Vec<usize>> {
    let mut dives: Vec<Vec<usize>> = Vec::new();
    for (k, log) in logs.iter().enumerate() {
        let same = |dive: &&mut Vec<usize>| dive.iter().all(|other| completes(&logs[*other], log));
        match dives.iter_mut().find(same) {
            Some(dive) => dive.push(k),
            None => dives.push(vec![k]),
        }
    }
    dives
}

/// Whether two logs hold different channels over the same time.
fn completes(a: &Understood, b: &Understood) -> bool {
    let (Some(a), Some(b)) = (&a.log, &b.log) else { return false };
    let known = |log: &LogFile| -> BTreeSet<String> {
        log.signals.keys().filter(|name| quantity(name).is_some()).cloned().collect()
    };
    let (own, other) = (known(a), known(b));
    if own.is_empty() || other.is_empty() || !own.is_disjoint(&other) {
        return false;
    }
    let span = |log: &LogFile| {
        let origin = log.origin.unwrap_or(0.0);
        Some((origin + log.time.first()?, origin + log.time.last()?))
    };
    let (Some((a0, a1)), Some((b0, b1))) = (span(a), span(b)) else { return false };
    // half of the shorter one at least
    a1.min(b1) - a0.max(b0) > 0.5 * (a1 - a0).min(b1 - b0)
}
