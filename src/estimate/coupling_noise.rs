//! The effect of velocity noise on balances that share their inertias, and its removal.
//!
//! ```text
//! κ = (E Σ c′² − Σ c²) / Σ c²
//! c′: the column c of the same run with as much noise added once more to its velocities
//! c ← (1 − κ) c                      columns of shared inertias, run by run, 0 ≤ κ ≤ 1
//! θ ← θ − (E θ′ − θ)       θ′: the estimates from runs with as much noise added once more
//! ```
//!
//! With tied Coriolis terms, an inertia stands in the balances of other degrees of freedom,
//! multiplied by the product of two velocities. If a run moves one degree of freedom alone, that
//! product is the noise of another one: κ is near 1, and least squares pulls the coefficient of the
//! column towards zero, in all balances that share it (m_v − m_u = 0.3 for 4.9 kg). The part of a
//! column that is not noise is the best estimate of the true column: regression calibration
//! (Carroll, Ruppert, Stefanski and Crainiceanu, *Measurement Error in Nonlinear Models*, 2nd ed.
//! 2006, chapter 4). The remaining bias grows with the variance of the noise: adding the noise once
//! more shows the bias once more, and it is subtracted (chapter 5, simulation extrapolation).
//! Without noise nothing changes.

use std::collections::BTreeSet;
use std::ops::Range;

use rayon::prelude::*;

use super::balance::RegressorError;
use super::regressor::{Columns, RegressorOptions, regressors_of};
use crate::check::samples::Samples;
use crate::frame::Dof;
use crate::model::Model;
use crate::noise::Noise;
use crate::run::{Run, Signal};

/// Number of draws of the noise. A few are enough for a mean of squares over some hundred rows, and
/// for estimates that lie within their standard deviations of each other.
const DRAWS: u64 = 3;

/// Balances that share free parameters, each with its rows.
pub(super) type Members = Vec<(Dof, Columns)>;

/// The rows of balances from runs to which as much noise is added once more, one for each draw;
/// empty if the runs show no noise.
///
/// # Errors
/// Those of the rows.
pub(super) fn shaken(
    members: &[(Dof, Columns)],
    runs: &[&Run],
    model: &Model,
    options: RegressorOptions,
) -> Result<Vec<Members>, RegressorError> {
    let sigmas: Vec<Vec<f64>> = runs.iter().map(|run| sigmas(run, model)).collect();
    if sigmas.iter().flatten().all(|sigma| *sigma <= 0.0) {
        return Ok(Vec::new());
    }
    let one = |draw: u64| {
        let runs: Vec<Run> = (0..runs.len()).map(|k| with_noise(runs[k], model, &sigmas[k], (draw, k))).collect();
        let runs: Vec<&Run> = runs.iter().collect();
        members.iter().map(|(dof, _)| Ok((*dof, regressors_of(*dof, &runs, model, options)?))).collect()
    };
    (0..DRAWS).into_par_iter().map(one).collect()
}

/// Rows of one column, and the part of the sum of their squares that is noise.
pub(super) struct Noisy {
    column: usize,
    rows: Range<usize>,
    noise: f64,
}

/// The noise in the columns of shared inertias, by balance and run, as the `shaken` rows show it;
/// `own` is the inertia of each balance. A parameter that is no balance's own inertia keeps its
/// columns, because nothing else determines it.
pub(super) fn noise_of(members: &[(Dof, Columns)], own: &[Option<usize>], shaken: &[Members]) -> Vec<Vec<Noisy>> {
    let inertias: BTreeSet<usize> = own.iter().copied().flatten().collect();
    let of = |k: usize| -> Vec<Noisy> {
        let columns = &members[k].1;
        let shared = |c: &usize| {
            let parameter = columns.parameters[*c].parameter;
            inertias.contains(&parameter) && own[k] != Some(parameter)
        };
        let shared: Vec<usize> = (0..columns.parameters.len()).filter(shared).collect();
        let noise = |column: usize, rows: &Range<usize>| {
            let with = shaken.iter().map(|all| squares(&all[k].1, column, rows)).sum::<f64>() / shaken.len() as f64;
            with - squares(columns, column, rows)
        };
        let blocks = columns.blocks.iter().map(|block| block.rows.clone());
        let one = |rows: Range<usize>, column: usize| Noisy { column, noise: noise(column, &rows), rows };
        blocks.flat_map(|rows| shared.iter().map(move |c| (rows.clone(), *c))).map(|(r, c)| one(r, c)).collect()
    };
    (0..members.len()).map(of).collect()
}

/// Scales the columns by the part of them that is not noise; the rows hold `times` as much noise as
/// [`noise_of`] has found.
pub(super) fn calibrate(members: &mut [(Dof, Columns)], noise: &[Vec<Noisy>], times: f64) {
    for ((_, columns), noisy) in members.iter_mut().zip(noise) {
        for Noisy { column, rows, noise } in noisy {
            let seen = squares(columns, *column, rows);
            let kept = if seen > 0.0 { (1.0 - times * noise / seen).clamp(0.0, 1.0) } else { 1.0 };
            columns.columns[*column][rows.clone()].iter_mut().for_each(|c| *c *= kept);
        }
    }
}

fn squares(columns: &Columns, column: usize, rows: &Range<usize>) -> f64 {
    columns.columns[column][rows.clone()].iter().map(|c| c * c).sum()
}

/// Noise of the velocity of each degree of freedom of the model, estimated from the run's own
/// samples; 0 if it is not logged.
fn sigmas(run: &Run, model: &Model) -> Vec<f64> {
    let of = |dof: &Dof| run.signal(dof.velocity()).and_then(Samples::of).map_or(0.0, |samples| samples.noise());
    model.dofs.iter().map(of).collect()
}

/// The run with white noise of these standard deviations on the velocities of the model; `draw` and
/// `number` (of the run) choose the noise.
fn with_noise(run: &Run, model: &Model, sigmas: &[f64], (draw, number): (u64, usize)) -> Run {
    let mut with = run.clone();
    for (dof, sigma) in model.dofs.iter().zip(sigmas).filter(|(_, sigma)| **sigma > 0.0) {
        let Some(signal) = run.signal(dof.velocity()) else { continue };
        let mut noise = Noise::new(draw, (number * Dof::ALL.len() + dof.index()) as u64);
        let values: Vec<f64> = signal.values().iter().map(|value| value + sigma * noise.normal()).collect();
        with.signals.insert(dof.velocity().into(), Signal::new(signal.shared_time().clone(), values));
    }
    with
}
