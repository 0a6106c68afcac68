//! Linear least squares on NumPy arrays.

use hydrosysid::estimate::{StdMethod, solve};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error;
use crate::work::detached;

/// Solves H θ = y. The arrays are C-contiguous and finite.
#[pyfunction]
pub fn least_squares<'py>(
    py: Python<'py>,
    h: PyReadonlyArray2<'py, f64>,
    y: PyReadonlyArray1<'py, f64>,
    names: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let (h, y) = (h.as_array(), y.as_slice()?);
    let columns: Vec<Vec<f64>> = h.columns().into_iter().map(|column| column.to_vec()).collect();
    let fit = detached(py, || {
        let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        // one block: rows are not from runs here
        solve(&slices, y, &names, std::slice::from_ref(&(0..y.len())), StdMethod::Paper)
    })?
    .map_err(|e| error::data(py, &e))?;
    let result = PyDict::new(py);
    let std: Vec<f64> = (0..columns.len()).map(|k| fit.covariance[k][k].sqrt()).collect();
    result.set_item("coefficients", PyArray1::from_vec(py, fit.coefficients))?;
    result.set_item("standard_errors", PyArray1::from_vec(py, std))?;
    result.set_item("covariance", PyArray2::from_vec2(py, &fit.covariance)?)?;
    result.set_item("residuals", PyArray1::from_vec(py, fit.residuals))?;
    result.set_item("residual_std", fit.residual_std)?;
    result.set_item("condition_number", fit.condition_number)?;
    result.set_item("condition_number_scaled", fit.condition_number_scaled)?;
    Ok(result)
}
