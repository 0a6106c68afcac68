//! Weight and buoyancy in the form of simulators: a mass, a volume and its centre.
//!
//! ```text
//! B = m g − (W − B),   V = B/(ρ g),   r_b B = r_g W − (moment arms of the model)
//! ```
//!
//! m: dry mass, kg; g: W/m if the weight is known, otherwise 9.81 m/s²; W − B and z_g W − z_b B as
//! identified, otherwise from the data of the vehicle, otherwise 0. Fossen (2021), ch. 4.

use super::body::Body;
use super::coefficients::Coefficients;
use crate::effects::id;
use crate::frame::Dof;
use crate::model::Model;
use crate::vehicle::{Vehicle, Water};

/// Standard acceleration of gravity if the vehicle's weight does not give another, m/s².
const GRAVITY: f64 = 9.81;

/// Weight, buoyancy and their centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Buoyancy {
    /// W, N.
    pub weight: f64,
    /// W − B, N.
    pub net_weight: f64,
    /// Displaced volume, m³.
    pub volume: f64,
    /// Centre of buoyancy in body axes forward-starboard-down, m.
    pub centre: [f64; 3],
}

impl Buoyancy {
    /// B, N.
    pub fn up(&self) -> f64 {
        self.weight - self.net_weight
    }
}

/// Weight and buoyancy under the vehicle's own gravity.
pub(super) fn buoyancy(found: &Coefficients, model: &Model, body: &Body, vehicle: &Vehicle, water: &Water) -> Buoyancy {
    let g = vehicle.weight.map_or(GRAVITY, |w| w / vehicle.mass.unwrap_or(body.mass));
    under(g, found, model, body, vehicle, water)
}

/// The same for a target with its own gravity, m/s²: W − B and the moments are those of the model.
pub(super) fn under(
    g: f64,
    found: &Coefficients,
    model: &Model,
    body: &Body,
    vehicle: &Vehicle,
    water: &Water,
) -> Buoyancy {
    let has = |id: &str| model.terms.iter().any(|t| t.effect.about().id == id);
    let restores = |dof: Dof| id::restoring(dof).is_some_and(|id| has(&id));
    let restoring = &found.restoring;
    let identified = [Dof::Surge, Dof::Sway, Dof::Heave].into_iter().position(restores);
    let net_weight = identified.map_or_else(|| vehicle.net_weight().unwrap_or(0.0), |i| restoring.net_weight[i]);
    let weight = body.mass * g;
    let up = weight - net_weight;
    let righting = [Dof::Roll, Dof::Pitch].into_iter().position(restores);
    // a model with righting moments and without trim_offset floats level
    let upright = righting.is_some() || has(id::TRIM_OFFSET);
    let given = vehicle.cb.unwrap_or(body.cg);
    let arm = |axis: usize, moment: f64| (body.cg[axis] * weight - moment) / up;
    let centre = [
        if upright { arm(0, restoring.trim[0]) } else { given[0] },
        if upright { arm(1, restoring.trim[1]) } else { given[1] },
        righting.map_or(given[2], |i| arm(2, restoring.righting[i])),
    ];
    Buoyancy { weight, net_weight, volume: up / (water.density * g), centre }
}
