//! Starting values of the search for the noise, and its priors.
//!
//! ```text
//! σ₀: a tenth of the thrust's rms      T₀: 1 s      R₀: differences of the samples, or as given
//! prior: ln T ~ N(ln 1 s, 1.5²),   ln R ~ N(ln given, 1²) where given
//! ```

use nalgebra::DMatrix;

use super::noise::{Coordinate, NoiseModel, RandomForce, SensorNoise};
use super::options::Forces;
use super::problem::Filtered;
use super::unseen_velocity;
use crate::chain::StateId;
use crate::effects::id;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, commanded_rms};

/// Starting rms of a random force as a share of the thrust: too large a force is reduced within a
/// few steps, too small a force makes a filter that trusts a wrong model.
const SHARE: f64 = 0.1;

/// The same for a moment if fixes alone determine a velocity along an axis: all of the thrust.
/// Velocities that have not settled yet turn the vehicle by a Munk moment of many standard
/// deviations of its rate. A filter that cannot attribute this moment to anything else takes the
/// masses for equal, (m_u − m_v) u v = 0: a maximum of the likelihood that it does not leave. If
/// fixes determine the rate too, so large a moment may itself be a maximum, with an inertia of a
/// twentieth. The search therefore starts from both shares.
const MOMENT_SHARE: f64 = 1.0;

/// Correlation time at which the search starts, and mean of its prior, s: turbulence at the scale
/// of a vehicle.
pub(super) const TIME: f64 = 1.0;

/// Standard deviation of ln T in its prior: from a fifth of a second to five seconds.
const TIME_SPREAD: f64 = 1.5;

/// Standard deviation of ln R about a given value, which may be wrong several times over.
const STATED_SPREAD: f64 = 1.0;

/// Noise models from which the search starts.
pub(super) fn noises(filtered: &Filtered, model: &Model, runs: &[Run], forces: &Forces) -> Vec<NoiseModel> {
    let states = &filtered.problem.dynamics.states;
    let unseen = unseen_velocity::states(&filtered.problem);
    let drifts = unseen.iter().any(|k| matches!(states[*k], StateId::Velocity(dof) if !dof.is_rotation()));
    let shares: &[f64] = if drifts && forces.is_estimated() { &[MOMENT_SHARE, SHARE] } else { &[SHARE] };
    shares.iter().map(|share| noise(filtered, model, runs, forces, *share)).collect()
}

/// The same for one share of the thrust for random moments.
fn noise(filtered: &Filtered, model: &Model, runs: &[Run], forces: &Forces, share_of_moment: f64) -> NoiseModel {
    let dofs = filtered.problem.dynamics.velocities();
    let forces = match forces {
        Forces::None => Vec::new(),
        Forces::Held { rms, time } => {
            let held = |dof: &Dof| Some(RandomForce { dof: *dof, rms: *rms.get(dof)?, time: *time });
            dofs.iter().filter_map(held).filter(|f| f.rms > 0.0).collect()
        }
        Forces::Estimate { most } => {
            let share = |dof: &Dof| if dof.is_rotation() { share_of_moment } else { SHARE };
            let start = |dof: &Dof| {
                (share(dof) * strength(model, runs, *dof)).min(most.get(dof).copied().unwrap_or(f64::INFINITY))
            };
            dofs.iter().map(|dof| RandomForce { dof: *dof, rms: start(dof), time: TIME }).collect()
        }
    };
    let sigma = filtered.problem.sigma.iter().zip(floors(filtered));
    let sensors = sigma.map(|(std, floor)| SensorNoise { std: std.max(10.0 * floor), coloured: None }).collect();
    NoiseModel { forces, sensors }
}

/// Samples of an output, run by run.
fn samples(filtered: &Filtered, output: usize) -> impl Iterator<Item = Vec<f64>> + '_ {
    let ny = filtered.problem.dynamics.outputs.len();
    let of =
        move |observed: &[f64]| observed.iter().skip(output).step_by(ny).copied().filter(|y| !y.is_nan()).collect();
    filtered.problem.tracks.iter().map(move |t| of(&t.observed))
}

/// Range of each output in the run where it is greatest.
fn ranges(filtered: &Filtered) -> Vec<f64> {
    let range = |y: Vec<f64>| {
        let (low, high) = y.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| (l.min(*y), h.max(*y)));
        high - low
    };
    let outputs = filtered.problem.dynamics.outputs.len();
    (0..outputs).map(|output| samples(filtered, output).map(range).fold(0.0, f64::max)).collect()
}

