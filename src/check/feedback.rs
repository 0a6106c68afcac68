//! Feedback: a command that repeats the noise of a sensor, sample by sample.
//!
//! ```text
//! τₖ = a + Σ aᵢ τₖ₋ᵢ + Σ bⱼ yₖ₋₂₋ⱼ + c₀ yₖ + c₁ yₖ₋₁ + e,    i = 1…4, j = 0…2
//! F = (SSE(c = 0) − SSE)/(p s²)
//! ```
//!
//! y: the sensors that a controller of this command would read; p: number of coefficients c. The
//! part of yₖ that earlier values do not predict is noise and random disturbance of the vehicle.
//! The commands of a pilot do not depend on it, F ≈ 1; a controller multiplies it by its gain, and
//! so does an autopilot with the angle of a fin. Only commands that are noisy themselves are
//! tested, not profiles and steps. Source: Granger, *Econometrica* 37 (1969) 424-438.

use super::balance::commands;
use super::codes;
use super::commands::as_logged;
use super::fit::fit;
use super::report::Found;
use crate::effects::id::{self, FinIds};
use crate::frame::Dof;
use crate::log::number::short;
use crate::navigation::unwrap;
use crate::run::{Run, Signal};

/// Number of lags of the command, and of a sensor besides the two that are tested.
const LAGS: [usize; 2] = [4, 3];
/// Least F of a command that follows a sensor; without feedback F exceeds 12 once in 10⁵ if two
/// coefficients are tested.
const FOLLOWS: f64 = 12.0;
/// Least number of samples.
const FEWEST: usize = 150;
/// Least share of third differences of a noisy command that are not zero, and largest correlation
/// of neighbouring ones: white noise has −0.75, a profile +1, and steps have few that are not zero.
const NOISY: (f64, f64) = (0.5, -0.3);

/// Finds commands that follow a sensor, except in the channels of `told`.
pub fn judge(run: &Run, told: &[Found]) -> Vec<Found> {
    let is_told = |channel: &str| {
        told.iter().any(|f| *f.code == codes::CLOSED_LOOP && f.channels.iter().any(|other| other == channel))
    };
    let mut found: Vec<Found> = Vec::new();
    for Steers { command, channel, dof } in steering(run) {
        // thrusters serve several degrees of freedom, and are reported once
        if is_told(&channel) || found.iter().any(|f| f.channels[0] == channel) {
            continue;
        }
        let sensors = sensors(run, dof);
        let Some(f) = run.signal(&command).and_then(|tau| follows(tau, &sensors)).filter(|f| *f > FOLLOWS) else {
            continue;
        };
        let names: Vec<&str> = sensors.iter().map(|(name, _)| *name).collect();
        let text = format!(
            "{} repeats the noise of {} from sample to sample (F = {}): a controller feeds it back, and a fit \
             identifies part of the controller; estimate the random force as well (filter_error does), or repeat the \
             run with open-loop commands",
            as_logged(&command, run),
            names.join(", "),
            short(f, 3)
        );
        found.push(Found::new(&codes::CLOSED_LOOP, &[&channel], text));
    }
    found
}

/// A command, the channel under which it is reported, and the degree of freedom whose sensors a
/// controller of it would read; `None` if it serves several.
struct Steers {
    command: String,
    channel: String,
    dof: Option<Dof>,
}

/// Returns the forces, thrusters and fins of a run.
fn steering(run: &Run) -> Vec<Steers> {
    let of_dof = |dof: Dof| {
        commands(run, dof).into_iter().map(move |command| {
            let own = command == dof.force();
            let channel = if own { dof.velocity().to_string() } else { as_logged(&command, run) };
            Steers { command, channel, dof: own.then_some(dof) }
        })
    };
    let of_fin = |fin: &FinIds| {
        let [command, channel] = [fin.channel, fin.channel].map(str::to_string);
        Steers { command, channel, dof: Some(fin.turns) }
    };
    Dof::ALL.into_iter().flat_map(of_dof).chain(id::fins().iter().map(of_fin)).collect()
}

/// Returns the sensors that a controller of `dof` reads, or those of all degrees of freedom if it is
/// unknown. Horizontal fixes are left out: they are too rare.
fn sensors(run: &Run, dof: Option<Dof>) -> Vec<(&'static str, Signal)> {
    let mut read = Vec::new();
    for dof in Dof::ALL.into_iter().filter(|other| dof.is_none_or(|dof| dof == *other)) {
        for name in [dof.velocity(), dof.position()].into_iter().filter(|name| !["x", "y"].contains(name)) {
            let varies = |s: &&Signal| s.values().iter().any(|x| x.to_bits() != s.values()[0].to_bits());
            let Some(signal) = run.signal(name).filter(|s| s.len() >= FEWEST).filter(varies) else { continue };
            let turned =
                if ["phi", "psi"].contains(&name) { unwrap(signal.values()) } else { signal.values().to_vec() };
            read.push((name, Signal::new(signal.shared_time().clone(), turned)));
        }
    }
    read
}

