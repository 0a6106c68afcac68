//! Blind campaigns: a random vehicle, runs, and effects in the true model that the baseline lacks.
//!
//! Nine runs of 90 s (thirteen in six degrees of freedom) at 10 Hz, commands linear between the
//! samples, noise of 5 mm/s, 3 mrad/s, 0.5° of angle, 5 cm of position (independent of the
//! velocity) and 2 cm of depth. The vehicle, the profiles and the noise come from separate streams
//! of one seed: with the same seed, another noise or another hidden effect has the same vehicle and
//! the same commands.

use std::collections::BTreeMap;

use super::hidden::hide;
use super::trials::trials;
use super::{Basin, Craft, CraftKind, Disturbance, Hidden, Law, Noise, Sensor, TankError, Trial};
use crate::effects::{Coriolis, channel};
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, Signal};
use crate::vehicle::Vehicle;

/// Options of a blind campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct BlindOptions {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Vehicle.
    pub craft: CraftKind,
    /// Six degrees of freedom instead of surge, sway and yaw.
    pub six: bool,
    /// Sample rate of sensors and commands, Hz.
    pub rate: f64,
    /// Length of a run, s.
    pub duration: f64,
    /// Noise as a multiple of the ordinary one (5 mm/s, 3 mrad/s, …).
    pub noise: f64,
    /// Correlation of the noise from sample to sample; 0 is white.
    pub colour: f64,
    /// Standard deviation of the disturbing force as a fraction of the force in each degree of
    /// freedom; 0 for none. 0.02 is 3 to 7 N on the large vehicle.
    pub disturbance: f64,
    /// Correlation time of the disturbing force, s.
    pub disturbance_time: f64,
    /// Effects that the true model contains and the baseline lacks.
    pub hidden: Vec<Hidden>,
}

impl Default for BlindOptions {
    fn default() -> BlindOptions {
        BlindOptions {
            seed: 1,
            craft: CraftKind::Large,
            six: false,
            rate: 10.0,
            duration: 90.0,
            noise: 1.0,
            colour: 0.0,
            disturbance: 0.0,
            disturbance_time: 1.0,
            hidden: Vec::new(),
        }
    }
}

/// A campaign with a known true model.
#[derive(Debug, Clone)]
pub struct Blind {
    /// The vehicle data known to the owner.
    pub vehicle: Vehicle,
    /// Degrees of freedom.
    pub dofs: Vec<Dof>,
    /// Names of the effects of the baseline.
    pub baseline: Vec<String>,
    /// Runs, train and validate.
    pub runs: Vec<Run>,
    /// The true model.
    pub truth: Model,
    /// Canonical names of the hidden effects.
    pub hidden: Vec<String>,
    /// Root mean square of the random force in each degree of freedom, N or N·m.
    pub disturbance: Vec<f64>,
}

impl Blind {
    /// The baseline as a model with neutral values.
    ///
    /// # Errors
    /// None for a campaign made by [`blind`].
    pub fn model(&self) -> Result<Model, TankError> {
        let names: Vec<&str> = self.baseline.iter().map(String::as_str).collect();
        let mut model = Model::with_effects(&self.dofs, Coriolis::Tied, &names)?;
        model.weight = self.vehicle.weight.unwrap_or(0.0);
        Ok(model)
    }
}

/// Effects of a baseline in the horizontal plane, and further ones in six degrees of freedom.
const PLANAR: [&str; 6] =
    ["inertia", "linear_drag", "quadratic_drag", "coriolis_surge", "coriolis_sway", "coriolis_yaw"];
const SPATIAL: [&str; 8] = [
    "coriolis_heave",
    "coriolis_roll",
    "coriolis_pitch",
    "restoring_surge",
    "restoring_sway",
    "restoring_heave",
    "restoring_roll",
    "restoring_pitch",
];

/// Streams of the seed: the vehicle, its trials, the hidden effects.
const STREAMS: [u64; 3] = [1, 2, 3];

