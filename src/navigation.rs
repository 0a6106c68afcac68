//! Navigation: attitude, and position by dead reckoning.
//!
//! ```text
//! ṗ = R(φ, θ, ψ) (u, v, w)          R = R_z(ψ) R_y(θ) R_x(φ)
//! φ̇ = p + (q sin φ + r cos φ) tan θ,   θ̇ = q cos φ − r sin φ,   ψ̇ = (q sin φ + r cos φ)/cos θ
//! q̇ = ½ q ⊗ (0, ω)
//! ```
//!
//! p is the position in earth axes (north, east, down; m), (u, v, w) the velocity in body axes (m/s), ω = (p, q, r) the
//! body rates (rad/s), angles in rad. Velocity and attitude come from sensors of their own rates: one of the two gives
//! the steps, the other is interpolated linearly to them, and both are linear between stamps. Source: Avila, Donha
//! and Adamowski, *Ocean Engineering* 60 (2013) 81-94; Fossen, *Handbook of Marine Craft* (2011), chapter 2.

pub mod upright;

use std::f64::consts::{PI, TAU};

use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::run::Signal;

/// The rotation R(φ, θ, ψ) that takes a vector from body to earth axes.
pub fn rotation(phi: f64, theta: f64, psi: f64) -> Rotation3<f64> {
    Rotation3::from_euler_angles(phi, theta, psi)
}

/// The attitude as a unit quaternion, from z-y-x Euler angles (rad).
pub fn quaternion(phi: f64, theta: f64, psi: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_euler_angles(phi, theta, psi)
}

/// z-y-x Euler angles (φ, θ, ψ) of an attitude, rad: φ, ψ in (−π, π], θ in [−π/2, π/2].
///
/// At θ = ±π/2 only one combination of φ and ψ is determined.
pub fn euler_angles(attitude: &UnitQuaternion<f64>) -> [f64; 3] {
    let (phi, theta, psi) = attitude.euler_angles();
    [phi, theta, psi]
}

/// Rates (φ̇, θ̇, ψ̇) of the Euler angles, rad/s, from the body rates ω. Infinite at θ = ±π/2: simulate with
/// [`quaternion_rate`] where the vehicle may stand upright.
pub fn euler_rates(phi: f64, theta: f64, omega: &Vector3<f64>) -> Vector3<f64> {
    let turn = omega.y * phi.sin() + omega.z * phi.cos();
    Vector3::new(omega.x + turn * theta.tan(), omega.y * phi.cos() - omega.z * phi.sin(), turn / theta.cos())
}

/// Rate q̇ = ½ q ⊗ (0, ω) of an attitude quaternion, 1/s. The norm is kept by the flow, not by an integrator:
/// normalise after each step.
pub fn quaternion_rate(q: &Quaternion<f64>, omega: &Vector3<f64>) -> Quaternion<f64> {
    q * Quaternion::from_parts(0.0, *omega) * 0.5
}

/// Takes the jumps of 2π out of a heading: each step becomes the shorter way round, in [−π, π).
pub fn unwrap(angle: &[f64]) -> Vec<f64> {
    let mut turns = 0.0;
    let mut before = angle.first().copied().unwrap_or(0.0);
    let mut unwrapped = Vec::with_capacity(angle.len());
    for &a in angle {
        turns -= TAU * ((a - before + PI) / TAU).floor();
        before = a;
        unwrapped.push(a + turns);
    }
    unwrapped
}

/// Which sensor's stamps are the steps of dead reckoning; the other is interpolated linearly to them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Steps {
    /// The stamps of the velocity (DVL): attitude is interpolated. The default.
    #[default]
    Velocity,
    /// The stamps of the heading: velocity is interpolated. Better where the vehicle turns much between two
    /// samples of a slow DVL.
    Attitude,
}

/// What dead reckoning reads. A component that is absent counts as zero.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// Surge velocity, m/s.
    pub u: &'a Signal,
    /// Sway velocity, m/s.
    pub v: Option<&'a Signal>,
    /// Heave velocity, m/s.
    pub w: Option<&'a Signal>,
    /// Roll, rad.
    pub phi: Option<&'a Signal>,
    /// Pitch, rad.
    pub theta: Option<&'a Signal>,
    /// Heading, rad; wrapped or not.
    pub psi: &'a Signal,
}

/// Position in earth axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Time stamps, s.
    pub time: Vec<f64>,
    /// North, east, down at each stamp, m.
    pub position: Vec<[f64; 3]>,
}

/// Dead reckoning that cannot be done.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NavigationError {
    /// Fewer than two steps lie in the time that all signals share.
    #[error(
        "dead reckoning needs two samples within the time that all its signals share ({from} s to {to} s), and found {found}"
    )]
    NoCommonTime {
        /// Latest first stamp, s.
        from: f64,
        /// Earliest last stamp, s.
        to: f64,
        /// Steps in between.
        found: usize,
    },
}

