//! Errors of the library as the package's exceptions, and results as JSON.

use hydrosysid::campaign::Error;
use hydrosysid::finding::Finding;
use hydrosysid::log::LogError;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use serde::Serialize;

/// Exception class of the package.
#[derive(Clone, Copy)]
pub enum Kind {
    /// `DataError`: the data are refused, or do not determine the result.
    Data,
    /// The call is wrong: a name, an option or a file.
    Use,
}

/// The exception of this kind. The package creates it, so that it is an ordinary, picklable Python class.
pub fn raise(py: Python<'_>, kind: Kind, message: &str, findings: &[Finding]) -> PyErr {
    let class = match kind {
        Kind::Data => "DataError",
        Kind::Use => "UsageError",
    };
    let made = to_json(&findings)
        .and_then(|json| py.import("hydrosysid._errors")?.call_method1("make", (class, message, json)));
    match made {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// The exception for an error in the data.
pub fn data(py: Python<'_>, error: &impl std::fmt::Display) -> PyErr {
    raise(py, Kind::Data, &error.to_string(), &[])
}

/// The exception for an error in the call.
pub fn usage(py: Python<'_>, error: &impl std::fmt::Display) -> PyErr {
    raise(py, Kind::Use, &error.to_string(), &[])
}

/// The exception for an error of a campaign: `Kind::Use` if the call is wrong, else `Kind::Data`.
pub fn campaign(py: Python<'_>, error: &Error) -> PyErr {
    let kind = if error.is_wrong_use() { Kind::Use } else { Kind::Data };
    raise(py, kind, &error.to_string(), error.findings())
}

/// The exception for an error of a log: `Kind::Data` if it has findings, else `Kind::Use`.
pub fn log(py: Python<'_>, error: &LogError) -> PyErr {
    let kind = if error.findings().is_empty() { Kind::Use } else { Kind::Data };
    raise(py, kind, &error.to_string(), error.findings())
}

/// A result as JSON; numbers that are not finite become `null`.
pub fn to_json(value: &impl Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|e| PyRuntimeError::new_err(e.to_string()))
}
