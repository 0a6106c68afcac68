//! Reading and checking logs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hydrosysid::campaign;
use hydrosysid::log::{self, LogOptions};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::error;
use crate::work::detached;

/// The `[log]` options from the JSON of the package's keywords.
fn options(py: Python<'_>, json: &str) -> PyResult<LogOptions> {
    serde_json::from_str(json).map_err(|e| error::usage(py, &e))
}

type Arrays<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// Signals, units, ends of gaps, and the findings as JSON.
#[pyfunction]
#[allow(clippy::type_complexity)] // a tuple is the plainest thing that crosses
pub fn read_log<'py>(
    py: Python<'py>,
    path: PathBuf,
    log_options: &str,
    required: Vec<String>,
) -> PyResult<(BTreeMap<String, Arrays<'py>>, BTreeMap<String, String>, Vec<f64>, String)> {
    let options = options(py, log_options)?;
    let required: Vec<&str> = required.iter().map(String::as_str).collect();
    let read = detached(py, || log::read(&path, &options, &required))?.map_err(|e| error::log(py, &e))?;
    let array = |values: &[f64]| PyArray1::from_slice(py, values);
    let signals = read.signals.iter().map(|(name, s)| (name.clone(), (array(s.time()), array(s.values())))).collect();
    let units = read.units.iter().map(|(name, unit)| (name.clone(), (*unit).to_string())).collect();
    let findings: Vec<_> = read.warnings.iter().chain(&read.notes).collect();
    Ok((signals, units, read.gaps, error::to_json(&findings)?))
}

/// The check of bare logs as JSON.
#[pyfunction]
pub fn check_logs(py: Python<'_>, paths: Vec<PathBuf>, log_options: &str, required: Vec<String>) -> PyResult<String> {
    let options = options(py, log_options)?;
    let required: Vec<&str> = required.iter().map(String::as_str).collect();
    let paths: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
    let found = detached(py, || campaign::check_logs(&paths, &options, &required))?;
    error::to_json(&found.map_err(|e| error::campaign(py, &e))?)
}
