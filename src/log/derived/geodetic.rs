//! Position in metres from latitude and longitude on the ellipsoid.
//!
//! ```text
//! x = M(φ̄) (φ − φ₀),   y = N(φ̄) cos φ̄ (λ − λ₀)        φ̄ = (φ + φ₀)/2
//! M = a (1 − e²)/(1 − e² sin²φ)^{3/2},   N = a/(1 − e² sin²φ)^{1/2}
//! a = 6 378 137 m,   e² = 6.694 379 990 14e-3
//! ```
//!
//! φ₀, λ₀: the first fix. a and e of the ellipsoid WGS 84 (NIMA TR8350.2, 2000). With the mean
//! latitude φ̄ the error of distances up to one kilometre is below one millimetre.

use super::{Columns, DerivedError, Told};

const A: f64 = 6_378_137.0;
const E2: f64 = 6.694_379_990_14e-3;

/// Metres per degree of latitude and of longitude at this latitude (degrees).
pub fn metres_per_degree(latitude: f64) -> [f64; 2] {
    let (s, c) = latitude.to_radians().sin_cos();
    let w = 1.0 - E2 * s * s;
    let degree = std::f64::consts::PI / 180.0;
    [degree * A * (1.0 - E2) / w.powf(1.5), degree * A / w.sqrt() * c]
}

/// Returns metres north and east of the first fix; a row of zeros has no fix.
pub(super) fn tell(columns: &Columns<'_>) -> Told {
    let degrees = |i: usize, k: usize| {
        let x = columns.values[i][k];
        if columns.radians[i] { x.to_degrees() } else { x }
    };
    for (i, column, most) in [(0, "latitude", 90.0), (1, "longitude", 360.0)] {
        // an excess of a millionth is rounding of the unit
        if let Some(k) = (0..columns.time.len()).find(|k| degrees(i, *k).abs() > most + 1e-6) {
            let (value, time) = (degrees(i, k), columns.time[k]);
            return Err(DerivedError::NoDegrees { column, value, most, time });
        }
    }
    let fixes: Vec<Option<[f64; 2]>> = (0..columns.time.len())
        .map(|k| [degrees(0, k), degrees(1, k)])
        .map(|fix| fix.iter().any(|x| *x != 0.0).then_some(fix))
        .collect();
    let Some([latitude, longitude]) = fixes.iter().flatten().next().copied() else { return Err(DerivedError::NoFix) };
    let metres = |[north, east]: [f64; 2]| {
        let per_degree = metres_per_degree(0.5 * (north + latitude));
        // the short way across the date line
        let turn = east - longitude;
        let turn = turn - 360.0 * (turn / 360.0).round();
        [per_degree[0] * (north - latitude), per_degree[1] * turn, 0.0]
    };
    let without = fixes.iter().filter(|fix| fix.is_none()).count();
    let without = match without {
        0 => String::new(),
        1 => "; 1 row without a fix (0, 0) is treated as no sample".to_string(),
        n => format!("; {n} rows without a fix (0, 0) are treated as no samples"),
    };
    let how = format!(
        "x, y are metres north and east of latitude {latitude:.7}, longitude {longitude:.7}, the first fix{without}"
    );
    Ok((fixes.into_iter().map(|fix| fix.map(metres)).collect(), how))
}
