//! Attitude: z-y-x Euler angles and unit quaternions, R = R_z(ψ) R_y(θ) R_x(φ) from body to earth
//! axes; angles in rad.
//!
//! Source: Fossen, *Handbook of Marine Craft* (2011), chapter 2.

pub mod upright;

use std::f64::consts::{PI, TAU};

use nalgebra::UnitQuaternion;

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

/// Whether an angle may be wrapped in radians: except for a few samples it stays within one and a
/// half turns. An angle with a larger range is already unwrapped, or in degrees; its large steps
/// are no turns.
pub fn comes_round(angle: &[f64]) -> bool {
    let mut sorted: Vec<f64> = angle.iter().copied().filter(|a| a.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let few = sorted.len() / 200;
    sorted.is_empty() || sorted[sorted.len() - 1 - few] - sorted[few] < 1.5 * TAU
}

/// Removes the jumps of 2π from a heading: each step becomes the shorter one, in [−π, π).
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

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;

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
    fn a_heading_in_degrees_does_not_come_round_in_radians() {
        let heading = |k: i32| 4.0 * (0.05 * f64::from(k)).sin();
        let wrapped: Vec<f64> = (0..400).map(|k| heading(k).rem_euclid(TAU)).collect();
        let mut spiked = wrapped.clone();
        spiked[7] = -9999.0;
        assert!(comes_round(&wrapped) && comes_round(&spiked) && comes_round(&[]));
        let degrees: Vec<f64> = (0..400).map(|k| heading(k).to_degrees()).collect();
        let unwound: Vec<f64> = (0..400).map(|k| 0.1 * f64::from(k)).collect();
        assert!(!comes_round(&degrees) && !comes_round(&unwound));
    }

    #[test]
    fn law_quaternion_and_angles_are_one_attitude() {
        for (phi, theta, psi) in [(0.1, -0.2, 0.3), (-2.5, 1.2, 3.0), (3.0, -1.5, -3.1), (0.0, 0.0, 0.0)] {
            let q = quaternion(phi, theta, psi);
            let back = euler_angles(&q);
            // near θ = −1.5 the angles are ill conditioned by 1/cos θ = 14, squared
            assert!((back[0] - phi).abs() + (back[1] - theta).abs() + (back[2] - psi).abs() < 1e-12);
            let difference = q.to_rotation_matrix().matrix() - Rotation3::from_euler_angles(phi, theta, psi).matrix();
            assert!(difference.amax() < 1e-14, "rounding only");
        }
        let zyx = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.3)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), -0.2)
            * Rotation3::from_axis_angle(&Vector3::x_axis(), 0.1);
        assert!((zyx.matrix() - Rotation3::from_euler_angles(0.1, -0.2, 0.3).matrix()).amax() < 1e-15, "rounding only");
    }
}
