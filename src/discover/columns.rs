//! Derivatives of the innovations with respect to the strength of every candidate.
//!
//! ```text
//! [G g e]ᵀ[G g e]      G = ∂e/∂θ /√s of what is in the model,  g = ∂e/∂α /√s of the candidates at α = 0,  e: e/√s
//! ```
//!
//! One pass of the filter carries the sensitivities of a model that contains the candidates with their parameters at
//! zero. Products are summed stretch by stretch, so that no column is stored.

use std::ops::Range;

use faer::Mat;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::candidate::Candidate;
use super::enlarged::{Planned, enlarge, remembered};
use super::simulated_states::{available_of, carried};
use crate::chain::Available;
use crate::dynamics::Dynamics;
use crate::estimate::filter_error::{FilterErrorFit, Filtered, NoiseModel};
use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions, Problem};
use crate::model::Model;
use crate::navigation::upright::with_quaternion;
use crate::run::Run;
use crate::simulate::{Track, values_in_run};

/// Maximum number of columns that are filtered together, so that the sensitivities fit into the second-level cache.
const CHUNK: usize = 96;

/// A model, its noise and the runs along which it is filtered.
#[derive(Debug, Clone, Copy)]
pub struct ModelOnRuns<'a> {
    /// The prepared runs.
    pub filtered: &'a Filtered,
    /// The model.
    pub model: &'a Model,
    /// Noise model.
    pub noise: &'a NoiseModel,
    /// Limit in standard deviations at which innovations are clipped.
    pub limit: f64,
}

impl<'a> From<&'a FilterErrorFit> for ModelOnRuns<'a> {
    fn from(fit: &'a FilterErrorFit) -> ModelOnRuns<'a> {
        ModelOnRuns { filtered: &fit.filtered, model: &fit.model, noise: &fit.noise, limit: fit.limit }
    }
}

/// The columns of one probe of a candidate.
#[derive(Debug, Clone, Copy)]
pub struct Probe {
    /// Index of the candidate.
    pub candidate: usize,
    /// Index of the probe in the candidate.
    pub probe: usize,
    /// Whether the columns have a value of their own in each run.
    pub per_run: bool,
    /// Number of columns.
    pub width: usize,
}

impl From<&Planned> for Probe {
    fn from(p: &Planned) -> Probe {
        Probe { candidate: p.candidate, probe: p.probe, per_run: p.per_run, width: p.parameters.len() }
    }
}

/// Candidates that are filtered together.
#[derive(Debug, Clone)]
pub struct Columns {
    /// The probes, in the order of their columns.
    pub probes: Vec<Probe>,
    /// Products of each stretch, square: the model's own directions, the probes' columns, the innovation.
    pub products: Vec<Mat<f64>>,
}

/// The products of all stretches, over the unknowns of the fit, the columns of each probe, and the innovation.
pub(super) struct Assembled<'a> {
    /// Square, priors included.
    pub total: DMatrix<f64>,
    /// Number of unknowns of the fit, which come first.
    pub unknowns: usize,
    /// Each probe and the range of its columns: one set, or one per run.
    pub probes: Vec<(&'a Probe, Range<usize>)>,
}

impl Columns {
    /// Assembles the products of columns that were computed at `fit`.
    pub(super) fn assembled(&self, fit: &FilterErrorFit) -> Assembled<'_> {
        let problem = &fit.filtered.problem;
        let (own, unknowns) = (problem.dynamics.directions.len(), problem.unknowns.len());
        let runs_of: Vec<usize> = problem.segments.iter().map(|s| problem.tracks[s.track].run).collect();
        let count = runs_of.iter().max().map_or(0, |r| r + 1);
        let (mut next, mut probes) = (unknowns, Vec::new());
        let mut places: Vec<(usize, bool)> = Vec::new();
        for probe in &self.probes {
            let each = if probe.per_run { count } else { 1 };
            places.extend((0..probe.width).map(|c| (next + c * each, probe.per_run)));
            probes.push((probe, next..next + probe.width * each));
            next += probe.width * each;
        }
        let e = next;
        let mut total = DMatrix::<f64>::zeros(e + 1, e + 1);
        for (stretch, product) in self.products.iter().enumerate() {
            let mut of: Vec<usize> = problem.columns_of(problem.segments[stretch].track);
            of.extend(places.iter().map(|(at, per_run)| if *per_run { at + runs_of[stretch] } else { *at }));
            of.push(e);
            debug_assert_eq!(of.len(), own + places.len() + 1, "a column for each direction, and the innovation");
            for (j, to_j) in of.iter().enumerate() {
                for (i, to_i) in of.iter().enumerate() {
                    total[(*to_i, *to_j)] += product[(i, j)];
                }
            }
        }
        fit.priors().for_each(|(k, information)| total[(k, k)] += information);
        Assembled { total, unknowns, probes }
    }
}

