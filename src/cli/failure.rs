//! Why the command did not do its work, and with which exit code it says so.

use std::path::PathBuf;

use crate::campaign::{Error, ModelFileError};
use crate::finding::Finding;
use crate::text_file;
use crate::wording::count;

/// Why the command failed.
#[derive(Debug, thiserror::Error)]
pub(super) enum Failure {
    /// The library refused.
    #[error(transparent)]
    Library(#[from] Error),
    /// A model file cannot be used.
    #[error(transparent)]
    Model(#[from] ModelFileError),
    /// Nothing was adopted.
    #[error(transparent)]
    Adopt(#[from] crate::campaign::AdoptError),
    /// Nothing can be exported.
    #[error(transparent)]
    Export(#[from] crate::export::ExportError),
    /// An output is there already.
    #[error("{} exists: choose another name, or replace it with --force", .0.display())]
    Exists(PathBuf),
    /// An output over what the call reads.
    #[error("{}: this call reads that file, and no output replaces it: choose another name", .0.display())]
    Input(PathBuf),
    /// An output cannot be written.
    #[error("{} cannot be written: {source}", .file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// An input cannot be read.
    #[error("{}: cannot be read: {}", .file.display(), text_file::reason(.source))]
    Read {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The page cannot be served.
    #[error(transparent)]
    View(#[from] crate::view::ViewError),
    /// The demo cannot be made.
    #[error(transparent)]
    Demo(#[from] crate::demo::DemoError),
    /// An argument that clap cannot judge.
    #[error("{0}")]
    Argument(String),
    /// A log beside a campaign where one of them is wanted, and the like.
    #[error("{} of {what} was refused", .refused)]
    Refused {
        /// How many.
        refused: usize,
        /// Of what.
        what: &'static str,
        /// Findings that say why.
        findings: Vec<Finding>,
    },
    /// The work was ended.
    #[error(transparent)]
    Stopped(#[from] crate::progress::Stopped),
    /// Warnings, where `--strict` takes them as errors.
    #[error("{}, and --strict takes warnings as errors", count(*.0, "warning"))]
    Strict(usize),
}

impl Failure {
    /// 1: the data; 2: the call.
    pub fn exit_code(&self) -> u8 {
        match self {
            Failure::Library(error) if !error.is_wrong_use() => 1,
            Failure::Refused { .. } | Failure::Strict(_) => 1,
            _ => 2,
        }
    }
}