/// A signal as a function of time, linear between samples; constant zero when there is none.
struct Line<'a> {
    time: &'a [f64],
    values: Vec<f64>,
}

impl<'a> Line<'a> {
    fn new(signal: Option<&'a Signal>, angle: bool) -> Line<'a> {
        let Some(signal) = signal else { return Line { time: &[], values: vec![] } };
        let values = if angle { unwrap(signal.values()) } else { signal.values().to_vec() };
        Line { time: signal.time(), values }
    }

    fn at(&self, t: f64) -> f64 {
        let right = self.time.partition_point(|&s| s < t).min(self.time.len().saturating_sub(1));
        match right {
            0 => self.values.first().copied().unwrap_or(0.0),
            k => {
                let part = ((t - self.time[k - 1]) / (self.time[k] - self.time[k - 1])).clamp(0.0, 1.0);
                self.values[k - 1] + part * (self.values[k] - self.values[k - 1])
            }
        }
    }
}

/// Position from body velocities and attitude, by classical RK4 from stamp to stamp.
///
/// The velocity in earth axes does not depend on position, so that RK4 is Simpson's rule: each step weighs the
/// velocity at its beginning, middle and end as 1 : 4 : 1. `start` is the position (m) at the first stamp that all
/// signals share; only shared time is integrated. The position stands still over a gap (`gaps` are the stamps at
/// which one ends, s): what the vehicle did there is not known.
///
/// # Errors
/// When fewer than two stamps lie in the time that all signals share.
pub fn dead_reckon(motion: &Motion<'_>, start: [f64; 3], gaps: &[f64], steps: Steps) -> Result<Track, NavigationError> {
    let signals = [Some(motion.u), motion.v, motion.w, motion.phi, motion.theta, Some(motion.psi)];
    let ends = |s: &Signal| Some((*s.time().first()?, *s.time().last()?));
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for signal in signals.into_iter().flatten() {
        let (first, last) = ends(signal).ok_or(NavigationError::NoCommonTime { from, to, found: 0 })?;
        (from, to) = (from.max(first), to.min(last));
    }
    let stamps = match steps {
        Steps::Velocity => motion.u.time(),
        Steps::Attitude => motion.psi.time(),
    };
    let time: Vec<f64> = stamps.iter().copied().filter(|t| (from..=to).contains(t)).collect();
    if time.len() < 2 {
        return Err(NavigationError::NoCommonTime { from, to, found: time.len() });
    }
    let velocity = signals[..3].iter().map(|s| Line::new(*s, false)).collect::<Vec<_>>();
    let attitude = signals[3..].iter().map(|s| Line::new(*s, true)).collect::<Vec<_>>();
    let earth = |t: f64| {
        let [phi, theta, psi] = [0, 1, 2].map(|i| attitude[i].at(t));
        rotation(phi, theta, psi) * Vector3::from([0, 1, 2].map(|i| velocity[i].at(t)))
    };
    let mut p = Vector3::from(start);
    let mut position = Vec::with_capacity(time.len());
    position.push(start);
    for step in time.windows(2) {
        let (a, b) = (step[0], step[1]);
        if !gaps.iter().any(|&gap| a < gap && gap <= b) {
            p += (earth(a) + earth(a.midpoint(b)) * 4.0 + earth(b)) * ((b - a) / 6.0);
        }
        position.push(p.into());
    }
    Ok(Track { time, position })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamps(rate: f64, duration: f64) -> Vec<f64> {
        (0..=(rate * duration).round() as usize).map(|k| k as f64 / rate).collect()
    }

    fn signal(time: &[f64], f: impl Fn(f64) -> f64) -> Signal {
        Signal::new(time.to_vec().into(), time.iter().map(|&t| f(t)).collect::<Vec<_>>())
    }

    #[test]
    fn exact_circle_with_sensors_of_their_own_rates() {
        // u, r constant: x = u/r sin(rt), y = u/r (1 − cos(rt)); the compass wraps, 13 Hz, the DVL has 3 Hz
        let (u0, r) = (0.6, 0.5);
        let (dvl, compass) = (stamps(3.0, 40.0), stamps(13.0, 40.0));
        let wrap = |a: f64| (a + PI).rem_euclid(TAU) - PI;
        let (u, psi) = (signal(&dvl, |_| u0), signal(&compass, |t| wrap(r * t)));
        let motion = Motion { u: &u, v: None, w: None, phi: None, theta: None, psi: &psi };
        for steps in [Steps::Velocity, Steps::Attitude] {
            let track = dead_reckon(&motion, [0.0; 3], &[], steps).unwrap();
            for (t, p) in track.time.iter().zip(&track.position) {
                let (x, y) = (u0 / r * (r * t).sin(), u0 / r * (1.0 - (r * t).cos()));
                // Simpson per step: radius · (r h)⁴/2880 of the arc; h = 1/3 s gives 6e-7 of up to 1.2 m · 20 rad
                assert!((p[0] - x).abs() < 1e-5 && (p[1] - y).abs() < 1e-5 && p[2].abs() < 1e-12, "{steps:?} {t}");
            }
        }
    }

    #[test]
    fn exact_pitched_climb() {
        // nose up 0.3 rad, heading east: forward motion goes east and up (down is positive)
        let t = stamps(5.0, 10.0);
        let (u, theta, psi) = (signal(&t, |_| 1.0), signal(&t, |_| 0.3), signal(&t, |_| PI / 2.0));
        let motion = Motion { u: &u, v: None, w: None, phi: None, theta: Some(&theta), psi: &psi };
        let end = *dead_reckon(&motion, [1.0, 2.0, 3.0], &[], Steps::Velocity).unwrap().position.last().unwrap();
        let exact = [1.0, 2.0 + 10.0 * 0.3_f64.cos(), 3.0 - 10.0 * 0.3_f64.sin()];
        // constant velocity: fifty roundings
        assert!(end.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-12), "{end:?}");
    }