/// Makes a blind campaign.
///
/// # Errors
/// [`TankError`] if an effect cannot be hidden there or the motion diverges.
pub fn blind(options: &BlindOptions) -> Result<Blind, TankError> {
    let [mut draw, mut profile, mut secret] = STREAMS.map(|stream| Noise::new(options.seed, stream));
    let craft = Craft::draw(options.craft, &mut draw);
    let dofs: Vec<Dof> = if options.six { Dof::ALL.to_vec() } else { vec![Dof::Surge, Dof::Sway, Dof::Yaw] };
    let mut baseline: Vec<String> = PLANAR.iter().map(|s| (*s).to_string()).collect();
    if options.six {
        baseline.extend(SPATIAL.iter().map(|s| (*s).to_string()));
    }
    let mut truth = truth_of(&craft, &dofs, &baseline)?;
    let mut trials = trials(&craft, options.six, options.duration, &mut profile);
    let mut hidden = Vec::new();
    for one in &options.hidden {
        hidden.push(hide(&mut truth, &mut baseline, one, &craft, trials.len(), &mut secret)?);
    }
    supply(&mut trials, channel::SUPPLY_RATIO);
    let basin = basin(options, &craft, &dofs);
    let mut runs = Vec::new();
    for (index, trial) in trials.iter_mut().enumerate() {
        amplitudes(&basin, &truth, trial, index, craft.vehicle.characteristic_length().unwrap_or(1.0))?;
        runs.push(basin.sail(&truth, trial, index, options.seed)?);
    }
    log_supply(&mut runs);
    let disturbance = dofs.iter().map(|dof| basin.disturbance.std[dof.index()]).collect();
    Ok(Blind { vehicle: craft.vehicle, dofs, baseline, runs, truth, hidden, disturbance })
}

fn truth_of(craft: &Craft, dofs: &[Dof], baseline: &[String]) -> Result<Model, TankError> {
    let names: Vec<&str> = baseline.iter().map(String::as_str).collect();
    let mut truth = Model::with_effects(dofs, Coriolis::Tied, &names)?;
    truth.weight = craft.vehicle.weight.unwrap_or(0.0);
    for dof in dofs {
        let i = dof.index();
        for (id, values) in
            [("inertia", craft.inertia), ("linear_drag", craft.linear), ("quadratic_drag", craft.quadratic)]
        {
            truth.set(&format!("{id}@{dof}"), values[i]);
        }
    }
    truth.set("restoring_heave", craft.net_weight());
    truth.set("restoring_roll", craft.righting);
    Ok(truth)
}

fn basin(options: &BlindOptions, craft: &Craft, dofs: &[Dof]) -> Basin {
    let degree = f64::to_radians(1.0);
    let sensor =
        |channel: &str, noise: f64| Sensor::new(channel, options.rate, noise * options.noise).colour(options.colour);
    let mut sensors: Vec<Sensor> =
        dofs.iter().map(|dof| sensor(dof.velocity(), if dof.is_rotation() { 0.003 } else { 0.005 })).collect();
    for dof in Dof::ALL {
        let noise = match dof {
            Dof::Surge | Dof::Sway => 0.05,
            Dof::Heave => 0.02,
            _ => 0.5 * degree,
        };
        sensors.push(sensor(dof.position(), noise));
    }
    sensors.push(sensor("supply_V", 0.01));
    Basin {
        control_rate: options.rate,
        sensors,
        disturbance: Disturbance {
            std: craft.force.map(|f| f * options.disturbance),
            correlation: options.disturbance_time,
        },
        ..Basin::default()
    }
}

/// Adds to every trial the ratio of the supply voltage to its mean over the campaign.
fn supply(trials: &mut [Trial], ratio: &str) {
    let all: Vec<f64> = trials.iter().filter_map(|t| t.channels.get("supply_V")).flat_map(mean_of).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    for trial in trials {
        if let Some(volts) = trial.channels.get("supply_V") {
            let values: Vec<f64> = volts.values().iter().map(|v| v / mean).collect();
            trial.channels.insert(ratio.to_string(), Signal::new(volts.shared_time().clone(), values));
        }
    }
}

/// Mean of a signal, if it has one.
fn mean_of(signal: &Signal) -> Option<f64> {
    (!signal.is_empty()).then(|| signal.values().iter().sum::<f64>() / signal.len() as f64)
}

