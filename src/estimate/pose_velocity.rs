//! Velocities of a run that logs poses alone, for starting values.
//!
//! ```text
//! (u, v, w) = Rᵀ(φ, θ, ψ) (ẋ, ẏ, ż)                 ẋ: slope of the least-squares line through a second of samples
//! p = φ̇ − ψ̇ sin θ,   q = θ̇ cos φ + ψ̇ sin φ cos θ,   r = ψ̇ cos φ cos θ − θ̇ sin φ
//! ```
//!
//! Positions and angles that are not logged count as zero. Source: Fossen, *Handbook of Marine Craft Hydrodynamics and Motion
//! Control* (2011), (2.17), (2.28).

use nalgebra::{Rotation3, Vector3};

use crate::frame::Dof;
use crate::model::Model;
use crate::navigation::unwrap;
use crate::run::{Run, Signal};

/// Time through which a line is drawn, s: long beside the noise, short beside the motion.
pub(super) const SPAN: f64 = 1.0;

/// The runs with a velocity in each modelled degree of freedom of which they log the position alone.
pub(super) fn with_velocities(model: &Model, runs: &[Run]) -> Vec<Run> {
    runs.iter().map(|run| with_velocity(model, run)).collect()
}

fn with_velocity(model: &Model, run: &Run) -> Run {
    let mut with = run.clone();
    let poses = Dof::ALL.map(|dof| {
        let position = run.signal(dof.position()).filter(|s| s.len() > 1)?;
        let smooth = |s: &Signal| Signal::new(s.shared_time().clone(), unwrap(s.values()));
        Some(if dof.is_rotation() { smooth(position) } else { position.clone() })
    });
    for dof in &model.dofs {
        let (None, Some(position)) = (run.signal(dof.velocity()).filter(|s| !s.is_empty()), &poses[dof.index()]) else {
            continue;
        };
        let velocity: Vec<f64> = position.time().iter().map(|t| velocity(&poses, *dof, *t)).collect();
        with.signals.insert(dof.velocity().into(), Signal::new(position.shared_time().clone(), velocity));
    }
    with
}

/// Body velocity at an instant.
fn velocity(poses: &[Option<Signal>; 6], dof: Dof, t: f64) -> f64 {
    let angle = |dof: Dof| poses[dof.index()].as_ref().map_or(0.0, |s| s.at(t));
    let rate = |dof: Dof| poses[dof.index()].as_ref().map_or(0.0, |s| slope(s, t));
    let (phi, theta) = (angle(Dof::Roll), angle(Dof::Pitch));
    match dof {
        Dof::Surge | Dof::Sway | Dof::Heave => {
            let earth = Vector3::new(rate(Dof::Surge), rate(Dof::Sway), rate(Dof::Heave));
            let attitude = Rotation3::from_euler_angles(phi, theta, angle(Dof::Yaw));
            attitude.inverse_transform_vector(&earth)[dof.index()]
        }
        Dof::Roll => rate(Dof::Roll) - rate(Dof::Yaw) * theta.sin(),
        Dof::Pitch => rate(Dof::Pitch) * phi.cos() + rate(Dof::Yaw) * phi.sin() * theta.cos(),
        Dof::Yaw => rate(Dof::Yaw) * phi.cos() * theta.cos() - rate(Dof::Pitch) * phi.sin(),
    }
}

/// Slope at an instant of the line through the samples about it, two at least.
fn slope(signal: &Signal, at: f64) -> f64 {
    let (t, x) = (signal.time(), signal.values());
    // rounded stamps belong to both sides or to none
    let half = 0.5 * SPAN * (1.0 + 1e-9);
    let near = t.partition_point(|s| *s < at).min(t.len() - 1);
    let first = t.partition_point(|s| *s < at - half).min(near.saturating_sub(1));
    let last = (t.partition_point(|s| *s <= at + half).max(near + 2) - 1).min(t.len() - 1);
    let middle = (first..=last).map(|i| t[i]).sum::<f64>() / (last - first + 1) as f64;
    let square: f64 = (first..=last).map(|i| (t[i] - middle).powi(2)).sum();
    (first..=last).map(|i| (t[i] - middle) * x[i]).sum::<f64>() / square.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    /// A circle with a drift angle, begun with a heading of 2 rad: u, v, r are constant, and x, y, psi tell them.
    #[test]
    fn a_circle_has_its_velocities_along_the_body() {
        let (u, v, r, psi0) = (0.5, 0.1, 0.2, 2.0);
        let time: std::sync::Arc<[f64]> = (0..1200).map(|k| 0.05 * f64::from(k)).collect();
        let mut run = Run::default();
        let mut put = |name: &str, f: &dyn Fn(f64) -> f64| {
            run.signals.insert(name.into(), Signal::new(time.clone(), time.iter().map(|t| f(*t)).collect::<Vec<_>>()));
        };
        let psi = |t: f64| psi0 + r * t;
        put("psi", &|t| psi(t) - std::f64::consts::TAU * (psi(t) / std::f64::consts::TAU).round());
        put("x", &|t| (u * psi(t).sin() + v * psi(t).cos()) / r);
        put("y", &|t| (v * psi(t).sin() - u * psi(t).cos()) / r);
        let dofs = [Dof::Surge, Dof::Sway, Dof::Yaw];
        let with = with_velocity(&Model::new(&dofs, Coriolis::Tied), &run);
        for (dof, right) in dofs.into_iter().zip([u, v, r]) {
            let told = with.signal(dof.velocity()).unwrap();
            // a line through a second of an arc is flatter by (r·1 s)²/40, one in a thousand of u and of v; at the ends it is
            // one-sided, half a second of turning off
            let inner = &told.values()[11..told.len() - 11];
            assert!(inner.iter().all(|x| (x - right).abs() < 2e-3), "{dof}: {:?}", &inner[..4]);
            assert!(told.values().iter().all(|x| (x - right).abs() < 0.06), "{dof}");
        }
    }
}
