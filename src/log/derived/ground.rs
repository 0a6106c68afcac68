//! Speed and course over ground.
//!
//! ```text
//! u = V cos(χ − ψ),   v = V sin(χ − ψ)        χ: course, clockwise from north;  ψ: heading
//! ```

use super::{Columns, DerivedError, Told};
use crate::log::earth_velocity::angle_at;

pub(super) fn tell(columns: &Columns<'_>) -> Told {
    let psi = columns.signals.get("psi").filter(|psi| !psi.is_empty()).ok_or(DerivedError::NoHeading)?;
    let (begin, end) = (psi.time()[0], psi.time()[psi.len() - 1]);
    let tell = |(k, t): (usize, &f64)| {
        let (speed, course) = (columns.values[0][k], columns.values[1][k]);
        let course = if columns.radians[1] { course } else { course.to_radians() };
        let (sin, cos) = (course - angle_at(psi, *t)).sin_cos();
        (begin..=end).contains(t).then_some([speed * cos, speed * sin, 0.0])
    };
    let samples: Vec<_> = columns.time.iter().enumerate().map(tell).collect();
    if samples.iter().all(Option::is_none) {
        return Err(DerivedError::NoHeading);
    }
    Ok((samples, "u, v are speed and course over ground turned by the heading".to_string()))
}
