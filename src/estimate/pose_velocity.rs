//! Velocities of a run that logs only poses, for starting values and for what candidates of a search remember.
//!
//! ```text
//! (u, v, w) = Rᵀ(φ, θ, ψ) (ẋ, ẏ, ż)            ẋ: slope of the least-squares line through samples within T
//! p = φ̇ − ψ̇ sin θ,   q = θ̇ cos φ + ψ̇ sin φ cos θ,   r = ψ̇ cos φ cos θ − θ̇ sin φ
//! ```
//!
//! T is a second, or longer, up to [`LONGEST`], if noise would make more than a fifth of the
//! changes of the slopes:
//!
//! ```text
//! Σ var ẋ(t) + var ẋ(t+T) < (1/5)² Σ (ẋ(t+T) − ẋ(t))²,   var ẋ = s²/Σ(t − t̄)²
//! s²: variance about the line
//! ```
//!
//! Positions and angles that are not logged count as zero. Source: Fossen, *Handbook of Marine
//! Craft Hydrodynamics and Motion Control* (2011), (2.17), (2.28).

use nalgebra::{Rotation3, Vector3};

use crate::frame::Dof;
use crate::model::Model;
use crate::navigation::unwrap;
use crate::run::{Run, Signal};

/// Time over which a line is drawn, s: short compared with the motion.
pub(super) const SPAN: f64 = 1.0;

/// The same if fixes are noisy: the time that a boat takes to speed up.
const LONGEST: f64 = 8.0;

/// Share of the changes that noise may make: a regression on them is off by the square of it.
const NOISY: f64 = 0.2;

/// Longest times over which lines were drawn, s; 0 if none was.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Spans {
    /// Through positions.
    pub translation: f64,
    /// Through angles.
    pub rotation: f64,
}

impl Spans {
    fn of(self, dof: Dof) -> f64 {
        if dof.is_rotation() { self.rotation } else { self.translation }
    }

    fn longest(self, other: Spans) -> Spans {
        Spans { translation: self.translation.max(other.translation), rotation: self.rotation.max(other.rotation) }
    }
}

/// The runs with a velocity in each modelled degree of freedom of which they log only the position,
/// and the times over which lines were drawn.
pub(super) fn with_velocities(model: &Model, runs: &[Run]) -> (Vec<Run>, Spans) {
    let (with, spans): (Vec<Run>, Vec<Spans>) = runs.iter().map(|run| with_velocity(model, run)).unzip();
    (with, spans.into_iter().fold(Spans::default(), Spans::longest))
}

/// The runs with a velocity in each modelled degree of freedom of which they log only the position.
pub fn velocities_from_poses(model: &Model, runs: &[Run]) -> Vec<Run> {
    with_velocities(model, runs).0
}

fn with_velocity(model: &Model, run: &Run) -> (Run, Spans) {
    let mut with = run.clone();
    let poses = Dof::ALL.map(|dof| {
        let position = run.signal(dof.position()).filter(|s| s.len() > 1)?;
        let smooth = |s: &Signal| Signal::new(s.shared_time().clone(), unwrap(s.values()));
        Some(if dof.is_rotation() { smooth(position) } else { position.clone() })
    });
    let is_asked = |dof: &Dof| run.signal(dof.velocity()).is_none_or(Signal::is_empty) && poses[dof.index()].is_some();
    let span_of = |rotations: bool| {
        let alike = |dof: &Dof| dof.is_rotation() == rotations;
        let asked = model.dofs.iter().any(|dof| alike(dof) && is_asked(dof));
        let logged: Vec<&Signal> =
            Dof::ALL.iter().filter(|d| alike(d)).filter_map(|d| poses[d.index()].as_ref()).collect();
        if asked { span(&logged) } else { 0.0 }
    };
    let spans = Spans { translation: span_of(false), rotation: span_of(true) };
    for dof in &model.dofs {
        let (None, Some(position)) = (run.signal(dof.velocity()).filter(|s| !s.is_empty()), &poses[dof.index()]) else {
            continue;
        };
        let velocity: Vec<f64> = position.time().iter().map(|t| velocity(&poses, *dof, *t, spans)).collect();
        with.signals.insert(dof.velocity().into(), Signal::new(position.shared_time().clone(), velocity));
    }
    (with, spans)
}

