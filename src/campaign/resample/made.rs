//! The training runs as the fitted model would have logged them.
//!
//! ```text
//! free motion   y = simulated + e
//! bollard       load = η_inter τ_nom + e
//! towing        load = D(U) − τ + e
//! ```
//!
//! e: white, with the noise of the channel as stated or as its samples show it. A steady or towed
//! run has a further error, which its rows show and its samples do not: a force that is constant
//! over the run, with the size of the residuals of the rows of its stage. Commands, channels that
//! the model does not predict, and time stamps are those of the log.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::super::error::Error;
use super::super::fit::Fit;
use super::super::load::{Campaign, moves};
use super::super::simulate::one;
use crate::check::samples::Samples;
use crate::estimate::IntegralError;
use crate::estimate::output_error::Problem;
use crate::frame::Dof;
use crate::model::Model;
use crate::navigation::upright;
use crate::noise::Noise;
use crate::procedure::{acting_forces, is_powered, shown, towed_drag};
use crate::run::{Run, RunKind, Signal};
use crate::thrust::efficiency::Efficiency;

/// Magnitude of a simulated value, SI, beyond which it is no motion of a vehicle.
const FURTHEST: f64 = 1e3;

/// Logs without noise, each with the errors of its channels.
pub(super) struct Made {
    runs: Vec<(Run, BTreeMap<String, Errors>)>,
}

/// Errors of a channel of one run.
struct Errors {
    /// Standard deviation of its white noise.
    white: f64,
    /// Change of each sample by one standard deviation of the run's own force; empty if the run has
    /// none.
    own: Vec<f64>,
}

impl Made {
    /// Makes the logs of `runs`, each with its number in the campaign, by the fitted model.
    ///
    /// # Errors
    /// [`Error::Asked`] if the fitted model runs away; [`Error`] if it cannot be simulated.
    pub fn of(campaign: &Campaign, fitted: &Fit, runs: Vec<(usize, Run)>) -> Result<Made, Error> {
        let acting = campaign.under(&fitted.efficiency);
        let make = |(index, mut run): (usize, Run)| -> Result<(Run, BTreeMap<String, Errors>), Error> {
            let (dof, own) = own_force(&run, fitted);
            let clean = |by: f64| match moves(run.kind) {
                true => sailed(&acting, &fitted.model, &pushed(&acting.runs[index], dof, by), index),
                false => on_load_cells(&run, &fitted.model, &fitted.efficiency, campaign, by),
            };
            let mut moved = if own > 0.0 { clean(own)? } else { Clean::new() };
            let mut errors = BTreeMap::new();
            for (channel, (signal, white)) in clean(0.0)? {
                let own = moved.remove(&channel).map_or_else(Vec::new, |(moved, _)| {
                    moved.values().iter().zip(signal.values()).map(|(a, b)| a - b).collect()
                });
                errors.insert(channel.clone(), Errors { white, own });
                run.signals.insert(channel, signal);
            }
            Ok((run, errors))
        };
        Ok(Made { runs: runs.into_par_iter().map(make).collect::<Result<_, _>>()? })
    }

    /// Returns the logs with new noise.
    pub fn logged(&self, noise: &mut Noise) -> Vec<Run> {
        let with = |(clean, errors): &(Run, BTreeMap<String, Errors>)| {
            let mut run = clean.clone();
            let own = noise.normal();
            for (channel, errors) in errors {
                let signal = &clean.signals[channel];
                let moved = errors.own.iter().copied().chain(std::iter::repeat(0.0));
                let values = signal.values().iter().zip(moved);
                let values: Vec<f64> = values.map(|(x, by)| x + own * by + errors.white * noise.normal()).collect();
                run.signals.insert(channel.clone(), Signal::new(signal.shared_time().clone(), values));
            }
            run
        };
        self.runs.iter().map(with).collect()
    }
}

/// Channels without noise, each with the standard deviation of its noise.
type Clean = BTreeMap<String, (Signal, f64)>;

/// Returns the degree of freedom that a steady or towed run shows, and the standard deviation of
/// the residuals of its stage, N or N·m; 0 for any other run.
fn own_force(run: &Run, fitted: &Fit) -> (Option<Dof>, f64) {
    let dof = shown(run, &fitted.model.dofs);
    let stage = match run.kind {
        RunKind::ConstantVelocity => "steady",
        RunKind::Towing if dof.is_some_and(|dof| !is_powered(run, dof)) => "towing",
        _ => return (dof, 0.0),
    };
    let found = fitted.stages.iter().find(|s| s.name == stage && Some(s.dof) == dof);
    (dof, found.map_or(0.0, |stage| stage.residual_std))
}