/// Filters all candidates that `at` can carry in chunks, and passes each chunk to `take` with its number.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub fn in_chunks<T: Send>(
    at: ModelOnRuns<'_>,
    runs: &[Run],
    candidates: &[Candidate],
    fitting: &OutputErrorOptions,
    take: impl Fn(usize, Columns) -> T + Sync,
) -> Result<Vec<T>, OutputErrorError> {
    let (runs, big, planned) = prepared(at, runs, candidates, fitting)?;
    let mut chunks: Vec<Vec<&Planned>> = Vec::new();
    let mut filled = CHUNK;
    for plan in &planned {
        filled += plan.parameters.len();
        if filled > CHUNK {
            chunks.push(Vec::new());
            filled = plan.parameters.len();
        }
        if let Some(last) = chunks.last_mut() {
            last.push(plan);
        }
    }
    let one = |(k, chunk): (usize, &Vec<&Planned>)| {
        let products = products(at, &runs, &big, chunk, fitting)?;
        Ok(take(k, Columns { probes: chunk.iter().map(|p| Probe::from(*p)).collect(), products }))
    };
    chunks.par_iter().enumerate().map(one).collect()
}

/// The runs with the candidates' memories, the model with all candidates, and those candidates that `at` can carry.
fn prepared(
    at: ModelOnRuns<'_>,
    runs: &[Run],
    candidates: &[Candidate],
    fitting: &OutputErrorOptions,
) -> Result<(Vec<Run>, Model, Vec<Planned>), OutputErrorError> {
    let upright = at.filtered.problem.dynamics.quaternion().is_some();
    let runs: Vec<Run> = if upright { runs.iter().map(with_quaternion).collect() } else { runs.to_vec() };
    let runs = remembered(at.model, &runs, candidates, fitting)?;
    let (big, mut planned) = enlarge(at.model, candidates);
    let carried = carried(&at.filtered.problem, at.model, candidates, &super::common_channels(&runs));
    planned.retain(|plan| carried[plan.candidate]);
    Ok((runs, big, planned))
}

/// Candidates that are filtered together, block by block.
pub(super) struct InBlocks {
    /// The probes, in the order of their columns.
    pub probes: Vec<Probe>,
    /// Products of each block of each stretch, as those of [`Columns`].
    pub products: Vec<Vec<Mat<f64>>>,
}

/// Products of each block of `rows` samples of each stretch, with all candidates that `at` can carry. Each candidate
/// has one probe and one column; these follow the model's own directions in the order of the probes.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub(super) fn in_blocks(
    at: ModelOnRuns<'_>,
    runs: &[Run],
    candidates: &[Candidate],
    fitting: &OutputErrorOptions,
    rows: usize,
) -> Result<InBlocks, OutputErrorError> {
    let (runs, big, planned) = prepared(at, runs, candidates, fitting)?;
    let chunk: Vec<&Planned> = planned.iter().collect();
    let (filtered, model) = with_chunk(at, &runs, &big, &chunk, fitting)?;
    let products = filtered.products_in_blocks(&model, at.noise, at.limit, rows);
    Ok(InBlocks { probes: chunk.into_iter().map(Probe::from).collect(), products })
}

/// Products of each stretch for the model with this chunk of candidates; none if the inertia is singular.
fn products(
    at: ModelOnRuns<'_>,
    runs: &[Run],
    big: &Model,
    chunk: &[&Planned],
    fitting: &OutputErrorOptions,
) -> Result<Vec<Mat<f64>>, OutputErrorError> {
    let (filtered, model) = with_chunk(at, runs, big, chunk, fitting)?;
    let Some(mobilities) = at.filtered.mobilities(at.model) else { return Ok(Vec::new()) };
    Ok(filtered.products(&model, at.noise, &mobilities, at.limit))
}

/// The runs prepared for the model with this chunk of candidates, and that model.
fn with_chunk(
    at: ModelOnRuns<'_>,
    runs: &[Run],
    big: &Model,
    chunk: &[&Planned],
    fitting: &OutputErrorOptions,
) -> Result<(Filtered, Model), OutputErrorError> {
    // only this chunk's terms are compiled
    let problem = &at.filtered.problem;
    let columns: Vec<usize> = chunk.iter().flat_map(|p| p.parameters.iter().copied()).collect();
    let mut model = big.clone();
    let (base, mut index) = (at.model.terms.len(), 0);
    model.terms.retain(|t| {
        index += 1;
        index <= base || t.parameters.iter().chain(t.blend.iter()).any(|p| columns.contains(p))
    });
    let directions: Vec<usize> = problem.dynamics.directions.iter().chain(&columns).copied().collect();
    let available = Available { channels: super::common_channels(runs), ..available_of(problem) };
    let observed = problem.dynamics.outputs.iter().cloned().collect();
    let dynamics = Dynamics::compile(&model, &available, &observed, &directions);
    let mut tracks = Vec::new();
    for (k, (run, known)) in runs.iter().zip(&problem.tracks).enumerate() {
        let theta = values_in_run(&model, k);
        let longest = fitting.longest_step_of_quick_motion();
        let mut track = Track::new(run, k, &dynamics, &theta, model.input, longest)?;
        if track.follow(known.longest().iter().copied()) {
            track.read_inputs(&dynamics, &theta);
        }
        tracks.push(track);
    }
    Ok((at.filtered.with_problem(Problem { dynamics, tracks, ..problem.clone() }), model))
}
