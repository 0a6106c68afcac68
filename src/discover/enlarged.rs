//! The model with all candidates added, each with zero strength.
//!
//! At zero strength a candidate's memory follows the motion but does not act on it. It is computed from the log
//! beforehand and read as a channel, so that no candidate adds a state.

use super::Candidate;
use crate::chain::{Attitude, Available, StateId};
use crate::dynamics::Dynamics;
use crate::effects::Family;
use crate::estimate::output_error::OutputErrorOptions;
use crate::estimate::velocities_from_poses;
use crate::frame::Dof;
use crate::model::{Model, Term, name_of};
use crate::run::{Run, Signal};
use crate::simulate::{Track, TrackError, free_run, values_in_run};

/// A candidate's columns in the big model.
pub(super) struct Planned {
    pub candidate: usize,
    pub probe: usize,
    pub per_run: bool,
    pub parameters: Vec<usize>,
}

/// The model with every probe of every candidate, its linear parameters at their neutral values.
pub(super) fn enlarge(model: &Model, candidates: &[Candidate]) -> (Model, Vec<Planned>) {
    let mut big = model.clone();
    for parameter in &mut big.parameters {
        parameter.spec.shared = None;
    }
    let mut planned = Vec::new();
    for (c, candidate) in candidates.iter().enumerate() {
        for (k, probe) in candidate.probes.iter().enumerate() {
            let mut free = Vec::new();
            let mut shared: Option<usize> = None;
            let blend = candidate.blended.then(|| {
                let spec = crate::effects::ParameterSpec::linear("blend", crate::units::Dimension::ONE);
                big.push_parameter(&candidate.name(), "blend", candidate.terms[0].1, spec)
            });
            for (effect, place) in &candidate.terms {
                let name = name_of(effect.about().id, *place);
                let mut shapes = probe.iter();
                let mut parameters = Vec::new();
                for spec in effect.parameters(*place) {
                    let linear = spec.is_linear();
                    let (is_shared, neutral) = (spec.shared.is_some(), spec.neutral);
                    if let (true, Some(known)) = (is_shared, shared) {
                        parameters.push(known);
                        continue;
                    }
                    let index = big.push_parameter(&name, effect.about().id, *place, spec);
                    if is_shared {
                        shared = Some(index);
                    }
                    if linear {
                        big.parameters[index].value = neutral;
                        free.push(index);
                    } else if let Some(value) = shapes.next() {
                        // a smooth shape parameter that is not probed on a grid is its own direction
                        let direction = !candidate.blended && candidate.probes.len() == 1;
                        big.parameters[index].value = if direction { neutral } else { *value };
                        if direction {
                            free.push(index);
                        }
                    }
                    parameters.push(index);
                }
                let states = memory_channels(c, k, &name, effect.as_ref(), *place, model);
                let memory_from = (!states.is_empty()).then_some(states);
                big.terms.push(Term { effect: effect.clone(), place: *place, parameters, blend, memory_from });
            }
            let per_run = free.iter().any(|p| big.parameters[*p].spec.per_run);
            let parameters = match blend {
                Some(blend) => vec![blend],
                None => free,
            };
            planned.push(Planned { candidate: c, probe: k, per_run, parameters });
        }
    }
    (big, planned)
}

/// Names of the channels that hold the memory of a probe.
fn memory_channels(
    candidate: usize,
    probe: usize,
    name: &str,
    effect: &dyn crate::effects::Effect,
    place: crate::effects::Place,
    model: &Model,
) -> Vec<String> {
    let graph = crate::symbolic::Graph::new();
    let count = crate::chain::memory_count(&graph, model, effect, place);
    (0..count).map(|i| format!("memory {candidate}.{probe} {name} {i}")).collect()
}

/// The runs with the memory of every probe, computed from the log: at zero strength a candidate's memory follows the
/// motion but does not act on it.
///
/// Memories of sensor effects are computed from the previous samples: a memory that contains the noise of the sample
/// which it is to explain would explain it. Where a log has poses alone, memories follow their slopes, which lie on both sides
/// of a sample and hold none of its noise.
pub(super) fn remembered(
    model: &Model,
    runs: &[Run],
    candidates: &[Candidate],
    options: &OutputErrorOptions,
) -> Result<Vec<Run>, TrackError> {
    let of_sensors = |c: &Candidate| c.family() == Family::Sensor;
    let moving = velocities_from_poses(model, runs);
    let mut before: Vec<Run> = runs.iter().map(a_sample_late).collect();
    for (before, moving) in before.iter_mut().zip(&moving) {
        for (name, slope) in &moving.signals {
            before.signals.entry(name.clone()).or_insert_with(|| slope.clone());
        }
    }
    let mut remembered = runs.to_vec();
    for listened in [
        listened(model, &moving, candidates, &|c| !of_sensors(c), options)?,
        listened(model, &before, candidates, &of_sensors, options)?,
    ] {
        for (run, channels) in remembered.iter_mut().zip(listened) {
            run.signals.extend(channels);
        }
    }
    Ok(remembered)
}

