//! Equations of motion of the vehicle in the water.
//!
//! ```text
//! M_RB ν̇ + C_RB(ν) ν + M_A ν̇_r + C_A(ν_r) ν_r + D(ν_r) ν_r + g(η) = τ + d
//! ν_r = ν − (RᵀV, 0),   ν̇_r = ν̇ − (RᵀV̇ − ω × RᵀV, 0),   ẋ = R v,   q̇ = ½ T(q) ω
//! ```
//!
//! A degree of freedom that does not move is held by constraint forces: its row and column are
//! removed. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021),
//! ch. 6, 8 and 10.

use nalgebra::{Matrix6, Vector3, Vector6};

use crate::actuation::{Actuation, CHANNELS, Surroundings};
use crate::attitude;
use crate::body::{Body, six};
use crate::hydrodynamics::Hydrodynamics;
use crate::outside::{OUTSIDE_STATES, Outside, Scene};
use crate::water::{Current, Wave};

/// Number of states.
pub const STATES: usize = 13 + 6 + 6 + CHANNELS + OUTSIDE_STATES;

/// Position (3), quaternion (4), ν (6), lags by degree of freedom (6), fluid memories (6), rotor
/// lags, outside effects.
pub type State = [f64; STATES];

/// Index of the first element of each part of a [`State`].
pub mod place {
    use super::{CHANNELS, OUTSIDE_STATES};
    /// The quaternion.
    pub const QUATERNION: usize = 3;
    /// ν.
    pub const NU: usize = 7;
    /// Lags by degree of freedom.
    pub const LAG: usize = 13;
    /// Fluid memories.
    pub const MEMORY: usize = 19;
    /// Rotor lags.
    pub const ROTOR: usize = 25;
    /// Outside effects.
    pub const OUTSIDE: usize = ROTOR + CHANNELS;
    /// One past the last element.
    pub const END: usize = OUTSIDE + OUTSIDE_STATES;
}

/// Everything that determines the motion of the vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// Which degrees of freedom move.
    pub moves: [bool; 6],
    /// The rigid body.
    pub body: Body,
    /// Added mass and drag.
    pub water: Hydrodynamics,
    /// Factor on each row of C(ν)ν: 1 as a rule, 0 if the row is switched off.
    pub coriolis: [f64; 6],
    /// Constant force b, N and N·m, which acts as −b.
    pub bias: [f64; 6],
    /// Thrusters and their losses.
    pub actuation: Actuation,
    /// The current.
    pub current: Current,
    /// Waves.
    pub waves: Vec<Wave>,
    /// A steady force north and east, N.
    pub earth_force: [f64; 2],
    /// Horizontal stiffness of a tether to the point where the run began, N/m.
    pub tether_spring: f64,
    /// Drag of a tether, k z ν|ν|, per metre of depth.
    pub tether_drag: [f64; 6],
    /// Effects outside the catalogue.
    pub outside: Vec<Outside>,
}

/// Inputs of the plant on an interval of integration, as straight lines in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Start, s of the run.
    pub from: f64,
    /// End, s of the run.
    pub to: f64,
    /// Start of the run on the campaign's clock, s.
    pub clock: f64,
    /// Command of each channel at `from`, and its slope.
    pub command: [(f64, f64); CHANNELS],
    /// Random force at `from`, N and N·m, and its slope.
    pub force: [(f64, f64); 6],
    /// V/V_ref at `from`, and its slope.
    pub supply: (f64, f64),
    /// Position to which a tether is fixed; `None` before the run has begun.
    pub anchor: Option<Vector3<f64>>,
}

impl Interval {
    /// An interval without command and random force, at the reference voltage.
    pub fn quiet(from: f64, to: f64) -> Interval {
        Interval {
            from,
            to,
            clock: 0.0,
            command: [(0.0, 0.0); CHANNELS],
            force: [(0.0, 0.0); 6],
            supply: (1.0, 0.0),
            anchor: None,
        }
    }

    /// The middle, s of the run.
    pub fn middle(&self) -> f64 {
        0.5 * (self.from + self.to)
    }
}

/// A plant with its inverted inertia, ready to be integrated.
#[derive(Debug, Clone)]
pub struct Ready<'a> {
    plant: &'a Plant,
    /// Instant from which on it holds, body, and inverse of M_RB + M_A: from the beginning, and
    /// after each step of the mass.
    bodies: Vec<(f64, Body, Matrix6<f64>)>,
    still: bool,
}

/// Rates of the states at an instant, with its kinks and its thrust.
#[derive(Debug, Clone, Copy)]
pub struct Rates {
    /// ẋ.
    pub state: State,
    /// On which side of each kink of the equations the instant lies.
    pub sides: u64,
    /// Wrench of the thrusters, N and N·m.
    pub thrust: Vector6<f64>,
}

impl Plant {
    /// M_RB + M_A.
    pub fn inertia(&self) -> Matrix6<f64> {
        self.body.inertia_matrix() + self.water.added_mass
    }

    /// Inverts the inertia.
    ///
    /// # Panics
    /// If the inertia of the degrees of freedom that move is not positive definite.
    pub fn ready(&self) -> Ready<'_> {
        let entry = |from: f64, body: Body| {
            let matrix = body.inertia_matrix() + self.water.added_mass;
            let inverse = constrained_inverse(&matrix, self.moves);
            (from, body, inverse)
        };
        let mut bodies = vec![entry(f64::NEG_INFINITY, self.body.clone())];
        for effect in &self.outside {
            if let Outside::MassStep { mass, place, from } = effect {
                bodies.push(entry(*from, self.body.with_floating_mass(*mass, *place)));
            }
        }
        Ready { plant: self, bodies, still: self.current == Current::Still }
    }
}

