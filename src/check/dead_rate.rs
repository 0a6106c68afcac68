//! Rates that stay near zero while their angle turns: the gyro or its column is dead.
//!
//! ```text
//! over windows with |Δα| > max(8 √2 σ_α, 0.02 rad):   dead where |∫(own rate)| < 0.01 |Δα| in 9 of 10
//! ```
//!
//! A rate in a wrong unit still follows the angle, with at least 1/57 of the right size; a dead
//! channel does not. The kinematics are those of [`attitude`](super::attitude).

use super::attitude::{WINDOW, kinematics, level_windows};
use super::codes;
use super::report::Found;
use super::samples::{Samples, windows};
use crate::frame::Dof;
use crate::log::number::short;
use crate::run::Run;

/// Least number of windows in which the angle turns.
const FEWEST: usize = 10;
/// Least change of an angle over a window that counts as a turn: rad, and standard deviations of
/// its difference.
const TURN: (f64, f64) = (0.02, 8.0);
/// Share of the turn below which the integral of the rate counts as silent.
const SILENT: f64 = 0.01;

/// Finds dead rates of roll, pitch and yaw.
pub fn judge(run: &Run) -> Vec<Found> {
    [Dof::Roll, Dof::Pitch, Dof::Yaw].into_iter().filter_map(|dof| dead(run, dof)).collect()
}

fn dead(run: &Run, dof: Dof) -> Option<Found> {
    let angle = Samples::of_angle(run.signal(dof.position())?)?;
    let logged = run.signal(dof.velocity())?;
    let rate = Samples::new(logged.time().to_vec(), logged.values().to_vec())?;
    let (own, others) = kinematics(run, dof, &rate);
    let level = level_windows(run);
    let width = WINDOW.max(2.0 * angle.step().max(rate.step()));
    let least = TURN.0.max(TURN.1 * 2f64.sqrt() * angle.noise());
    let turn = |(a, b): &(f64, f64)| (angle.at(*b) - angle.at(*a)).abs();
    // windows in which the other two rates turn the angle are left out
    let turns = |w: &(f64, f64)| turn(w) > least && others.integral(w.0, w.1).abs() < 0.3 * turn(w);
    let turning: Vec<_> = windows(&[&angle, &rate], width, 0.0).into_iter().filter(&level).filter(turns).collect();
    let silent = turning.iter().filter(|w| own.integral(w.0, w.1).abs() < SILENT * turn(w)).count();
    if turning.len() < FEWEST || 10 * silent < 9 * turning.len() {
        return None;
    }
    let (r, alpha) = (dof.velocity(), dof.position());
    let most = rate.values().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let total: f64 = turning.iter().map(turn).sum();
    let text = format!(
        "{r} never exceeds {} rad/s while {alpha} turns by {} rad in all: the gyro or its column is dead; leave {r} \
         out, {alpha} shows the rotation",
        short(most, 2),
        short(total, 3)
    );
    Some(Found::new(&codes::DEAD_RATE, &[r, alpha], text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;
    use crate::run::Signal;

    /// A heading that oscillates, with noise, and a gyro that shows `factor` times its rate, with noise
    /// of `sigma` rad/s.
    fn swing(factor: f64, sigma: f64, psi_scale: f64) -> Run {
        let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        let mut noise = Noise::new(4, 1);
        let psi: Vec<f64> = time.iter().map(|t| psi_scale * ((0.6 * t).sin() + 0.005 * noise.normal())).collect();
        let r: Vec<f64> = time.iter().map(|t| factor * 0.6 * (0.6 * t).cos() + sigma * noise.normal()).collect();
        let mut run = Run::default();
        run.signals.insert("psi".into(), Signal::new(time.clone(), psi));
        run.signals.insert("r".into(), Signal::new(time, r));
        run
    }

    #[test]
    fn a_dead_gyro_is_told_and_one_in_another_unit_is_not() {
        for sigma in [0.0, 1e-7, 1e-4] {
            let found = judge(&swing(0.0, sigma, 1.0));
            assert_eq!((found.len(), found[0].code.code), (1, codes::DEAD_RATE.code), "{sigma}");
        }
        for factor in [1.0, -1.0, 57.3, 0.05] {
            assert!(judge(&swing(factor, 0.003, 1.0)).is_empty(), "{factor}");
        }
        // a heading in degrees beside a sound gyro
        assert!(judge(&swing(1.0, 0.003, 57.3)).is_empty());
        // nothing turns, so the gyro cannot be judged
        assert!(judge(&swing(0.0, 1e-7, 0.0)).is_empty());
    }
}
