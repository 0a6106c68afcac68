//! Linear least squares on NumPy arrays.

use hydrosysid::estimate::{Blocks, LeastSquaresOptions, Names, least_squares_with};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error;
use crate::work::{detached, interruptible};

/// Solves H θ = y.
#[pyfunction]
pub fn least_squares<'py>(
    py: Python<'py>,
    h: PyReadonlyArray2<'py, f64>,
    y: PyReadonlyArray1<'py, f64>,
    names: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let (h, y) = (h.as_array(), y.as_slice()?);
    let columns: Vec<Vec<f64>> = h.columns().into_iter().map(|column| column.to_vec()).collect();
    let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let names = Names { columns: names, response: None };
    let options = LeastSquaresOptions { names, ..LeastSquaresOptions::default() };
    let (fit, residuals) = detached(py, || {
        let fit = least_squares_with(&slices, y, &options)?;
        let residuals = fit.residuals(&slices, y)?;
        Ok::<_, hydrosysid::estimate::LeastSquaresError>((fit, residuals))
    })?
    .map_err(|e| error::data(py, &e))?;
    let result = PyDict::new(py);
    result.set_item("coefficients", PyArray1::from_vec(py, fit.coefficients))?;
    result.set_item("standard_errors", PyArray1::from_vec(py, fit.standard_errors))?;
    result.set_item("covariance", PyArray2::from_vec2(py, &fit.covariance)?)?;
    result.set_item("residuals", PyArray1::from_vec(py, residuals))?;
    result.set_item("residual_std", fit.residual_std)?;
    result.set_item("r_squared", fit.r_squared)?;
    result.set_item("condition_number", fit.condition_number)?;
    result.set_item("condition_number_scaled", fit.condition_number_scaled)?;
    result.set_item("rank", fit.rank)?;
    Ok(result)
}

/// Solutions of H θ = y on blocks of rows that are drawn with replacement, one row a refit.
#[pyfunction]
pub fn block_bootstrap<'py>(
    py: Python<'py>,
    h: PyReadonlyArray2<'py, f64>,
    y: PyReadonlyArray1<'py, f64>,
    block: usize,
    draws: usize,
    seed: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (h, y) = (h.as_array(), y.as_slice()?);
    let columns: Vec<Vec<f64>> = h.columns().into_iter().map(|column| column.to_vec()).collect();
    let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let drawn = interruptible(py, progress, || {
        let blocks = Blocks::of(&slices, y, block, &Names::default())?;
        Ok::<_, hydrosysid::estimate::LeastSquaresError>(blocks.bootstrap(draws, seed))
    })?
    .map_err(|e| error::data(py, &e))?;
    Ok(PyArray2::from_vec2(py, &drawn.values)?)
}
