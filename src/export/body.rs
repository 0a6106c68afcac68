//! The rigid body within the virtual inertia, Coriolis forces as coefficients, and conversion to
//! the other body axes.
//!
//! ```text
//! M = M_RB + M_A          M_RB = [ m I      −m S(r_g) ]       S(a) b = a × b
//!                                [ m S(r_g)  I_b      ]
//! C(ν) ν = (ω × P, ω × L + v × P),   (P, L) = M ν
//! forward-starboard-down → forward-port-up:   ν' = T ν,   T = diag(1, −1, −1, 1, −1, −1)
//! ```
//!
//! m: dry mass, kg; r_g: centre of gravity, m; I_b: dry inertia about the body origin, kg·m².
//! Fossen (2021), ch. 3, 6.

use serde::Serialize;

use super::codes;
use super::coefficients::{Coefficients, Matrix, Tensor};
use super::{ExportError, ExportOptions};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::vehicle::Vehicle;

/// Sign of a velocity or force in forward-port-up axes relative to forward-starboard-down axes.
pub const TURN: [f64; 6] = [1.0, -1.0, -1.0, 1.0, -1.0, -1.0];

/// The rigid body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Body {
    /// Dry mass, kg.
    pub mass: f64,
    /// Centre of gravity, m.
    pub cg: [f64; 3],
    /// Principal moments of inertia about the body origin, kg·m².
    pub inertia: [f64; 3],
}

/// The parts of a model in a simulator: rigid body, added mass, remaining products.
#[derive(Debug, Clone, PartialEq)]
pub struct Parts {
    /// The rigid body.
    pub body: Body,
    /// M_A: added mass, symmetric.
    pub added: Matrix,
    /// Products that remain if the simulator computes C(M_RB + M_A) itself.
    pub rest: Tensor,
    /// Products that remain if the simulator computes C(M_RB) only.
    pub rest_of_body: Tensor,
}

/// Splits the virtual inertia of a model.
///
/// # Errors
/// [`ExportError::NoMass`] and [`ExportError::NoInertia`] if the rigid body is not known.
pub fn split(
    found: &Coefficients,
    vehicle: &Vehicle,
    options: &ExportOptions,
    findings: &mut Vec<Finding>,
) -> Result<Parts, ExportError> {
    let body = rigid(found, vehicle, options, findings)?;
    let dry = body.matrix();
    let mut added = [[0.0; 6]; 6];
    for i in found.dofs.iter().map(|d| d.index()) {
        for j in 0..6 {
            let modelled = found.dofs.iter().any(|d| d.index() == j);
            // a coupling with a motion that is not modelled is in one row of the model: physically
            // it is in both
            let own = if modelled { found.inertia[i][j] - dry[i][j] } else { found.inertia[i][j] };
            added[i][j] = tidy(own, dry[i][i].max(1.0));
            if !modelled {
                added[j][i] = added[i][j];
            }
        }
    }
    for dof in &found.dofs {
        let i = dof.index();
        if added[i][i] < 0.0 {
            let text = format!(
                "{dof}: the virtual inertia {:.4} is below the dry one {:.4}: the added mass is negative, which is \
                 impossible",
                found.inertia[i][i], dry[i][i]
            );
            findings.push(Finding::new(&codes::NEGATIVE, text));
        }
    }
    let modelled = |tensor: Tensor| restricted(tensor, found);
    Ok(Parts {
        body,
        added,
        rest: less(&found.product, &modelled(coriolis(&found.inertia)), found),
        rest_of_body: less(&found.product, &modelled(coriolis(&dry)), found),
    })
}

fn rigid(
    found: &Coefficients,
    vehicle: &Vehicle,
    options: &ExportOptions,
    findings: &mut Vec<Finding>,
) -> Result<Body, ExportError> {
    let mass = options.mass.or(vehicle.mass).ok_or(ExportError::NoMass)?;
    if let Some(inertia) = options.inertia {
        return Ok(Body { mass, cg: vehicle.cg.unwrap_or([0.0; 3]), inertia });
    }
    let total: [Option<f64>; 3] =
        [Dof::Roll, Dof::Pitch, Dof::Yaw].map(|d| found.dofs.contains(&d).then(|| found.inertia[d.index()][d.index()]));
    let greatest = total.iter().flatten().copied().fold(0.0, f64::max);
    // if the model has no rotation: a homogeneous sphere of the characteristic length
    let sphere = vehicle.characteristic_length().map(|length| 0.1 * mass * length * length);
    let other = if greatest > 0.0 { greatest } else { sphere.ok_or(ExportError::NoInertia)? };
    if total.iter().any(Option::is_some) {
        let text = "the dry inertia is not known: the whole rotational inertia identified, dry and added, is given \
                    to the rigid body; the motion is the same (--inertia IXX,IYY,IZZ separates them)";
        findings.push(Finding::new(&codes::INERTIA, text));
    }
    if total.iter().any(Option::is_none) {
        let text = format!(
            "the moments of inertia of rotations that are not modelled are set to {other:.4} kg*m2: give the correct \
             ones with --inertia"
        );
        findings.push(Finding::new(&codes::GUESSED_INERTIA, text));
    }
    Ok(Body { mass, cg: vehicle.cg.unwrap_or([0.0; 3]), inertia: total.map(|i| i.unwrap_or(other)) })
}

