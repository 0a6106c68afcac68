//! The attitude of the vehicle: its internal representation, its rate, and its difference from the
//! logged one.
//!
//! ```text
//! angles:     φ̇ = p + (q sin φ + r cos φ) tan θ,   θ̇ = q cos φ − r sin φ,   ψ̇ = (q sin φ + r cos φ)/cos θ
//! quaternion: q̇ = ½ q ⊗ (0, ω),   R = R(q/|q|)
//! ```
//!
//! Angles are three states, those that instruments log, and singular at θ = ±90°. The quaternion is
//! four states and nowhere singular; its norm has no effect, so that errors of the integrator in it
//! do not matter. It is used if a run comes near the vertical. Fossen, *Handbook of Marine Craft*
//! (2021), 2.2; Diebel, *Representing Attitude* (2006).

use crate::effects::{Instant, Six};
use crate::frame::Dof;
use crate::model::Model;
use crate::navigation::upright;
use crate::run::Run;
use crate::symbolic::Expr;

/// Internal representation of the attitude.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Attitude {
    /// z-y-x Euler angles.
    #[default]
    Angles,
    /// A unit quaternion.
    Quaternion,
}

impl Attitude {
    /// A quaternion if a run comes near the vertical, all runs log all angles, and the model turns
    /// about more than one axis; else angles. A model that only pitches has no pole: its θ
    /// continues beyond 90°.
    pub fn of(model: &Model, runs: &[Run]) -> Attitude {
        let upright = turns_freely(model) && runs.iter().any(upright::is_steep) && runs.iter().all(upright::is_whole);
        if upright { Attitude::Quaternion } else { Attitude::Angles }
    }
}

/// Whether Euler angles of the model have a pole: it pitches, and also turns about another axis.
pub fn turns_freely(model: &Model) -> bool {
    let turns = |dof: Dof| model.dofs.contains(&dof);
    turns(Dof::Pitch) && (turns(Dof::Roll) || turns(Dof::Yaw))
}

/// R(q/|q|), from body to earth axes, of q = (w, x, y, z).
pub(super) fn rotation<'g>([w, x, y, z]: [Expr<'g>; 4]) -> [[Expr<'g>; 3]; 3] {
    let one = w.graph().constant(1.0);
    let s = w.graph().constant(2.0) / (w * w + x * x + y * y + z * z);
    [
        [one - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), one - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), one - s * (x * x + y * y)],
    ]
}

/// φ, θ, ψ of a rotation: φ and ψ in (−π, π], θ in [−π/2, π/2].
pub(super) fn angles<'g>(r: &[[Expr<'g>; 3]; 3]) -> [Expr<'g>; 3] {
    let level = (r[2][1] * r[2][1] + r[2][2] * r[2][2]).sqrt();
    [r[2][1].atan2(r[2][2]), (-r[2][0]).atan2(level), r[1][0].atan2(r[0][0])]
}

/// The quaternion of z-y-x Euler angles.
fn quaternion_of<'g>([phi, theta, psi]: [Expr<'g>; 3]) -> [Expr<'g>; 4] {
    let half = |angle: Expr<'g>| ((angle * 0.5).sin(), (angle * 0.5).cos());
    let ((sf, cf), (st, ct), (sp, cp)) = (half(phi), half(theta), half(psi));
    [cf * ct * cp + sf * st * sp, sf * ct * cp - cf * st * sp, cf * st * cp + sf * ct * sp, cf * ct * sp - sf * st * cp]
}

/// q̇ = ½ q ⊗ (0, ω).
pub(super) fn quaternion_rate<'g>([w, x, y, z]: [Expr<'g>; 4], nu: &Six<'g>) -> [Expr<'g>; 4] {
    let [_, _, _, p, q, r] = *nu;
    [
        (x * p + y * q + z * r) * -0.5,
        (w * p + y * r - z * q) * 0.5,
        (w * q + z * p - x * r) * 0.5,
        (w * r + x * q - y * p) * 0.5,
    ]
}

