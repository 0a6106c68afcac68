//! From commands to the wrench on the body.
//!
//! ```text
//! thrusters: τ = Σ wⱼ Fⱼ      or the command is the wrench itself
//! then for each degree of freedom, in this order (the losses of the catalogue):
//! τ → η τ,  (1 − k|ν|) τ,  (1 − k) τ where τ < 0,  sign(τ) max(|τ| − c, 0),  clamp to ± c,  (V/V_ref)ⁿ τ,
//! lag T ż = τ − z,  + Σ k τⱼ,  (1 − k) τ from t₀ on
//! ```

use nalgebra::{Matrix6, Vector3, Vector6};

use crate::thruster::Thruster;

/// Most thrusters that a vehicle may have.
pub const CHANNELS: usize = 8;

/// Losses that act on the force of a whole degree of freedom.
#[derive(Debug, Clone, PartialEq)]
pub struct Losses {
    /// η.
    pub interaction: [f64; 6],
    /// k by the vehicle's own speed, s/m or s.
    pub advance: [f64; 6],
    /// k where τ < 0.
    pub reverse: [f64; 6],
    /// Dead band, N or N·m.
    pub deadband: [f64; 6],
    /// Saturation, N or N·m.
    pub saturation: [f64; 6],
    /// Exponent of the supply voltage.
    pub supply_exponent: f64,
    /// Lag T, s; 0 for none.
    pub lag: f64,
    /// k_ij, 0 on the diagonal.
    pub crosstalk: Matrix6<f64>,
    /// k and t₀, s of the run.
    pub fault: [(f64, f64); 6],
}

impl Default for Losses {
    fn default() -> Losses {
        Losses {
            interaction: [1.0; 6],
            advance: [0.0; 6],
            reverse: [0.0; 6],
            deadband: [0.0; 6],
            saturation: [f64::INFINITY; 6],
            supply_exponent: 0.0,
            lag: 0.0,
            crosstalk: Matrix6::zeros(),
            fault: [(0.0, 0.0); 6],
        }
    }
}

/// All between the command and the force on the body.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Actuation {
    /// The thrusters as they are; none where the command is the wrench.
    pub thrusters: Vec<Thruster>,
    /// Losses by degree of freedom.
    pub losses: Losses,
    /// Dead time of all commands, s.
    pub delay: f64,
    /// Amplitude, share, and frequency, Hz, of a ripple on all thrust.
    pub ripple: (f64, f64),
    /// Share of all thrust that is lost from an instant of the campaign's clock on, s: a weak battery.
    pub weakened: (f64, f64),
}

/// What the actuators see of an instant.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings {
    /// Time of the run, s, and of the middle of the interval that it belongs to.
    pub time: f64,
    /// Middle of the interval of integration: on which side of an event it lies.
    pub middle: f64,
    /// Start of the run on the campaign's clock, s.
    pub clock: f64,
    /// V/V_ref.
    pub supply: f64,
    /// ν.
    pub nu: Vector6<f64>,
    /// ν_r.
    pub relative: Vector6<f64>,
}

/// States of the lags: by degree of freedom, by thruster.
pub type Lags = ([f64; 6], [f64; CHANNELS]);

impl Actuation {
    /// Number of command channels.
    pub fn channels(&self) -> usize {
        if self.thrusters.is_empty() { 6 } else { self.thrusters.len() }
    }

    /// The wrench on the body, N and N·m, the rates of the lags, and the sides of its kinks as bits.
    pub fn wrench(&self, command: &[f64; CHANNELS], lags: &Lags, at: &Surroundings) -> (Vector6<f64>, Lags, u64) {
        let mut rates: Lags = ([0.0; 6], [0.0; CHANNELS]);
        let mut sides = 0u64;
        let mut tau = Vector6::zeros();
        if self.thrusters.is_empty() {
            tau = Vector6::from_column_slice(&command[..6]);
        } else {
            for (k, thruster) in self.thrusters.iter().enumerate() {
                let steady = thruster_force(thruster, command[k], at);
                sides = sides << 2 | u64::from(command[k] > 0.0) << 1 | u64::from(command[k].abs() > thruster.deadband);
                let force = if thruster.lag > 0.0 {
                    rates.1[k] = (steady - lags.1[k]) / thruster.lag;
                    lags.1[k]
                } else {
                    steady
                };
                tau += thruster.unit_wrench() * force;
            }
        }
        if self.ripple.0 > 0.0 {
            tau *= 1.0 + self.ripple.0 * (std::f64::consts::TAU * self.ripple.1 * at.time).sin();
        }
        if at.clock + at.middle >= self.weakened.1 {
            tau *= 1.0 - self.weakened.0;
        }
        let tau = self.losses.apply(tau, &lags.0, at, &mut rates.0, &mut sides);
        (tau, rates, sides)
    }
}

/// Force of a thruster before its lag.
fn thruster_force(thruster: &Thruster, command: f64, at: &Surroundings) -> f64 {
    let mut force = thruster.bollard(command);
    if thruster.supply_exponent != 0.0 {
        force *= at.supply.powf(thruster.supply_exponent);
    }
    if thruster.advance_loss != 0.0 {
        let (v, omega) = (at.relative.fixed_rows::<3>(0), at.relative.fixed_rows::<3>(3));
        let through = v + Vector3::from(omega).cross(&thruster.position);
        force *= 1.0 - thruster.advance_loss * thruster.axis.dot(&through).abs();
    }
    let (loss, from) = thruster.loss;
    if at.clock + at.middle >= from { (1.0 - loss) * force } else { force }
}

impl Losses {
    fn apply(
        &self,
        mut tau: Vector6<f64>,
        lagged: &[f64; 6],
        at: &Surroundings,
        rates: &mut [f64; 6],
        sides: &mut u64,
    ) -> Vector6<f64> {
        let supply = if self.supply_exponent != 0.0 { at.supply.powf(self.supply_exponent) } else { 1.0 };
        for i in 0..6 {
            tau[i] *= self.interaction[i] * (1.0 - self.advance[i] * at.nu[i].abs());
            if tau[i] < 0.0 {
                tau[i] *= 1.0 - self.reverse[i];
            }
            let beyond = tau[i].abs() - self.deadband[i];
            *sides = *sides << 3
                | u64::from(tau[i] < 0.0) << 2
                | u64::from(beyond > 0.0) << 1
                | u64::from(tau[i].abs() > self.saturation[i]);
            tau[i] = beyond.max(0.0).copysign(tau[i]).clamp(-self.saturation[i], self.saturation[i]) * supply;
            if self.lag > 0.0 {
                rates[i] = (tau[i] - lagged[i]) / self.lag;
                tau[i] = lagged[i];
            }
        }
        tau += self.crosstalk * tau;
        for i in 0..6 {
            let (k, from) = self.fault[i];
            if at.middle >= from {
                tau[i] *= 1.0 - k;
            }
        }
        tau
    }
}
