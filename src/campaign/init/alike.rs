//! Logs with the same header are read alike: what the reader tolerates in one of them it tolerates
//! in all, and the yaw rate has one sign in all of them.

use std::collections::BTreeMap;

use super::reading::Understood;
use crate::log::options::{ColumnSource, Duplicates, Missing, Repeated, Truncated};

/// Makes the options of logs with the same header equal.
pub fn settle(logs: &mut [Understood]) {
    let mut alike: BTreeMap<Vec<String>, Vec<usize>> = BTreeMap::new();
    for (k, log) in logs.iter().enumerate().filter(|(_, log)| log.log.is_some()) {
        alike.entry(log.headers.clone()).or_default().push(k);
    }
    for group in alike.into_values().filter(|group| group.len() > 1) {
        let_pass(logs, &group);
        turn(logs, &group);
    }
}

/// Tolerates in all logs what one of them needs.
fn let_pass(logs: &mut [Understood], group: &[usize]) {
    let mut texts: Vec<String> = group.iter().flat_map(|k| logs[*k].options.missing_values.clone()).collect();
    texts.sort();
    texts.dedup();
    let all: Vec<Understood> = group.iter().map(|k| logs[*k].clone()).collect();
    for k in group {
        let this = &mut logs[*k];
        for other in &all {
            let (own, theirs) = (&mut this.options, &other.options);
            let mut taken = Vec::new();
            if own.missing == Missing::Error && theirs.missing != Missing::Error {
                own.missing = theirs.missing;
                taken.push("missing");
            }
            if own.duplicates == Duplicates::Error && theirs.duplicates != Duplicates::Error {
                own.duplicates = theirs.duplicates;
                taken.push("duplicates");
            }
            if own.truncated == Truncated::Error && theirs.truncated != Truncated::Error {
                own.truncated = theirs.truncated;
                taken.push("truncated");
            }
            if own.repeated == Repeated::Auto && theirs.repeated == Repeated::NoSample {
                own.repeated = Repeated::NoSample;
                taken.push("repeated");
            }
            for key in taken {
                if let Some(reason) = other.reasons.get(key) {
                    this.guess(key, format!("{reason} ({})", other.shown));
                }
            }
        }
        if this.options.missing_values != texts {
            this.options.missing_values.clone_from(&texts);
            let said = all.iter().find_map(|other| Some((other.reasons.get("missing_values")?, &other.shown)));
            if let Some((reason, shown)) = said.filter(|_| !this.reasons.contains_key("missing_values")) {
                this.guess("missing_values", format!("{reason} ({shown})"));
            }
        }
    }
}

/// Gives the yaw rate of all logs the sign of the majority of those logs whose heading tells it.
fn turn(logs: &mut [Understood], group: &[usize]) {
    let votes: Vec<(usize, f64)> = group.iter().filter_map(|k| Some((*k, logs[*k].turns?))).collect();
    let reversed = votes.iter().filter(|(_, turns)| *turns < 0.0).count();
    if reversed == 0 || reversed == votes.len() && votes.len() == group.len() {
        return;
    }
    let counts_back = 2 * reversed > votes.len();
    for k in group {
        let own = votes.iter().find(|(vote, _)| vote == k).map(|(_, turns)| *turns < 0.0);
        // the sign of a log whose heading does not tell has not been changed so far
        if own.unwrap_or(false) == counts_back {
            continue;
        }
        let this = &mut logs[*k];
        let source = this.options.columns.entry("r".into()).or_insert_with(|| ColumnSource::from("r"));
        source.sign = -source.sign;
        let sign = source.sign;
        let why = match own {
            Some(_) => "with doubt: this log alone suggests the opposite sign of psi",
            None => "the headings of the logs with the same header agree on this",
        };
        let before = this.reasons.get("columns.r").map_or_else(|| "r".to_string(), Clone::clone);
        this.guess("columns.r", format!("{before}; sign = {sign} in all logs of this header, {why}"));
    }
}
