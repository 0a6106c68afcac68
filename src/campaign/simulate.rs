//! The verb `simulate`: the model driven by what drove the runs.
//!
//! The initial state of each stretch without a gap is estimated on its first seconds with the parameters held; from
//! there on the measurement has no part in it.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use super::error::Error;
use super::load::{Campaign, moves};
use crate::envelope::{self, Envelope};
use crate::estimate::output_error::{OutputErrorOptions, Problem, fit_from};
use crate::finding::Finding;
use crate::model::Model;
use crate::run::{Role, Run, Signal};
use crate::simulate::{free_run, values_in_run};

/// First seconds of a stretch on which its initial state is estimated, s.
const SETTLE: f64 = 5.0;

/// Simulated runs. Serialises as `hydrosysid simulate --json`.
#[derive(Debug, Clone, Serialize)]
pub struct Simulation {
    /// Format of the result: 1.
    pub format: u32,
    /// The runs.
    pub runs: Vec<Simulated>,
    /// What there is to say.
    pub warnings: Vec<Finding>,
}

/// One simulated run.
#[derive(Debug, Clone, Serialize)]
pub struct Simulated {
    /// Name of the run.
    pub run: String,
    /// Whether the run took part in the fit.
    pub role: Role,
    /// Time stamps, s.
    pub time: Vec<f64>,
    /// Simulated channels by name, SI, one value a time stamp.
    pub simulated: BTreeMap<String, Vec<f64>>,
    /// Measured channels by name, SI; `null` where a sensor has no sample.
    pub measured: BTreeMap<String, Vec<Option<f64>>>,
}

impl Simulated {
    /// The simulated channels as signals.
    pub fn signals(&self) -> BTreeMap<String, Signal> {
        let time: std::sync::Arc<[f64]> = self.time.clone().into();
        self.simulated.iter().map(|(name, x)| (name.clone(), Signal::new(time.clone(), x.clone()))).collect()
    }
}

/// Simulates `model` over the runs of free motion of a campaign; `envelope` is that in which it was fitted.
///
/// # Errors
/// [`Error`] when a run lacks what the model reads.
pub fn simulate(campaign: &Campaign, model: &Model, envelope: &Envelope) -> Result<Simulation, Error> {
    let runs: Vec<(usize, &Run)> = campaign.runs.iter().enumerate().filter(|(_, run)| moves(run.kind)).collect();
    let mut warnings = campaign.findings.clone();
    warnings.extend(runs.iter().flat_map(|(_, run)| envelope::beyond(run, envelope)));
    let simulated: Result<Vec<Simulated>, Error> =
        runs.into_par_iter().map(|(k, run)| one(campaign, model, run, k)).collect();
    Ok(Simulation { format: 1, runs: simulated?, warnings })
}

fn one(campaign: &Campaign, model: &Model, run: &Run, index: usize) -> Result<Simulated, Error> {
    let mut held = model.clone();
    for (p, value) in held.parameters.iter_mut().zip(values_in_run(model, index)) {
        p.value = value;
        p.fixed = true;
        p.per_run.clear();
    }
    let options = OutputErrorOptions { segment: SETTLE, iterations: 6, ..campaign.options.output_error.clone() };
    // only the first seconds of each stretch: further on a model may be so wrong that it runs away, and that is to be seen
    let mut problem = Problem::new(&held, std::slice::from_ref(run), &options)?;
    let starts = problem.tracks[0].starts.clone();
    problem.segments.retain(|s| starts.contains(&s.first));
    let x0 = problem.initial_states(&held);
    let settled = fit_from(&held, problem, x0, &options)?;
    let Problem { dynamics, segments, tracks, .. } = &settled.problem;
    let track = &tracks[0];
    let width = dynamics.outputs.len();
    let mut result = Simulated {
        run: run.name.clone(),
        role: run.role,
        time: Vec::new(),
        simulated: dynamics.outputs.iter().map(|o| (o.clone(), Vec::new())).collect(),
        measured: dynamics.outputs.iter().map(|o| (o.clone(), Vec::new())).collect(),
    };
    let begins = segments.iter().zip(&settled.initial_states).filter(|(s, _)| track.starts.contains(&s.first));
    for (segment, start) in begins {
        let next = track.starts.iter().find(|s| **s > segment.first).copied().unwrap_or(track.time.len());
        let path = free_run(dynamics, track, &held.values(), start, segment.first, next - 1);
        result.time.extend(&path.time);
        for (column, name) in dynamics.outputs.iter().enumerate() {
            let simulated = path.outputs.iter().skip(column).step_by(width);
            let measured = track.observed[segment.first * width..next * width].iter().skip(column).step_by(width);
            result.simulated.entry(name.clone()).or_default().extend(simulated);
            let measured = measured.map(|x| (!x.is_nan()).then_some(*x));
            result.measured.entry(name.clone()).or_default().extend(measured);
        }
    }
    Ok(result)
}
