//! Errors of reading a log.

use super::faults::Faults;
use super::valid_options::OptionsError;
use crate::finding::Finding;
use crate::text_file;

/// Reason why a log was not read.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// An option has an invalid value: wrong use.
    #[error("[log] {0}")]
    Options(#[from] OptionsError),
    /// The file cannot be opened: wrong use.
    #[error("{file}: cannot be read: {}", text_file::reason(source))]
    Open {
        /// As given.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The data were refused.
    #[error("{}", list(findings, *further))]
    Refused {
        /// As given.
        file: String,
        /// The first case of each kind and column, at most 20.
        findings: Vec<Finding>,
        /// Number of faults of further kinds and columns.
        further: u64,
    },
}

impl LogError {
    /// Returns the findings if the data were refused; empty otherwise.
    pub fn findings(&self) -> &[Finding] {
        match self {
            LogError::Refused { findings, .. } => findings,
            _ => &[],
        }
    }

    pub(super) fn refused(file: &str, faults: Faults) -> LogError {
        let (findings, further) = faults.into_findings(file);
        LogError::Refused { file: file.to_string(), findings, further }
    }
}

fn list(findings: &[Finding], further: u64) -> String {
    let mut text = findings.iter().map(|f| f.message.as_str()).collect::<Vec<_>>().join("\n");
    if further > 0 {
        text += &format!("\nand {further} more");
    }
    text
}