/// Replaces the true supply ratio by that of the logged voltage.
fn log_supply(runs: &mut [Run]) {
    let all: Vec<f64> = runs.iter().filter_map(|run| run.signal("supply_V")).flat_map(mean_of).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    for run in runs {
        if let Some(volts) = run.signals.get("supply_V") {
            let values: Vec<f64> = volts.values().iter().map(|v| v / mean).collect();
            let ratio = Signal::new(volts.shared_time().clone(), values);
            run.signals.insert(channel::SUPPLY_RATIO.to_string(), ratio);
        }
    }
}

/// Rounds of the fixed-point iteration for the amplitude and the motion that it causes.
const ROUNDS: usize = 4;

/// Adds to a trial its Keulegan-Carpenter numbers, KC = U_m T / L_c with the characteristic length
/// `length` (m), where the true model reads them. U_m is the greatest speed of the motion that
/// results with these numbers themselves, T the period of the strongest sine, 0 without one.
pub(crate) fn amplitudes(
    basin: &Basin,
    truth: &Model,
    trial: &mut Trial,
    index: usize,
    length: f64,
) -> Result<(), TankError> {
    let read: Vec<Dof> = truth
        .terms
        .iter()
        .filter(|term| term.effect.about().id == "added_mass_amplitude")
        .filter_map(|term| term.place.dof)
        .collect();
    let still = Basin { disturbance: Disturbance::default(), ..basin.clone() };
    let perfect =
        Basin { sensors: read.iter().map(|d| Sensor::new(d.velocity(), basin.control_rate, 0.0)).collect(), ..still };
    let mut greatest: BTreeMap<Dof, f64> = read.iter().map(|dof| (*dof, 0.0)).collect();
    let rounds = if read.is_empty() { 0 } else { ROUNDS };
    for round in 0..=rounds {
        for (dof, speed) in &greatest {
            let length = if dof.is_rotation() { 1.0 } else { length };
            let number = speed * period_of(trial, *dof) / length;
            let ends: std::sync::Arc<[f64]> = vec![0.0, trial.duration].into();
            trial.channels.insert(channel::keulegan_carpenter(*dof), Signal::new(ends, vec![number; 2]));
        }
        if round < rounds {
            let run = perfect.sail(truth, trial, index, 0)?;
            for (dof, speed) in &mut greatest {
                let values = run.signal(dof.velocity()).map_or(&[][..], Signal::values);
                *speed = values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            }
        }
    }
    Ok(())
}

