//! Attitude: quaternions to Euler angles, earth axes to body axes.

use hydrosysid::navigation::{euler_angles, rotation};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::error;

type Array<'py> = Bound<'py, PyArray1<f64>>;
type Given<'py> = PyReadonlyArray1<'py, f64>;

/// z-y-x Euler angles (φ, θ, ψ) of quaternions x, y, z, w; NaN for what is none.
#[pyfunction]
pub fn euler<'py>(
    py: Python<'py>,
    x: Given<'py>,
    y: Given<'py>,
    z: Given<'py>,
    w: Given<'py>,
) -> PyResult<(Array<'py>, Array<'py>, Array<'py>)> {
    let given = [x.as_slice()?, y.as_slice()?, z.as_slice()?, w.as_slice()?];
    let found = columns(py, given, |[x, y, z, w]| {
        let q = Quaternion::new(w, x, y, z);
        // a message that was never filled in has four zeros
        if q.norm() > 0.5 { euler_angles(&UnitQuaternion::from_quaternion(q)) } else { [f64::NAN; 3] }
    })?;
    Ok(found)
}

/// Velocities in body axes from velocities north, east, down and the attitude.
#[pyfunction]
pub fn to_body<'py>(
    py: Python<'py>,
    phi: Given<'py>,
    theta: Given<'py>,
    psi: Given<'py>,
    north: Given<'py>,
    east: Given<'py>,
    down: Given<'py>,
) -> PyResult<(Array<'py>, Array<'py>, Array<'py>)> {
    let given =
        [phi.as_slice()?, theta.as_slice()?, psi.as_slice()?, north.as_slice()?, east.as_slice()?, down.as_slice()?];
    columns(py, given, |[phi, theta, psi, n, e, d]| {
        rotation(phi, theta, psi).inverse_transform_vector(&Vector3::new(n, e, d)).into()
    })
}

fn columns<'py, const N: usize>(
    py: Python<'py>,
    given: [&[f64]; N],
    of: impl Fn([f64; N]) -> [f64; 3],
) -> PyResult<(Array<'py>, Array<'py>, Array<'py>)> {
    if given.iter().any(|column| column.len() != given[0].len()) {
        return Err(error::usage(py, &"columns of different length"));
    }
    let rows: Vec<[f64; 3]> = (0..given[0].len()).map(|k| of(given.map(|column| column[k]))).collect();
    let column = |i: usize| PyArray1::from_vec(py, rows.iter().map(|row| row[i]).collect());
    Ok((column(0), column(1), column(2)))
}
