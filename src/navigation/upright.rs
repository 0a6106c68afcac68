//! Attitude of runs near the vertical: the logged angles as a unit quaternion.
//!
//! ```text
//! q = q(φ, θ, ψ)      with the sign that continues the previous sample
//! δ = 2 sign(e₀) (e₁, e₂, e₃),   e = q_simulated ⊗ q*_logged  turn from logged to simulated, earth axes, rad
//! ```
//!
//! At θ = ±90° only one sum of φ and ψ is determined, and near it the noise of an attitude causes
//! arbitrary errors of either. There attitudes are compared by the turn between them,
//! |δ| = 2 sin(angle/2). For a level vehicle the turn is (Δφ, Δθ, Δψ) in the vehicle's heading.
//! Markley and Crassidis, *Fundamentals of Spacecraft Attitude Determination and Control* (2014), 2.9.

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::Quaternion;

use super::{quaternion, unwrap};
use crate::run::{Run, Signal};

/// |sin θ| from which on a run counts as near the vertical: that of 60°, where the noise of φ and ψ
/// has doubled.
pub const STEEP: f64 = 0.866;

/// Channels of the logged attitude quaternion. No name that a formula can read contains a blank.
pub const LOGGED: [&str; 4] = ["attitude w", "attitude x", "attitude y", "attitude z"];

/// Channels of the turn from the logged to the simulated attitude, about north, east and down, rad;
/// the logged turn is 0.
pub const TURNS: [&str; 3] = ["turn north", "turn east", "turn down"];

/// Names of the angles in a log.
const ANGLES: [&str; 3] = ["phi", "theta", "psi"];

/// The angle whose instrument determines the noise of a turn: tilt about the horizontal axes,
/// heading about the vertical.
pub fn instrument_of(channel: &str) -> Option<&'static str> {
    TURNS.iter().position(|turn| *turn == channel).map(|k| ANGLES[k])
}

/// Whether a run comes near the vertical.
pub fn is_steep(run: &Run) -> bool {
    run.signal("theta").is_some_and(|s| s.values().iter().any(|theta| theta.sin().abs() > STEEP))
}

/// Whether a run logs all three angles at the same instants.
pub fn is_whole(run: &Run) -> bool {
    let [phi, theta, psi] = ANGLES.map(|name| run.signal(name).map(Signal::time));
    phi.is_some_and(|time| !time.is_empty()) && phi == theta && theta == psi
}

/// The run with its attitude as a quaternion and with turns of 0; unchanged if it does not log a
/// whole attitude.
pub fn with_quaternion(run: &Run) -> Run {
    let mut run = run.clone();
    if !is_whole(&run) {
        return run;
    }
    let [phi, theta, psi] = ANGLES.map(|name| run.signals[name].clone());
    let mut before = Quaternion::identity();
    let mut components: [Vec<f64>; 4] = Default::default();
    for ((phi, theta), psi) in phi.values().iter().zip(theta.values()).zip(psi.values()) {
        let q = quaternion(*phi, *theta, *psi).into_inner();
        before = if q.dot(&before) < 0.0 { -q } else { q };
        for (column, value) in components.iter_mut().zip([before.w, before.i, before.j, before.k]) {
            column.push(value);
        }
    }
    let time: &Arc<[f64]> = phi.shared_time();
    for (name, values) in LOGGED.iter().zip(components) {
        run.signals.insert((*name).to_string(), Signal::new(time.clone(), values));
    }
    for name in TURNS {
        run.signals.insert(name.to_string(), Signal::new(time.clone(), vec![0.0; time.len()]));
    }
    run
}

/// Continues θ beyond ±90° for a vehicle that only pitches and passes the vertical: instruments
/// then report half a turn of roll and of heading, seen as a roll of more than 90°. Nothing changes
/// if roll and pitch have different time stamps.
pub fn unfold(run: &mut Run) {
    let [phi, theta, psi] = ANGLES.map(|name| run.signals.get(name).cloned());
    let (Some(phi), Some(theta)) = (phi, theta) else { return };
    if phi.time() != theta.time() || phi.values().iter().all(|phi| phi.cos() >= 0.0) {
        return;
    }
    let back: Vec<bool> = phi.values().iter().map(|phi| phi.cos() < 0.0).collect();
    let turned = |signal: &Signal, over: &dyn Fn(f64) -> f64| {
        let values: Vec<f64> =
            signal.values().iter().zip(&back).map(|(x, back)| if *back { over(*x) } else { *x }).collect();
        Signal::new(signal.shared_time().clone(), unwrap(&values))
    };
    run.signals.insert("phi".into(), turned(&phi, &|x| x - PI));
    run.signals.insert("theta".into(), turned(&theta, &|x| PI - x));
    if let Some(psi) = psi.filter(|psi| psi.time() == theta.time()) {
        run.signals.insert("psi".into(), turned(&psi, &|x| x - PI));
    }
}

