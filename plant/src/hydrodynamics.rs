//! Hydrodynamic forces on a body that moves through the water with ν_r: added mass and drag.
//!
//! ```text
//! C_A(ν_r) = [ 0            −S(A₁₁v + A₁₂ω) ]                                      Fossen (2021), eq. 6.44
//!            [ −S(A₁₁v + A₁₂ω)  −S(A₂₁v + A₂₂ω) ]
//! D(ν_r)ν_r, row i: Σⱼ (d_ij νⱼ + q_ij νⱼ|νⱼ| + m_ij |νⱼ|νᵢ + e_ij νⱼ² + l_ij u νⱼ)
//!                   + c_i νᵢ³ + a_i νᵢ|νᵢ| [νᵢ < 0] + s_i √|νᵢ| νᵢ
//!                   + f_i tanh(νᵢ/ε) + k_i zᵢ,   T_i żᵢ = νᵢ − zᵢ
//! ```

use nalgebra::{Matrix6, Vector3, Vector6};

use crate::body::six;

/// ε of dry friction, m/s or rad/s.
pub const FRICTION_WIDTH: f64 = 0.01;

/// Coefficients of added mass and drag; drag is positive where it dissipates. SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Hydrodynamics {
    /// Added mass M_A, symmetric.
    pub added_mass: Matrix6<f64>,
    /// Linear drag d_ij, cross terms off the diagonal.
    pub linear: Matrix6<f64>,
    /// Quadratic drag q_ij.
    pub quadratic: Matrix6<f64>,
    /// Drag m_ij |νⱼ| νᵢ: drag on the motion in i that grows with the speed in j.
    pub mixed: Matrix6<f64>,
    /// Force e_ij νⱼ²: proportional to the square of the motion in another direction, whatever its sign.
    pub even: Matrix6<f64>,
    /// Moment l_ij u νⱼ of the lift of the hull: proportional to the speed ahead and the motion across.
    pub lift: Matrix6<f64>,
    /// Cubic drag c_i.
    pub cubic: [f64; 6],
    /// Additional quadratic drag a_i for νᵢ < 0.
    pub asymmetry: [f64; 6],
    /// Drag s_i proportional to the power 1.5 of the speed.
    pub three_halves: [f64; 6],
    /// Dry friction f_i.
    pub friction: [f64; 6],
    /// Fluid memory: strength k_i and time T_i, s; no memory if k_i is 0.
    pub memory: [(f64, f64); 6],
}

impl Hydrodynamics {
    /// Added mass only, without drag.
    pub fn ideal(added_mass: Matrix6<f64>) -> Hydrodynamics {
        Hydrodynamics {
            added_mass,
            linear: Matrix6::zeros(),
            quadratic: Matrix6::zeros(),
            mixed: Matrix6::zeros(),
            even: Matrix6::zeros(),
            lift: Matrix6::zeros(),
            cubic: [0.0; 6],
            asymmetry: [0.0; 6],
            three_halves: [0.0; 6],
            friction: [0.0; 6],
            memory: [(0.0, 1.0); 6],
        }
    }

    /// C_A(ν_r) ν_r of the added mass `added_mass`, N and N·m.
    pub fn coriolis(added_mass: &Matrix6<f64>, nu: &Vector6<f64>) -> Vector6<f64> {
        let momentum = added_mass * nu;
        let linear = Vector3::new(momentum[0], momentum[1], momentum[2]);
        let angular = Vector3::new(momentum[3], momentum[4], momentum[5]);
        let (v, omega) = (Vector3::new(nu[0], nu[1], nu[2]), Vector3::new(nu[3], nu[4], nu[5]));
        six(&-linear.cross(&omega), &(-linear.cross(&v) - angular.cross(&omega)))
    }

    /// D(ν_r) ν_r without memory, N and N·m.
    pub fn drag(&self, nu: &Vector6<f64>) -> Vector6<f64> {
        let magnitude = nu.abs();
        let mut drag = self.linear * nu + self.quadratic * nu.component_mul(&magnitude);
        drag += (self.mixed * magnitude).component_mul(nu) + self.even * nu.component_mul(nu);
        drag += self.lift * nu * nu[0];
        for i in 0..6 {
            let v = nu[i];
            drag[i] += self.cubic[i] * v * v * v;
            if v < 0.0 {
                drag[i] += self.asymmetry[i] * v * v.abs();
            }
            if self.three_halves[i] != 0.0 {
                drag[i] += self.three_halves[i] * v * v.abs().sqrt();
            }
            if self.friction[i] != 0.0 {
                drag[i] += self.friction[i] * (v / FRICTION_WIDTH).tanh();
            }
        }
        drag
    }
}