    #[test]
    fn nothing_is_integrated_across_a_gap_or_outside_shared_time() {
        let t = vec![0.0, 1.0, 2.0, 10.0, 11.0];
        let u = signal(&t, |_| 1.0);
        let psi = signal(&[1.0, 11.0], |_| 0.0);
        let motion = Motion { u: &u, v: None, w: None, phi: None, theta: None, psi: &psi };
        let track = dead_reckon(&motion, [0.0; 3], &[10.0], Steps::Velocity).unwrap();
        assert_eq!(track.time, [1.0, 2.0, 10.0, 11.0]);
        let north: Vec<f64> = track.position.iter().map(|p| p[0]).collect();
        assert!(north.iter().zip([0.0, 1.0, 1.0, 2.0]).all(|(a, b)| (a - b).abs() < 1e-15), "{north:?}");
        let apart = signal(&[20.0, 21.0], |_| 0.0);
        let none = dead_reckon(&Motion { psi: &apart, ..motion }, [0.0; 3], &[], Steps::Velocity);
        assert!(matches!(none, Err(NavigationError::NoCommonTime { found: 0, .. })));
    }

    #[test]
    fn law_unwrap_is_continuous_and_changes_whole_turns_only() {
        let heading: Vec<f64> = (0..400).map(|k| 10.0 * (0.02 * f64::from(k)).sin()).collect();
        let wrapped: Vec<f64> = heading.iter().map(|a| (a + PI).rem_euclid(TAU) - PI).collect();
        for (a, b) in unwrap(&wrapped).iter().zip(&heading) {
            assert!((a - b).abs() < 1e-12, "starts in (−π, π), so the turns agree");
        }
        assert!(unwrap(&[]).is_empty());
    }

    #[test]
    fn law_quaternion_and_angles_are_one_attitude() {
        for (phi, theta, psi) in [(0.1, -0.2, 0.3), (-2.5, 1.2, 3.0), (3.0, -1.5, -3.1), (0.0, 0.0, 0.0)] {
            let q = quaternion(phi, theta, psi);
            let back = euler_angles(&q);
            // near θ = −1.5 the angles are ill conditioned by 1/cos θ = 14, squared
            assert!((back[0] - phi).abs() + (back[1] - theta).abs() + (back[2] - psi).abs() < 1e-12);
            let difference = q.to_rotation_matrix().matrix() - rotation(phi, theta, psi).matrix();
            assert!(difference.amax() < 1e-14, "rounding only");
        }
        let zyx = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.3)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), -0.2)
            * Rotation3::from_axis_angle(&Vector3::x_axis(), 0.1);
        assert!((zyx.matrix() - rotation(0.1, -0.2, 0.3).matrix()).amax() < 1e-15, "rounding only");
    }

    #[test]
    fn law_both_kinematics_agree() {
        let (phi, theta, psi) = (0.4, -0.7, 2.0);
        let omega = Vector3::new(0.3, -0.2, 0.5);
        let h = 1e-5;
        let rate = euler_rates(phi, theta, &omega) * h;
        let q = quaternion(phi, theta, psi);
        let by_angles = quaternion(phi + rate.x, theta + rate.y, psi + rate.z);
        let by_quaternion = UnitQuaternion::new_normalize(*q + quaternion_rate(&q, &omega) * h);
        // both are first-order steps: they part by O(h²) = 1e-10
        assert!(by_angles.angle_to(&by_quaternion) < 1e-9);
    }
}
