//! The demo's folder: replaced if an earlier demo made it, refused if it is anything else.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Name of a file that only a demo writes.
const MARK: &str = ".hydrosysid-demo";

/// Error of the folder.
#[derive(Debug, Error)]
pub enum FolderError {
    /// It exists, and no demo made it.
    #[error("{} exists and is not a demo's folder: name another with --folder", .0.display())]
    NotOurs(PathBuf),
    /// It cannot be written.
    #[error("{}: {source}", folder.display())]
    Io {
        /// The folder.
        folder: PathBuf,
        /// Cause.
        source: io::Error,
    },
}

/// Makes an empty folder with the demo's mark in it.
pub(super) fn prepare(folder: &Path) -> Result<(), FolderError> {
    let failed = |source| FolderError::Io { folder: folder.to_path_buf(), source };
    if folder.exists() {
        let empty = folder.read_dir().is_ok_and(|mut entries| entries.next().is_none());
        match (folder.join(MARK).is_file(), empty) {
            (true, _) => std::fs::remove_dir_all(folder).map_err(failed)?,
            (false, true) => {}
            (false, false) => return Err(FolderError::NotOurs(folder.to_path_buf())),
        }
    }
    std::fs::create_dir_all(folder).map_err(failed)?;
    std::fs::write(folder.join(MARK), "made by `hydrosysid demo`; it may be replaced by the next one\n").map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_demos_folder_is_replaced() {
        let base = std::env::temp_dir().join(format!("hydrosysid-demo-folder-{}", std::process::id()));
        let (ours, theirs) = (base.join("ours"), base.join("theirs"));
        std::fs::create_dir_all(&theirs).unwrap();
        std::fs::write(theirs.join("thesis.tex"), "years of work").unwrap();
        assert!(matches!(prepare(&theirs), Err(FolderError::NotOurs(_))));
        assert!(theirs.join("thesis.tex").exists());
        prepare(&ours).unwrap();
        std::fs::write(ours.join("old.csv"), "x").unwrap();
        prepare(&ours).unwrap();
        assert!(!ours.join("old.csv").exists());
        std::fs::remove_dir_all(&base).unwrap();
    }
}
