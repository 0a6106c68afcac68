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
use super::enlarged::{Planned, enlarge, remembered};
use super::products::{Own, Products, Summing};
use super::thin::{STEP, Thin};
use crate::chain::Available;
use crate::dynamics::Dynamics;
use crate::estimate::output_error::{LANES, OutputErrorFit, OutputErrorOptions, Problem, longest_step};
use crate::model::Model;
use crate::navigation::upright::with_quaternion;
use crate::progress;
use crate::run::Run;
use crate::simulate::{Track, TrackError, values_in_run};
use crate::wide::{Machine, Widths as _};

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
    let upright = fit.problem.dynamics.quaternion().map(|_| runs.iter().map(with_quaternion).collect::<Vec<_>>());
    let runs = upright.as_deref().unwrap_or(runs);
    let mut runs = remembered(&fit.model, runs, candidates, options)?;
    let thin = Thin::new(fit, &mut runs, STEP);
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
            let scored = score_chunk(fit, &runs, &thin, &big, &chunk, options);
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

fn score_chunk(
    fit: &OutputErrorFit,
    runs: &[Run],
    thin: &Thin,
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
    // only a memory that is quicker than that needs shorter steps
    let longest = match longest_step(&fit.model, options) {
        quick if quick < options.longest_step => quick,
        usual => usual.max(STEP),
    };
    let tracks = runs
        .iter()
        .enumerate()
        .map(|(k, run)| Track::new(run, k, &dynamics, &values_in_run(&model, k), model.input, longest))
        .collect::<Result<Vec<_>, _>>()?;
    let problem = Problem {
        dynamics,
        tracks,
        segments: thin.segments.clone(),
        sigma: fit.problem.sigma.clone(),
        unknowns: fit.problem.unknowns.clone(),
        loss: fit.problem.loss,
    };
    let order: Vec<usize> = (0..problem.segments.len()).collect();
    let batches: Vec<&[usize]> = order.chunks(LANES).collect();
    let groups: Vec<usize> = chunk.iter().map(|p| p.parameters.len()).collect();
    let parts: Vec<Vec<(Own, Vec<Products>)>> = batches
        .into_par_iter()
        .map(|batch| {
            let (problem, model, x0, groups) = (&problem, &model, &fit.initial_states[..], &groups[..]);
            Machine::widest(Summing { problem, thin, model, x0, batch, own: own.len(), groups })
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
