//! The gap: errors of the predictions of held-out runs, before and after each name.

use std::collections::BTreeMap;

use serde::Serialize;

use super::found::FoundEffect;
use super::searched::{Search, Step};
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions, Filtered, Forecast, Prediction, RandomForce};
use crate::estimate::output_error::OutputErrorError;
use crate::frame::{Dof, Measured};
use crate::model::Model;
use crate::run::Run;

/// The gap on held-out runs after one step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GapStep {
    /// Name of the added effect; `None` for the refitted baseline.
    pub added: Option<String>,
    /// Whether it was removed again by a later step.
    pub dropped: bool,
    /// Root mean square of simulated minus measured velocity over the free run, per degree of freedom and observed
    /// channel.
    pub held_out_rms: BTreeMap<Measured, f64>,
    /// Sensor noise of the same quantities.
    pub noise_floor: BTreeMap<Measured, f64>,
    /// The same for each run.
    pub runs: Vec<GapOfRun>,
    /// Random force at this step: a true name reduces it.
    pub force: Vec<GapForce>,
    /// Accuracy of the predictions of held-out runs at this step.
    pub prediction: Vec<GapPrediction>,
}

/// The random force of one step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GapForce {
    /// Degree of freedom.
    pub dof: Dof,
    /// Standard deviation, N or N·m.
    pub rms: f64,
    /// `N` or `N*m`.
    pub unit: &'static str,
    /// Correlation time, s.
    pub correlation_time: f64,
}

/// Accuracy of the predictions of one channel of a held-out run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GapPrediction {
    /// Name of the run.
    pub run: String,
    /// Degree of freedom, or the channel of an observed function.
    pub dof: Measured,
    /// Seconds ahead: 0 for one sample, `null` for a free run.
    pub ahead: Option<f64>,
    /// Root-mean-square error, in the unit of the channel.
    pub rms: f64,
    /// The error that the filter expects.
    pub expected: f64,
}

/// The gap on one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GapOfRun {
    /// Name of the run.
    pub run: String,
    /// Root mean square by degree of freedom.
    pub held_out_rms: BTreeMap<Measured, f64>,
}

/// Predictions of the held-out runs by a fit; of the runs of the fit if none is held out.
pub(super) fn predictions(
    fit: &FilterErrorFit,
    held: &[Run],
    fitting: &FilterErrorOptions,
) -> Result<(Vec<String>, Vec<Forecast>), OutputErrorError> {
    let outputs = fit.filtered.problem.dynamics.outputs.clone();
    if held.is_empty() {
        return Ok((outputs, fit.forecast()));
    }
    let model = fit.on_others(held, fitting)?;
    let noise = fit.noise.elsewhere(&model, held);
    let filtered = Filtered::begun(&model, held, (&noise, fit.limit), &fitting.base)?;
    Ok((outputs, filtered.forecast(&model, &noise, fit.limit)))
}

/// Quantity that an output measures, if it is compared: a velocity, an observed function, or a pose whose velocity is
/// not measured.
fn measured(model: &Model, outputs: &[String], output: usize) -> Option<Measured> {
    let name = &outputs[output];
    let of_pose = || {
        let dof = model.dofs.iter().find(|dof| dof.position() == name)?;
        let alone = !outputs.iter().any(|other| other == dof.velocity());
        alone.then(|| Measured::Function(name.as_str().into()))
    };
    model.measured().into_iter().find(|m| m.channel() == name).or_else(of_pose)
}

/// Sensor noise of each quantity that is compared.
pub(super) fn noise_floor(fit: &FilterErrorFit) -> BTreeMap<Measured, f64> {
    let outputs = &fit.filtered.problem.dynamics.outputs;
    let of = |output: usize| {
        let sensor = fit.noise.sensors[output];
        let noise = sensor.std.hypot(sensor.coloured.map_or(0.0, |c| c.rms));
        Some((measured(&fit.model, outputs, output)?, noise))
    };
    (0..outputs.len()).filter_map(of).collect()
}

