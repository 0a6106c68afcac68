//! Assignment of requests to functions.

use std::io::Read;
use std::sync::Arc;

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::answer::{Answer, Refusal};
use super::edit::runs::Stretch;
use super::query::Query;
use super::server::read_body;
use super::workspace::Workspace;
use super::{columns, discovery, effects, fit, logs, outline, page, plot, report, stretches};

/// A request that has passed the access control.
pub(super) struct Asked<'a> {
    pub post: bool,
    pub query: Query,
    /// Stamp of the campaign that a change is meant for.
    pub stamp: Option<String>,
    pub body: &'a mut dyn Read,
}

/// Maximum size of a request other than a log, bytes.
const MOST: u64 = 1 << 20;

impl Asked<'_> {
    /// The body, a JSON object; an empty body counts as `{}`.
    fn json<T: DeserializeOwned>(&mut self) -> Result<T, Refusal> {
        let bytes = read_body(self.body, MOST)?;
        let bytes = if bytes.is_empty() { b"{}".as_slice() } else { &bytes };
        serde_json::from_slice(bytes)
            .map_err(|e| Refusal::bad(format!("the request does not have the expected form: {e}")))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OfRun {
    run: usize,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NewStretch {
    run: usize,
    stretch: Stretch,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Switch {
    name: String,
    on: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Named {
    name: String,
}

/// Answers a request.
pub(super) fn answer(workspace: &Arc<Workspace>, mut asked: Asked<'_>) -> Result<Answer, Refusal> {
    let path = std::mem::take(&mut asked.query.path);
    let query = |name: &str| asked.query.value(name).to_string();
    // a change of the campaign answers with its new outline
    let outlined = |changed: Result<(), Refusal>| changed.and_then(|()| outline::outline(workspace));
    if let Some(meant) = asked.stamp.as_ref()
        && *meant != workspace.stamp()?
    {
        let text = "the campaign file was changed elsewhere meanwhile: check its current content, and repeat the edit";
        return Err(Refusal::conflict(text));
    }
    match (asked.post, path.as_str()) {
        (false, "/") => page::page(),
        (false, "/api/campaign") => outline::outline(workspace),
        (false, "/api/check") => Ok(Answer::json(&*workspace.check()?)),
        (false, "/api/progress") => outline::progress(workspace),
        (false, "/api/columns") => columns::columns(workspace, &query("log")),
        (false, "/api/plot") => plot::plot(workspace, &query("log"), &query("channel"), &query("below")),
        (false, "/api/fit") => fit::result(workspace),
        (false, "/api/overlay") => fit::overlay(workspace, &query("run")),
        (false, "/api/discovery") => discovery::result(workspace),
        (false, "/report") => report::open(workspace),
        (true, "/api/log") => logs::receive(workspace, &query("name"), asked.body),
        (true, "/api/runs") => outlined(logs::add(workspace, &asked.json()?)),
        (true, "/api/columns") => outlined(columns::set(workspace, &asked.json()?)),
        (true, "/api/stretch") => {
            let NewStretch { run, stretch } = asked.json()?;
            outlined(stretches::set(workspace, run, stretch))
        }
        (true, "/api/stretch/add") => {
            let NewStretch { run, stretch } = asked.json()?;
            outlined(stretches::add(workspace, run, stretch))
        }
        (true, "/api/stretch/remove") => outlined(stretches::remove(workspace, asked.json::<OfRun>()?.run)),
        (true, "/api/effect") => {
            let Switch { name, on } = asked.json()?;
            outlined(effects::switch(workspace, &name, on))
        }
        (true, "/api/adopt") => outlined(discovery::adopt(workspace, &asked.json::<Named>()?.name)),
        (true, "/api/undo") => outlined(workspace.undo()),
        (true, "/api/fit") => fit::begin(workspace),
        (true, "/api/discovery") => discovery::begin(workspace),
        (true, "/api/report") => report::begin(workspace, asked.json()?),
        (true, "/api/stop") => {
            match asked.json::<Named>()?.name.as_str() {
                "fit" => workspace.fit.stop(),
                "discovery" => workspace.discovery.stop(),
                "report" => workspace.report.stop(),
                other => return Err(Refusal::bad(format!("no task is called {other:?}"))),
            }
            outline::progress(workspace)
        }
        _ => Err(Refusal::absent(format!("there is nothing at {path}"))),
    }
}
