//! Errors of the command and their exit codes.

use std::path::PathBuf;

use crate::campaign::{Error, ModelFileError};
use crate::finding::Finding;
use crate::text_file;
use crate::wording::count;

/// Error of the command.
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
    /// An output exists already.
    #[error("{} exists: choose another name, or replace it with --force", .0.display())]
    Exists(PathBuf),
    /// An output that would replace an input of the call.
    #[error("{}: this call reads that file and must not overwrite it: choose another name", .0.display())]
    Input(PathBuf),
    /// An output cannot be written.
    #[error("{} cannot be written: {source}", .file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// An input cannot be read.
    #[error("{}: cannot be read: {}", .file.display(), text_file::reason(.source))]
    Read {
        /// The file.
        file: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// The page cannot be served.
    #[error(transparent)]
    View(#[from] crate::view::ViewError),
    /// The demo cannot be made.
    #[error(transparent)]
    Demo(#[from] crate::demo::DemoError),
    /// An argument with an error that clap cannot detect.
    #[error("{0}")]
    Argument(String),
    /// Refused inputs, such as the red logs of a check.
    #[error("{} of {what} was refused", .refused)]
    Refused {
        /// Number of refused ones.
        refused: usize,
        /// What they are.
        what: &'static str,
        /// Findings with the reasons.
        findings: Vec<Finding>,
    },
    /// The work was stopped.
    #[error(transparent)]
    Stopped(#[from] crate::progress::Stopped),
    /// Warnings that `--strict` treats as errors.
    #[error("{}, and --strict treats warnings as errors", count(*.0, "warning"))]
    Strict(usize),
}

impl Failure {
    /// 1: an error of the data; 2: an error of the call.
    pub fn exit_code(&self) -> u8 {
        match self {
            Failure::Library(error) if !error.is_wrong_use() => 1,
            Failure::Refused { .. } | Failure::Strict(_) => 1,
            _ => 2,
        }
    }
}
