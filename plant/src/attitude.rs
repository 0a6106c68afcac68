//! Attitude by a unit quaternion (w, x, y, z) from body axes to north-east-down.
//!
//! ```text
//! R(q) = 1 + 2 w S(ε) + 2 S²(ε)        q̇ = ½ (−εᵀω, (w 1 + S(ε)) ω)        Fossen (2021), eq. 2.68, 2.79
//! ```

use nalgebra::{Matrix3, Vector3};

/// A unit quaternion, w first.
pub type Quaternion = [f64; 4];

/// Cross-product matrix S(a): S(a) b = a × b.
pub fn cross_matrix(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// Rotation matrix from body axes to north-east-down.
pub fn rotation([w, x, y, z]: Quaternion) -> Matrix3<f64> {
    Matrix3::new(
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )
}

/// Rate of the quaternion at the body rates ω, rad/s.
pub fn rate([w, x, y, z]: Quaternion, omega: &Vector3<f64>) -> Quaternion {
    let [p, q, r] = [omega.x, omega.y, omega.z];
    [
        -0.5 * (x * p + y * q + z * r),
        0.5 * (w * p - z * q + y * r),
        0.5 * (z * p + w * q - x * r),
        0.5 * (-y * p + x * q + w * r),
    ]
}

/// Quaternion of the angles roll φ, pitch θ, yaw ψ (z-y-x), rad.
pub fn from_angles([phi, theta, psi]: [f64; 3]) -> Quaternion {
    let ((s1, c1), (s2, c2), (s3, c3)) = ((phi / 2.0).sin_cos(), (theta / 2.0).sin_cos(), (psi / 2.0).sin_cos());
    [c3 * c2 * c1 + s3 * s2 * s1, c3 * c2 * s1 - s3 * s2 * c1, s3 * c2 * s1 + c3 * s2 * c1, s3 * c2 * c1 - c3 * s2 * s1]
}

/// Roll, pitch and yaw of a rotation matrix, rad.
pub fn angles(r: &Matrix3<f64>) -> [f64; 3] {
    let theta = (-r[(2, 0)]).clamp(-1.0, 1.0).asin();
    [r[(2, 1)].atan2(r[(2, 2)]), theta, r[(1, 0)].atan2(r[(0, 0)])]
}

/// The angle wrapped to −π … π, rad.
pub fn wrapped(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - turn * (angle / turn).round()
}

/// The quaternion scaled to norm 1.
pub fn normalised(q: Quaternion) -> Quaternion {
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / norm)
}

/// Angle of the rotation that a quaternion describes, 0 to π, rad.
pub fn turn([w, x, y, z]: Quaternion) -> f64 {
    2.0 * (x * x + y * y + z * z).sqrt().atan2(w.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Angles survive the way to a rotation matrix and back, and the matrix is orthogonal; the
    /// tolerance allows for rounding only.
    #[test]
    fn exact_angles_come_back_and_rotations_are_orthogonal() {
        let given = [0.3, -0.7, 2.1];
        let r = rotation(from_angles(given));
        assert!((r * r.transpose() - Matrix3::identity()).amax() < 1e-15);
        for (a, b) in angles(&r).iter().zip(&given) {
            assert!((a - b).abs() < 1e-15);
        }
        // a turn of ψ alone takes the bow from north to east
        let east = rotation(from_angles([0.0, 0.0, std::f64::consts::FRAC_PI_2])) * Vector3::x();
        assert!((east - Vector3::y()).amax() < 1e-15);
    }

    /// Ṙ = R S(ω), checked by central differences, whose error is h² = 1e-10.
    #[test]
    fn law_rate_of_the_quaternion_is_that_of_the_rotation() {
        let (q, omega, h) = (from_angles([0.4, 0.2, -1.0]), Vector3::new(0.5, -0.3, 0.8), 1e-5);
        let rate = rate(q, &omega);
        let moved = |s: f64| rotation(std::array::from_fn(|k| q[k] + s * h * rate[k]));
        let difference = (moved(1.0) - moved(-1.0)) / (2.0 * h);
        assert!((difference - rotation(q) * cross_matrix(&omega)).amax() < 1e-9);
    }
}
