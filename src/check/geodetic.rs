//! Metres of position compared with degrees of latitude and longitude.
//!
//! ```text
//! north: M(φ) π/180 m a degree of latitude        east: N(φ) cos φ π/180 m a degree of longitude
//! ```
//!
//! M, N: [`crate::log::derived::geodetic`]. The slope of logged metres on true metres is 1 when they agree.

use super::codes;
use super::fit::fit;
use super::options::Geodetic;
use super::report::{Agreement, FaultKind, Found};
use super::samples::Samples;
use crate::log::derived::geodetic::metres_per_degree;
use crate::log::number::short;
use crate::run::Run;

/// Least distance covered along an axis for a test of its scale, m.
const LEAST_WAY: f64 = 5.0;
/// Largest difference that is accepted: spherical formulas differ from the ellipsoid by 0.3 percent
/// and less.
pub const TOLERANCE: f64 = 0.01;

/// Returns the scale of each axis: logged metres over true ones.
pub fn measure(run: &Run, columns: &Geodetic) -> Vec<Agreement> {
    let Some(latitude) = columns.latitude.as_ref().and_then(|n| run.signal(n)).filter(|s| !s.is_empty()) else {
        return Vec::new();
    };
    let scale = metres_per_degree(latitude.values().iter().sum::<f64>() / latitude.len() as f64);
    let axes = [(&columns.north, &columns.latitude), (&columns.east, &columns.longitude)];
    let slope = |(metres, degrees): (&Option<String>, &Option<String>), per_degree: f64| {
        let (metres, degrees) = (metres.as_ref()?, degrees.as_ref()?);
        let logged = Samples::of(run.signal(metres)?)?;
        let true_way = run.signal(degrees)?;
        let pairs: Vec<(f64, f64)> = true_way.time().iter().zip(true_way.values()).map(|(t, d)| (*t, *d)).collect();
        let start = pairs.first()?.1;
        let way: Vec<f64> = pairs.iter().map(|(_, d)| (d - start) * per_degree).collect();
        let seen: Vec<f64> = pairs.iter().map(|(t, _)| logged.at(*t)).collect();
        let (low, high) = crate::log::check::statistics::range(way.iter().copied())?;
        if high - low < LEAST_WAY {
            return None;
        }
        let one = vec![1.0; way.len()];
        let f = fit(&[&way, &one], &seen)?;
        let against = format!("{degrees} (WGS 84)");
        Some(Agreement { channel: metres.clone(), against, factor: f.theta[0], std: f.std[0], angle: None, lag: None })
    };
    axes.into_iter().zip(scale).filter_map(|(axis, scale)| slope(axis, scale)).collect()
}

/// Returns the findings.
pub fn judge(agreements: &[Agreement]) -> Vec<Found> {
    let wrong: Vec<&Agreement> =
        agreements.iter().filter(|a| (a.factor - 1.0).abs() > TOLERANCE.max(5.0 * a.std)).collect();
    if wrong.is_empty() {
        return Vec::new();
    }
    let says = |a: &&Agreement| {
        format!(
            "{} is {:+.1} % ({} times) what {} says",
            a.channel,
            100.0 * (a.factor - 1.0),
            short(a.factor, 4),
            a.against
        )
    };
    let channels: Vec<&str> = wrong.iter().map(|a| a.channel.as_str()).collect();
    let text = format!(
        "{}: all distances are off by this factor; set columns.{}.scale = {}",
        wrong.iter().map(says).collect::<Vec<_>>().join(", "),
        channels[0],
        short(1.0 / wrong[0].factor, 5)
    );
    let mut found = Found::new(&codes::POSITION_SCALE, &channels, text);
    for a in wrong {
        found = found.fault(FaultKind::Unit, &a.channel, a.factor);
    }
    vec![found]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::options::CheckOptions;
    use crate::run::Signal;

    #[test]
    fn exact_degrees_of_the_ellipsoid() {
        // NGA, length of a degree calculator: 45°: 111 131.7 m and 78 846.8 m;
        // equator 110 574.3 and 111 319.5
        for (latitude, north, east) in [(45.0, 111_131.75, 78_846.84), (0.0, 110_574.28, 111_319.49)] {
            let [n, e] = metres_per_degree(latitude);
            // those figures are rounded to a tenth of a metre
            assert!((n - north).abs() < 0.2 && (e - east).abs() < 0.2, "{n} {e}");
        }
    }

    #[test]
    fn a_wrong_scale_is_found_and_a_right_one_is_not() {
        let run = |scale: f64| {
            let time: std::sync::Arc<[f64]> = (0..300).map(|k| 0.2 * f64::from(k)).collect();
            let [n, e] = metres_per_degree(38.9);
            let column =
                |f: &dyn Fn(f64) -> f64| Signal::new(time.clone(), time.iter().map(|t| f(*t)).collect::<Vec<_>>());
            let mut run = Run::default();
            run.signals.insert("x".into(), column(&|t| scale * 20.0 * (0.1 * t).sin()));
            run.signals.insert("y".into(), column(&|t| 20.0 * (0.1 * t).cos()));
            run.signals.insert("latitude".into(), column(&|t| 38.9 + 20.0 * (0.1 * t).sin() / n));
            run.signals.insert("longitude".into(), column(&|t| 121.0 + 20.0 * (0.1 * t).cos() / e));
            run
        };
        let check = |run: &Run| judge(&measure(run, &Geodetic::of(run, &CheckOptions::default())));
        assert!(check(&run(1.0)).is_empty());
        let found = check(&run(1.111));
        assert_eq!(found.len(), 1);
        assert!(found[0].channels == ["x"] && found[0].text.contains("+11.1 %"), "{}", found[0].text);
    }
}
