//! Velocities logged along earth axes, turned to body axes by the logged attitude: ν = Rᵀ(φ, θ, ψ)
//! (north, east, down).

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::{Rotation3, Vector3};

use super::options::EarthFrame;
use crate::run::Signal;

/// Names of the channels that are turned.
pub const VELOCITIES: [&str; 3] = ["u", "v", "w"];
/// Names of the channels of the attitude, north-east-down.
const ANGLES: [&str; 3] = ["phi", "theta", "psi"];

/// Reason why velocities along earth axes cannot be turned.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EarthVelocityError {
    /// A required channel is missing.
    #[error("velocities along earth axes need u, v, w in one frame, and phi, theta, psi; missing: {0}")]
    Missing(String),
    /// The components have different time stamps.
    #[error("u, v, w along earth axes must come at the same instants")]
    Instants,
    /// Velocities and attitude have no time in common.
    #[error("the attitude and the velocities have no time in common")]
    Apart,
}

/// Turns `u`, `v`, `w`, which hold north, east, down (or east, north, up), to body axes; returns a
/// sentence that says how. Samples outside the time range of the attitude are dropped.
///
/// # Errors
/// See [`EarthVelocityError`]; the signals are then unchanged.
pub fn to_body(signals: &mut BTreeMap<String, Signal>, frame: EarthFrame) -> Result<String, EarthVelocityError> {
    let missing: Vec<&str> = VELOCITIES.into_iter().chain(ANGLES).filter(|name| !signals.contains_key(*name)).collect();
    if !missing.is_empty() {
        return Err(EarthVelocityError::Missing(missing.join(", ")));
    }
    let [first, second, third] = VELOCITIES.map(|name| signals[name].clone());
    let time = first.time();
    if time != second.time() || time != third.time() {
        return Err(EarthVelocityError::Instants);
    }
    let angles = ANGLES.map(|name| signals[name].clone());
    let edge = |of: fn(&[f64]) -> Option<&f64>, pick: fn(f64, f64) -> f64| {
        angles.iter().filter_map(|angle| of(angle.time()).copied()).reduce(pick)
    };
    let (Some(begin), Some(end)) = (edge(<[f64]>::first, f64::max), edge(<[f64]>::last, f64::min)) else {
        return Err(EarthVelocityError::Apart);
    };
    let inside: Vec<usize> = (0..time.len()).filter(|k| (begin..=end).contains(&time[*k])).collect();
    if inside.is_empty() {
        return Err(EarthVelocityError::Apart);
    }
    let own = angles.iter().all(|angle| angle.time() == time);
    let turned: Vec<Vector3<f64>> = inside
        .iter()
        .map(|&k| {
            let [phi, theta, psi] = [0, 1, 2].map(|i| angle_at(&angles[i], time[k]));
            let (a, b, c) = (first.values()[k], second.values()[k], third.values()[k]);
            let ned = if frame == EarthFrame::Enu { Vector3::new(b, a, -c) } else { Vector3::new(a, b, c) };
            Rotation3::from_euler_angles(phi, theta, psi).inverse_transform_vector(&ned)
        })
        .collect();
    let shared = if inside.len() == time.len() {
        first.shared_time().clone()
    } else {
        inside.iter().map(|k| time[*k]).collect()
    };
    for (i, name) in VELOCITIES.into_iter().enumerate() {
        signals.insert(name.into(), Signal::new(shared.clone(), turned.iter().map(|v| v[i]).collect::<Vec<f64>>()));
    }
    let how = if own {
        "sampled with it".to_string()
    } else {
        format!("interpolated to their time stamps; {} samples lie outside", time.len() - inside.len())
    };
    Ok(format!("u, v, w are rotated from earth to body axes by the attitude, {how}"))
}

/// Returns an angle at time `t`, interpolated linearly the short way round; before the first and
/// after the last sample it returns that sample.
pub(super) fn angle_at(angle: &Signal, t: f64) -> f64 {
    let (time, x) = (angle.time(), angle.values());
    match time.partition_point(|s| *s <= t) {
        0 => x[0],
        k if k == x.len() => x[k - 1],
        k => {
            let step = x[k] - x[k - 1];
            let step = step - TAU * (step / TAU).round();
            x[k - 1] + step * (t - time[k - 1]) / (time[k] - time[k - 1])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signals(angle: [f64; 3], north: f64, east: f64, down: f64) -> BTreeMap<String, Signal> {
        let names = VELOCITIES.into_iter().chain(ANGLES);
        let values = [north, east, down].into_iter().chain(angle);
        names.zip(values).map(|(n, x)| (n.to_string(), Signal::new([0.0, 1.0].into(), vec![x, x]))).collect()
    }

    #[test]
    fn a_vehicle_that_heads_east_goes_forward_when_it_goes_east() {
        let mut there = signals([0.0, 0.0, std::f64::consts::FRAC_PI_2], 0.0, 2.0, 0.5);
        to_body(&mut there, EarthFrame::Ned).unwrap();
        // rounding of one sine and one cosine
        for (name, x) in [("u", 2.0), ("v", 0.0), ("w", 0.5)] {
            assert!((there[name].values()[1] - x).abs() < 1e-15, "{name}");
        }
        let mut same = signals([0.0, 0.0, std::f64::consts::FRAC_PI_2], 2.0, 0.0, -0.5);
        to_body(&mut same, EarthFrame::Enu).unwrap();
        assert_eq!(same["u"].values(), there["u"].values());
    }

    #[test]
    fn angles_are_interpolated_the_short_way() {
        let angle = Signal::new([0.0, 1.0].into(), vec![3.1, -3.1]);
        let half = angle_at(&angle, 0.5).abs();
        assert!((half - std::f64::consts::PI).abs() < 1e-12, "{half}");
    }

    #[test]
    fn what_is_missing_is_named_and_nothing_changes() {
        let mut there = signals([0.0; 3], 1.0, 2.0, 3.0);
        there.remove("psi");
        let before = there.clone();
        assert_eq!(to_body(&mut there, EarthFrame::Ned), Err(EarthVelocityError::Missing("psi".into())));
        assert_eq!(there.keys().collect::<Vec<_>>(), before.keys().collect::<Vec<_>>());
        there.insert("psi".into(), Signal::new([5.0, 6.0].into(), vec![0.0, 0.0]));
        assert_eq!(to_body(&mut there, EarthFrame::Ned), Err(EarthVelocityError::Apart));
    }
}
