//! Linear least squares on NumPy arrays.

use std::borrow::Cow;
use std::ops::Range;

use hydrosysid::estimate::{
    Blocks, LeastSquaresOptions, Names, least_squares_filled, least_squares_rows, least_squares_with,
};
use numpy::ndarray::Axis;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error;
use crate::work::{detached, interruptible};

/// Solves H θ = y. H is read in place, in any memory order.
#[pyfunction]
pub fn least_squares<'py>(
    py: Python<'py>,
    h: PyReadonlyArray2<'py, f64>,
    y: PyReadonlyArray1<'py, f64>,
    names: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let (h, y) = (h.as_array(), y.as_array());
    let y = y.as_slice().map_or_else(|| Cow::Owned(y.to_vec()), Cow::Borrowed);
    let names = Names { columns: names, response: None };
    let options = LeastSquaresOptions { names, ..LeastSquaresOptions::default() };
    let by_columns: Option<Vec<&[f64]>> = (0..h.ncols()).map(|j| h.index_axis_move(Axis(1), j).to_slice()).collect();
    let fit = detached(py, || match (by_columns, h.to_slice()) {
        (Some(columns), _) => least_squares_with(&columns, &y, &options),
        (None, Some(rows)) => least_squares_rows(rows, h.ncols(), &y, &options),
        (None, None) => {
            let fill = |rows: Range<usize>, j: usize, to: &mut [f64]| {
                // a walk by the stride: an index by row and column is checked, and multiplied out, each time
                let column = h.index_axis(Axis(1), j);
                to.iter_mut().zip(column.slice_axis(Axis(0), rows.into())).for_each(|(to, value)| *to = *value);
            };
            least_squares_filled(h.ncols(), &fill, &y, &options)
        }
    })?
    .map_err(|e| error::data(py, &e))?;
    let result = PyDict::new(py);
    result.set_item("coefficients", PyArray1::from_vec(py, fit.coefficients))?;
    result.set_item("standard_errors", PyArray1::from_vec(py, fit.standard_errors))?;
    result.set_item("covariance", PyArray2::from_vec2(py, &fit.covariance)?)?;
    result.set_item("residual_std", fit.residual_std)?;
    result.set_item("r_squared", fit.r_squared)?;
    result.set_item("condition_number", fit.condition_number)?;
    result.set_item("condition_number_scaled", fit.condition_number_scaled)?;
    result.set_item("rank", fit.rank)?;
    Ok(result)
}

/// Solutions of H θ = y on blocks of rows drawn with replacement, one row per refit.
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
