//! Body velocities from speed and course over ground, or from velocities north and east.
//!
//! ```text
//! u = V cos(χ − ψ),   v = V sin(χ − ψ)                          χ: course, clockwise from north;  ψ: heading
//! u = v_N cos ψ + v_E sin ψ,   v = v_E cos ψ − v_N sin ψ         level attitude
//! ```

use super::{Columns, DerivedError, Told};
use crate::log::earth_velocity::angle_at;

/// Returns u, v from speed and course.
pub(super) fn tell(columns: &Columns<'_>) -> Told {
    let at = |k: usize, psi: f64| {
        let (speed, course) = (columns.values[0][k], columns.values[1][k]);
        let course = if columns.radians[1] { course } else { course.to_radians() };
        let (sin, cos) = (course - psi).sin_cos();
        [speed * cos, speed * sin, 0.0]
    };
    by_heading(columns, at, "u, v are speed and course over ground rotated by the heading")
}

/// Returns u, v from velocities north and east.
pub(super) fn tell_components(columns: &Columns<'_>) -> Told {
    let at = |k: usize, psi: f64| {
        let (north, east) = (columns.values[0][k], columns.values[1][k]);
        let (sin, cos) = psi.sin_cos();
        [north * cos + east * sin, east * cos - north * sin, 0.0]
    };
    by_heading(columns, at, "u, v are the north and east velocities rotated by the heading, assuming a level vehicle")
}

/// Applies `at` to each sample and the heading at its time; `None` for samples outside the time
/// range of the heading.
fn by_heading(columns: &Columns<'_>, at: impl Fn(usize, f64) -> [f64; 3], said: &str) -> Told {
    let psi = columns.signals.get("psi").filter(|psi| !psi.is_empty()).ok_or(DerivedError::NoHeading)?;
    let (begin, end) = (psi.time()[0], psi.time()[psi.len() - 1]);
    let tell = |(k, t): (usize, &f64)| (begin..=end).contains(t).then(|| at(k, angle_at(psi, *t)));
    let samples: Vec<_> = columns.time.iter().enumerate().map(tell).collect();
    if samples.iter().all(Option::is_none) {
        return Err(DerivedError::NoHeading);
    }
    Ok((samples, said.to_string()))
}
