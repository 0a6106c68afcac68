//! Two very different vehicles, with properties drawn at random about typical values.
//!
//! The large one is like LAURS (Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94:
//! masses and drag in surge and yaw near Tables 3, 5, 7 and 9; all other values are assumed). The
//! small one is like a BlueROV2 (masses and drag near von Benzon et al., *Journal of Marine Science
//! and Engineering* 10 (2022) 1898, rounded).

use super::Noise;
use crate::vehicle::Vehicle;

/// Kind of vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CraftKind {
    /// 190 kg, open frame, like LAURS.
    #[default]
    Large,
    /// 11.5 kg, like a BlueROV2.
    Small,
}

/// Properties of a vehicle, in the order of ν.
#[derive(Debug, Clone, PartialEq)]
pub struct Craft {
    /// Weighed and measured properties.
    pub vehicle: Vehicle,
    /// Mass or moment of inertia with added mass, kg and kg·m².
    pub inertia: [f64; 6],
    /// Linear drag, kg/s and kg·m²/s.
    pub linear: [f64; 6],
    /// Quadratic drag, kg/m and kg·m².
    pub quadratic: [f64; 6],
    /// Righting moment per radian of roll and pitch, N·m.
    pub righting: f64,
    /// Maximum force of the thrusters in ordinary work, N and N·m.
    pub force: [f64; 6],
}

/// Typical values: mass, volume, net buoyancy, length, inertia, linear drag, quadratic drag,
/// righting moment, force.
struct Typical {
    mass: f64,
    volume: f64,
    net_buoyancy: f64,
    length: f64,
    inertia: [f64; 6],
    linear: [f64; 6],
    quadratic: [f64; 6],
    righting: f64,
    force: [f64; 6],
}

const LARGE: Typical = Typical {
    mass: 189.0,
    volume: 0.19,
    net_buoyancy: 33.4,
    length: 0.575,
    inertia: [790.0, 620.0, 700.0, 62.0, 105.0, 190.0],
    linear: [80.0, 110.0, 150.0, 32.0, 52.0, 16.0],
    quadratic: [310.0, 500.0, 640.0, 60.0, 140.0, 95.0],
    righting: 120.0,
    force: [335.0, 170.0, 200.0, 40.0, 60.0, 110.0],
};

const SMALL: Typical = Typical {
    mass: 11.5,
    volume: 0.0117,
    net_buoyancy: 1.5,
    length: 0.227,
    inertia: [17.0, 22.0, 25.0, 0.30, 0.31, 0.45],
    linear: [5.0, 8.0, 5.5, 0.28, 0.28, 0.8],
    quadratic: [20.0, 40.0, 35.0, 1.5, 1.5, 1.7],
    righting: 3.0,
    force: [15.0, 11.0, 14.0, 1.0, 1.0, 1.2],
};

/// Least relative difference of the virtual masses in surge and sway: below it there is hardly a
/// Munk moment.
const LEAST_MUNK: f64 = 0.15;

/// Least righting moment in units of the Munk moment in pitch, (m_w − m_u) u² θ: below it the
/// vehicle tumbles.
const LEAST_RIGHTING: f64 = 2.5;

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.81;

impl Craft {
    /// Draws a vehicle of a kind, with properties within a fifth of the typical ones.
    pub fn draw(kind: CraftKind, noise: &mut Noise) -> Craft {
        let (typical, name) = match kind {
            CraftKind::Large => (&LARGE, "large"),
            CraftKind::Small => (&SMALL, "small"),
        };
        let mut near = |list: &[f64; 6]| list.map(|x| x * noise.between(0.8, 1.2));
        let (mut inertia, linear, quadratic) =
            (near(&typical.inertia), near(&typical.linear), near(&typical.quadratic));
        if (inertia[1] / inertia[0] - 1.0).abs() < LEAST_MUNK {
            inertia[1] = inertia[0] * (1.0 + (inertia[1] - inertia[0]).signum() * LEAST_MUNK);
        }
        let drawn = typical.righting * noise.between(0.8, 1.2);
        let weight = typical.mass * GRAVITY;
        let vehicle = Vehicle {
            name: name.to_string(),
            mass: Some(typical.mass),
            volume: Some(typical.volume),
            weight: Some(weight),
            buoyancy: Some(weight + typical.net_buoyancy),
            length: Some(typical.length),
            ..Vehicle::default()
        };
        let mut craft = Craft { vehicle, inertia, linear, quadratic, righting: drawn, force: typical.force };
        let munk = (inertia[2] - inertia[0]) * craft.speed()[0].powi(2);
        craft.righting = drawn.max(LEAST_RIGHTING * munk);
        craft
    }

    /// Steady speed at three quarters of the maximum force, m/s and rad/s.
    pub fn speed(&self) -> [f64; 6] {
        std::array::from_fn(|i| {
            let (b, a, f) = (self.linear[i], self.quadratic[i], 0.75 * self.force[i]);
            2.0 * f / (b + (b * b + 4.0 * a * f).sqrt())
        })
    }

    /// Weight minus buoyancy, N.
    pub fn net_weight(&self) -> f64 {
        self.vehicle.net_weight().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_near_the_typical_ones_and_leave_a_munk_moment() {
        for kind in [CraftKind::Large, CraftKind::Small] {
            for seed in 0..20 {
                let craft = Craft::draw(kind, &mut Noise::new(seed, 0));
                craft.vehicle.validate().unwrap();
                assert!((craft.inertia[1] / craft.inertia[0] - 1.0).abs() >= LEAST_MUNK * (1.0 - 1e-12));
                let u = craft.speed()[0];
                let drag = craft.linear[0] * u + craft.quadratic[0] * u * u;
                // the root of the quadratic, in floating point
                assert!((drag / (0.75 * craft.force[0]) - 1.0).abs() < 1e-12);
                assert!((0.3..2.0).contains(&u), "{u}");
            }
        }
    }
}
