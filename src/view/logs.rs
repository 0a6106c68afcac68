//! Logs that are dropped on the page: stored beside the campaign, never over another file, and
//! added to it as runs as `init` does.

use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::answer::{Answer, Refusal};
use super::edit::runs;
use super::workspace::{Workspace, plain_name};
use crate::atomic_file;
use crate::campaign::{self, InitFacts, InitRequest};

/// Maximum size of a log, bytes.
const MOST: u64 = 2 << 30;

/// A log that is now in the campaign's folder.
#[derive(Serialize)]
struct Received<'a> {
    file: &'a str,
    /// Whether the identical file was there already.
    was_there: bool,
}

/// Stores a log in the campaign's folder.
pub(super) fn receive(workspace: &Workspace, name: &str, body: &mut dyn Read) -> Result<Answer, Refusal> {
    let name = plain_name(name)?;
    let to = workspace.folder.join(name);
    if Path::new(name).extension().is_some_and(|e| e == "toml" || e == "html") {
        return Err(Refusal::bad(format!("{name} is not a log: logs are text tables, such as dive.csv")));
    }
    if std::fs::symlink_metadata(&to).is_ok() {
        return match is_same(&to, body) {
            true => Ok(Answer::json(&Received { file: name, was_there: true })),
            false => {
                Err(Refusal::conflict(format!("{name} already exists and is a different log: rename one of them")))
            }
        };
    }
    let mut bytes = 0;
    let written = atomic_file::write(&to, |file| {
        bytes = std::io::copy(&mut body.take(MOST + 1), file)?;
        if bytes > MOST { Err(std::io::ErrorKind::FileTooLarge.into()) } else { Ok(()) }
    });
    match written {
        Ok(()) => {
            workspace.keep_in_mind(name);
            Ok(Answer::json(&Received { file: name, was_there: false }))
        }
        Err(_) if bytes > MOST => Err(Refusal::too_large(format!("{name} is larger than {} GiB", MOST >> 30))),
        Err(error) => Err(Refusal::failed(format!("{name} cannot be stored: {error}"))),
    }
}

/// Whether a file has the same content as the sent one.
fn is_same(path: &Path, body: &mut dyn Read) -> bool {
    let Ok(mut file) = std::fs::File::open(path).map(std::io::BufReader::new) else { return false };
    let (mut sent, mut there) = ([0; 1 << 14], [0; 1 << 14]);
    loop {
        let Ok(count) = body.read(&mut sent) else { return false };
        if count == 0 {
            return matches!(file.read(&mut there), Ok(0));
        }
        if file.read_exact(&mut there[..count]).is_err() || sent[..count] != there[..count] {
            return false;
        }
    }
}

/// Logs that become runs, and data of the vehicle if there is no campaign yet.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct NewLogs {
    files: Vec<String>,
    /// A vehicle that comes with the program.
    vehicle: Option<String>,
    name: Option<String>,
    mass: Option<f64>,
}

/// Writes a campaign of the logs, or adds their runs to the existing one.
pub(super) fn add(workspace: &Workspace, new: &NewLogs) -> Result<(), Refusal> {
    let mut logs = Vec::new();
    for file in &new.files {
        let name = plain_name(file)?;
        let path = workspace.folder.join(name);
        if !path.is_file() {
            return Err(Refusal::absent(format!("{name} is not next to the campaign: drop it first")));
        }
        logs.push((path, name.to_string()));
    }
    if logs.is_empty() {
        return Err(Refusal::bad("no log is named"));
    }
    let is_new = workspace.text()?.trim().is_empty();
    let known = |name: &str| campaign::known_vehicles().iter().any(|known| known.id == name);
    let vehicle = new.vehicle.clone().filter(|name| is_new && !name.is_empty());
    // only a known name: `init` would also read any path
    if let Some(strange) = vehicle.as_ref().filter(|name| !known(name)) {
        return Err(Refusal::bad(format!("no vehicle of the program is called {strange:?}")));
    }
    let facts = InitFacts { name: new.name.clone().unwrap_or_default(), mass: new.mass, ..InitFacts::default() };
    let scaffold = campaign::init(&InitRequest { logs, facts, vehicle, ..InitRequest::default() })?;
    if !scaffold.unread.is_empty() {
        new.files.iter().for_each(|file| workspace.forget(file));
        return Err(Refusal::unusable(format!("not read: {}", scaffold.unread.join("\n"))));
    }
    workspace.edit(|text| {
        if is_new {
            return Ok(scaffold.text.clone());
        }
        let there: toml::Table = toml::from_str(text).unwrap_or_default();
        let runs_there = there.get("run").and_then(toml::Value::as_array);
        let of = |file: &String| {
            runs_there
                .is_some_and(|runs| runs.iter().any(|run| run.get("file").and_then(toml::Value::as_str) == Some(file)))
        };
        match new.files.iter().find(|file| of(file)) {
            Some(file) => Err(Refusal::conflict(format!("{file} is already a run of the campaign"))),
            None => runs::append(text, &scaffold.text),
        }
    })
}
