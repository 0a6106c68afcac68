//! Values that do not change: frozen sensors, commands at their limit.
//!
//! A frozen sensor otherwise changes with nearly every sample and stays at exactly one value for
//! more than 2 s and more than twenty samples.

use super::codes;
use super::rates::number_of;
use super::report::Found;
use crate::log::check::time::usual_step;
use crate::log::check::{hold, is_measured, repeat};
use crate::log::number::short;
use crate::run::{Run, Signal, is_command};

/// Number of samples, and time in s, that a freeze must exceed.
const FREEZE: (usize, f64) = (20, 2.0);

/// Finds frozen sensors and saturated commands.
pub fn check(run: &Run) -> Vec<Found> {
    let mut found = Vec::new();
    for (name, signal) in &run.signals {
        if is_measured(name)
            && let Some((from, seconds)) = frozen(signal)
        {
            let text = format!(
                "{name} stays at exactly {} for {} s from t = {} s, and changes with nearly every sample otherwise: \
                 the sensor froze; leave these cells empty",
                short(signal.values()[signal.time().partition_point(|t| *t < from)], 6),
                short(seconds, 4),
                short(from, 6)
            );
            found.push(Found::new(&codes::FROZEN, &[name], text));
        }
        // a force computed from a command is at its limit where the command is
        if is_command(name)
            && number_of(name).is_some()
            && run.command_of(name).is_none()
            && let Some((first, limit, samples)) = repeat::saturated(signal.values())
        {
            let text = format!(
                "{name} stays at its extreme {} for {samples} samples, first at t = {} s: a limit was reached; if the \
                 log holds what was requested and not what was sent, the force is less than its curve says",
                short(limit, 6),
                short(signal.time()[first], 6)
            );
            found.push(Found::new(&codes::COMMAND_SATURATION, &[name], text));
        }
    }
    found
}

/// Returns start and duration of the longest freeze, s.
fn frozen(signal: &Signal) -> Option<(f64, f64)> {
    let (time, values) = (signal.time(), signal.values());
    let held = hold::of(values).map_or(1.0, |h| h.rows);
    let stretches = hold::stretches(values);
    let longest = stretches.iter().rev().max_by_key(|s| s.len())?;
    let (rows, step) = (longest.len() as f64, usual_step(time)?);
    let long = rows > FREEZE.0 as f64 * held && rows * step > FREEZE.1;
    if !long || stretches.len() < 20 || !hold::seldom_repeats(&stretches, held) {
        return None;
    }
    Some((time[longest.start], time[longest.end - 1] - time[longest.start]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tank::Noise;

    #[test]
    fn a_frozen_sensor_is_found_and_a_coarse_one_is_not() {
        let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        for seed in 0..20 {
            let mut noise = Noise::new(seed, 1);
            let fine: Vec<f64> = time.iter().map(|t| (0.2 * t).sin() + 0.01 * noise.normal()).collect();
            let mut frozen: Vec<f64> = fine.clone();
            frozen[200..260].fill(0.5);
            let coarse: Vec<f64> = fine.iter().map(|x| (x / 0.05).round() * 0.05).collect();
            let of = |x: Vec<f64>| super::frozen(&Signal::new(time.clone(), x));
            assert_eq!(of(fine), None);
            assert_eq!(of(coarse), None);
            let (from, seconds) = of(frozen).unwrap();
            assert!((from - 20.0).abs() < 1e-9 && (seconds - 5.9).abs() < 1e-9);
        }
    }

    #[test]
    fn a_thruster_at_its_limit_is_found() {
        let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        let mut run = Run::default();
        let volts = |limit: f64| time.iter().map(|t| (5.0 * t.sin()).clamp(-limit, limit)).collect::<Vec<_>>();
        run.signals.insert("V1".into(), Signal::new(time.clone(), volts(4.0)));
        run.signals.insert("V2".into(), Signal::new(time.clone(), volts(6.0)));
        // computed from the command: at its limit where the command is
        run.signals.insert("F1".into(), Signal::new(time.clone(), volts(4.0)));
        let found = check(&run);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].channels, ["V1"]);
    }
}
