//! Motion of the water: currents and waves.
//!
//! ```text
//! steady        V = V₀                                        tide   V = V₀ (cos α, sin α),  α = α₀ + 2πt/P
//! by heading    V = V₀ (1 + cos(ψ − ψ₀))/2                    (for example a vehicle in the lee of a wall)
//! waves         Xᵢ = Σ aₖ sin(ωₖ t + φₖ),  aₖ² ∝ S(ωₖ) Δω     S of JONSWAP, γ = 1: Pierson and Moskowitz
//! ```
//!
//! V is the velocity of the water over ground, north and east; V̇ goes into ν̇_r. Fossen (2021), ch. 10.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use crate::random::Random;

/// The current.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Current {
    /// No current.
    #[default]
    Still,
    /// A constant velocity, m/s.
    Steady(Vector3<f64>),
    /// A current of constant speed whose direction turns once in `period` s of the campaign's clock.
    Tide {
        /// Speed, m/s.
        speed: f64,
        /// Period of a full turn, s.
        period: f64,
        /// Direction at the clock's zero, rad from north.
        direction: f64,
    },
    /// A current that depends on the vehicle's heading.
    ByHeading {
        /// Maximum velocity, m/s.
        velocity: Vector3<f64>,
        /// Heading of the maximum, rad.
        heading: f64,
    },
}

impl Current {
    /// Velocity V over ground and its derivative V̇ at the campaign's `clock`, s, for a vehicle
    /// with rotation matrix `r` and angular rates `omega`, rad/s.
    pub fn velocity(&self, clock: f64, r: &Matrix3<f64>, omega: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        match self {
            Current::Still => (Vector3::zeros(), Vector3::zeros()),
            Current::Steady(v) => (*v, Vector3::zeros()),
            Current::Tide { speed, period, direction } => {
                let speed = *speed;
                let rate = TAU / period;
                let (sin, cos) = (direction + rate * clock).sin_cos();
                (speed * Vector3::new(cos, sin, 0.0), speed * rate * Vector3::new(-sin, cos, 0.0))
            }
            Current::ByHeading { velocity, heading } => {
                // ψ and ψ̇: direction of the bow in the horizontal plane, and its rate
                let (bow, starboard, down) = (r.column(0), r.column(1), r.column(2));
                let moved = starboard * omega.z - down * omega.y;
                let square = bow[0] * bow[0] + bow[1] * bow[1];
                let turning = (bow[0] * moved[1] - bow[1] * moved[0]) / square;
                let off = bow[1].atan2(bow[0]) - heading;
                (velocity * (0.5 * (1.0 + off.cos())), velocity * (-0.5 * off.sin() * turning))
            }
        }
    }
}

/// A sinusoidal force in one degree of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// Index of the degree of freedom.
    pub dof: usize,
    /// Amplitude, N or N·m.
    pub amplitude: f64,
    /// Angular frequency, rad/s.
    pub frequency: f64,
    /// Phase, rad.
    pub phase: f64,
}

impl Wave {
    /// Force at the time `t` of the run, s.
    pub fn force(&self, t: f64) -> f64 {
        self.amplitude * (self.frequency * t + self.phase).sin()
    }
}

/// Spectrum of wave forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sea {
    /// Root mean square of the force in each degree of freedom, N and N·m.
    pub rms: [f64; 6],
    /// Peak period, s.
    pub period: f64,
    /// Peak enhancement γ: 3.3 for JONSWAP, 1 for Pierson and Moskowitz.
    pub enhancement: f64,
}

/// Number of components of a sea.
const COMPONENTS: usize = 24;

impl Sea {
    /// The components of one realisation.
    pub fn realise(&self, random: &mut Random) -> Vec<Wave> {
        let peak = TAU / self.period;
        // one random frequency in each of equal cells, so that the record does not repeat
        let frequencies: Vec<f64> =
            (0..COMPONENTS).map(|k| peak * (0.5 + 2.0 * (k as f64 + random.uniform()) / COMPONENTS as f64)).collect();
        let density: Vec<f64> = frequencies.iter().map(|w| self.density(w / peak)).collect();
        let total: f64 = density.iter().sum();
        let mut waves = Vec::new();
        for dof in (0..6).filter(|dof| self.rms[*dof] > 0.0) {
            for (frequency, s) in frequencies.iter().zip(&density) {
                let amplitude = self.rms[dof] * (2.0 * s / total).sqrt();
                waves.push(Wave { dof, amplitude, frequency: *frequency, phase: random.between(0.0, TAU) });
            }
        }
        waves
    }

    /// JONSWAP spectrum S up to a factor; `x` is the frequency over that of the peak.
    fn density(&self, x: f64) -> f64 {
        let width = if x <= 1.0 { 0.07 } else { 0.09 };
        let bump = (-(x - 1.0).powi(2) / (2.0 * width * width)).exp();
        x.powi(-5) * (-1.25 * x.powi(-4)).exp() * self.enhancement.powf(bump)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wave forces have the root mean square that is asked for. The tolerance of 5 % is for the
    /// finite time: over 4000 s the mean square of 24 sines differs by a few per cent from the sum
    /// of their mean squares.
    #[test]
    fn law_a_sea_has_the_rms_it_is_given() {
        let sea = Sea { rms: [3.0, 0.0, 0.0, 0.0, 0.0, 0.5], period: 4.0, enhancement: 3.3 };
        let waves = sea.realise(&mut Random::new(1, 0));
        for (dof, rms) in [(0, 3.0), (5, 0.5)] {
            let force = |t: f64| waves.iter().filter(|w| w.dof == dof).map(|w| w.force(t)).sum::<f64>();
            let mean = (0..40_000).map(|k| force(0.1 * f64::from(k)).powi(2)).sum::<f64>() / 40_000.0;
            assert!((mean.sqrt() / rms - 1.0).abs() < 0.05, "{dof}: {}", mean.sqrt());
        }
    }

    /// V̇ is the derivative of V for a turning vehicle, checked by central differences with an error of h².
    #[test]
    fn law_acceleration_of_the_water_is_the_derivative_of_its_velocity() {
        let omega = Vector3::new(0.2, -0.3, 0.4);
        let q = crate::attitude::from_angles([0.3, 0.4, 1.0]);
        let rate = crate::attitude::rate(q, &omega);
        let still = Vector3::new(0.2, -0.1, 0.0);
        for current in [
            Current::Tide { speed: 0.3, period: 50.0, direction: 1.0 },
            Current::ByHeading { velocity: still, heading: 0.3 },
        ] {
            let at = |s: f64| {
                let r = crate::attitude::rotation(std::array::from_fn(|k| q[k] + s * rate[k]));
                current.velocity(7.0 + s, &r, &omega)
            };
            let difference = (at(1e-4).0 - at(-1e-4).0) / 2e-4;
            assert!((difference - at(0.0).1).amax() < 1e-7, "{current:?}");
        }
    }
}