impl Body {
    /// M_RB about the body origin.
    pub fn matrix(&self) -> Matrix {
        let mut m = [[0.0; 6]; 6];
        let dry = Vehicle { mass: Some(self.mass), cg: Some(self.cg), ..Vehicle::default() };
        for (row, column) in Dof::ALL.into_iter().flat_map(|row| Dof::ALL.map(|column| (row, column))) {
            m[row.index()][column.index()] = dry.dry_coupling(row, column).unwrap_or(0.0);
        }
        for i in 0..3 {
            m[i][i] = self.mass;
            m[3 + i][3 + i] = self.inertia[i];
        }
        m
    }

    /// Inertia about the centre of gravity, kg·m²: Ixx, Iyy, Izz, Ixy, Ixz, Iyz.
    pub fn central(&self) -> [f64; 6] {
        let [x, y, z] = self.cg;
        let m = self.mass;
        let [ixx, iyy, izz] = self.inertia;
        [
            ixx - m * (y * y + z * z),
            iyy - m * (x * x + z * z),
            izz - m * (x * x + y * y),
            m * x * y,
            m * x * z,
            m * y * z,
        ]
    }
}

/// −C(ν) ν of an inertia as coefficients of ν_j ν_k, j ≤ k.
pub fn coriolis(m: &Matrix) -> Tensor {
    let mut tensor = [[[0.0; 6]; 6]; 6];
    for j in 0..6 {
        for k in 0..6 {
            // ν_j from the rotation of the axes, ν_k from the momentum
            let mut nu = [0.0; 6];
            nu[j] = 1.0;
            let pi: [f64; 6] = std::array::from_fn(|i| m[i][k]);
            let cross = |a: &[f64], b: &[f64], i: usize| {
                let (p, q) = ((i + 1) % 3, (i + 2) % 3);
                a[p] * b[q] - a[q] * b[p]
            };
            let (low, high) = (j.min(k), j.max(k));
            for i in 0..3 {
                tensor[i][low][high] -= cross(&nu[3..], &pi[..3], i);
                tensor[3 + i][low][high] -= cross(&nu[3..], &pi[3..], i) + cross(&nu[..3], &pi[..3], i);
            }
        }
    }
    tensor
}

/// The tensor with zero entries for degrees of freedom that are not modelled.
fn restricted(mut tensor: Tensor, found: &Coefficients) -> Tensor {
    let modelled = |i: usize| found.dofs.iter().any(|d| d.index() == i);
    for i in 0..6 {
        for j in 0..6 {
            for k in 0..6 {
                if !(modelled(i) && modelled(j) && modelled(k)) {
                    tensor[i][j][k] = 0.0;
                }
            }
        }
    }
    tensor
}

fn less(all: &Tensor, counted: &Tensor, found: &Coefficients) -> Tensor {
    let mut rest = *all;
    let size = found.inertia.iter().flatten().fold(1.0_f64, |s, m| s.max(m.abs()));
    for i in 0..6 {
        for j in 0..6 {
            for k in 0..6 {
                rest[i][j][k] = tidy(all[i][j][k] - counted[i][j][k], size);
            }
        }
    }
    rest
}

/// `x`, or 0 if it is only the rounding of a difference of two numbers of this size.
fn tidy(x: f64, size: f64) -> f64 {
    if x.abs() < 1e-9 * size { 0.0 } else { x }
}

/// The matrix in forward-port-up axes.
pub fn turned(m: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| TURN[i] * TURN[j] * m[i][j]))
}

/// Coefficients of ν_j |ν_k| in forward-port-up axes: the sign of the absolute value does not
/// change.
pub fn turned_absolute(a: &Tensor) -> Tensor {
    std::array::from_fn(|i| std::array::from_fn(|j| std::array::from_fn(|k| TURN[i] * TURN[j] * a[i][j][k])))
}