/// Returns F of the newest samples of these sensors in a command; `None` if the command is not
/// noisy or the data do not suffice.
fn follows(command: &Signal, sensors: &[(&'static str, Signal)]) -> Option<f64> {
    let (time, tau) = (command.time(), command.values());
    if tau.len() < FEWEST || sensors.is_empty() || !is_noisy(tau) {
        return None;
    }
    let begins = sensors.iter().map(|(_, s)| s.time()[0]).fold(f64::NEG_INFINITY, f64::max);
    let ends = sensors.iter().map(|(_, s)| s.time()[s.len() - 1]).fold(f64::INFINITY, f64::min);
    let first = time.partition_point(|t| *t < begins) + LAGS[0].max(LAGS[1] + 1);
    let end = time.partition_point(|t| *t <= ends);
    if end < first + FEWEST {
        return None;
    }
    let rows = first..end;
    let lagged = |x: &[f64], lag: usize| -> Vec<f64> { rows.clone().map(|k| x[k - lag]).collect() };
    // the newest sample at each stamp of the command
    let newest = |s: &Signal| -> Vec<f64> {
        time.iter().map(|t| s.values()[s.time().partition_point(|own| own <= t).max(1) - 1]).collect()
    };
    let mut columns: Vec<Vec<f64>> = vec![vec![1.0; rows.len()]];
    columns.extend((1..=LAGS[0]).map(|lag| lagged(tau, lag)));
    let mut tested = Vec::new();
    for (_, sensor) in sensors {
        let y = newest(sensor);
        columns.extend((2..2 + LAGS[1]).map(|lag| lagged(&y, lag)));
        tested.extend((0..2).map(|lag| lagged(&y, lag)));
    }
    let target = lagged(tau, 0);
    let cost = |columns: &[&Vec<f64>]| {
        fit(&columns.iter().map(|c| c.as_slice()).collect::<Vec<_>>(), &target)
            .map(|f| (f.cost, f.rows - f.theta.len()))
    };
    let (without, _) = cost(&columns.iter().collect::<Vec<_>>())?;
    let (with, free) = cost(&columns.iter().chain(&tested).collect::<Vec<_>>())?;
    (with > 0.0).then(|| (without - with) / tested.len() as f64 / (with / free as f64))
}

/// Whether a command is noisy: neither a smooth profile nor steps.
fn is_noisy(tau: &[f64]) -> bool {
    let third: Vec<f64> = tau.windows(4).map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).collect();
    let most = third.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let changing = third.iter().filter(|x| x.abs() > 1e-9 * most).count();
    let power: f64 = third.iter().map(|x| x * x).sum();
    let neighbours: f64 = third.windows(2).map(|w| w[0] * w[1]).sum();
    most > 0.0 && changing as f64 > NOISY.0 * third.len() as f64 && neighbours < NOISY.1 * power
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// Command as a function of time, measured heading, measured rate and noise.
    type Pilot = dyn Fn(f64, f64, f64, &mut Noise) -> f64;

    /// A heading under r' = τ/20 − r, at 10 Hz with noise of both sensors; the command is a
    /// function of the measurements.
    fn sailed(seed: u64, moment: impl Fn(f64, f64, f64, &mut Noise) -> f64) -> Run {
        let mut noise = Noise::new(seed, 3);
        let (mut psi, mut r) = (0.0, 0.0);
        let [mut logged, mut rates, mut moments] = [Vec::new(), Vec::new(), Vec::new()];
        let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        for t in time.iter() {
            let (seen, rate) = (psi + 0.009 * noise.normal(), r + 0.003 * noise.normal());
            // as a log writes it
            let tau = (1e3 * moment(*t, seen, rate, &mut noise)).round() / 1e3;
            logged.push(seen);
            rates.push(rate);
            moments.push(tau);
            r += 0.1 * (tau / 20.0 - r);
            psi += 0.1 * r;
        }
        let mut run = Run::default();
        for (name, values) in [("psi", logged), ("r", rates), ("tau_r", moments)] {
            run.signals.insert(name.into(), Signal::new(time.clone(), values));
        }
        run
    }

    #[test]
    fn a_heading_controller_is_told_and_a_pilot_is_not() {
        for seed in 0..20 {
            let steers = |t: f64, psi: f64, r: f64, _: &mut Noise| 30.0 * ((0.2 * t).sin() - psi) - 20.0 * r;
            let found = judge(&sailed(seed, steers), &[]);
            assert_eq!((found.len(), found[0].code.code, &found[0].channels[..]), (1, "K132", &["r".to_string()][..]));
            assert!(judge(&sailed(seed, steers), &found).is_empty(), "told once");
            let mut by_rudder = sailed(seed, steers);
            let rudder = by_rudder.signals.remove("tau_r").unwrap();
            by_rudder.signals.insert("rudder".into(), rudder);
            assert_eq!(judge(&by_rudder, &[])[0].channels, ["rudder"]);
            let pilots: [&Pilot; 5] = [
                &|t, _, _, _| 8.0 * (0.7 * t).sin() + 5.0 * (1.9 * t).cos(),
                &|t, _, _, _| if (0.4 * t).sin() > 0.0 { 9.0 } else { -9.0 },
                // coarse as a pulse width; a stick that trembles
                &|t, _, _, _| (20.0 * (0.7 * t).sin()).round() / 2.0,
                &|t, _, _, noise| 8.0 * (0.7 * t).sin() + noise.normal(),
                &|_, _, _, noise| 6.0 * noise.normal(),
            ];
            for (number, pilot) in pilots.into_iter().enumerate() {
                let found = judge(&sailed(seed, pilot), &[]);
                assert!(found.is_empty(), "{seed}, pilot {number}: {found:?}");
            }
        }
    }
}
