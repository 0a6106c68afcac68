//! The campaign file that the page edits, its logs once they are read, and the running work.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use sha2::{Digest, Sha256};

use super::answer::Refusal;
use super::discovery::Found;
use super::fit::Fitted;
use super::report::Saved;
use super::task::{Task, lock};
use crate::atomic_file;
use crate::campaign::file::{CampaignFile, ReadOptions};
use crate::campaign::{Campaign, Check, LoadOptions, check_campaign};

/// Data that was read from the campaign, with the stamp of that campaign.
type AtStamp<T> = Mutex<Option<(String, Arc<T>)>>;

/// State shared by all requests.
pub(super) struct Workspace {
    /// The campaign file, which need not exist yet.
    pub file: PathBuf,
    /// Its folder, which also contains its logs.
    pub folder: PathBuf,
    pub allow_outside: bool,
    /// Texts before and after each edit made here, the latest last.
    edits: Mutex<Vec<(String, String)>>,
    /// Names of the logs that were sent through the page.
    received: Mutex<BTreeSet<String>>,
    loaded: AtStamp<Campaign>,
    checked: AtStamp<Check>,
    pub fit: Task<Fitted>,
    pub discovery: Task<Found>,
    pub report: Task<Saved>,
}

/// Maximum number of edits that can be undone.
const MOST_EDITS: usize = 200;

impl Workspace {
    pub fn new(file: PathBuf, folder: PathBuf, allow_outside: bool) -> Workspace {
        Workspace {
            file,
            folder,
            allow_outside,
            edits: Mutex::default(),
            received: Mutex::default(),
            loaded: Mutex::default(),
            checked: Mutex::default(),
            fit: Task::new(),
            discovery: Task::new(),
            report: Task::new(),
        }
    }

    /// The text of the campaign; empty if there is no file yet.
    pub fn text(&self) -> Result<String, Refusal> {
        match crate::text_file::read(&self.file) {
            Ok(text) => Ok(text),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(String::new()),
            Err(error) => Err(Refusal::unusable(format!("{} cannot be read: {error}", self.file.display()))),
        }
    }

    fn reading(&self) -> ReadOptions {
        ReadOptions { allow_outside: self.allow_outside, ..ReadOptions::default() }
    }

    /// The campaign as described in its file.
    pub fn campaign_file(&self) -> Result<CampaignFile, Refusal> {
        Ok(CampaignFile::read(&self.file, &self.reading())?)
    }

    /// A hash that changes if the campaign file or one of its logs changes.
    pub fn stamp(&self) -> Result<String, Refusal> {
        let text = self.text()?;
        let mut hash = Sha256::new();
        hash.update(&text);
        if let Ok(file) = CampaignFile::from_bytes(text.as_bytes(), &self.file, &self.reading()) {
            for log in file.runs.iter().flat_map(|run| &run.files) {
                let about = file.path_of(log).metadata().ok();
                let changed = about.as_ref().and_then(|about| about.modified().ok());
                hash.update(format!("{:?}{changed:?}", about.map(|about| about.len())));
            }
        }
        Ok(hash.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect())
    }

    fn at_stamp<T>(&self, kept: &AtStamp<T>, make: impl FnOnce() -> Result<T, Refusal>) -> Result<Arc<T>, Refusal> {
        let stamp = self.stamp()?;
        if let Some((_, there)) = lock(kept).as_ref().filter(|(of, _)| *of == stamp) {
            return Ok(there.clone());
        }
        let made = Arc::new(make()?);
        *lock(kept) = Some((stamp, made.clone()));
        Ok(made)
    }

    fn loading(&self) -> LoadOptions {
        LoadOptions { allow_outside: self.allow_outside }
    }

    /// The campaign with its logs.
    pub fn campaign(&self) -> Result<Arc<Campaign>, Refusal> {
        self.at_stamp(&self.loaded, || Ok(Campaign::load(&self.file, self.loading())?))
    }

    /// The result of the check of the campaign and its logs.
    pub fn check(&self) -> Result<Arc<Check>, Refusal> {
        self.at_stamp(&self.checked, || Ok(check_campaign(&self.file, self.loading())?))
    }

    /// Replaces the campaign's text by the result of `edit`, if that is a valid campaign.
    pub fn edit(&self, edit: impl FnOnce(&str) -> Result<String, Refusal>) -> Result<(), Refusal> {
        let mut edits = lock(&self.edits);
        let before = self.text()?;
        let after = edit(&before)?;
        if after == before {
            return Ok(());
        }
        CampaignFile::from_bytes(after.as_bytes(), &self.file, &self.reading())?;
        self.write(&self.file, after.as_bytes())?;
        if edits.len() == MOST_EDITS {
            edits.remove(0);
        }
        edits.push((before, after));
        Ok(())
    }

    /// Undoes the last edit.
    pub fn undo(&self) -> Result<(), Refusal> {
        let mut edits = lock(&self.edits);
        let Some((before, after)) = edits.last() else {
            return Err(Refusal::conflict("no edit of this page is left to undo"));
        };
        if self.text()? != *after {
            return Err(Refusal::conflict("the campaign file was changed elsewhere since: undo the change there"));
        }
        if before.is_empty() {
            return Err(Refusal::conflict("the campaign file did not exist before this: delete it by hand"));
        }
        self.write(&self.file, before.as_bytes())?;
        edits.pop();
        Ok(())
    }

    /// Whether there is an edit to undo.
    pub fn can_undo(&self) -> bool {
        lock(&self.edits).last().is_some_and(|(before, _)| !before.is_empty())
    }

    /// Records that a log was sent through the page.
    pub fn keep_in_mind(&self, log: &str) {
        lock(&self.received).insert(log.to_string());
    }

    /// Removes a log that cannot be used, if it was sent through the page: the user can mend it and
    /// drop it again.
    pub fn forget(&self, log: &str) {
        if lock(&self.received).remove(log) {
            let _ = std::fs::remove_file(self.folder.join(log));
        }
    }

    /// Writes a file completely or not at all.
    pub fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), Refusal> {
        let written = atomic_file::write(path, |file| std::io::Write::write_all(file, bytes));
        written.map_err(|e| Refusal::failed(format!("{} cannot be written: {e}", path.display())))
    }
}

/// A name for a file in the campaign's folder; refuses paths and hidden files.
pub(super) fn plain_name(name: &str) -> Result<&str, Refusal> {
    let strange = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
    let name = name.trim();
    if name.is_empty() || name.len() > 200 || name.starts_with('.') || name.contains(strange) {
        return Err(Refusal::bad(format!("{name:?} is not a plain file name")));
    }
    Ok(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_lead_elsewhere_are_refused() {
        for wrong in ["", "..", "../a.csv", "/etc/passwd", "a/b.csv", "a\\b.csv", ".hidden", "C:a.csv", "a\n.csv"] {
            assert_eq!(plain_name(wrong).unwrap_err().status, 400, "{wrong:?}");
        }
        assert_eq!(plain_name(" rück weg (2).csv ").unwrap(), "rück weg (2).csv");
    }
}