/// Coefficients of ν_j ν_k in forward-port-up axes.
pub fn turned_product(p: &Tensor) -> Tensor {
    std::array::from_fn(|i| std::array::from_fn(|j| std::array::from_fn(|k| TURN[i] * TURN[j] * TURN[k] * p[i][j][k])))
}

/// A position in forward-port-up axes.
pub fn turned_place(r: [f64; 3]) -> [f64; 3] {
    [r[0], -r[1], -r[2]]
}

/// Least and greatest ratio of added to rigid inertia: the eigenvalues of M_RB⁻¹ M_A. A simulator
/// that applies the added mass as a force, from the acceleration of the previous step, is stable
/// only if they are between two limits.
pub fn added_share(rigid: &Matrix, added: &Matrix) -> [f64; 2] {
    let matrix = |m: &Matrix| nalgebra::Matrix6::from_fn(|i, j| m[i][j]);
    let none = [f64::NEG_INFINITY, f64::INFINITY];
    let Some(cholesky) = matrix(rigid).cholesky() else { return none };
    // similar to L⁻¹ M_A L⁻ᵀ, which is symmetric
    let Some(inverse) = cholesky.l().try_inverse() else { return none };
    let values = (inverse * matrix(added) * inverse.transpose()).symmetric_eigenvalues();
    [values.min(), values.max()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body() -> Body {
        Body { mass: 100.0, cg: [0.1, 0.02, -0.05], inertia: [10.0, 12.0, 14.0] }
    }

    fn force(tensor: &Tensor, nu: &[f64; 6]) -> [f64; 6] {
        std::array::from_fn(|i| {
            (0..6).flat_map(|j| (j..6).map(move |k| (j, k))).map(|(j, k)| tensor[i][j][k] * nu[j] * nu[k]).sum()
        })
    }

    #[test]
    fn coriolis_forces_do_no_work() {
        let nu = [0.7, -0.4, 0.2, 0.1, -0.3, 0.5];
        let f = force(&coriolis(&body().matrix()), &nu);
        let power: f64 = f.iter().zip(nu).map(|(f, v)| f * v).sum();
        let size: f64 = f.iter().zip(nu).map(|(f, v)| (f * v).abs()).sum();
        assert!(power.abs() < 1e-12 * size, "{power}");
        // X = m (v r − w q + x_g (q² + r²) − y_g p q − z_g p r), Fossen (2021), eq. 3.28
        let x = 100.0 * (-0.4 * 0.5 + 0.2 * 0.3 + 0.1 * (0.09 + 0.25) + 0.02 * 0.1 * 0.3 + 0.05 * 0.1 * 0.5);
        assert!((f[0] - x).abs() < 1e-9, "{} {x}", f[0]);
    }

    #[test]
    fn turning_the_axes_turns_the_forces() {
        // products, absolute values and matrices, with all cells different
        let mut all = [[[0.0; 6]; 6]; 6];
        let mut m = [[0.0; 6]; 6];
        for i in 0..6 {
            for j in 0..6 {
                m[i][j] = 1.0 + (7 * i + 3 * j) as f64;
                for k in j..6 {
                    all[i][j][k] = 1.0 + (36 * i + 6 * j + k) as f64;
                }
            }
        }
        let nu = [0.7, -0.4, 0.2, 0.1, -0.3, 0.5];
        let other: [f64; 6] = std::array::from_fn(|i| TURN[i] * nu[i]);
        let there = force(&turned_product(&all), &other);
        let linear: [f64; 6] = std::array::from_fn(|i| (0..6).map(|j| turned(&m)[i][j] * other[j]).sum());
        for i in 0..6 {
            assert!((there[i] - TURN[i] * force(&all, &nu)[i]).abs() < 1e-10);
            let here: f64 = (0..6).map(|j| m[i][j] * nu[j]).sum();
            assert!((linear[i] - TURN[i] * here).abs() < 1e-12);
        }
    }

    #[test]
    fn central_inertia_is_that_of_the_parallel_axes() {
        let [ixx, _, _, ixy, ..] = body().central();
        assert!((ixx - (10.0 - 100.0 * (0.02 * 0.02 + 0.05 * 0.05))).abs() < 1e-12);
        // I_b has no products here, so those about the centre are + m x y with the tensor's sign −(−m x y)
        assert!((ixy - 100.0 * 0.1 * 0.02).abs() < 1e-12);
    }
}
