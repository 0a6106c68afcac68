//! Pitch at constant speed from the balance of moments, for vehicles that do not log it.
//!
//! ```text
//! (z_g W − z_b B) sin θ + (x_g W − x_b B) cos θ = M_T − z_D τ_u
//! ```
//!
//! M_T: moment of the thrusters about the body origin, N·m. z_D: height at which the drag acts, m;
//! the drag force at constant speed is the thrust τ_u, N, if the small gravity term of (19) is
//! neglected. W, B: weight and buoyancy, N, which act at (x_g, z_g) and (x_b, z_b), m. Avila et al.
//! (2013), text with eq. 19; Fossen (2021), ch. 4.

use super::options::SteadyStage;
use crate::frame::Dof;
use crate::run::{Run, Signal};
use crate::vehicle::Vehicle;

/// The run with `theta` from the balance of moments, at the time stamps of τ_u; the error names the
/// missing input.
pub(super) fn of_moments(run: &Run, vehicle: &Vehicle, options: &SteadyStage) -> Result<Run, String> {
    let lacks = |what: &str| format!("run `{}`: pitch = \"moments\" needs {what}", run.name);
    let figures = (vehicle.weight, vehicle.buoyancy, vehicle.cg, vehicle.cb);
    let (Some(weight), Some(buoyancy), Some(cg), Some(cb)) = figures else {
        return Err(lacks("weight, buoyancy, cg and cb in [vehicle]"));
    };
    let (Some(thrust), Some(moment)) = (run.signal(Dof::Surge.force()), run.signal(Dof::Pitch.force())) else {
        return Err(lacks("tau_q: the moment of the thrusters, logged or from [[thruster]] tables"));
    };
    let (sine, cosine) = (cg[2] * weight - cb[2] * buoyancy, cg[0] * weight - cb[0] * buoyancy);
    let size = sine.hypot(cosine);
    if sine <= 0.0 {
        return Err(lacks("a righting moment: z_g W − z_b B above 0"));
    }
    let angle = |(t, tau): (&f64, &f64)| {
        let wanted = (moment.at(*t) - options.drag_height * tau) / size;
        (wanted.abs() <= 1.0).then(|| wanted.asin() - cosine.atan2(sine))
    };
    let angles: Option<Vec<f64>> = thrust.time().iter().zip(thrust.values()).map(angle).collect();
    let Some(angles) = angles else {
        return Err(lacks("a righting moment large enough to balance the thrust: otherwise the vehicle would capsize"));
    };
    let mut pitched = run.clone();
    pitched.signals.insert(Dof::Pitch.position().into(), Signal::new(thrust.shared_time().clone(), angles));
    Ok(pitched)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(moment: f64) -> Run {
        let mut run = Run::default();
        for (name, value) in [("tau_u", 200.0), ("tau_q", moment)] {
            run.signals.insert(name.into(), Signal::new(vec![0.0, 1.0].into(), vec![value; 2]));
        }
        run
    }

    /// Centre of gravity 13 cm below the centre of buoyancy: a righting moment of 250 N·m at 90°.
    fn vehicle() -> Vehicle {
        Vehicle {
            weight: Some(1854.1),
            buoyancy: Some(1887.5),
            cg: Some([0.0, 0.0, 250.0 / 1854.1]),
            cb: Some([0.0; 3]),
            ..Vehicle::default()
        }
    }

    #[test]
    fn exact_pitch_holds_the_moments() {
        let options = SteadyStage { drag_height: 0.1, ..SteadyStage::default() };
        // thrusters above the origin by 0.15 m push the nose down: −30 N·m, and drag 0.1 m below it
        // −20 N·m more
        let pitched = of_moments(&run(-30.0), &vehicle(), &options).unwrap();
        let theta = pitched.signal("theta").unwrap().values()[0];
        assert!((theta.sin() + 50.0 / 250.0).abs() < 1e-12, "{theta}");
        let trimmed = Vehicle { cg: Some([0.01, 0.0, 250.0 / 1854.1]), ..vehicle() };
        let theta =
            of_moments(&run(0.0), &trimmed, &SteadyStage::default()).unwrap().signal("theta").unwrap().values()[0];
        assert!((theta.tan() + 18.541 / 250.0).abs() < 1e-12, "weight ahead of buoyancy: nose down, {theta}");
    }

    #[test]
    fn what_is_missing_is_named() {
        let options = SteadyStage::default();
        let without = of_moments(&run(0.0), &Vehicle::default(), &options).unwrap_err();
        assert!(without.contains("cg and cb"), "{without}");
        let over = of_moments(&run(-300.0), &vehicle(), &options).unwrap_err();
        assert!(over.contains("capsize"), "{over}");
        let mut bare = run(0.0);
        bare.signals.remove("tau_q");
        assert!(of_moments(&bare, &vehicle(), &options).unwrap_err().contains("tau_q"));
    }
}