/// Noise of the turn about each earth axis, rad, from third differences of samples of the
/// quaternion, which remove any smooth motion: Δ³q ⊗ q* is half of the turn caused by noise.
pub fn third_differences(samples: &[Quaternion<f64>], axis: usize) -> impl Iterator<Item = f64> + '_ {
    samples.windows(4).map(move |w| {
        let third = (w[3] - w[2] * 3.0 + w[1] * 3.0 - w[0]) * w[1].conjugate();
        2.0 * third.imag()[axis]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(angles: &[[f64; 3]]) -> Run {
        let time: Arc<[f64]> = (0..angles.len()).map(|k| 0.1 * k as f64).collect();
        let mut run = Run::default();
        for (k, name) in ANGLES.iter().enumerate() {
            let values: Vec<f64> = angles.iter().map(|a| a[k]).collect();
            run.signals.insert((*name).to_string(), Signal::new(time.clone(), values));
        }
        run
    }

    /// At the vertical φ and ψ jump by 180°; the quaternion continues with the same small turn.
    #[test]
    fn exact_quaternion_goes_on_through_the_vertical() {
        let angles: Vec<[f64; 3]> = (80..=100)
            .step_by(5)
            .map(|degrees| {
                let theta = f64::from(degrees).to_radians();
                let over = PI;
                if degrees <= 90 { [0.0, theta, 0.3] } else { [over, over - theta, 0.3 - over] }
            })
            .collect();
        let run = with_quaternion(&run(&angles));
        let q = |k: usize| LOGGED.map(|name| run.signals[name].values()[k]);
        let step = (2.5f64.to_radians()).cos();
        for k in 1..angles.len() {
            let dot: f64 = q(k).iter().zip(q(k - 1)).map(|(a, b)| a * b).sum();
            assert!((dot - step).abs() < 1e-12, "{k}: {dot}");
        }
        assert_eq!(run.signals[TURNS[1]].values(), [0.0; 5]);
    }

    /// A loop of 360° in pitch as instruments report it: θ continues.
    #[test]
    fn exact_loop_of_a_vehicle_that_pitches_alone() {
        let told = |degrees: i32| {
            let q = quaternion(0.0, f64::from(degrees).to_radians(), 0.3);
            super::super::euler_angles(&q)
        };
        let mut run = run(&(0..=360).step_by(20).map(told).collect::<Vec<_>>());
        unfold(&mut run);
        for (k, theta) in run.signals["theta"].values().iter().enumerate() {
            assert!((theta - (20.0 * k as f64).to_radians()).abs() < 1e-9, "{k}: {theta}");
        }
        assert!(run.signals["psi"].values().iter().all(|psi| (psi - 0.3).abs() < 1e-9));
    }

    #[test]
    fn what_is_steep_and_what_is_whole() {
        let steep = run(&[[0.0, 1.1, 0.0]]);
        assert!(is_steep(&steep) && is_whole(&steep));
        assert!(!is_steep(&run(&[[0.0, 1.0, 0.0]])));
        let mut part = steep.clone();
        part.signals.insert("psi".into(), Signal::new(vec![0.05].into(), vec![0.0]));
        assert!(!is_whole(&part) && with_quaternion(&part).signals.len() == 3);
        assert_eq!(instrument_of("turn down"), Some("psi"));
        assert_eq!(instrument_of("psi"), None);
    }

    /// White turns of 0.01 rad standard deviation: third differences have √20 times that; 4000 of
    /// them determine it to 5 %.
    #[test]
    fn law_third_differences_show_the_noise_of_the_turn() {
        let mut noise = crate::noise::Noise::new(5, 1);
        let samples: Vec<Quaternion<f64>> = (0..4000)
            .map(|k| {
                let turn = nalgebra::Vector3::from_fn(|_, _| 0.01 * noise.normal());
                (nalgebra::UnitQuaternion::new(turn) * quaternion(0.0, 0.002 * f64::from(k), 0.4)).into_inner()
            })
            .collect();
        for axis in 0..3 {
            let squares: f64 = third_differences(&samples, axis).map(|x| x * x).sum();
            let found = (squares / (samples.len() - 3) as f64 / 20.0).sqrt();
            assert!((found / 0.01 - 1.0).abs() < 0.05, "{axis}: {found}");
        }
    }
}
