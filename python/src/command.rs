//! The `hydrosysid` command.

use pyo3::prelude::*;

use crate::work::detached;

/// Runs the command with these arguments, the first being its name; returns its exit code.
#[pyfunction]
pub fn command(py: Python<'_>, arguments: Vec<String>) -> PyResult<u8> {
    detached(py, || hydrosysid::cli::run_with(arguments))
}
