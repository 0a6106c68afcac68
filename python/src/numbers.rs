//! Small building blocks: Runge-Kutta, the polynomial filter, a thruster's curve, quantiles of Student's t.

use hydrosysid::filter::{PolynomialFilter, Window};
use hydrosysid::least_squares;
use hydrosysid::run::Signal;
use hydrosysid::simulate::{self, OdeError};
use hydrosysid::thrust::bollard::{Bollard, CurveOptions, DeadBand};
use hydrosysid::thrust::fit::{CurveFit, DirectionFit, fit_curve};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error;
use crate::work::{attended, detached, interruptible};

/// Solves ẏ = f(t, y) by the classical Runge-Kutta scheme; `f` takes and returns arrays.
#[pyfunction]
pub fn rk4<'py>(
    py: Python<'py>,
    f: Bound<'py, PyAny>,
    t: PyReadonlyArray1<'py, f64>,
    y0: PyReadonlyArray1<'py, f64>,
    substeps: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (time, start) = (t.as_slice()?, y0.as_slice()?);
    let rate = |t: f64, y: &[f64], out: &mut [f64]| -> PyResult<()> {
        let found: PyReadonlyArray1<'py, f64> = f.call1((t, PyArray1::from_slice(py, y)))?.extract()?;
        let found = found.as_slice()?;
        if found.len() != out.len() {
            let text = format!("f returned {} rates for {} components", found.len(), out.len());
            return Err(error::usage(py, &text));
        }
        out.copy_from_slice(found);
        Ok(())
    };
    let solve = || Ok(simulate::rk4(rate, time, start, substeps));
    let rows = attended(solve)?.map_err(|e| match e {
        OdeError::Function { error, .. } => error,
        OdeError::NotFinite { .. } => error::data(py, &e),
        other => error::usage(py, &other),
    })?;
    PyArray1::from_vec(py, rows).reshape([time.len(), start.len()])
}

type Array<'py> = Bound<'py, PyArray1<f64>>;

/// Filtered signal and its derivative; the window is a number of samples or of seconds.
#[pyfunction]
#[pyo3(signature = (t, x, samples, seconds, degree, gaps))]
pub fn polynomial_filter<'py>(
    py: Python<'py>,
    t: PyReadonlyArray1<'py, f64>,
    x: PyReadonlyArray1<'py, f64>,
    samples: Option<usize>,
    seconds: Option<f64>,
    degree: usize,
    gaps: Vec<f64>,
) -> PyResult<(Array<'py>, Array<'py>)> {
    let window = match (samples, seconds) {
        (Some(samples), None) => Window::Samples(samples),
        (None, Some(seconds)) => Window::Seconds(seconds),
        _ => return Err(error::usage(py, &"give the window either in samples or in seconds")),
    };
    let (time, values) = (t.as_slice()?, x.as_slice()?);
    if time.len() != values.len() {
        return Err(error::usage(py, &format!("{} time stamps and {} values", time.len(), values.len())));
    }
    let signal = Signal::new(time.into(), values);
    let filtered = interruptible(py, None, || PolynomialFilter { window, degree }.apply(&signal, &gaps))?
        .map_err(|e| error::data(py, &e))?;
    let array = |signal: &Signal| PyArray1::from_slice(py, signal.values());
    Ok((array(&filtered.value), array(&filtered.derivative)))
}

/// Fits a thruster's curve to a bollard table; the dead band is fitted where none is given.
#[pyfunction]
#[pyo3(signature = (command, force, deadband, supply, reference_supply))]
pub fn fit_thruster<'py>(
    py: Python<'py>,
    command: PyReadonlyArray1<'py, f64>,
    force: PyReadonlyArray1<'py, f64>,
    deadband: Option<f64>,
    supply: Option<PyReadonlyArray1<'py, f64>>,
    reference_supply: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let supply = supply.as_ref().map(|s| s.as_slice()).transpose()?;
    let table = Bollard { command: command.as_slice()?, force: force.as_slice()?, supply };
    let options =
        CurveOptions { deadband: deadband.map_or(DeadBand::Fitted, DeadBand::Given), reference_supply, max: None };
    let fit = detached(py, || fit_curve(&table, &options))?.map_err(|e| error::data(py, &e))?;
    to_dict(py, &fit)
}

fn to_dict<'py>(py: Python<'py>, fit: &CurveFit) -> PyResult<Bound<'py, PyDict>> {
    let direction =
        |d: &DirectionFit| ((d.a.value, d.a.std), (d.b.value, d.b.std), d.rows, d.residual_std, d.covariance);
    let result = PyDict::new(py);
    result.set_item("forward", direction(&fit.forward))?;
    result.set_item("reverse", direction(&fit.reverse))?;
    result.set_item("deadband", (fit.deadband.value, fit.deadband.std))?;
    result.set_item("exponent", fit.exponent.map(|n| (n.value, n.std)))?;
    Ok(result)
}

/// The quantile of Student's t below which lies this share.
#[pyfunction]
pub fn student_quantile(below: f64, freedom: f64) -> f64 {
    least_squares::student_quantile(below, freedom)
}
