//! Three vehicles, and others about them.
//!
//! | | |
//! |---|---|
//! | `laurs` | 189 kg, open frame, eight thrusters: surge and yaw after Avila, Donha and Adamowski, Ocean Engineering 60 (2013), Tables 3, 5, 7 and 10; what the paper does not say (sway, heave, roll, pitch, places of the thrusters) is assumed |
//! | `small` | 11.5 kg, six thrusters, no skeg: the Munk moment turns it away from its course; figures near those of Wu, *6-DoF Modelling and Control of a Remotely Operated Vehicle* (2018) |
//! | `heavy` | 13.5 kg, eight thrusters, six degrees of freedom; figures near those of von Benzon et al., J. Mar. Sci. Eng. 10 (2022) 1898, linear drag where they have none assumed |

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use crate::actuation::{Actuation, Losses};
use crate::body::{Body, GRAVITY};
use crate::hydrodynamics::Hydrodynamics;
use crate::plant::Plant;
use crate::random::Random;
use crate::thruster::Thruster;
use crate::water::Current;

/// A vehicle as its owner knows it, and as it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Vehicle {
    /// Name.
    pub name: &'static str,
    /// The plant: all six degrees of freedom, commanded by wrenches.
    pub plant: Plant,
    /// Its thrusters.
    pub thrusters: Vec<Thruster>,
    /// Displaced volume, m³.
    pub volume: f64,
    /// Characteristic length, m.
    pub length: f64,
    /// What the thrusters give at most in ordinary work, N and N·m.
    pub rated: [f64; 6],
}

/// Figures from which a vehicle is made, in the order of ν.
struct Figures {
    name: &'static str,
    mass: f64,
    /// Moments of inertia about the centre of gravity.
    inertia: [f64; 3],
    gravity_centre: [f64; 3],
    net_buoyancy: f64,
    buoyancy_centre: [f64; 3],
    added: [f64; 6],
    /// Added mass off the diagonal.
    coupled: &'static [(usize, usize, f64)],
    linear: [f64; 6],
    quadratic: [f64; 6],
    volume: f64,
    length: f64,
    rated: [f64; 6],
}

const LAURS: Figures = Figures {
    name: "laurs",
    mass: 189.0,
    inertia: [30.0, 40.0, 45.0],
    gravity_centre: [0.0, 0.0, 0.05],
    net_buoyancy: 33.4,
    buoyancy_centre: [0.0, 0.0, -0.03],
    added: [652.9, 401.0, 511.0, 35.0, 70.0, 171.0],
    coupled: &[],
    linear: [82.3, 110.0, 150.0, 32.0, 90.0, 15.5],
    quadratic: [309.07, 500.0, 640.0, 60.0, 140.0, 95.0],
    volume: 0.19,
    length: 0.5749,
    rated: [335.0, 170.0, 200.0, 40.0, 60.0, 110.0],
};

const SMALL: Figures = Figures {
    name: "small",
    mass: 11.5,
    inertia: [0.16, 0.16, 0.25],
    gravity_centre: [0.0, 0.0, 0.02],
    net_buoyancy: 1.5,
    buoyancy_centre: [0.0, 0.0, 0.0],
    added: [5.5, 12.7, 14.57, 0.12, 0.12, 0.15],
    coupled: &[],
    linear: [4.0, 6.2, 5.2, 0.25, 0.25, 0.4],
    quadratic: [18.2, 21.7, 37.0, 1.55, 1.55, 1.55],
    volume: 0.01165,
    length: 0.227,
    rated: [22.0, 18.0, 20.0, 1.6, 1.2, 2.4],
};

const HEAVY: Figures = Figures {
    name: "heavy",
    mass: 13.5,
    inertia: [0.26, 0.23, 0.37],
    gravity_centre: [0.0, 0.0, 0.02],
    net_buoyancy: 2.0,
    buoyancy_centre: [0.0, 0.0, -0.02],
    added: [6.36, 7.12, 18.68, 0.189, 0.135, 0.222],
    coupled: &[(0, 4, -0.12), (1, 3, 0.15)],
    linear: [13.7, 12.0, 33.0, 0.6, 0.8, 0.7],
    quadratic: [100.0, 130.0, 150.0, 1.2, 0.9, 1.5],
    volume: 0.01370,
    length: 0.24,
    rated: [40.0, 40.0, 50.0, 2.4, 2.4, 5.0],
};

impl Vehicle {
    /// The vehicle of this name.
    pub fn named(name: &str) -> Option<Vehicle> {
        match name {
            "laurs" => Some(made(&LAURS, laurs_thrusters())),
            "small" => Some(made(&SMALL, small_thrusters())),
            "heavy" => Some(made(&HEAVY, heavy_thrusters())),
            _ => None,
        }
    }

    /// One of its kind: each added mass and drag coefficient within `spread` (a share) of the typical one.
    #[must_use]
    pub fn drawn(mut self, spread: f64, random: &mut Random) -> Vehicle {
        let mut factors = || Vector6::from_fn(|_, _| 1.0 + spread * random.between(-1.0, 1.0));
        let (added, linear, quadratic) = (factors(), factors(), factors());
        let water = &mut self.plant.water;
        for i in 0..6 {
            for j in 0..6 {
                water.added_mass[(i, j)] *= (added[i] * added[j]).sqrt();
                water.linear[(i, j)] *= linear[i];
                water.quadratic[(i, j)] *= quadratic[i];
            }
        }
        self
    }

