//! Any content of a campaign file or a log leads to a fit with finite parameters or to an error
//! with a message.
//!
//! The tests make small random changes to sound files; `fuzz/` goes further. `PROPTEST_CASES` sets
//! the number of cases.

#![allow(clippy::unwrap_used)] // tests, and the small functions they share

use std::path::Path;

use crate::swim::{CAMPAIGN, Swim};
use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign, Estimator, FitOptions};
use hydrosysid::log;
use hydrosysid::run::Run;
use proptest::prelude::*;

const FULL: &str = include_str!("../../fuzz/seeds/campaign/full.toml");

fn plain() -> String {
    format!("{CAMPAIGN}[[run]]\nfile = \"log.csv\"\n")
}

/// Words and numbers that occur in files, and some that should not.
const WORDS: [&str; 30] = [
    "0",
    "-1",
    "1e300",
    "-1e-300",
    "nan",
    "inf",
    "18446744073709551616",
    "true",
    "[]",
    "{}",
    "\"\"",
    "\"hold\"",
    "[[run]]",
    "[fit]\nsegment = 1e-300\n",
    "[fit]\nlongest_step = 1e-9\n",
    "surge",
    "yaw",
    "drag",
    "@",
    "fixed = true",
    "resample = 1e9",
    "where = \"u > 1\"",
    "kind = \"zigzag\"",
    "kind = \"constant_velocity\"",
    "\n",
    "#",
    "=",
    ".",
    "\u{fffd}",
    "1e-9",
];

/// Replaces parts of a text by words.
fn change(text: &str, edits: &[(prop::sample::Index, usize, usize)]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for (at, length, word) in edits {
        let from = at.index(bytes.len().max(1)).min(bytes.len());
        let to = (from + length).min(bytes.len());
        bytes.splice(from..to, WORDS[word % WORDS.len()].bytes());
    }
    bytes
}

fn options() -> ReadOptions {
    ReadOptions { look_for_files: false, ..ReadOptions::default() }
}

/// Fits from bytes by each estimator; returns the number of successful fits.
fn fits(campaign: &[u8], bytes: &[u8]) -> usize {
    let Ok(file) = CampaignFile::from_bytes(campaign, Path::new("campaign.toml"), &options()) else { return 0 };
    let Ok(read) = log::read_from(bytes, "log.csv", &file.log, &log::required(&file.model.dofs)) else { return 0 };
    let kind = file.runs.first().map(|run| run.kind).unwrap_or_default();
    let run = Run { name: "log.csv".into(), kind, gaps: read.gaps, signals: read.signals, ..Run::default() };
    let Ok(loaded) = Campaign::from_runs(file, vec![run]) else { return 0 };
    let fit = |estimator| match campaign::fit(&loaded, FitOptions { estimator: Some(estimator) }) {
        Ok(fit) => {
            assert!(fit.parameters.iter().all(|p| p.value.is_finite()), "{:?}", fit.parameters);
            1
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            0
        }
    };
    [Estimator::Integral, Estimator::OutputError, Estimator::Staged].into_iter().map(fit).sum()
}

fn log_text() -> String {
    Swim::new(10.0, 5.0, 1.0, 3).lines().join("\n") + "\n"
}

fn edits(most: usize) -> impl Strategy<Value = Vec<(prop::sample::Index, usize, usize)>> {
    prop::collection::vec((any::<prop::sample::Index>(), 0usize..12, 0usize..WORDS.len()), 0..most)
}

#[test]
fn unchanged_files_are_fitted() {
    assert!(fits(plain().as_bytes(), log_text().as_bytes()) >= 2);
    CampaignFile::from_bytes(FULL.as_bytes(), Path::new("campaign.toml"), &options()).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn law_any_campaign_is_survived(edits in edits(6)) {
        let bytes = change(FULL, &edits);
        match CampaignFile::from_bytes(&bytes, Path::new("campaign.toml"), &options()) {
            Err(errors) => {
                prop_assert!(!errors.errors.is_empty());
                prop_assert!(errors.to_string().contains("campaign.toml"));
            }
            Ok(campaign) => {
                let text = campaign.to_toml().unwrap();
                let again = CampaignFile::from_bytes(text.as_bytes(), Path::new("campaign.toml"), &options()).unwrap();
                let same = CampaignFile { source: None, ..again } == CampaignFile { source: None, ..campaign };
                prop_assert!(same, "{text}");
            }
        }
    }

    #[test]
    fn law_any_fit_is_survived(of_campaign in edits(3), of_log in edits(4)) {
        fits(&change(&plain(), &of_campaign), &change(&log_text(), &of_log));
    }
}
