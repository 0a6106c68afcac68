//! The trials of a blind campaign: each degree of freedom alone, a zig-zag, all together.
//!
//! ```text
//! 0 surge, thrust of one sign   1 surge   2 sway   3 yaw   4 zig-zag   5 all, multi-sine         train
//! 6 zig-zag   7 all, multi-sine   8 surge                                                        validate
//! 9 heave   10 roll   11 pitch  train,   12 all, multi-sine  validate                            6 DOF only
//! ```

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use super::{Craft, Law, Measured, Noise, Pilot, Sine, Trial};
use crate::frame::Dof;
use crate::run::{Role, RunKind, Signal};

/// Periods of the multi-sines, s: no two have a simple ratio.
const PERIODS: [f64; 9] = [31.0, 19.0, 11.3, 27.0, 16.3, 9.1, 23.0, 14.1, 7.3];
/// Heading bound of the zig-zags, rad.
const BOUND: f64 = PI / 3.0;
/// Supply voltage at the start of the first run, and its decrease over one run and from run to run,
/// V.
const SUPPLY: [f64; 3] = [16.6, 1.6, 0.12];

/// All trials; those in six degrees of freedom hold their depth.
pub(super) fn trials(craft: &Craft, six: bool, duration: f64, noise: &mut Noise) -> Vec<Trial> {
    let number = if six { 13 } else { 9 };
    (0..number).map(|k| trial(craft, six, duration, k, noise)).collect()
}

fn trial(craft: &Craft, six: bool, duration: f64, k: usize, noise: &mut Noise) -> Trial {
    let force = craft.force.map(|f| f * noise.between(0.9, 1.05));
    let heading = noise.between(-PI, PI);
    // if heave is simulated, a heave run moves some 2 m up and down
    let depth = noise.between(1.0, 4.0) + if six { 2.0 } else { 0.0 };
    let period = |typical: f64, noise: &mut Noise| typical * noise.between(0.9, 1.1);
    let zigzag = |moment: f64| Law::Zigzag { moment, centre: heading, bound: BOUND };
    let (kind, mut laws) = match k {
        0 => {
            let law = Law::sine(0.5 * force[0], 0.45 * force[0], period(16.0, noise));
            (RunKind::Oscillatory, vec![(Dof::Surge, law)])
        }
        1 => alone(Dof::Surge, 0.6 * force[0], period(11.0, noise)),
        2 => alone(Dof::Sway, force[1], period(14.0, noise)),
        3 => alone(Dof::Yaw, force[5], period(17.0, noise)),
        4 | 6 => {
            let moment = if k == 4 { 0.65 } else { -0.6 } * force[5];
            let ahead = Law::constant(if k == 4 { 0.55 } else { 0.5 } * force[0]);
            (RunKind::Zigzag, vec![(Dof::Surge, ahead), (Dof::Yaw, zigzag(moment))])
        }
        8 => alone(Dof::Surge, 0.55 * force[0], period(20.0, noise)),
        9 => alone(Dof::Heave, 0.7 * force[2], period(13.0, noise)),
        10 => alone(Dof::Roll, 0.8 * force[3], period(7.0, noise)),
        11 => alone(Dof::Pitch, 0.8 * force[4], period(8.0, noise)),
        _ => (RunKind::Free, everything(&force, six, noise)),
    };
    if six {
        let stiffness = if k == 9 { 0.15 } else { 0.6 } * force[2];
        laws.push((Dof::Heave, Law::Hold { target: depth, stiffness, damping: stiffness }));
    }
    let mut start = Measured::default();
    (start.pose[2], start.pose[5]) = (depth, heading);
    Trial {
        name: format!("run{k:02}.csv"),
        kind,
        role: if matches!(k, 6 | 7 | 8 | 12) { Role::Validate } else { Role::Train },
        duration,
        pilot: Pilot::new(laws),
        start,
        channels: surroundings(six, depth, duration, k, noise),
    }
}

fn alone(dof: Dof, amplitude: f64, period: f64) -> (RunKind, Vec<(Dof, Law)>) {
    (RunKind::Oscillatory, vec![(dof, Law::sine(0.0, amplitude, period))])
}

/// Multi-sines in every degree of freedom, each with its own three periods.
fn everything(force: &[f64; 6], six: bool, noise: &mut Noise) -> Vec<(Dof, Law)> {
    let dofs: &[Dof] = if six { &Dof::ALL } else { &[Dof::Surge, Dof::Sway, Dof::Yaw] };
    let law = |(n, dof): (usize, &Dof)| {
        let share = match dof {
            Dof::Surge => 0.15,
            Dof::Sway => 0.25,
            _ => 0.2,
        };
        let sines = (0..3).map(|part| Sine {
            amplitude: share * force[dof.index()],
            period: PERIODS[(n * 3 + part) % PERIODS.len()] * noise.between(0.95, 1.05),
            phase: noise.between(0.0, TAU),
        });
        let offset = if *dof == Dof::Surge { 0.33 * force[0] } else { 0.0 };
        (*dof, Law::Sines(offset, sines.collect()))
    };
    dofs.iter().enumerate().map(law).collect()
}

/// Channels that are logged beside the motion: the decreasing supply voltage and, if they are not
/// simulated, depth, roll and pitch.
fn surroundings(six: bool, depth: f64, duration: f64, k: usize, noise: &mut Noise) -> BTreeMap<String, Signal> {
    let volts = SUPPLY[0] - SUPPLY[2] * k as f64;
    let supply = Signal::new(vec![0.0, duration].into(), vec![volts, volts - SUPPLY[1]]);
    let mut channels = BTreeMap::from([("supply_V".to_string(), supply)]);
    if six {
        return channels;
    }
    let time: Vec<f64> = (0..=(duration * 10.0) as usize).map(|j| 0.1 * j as f64).collect();
    let slow = [(Dof::Heave, depth, 0.4, 37.0), (Dof::Roll, 0.0, 0.04, 21.0), (Dof::Pitch, -0.02, 0.09, 26.0)];
    for (dof, mean, amplitude, period) in slow {
        let phase = noise.between(0.0, TAU);
        let values: Vec<f64> = time.iter().map(|t| mean + amplitude * (TAU * t / period + phase).sin()).collect();
        channels.insert(dof.position().to_string(), Signal::new(time.clone().into(), values));
    }
    channels
}