/// Time over which lines are drawn so that noise makes no more than [`NOISY`] of the changes of the
/// slopes, of all these signals together: if a vehicle goes north, its east shows only noise. If a
/// vehicle moves steadily, nothing changes; then the slopes themselves must be known ten times
/// better.
fn span(signals: &[&Signal]) -> f64 {
    let mut span = SPAN;
    while span < LONGEST {
        let of = |signal: &&Signal| -> [f64; 3] {
            let sums = signal.time().iter().filter_map(|t| {
                let (line, later) = (line(signal, *t, span), line(signal, t + span, span));
                let noise = line.variance? + later.variance?;
                Some([noise, (later.slope - line.slope).powi(2), line.slope.powi(2)])
            });
            sums.fold([0.0; 3], |sum, of| std::array::from_fn(|k| sum[k] + of[k]))
        };
        let [noise, changes, all] =
            signals.iter().map(of).fold([0.0; 3], |sum, of| std::array::from_fn(|k| sum[k] + of[k]));
        let steady = (0.1 * NOISY).powi(2) * all;
        if all > 0.0 && noise < steady.max(NOISY * NOISY * changes) {
            break;
        }
        span *= 1.5;
    }
    span.min(LONGEST)
}

/// Body velocity at an instant, from lines over these times.
fn velocity(poses: &[Option<Signal>; 6], dof: Dof, t: f64, spans: Spans) -> f64 {
    let angle = |dof: Dof| poses[dof.index()].as_ref().map_or(0.0, |s| s.at(t));
    let rate = |dof: Dof| poses[dof.index()].as_ref().map_or(0.0, |s| line(s, t, spans.of(dof)).slope);
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

/// A line through samples.
struct Line {
    slope: f64,
    /// Variance of the slope; `None` for two samples.
    variance: Option<f64>,
}

/// The line through the samples within `span` seconds about an instant, at least two.
fn line(signal: &Signal, at: f64, span: f64) -> Line {
    let (t, x) = (signal.time(), signal.values());
    // rounded stamps belong to both sides or to none
    let half = 0.5 * span * (1.0 + 1e-9);
    let near = t.partition_point(|s| *s < at).min(t.len() - 1);
    let first = t.partition_point(|s| *s < at - half).min(near.saturating_sub(1));
    let last = (t.partition_point(|s| *s <= at + half).max(near + 2) - 1).min(t.len() - 1);
    let count = (last - first + 1) as f64;
    let mean = |of: &[f64]| of[first..=last].iter().sum::<f64>() / count;
    let (middle, level) = (mean(t), mean(x));
    let square = (first..=last).map(|i| (t[i] - middle).powi(2)).sum::<f64>().max(f64::MIN_POSITIVE);
    let slope = (first..=last).map(|i| (t[i] - middle) * x[i]).sum::<f64>() / square;
    let off: f64 = (first..=last).map(|i| (x[i] - level - slope * (t[i] - middle)).powi(2)).sum();
    Line { slope, variance: (count > 2.0).then(|| off / (count - 2.0) / square) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    /// A circle with a drift angle, starting with a heading of 2 rad: u, v, r are constant and
    /// follow from x, y, psi.
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
        let (with, spans) = with_velocity(&Model::new(&dofs, Coriolis::Tied), &run);
        assert_eq!(spans, Spans { translation: SPAN, rotation: SPAN });
        for (dof, right) in dofs.into_iter().zip([u, v, r]) {
            let told = with.signal(dof.velocity()).unwrap();
            // a line over a second of an arc is flatter by (r·1 s)²/40, one in a thousand of u and
            // of v; at the ends it is one-sided, off by half a second of turning
            let inner = &told.values()[11..told.len() - 11];
            assert!(inner.iter().all(|x| (x - right).abs() < 2e-3), "{dof}: {:?}", &inner[..4]);
            assert!(told.values().iter().all(|x| (x - right).abs() < 0.06), "{dof}");
        }
    }
}
