//! All candidates scored at once.
//!
//! ```text
//! z = ∂y/∂α at α = 0      what a little of the candidate would add to the log
//! z̃ = z less its projection on the initial states of each segment and on ∂y/∂θ of what is in the model
//! S = z̃ᵀr,  I = z̃ᵀz̃      explained = Sᵀ I⁻¹ S, in units of the noise; β = I⁻¹ S
//! ```
//!
//! One integration of the sensitivities of a model in which every candidate stands with its parameter at zero gives
//! all z. Products with the residual r and with ∂y/∂θ are summed segment by segment, so that no column is kept.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::candidate::Candidate;
use super::carried::{available_of, carried};
use crate::chain::{Available, StateId};
use crate::dynamics::Dynamics;
use crate::estimate::output_error::{LANES, OutputErrorFit, OutputErrorOptions, Problem};
use crate::model::{Model, Term, name_of};
use crate::progress;
use crate::run::{Run, Signal};
use crate::simulate::{Emission, Track, TrackError, free_run, integrate, values_in_run, widest};

/// Columns that are integrated together: as many as keep the sensitivities in the second-level cache.
const CHUNK: usize = 96;

/// A probe of a candidate: its columns and what they say, segment by segment.
#[derive(Debug, Clone)]
pub struct Probe {
    /// Index of the candidate.
    pub candidate: usize,
    /// Index of the probe in the candidate.
    pub probe: usize,
    /// Whether the columns have a value of their own in each run.
    pub per_run: bool,
    /// Products of each segment.
    pub segments: Vec<Products>,
}

/// Products of the `k` columns z of one probe in one segment, initial states projected out.
#[derive(Debug, Clone, Default)]
pub struct Products {
    /// z̃ᵀz̃, k × k.
    pub zz: Vec<f64>,
    /// z̃ᵀr, k.
    pub zr: Vec<f64>,
    /// Xᵀz̃, p × k; X: sensitivities of the model's own unknowns, by direction.
    pub xz: Vec<f64>,
    /// Σ z², k: before anything is projected out.
    pub raw: Vec<f64>,
}

/// The model's own products of one segment, initial states projected out.
#[derive(Debug, Clone, Default)]
pub struct Own {
    /// XᵀX, by direction.
    pub xx: Vec<f64>,
    /// Xᵀr.
    pub xr: Vec<f64>,
    /// rᵀr.
    pub rr: f64,
}

/// A candidate's columns in the big model.
struct Planned {
    candidate: usize,
    probe: usize,
    per_run: bool,
    parameters: Vec<usize>,
}

/// Scores `candidates` at the fit: the products of every probe, and the model's own.
///
/// # Errors
/// [`TrackError`] when a run lacks what a candidate reads.
pub fn score(
    fit: &OutputErrorFit,
    runs: &[Run],
    candidates: &[Candidate],
    options: &OutputErrorOptions,
) -> Result<(Vec<Probe>, Vec<Own>), TrackError> {
    let runs = remembered(&fit.model, runs, candidates, options)?;
    let (big, mut planned) = enlarge(&fit.model, candidates);
    let carried = carried(fit, candidates, &super::common_channels(&runs));
    planned.retain(|plan| carried[plan.candidate]);
    let mut chunks: Vec<Vec<&Planned>> = vec![Vec::new()];
    let mut filled = 0;
    for plan in &planned {
        if filled + plan.parameters.len() > CHUNK && filled > 0 {
            chunks.push(Vec::new());
            filled = 0;
        }
        filled += plan.parameters.len();
        chunks.last_mut().expect("there is a first chunk").push(plan);
    }
    let (parts, done) = (chunks.len(), AtomicUsize::new(0));
    let results: Vec<(Vec<Probe>, Vec<Own>)> = chunks
        .into_par_iter()
        .map(|chunk| {
            progress::tell(format!("judging {} candidates", candidates.len()), done.load(Ordering::Relaxed), parts);
            let scored = score_chunk(fit, &runs, &big, &chunk, options);
            done.fetch_add(1, Ordering::Relaxed);
            scored
        })
        .collect::<Result<_, _>>()?;
    let mut probes = Vec::new();
    let mut own = Vec::new();
    for (part, model) in results {
        probes.extend(part);
        own = model;
    }
    Ok((probes, own))
}

