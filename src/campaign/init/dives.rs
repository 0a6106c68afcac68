//! Grouping of logs that belong to one dive: each holds channels that the others lack, over the
//! same time.
//!
//! Stamps of a wall clock tell whether the time is the same. For clocks that begin at zero the logs
//! must begin and end together, or begin together and have names like the topics of one bag.

use std::collections::BTreeSet;

use super::reading::Understood;
use super::words;
use crate::log::LogFile;
use crate::log::columns::quantity;

/// Part of the longer log's duration by which beginnings and ends of one dive may differ.
const TOGETHER: f64 = 0.03;

/// Reason why two logs are taken for parts of one dive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Why {
    Stamps,
    Span,
    Names,
}

/// Groups the logs by dive: indices, in the order of the logs.
pub fn of(logs: &[Understood]) -> Vec<Vec<usize>> {
    let mut dives: Vec<Vec<usize>> = Vec::new();
    for (k, log) in logs.iter().enumerate() {
        let same = |dive: &&mut Vec<usize>| dive.iter().all(|other| completes(&logs[*other], log).is_some());
        match dives.iter_mut().find(same) {
            Some(dive) => dive.push(k),
            None => dives.push(vec![k]),
        }
    }
    dives
}

/// The reason why the logs belong to one dive, in words.
pub fn reason(logs: &[&Understood]) -> String {
    let pairs = logs.iter().enumerate().flat_map(|(k, a)| logs[k + 1..].iter().filter_map(|b| completes(a, b)));
    let why: Vec<Why> = pairs.collect();
    let is = |wanted: Why| why.iter().all(|w| *w == wanted);
    match () {
        () if is(Why::Stamps) => "by their wall-clock stamps".into(),
        () if why.contains(&Why::Names) => {
            "with doubt: their clocks start at their own zero, and their names are similar (separate dives need one \
             [[run]] each)"
                .into()
        }
        () => "with doubt: their clocks start at their own zero, and they start and end together (separate dives need \
             one [[run]] each)"
            .into(),
    }
}

/// The reason why two logs with different channels cover the same time; `None` if they do not, or
/// nothing tells.
fn completes(one: &Understood, other: &Understood) -> Option<Why> {
    let (a, b) = (one.log.as_ref()?, other.log.as_ref()?);
    let known = |log: &LogFile| -> BTreeSet<String> {
        log.signals.keys().filter(|name| quantity(name).is_some()).cloned().collect()
    };
    let (own, foreign) = (known(a), known(b));
    if own.is_empty() || foreign.is_empty() || !own.is_disjoint(&foreign) {
        return None;
    }
    let span = |log: &LogFile| {
        let origin = log.origin.unwrap_or(0.0);
        Some((origin + log.time.first()?, origin + log.time.last()?))
    };
    let ((a0, a1), (b0, b1)) = (span(a)?, span(b)?);
    let (overlap, shorter, longer) = (a1.min(b1) - a0.max(b0), (a1 - a0).min(b1 - b0), (a1 - a0).max(b1 - b0));
    if a.origin.is_some() && b.origin.is_some() {
        return (overlap > 0.5 * shorter).then_some(Why::Stamps);
    }
    if a.origin.is_some() != b.origin.is_some() || (a0 - b0).abs() > TOGETHER * longer {
        return None;
    }
    if (a1 - b1).abs() < TOGETHER * longer {
        return Some(Why::Span);
    }
    (overlap > 0.5 * longer && are_topics(&one.shown, &other.shown)).then_some(Why::Names)
}

/// Whether two file names differ only in their last word, which is not a number: `dive3_imu.csv`,
/// `dive3_dvl.csv`.
fn are_topics(one: &str, other: &str) -> bool {
    let parts = |shown: &str| {
        let name = shown.rsplit(['/', '\\']).next().unwrap_or(shown);
        let mut words = words::of(name.rsplit_once('.').map_or(name, |(stem, _)| stem)).words;
        let topic = words.pop()?;
        (!words.is_empty() && topic.chars().all(char::is_alphabetic)).then_some((words, topic))
    };
    matches!((parts(one), parts(other)), (Some(a), Some(b)) if a.0 == b.0 && a.1 != b.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_of_one_bag_are_called_alike() {
        assert!(are_topics("dive3_imu.csv", "x/dive3_dvl.csv"));
        assert!(!are_topics("dive3_imu.csv", "dive4_dvl.csv"));
        assert!(!are_topics("bollard_+12V.csv", "tow_+20cms.csv"));
        assert!(!are_topics("run1.csv", "run2.csv"));
        assert!(!are_topics("imu.csv", "dvl.csv"));
    }
}
