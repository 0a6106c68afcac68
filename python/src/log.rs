//! Reading and checking logs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hydrosysid::campaign;
use hydrosysid::log::columns::{any_unit, quantity};
use hydrosysid::log::header::Column;
use hydrosysid::log::{self, LogOptions, OptionsError};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::error;
use crate::run::GivenRun;
use crate::work::interruptible;

/// The `[log]` options from the JSON of the package's keywords.
pub fn options(py: Python<'_>, json: &str) -> PyResult<LogOptions> {
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
    let read = interruptible(py, None, || log::read(&path, &options, &required))?.map_err(|e| error::log(py, &e))?;
    let array = |values: &[f64]| PyArray1::from_slice(py, values);
    let signals = read.signals.iter().map(|(name, s)| (name.clone(), (array(s.time()), array(s.values())))).collect();
    let units = read.units.iter().map(|(name, unit)| (name.clone(), (*unit).to_string())).collect();
    let findings: Vec<_> = read.warnings.iter().chain(&read.notes).collect();
    Ok((signals, units, read.gaps, error::to_json(&findings)?))
}

/// The check of bare logs as JSON.
#[pyfunction]
pub fn check_logs(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    log_options: &str,
    required: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let options = options(py, log_options)?;
    let required: Vec<&str> = required.iter().map(String::as_str).collect();
    let paths: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
    let found = interruptible(py, progress, || campaign::check_logs(&paths, &options, &required))?;
    error::to_json(&found.map_err(|e| error::campaign(py, &e))?)
}

/// Name, unit and values of the channel `name` in SI units and library axes; commands keep their unit. `log_options`
/// hold its one entry of `columns`, and the axes it is written in.
#[pyfunction]
pub fn to_si<'py>(
    py: Python<'py>,
    name: &str,
    values: PyReadonlyArray1<'py, f64>,
    log_options: &str,
) -> PyResult<(String, &'static str, Bound<'py, PyArray1<f64>>)> {
    let options = options(py, log_options)?;
    options.validate_each().map_err(|e| error::usage(py, &e))?;
    let source = options.columns.get(name).cloned().unwrap_or_else(|| name.into());
    let unit = source.unit.as_deref().map(|unit| match quantity(name) {
        Some(quantity) => quantity.unit(unit).ok_or_else(|| quantity.accepted()),
        None => any_unit(unit).ok_or_else(|| "m, rad, deg, m/s, mm/s, cm/s, kn, rad/s, deg/s, N, kgf, lbf".to_string()),
    });
    let unit = unit.transpose().map_err(|accepted| {
        let unit = source.unit.clone().unwrap_or_default();
        error::usage(py, &OptionsError::Unit { column: name.to_string(), unit, accepted })
    })?;
    let column = Column::new(name, 0, unit, &source, &options);
    let found: Vec<f64> = values.as_slice()?.iter().map(|x| column.convert(*x)).collect();
    Ok((column.name.clone(), column.unit, PyArray1::from_vec(py, found)))
}

/// A run as CSV: the bytes of the file. `origin`: t = 0 in ns since 1970, if the file is to have wall-clock stamps.
#[pyfunction]
pub fn csv_of(py: Python<'_>, run: GivenRun<'_>, origin: Option<i64>) -> PyResult<Vec<u8>> {
    let (run, units) = (run.to_run(py)?, run.units());
    let mut bytes = Vec::new();
    let written = interruptible(py, None, || match origin {
        Some(origin) => log::write_wall_clock(&run.signals, &units, origin, &mut bytes),
        None => log::write_signals(&run.signals, &units, &mut bytes),
    })?;
    written.map_err(|e| error::usage(py, &e))?;
    Ok(bytes)
}