/// The model with every probe of every candidate in it, its linear parameters at their neutral values.
fn enlarge(model: &Model, candidates: &[Candidate]) -> (Model, Vec<Planned>) {
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

/// The runs with the memory of every probe computed from the log: at zero strength a candidate's memory listens to the
/// motion but does not act on it.
fn remembered(
    model: &Model,
    runs: &[Run],
    candidates: &[Candidate],
    options: &OutputErrorOptions,
) -> Result<Vec<Run>, TrackError> {
    let mut listening = model.clone();
    listening.terms.retain(|t| t.effect.about().family == crate::effects::Family::Actuator);
    let mut channels: Vec<(u16, Vec<String>)> = Vec::new();
    for (c, candidate) in candidates.iter().enumerate() {
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
    let mut runs = runs.to_vec();
    if channels.is_empty() {
        return Ok(runs);
    }
    let all = super::common_channels(&runs);
    let available = Available { channels: all, position: false, from_log: true };
    let dynamics = Dynamics::compile(&listening, &available, &std::collections::BTreeSet::new(), &[]);
    for (index, run) in runs.iter_mut().enumerate() {
        let theta = values_in_run(&listening, index);
        let track = Track::new(run, index, &dynamics, &theta, listening.input, options.longest_step)?;
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
            run.signals.insert(names[usize::from(index)].clone(), Signal::new(time.clone(), values));
        }
    }
    Ok(runs)
}

fn score_chunk(
    fit: &OutputErrorFit,
    runs: &[Run],
    big: &Model,
    chunk: &[&Planned],
    options: &OutputErrorOptions,
) -> Result<(Vec<Probe>, Vec<Own>), TrackError> {
    // only this chunk's terms are compiled
    let own = fit.problem.dynamics.directions.clone();
    let columns: Vec<usize> = chunk.iter().flat_map(|p| p.parameters.iter().copied()).collect();
    let mut model = big.clone();
    let base = fit.model.terms.len();
    let mut index = 0;
    model.terms.retain(|t| {
        index += 1;
        index <= base || t.parameters.iter().chain(t.blend.iter()).any(|p| columns.contains(p))
    });
    let directions: Vec<usize> = own.iter().copied().chain(columns.iter().copied()).collect();
    let available = Available { channels: super::common_channels(runs), ..available_of(&fit.problem) };
    let observed = fit.problem.dynamics.outputs.iter().cloned().collect();
    let dynamics = Dynamics::compile(&model, &available, &observed, &directions);
    debug_assert_eq!(dynamics.states, fit.problem.dynamics.states, "candidates at zero add no state");
    let tracks = runs
        .iter()
        .enumerate()
        .map(|(k, run)| Track::new(run, k, &dynamics, &values_in_run(&model, k), model.input, options.longest_step))
        .collect::<Result<Vec<_>, _>>()?;
    let problem = Problem { dynamics, tracks, ..fit.problem.clone() };
    let order: Vec<usize> = (0..problem.segments.len()).collect();
    let batches: Vec<&[usize]> = order.chunks(LANES).collect();
    let groups: Vec<usize> = chunk.iter().map(|p| p.parameters.len()).collect();
    let parts: Vec<Vec<(Own, Vec<Products>)>> = batches
        .into_par_iter()
        .map(|batch| {
            widest(
                #[inline(always)]
                || batch_products::<LANES>(&problem, &model, &fit.initial_states, batch, own.len(), &groups),
            )
        })
        .collect();
    let mut probes: Vec<Probe> = chunk
        .iter()
        .map(|p| Probe { candidate: p.candidate, probe: p.probe, per_run: p.per_run, segments: Vec::new() })
        .collect();
    let mut model_products = Vec::new();
    for (own, products) in parts.into_iter().flatten() {
        model_products.push(own);
        for (probe, products) in probes.iter_mut().zip(products) {
            probe.segments.push(products);
        }
    }
    Ok((probes, model_products))
}

/// Products of one batch of segments: for each segment the model's own and those of each group of columns.
#[inline(always)]
fn batch_products<const L: usize>(
    problem: &Problem,
    model: &Model,
    x0: &[Vec<f64>],
    batch: &[usize],
    own: usize,
    groups: &[usize],
) -> Vec<(Own, Vec<Products>)> {
    let nx = problem.dynamics.states.len();
    let candidates: usize = groups.iter().sum();
    let width = nx + own + candidates;
    // left: initial states, own directions, residual; right: candidates
    let left = nx + own + 1;
    let mut ll = vec![[0.0; L]; left * left];
    let mut lr = vec![[0.0; L]; left * candidates];
    let inner: usize = groups.iter().map(|k| k * k).sum();
    let mut rr = vec![[0.0; L]; inner];
    let (stretches, theta, start) = problem.lanes::<L>(model, x0, batch);
    let mut row = vec![[0.0; L]; left];
    integrate(&problem.dynamics, &problem.tracks, &stretches, &theta, &start, true, &mut |at: &Emission<'_, L>| {
        for output in 0..problem.dynamics.outputs.len() {
            let (mut weight, mut residual) = ([0.0; L], [0.0; L]);
            for lane in 0..L {
                let measured = problem.measured(&stretches, at.grid, lane, output);
                if !measured.is_nan() {
                    weight[lane] = 1.0 / problem.sigma[output];
                    residual[lane] = (measured - at.outputs[output][lane]) * weight[lane];
                }
            }
            let jacobian = &at.jacobian[output * width..(output + 1) * width];
            // rows are scaled once: w² z = w (w z)
            for (to, from) in row.iter_mut().zip(&jacobian[..nx + own]) {
                for lane in 0..L {
                    to[lane] = from[lane] * weight[lane];
                }
            }
            row[left - 1] = residual;
            for i in 0..left {
                for j in i..left {
                    for lane in 0..L {
                        ll[i * left + j][lane] += row[i][lane] * row[j][lane];
                    }
                }
                let scaled: [f64; L] = std::array::from_fn(|lane| row[i][lane] * weight[lane]);
                let right = &mut lr[i * candidates..(i + 1) * candidates];
                for (to, z) in right.iter_mut().zip(&jacobian[nx + own..]) {
                    for lane in 0..L {
                        to[lane] += scaled[lane] * z[lane];
                    }
                }
            }
            let (mut first, mut at_group) = (nx + own, 0);
            for k in groups {
                for a in 0..*k {
                    for b in 0..*k {
                        let (za, zb) = (jacobian[first + a], jacobian[first + b]);
                        for lane in 0..L {
                            rr[at_group + a * k + b][lane] += za[lane] * zb[lane] * weight[lane] * weight[lane];
                        }
                    }
                }
                first += k;
                at_group += k * k;
            }
        }
    });
    (0..batch.len())
        .map(|lane| {
            let pick = |table: &[[f64; L]]| table.iter().map(|x| x[lane]).collect::<Vec<f64>>();
            project(&pick(&ll), &pick(&lr), &pick(&rr), nx, own, groups)
        })
        .collect()
}

