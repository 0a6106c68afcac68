//! A heading that wraps within a tenth of a radian: radians that were read as degrees.
//!
//! ```text
//! |Δψ| = 2π · π/180 = 0.110 rad where ψ wraps, and ψ never leaves such an interval
//! ```
//!
//! Compared with such a heading the gyro appears 57 times too large or, if the heading wraps often,
//! does not fit at all. The other checks use the heading in the corrected unit.

use std::f64::consts::{PI, TAU};

use super::codes;
use super::report::{FaultKind, Found};
use crate::frame::Dof;
use crate::log::check::statistics::{median, range};
use crate::log::number::short;
use crate::run::{Run, Signal};

/// A full turn in radians that was read as degrees, rad.
const TURN: f64 = TAU * PI / 180.0;

/// Least share of a turn by which a heading jumps where it wraps: it turns on between the two samples.
const JUMP: f64 = 0.9;

/// Least share of the samples in each quarter of a turn: a heading that wraps has been in all of them.
const LEAST: f64 = 0.02;

/// Returns the finding about the unit of the heading, and the run with the heading in the right unit.
pub fn mended(run: &Run) -> Option<(Found, Run)> {
    let psi = Dof::Yaw.position();
    let signal = run.signal(psi)?;
    let values = signal.values();
    let steps = || values.windows(2).map(|w| (w[1] - w[0]).abs());
    let jumps = steps().filter(|step| *step > JUMP * TURN).count();
    let (low, high) = range(values.iter().copied())?;
    let mut quarters = [0_usize; 4];
    values.iter().for_each(|x| quarters[((4.0 * (x - low) / (high - low)) as usize).min(3)] += 1);
    let turns = quarters.iter().all(|count| *count as f64 >= LEAST * values.len() as f64);
    // a held heading a few degrees wide is excluded: its noise jumps at every sample, and a spike
    // leaves the values in between empty
    if jumps == 0 || !turns || high - low > 1.05 * TURN || median(steps())? > 0.2 * TURN {
        return None;
    }
    let text = format!(
        "{psi} jumps by {} rad, {jumps} times, and stays within that range: it wraps in radians but was read as \
         degrees; set columns.{psi}.unit = \"rad\"",
        short(TURN, 3)
    );
    let found = Found::new(&codes::UNIT, &[psi], text).fault(FaultKind::Unit, psi, PI / 180.0);
    let meant: Vec<f64> = values.iter().map(|x| x * 180.0 / PI).collect();
    let mut run = run.clone();
    run.signals.insert(psi.into(), Signal::new(signal.time().into(), meant));
    Some((found, run))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A heading that turns at 0.3 rad/s for 100 s, in radians between 0 and 2π, times a factor.
    fn turning(factor: f64) -> Run {
        let time: std::sync::Arc<[f64]> = (0..1000).map(|k| 0.1 * f64::from(k)).collect();
        let psi: Vec<f64> = time.iter().map(|t| factor * ((0.3 * t) % TAU)).collect();
        let mut run = Run::default();
        run.signals.insert("psi".into(), Signal::new(time, psi));
        run
    }

    #[test]
    fn radians_that_were_read_as_degrees_are_told_and_mended() {
        let (found, run) = mended(&turning(PI / 180.0)).unwrap();
        assert_eq!((found.code.code, found.faults[0].channel.as_str()), ("K111", "psi"));
        let meant = turning(1.0);
        let pairs = run.signals["psi"].values().iter().zip(meant.signals["psi"].values());
        pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{a} {b}"));
    }

    #[test]
    fn a_heading_in_radians_or_held_within_a_few_degrees_is_right() {
        assert!(mended(&turning(1.0)).is_none());
        let mut held = turning(1.0);
        let time: Vec<f64> = held.signals["psi"].time().to_vec();
        let noisy = |k: u32| if k.is_multiple_of(2) { 0.0 } else { 0.105 };
        let spiked = |k: u32| if k == 500 { 0.105 } else { 0.002 * f64::from(k % 3) };
        for heading in [&noisy as &dyn Fn(u32) -> f64, &spiked] {
            let values: Vec<f64> = (0..1000).map(heading).collect();
            held.signals.insert("psi".into(), Signal::new(time.clone().into(), values));
            assert!(mended(&held).is_none());
        }
    }
}
