//! Reading options for a new log: those of the log of its name, otherwise those of logs with the
//! same columns.

use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::codes;
use super::file::CampaignFile;
use crate::finding::Finding;
use crate::log::{LogOptions, Rows};
use crate::run::RunKind;

/// One set of reading options, and the logs that are read with it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reading {
    /// Paths of the logs, relative to the campaign.
    pub files: Vec<String>,
    /// The reading options.
    pub log: LogOptions,
}

/// Returns the sets of reading options of the logs of a campaign, that of most logs first.
pub(super) fn readings(file: &CampaignFile) -> Vec<Reading> {
    let mut ways: Vec<Reading> = Vec::new();
    // a bench log is about one thruster, a bollard table may have no time
    for run in file.runs.iter().filter(|run| !matches!(run.kind, RunKind::Bench | RunKind::Bollard)) {
        for log in &run.files {
            let options = log.log.as_ref().or(run.log.as_ref()).unwrap_or(&file.log);
            match ways.iter_mut().find(|way| way.log == *options) {
                Some(way) => way.files.push(log.file.clone()),
                None => ways.push(Reading { files: vec![log.file.clone()], log: options.clone() }),
            }
        }
    }
    ways.sort_by_key(|way| std::cmp::Reverse(way.files.len()));
    ways
}

/// Returns the options with which `log` is read, and a finding if others may be meant. If none
/// suits the log, those of most logs are taken, so that the reader says what the log lacks. `None`
/// if there are none.
pub(super) fn reading_of<'a>(log: &Path, ways: &'a [Reading]) -> Option<(&'a LogOptions, Option<Finding>)> {
    if let Some(way) = by_name(log, ways) {
        return Some((&way.log, None));
    }
    let suited: Vec<&Reading> = ways.iter().filter(|way| has_columns(log, &way.log)).collect();
    let columns = |way: &&&Reading| way.log.columns.len();
    // options that name more columns know more of the log; among equals the first is that of most
    // logs
    let Some(most) = suited.iter().map(|way| way.log.columns.len()).max() else {
        return ways.first().map(|way| (&way.log, None));
    };
    let alike: Vec<&&Reading> = suited.iter().filter(|way| columns(way) == most).collect();
    let finding = alike.get(1).map(|other| {
        let [this, other] = [alike[0], other].map(|way| way.files.first().map_or("", String::as_str));
        let text = format!(
            "read like {this}, with the same columns as {other}, which is read differently{}: if this log resembles \
             that one, say with --log how it is read",
            differing(&alike[0].log, &alike[1].log)
        );
        Finding::at(&codes::READ_ALIKE, &log.display().to_string(), None, None, &text)
    });
    Some((&alike[0].log, finding))
}

/// Returns the set of the log whose path ends that of `log`, the longest such path first:
/// `a/log.csv` and `b/log.csv` are told apart.
fn by_name<'a>(log: &Path, ways: &'a [Reading]) -> Option<&'a Reading> {
    let whole = log.canonicalize().unwrap_or_else(|_| log.to_path_buf());
    let length = |file: &String| {
        // `../logs/run.csv` is relative to the campaign: only `logs/run.csv` can be in the path
        let path: PathBuf = Path::new(file).components().filter(|c| !is_step(*c)).collect();
        whole.ends_with(&path).then(|| path.components().count())
    };
    let longest = |way: &&Reading| way.files.iter().filter_map(length).max();
    // of equals the first
    ways.iter().rev().filter(|way| longest(way).is_some()).max_by_key(longest)
}

fn is_step(component: Component<'_>) -> bool {
    matches!(component, Component::CurDir | Component::ParentDir)
}

/// Whether the header of a log has the columns that these options name, and time.
fn has_columns(log: &Path, options: &LogOptions) -> bool {
    Rows::open(log, options, &["t"]).is_ok()
}

/// Returns the channels that two sets of options read differently, as ` (z)`; empty if only other
/// options differ.
fn differing(a: &LogOptions, b: &LogOptions) -> String {
    let names: Vec<&str> = a
        .columns
        .iter()
        .filter(|(name, source)| b.columns.get(*name) != Some(source))
        .map(|(name, _)| name.as_str())
        .collect();
    if names.is_empty() { String::new() } else { format!(" ({})", names.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn way(files: &[&str], sort: bool) -> Reading {
        let files = files.iter().map(|f| (*f).to_string()).collect();
        Reading { files, log: LogOptions { sort, ..LogOptions::default() } }
    }

    #[test]
    fn a_log_is_known_by_the_longest_path_that_ends_its_own() {
        let ways = [way(&["log.csv", "../c/log.csv"], false), way(&["b/log.csv"], true)];
        let sorted = |log: &str| by_name(Path::new(log), &ways).map(|way| way.log.sort);
        assert_eq!(sorted("/sea/log.csv"), Some(false));
        assert_eq!(sorted("/sea/b/log.csv"), Some(true));
        assert_eq!(sorted("/sea/c/log.csv"), Some(false));
        assert_eq!(sorted("/sea/blog.csv"), None);
    }
}