/// Projects the first `nx` columns out of all products, one column after the other (Cholesky on the left block).
fn project(ll: &[f64], lr: &[f64], rr: &[f64], nx: usize, own: usize, groups: &[usize]) -> (Own, Vec<Products>) {
    let left = nx + own + 1;
    let candidates: usize = groups.iter().sum();
    let (mut ll, mut lr, mut rr) = (ll.to_vec(), lr.to_vec(), rr.to_vec());
    let raw: Vec<f64> = diagonal(&rr, groups);
    for s in 0..nx {
        let pivot = ll[s * left + s];
        let size = pivot.abs();
        if size < 1e-12 {
            continue;
        }
        let (head, tail) = (ll[s * left..(s + 1) * left].to_vec(), lr[s * candidates..(s + 1) * candidates].to_vec());
        for i in s + 1..left {
            let factor = head[i] / pivot;
            for j in i..left {
                ll[i * left + j] -= factor * head[j];
            }
            for (to, z) in lr[i * candidates..(i + 1) * candidates].iter_mut().zip(&tail) {
                *to -= factor * z;
            }
        }
        let (mut first, mut at) = (0, 0);
        for k in groups {
            for a in 0..*k {
                for b in 0..*k {
                    rr[at + a * k + b] -= tail[first + a] * tail[first + b] / pivot;
                }
            }
            first += k;
            at += k * k;
        }
    }
    let upper = |i: usize, j: usize| ll[(nx + i.min(j)) * left + nx + i.max(j)];
    let model = Own {
        xx: (0..own * own).map(|k| upper(k / own, k % own)).collect(),
        xr: (0..own).map(|i| upper(i, own)).collect(),
        rr: upper(own, own),
    };
    let (mut first, mut at) = (0, 0);
    let products = groups
        .iter()
        .map(|k| {
            let column = |i: usize| (0..*k).map(|a| lr[(nx + i) * candidates + first + a]).collect::<Vec<f64>>();
            let result = Products {
                zz: rr[at..at + k * k].to_vec(),
                zr: column(own),
                xz: (0..own).flat_map(column).collect(),
                raw: raw[first..first + k].to_vec(),
            };
            first += k;
            at += k * k;
            result
        })
        .collect();
    (model, products)
}

fn diagonal(rr: &[f64], groups: &[usize]) -> Vec<f64> {
    let mut at = 0;
    let mut all = Vec::new();
    for k in groups {
        all.extend((0..*k).map(|a| rr[at + a * k + a]));
        at += k * k;
    }
    all
}