/// Inverse of the matrix of the rows and columns that move; 0 elsewhere.
fn constrained_inverse(matrix: &Matrix6<f64>, moves: [bool; 6]) -> Matrix6<f64> {
    let mut square = *matrix;
    for i in 0..6 {
        for j in 0..6 {
            if !(moves[i] && moves[j]) {
                square[(i, j)] = if i == j { 1.0 } else { 0.0 };
            }
        }
    }
    let mut inverse = square.cholesky().expect("an inertia matrix is positive definite").inverse();
    for i in (0..6).filter(|i| !moves[*i]) {
        inverse[(i, i)] = 0.0;
    }
    inverse
}

/// ν of a state.
pub fn nu_of(state: &State) -> Vector6<f64> {
    Vector6::from_column_slice(&state[place::NU..place::LAG])
}

/// The quaternion of a state.
pub fn quaternion_of(state: &State) -> attitude::Quaternion {
    std::array::from_fn(|k| state[place::QUATERNION + k])
}

impl Ready<'_> {
    /// The plant.
    pub fn plant(&self) -> &Plant {
        self.plant
    }

    /// Rates of the states at the time `t` of the interval.
    pub fn rates(&self, t: f64, x: &State, interval: &Interval) -> Rates {
        let plant = self.plant;
        let since = t - interval.from;
        let now = |(value, slope): (f64, f64)| value + slope * since;
        let clock = interval.clock + interval.middle();
        let (_, body, inverse) = self.bodies.iter().rev().find(|(from, ..)| clock >= *from).unwrap_or(&self.bodies[0]);

        let nu = nu_of(x);
        let (v, omega) = (Vector3::new(nu[0], nu[1], nu[2]), Vector3::new(nu[3], nu[4], nu[5]));
        let q = quaternion_of(x);
        let r = attitude::rotation(q);
        let down = Vector3::new(r[(2, 0)], r[(2, 1)], r[(2, 2)]);

        let (mut relative, mut drift) = (nu, Vector6::zeros());
        if !self.still {
            let (velocity, acceleration) = plant.current.velocity(interval.clock + t, &r, &omega);
            let flow = r.tr_mul(&velocity);
            relative -= six(&flow, &Vector3::zeros());
            drift = six(&(r.tr_mul(&acceleration) - omega.cross(&flow)), &Vector3::zeros());
        }

        let at = Surroundings {
            time: t,
            middle: interval.middle(),
            clock: interval.clock,
            supply: now(interval.supply),
            nu,
            relative,
        };
        let lags = (std::array::from_fn(|k| x[place::LAG + k]), std::array::from_fn(|k| x[place::ROTOR + k]));
        let (thrust, lag_rates, mut sides) = plant.actuation.wrench(&interval.command.map(now), &lags, &at);

        let drag = plant.water.drag(&relative);
        let mut coriolis = body.coriolis(&v, &omega) + Hydrodynamics::coriolis(&plant.water.added_mass, &relative);
        let mut state = [0.0; STATES];
        let mut force = thrust - drag + body.restoring(&down) + plant.water.added_mass * drift;
        for i in 0..6 {
            coriolis[i] *= plant.coriolis[i];
            force[i] += now(interval.force[i]) - plant.bias[i] - coriolis[i];
            sides = sides << 1 | u64::from(relative[i] > 0.0);
            let (strength, time) = plant.water.memory[i];
            if strength != 0.0 {
                let memory = x[place::MEMORY + i];
                force[i] -= strength * memory;
                state[place::MEMORY + i] = (relative[i] - memory) / time;
            }
            if plant.tether_drag[i] != 0.0 {
                force[i] -= plant.tether_drag[i] * x[2] * relative[i] * relative[i].abs();
            }
            state[place::LAG + i] = lag_rates.0[i];
        }
        for wave in &plant.waves {
            force[wave.dof] += wave.force(t);
        }
        let velocity = r * v;
        let position = Vector3::new(x[0], x[1], x[2]);
        let anchor = interval.anchor.unwrap_or(position);
        let mut pull = plant.tether_spring * (anchor - position);
        pull.z = 0.0;
        pull += Vector3::new(plant.earth_force[0], plant.earth_force[1], 0.0);
        let mut first = place::OUTSIDE;
        for effect in &plant.outside {
            let scene = Scene { relative: &relative, nu: &nu, position, velocity, anchor, drag: &drag, clock };
            let own = first..first + effect.states();
            let (in_body, in_earth) = effect.force(&scene, &x[own.clone()], &mut state[own]);
            force += in_body;
            pull += in_earth;
            first += effect.states();
        }
        force += six(&r.tr_mul(&pull), &Vector3::zeros());

        let acceleration = inverse * force;
        let turning = attitude::rate(q, &omega);
        for k in 0..3 {
            state[k] = velocity[k];
        }
        state[place::QUATERNION..place::NU].copy_from_slice(&turning);
        state[place::NU..place::LAG].copy_from_slice(acceleration.as_slice());
        state[place::ROTOR..place::OUTSIDE].copy_from_slice(&lag_rates.1);
        Rates { state, sides, thrust }
    }
}
