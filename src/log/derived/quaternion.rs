//! Angles from a logged quaternion.
//!
//! ```text
//! R(q) = R_z(ψ) R_y(θ) R_x(φ)        q = (w, x, y, z): from the body axes of the file to its earth axes
//! ```
//!
//! The angles are converted from the axes of the file, `body_frame` and `earth_frame`
//! ([`crate::log::frames`]).

use nalgebra::{Quaternion, UnitQuaternion};

use super::{Columns, DerivedError, Told};
use crate::log::frames;

/// Largest difference of the length from 1 that rounding to two decimals explains.
const OFF: f64 = 0.02;

pub(super) fn tell(columns: &Columns<'_>) -> Told {
    let [w, x, y, z] = [0, 1, 2, 3].map(|i| &columns.values[i]);
    let (body, earth) = (columns.options.body_frame, columns.options.earth_frame);
    let mut samples = Vec::with_capacity(columns.time.len());
    let mut none = 0;
    for (k, time) in columns.time.iter().enumerate() {
        let q = Quaternion::new(w[k], x[k], y[k], z[k]);
        let length = q.norm();
        // all zeros: the estimator has not started
        if length == 0.0 {
            none += 1;
            samples.push(None);
            continue;
        }
        if (length - 1.0).abs() > OFF {
            return Err(DerivedError::NoRotation { length, time: *time });
        }
        let (phi, theta, psi) = UnitQuaternion::from_quaternion(q).euler_angles();
        let angle = |name: &str, x: f64| {
            let turn = frames::turn(name, body, earth);
            let x = turn.sign * x + turn.offset;
            x - std::f64::consts::TAU * (x / std::f64::consts::TAU).round()
        };
        samples.push(Some([angle("phi", phi), angle("theta", theta), angle("psi", psi)]));
    }
    let none = if none == 0 { String::new() } else { format!("; {none} rows of zeros are treated as no samples") };
    Ok((samples, format!("phi, theta, psi are the angles of the quaternion qw, qx, qy, qz{none}")))
}
