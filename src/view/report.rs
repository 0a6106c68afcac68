//! The report, saved beside the campaign.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::answer::{Answer, Refusal};
use super::workspace::{Workspace, plain_name};
use crate::progress::tell;
use crate::{campaign, report_content};

/// A saved report.
pub(super) struct Saved {
    file: PathBuf,
}

/// The requested report.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Wanted {
    /// Name of the page in the campaign's folder.
    name: String,
    /// Whether a page of that name may be replaced.
    #[serde(default)]
    replace: bool,
    /// Whether it includes the search for missing effects.
    #[serde(default)]
    discovery: bool,
}

#[derive(Serialize)]
struct Begun {
    number: u64,
    file: String,
}

/// Starts writing the report.
pub(super) fn begin(workspace: &Arc<Workspace>, wanted: Wanted) -> Result<Answer, Refusal> {
    let Wanted { name, replace, discovery } = wanted;
    let name = plain_name(&name)?.to_string();
    let file = workspace.folder.join(&name);
    if Path::new(&name).extension().is_none_or(|e| e != "html") {
        return Err(Refusal::bad(format!("{name}: a report is a page, such as report.html")));
    }
    if file.exists() && !replace {
        return Err(Refusal::conflict(format!("{name} exists: choose another name, or replace it")));
    }
    let shared = workspace.clone();
    let to = file.clone();
    let number = workspace.report.begin(move |_| {
        let (stamp, campaign) = (shared.stamp()?, shared.campaign()?);
        let known = shared.discovery.result().filter(|found| discovery && found.stamp == stamp);
        let searched = match (discovery, &known) {
            (true, None) => Some(campaign::discover(&campaign)?),
            _ => None,
        };
        let found = known.as_ref().map(|known| &known.discovery).or(searched.as_ref());
        tell("writing the report", 0, 0);
        let command = format!("hydrosysid view {}", shared.file.display());
        let html = report_content::page_of(&campaign, found, None, report_content::origin(&campaign, command, None)?)?;
        shared.write(&to, html.as_bytes())?;
        Ok(Saved { file: to })
    });
    Ok(Answer::json(&Begun { number, file: file.display().to_string() }))
}

/// The last saved report, as a page.
pub(super) fn open(workspace: &Workspace) -> Result<Answer, Refusal> {
    let saved = workspace.report.result().ok_or_else(|| Refusal::absent("no report was saved yet"))?;
    let html = std::fs::read_to_string(&saved.file)
        .map_err(|e| Refusal::absent(format!("{} cannot be read: {e}", saved.file.display())))?;
    // the report may run its own script but cannot reach this server
    let policy = "sandbox allow-scripts allow-downloads; default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; \
                  base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
    Ok(Answer::page(html, policy.into()))
}
