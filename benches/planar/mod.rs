//! The planar vehicle of the benches, in surge, sway and yaw, with figures near those of the paper.
//!
//! ```text
//! m_u u̇ = (1 − k_u|u|) τ_u + m_v v r − (d_u + d_uu|u|) u
//! m_v v̇ = (1 − k_v|v|) τ_v − m_u u r − (d_v + d_vv|v|) v
//! I_r ṙ = (1 − k_r|r|) τ_r − (m_v − m_u) u v − (d_r + d_rr|r|) r
//! ```

use std::sync::Arc;

use hydrosysid::effects::Coriolis;
use hydrosysid::frame::Dof;
use hydrosysid::model::Model;
use hydrosysid::run::{Run, Signal};

/// Virtual mass, linear and quadratic drag and advance loss of each degree of freedom, SI.
pub const FIGURES: [(&str, [f64; 4]); 3] =
    [("surge", [842.0, 82.0, 309.0, 0.12]), ("sway", [1100.0, 120.0, 450.0, 0.08]), ("yaw", [186.0, 12.8, 95.3, 0.05])];

/// Offset, amplitude and angular frequency of the three commands, N and N·m.
pub const COMMANDS: [(&str, [f64; 3]); 3] =
    [("tau_u", [180.0, 140.0, 0.22]), ("tau_v", [0.0, 60.0, 0.31]), ("tau_r", [0.0, 40.0, 0.47])];

/// The model with its values; `losses` adds the advance loss.
pub fn model(losses: bool) -> Model {
    let mut effects =
        vec!["inertia", "linear_drag", "quadratic_drag", "coriolis_surge", "coriolis_sway", "coriolis_yaw"];
    if losses {
        effects.push("thrust_advance_loss");
    }
    let mut model = Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Tied, &effects).expect("planar");
    for (dof, [m, linear, quadratic, loss]) in FIGURES {
        model.set(&format!("inertia@{dof}"), m);
        model.set(&format!("linear_drag@{dof}"), linear);
        model.set(&format!("quadratic_drag@{dof}"), quadratic);
        if losses {
            model.set(&format!("thrust_advance_loss@{dof}"), loss);
        }
    }
    model
}

/// A run of `n` samples, `step` seconds apart, in which every channel varies; `phase` makes runs
/// differ. The velocities are not those of the model, which does not matter for the time of columns
/// and integrators.
pub fn run(n: usize, step: f64, phase: f64) -> Run {
    let time: Arc<[f64]> = (0..n).map(|k| step * k as f64).collect();
    let mut run = Run { name: format!("run {phase}"), ..Run::default() };
    let velocities = [("u", [0.5, 0.3, 0.21]), ("v", [0.0, 0.2, 0.37]), ("r", [0.0, 0.3, 0.53])];
    for (name, [offset, amplitude, rate]) in velocities.into_iter().chain(COMMANDS) {
        let values: Vec<f64> = time.iter().map(|t| offset + amplitude * (rate * t + phase).sin()).collect();
        run.signals.insert(name.into(), Signal::new(time.clone(), values));
    }
    run
}
