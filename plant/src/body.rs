//! The rigid body: inertia, Coriolis and centripetal forces, weight and buoyancy.
//!
//! ```text
//! M_RB = [ m 1      −m S(r_g) ]   C_RB(ν) = [ m S(ω)          −m S(ω) S(r_g) ]   Fossen (2021), eq. 3.52
//!        [ m S(r_g)  I_b      ]             [ m S(r_g) S(ω)   −S(I_b ω)      ]   form without v: eq. 3.63
//! g(η) = −[ f_g + f_b ; r_g × f_g + r_b × f_b ]    f_g = Rᵀ(0, 0, W), f_b = −Rᵀ(0, 0, B)           eq. 4.4
//! ```
//!
//! All quantities are about the origin of the body axes; r_g is the centre of gravity, r_b the
//! centre of buoyancy, I_b the inertia about the origin.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use crate::attitude::cross_matrix;

/// Acceleration of gravity, m/s².
pub const GRAVITY: f64 = 9.81;

/// Mass properties and buoyancy of the rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Dry mass m, kg.
    pub mass: f64,
    /// Centre of gravity r_g, m.
    pub gravity_centre: Vector3<f64>,
    /// Inertia I_b about the origin, kg·m².
    pub inertia: Matrix3<f64>,
    /// Weight W, N.
    pub weight: f64,
    /// Buoyancy B, N.
    pub buoyancy: f64,
    /// Centre of buoyancy r_b, m.
    pub buoyancy_centre: Vector3<f64>,
}

impl Body {
    /// M_RB.
    pub fn inertia_matrix(&self) -> Matrix6<f64> {
        let mut matrix = Matrix6::zeros();
        let arm = self.mass * cross_matrix(&self.gravity_centre);
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&(self.mass * Matrix3::identity()));
        matrix.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm);
        matrix.fixed_view_mut::<3, 3>(3, 0).copy_from(&arm);
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.inertia);
        matrix
    }

    /// C_RB(ν) ν, N and N·m.
    pub fn coriolis(&self, v: &Vector3<f64>, omega: &Vector3<f64>) -> Vector6<f64> {
        let turning = omega.cross(v);
        let force = self.mass * (turning + omega.cross(&omega.cross(&self.gravity_centre)));
        let moment = self.mass * self.gravity_centre.cross(&turning) + omega.cross(&(self.inertia * omega));
        six(&force, &moment)
    }

    /// −g(η) for `down` = Rᵀ(0, 0, 1), N and N·m.
    pub fn restoring(&self, down: &Vector3<f64>) -> Vector6<f64> {
        let (weight, buoyancy) = (self.weight * down, -self.buoyancy * down);
        let moment = self.gravity_centre.cross(&weight) + self.buoyancy_centre.cross(&buoyancy);
        six(&(weight + buoyancy), &moment)
    }

    /// The body with a neutrally buoyant point mass added at `place`: the mass adds its weight and
    /// an equal buoyancy. A negative mass is taken away.
    #[must_use]
    pub fn with_floating_mass(&self, mass: f64, place: Vector3<f64>) -> Body {
        let arm = cross_matrix(&place);
        let (total, lift) = (self.mass + mass, mass * GRAVITY);
        let buoyancy = self.buoyancy + lift;
        Body {
            mass: total,
            gravity_centre: (self.mass * self.gravity_centre + mass * place) / total,
            inertia: self.inertia - mass * arm * arm,
            weight: self.weight + lift,
            buoyancy,
            buoyancy_centre: (self.buoyancy * self.buoyancy_centre + lift * place) / buoyancy,
        }
    }
}

/// A vector of six from its two halves.
pub fn six(first: &Vector3<f64>, second: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(first.x, first.y, first.z, second.x, second.y, second.z)
}