fn period_of(trial: &Trial, dof: Dof) -> f64 {
    let sines = trial.pilot.laws.iter().filter(|(d, _)| *d == dof).flat_map(|(_, law)| match law {
        Law::Sines(_, sines) => sines.as_slice(),
        _ => &[],
    });
    sines.max_by(|a, b| a.amplitude.abs().total_cmp(&b.amplitude.abs())).map_or(0.0, |s| s.period)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::Available;
    use crate::dynamics::Dynamics;
    use crate::run::{Role, RunKind};
    use crate::simulate::{Track, free_run};

    fn bits(blind: &Blind) -> Vec<u64> {
        let signals = blind.runs.iter().flat_map(|run| run.signals.values());
        signals.flat_map(|s| s.time().iter().chain(s.values()).map(|x| x.to_bits()).collect::<Vec<_>>()).collect()
    }

    #[test]
    fn regress_same_seed_same_bits() {
        let options = BlindOptions { duration: 20.0, disturbance: 0.02, colour: 0.5, ..BlindOptions::default() };
        let first = bits(&blind(&options).unwrap());
        assert_eq!(first, bits(&blind(&options).unwrap()));
        assert_ne!(first, bits(&blind(&BlindOptions { seed: 2, ..options }).unwrap()));
    }

    #[test]
    fn noise_does_not_change_vehicle_or_commands() {
        let quiet = BlindOptions { duration: 20.0, noise: 0.0, ..BlindOptions::default() };
        let (a, b) = (blind(&quiet).unwrap(), blind(&BlindOptions { noise: 5.0, ..quiet }).unwrap());
        assert_eq!(a.truth.values(), b.truth.values());
        for (one, other) in a.runs.iter().zip(&b.runs) {
            assert_eq!(one.signal("tau_r"), other.signal("tau_r"));
            assert_ne!(one.signal("r"), other.signal("r"));
        }
    }

    #[test]
    fn nine_runs_with_the_rates_and_noise_asked_for() {
        let quiet = BlindOptions { rate: 4.0, noise: 0.0, ..BlindOptions::default() };
        let (clean, noisy) = (blind(&quiet).unwrap(), blind(&BlindOptions { noise: 1.0, ..quiet }).unwrap());
        assert_eq!(noisy.runs.len(), 9);
        assert_eq!(noisy.runs.iter().filter(|run| run.role == Role::Validate).count(), 3);
        for (channel, std) in [("u", 0.005), ("r", 0.003), ("x", 0.05), ("psi", 0.5f64.to_radians()), ("z", 0.02)] {
            let (mut sum, mut n) = (0.0, 0.0);
            for (a, b) in clean.runs.iter().zip(&noisy.runs) {
                let (a, b) = (a.signal(channel).unwrap(), b.signal(channel).unwrap());
                assert_eq!(b.len(), 361);
                sum += a.values().iter().zip(b.values()).map(|(x, y)| (x - y).powi(2)).sum::<f64>();
                n += b.len() as f64;
            }
            // 3249 samples: a standard error of 1.2 %
            assert!(((sum / n).sqrt() / std - 1.0).abs() < 0.05, "{channel}");
        }
    }

    /// The tank and the simulator of the fit are two integrators of one model: without noise they
    /// agree.
    #[test]
    fn law_noise_free_logs_satisfy_the_model() {
        for (six, name) in [(false, "thrust_lag"), (false, "thrust_delay"), (false, "tether_spring"), (true, "current")]
        {
            let hidden = vec![Hidden::new(name, 1.0)];
            let options = BlindOptions { six, noise: 0.0, duration: 30.0, hidden, ..BlindOptions::default() };
            let campaign = blind(&options).unwrap();
            let theta = campaign.truth.values();
            for (index, run) in campaign.runs.iter().enumerate() {
                let available = Available {
                    channels: run.signals.keys().cloned().collect(),
                    position: true,
                    ..Available::default()
                };
                let observed = run.signals.keys().cloned().collect();
                let dynamics = Dynamics::compile(&campaign.truth, &available, &observed, &[]);
                let track = Track::new(run, index, &dynamics, &theta, campaign.truth.input, 0.01).unwrap();
                let first = |id: &crate::chain::StateId| id.channel().map(|name| run.signal(name).unwrap().values()[0]);
                let x0: Vec<f64> = dynamics.states.iter().filter_map(first).collect();
                let result = free_run(&dynamics, &track, &theta, &x0, 0, track.time.len() - 1);
                let worst = result.outputs.iter().zip(&track.observed).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                // two Runge-Kutta solutions with different steps at the kinks of a delayed command
                assert!(worst < 1e-5, "{name}, {}: {worst}", run.name);
            }
        }
    }

    #[test]
    fn zigzags_stay_within_bounds() {
        for seed in 0..4 {
            for craft in [CraftKind::Large, CraftKind::Small] {
                let campaign = blind(&BlindOptions { seed, craft, noise: 0.0, ..BlindOptions::default() }).unwrap();
                for run in campaign.runs.iter().filter(|run| run.kind == RunKind::Zigzag) {
                    let psi = run.signal("psi").unwrap().values();
                    let most = psi.iter().fold(0.0, |m: f64, p| m.max((p - psi[0]).abs()));
                    assert!(most > 1.0 && most < 2.6, "{craft:?} {}: {most} rad", run.name);
                }
            }
        }
    }

    #[test]
    fn six_degrees_of_freedom_stay_upright_and_under_water() {
        for (seed, craft) in
            [(1, CraftKind::Small), (2, CraftKind::Small), (3, CraftKind::Small), (3, CraftKind::Large)]
        {
            let options = BlindOptions { seed, craft, six: true, noise: 0.0, rate: 5.0, ..BlindOptions::default() };
            let campaign = blind(&options).unwrap();
            assert_eq!(campaign.runs.len(), 13);
            for run in &campaign.runs {
                let (theta, z) = (run.signal("theta").unwrap().values(), run.signal("z").unwrap().values());
                let most = theta.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                assert!(most < 1.0, "{craft:?} seed {seed} {}: pitch of {most} rad", run.name);
                assert!(z.iter().all(|z| *z > 0.0), "{craft:?} seed {seed} {}: out of the water", run.name);
            }
        }
    }
}
