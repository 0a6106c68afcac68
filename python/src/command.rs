//! The `hydrosysid` command.

use pyo3::prelude::*;

use crate::work::{detached, interruptible};

/// Runs the command with these arguments, the first being its name; returns its exit code.
#[pyfunction]
pub fn command(py: Python<'_>, arguments: Vec<String>) -> PyResult<u8> {
    detached(py, || hydrosysid::cli::run_with(arguments))
}

/// The same as a part of other work: tells `progress` what it is at, and ends by Ctrl-C.
#[pyfunction]
pub fn watched_command(py: Python<'_>, arguments: Vec<String>, progress: Option<Py<PyAny>>) -> PyResult<u8> {
    interruptible(py, progress, || hydrosysid::cli::run_with(arguments))
}
