//! The search for missing effects, and the adoption of a found effect into the campaign.

use std::sync::Arc;

use serde::Serialize;

use super::answer::{Answer, Refusal};
use super::edit::effects;
use super::workspace::Workspace;
use crate::campaign::{self, Adoption};
use crate::discover::{Discovery, FoundEffect, LogFinding, Verdict, Where};
use crate::finding::Finding;
use crate::report::figure;
use crate::report_content::gap_figure;

/// Result of a search, with the stamp of its campaign.
pub(super) struct Found {
    pub stamp: String,
    pub discovery: Discovery,
}

/// Starts the search.
pub(super) fn begin(workspace: &Arc<Workspace>) -> Result<Answer, Refusal> {
    let shared = workspace.clone();
    let number = workspace.discovery.begin(move |_| {
        let stamp = shared.stamp()?;
        let campaign = shared.campaign()?;
        Ok(Found { stamp, discovery: campaign::discover(&campaign)? })
    });
    Ok(Answer::json(&serde_json::json!({"number": number})))
}

/// Number of places that are shown; the JSON of the command line contains all.
const PLACES: usize = 5;

#[derive(Serialize)]
struct Shown<'a> {
    /// Stamp of the campaign that was searched.
    stamp: &'a str,
    verdict: Verdict,
    sentence: &'a str,
    effects: &'a [FoundEffect],
    adopt: &'a [String],
    behaves_like: Vec<String>,
    #[serde(rename = "where")]
    places: Vec<&'a Where>,
    log_findings: &'a [LogFinding],
    next_experiment: Option<&'a str>,
    figure: Option<String>,
    warnings: &'a [Finding],
}

/// The last search; `null` if there is none.
pub(super) fn result(workspace: &Workspace) -> Result<Answer, Refusal> {
    let Some(found) = workspace.discovery.result() else { return Ok(Answer::json(&None::<Shown<'_>>)) };
    let of = &found.discovery;
    Ok(Answer::json(&Shown {
        stamp: &found.stamp,
        verdict: of.verdict,
        sentence: &of.sentence,
        effects: &of.effects,
        adopt: &of.adopt,
        behaves_like: of.resemblances().map(|like| like.told()).collect(),
        places: of.places.iter().take(PLACES).collect(),
        log_findings: &of.log_findings,
        next_experiment: of.next_experiment.as_deref(),
        figure: gap_figure(of).map(|shown| figure(&shown, "gap")),
        warnings: &of.warnings,
    }))
}

/// Adds an effect to the campaign, and the runs that took part in the search to the fit, as
/// `discover --adopt` does.
pub(super) fn adopt(workspace: &Workspace, name: &str) -> Result<(), Refusal> {
    let found = workspace.discovery.result();
    let adoption = found.as_ref().map_or_else(Adoption::default, |found| Adoption::from(&found.discovery));
    workspace.edit(|text| {
        let text = effects::with(text, name)?;
        campaign::with_input(&text, adoption.input)
            .and_then(|text| campaign::with_training(&text, &workspace.file, adoption.training))
            .map_err(Refusal::unusable)
    })
}