/// The rotation from `logged` to the attitude that the sensors would log, in earth axes, rad.
/// `said`: the angles that they would log, if these have an error.
pub(super) fn turn<'g>(own: [Expr<'g>; 4], said: Option<[Expr<'g>; 3]>, logged: [Expr<'g>; 4]) -> [Expr<'g>; 3] {
    let [w, x, y, z] = said.map_or(own, quaternion_of);
    let [a, b, c, d] = logged;
    let square = |q: [Expr<'g>; 4]| q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    let cosine = w * a + x * b + y * c + z * d;
    let scale = cosine.sign() * 2.0 / (square([w, x, y, z]) * square(logged)).sqrt();
    [x * a - w * b - (y * d - z * c), y * a - w * c - (z * b - x * d), z * a - w * d - (x * c - y * b)]
        .map(|e| e * scale)
}

/// η̇ = J(η) ν: rates of the position and, if the attitude is by angles, of the angles. A model
/// that simulates neither roll nor pitch moves in the horizontal plane: its kinematics are planar,
/// whatever small tilt the log shows.
pub(super) fn kinematics<'g>(at: &Instant<'g>) -> Six<'g> {
    let (zero, [x, y, z]) = (at.graph.zero(), at.over_ground());
    let [.., p, q, yaw] = at.nu;
    if at.is_planar() {
        return [x, y, z, zero, zero, yaw];
    }
    let [phi, theta, _] = at.attitude;
    let turn = q * phi.sin() + yaw * phi.cos();
    [x, y, z, p + turn * theta.tan(), q * phi.cos() - yaw * phi.sin(), turn / theta.cos()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::navigation::{euler_angles, quaternion};
    use crate::symbolic::{Graph, Leaf};
    use crate::units::Dimension;
    use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};

    /// The formulas against nalgebra's own, at an attitude beyond the vertical; rounding only.
    #[test]
    fn exact_formulas_of_the_quaternion() {
        let graph = Graph::new();
        let leaf = |k: u16| graph.leaf(Leaf::State(k), Dimension::ONE);
        let (own, other) = ([0, 1, 2, 3].map(leaf), [4, 5, 6, 7].map(leaf));
        let nu = [8, 9, 10, 11, 12, 13].map(leaf);
        let q = quaternion(0.4, 1.4, -2.0) * quaternion(0.0, 0.9, 0.0);
        let turned = Vector3::new(0.02, -0.3, 0.1);
        let logged = UnitQuaternion::new(-turned) * q;
        let omega = Vector3::new(0.3, -0.2, 0.5);
        // a norm other than 1 and the opposite sign have no meaning
        let list = |q: &UnitQuaternion<f64>, scale: f64| [q.w, q.i, q.j, q.k].map(|x| x * scale);
        let (a, b) = (list(&q, 1.3), list(&logged, -0.9));
        let read = |leaf: Leaf| match leaf {
            Leaf::State(k) if k < 4 => a[usize::from(k)],
            Leaf::State(k) if k < 8 => b[usize::from(k) - 4],
            Leaf::State(k) if k > 10 => omega[usize::from(k) - 11],
            _ => 0.0,
        };
        let near = |found: Expr<'_>, exact: f64| {
            let found = found.evaluate(&read);
            assert!((found - exact).abs() < 1e-14, "{found} for {exact}");
        };
        let [phi, theta, psi] = euler_angles(&q);
        let r = rotation(own);
        for i in 0..3 {
            for j in 0..3 {
                near(r[i][j], Rotation3::from_euler_angles(phi, theta, psi)[(i, j)]);
            }
        }
        for (found, exact) in angles(&r).into_iter().zip([phi, theta, psi]) {
            near(found, exact);
        }
        // q̇ = ½ q ⊗ (0, ω)
        let rate = q.into_inner() * 1.3 * Quaternion::from_parts(0.0, omega) * 0.5;
        for (found, exact) in quaternion_rate(own, &nu).into_iter().zip([rate.w, rate.i, rate.j, rate.k]) {
            near(found, exact);
        }
        let size = turned.norm();
        for said in [None, Some(angles(&r))] {
            for (found, exact) in
                turn(own, said, other).into_iter().zip((turned * (2.0 * (size / 2.0).sin() / size)).iter())
            {
                near(found, *exact);
            }
        }
        assert!((Quaternion::from(a).norm() - 1.3).abs() < 1e-14);
    }
}
