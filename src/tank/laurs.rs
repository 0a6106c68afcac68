//! LAURS, the paper's vehicle, as the true model of the tank.
//!
//! ```text
//! surge   drag of Table 3, mass, coupling and bias of each run from Table 5, W − B = −33.4 N, η of eq. (17)
//! yaw     drag of Table 7 by direction, inertia and bias of each run from Tables 9 and 10, k_uv of Table 10
//! pitch   I_q q̇ = −K sin θ − d_q q − c u|u| + e u + …          nose down at speed, as in Fig. 9b
//! ```
//!
//! Source: Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94. Values that the paper
//! does not give are marked "assumed".

use std::sync::Arc;

use super::TankError;
use crate::effects::{About, Coriolis, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::model::Model;
use crate::symbolic::Expr;
use crate::units::Dimension;
use crate::vehicle::Vehicle;

/// Degrees of freedom of the true model: the paper gives nothing about roll.
pub(super) const DOFS: [Dof; 5] = [Dof::Surge, Dof::Sway, Dof::Heave, Dof::Pitch, Dof::Yaw];

/// Slope, s/m, and intercept of equation (17).
pub(super) const ADVANCE: (f64, f64) = (-0.1946, 0.9967);
/// η_inter in surge (T5 and T6), sway and heave, Table 2. The paper then sets 1 for its surge runs;
/// the true model has the measured value. That of heave was measured downwards only; upwards it is
/// assumed to be the same.
pub(super) const INTERACTION: [(Dof, f64); 3] = [(Dof::Surge, 0.97), (Dof::Sway, 0.90), (Dof::Heave, 0.93)];
/// Weight minus buoyancy, N.
pub(super) const NET_WEIGHT: f64 = -33.4;
/// Drag in surge under own thrust, Table 3: quadratic, kg/m, and linear, kg/s.
pub(super) const PROPELLED: (f64, f64) = (309.07, 82.30);
/// Righting moment, N·m; assumed: with 200 kg·m² it gives a period of 5.6 s.
const RIGHTING: f64 = 250.0;
/// Moments of the speed that hold −12° at 0.81 m/s and −2.63° at 0.47 m/s against the righting
/// moment: solution of the two equations sin 12° = c u² − e u for c (s²/m²) and e (s/m).
const NOSE_DOWN: (f64, f64) = (0.467, 0.122);
/// Virtual mass in sway if no run determines it, kg; assumed.
pub(super) const SWAY_MASS: f64 = 590.0;

/// The vehicle data of its owners; W − B is theirs, W itself is 189 kg at standard gravity.
pub(super) fn vehicle() -> Vehicle {
    Vehicle {
        name: "LAURS".to_string(),
        mass: Some(189.0),
        volume: Some(0.19),
        weight: Some(1854.1),
        buoyancy: Some(1854.1 - NET_WEIGHT),
        length: Some(0.5749),
        ..Vehicle::default()
    }
}

/// Pitch at a steady speed, rad.
pub(super) fn steady_pitch(speed: f64) -> f64 {
    let (c, e) = NOSE_DOWN;
    -(c * speed * speed - e * speed).asin()
}

/// Command that holds a steady speed ahead, N.
pub(super) fn steady_command(speed: f64) -> f64 {
    let (quadratic, linear) = PROPELLED;
    let (slope, intercept) = ADVANCE;
    let drag = quadratic * speed * speed + linear * speed + NET_WEIGHT * steady_pitch(speed).sin();
    drag / (INTERACTION[0].1 * (slope * speed + intercept))
}

/// Parameters that differ from run to run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Figures {
    /// m_u, kg.
    pub(super) surge_mass: f64,
    /// X_q̇ in the paper's sign, kg·m.
    pub(super) coupling: f64,
    /// b in surge, N.
    pub(super) surge_bias: f64,
    /// I_r, kg·m².
    pub(super) yaw_inertia: f64,
    /// b in yaw, N·m.
    pub(super) yaw_bias: f64,
    /// m_v, kg.
    pub(super) sway_mass: f64,
}

impl Default for Figures {
    /// The reference model (24) in surge and the mean of Table 9 in yaw, without bias.
    fn default() -> Figures {
        Figures {
            surge_mass: 841.93,
            coupling: -280.77,
            surge_bias: 0.0,
            yaw_inertia: 216.17,
            yaw_bias: 0.0,
            sway_mass: SWAY_MASS,
        }
    }
}

