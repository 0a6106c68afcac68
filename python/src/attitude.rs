//! Attitude: quaternions to Euler angles, earth axes to body axes.

use std::collections::BTreeMap;

use hydrosysid::log::earth_velocity::{self, EarthVelocityError};
use hydrosysid::log::options::EarthFrame;
use hydrosysid::navigation::euler_angles;
use hydrosysid::run::Signal;
use nalgebra::{Quaternion, UnitQuaternion};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::error;

type Array<'py> = Bound<'py, PyArray1<f64>>;
type Given<'py> = PyReadonlyArray1<'py, f64>;

/// z-y-x Euler angles (φ, θ, ψ) of quaternions x, y, z, w; NaN for invalid quaternions.
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

type Arrays<'py> = (Array<'py>, Array<'py>);

/// Rotates the signals `u`, `v`, `w` from the earth axes `frame` to body axes. Returns all signals, and how it was done.
#[pyfunction]
pub fn to_body<'py>(
    py: Python<'py>,
    signals: BTreeMap<String, (Given<'py>, Given<'py>)>,
    frame: &str,
) -> PyResult<(BTreeMap<String, Arrays<'py>>, String)> {
    let mut there = BTreeMap::new();
    for (name, (time, values)) in &signals {
        there.insert(name.clone(), Signal::new(time.as_slice()?.into(), values.as_slice()?));
    }
    let frame = if frame == "enu" { EarthFrame::Enu } else { EarthFrame::Ned };
    let how = earth_velocity::to_body(&mut there, frame).map_err(|e| match e {
        EarthVelocityError::Missing(_) => error::usage(py, &e),
        _ => error::data(py, &e),
    })?;
    let array = |values: &[f64]| PyArray1::from_slice(py, values);
    Ok((there.iter().map(|(name, s)| (name.clone(), (array(s.time()), array(s.values())))).collect(), how))
}

fn columns<'py, const N: usize>(
    py: Python<'py>,
    given: [&[f64]; N],
    of: impl Fn([f64; N]) -> [f64; 3],
) -> PyResult<(Array<'py>, Array<'py>, Array<'py>)> {
    if given.iter().any(|column| column.len() != given[0].len()) {
        return Err(error::usage(py, &"columns of different lengths"));
    }
    let rows: Vec<[f64; 3]> = (0..given[0].len()).map(|k| of(given.map(|column| column[k]))).collect();
    let column = |i: usize| PyArray1::from_vec(py, rows.iter().map(|row| row[i]).collect());
    Ok((column(0), column(1), column(2)))
}