/// Returns the run with a further force added to the logged one.
fn pushed(run: &Run, dof: Option<Dof>, by: f64) -> Run {
    let mut run = run.clone();
    if let Some(force) = dof.and_then(|dof| run.signals.get_mut(dof.force())) {
        let values: Vec<f64> = force.values().iter().map(|f| f + by).collect();
        *force = Signal::new(force.shared_time().clone(), values);
    }
    run
}

/// Returns what the model predicts for a run of free motion, at the time stamps of its sensors. If
/// the model runs away, as one may whose other degrees of freedom no stage has shown, only the
/// degree of freedom that the run shows is simulated, with the others as logged.
fn sailed(campaign: &Campaign, model: &Model, run: &Run, index: usize) -> Result<Clean, Error> {
    let alone = shown(run, &model.dofs).map(|dof| Model { dofs: vec![dof], ..model.clone() });
    for model in [Some(model), alone.as_ref()].into_iter().flatten() {
        let clean = simulated(campaign, model, run, index)?;
        let tame = |signal: &Signal| signal.values().iter().all(|x| x.is_finite() && x.abs() < FURTHEST);
        if clean.values().all(|(signal, _)| tame(signal)) {
            return Ok(clean);
        }
    }
    let text =
        format!("the fitted model diverges in `{}`, and cannot produce data to refit: use --bootstrap", run.name);
    Err(Error::Asked(text))
}

fn simulated(campaign: &Campaign, model: &Model, run: &Run, index: usize) -> Result<Clean, Error> {
    let simulated = one(campaign, model, run, index)?;
    let problem = Problem::new(model, std::slice::from_ref(run), &campaign.options.output_error)?;
    let outputs = problem.dynamics.outputs.iter().zip(&problem.sigma);
    let noise: BTreeMap<&str, f64> =
        outputs.map(|(output, sigma)| (upright::instrument_of(output).unwrap_or(output), *sigma)).collect();
    let mut clean = Clean::new();
    for (channel, values) in &simulated.simulated {
        let is = simulated.measured.get(channel).map_or(&[][..], Vec::as_slice);
        let samples = simulated.time.iter().zip(values).zip(is).filter(|(_, is)| is.is_some());
        let (time, values): (Vec<f64>, Vec<f64>) = samples.map(|((t, x), _)| (*t, *x)).unzip();
        if !time.is_empty() {
            let deviation = noise.get(channel.as_str()).copied().unwrap_or(0.0);
            clean.insert(channel.clone(), (Signal::new(time.into(), values), deviation));
        }
    }
    Ok(clean)
}

/// Returns the readings of the load cells of a bollard or towing run, increased by `by`.
fn on_load_cells(
    run: &Run,
    model: &Model,
    efficiency: &Efficiency,
    campaign: &Campaign,
    by: f64,
) -> Result<Clean, Error> {
    let towing = run.kind == RunKind::Towing;
    // a vehicle that is held still has no advance
    let losses = Efficiency { eta_adv: efficiency.eta_adv.filter(|_| towing), ..efficiency.clone() };
    let acting = acting_forces(run, &losses, &campaign.file.thrusters).0;
    let mut clean = Clean::new();
    for dof in &model.dofs {
        let Some(load) = run.signal(dof.load()).filter(|load| !load.is_empty()) else { continue };
        let thrust = |t: f64| acting.signal(dof.force()).map_or(0.0, |force| force.at(t));
        let speed = |t: &f64| run.signal(dof.velocity()).map_or(0.0, |speed| speed.at(*t));
        let values: Vec<f64> = match towing {
            true => {
                let speeds: Vec<f64> = load.time().iter().map(speed).collect();
                let drags = towed_drag(model, *dof, &speeds).map_err(IntegralError::from)?;
                load.time().iter().zip(drags).map(|(t, drag)| drag - thrust(*t) + by).collect()
            }
            false => load.time().iter().map(|t| thrust(*t) + by).collect(),
        };
        let noise = Samples::of(load).map_or(0.0, |samples| samples.noise());
        clean.insert(dof.load().to_string(), (Signal::new(load.shared_time().clone(), values), noise));
    }
    Ok(clean)
}