/// The true model of a run.
pub(super) fn truth(figures: &Figures) -> Result<Model, TankError> {
    let effects = [
        "inertia",
        "linear_drag",
        "quadratic_drag",
        "coriolis_surge",
        "coriolis_sway",
        "coriolis_yaw",
        "restoring_surge",
        "restoring_heave",
        "restoring_pitch",
        "bias@surge",
        "bias@yaw",
        "added_mass_coupling@surge:pitch",
        "cross_drag@pitch:surge",
        "linear_cross_damping@pitch:surge",
    ];
    let mut model = Model::with_effects(&DOFS, Coriolis::Free, &effects)?;
    for dof in DOFS {
        model.add(Arc::new(AdvanceLoss), Place::at(dof))?;
    }
    model.add(Arc::new(TurnDrag), Place::at(Dof::Yaw))?;
    let f = figures;
    let (c, e) = NOSE_DOWN;
    let values = [
        ("inertia@surge", f.surge_mass),
        ("inertia@sway", f.sway_mass),
        // heave and pitch: assumed
        ("inertia@heave", 700.0),
        ("inertia@pitch", 200.0),
        ("inertia@yaw", f.yaw_inertia),
        ("linear_drag@surge", PROPELLED.1),
        // sway, heave and pitch: assumed
        ("linear_drag@sway", 110.0),
        ("linear_drag@heave", 150.0),
        ("linear_drag@pitch", 90.0),
        ("linear_drag@yaw", 12.78),
        ("quadratic_drag@surge", PROPELLED.0),
        ("quadratic_drag@sway", 500.0),
        ("quadratic_drag@heave", 640.0),
        ("quadratic_drag@pitch", 140.0),
        ("quadratic_drag@yaw", 95.32),
        // the three Coriolis terms do no net work: k_uv = m_v − m_u
        ("coriolis_surge", f.sway_mass),
        ("coriolis_sway", f.surge_mass),
        ("coriolis_yaw", f.sway_mass - f.surge_mass),
        ("restoring_heave", NET_WEIGHT),
        ("restoring_pitch", RIGHTING),
        ("bias@surge", f.surge_bias),
        ("bias@yaw", f.yaw_bias),
        ("added_mass_coupling@surge:pitch", f.coupling),
        ("cross_drag@pitch:surge", c * RIGHTING),
        ("linear_cross_damping@pitch:surge", -e * RIGHTING),
    ];
    for (name, value) in values {
        model.set(name, value);
    }
    for (dof, eta) in INTERACTION {
        let name = format!("thrust_interaction_loss@{dof}");
        model.add_named(&name)?;
        model.set(&name, eta);
    }
    Ok(model)
}

/// Equation (17): loss of thrust with the speed of the vehicle, in yaw with its speed ahead.
#[derive(Debug)]
pub(super) struct AdvanceLoss;

impl Effect for AdvanceLoss {
    fn about(&self) -> About<'_> {
        About {
            id: "advance_loss_17",
            family: Family::Actuator,
            scope: Scope::Each(&Dof::ALL),
            formula: "τᵢ → (0.9967 − 0.1946 |v_a|) τᵢ",
            meaning: "Thrust lost with the speed of advance.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), eq. 17",
            shown_by: "load cells and a moving vehicle",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        Vec::new()
    }

    fn actuate<'g>(&self, at: &Instant<'g>, place: Place, _: &[Expr<'g>], _: &[Expr<'g>], tau: &mut Six<'g>) {
        let dof = place.here();
        let advance = if dof.is_rotation() { at.nu[0] } else { at.nu[dof.index()] };
        let (slope, intercept) = ADVANCE;
        let efficiency = advance.abs() * at.unit(Dimension::VELOCITY.power(-1), slope) + intercept;
        tau[dof.index()] = tau[dof.index()] * efficiency;
    }
}

/// Table 7: different drag anticlockwise and clockwise.
#[derive(Debug)]
struct TurnDrag;

/// Difference anticlockwise minus clockwise: linear, kg·m²/s, and quadratic, kg·m².
const ANTICLOCKWISE: (f64, f64) = (18.21 - 12.78, 94.72 - 95.32);

impl Effect for TurnDrag {
    fn about(&self) -> About<'_> {
        About {
            id: "turn_drag_7",
            family: Family::Body,
            scope: Scope::Each(&[Dof::Yaw]),
            formula: "−(d₁ + d₂ |r|) r   where r < 0",
            meaning: "Another drag anticlockwise than clockwise.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), Table 7",
            shown_by: "turns both ways",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        Vec::new()
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, _: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let r = at.nu_r[Dof::Yaw.index()];
        let (linear, quadratic) = ANTICLOCKWISE;
        let drag = at.unit(Dimension::new(1, 2, -1), linear) + r.abs() * at.unit(Dimension::new(1, 2, 0), quadratic);
        wrench[Dof::Yaw.index()] -= drag * r * (-r).step();
    }
}
