//! Body velocities from positions and angles, for a log that has no velocities.
//!
//! ```text
//! (u, v, ·) = Rᵀ(φ, θ, ψ) (Δx, Δy, Δz)/Δt         w ≈ Δz/Δt,   p, q, r ≈ Δφ/Δt, Δθ/Δt, Δψ/Δt
//! ```
//!
//! over the least number of steps that spans a quarter of a second (`SPAN`), at the middle of each
//! span: a slope between neighbouring samples of a fast log is mostly noise. Roll, pitch and depth
//! that are not logged count as zero. Source: Fossen, *Handbook of Marine Craft Hydrodynamics and
//! Motion Control* (2011), (2.17). For checks of a run only, not for a fit.

use nalgebra::{Rotation3, Vector3};

use super::samples::Samples;
use crate::frame::Dof;
use crate::run::Run;

/// Least time over which a slope is taken, s.
const SPAN: f64 = 0.25;

/// Returns the velocity in `dof`: as logged, or else from positions and angles; `None` if neither gives it.
pub fn velocity(run: &Run, dof: Dof) -> Option<Samples> {
    if let Some(signal) = run.signal(dof.velocity()) {
        return Samples::of(signal);
    }
    match dof {
        Dof::Surge | Dof::Sway => horizontal(run, dof),
        Dof::Heave => slope(&Samples::of(run.signal("z")?)?),
        Dof::Roll | Dof::Pitch | Dof::Yaw => slope(&Samples::of_angle(run.signal(dof.position())?)?),
    }
}

/// Returns surge or sway from north, east and the heading.
fn horizontal(run: &Run, dof: Dof) -> Option<Samples> {
    let [north, east] = ["x", "y"].map(|name| run.signal(name).and_then(Samples::of).as_ref().and_then(slope));
    let (north, east) = (north?, east?);
    let angle = |name: &str| run.signal(name).and_then(Samples::of_angle);
    let psi = angle("psi")?;
    let (phi, theta) = (angle("phi"), angle("theta"));
    let down = run.signal("z").and_then(Samples::of).as_ref().and_then(slope);
    let at = |s: &Option<Samples>, t: f64| s.as_ref().map_or(0.0, |s| s.at(t));
    Some(north.map(|t, along| {
        let earth = Vector3::new(along, east.at(t), at(&down, t));
        let attitude = Rotation3::from_euler_angles(at(&phi, t), at(&theta, t), psi.at(t));
        attitude.inverse_transform_vector(&earth)[dof.index()]
    }))
}

/// Returns the slope over successive spans of samples.
fn slope(position: &Samples) -> Option<Samples> {
    let (time, x) = (position.time(), position.values());
    let steps = (SPAN / position.step() * (1.0 - 1e-9)).ceil().max(1.0) as usize;
    let ends: Vec<usize> = (0..time.len()).step_by(steps).collect();
    let middle = ends.windows(2).map(|k| 0.5 * (time[k[0]] + time[k[1]])).collect();
    let slopes = ends.windows(2).map(|k| (x[k[1]] - x[k[0]]) / (time[k[1]] - time[k[0]])).collect();
    Samples::new(middle, slopes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Signal;

    /// A circle with a drift angle: u, v, r are constant and follow from x, y, psi.
    #[test]
    fn a_circle_has_its_constant_velocities() {
        let (u, v, r) = (0.5, 0.1, 0.2);
        let time: std::sync::Arc<[f64]> = (0..1200).map(|k| 0.05 * f64::from(k)).collect();
        let mut run = Run::default();
        let mut put = |name: &str, f: &dyn Fn(f64) -> f64| {
            run.signals.insert(name.into(), Signal::new(time.clone(), time.iter().map(|t| f(*t)).collect::<Vec<_>>()));
        };
        put("psi", &|t| r * t - std::f64::consts::TAU * (r * t / std::f64::consts::TAU).round());
        put("x", &|t| (u * (r * t).sin() + v * (r * t).cos()) / r);
        put("y", &|t| (v * (r * t).sin() - u * (r * t).cos()) / r);
        for (dof, right) in [(Dof::Surge, u), (Dof::Sway, v), (Dof::Yaw, r)] {
            let told = velocity(&run, dof).unwrap();
            // a chord of 0.25 s is shorter than its arc by (r Δt)²/24, one in ten thousand
            assert!(told.values().iter().all(|x| (x - right).abs() < 2e-4), "{dof}: {:?}", &told.values()[..4]);
        }
        assert!(velocity(&run, Dof::Heave).is_none());
    }
}
