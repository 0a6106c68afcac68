//! The files that a call reads: no output may replace one of its inputs.

use std::path::{Path, PathBuf};

use super::arguments::Verb;
use super::failure::Failure;
use crate::campaign::file::{CampaignFile, ReadOptions};

/// The files among the arguments of a verb.
pub(super) fn of(verb: &Verb) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = Vec::new();
    match verb {
        Verb::Init(a) => found.extend(a.logs.iter().cloned()),
        Verb::Check(a) => found.extend(a.files.iter().cloned()),
        Verb::Convert(a) => found.extend([Some(&a.log), a.map.as_ref()].into_iter().flatten().cloned()),
        Verb::Fit(a) => found.push(a.campaign.clone()),
        Verb::Simulate(a) => found.extend([Some(&a.campaign), a.model.as_ref()].into_iter().flatten().cloned()),
        Verb::Compare(a) => {
            let files = [Some(&a.campaign), a.other.as_ref(), a.model.as_ref(), a.params.as_ref()];
            found.extend(files.into_iter().flatten().cloned());
        }
        Verb::Discover(a) => found.push(a.campaign.clone()),
        Verb::Plan(a) => found.extend([Some(&a.source), a.runs.as_ref()].into_iter().flatten().cloned()),
        Verb::Monitor(a) => {
            found.extend(a.logs.iter().chain([&a.model]).chain(a.campaign.as_ref()).cloned());
        }
        Verb::Report(a) => found.extend([Some(&a.campaign), a.params.as_ref()].into_iter().flatten().cloned()),
        Verb::View(a) => found.push(a.campaign.clone()),
        Verb::Export(a) => found.extend(a.file.clone()),
        Verb::Demo(_) | Verb::Effects(_) | Verb::Explain(_) | Verb::Completions(_) | Verb::Man | Verb::Vehicles => {}
    }
    found
}

/// Refuses a path that cannot be read more than once, such as a pipe.
pub(super) fn is_a_file(path: &Path) -> Result<(), Failure> {
    let unread = |source| Failure::Read { file: path.to_path_buf(), source };
    match path.metadata().map_err(unread)? {
        about if about.is_file() => Ok(()),
        about if about.is_dir() => Err(unread(std::io::ErrorKind::IsADirectory.into())),
        _ => {
            let text = format!("{} can be read only once: save it as a file first", path.display());
            Err(Failure::Argument(text))
        }
    }
}

/// Refuses a pipe as the campaign of a verb that reads it more than once.
pub(super) fn can_be_read_again(verb: &Verb) -> Result<(), Failure> {
    let campaign = match verb {
        // reasons for a second read: size of its logs; whether it is a model; its hash
        Verb::Fit(a) => &a.campaign,
        Verb::Plan(a) => &a.source,
        Verb::Report(a) => &a.campaign,
        _ => return Ok(()),
    };
    match campaign.metadata() {
        Ok(about) if !about.is_dir() => is_a_file(campaign),
        // the reader of the file reports a missing one
        _ => Ok(()),
    }
}

/// Whether `output` is one of `inputs`, or a log or table that a campaign among them names.
pub(super) fn hold(inputs: &[PathBuf], output: &Path) -> bool {
    let read = ReadOptions { allow_outside: true, look_for_files: false, ..ReadOptions::default() };
    // a folder means the campaign in it; a pipe can be read only once
    let files = inputs.iter().map(|path| CampaignFile::at(path)).filter(|path| path.is_file());
    files.into_iter().any(|path| {
        let path = path.as_path();
        is_same(path, output)
            || path.extension().is_some_and(|e| e == "toml")
                && CampaignFile::read(path, &read).is_ok_and(|campaign| names(&campaign, output))
    })
}

fn names(campaign: &CampaignFile, output: &Path) -> bool {
    let logs = campaign.runs.iter().flat_map(|run| &run.files).map(|log| &log.file);
    let tables = campaign.thrusters.iter().filter_map(|t| t.bollard.as_ref()).map(|table| &table.file);
    logs.chain(tables).any(|file| is_same(&campaign.folder().join(file), output))
}

/// Whether two paths lead to the same file.
fn is_same(a: &Path, b: &Path) -> bool {
    let (Ok(a), Ok(b)) = (a.canonicalize(), b.canonicalize()) else { return false };
    if a == b {
        return true;
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let place = |path: &Path| path.metadata().map(|found| (found.dev(), found.ino()));
        // one file with two names
        place(&a).is_ok_and(|a| place(&b).is_ok_and(|b| a == b))
    }
    #[cfg(not(unix))]
    false
}
