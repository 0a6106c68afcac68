//! A run from Python: its signals as pairs of arrays.

use std::collections::BTreeMap;

use hydrosysid::log::columns::Quantity;
use hydrosysid::run::{Run, Signal};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;

use crate::error;

/// A run as the Python package passes it: name, kind, role, ends of gaps, units of commands,
/// signals by name. The package has checked time stamps and values: finite, increasing, of equal
/// length.
#[derive(FromPyObject)]
#[pyo3(transparent)]
pub struct GivenRun<'py>(
    #[allow(clippy::type_complexity)] // a tuple is the plainest thing that crosses
    (
        String,
        String,
        String,
        Vec<f64>,
        BTreeMap<String, String>,
        BTreeMap<String, (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>)>,
    ),
);

impl GivenRun<'_> {
    /// Units of commands that are not in volts.
    pub fn units(&self) -> BTreeMap<String, &'static str> {
        let known = |unit: &String| Quantity::Command.unit(unit).map(|u| u.name);
        self.0.4.iter().filter_map(|(name, unit)| Some((name.clone(), known(unit)?))).collect()
    }

    /// The run as a run of the library.
    pub fn to_run(&self, py: Python<'_>) -> PyResult<Run> {
        let (name, kind, role, gaps, _, given) = &self.0;
        let kind = serde_json::from_value(kind.as_str().into()).map_err(|e| error::usage(py, &e))?;
        let role = serde_json::from_value(role.as_str().into()).map_err(|e| error::usage(py, &e))?;
        let mut signals = BTreeMap::new();
        for (channel, (time, values)) in given {
            let (time, values) = (time.as_slice()?, values.as_slice()?);
            if time.len() != values.len() {
                let text =
                    format!("run `{name}`, channel `{channel}`: {} time stamps, {} values", time.len(), values.len());
                return Err(error::usage(py, &text));
            }
            signals.insert(channel.clone(), Signal::new(time.into(), values));
        }
        Ok(Run { name: name.clone(), kind, role, gaps: gaps.clone(), signals })
    }
}

/// Several runs as runs of the library.
pub fn to_runs(py: Python<'_>, given: &[GivenRun<'_>]) -> PyResult<Vec<Run>> {
    given.iter().map(|run| run.to_run(py)).collect()
}
