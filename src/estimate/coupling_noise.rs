//! What the noise of the velocities does to balances that share their inertias, and how it is taken away.
//!
//! ```text
//! κ = (E Σ c′² − Σ c²) / Σ c²        c′: the column c of the same run with as much noise on its velocities once more
//! c ← (1 − κ) c                      columns of shared inertias, run by run, 0 ≤ κ ≤ 1
//! θ ← θ − (E θ′ − θ)                 θ′: the estimates from runs with as much noise once more
//! ```
//!
//! Under tied Coriolis terms an inertia stands in the balances of others with the product of two velocities. Where a run
//! moves one degree of freedom alone, that product is the noise of another one: κ is near 1, and least squares pulls what
//! the column multiplies towards zero, in all balances that share it (m_v − m_u = 0.3 for 4.9 kg). The part that is no
//! noise is the best that is known of the true column: regression calibration (Carroll, Ruppert, Stefanski and Crainiceanu,
//! *Measurement Error in Nonlinear Models*, 2nd ed. 2006, chapter 4). What bias is left grows with the variance of the
//! noise: noise added once more shows it once more, and it is taken off (chapter 5, simulation extrapolation). Without
//! noise nothing changes.

use std::collections::BTreeSet;
use std::ops::Range;

use super::regressor::{Columns, RegressorOptions, regressors_of};
use crate::check::samples::Samples;
use crate::frame::Dof;
use crate::model::Model;
use crate::noise::Noise;
use crate::run::{Run, Signal};

/// Draws of the noise: a mean of squares over some hundred rows, and of estimates that lie within their deviations of each
/// other, is known well enough by few.
pub(super) const DRAWS: u64 = 4;

/// Scales the columns of shared inertias by what is no noise in them; `own` is the inertia of each balance. A parameter that
/// no balance has as its own inertia keeps its columns: nothing else tells it.
pub(super) fn calibrate(
    members: &mut [(Dof, Columns)],
    own: &[Option<usize>],
    runs: &[Run],
    model: &Model,
    options: RegressorOptions,
) {
    let inertias: BTreeSet<usize> = own.iter().copied().flatten().collect();
    let places: Vec<Vec<(usize, Range<usize>)>> = members
        .iter()
        .zip(own)
        .map(|((_, columns), own)| {
            let shared = |c: &usize| {
                let parameter = columns.parameters[*c].parameter;
                inertias.contains(&parameter) && *own != Some(parameter)
            };
            let shared: Vec<usize> = (0..columns.parameters.len()).filter(shared).collect();
            let blocks = columns.blocks.iter().map(|block| block.rows.clone());
            blocks.flat_map(|rows| shared.iter().map(move |column| (*column, rows.clone()))).collect()
        })
        .collect();
    let squares = |columns: &Columns, (column, rows): &(usize, Range<usize>)| -> f64 {
        columns.columns[*column][rows.clone()].iter().map(|c| c * c).sum()
    };
    let mut noisy: Vec<Vec<f64>> = places.iter().map(|places| vec![0.0; places.len()]).collect();
    for draw in 0..DRAWS {
        let Some(shaken) = shaken(runs, model, CALIBRATION + draw) else { return };
        let shaken: Vec<&Run> = shaken.iter().collect();
        for ((dof, _), (places, noisy)) in members.iter().zip(places.iter().zip(&mut noisy)) {
            // what the runs do not bear with more noise is left as it is
            let Ok(columns) = regressors_of(*dof, &shaken, model, options) else { return };
            for (place, sum) in places.iter().zip(noisy) {
                *sum += squares(&columns, place) / DRAWS as f64;
            }
        }
    }
    for ((_, columns), (places, noisy)) in members.iter_mut().zip(places.iter().zip(&noisy)) {
        for (place, noisy) in places.iter().zip(noisy) {
            let seen = squares(columns, place);
            let kept = if seen > 0.0 { (2.0 - noisy / seen).clamp(0.0, 1.0) } else { 1.0 };
            columns.columns[place.0][place.1.clone()].iter_mut().for_each(|c| *c *= kept);
        }
    }
}

/// Seed from which the draws of the calibration are counted, apart from those of the extrapolation.
const CALIBRATION: u64 = 1000;

/// The runs with white noise on the velocities of the model, as much as each shows of its own; `None` where none shows any.
pub(super) fn shaken(runs: &[Run], model: &Model, draw: u64) -> Option<Vec<Run>> {
    let mut any = false;
    let one = |(number, run): (usize, &Run)| {
        let mut shaken = run.clone();
        for dof in &model.dofs {
            let Some(signal) = run.signal(dof.velocity()) else { continue };
            let sigma = Samples::of(signal).map_or(0.0, |samples| samples.noise());
            if sigma > 0.0 {
                any = true;
                let mut noise = Noise::new(draw, (number * Dof::ALL.len() + dof.index()) as u64);
                let values: Vec<f64> = signal.values().iter().map(|value| value + sigma * noise.normal()).collect();
                shaken.signals.insert(dof.velocity().into(), Signal::new(signal.shared_time().clone(), values));
            }
        }
        shaken
    };
    let shaken = runs.iter().enumerate().map(one).collect();
    any.then_some(shaken)
}
