//! The pilot: forces as functions of time and measured motion.
//!
//! ```text
//! sine        τ = B + A sin(2πt/P + φ)              multi-sine   τ = B + Σ A sin(2πt/P + φ)
//! zig-zag     τ = ±M, changes sign when |ψ − ψ₀| ≥ ψ_max
//! heading     τ = k (ψ₀ − ψ) − d r                  depth        τ = k (z₀ − z) − d w
//! ```
//!
//! Source of the profiles: Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94.

use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

use crate::frame::Dof;

/// Motion that the pilot sees: that of the sensors, but without noise. A degree of freedom that is
/// not simulated reads 0.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Measured {
    /// ν, m/s and rad/s.
    pub nu: [f64; 6],
    /// η, m and rad.
    pub pose: [f64; 6],
}

/// A sine of a profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sine {
    /// Amplitude A, N or N·m.
    pub amplitude: f64,
    /// Period P, s.
    pub period: f64,
    /// Phase φ, rad.
    pub phase: f64,
}

impl Sine {
    /// A sine of phase 0.
    pub const fn new(amplitude: f64, period: f64) -> Sine {
        Sine { amplitude, period, phase: 0.0 }
    }
}

/// A force as a function of time and measured motion, for [`Law::Function`].
pub type Profile = dyn Fn(f64, &Measured) -> f64 + Send + Sync;

/// Control law in one degree of freedom.
#[derive(Clone)]
pub enum Law {
    /// Offset B, N or N·m, and sines; no sines for a constant force.
    Sines(f64, Vec<Sine>),
    /// Zig-zag.
    Zigzag {
        /// M, N·m; the first turn has its sign.
        moment: f64,
        /// ψ₀, rad.
        centre: f64,
        /// ψ_max, rad.
        bound: f64,
    },
    /// Holds the pose of this degree of freedom: heading in yaw, depth in heave.
    Hold {
        /// Pose to hold, m or rad.
        target: f64,
        /// k, N/m or N·m/rad.
        stiffness: f64,
        /// d, N·s/m or N·m·s/rad.
        damping: f64,
    },
    /// Any other function.
    Function(Arc<Profile>),
}

impl fmt::Debug for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Law::Sines(offset, sines) => f.debug_tuple("Sines").field(offset).field(sines).finish(),
            Law::Zigzag { moment, centre, bound } => write!(f, "Zigzag({moment}, {centre} ± {bound})"),
            Law::Hold { target, stiffness, damping } => write!(f, "Hold({target}, {stiffness}, {damping})"),
            Law::Function(_) => f.write_str("Function"),
        }
    }
}

impl Law {
    /// A constant force, N or N·m.
    pub fn constant(force: f64) -> Law {
        Law::Sines(force, Vec::new())
    }

    /// B + A sin(2πt/P).
    pub fn sine(offset: f64, amplitude: f64, period: f64) -> Law {
        Law::Sines(offset, vec![Sine::new(amplitude, period)])
    }
}

/// Laws of a trial; several laws in one degree of freedom add up.
#[derive(Debug, Clone, Default)]
pub struct Pilot {
    /// Each law with its degree of freedom.
    pub laws: Vec<(Dof, Law)>,
    /// Direction in which each zig-zag turns, +1 or −1; unused for other laws.
    turns: Vec<f64>,
}

impl Pilot {
    /// A pilot with these laws.
    pub fn new(laws: Vec<(Dof, Law)>) -> Pilot {
        Pilot { turns: vec![1.0; laws.len()], laws }
    }

    /// The command for the instant `t`, N and N·m, with the motion `seen`.
    pub fn command(&mut self, t: f64, seen: &Measured) -> [f64; 6] {
        let mut tau = [0.0; 6];
        for ((dof, law), turn) in self.laws.iter().zip(&mut self.turns) {
            let i = dof.index();
            tau[i] += match law {
                Law::Sines(offset, sines) => {
                    offset + sines.iter().map(|s| s.amplitude * (TAU * t / s.period + s.phase).sin()).sum::<f64>()
                }
                Law::Zigzag { moment, centre, bound } => {
                    let off = seen.pose[i] - centre;
                    if off.abs() >= *bound {
                        // back towards the centre, whatever the sign of the moment
                        *turn = -off.signum() * moment.signum();
                    }
                    *turn * moment
                }
                Law::Hold { target, stiffness, damping } => stiffness * (target - seen.pose[i]) - damping * seen.nu[i],
                Law::Function(profile) => profile(t, seen),
            };
        }
        tau
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heading(psi: f64) -> Measured {
        Measured { pose: [0.0, 0.0, 0.0, 0.0, 0.0, psi], ..Measured::default() }
    }

    #[test]
    fn zigzag_flips_at_the_bound_and_not_before() {
        let mut pilot = Pilot::new(vec![(Dof::Yaw, Law::Zigzag { moment: 70.0, centre: 0.5, bound: 1.0 })]);
        let mut yaw = |psi| pilot.command(0.0, &heading(psi))[5];
        assert_eq!(
            [yaw(0.5), yaw(1.4), yaw(1.5), yaw(0.0), yaw(-0.6), yaw(1.0)],
            [70.0, 70.0, -70.0, -70.0, 70.0, 70.0]
        );
    }

    #[test]
    fn laws_of_one_degree_of_freedom_add_up() {
        let hold = Law::Hold { target: 0.2, stiffness: 10.0, damping: 1.0 };
        let late = Law::Function(Arc::new(|t, seen: &Measured| t * (1.0 + seen.pose[5])));
        let mut pilot = Pilot::new(vec![(Dof::Yaw, Law::sine(3.0, 2.0, 4.0)), (Dof::Yaw, hold), (Dof::Yaw, late)]);
        let tau = pilot.command(1.0, &heading(0.0));
        // sin(π/2) is 1 in floating point
        assert_eq!(tau, [0.0, 0.0, 0.0, 0.0, 0.0, 3.0 + 2.0 + 10.0 * 0.2 + 1.0]);
    }
}
