//! Errors of building a campaign and of its verbs.

use std::path::PathBuf;

use thiserror::Error;

use super::codes;
use super::file::CampaignErrors;
use crate::compare::CompareError;
use crate::estimate::IntegralError;
use crate::estimate::output_error::OutputErrorError;
use crate::finding::Finding;
use crate::log::LogError;
use crate::model::ModelError;
use crate::plan::PlanError;
use crate::procedure::ProcedureError;

/// The reason why a campaign cannot be used.
#[derive(Debug, Error)]
pub enum Error {
    /// The campaign file is wrong: a usage error.
    #[error(transparent)]
    File(#[from] CampaignErrors),
    /// A log cannot be opened, or a reading option is invalid: a usage error.
    #[error("run `{run}`: {source}")]
    Log {
        /// Name of the run.
        run: String,
        /// What is wrong.
        source: LogError,
    },
    /// The data was refused.
    #[error("{}", .findings.iter().map(|f| f.message.as_str()).collect::<Vec<_>>().join("\n"))]
    Refused {
        /// All faults of all runs.
        findings: Vec<Finding>,
    },
    /// A file of published parameters cannot be used: a usage error.
    #[error("{}: {message}", .file.display())]
    Parameters {
        /// The file.
        file: PathBuf,
        /// What is wrong, with the key.
        message: String,
    },
    /// There is no such vehicle, or its file cannot be used: a usage error.
    #[error("vehicle {name}: {message}")]
    Vehicle {
        /// Name or path that was asked for.
        name: String,
        /// What is wrong.
        message: String,
    },
    /// The model is impossible: a usage error.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Output error cannot fit this data.
    #[error(transparent)]
    OutputError(#[from] OutputErrorError),
    /// The staged procedure cannot fit this data.
    #[error(transparent)]
    Procedure(#[from] ProcedureError),
    /// Integral least squares cannot fit this data.
    #[error(transparent)]
    Integral(IntegralError),
    /// A model cannot be compared with a run.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// Nothing can be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A request cannot be met: a usage error.
    #[error("{0}")]
    Asked(String),
}

impl From<IntegralError> for Error {
    /// An error that says what to do instead has a code of its own.
    fn from(error: IntegralError) -> Error {
        match &error {
            IntegralError::NotSettled { .. } | IntegralError::SharedInStream { .. } => {
                Error::Refused { findings: vec![Finding::new(&codes::SHARED_INERTIAS, error.to_string())] }
            }
            _ => Error::Integral(error),
        }
    }
}

impl Error {
    /// Whether the call was wrong (exit code 2), not the data (exit code 1).
    pub fn is_wrong_use(&self) -> bool {
        match self {
            Error::File(_) | Error::Model(_) | Error::Asked(_) | Error::Parameters { .. } | Error::Vehicle { .. } => {
                true
            }
            Error::Log { source, .. } => !matches!(source, LogError::Refused { .. }),
            _ => false,
        }
    }

    /// Returns the findings behind the error, if there are any.
    pub fn findings(&self) -> &[Finding] {
        match self {
            Error::Refused { findings } => findings,
            Error::Log { source, .. } => source.findings(),
            _ => &[],
        }
    }
}
