//! One thruster: position, thrust curve and faults.
//!
//! ```text
//! F = (a V'|V'| + b V') (V_s/V_ref)ⁿ (1 − k_a |s·(v + ω × p)|) (1 − k)
//! V' = sign(V) max(|V| − c, 0), |V| ≤ V_max,   T Ḟ' = F − F'
//! a, b: curve by direction; n: supply voltage; k_a: advance; k: loss, always or from an instant on
//! ```
//!
//! Avila, Donha and Adamowski, Ocean Engineering 60 (2013), eq. 1 and 16; Fossen (2021), ch. 9.

use nalgebra::{Matrix6xX, Vector3, Vector6};

/// A thruster.
#[derive(Debug, Clone, PartialEq)]
pub struct Thruster {
    /// Name.
    pub name: &'static str,
    /// Position p, m.
    pub position: Vector3<f64>,
    /// Unit axis s of positive force.
    pub axis: Vector3<f64>,
    /// a, N per squared unit of the command, and b, N per unit, for positive commands.
    pub forward: (f64, f64),
    /// The same for negative commands; both are positive numbers.
    pub reverse: (f64, f64),
    /// Dead band c of the command.
    pub deadband: f64,
    /// Maximum of the command.
    pub max: f64,
    /// Rotor lag T, s; 0 for none.
    pub lag: f64,
    /// Loss by the water's axial speed k_a, s/m.
    pub advance_loss: f64,
    /// Exponent n of the supply voltage.
    pub supply_exponent: f64,
    /// Share k of the force that is lost (2: reversed polarity), and the instant of the campaign's
    /// clock from which on, s.
    pub loss: (f64, f64),
}

impl Thruster {
    /// A thruster without faults.
    pub fn new(
        name: &'static str,
        position: Vector3<f64>,
        axis: Vector3<f64>,
        forward: (f64, f64),
        reverse: (f64, f64),
    ) -> Thruster {
        Thruster {
            name,
            position,
            axis: axis.normalize(),
            forward,
            reverse,
            deadband: 0.0,
            max: f64::INFINITY,
            lag: 0.0,
            advance_loss: 0.0,
            supply_exponent: 0.0,
            loss: (0.0, f64::NEG_INFINITY),
        }
    }

    /// Force at bollard pull and reference voltage for a command, N.
    pub fn bollard(&self, command: f64) -> f64 {
        let command = command.clamp(-self.max, self.max);
        let v = (command.abs() - self.deadband).max(0.0);
        let (a, b) = if command > 0.0 { self.forward } else { self.reverse };
        (a * v * v + b * v).copysign(command)
    }

    /// The command for a force, limited to the maximum.
    pub fn command(&self, force: f64) -> f64 {
        if force == 0.0 {
            return 0.0;
        }
        let (a, b) = if force > 0.0 { self.forward } else { self.reverse };
        let f = force.abs();
        let v = if a > 0.0 { ((b * b + 4.0 * a * f).sqrt() - b) / (2.0 * a) } else { f / b };
        (v + self.deadband).min(self.max).copysign(force)
    }

    /// Wrench of a force of 1 N of this thruster: (s, p × s).
    pub fn unit_wrench(&self) -> Vector6<f64> {
        crate::body::six(&self.axis, &self.position.cross(&self.axis))
    }
}

/// The matrix of all unit wrenches.
pub fn configuration(thrusters: &[Thruster]) -> Matrix6xX<f64> {
    Matrix6xX::from_columns(&thrusters.iter().map(Thruster::unit_wrench).collect::<Vec<_>>())
}

/// Least-squares forces of the thrusters for a wrench: Tᵀ (T Tᵀ + ε)⁻¹ τ.
pub fn allocate(thrusters: &[Thruster], wrench: &Vector6<f64>) -> Vec<f64> {
    let t = configuration(thrusters);
    let mut square = &t * t.transpose();
    let ridge = 1e-9 * square.trace();
    for i in 0..6 {
        square[(i, i)] += ridge;
    }
    match square.try_inverse() {
        Some(inverse) => (t.transpose() * (inverse * wrench)).iter().copied().collect(),
        None => vec![0.0; thrusters.len()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one() -> Thruster {
        let mut thruster =
            Thruster::new("T1", Vector3::new(0.2, 0.1, 0.0), 2.0 * Vector3::z(), (37.0, 14.0), (28.0, 11.0));
        (thruster.deadband, thruster.max) = (0.06, 1.0);
        thruster
    }

    #[test]
    fn exact_curve_and_its_inverse() {
        let thruster = one();
        assert_eq!(thruster.bollard(0.05).abs().to_bits(), 0.0f64.to_bits());
        for force in [-20.0, -3.0, 0.5, 30.0] {
            assert!((thruster.bollard(thruster.command(force)) - force).abs() < 1e-12);
        }
        let greatest = 37.0 * 0.94 * 0.94 + 14.0 * 0.94;
        assert!((thruster.bollard(7.0) - greatest).abs() < 1e-12);
        assert!((thruster.unit_wrench() - Vector6::new(0.0, 0.0, 1.0, 0.1, -0.2, 0.0)).amax() < 1e-15);
    }
}