    /// Speed at three quarters of the rated force, m/s and rad/s.
    pub fn speed(&self) -> [f64; 6] {
        let water = &self.plant.water;
        std::array::from_fn(|i| {
            let (b, a, f) = (water.linear[(i, i)], water.quadratic[(i, i)], 0.75 * self.rated[i]);
            2.0 * f / (b + (b * b + 4.0 * a * f).sqrt())
        })
    }
}

fn made(figures: &Figures, thrusters: Vec<Thruster>) -> Vehicle {
    let mut added = Matrix6::from_diagonal(&Vector6::from(figures.added));
    for (i, j, value) in figures.coupled {
        (added[(*i, *j)], added[(*j, *i)]) = (*value, *value);
    }
    let gravity_centre = Vector3::from(figures.gravity_centre);
    let arm = crate::attitude::cross_matrix(&gravity_centre);
    let weight = figures.mass * GRAVITY;
    let body = Body {
        mass: figures.mass,
        gravity_centre,
        inertia: Matrix3::from_diagonal(&Vector3::from(figures.inertia)) - figures.mass * arm * arm,
        weight,
        buoyancy: weight + figures.net_buoyancy,
        buoyancy_centre: Vector3::from(figures.buoyancy_centre),
    };
    let mut water = Hydrodynamics::ideal(added);
    water.linear = Matrix6::from_diagonal(&Vector6::from(figures.linear));
    water.quadratic = Matrix6::from_diagonal(&Vector6::from(figures.quadratic));
    let plant = Plant {
        moves: [true; 6],
        body,
        water,
        coriolis: [1.0; 6],
        bias: [0.0; 6],
        actuation: Actuation {
            thrusters: Vec::new(),
            losses: Losses::default(),
            delay: 0.0,
            ripple: (0.0, 0.0),
            weakened: (0.0, f64::INFINITY),
        },
        current: Current::Still,
        waves: Vec::new(),
        earth_force: [0.0; 2],
        tether_spring: 0.0,
        tether_drag: [0.0; 6],
        outside: Vec::new(),
    };
    Vehicle {
        name: figures.name,
        plant,
        thrusters,
        volume: figures.volume,
        length: figures.length,
        rated: figures.rated,
    }
}

fn laurs_thrusters() -> Vec<Thruster> {
    let (sin, cos) = 36.0_f64.to_radians().sin_cos();
    let (forward, reverse) = ((11.53, 4.21), (7.87, 4.68));
    let one = |name, place: [f64; 3], axis: [f64; 3]| {
        let mut thruster = Thruster::new(name, Vector3::from(place), Vector3::from(axis), forward, reverse);
        thruster.max = 5.0;
        thruster
    };
    vec![
        one("T1", [0.45, -0.35, 0.0], [0.0, 0.0, 1.0]),
        one("T2", [-0.5, -0.4, 0.0], [-cos, sin, 0.0]),
        one("T3", [0.45, 0.35, 0.0], [0.0, 0.0, 1.0]),
        one("T4", [-0.45, -0.35, 0.0], [0.0, 0.0, 1.0]),
        one("T5", [0.5, -0.4, 0.0], [cos, sin, 0.0]),
        one("T6", [0.5, 0.4, 0.0], [cos, -sin, 0.0]),
        one("T7", [-0.45, 0.35, 0.0], [0.0, 0.0, 1.0]),
        one("T8", [-0.5, 0.4, 0.0], [-cos, -sin, 0.0]),
    ]
}

/// A small thruster: command −1 to 1, dead band of 6 %.
fn t200(name: &'static str, place: [f64; 3], axis: [f64; 3]) -> Thruster {
    let mut thruster = Thruster::new(name, Vector3::from(place), Vector3::from(axis), (38.0, 13.0), (29.0, 11.0));
    (thruster.deadband, thruster.max) = (0.06, 1.0);
    thruster
}

fn small_thrusters() -> Vec<Thruster> {
    vec![
        t200("T1", [0.14, 0.10, 0.0], [1.0, -1.0, 0.0]),
        t200("T2", [0.14, -0.10, 0.0], [1.0, 1.0, 0.0]),
        t200("T3", [-0.14, 0.10, 0.0], [-1.0, -1.0, 0.0]),
        t200("T4", [-0.14, -0.10, 0.0], [-1.0, 1.0, 0.0]),
        t200("T5", [0.0, 0.11, 0.0], [0.0, 0.0, 1.0]),
        t200("T6", [0.0, -0.11, 0.0], [0.0, 0.0, 1.0]),
    ]
}

fn heavy_thrusters() -> Vec<Thruster> {
    vec![
        t200("T1", [0.156, 0.111, 0.085], [1.0, -1.0, 0.0]),
        t200("T2", [0.156, -0.111, 0.085], [1.0, 1.0, 0.0]),
        t200("T3", [-0.156, 0.111, 0.085], [-1.0, -1.0, 0.0]),
        t200("T4", [-0.156, -0.111, 0.085], [-1.0, 1.0, 0.0]),
        t200("T5", [0.12, 0.218, 0.0], [0.0, 0.0, 1.0]),
        t200("T6", [0.12, -0.218, 0.0], [0.0, 0.0, 1.0]),
        t200("T7", [-0.12, 0.218, 0.0], [0.0, 0.0, 1.0]),
        t200("T8", [-0.12, -0.218, 0.0], [0.0, 0.0, 1.0]),
    ]
}
