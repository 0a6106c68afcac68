//! Errors of the library as the package's exceptions, and results as JSON.

use hydrosysid::campaign::Error;
use hydrosysid::finding::Finding;
use hydrosysid::log::LogError;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use serde::Serialize;

/// Which of the package's classes is raised.
#[derive(Clone, Copy)]
pub enum Kind {
    /// The data was refused, or does not determine what is asked.
    Data,
    /// The call was wrong: a name, an option, a file.
    Use,
}

/// The exception of this kind, made by the package so that it is an ordinary picklable Python class.
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

/// What is wrong with the data.
pub fn data(py: Python<'_>, error: &impl std::fmt::Display) -> PyErr {
    raise(py, Kind::Data, &error.to_string(), &[])
}

/// What is wrong with the call.
pub fn usage(py: Python<'_>, error: &impl std::fmt::Display) -> PyErr {
    raise(py, Kind::Use, &error.to_string(), &[])
}

/// What is wrong with a campaign or what is asked of it.
pub fn campaign(py: Python<'_>, error: &Error) -> PyErr {
    let kind = if error.is_wrong_use() { Kind::Use } else { Kind::Data };
    raise(py, kind, &error.to_string(), error.findings())
}

/// What is wrong with a log.
pub fn log(py: Python<'_>, error: &LogError) -> PyErr {
    let kind = if error.findings().is_empty() { Kind::Use } else { Kind::Data };
    raise(py, kind, &error.to_string(), error.findings())
}

/// A result as JSON; what is not finite becomes `null`.
pub fn to_json(value: &impl Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|e| PyRuntimeError::new_err(e.to_string()))
}