pub(super) fn gap_step(
    found: &Search,
    k: usize,
    step: &Step,
    outputs: &[String],
    forecasts: &[Forecast],
    floor: &BTreeMap<Measured, f64>,
) -> GapStep {
    let mut all: BTreeMap<Measured, Prediction> = BTreeMap::new();
    let (mut runs, mut prediction): (Vec<GapOfRun>, Vec<GapPrediction>) = (Vec::new(), Vec::new());
    for forecast in forecasts {
        let mut own = BTreeMap::new();
        for channel in &forecast.channels {
            let Some(dof) = measured(&step.fit.model, outputs, channel.output) else { continue };
            for p in channel.predictions.iter().filter(|p| p.count > 0) {
                let (run, dof) = (forecast.run.clone(), dof.clone());
                prediction.push(GapPrediction { run, dof, ahead: p.ahead, rms: p.rms(), expected: p.expected_rms() });
            }
            if let Some(free) = channel.predictions.iter().find(|p| p.ahead.is_none() && p.count > 0) {
                own.insert(dof.clone(), free.rms());
                all.entry(dof).and_modify(|sum| *sum = sum.with(free)).or_insert(*free);
            }
        }
        runs.push(GapOfRun { run: forecast.run.clone(), held_out_rms: own });
    }
    let force = |f: &RandomForce| GapForce {
        dof: f.dof,
        rms: f.rms,
        unit: if f.dof.is_rotation() { "N*m" } else { "N" },
        correlation_time: f.time,
    };
    GapStep {
        added: step.name.clone(),
        dropped: dropped(found, k),
        held_out_rms: all.into_iter().map(|(dof, p)| (dof, p.rms())).collect(),
        noise_floor: floor.clone(),
        runs,
        force: step.fit.noise.forces.iter().map(force).collect(),
        prediction,
    }
}

/// Least factor of improvement of predictions that is reported.
const BETTER: f64 = 1.1;

/// The quantity whose held-out predictions 8 s ahead have improved most, and the factor; one in which `effects` act,
/// if any of those has improved.
pub(super) fn improvement(gap: &[GapStep], effects: &[FoundEffect]) -> Option<(Measured, f64)> {
    let (first, last) = (gap.first()?, gap.last()?);
    let of = |step: &GapStep, measured: &Measured| {
        let own = step.prediction.iter().filter(|p| p.ahead == Some(8.0) && p.dof == *measured);
        own.map(|p| p.rms * p.rms).sum::<f64>().sqrt()
    };
    let times = |m: &Measured| (m.clone(), of(first, m) / of(last, m));
    let all = || first.held_out_rms.keys().map(times).filter(|(_, t)| t.is_finite() && *t > BETTER);
    let acts_in = |m: &Measured| effects.iter().flat_map(|e| &e.dofs).any(|dof| m.dof() == Some(*dof));
    let greatest = |a: &(Measured, f64), b: &(Measured, f64)| a.1.total_cmp(&b.1);
    all().filter(|(m, _)| acts_in(m)).max_by(greatest).or_else(|| all().max_by(greatest))
}

/// Error of free runs beyond the sensor noise: Σ (E²/σ² − 1)₊ over the compared quantities.
pub(super) fn excess(step: &GapStep) -> f64 {
    let of =
        |(dof, rms): (&Measured, &f64)| step.noise_floor.get(dof).map(|noise| ((rms / noise).powi(2) - 1.0).max(0.0));
    step.held_out_rms.iter().filter_map(of).sum()
}

/// Whether the effect of step `k` is not in the final model, or was added again later.
fn dropped(found: &Search, k: usize) -> bool {
    let name = found.steps[k].name.as_ref();
    name.is_some_and(|name| {
        let again = found.steps[k + 1..].iter().any(|later| later.name.as_ref() == Some(name));
        again || found.added.iter().all(|added| added.candidate.name() != *name)
    })
}