impl Filtered {
    /// Whether each output is silent, i.e. compared but without influence: its noise is larger than
    /// its range.
    pub fn silent(&self, noise: &NoiseModel) -> Vec<bool> {
        ranges(self).into_iter().zip(&noise.sensors).map(|(range, sensor)| sensor.std > range).collect()
    }
}

/// Least standard deviation of the noise of each output: that of its resolution or, if larger, a
/// hundred-thousandth of its range, below which numerics decide and not instruments.
pub(super) fn floors(filtered: &Filtered) -> Vec<f64> {
    let floor = |(output, range): (usize, f64)| {
        let steps = samples(filtered, output).filter_map(|y| resolution_of(&y));
        let resolution = steps.reduce(f64::min).unwrap_or(0.0);
        (resolution / 12f64.sqrt()).max(1e-5 * range).max(1e-12)
    };
    ranges(filtered).into_iter().enumerate().map(floor).collect()
}

/// The step of which all differences of the samples are multiples; `None` if there is none.
fn resolution_of(y: &[f64]) -> Option<f64> {
    let differences: Vec<f64> = y.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 0.0).collect();
    let least = differences.iter().copied().fold(f64::INFINITY, f64::min);
    // a difference of two decimal numbers has rounding errors
    let multiple = |d: &f64| (d / least - (d / least).round()).abs() < 1e-3 * (d / least).max(1.0);
    let fits = differences.iter().filter(|d| multiple(d)).count();
    (differences.len() > 8 && fits == differences.len()).then_some(least)
}

/// Rms of the thrust in a degree of freedom, N or N·m; if none is commanded there, that of inertia
/// times acceleration.
pub(super) fn strength(model: &Model, runs: &[Run], dof: Dof) -> f64 {
    if let Some(thrust) = commanded_rms(runs, dof) {
        return thrust;
    }
    let inertia = model.value_at(id::INERTIA, dof).unwrap_or(1.0).abs();
    // over a second, in which the noise of a sensor is negligible
    let changes = runs.iter().filter_map(|r| r.signal(dof.velocity())).flat_map(|s| {
        let (t, x) = (s.time(), s.values());
        let mut until = 0;
        (0..t.len())
            .filter_map(|k| {
                while until + 1 < t.len() && t[until] < t[k] + 1.0 {
                    until += 1;
                }
                (t[until] > t[k]).then(|| (x[until] - x[k]) / (t[until] - t[k]))
            })
            .collect::<Vec<f64>>()
    });
    let (sum, count) = changes.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    let strength = inertia * f64::sqrt(sum / f64::max(count, 1.0));
    if strength > 0.0 { strength } else { inertia }
}

/// What is known of the noise before the data: −2 ln of the prior, its slope and its curvature by
/// each logarithm.
pub(super) struct Prior {
    /// Mean and standard deviation by coordinate, if there is a prior.
    pub of: Vec<Option<(f64, f64)>>,
}

impl Prior {
    /// The prior of these coordinates; `stated` holds the standard deviation of each output where
    /// it is given.
    pub fn new(coordinates: &[Coordinate], stated: &[Option<f64>]) -> Prior {
        let of = coordinates.iter().map(|c| match *c {
            Coordinate::ForceTime(_) | Coordinate::ColouredTime(_) => Some((TIME.ln(), TIME_SPREAD)),
            Coordinate::Sensor(output) => stated[output].map(|std| (std.ln(), STATED_SPREAD)),
            Coordinate::ForceRms(_) | Coordinate::ColouredRms(_) => None,
        });
        Prior { of: of.collect() }
    }

    /// Adds the information of the prior to that of the data.
    pub fn inform(&self, information: &mut DMatrix<f64>) {
        let known = self.of.iter().enumerate().filter_map(|(k, of)| Some((k, (*of)?.1)));
        known.for_each(|(k, std)| information[(k, k)] += 1.0 / (std * std));
    }

    /// −2 ln of the prior.
    pub fn cost(&self, noise: &NoiseModel, coordinates: &[Coordinate]) -> f64 {
        let terms = coordinates.iter().zip(&self.of);
        terms.filter_map(|(c, of)| of.map(|(mean, std)| ((noise.at(*c) - mean) / std).powi(2))).sum()
    }
}
