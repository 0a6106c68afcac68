//! Initial velocities of a run that logs none, from its poses.
//!
//! ```text
//! η̇ = J(η) ν + c    η̇: slope at the beginning of a parabola through the first samples, by least squares
//! min Σ (η̇ − J ν − c)²/(3σ)² + ν²/V²        →  ν₀ and its variances
//! ```
//!
//! A filter that takes any initial velocity as possible follows the difference of the first two
//! fixes, half a metre per second off and more, and linearises there about a motion that never took
//! place. Without a random force it does not forget that: a virtual mass came out 25 standard
//! deviations off. The factor 3 is there because the filter receives the same samples once more.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::chain::StateId;
use crate::estimate::output_error::Problem;
use crate::model::Model;
use crate::simulate::{Stretch, Track, values_at, values_in_run};

/// Standard deviation, m/s or rad/s, of an initial velocity of which nothing is known.
pub(super) const UNKNOWN: f64 = 1.0;

/// Length of the parabola, s, and its least number of samples, for which it is made longer if
/// necessary.
const SPAN: f64 = 2.0;
const FEWEST: usize = 8;

/// Factor by which a standard deviation from the samples is widened for the initial estimate.
pub(super) const WIDER: f64 = 3.0;

/// An initial velocity: its state, value and variance.
pub(super) struct Velocity {
    pub state: usize,
    pub value: f64,
    pub variance: f64,
}

/// The states that are velocities without a sensor.
pub(super) fn states(problem: &Problem) -> Vec<usize> {
    let dynamics = &problem.dynamics;
    let is_unseen = |id: &StateId| match id {
        StateId::Velocity(dof) => dynamics.outputs.iter().all(|output| output != dof.velocity()),
        _ => false,
    };
    (0..dynamics.states.len()).filter(|k| is_unseen(&dynamics.states[*k])).collect()
}

/// The initial velocities without a sensor of a stretch; `x` is its initial state, attitude
/// included.
pub(super) fn of(problem: &Problem, model: &Model, stretch: Stretch, x: &[f64]) -> Vec<Velocity> {
    let (dynamics, track) = (&problem.dynamics, &problem.tracks[stretch.track]);
    let output = |id: StateId| id.channel().and_then(|c| dynamics.outputs.iter().position(|o| o == c));
    let states = || dynamics.states.iter().copied().enumerate();
    let unseen = self::states(problem);
    let slopes: Vec<(usize, f64, f64)> = states()
        .filter(|(_, id)| matches!(id, StateId::Position(_)))
        .filter_map(|(k, id)| slope(track, output(id)?, dynamics.outputs.len(), stretch).map(|(s, std)| (k, s, std)))
        .collect();
    if unseen.is_empty() {
        return Vec::new();
    }
    let theta = values_in_run(model, track.run);
    let rates = |x: &[f64]| values_at(&dynamics.rates, dynamics, track, &theta, stretch.first, x);
    let mut still = x.to_vec();
    unseen.iter().for_each(|k| still[*k] = 0.0);
    let offset = rates(&still);
    let along: Vec<Vec<f64>> = unseen
        .iter()
        .map(|k| {
            let mut moving = still.clone();
            moving[*k] = 1.0;
            rates(&moving)
        })
        .collect();
    let row = |i: usize| {
        let (state, slope, std) = slopes[i];
        let weight = 1.0 / (WIDER * std);
        (
            weight * (slope - offset[state]),
            along.iter().map(|a| weight * (a[state] - offset[state])).collect::<Vec<f64>>(),
        )
    };
    let rows: Vec<(f64, Vec<f64>)> =
        (0..slopes.len()).map(row).filter(|(b, a)| b.is_finite() && a.iter().all(|a| a.is_finite())).collect();
    let a = DMatrix::from_fn(rows.len(), unseen.len(), |i, j| rows[i].1[j]);
    let b = DVector::from_fn(rows.len(), |i, _| rows[i].0);
    let information = a.tr_mul(&a) + DMatrix::identity(unseen.len(), unseen.len()) / UNKNOWN.powi(2);
    let Some(covariance) = information.try_inverse() else { return Vec::new() };
    let value = &covariance * a.tr_mul(&b);
    let velocity = |(k, state)| Velocity { state, value: value[k], variance: covariance[(k, k)] };
    unseen.into_iter().enumerate().map(velocity).collect()
}

/// Slope of an output at the beginning of a stretch, with its standard deviation; `None` if there
/// are too few samples.
fn slope(track: &Track, output: usize, width: usize, stretch: Stretch) -> Option<(f64, f64)> {
    let t0 = track.time[stretch.first];
    let samples: Vec<(f64, f64)> = (stretch.first..=stretch.last)
        .map(|k| (track.time[k] - t0, track.observed[k * width + output]))
        .filter(|(_, y)| !y.is_nan())
        .enumerate()
        .take_while(|(i, (t, _))| *i < FEWEST || *t < SPAN)
        .map(|(_, sample)| sample)
        .collect();
    if samples.len() < FEWEST {
        return None;
    }
    let basis = |t: f64| Vector3::new(1.0, t, t * t);
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (t, y) in &samples {
        let b = basis(*t);
        normal += b * b.transpose();
        right += b * *y;
    }
    let inverse = normal.try_inverse()?;
    let fitted = inverse * right;
    let squares: f64 = samples.iter().map(|(t, y)| (y - basis(*t).dot(&fitted)).powi(2)).sum();
    let std = (squares / (samples.len() - 3) as f64 * inverse[(1, 1)]).sqrt();
    (std > 0.0 && std.is_finite()).then_some((fitted[1], std))
}