/// The run with every measured velocity and position delayed by one sample.
fn a_sample_late(run: &Run) -> Run {
    let mut late = run.clone();
    for name in Dof::ALL.iter().flat_map(|dof| [dof.velocity(), dof.position()]) {
        if let Some(signal) = late.signals.get_mut(name).filter(|s| !s.is_empty()) {
            let values = signal.values();
            let before: Vec<f64> =
                std::iter::once(values[0]).chain(values.iter().copied()).take(values.len()).collect();
            *signal = Signal::new(signal.shared_time().clone(), before);
        }
    }
    late
}

/// The memory of every probe of the candidates that satisfy `asked`, by its channel, for each run.
fn listened(
    model: &Model,
    runs: &[Run],
    candidates: &[Candidate],
    asked: &dyn Fn(&Candidate) -> bool,
    options: &OutputErrorOptions,
) -> Result<Vec<Vec<(String, Signal)>>, TrackError> {
    let mut listening = model.clone();
    listening.terms.retain(|t| t.effect.about().family == Family::Actuator);
    let mut channels: Vec<(u16, Vec<String>)> = Vec::new();
    for (c, candidate) in candidates.iter().enumerate().filter(|(_, c)| asked(c)) {
        for (k, probe) in candidate.probes.iter().enumerate() {
            for (effect, place) in &candidate.terms {
                let name = name_of(effect.about().id, *place);
                let names = memory_channels(c, k, &name, effect.as_ref(), *place, model);
                if names.is_empty() {
                    continue;
                }
                let mut shapes = probe.iter();
                let parameters = effect
                    .parameters(*place)
                    .into_iter()
                    .map(|spec| {
                        let shape = if spec.is_linear() { None } else { shapes.next() };
                        let index = listening.push_parameter(&name, effect.about().id, *place, spec);
                        if let Some(value) = shape {
                            listening.parameters[index].value = *value;
                        }
                        index
                    })
                    .collect();
                channels.push((listening.terms.len() as u16, names));
                let spec = crate::effects::ParameterSpec::linear("blend", crate::units::Dimension::ONE);
                let blend = listening.push_parameter(&name, "blend", *place, spec);
                listening.terms.push(Term {
                    effect: effect.clone(),
                    place: *place,
                    parameters,
                    blend: Some(blend),
                    memory_from: None,
                });
            }
        }
    }
    let mut heard: Vec<Vec<(String, Signal)>> = vec![Vec::new(); runs.len()];
    if channels.is_empty() {
        return Ok(heard);
    }
    let all = super::common_channels(runs);
    let attitude = Attitude::of(model, runs);
    let available = Available { channels: all, from_log: true, attitude, ..Available::default() };
    let dynamics = Dynamics::compile(&listening, &available, &std::collections::BTreeSet::new(), &[]);
    for (index, (run, heard)) in runs.iter().zip(&mut heard).enumerate() {
        let theta = values_in_run(&listening, index);
        let track = Track::new(run, index, &dynamics, &theta, listening.input, options.longest_step_of_quick_motion())?;
        let mut time: Vec<f64> = Vec::new();
        let mut rows: Vec<f64> = Vec::new();
        for (i, begin) in track.starts.iter().enumerate() {
            let end = track.starts.get(i + 1).copied().unwrap_or(track.time.len()) - 1;
            let trajectory = free_run(&dynamics, &track, &theta, &[], *begin, end);
            time.extend(trajectory.time);
            rows.extend(trajectory.states);
        }
        let time: std::sync::Arc<[f64]> = time.into();
        let width = dynamics.states.len();
        for (column, state) in dynamics.states.iter().enumerate() {
            let StateId::Memory { term, index } = *state else { continue };
            let Some((_, names)) = channels.iter().find(|(t, _)| *t == term) else { continue };
            let values: Vec<f64> = rows.iter().skip(column).step_by(width).copied().collect();
            heard.push((names[usize::from(index)].clone(), Signal::new(time.clone(), values)));
        }
    }
    Ok(heard)
}
