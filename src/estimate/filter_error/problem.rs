//! The prepared problem: runs without gaps, each with an estimate of its state before the first
//! sample.
//!
//! ```text
//! x₀: the first samples, quasi-steady for memories
//! P₀: as wide as the range of each channel, so that x₀ has no weight
//! ```
//!
//! Velocities that no channel logs: see [`super::unseen_velocity`].

use nalgebra::DMatrix;

use super::noise::NoiseModel;
use super::transition::Belief;
use super::ud::{Covariance, First, Work};
use super::unseen_velocity::{self, UNKNOWN};
use crate::chain::StateId;
use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions, Problem};
use crate::frame::Dof;
use crate::model::Model;
use crate::run::Run;
use crate::simd::Plain;
use crate::simulate::{Stretch, values_at, values_in_run};

/// Runs prepared for the filter.
#[derive(Debug, Clone)]
pub struct Filtered {
    /// The compiled model, tracks, stretches without gaps, and unknowns.
    pub problem: Problem,
    /// Estimate of the state at the beginning of each stretch.
    pub(super) starts: Vec<Start>,
}

/// Estimate of the state before the first sample of a stretch: mean and variances.
#[derive(Debug, Clone)]
pub(super) struct Start {
    pub(super) x: Vec<f64>,
    pub(super) variance: Vec<f64>,
}

/// The input of a pass over `L` stretches, one per lane.
pub(super) struct Batch<'a, const L: usize> {
    /// The runs.
    pub problem: &'a Problem,
    /// The stretch of each lane.
    pub stretches: [Option<Stretch>; L],
    /// Parameters by lane.
    pub theta: Vec<[f64; L]>,
    /// Noise of each lane.
    pub noise: [NoiseModel; L],
    /// M⁻¹ by lane, velocities × forces.
    pub mobility: Vec<[f64; L]>,
    /// Estimate of the state before the first sample.
    pub belief: Belief<L>,
    /// Number of standard deviations beyond which innovations are held back.
    pub limit: f64,
}

impl Filtered {
    /// Prepares the runs for a filter of `model`.
    ///
    /// # Errors
    /// [`OutputErrorError`] when a run lacks what the model reads, or no run logs anything the
    /// model predicts.
    pub fn new(model: &Model, runs: &[Run], options: &OutputErrorOptions) -> Result<Filtered, OutputErrorError> {
        let whole = OutputErrorOptions { segment: f64::INFINITY, ..options.clone() };
        Filtered::in_windows(model, runs, &whole)
    }

    /// The same in windows of `options.segment` seconds, each of which begins with an unknown state.
    ///
    /// # Errors
    /// As [`Filtered::new`].
    pub fn in_windows(model: &Model, runs: &[Run], options: &OutputErrorOptions) -> Result<Filtered, OutputErrorError> {
        let problem = Problem::new(model, runs, options)?;
        let states = problem.initial_states(model);
        let starts = states.into_iter().enumerate().map(|(k, x)| start(&problem, model, k, x)).collect();
        Ok(Filtered { problem, starts })
    }

    /// Computes the initial estimates anew after the parameters of `model`, and with them its
    /// memories, have changed.
    pub fn restart(&mut self, model: &Model) {
        let states = self.problem.initial_states(model);
        self.starts = states.into_iter().enumerate().map(|(k, x)| start(&self.problem, model, k, x)).collect();
    }

    /// The same stretches and initial estimates with another compiled model of the same states.
    pub(crate) fn with_problem(&self, problem: Problem) -> Filtered {
        Filtered { problem, starts: self.starts.clone() }
    }

    /// M⁻¹ of every stretch, velocities × velocities; `None` if an inertia is singular.
    pub(crate) fn mobilities(&self, model: &Model) -> Option<Vec<DMatrix<f64>>> {
        let problem = &self.problem;
        let nd = problem.dynamics.velocities().len();
        let of = |(stretch, start): (&Stretch, &Start)| {
            let track = &problem.tracks[stretch.track];
            let theta = values_in_run(model, track.run);
            let functions = &problem.dynamics.inertia;
            let m = values_at(functions, &problem.dynamics, track, &theta, stretch.first, &start.x);
            DMatrix::from_row_slice(nd, nd, &m).try_inverse().filter(|i| i.iter().all(|x| x.is_finite()))
        };
        problem.segments.iter().zip(&self.starts).map(of).collect()
    }

    /// A batch of the stretches `members`, one per lane, with the noise of each lane. Lanes beyond
    /// the members repeat the first one's numbers, so that nothing in them can overflow.
    pub(super) fn batch<'a, const L: usize>(
        &'a self,
        model: &Model,
        members: &[usize],
        noise: [NoiseModel; L],
        mobilities: &[DMatrix<f64>],
        limit: f64,
    ) -> Batch<'a, L> {
        let pairs: Vec<(&Model, usize)> = members.iter().map(|member| (model, *member)).collect();
        self.batch_of_models(&pairs, noise, mobilities, limit)
    }

    /// The same for `members` that have parameter values of their own each.
    pub(super) fn batch_of_models<'a, const L: usize>(
        &'a self,
        members: &[(&Model, usize)],
        noise: [NoiseModel; L],
        mobilities: &[DMatrix<f64>],
        limit: f64,
    ) -> Batch<'a, L> {
        let problem = &self.problem;
        let of_lane = |lane: usize| members.get(lane).copied().unwrap_or(members[0]);
        let member = |lane: usize| of_lane(lane).1;
        let stretches = std::array::from_fn(|lane| members.get(lane).map(|(_, k)| problem.segments[*k]));
        let of_stretch =
            |(model, k): (&Model, usize)| values_in_run(model, problem.tracks[problem.segments[k].track].run);
        let values: Vec<Vec<f64>> = (0..L).map(|lane| of_stretch(of_lane(lane))).collect();
        let theta = (0..values[0].len()).map(|p| std::array::from_fn(|lane| values[lane][p])).collect();
        let dofs = problem.dynamics.velocities();
        let forces: Vec<usize> =
            noise[0].forces.iter().filter_map(|f| dofs.iter().position(|dof| *dof == f.dof)).collect();
        let mobility = (0..dofs.len() * forces.len())
            .map(|k| {
                let (row, force) = (k / forces.len(), forces[k % forces.len()]);
                std::array::from_fn(|lane| mobilities[member(lane)][(row, force)])
            })
            .collect();
        let belief = self.belief(std::array::from_fn(member), &noise);
        Batch { problem, stretches, theta, noise, mobility, belief, limit }
    }

    /// Estimate of the state before the first sample of each lane's stretch.
    fn belief<const L: usize>(&self, members: [usize; L], noise: &[NoiseModel; L]) -> Belief<L> {
        let nx = self.problem.dynamics.states.len();
        let processes: Vec<[f64; L]> = {
            let of = |model: &NoiseModel| -> Vec<f64> {
                let coloured = model.coloured().map(|(_, c)| c.rms * c.rms);
                model.forces.iter().map(|f| f.rms * f.rms).chain(coloured).collect()
            };
            let lanes: Vec<Vec<f64>> = noise.iter().map(of).collect();
            (0..lanes[0].len()).map(|k| std::array::from_fn(|lane| lanes[lane][k])).collect()
        };
        let n = nx + processes.len();
        let state = |k: usize| std::array::from_fn(|lane| self.starts[members[lane]].x[k]);
        let variance = |k: usize| std::array::from_fn(|lane| self.starts[members[lane]].variance[k]);
        let x: Vec<[f64; L]> = (0..nx).map(state).chain(processes.iter().map(|_| [0.0; L])).collect();
        let variances: Vec<[f64; L]> = (0..nx).map(variance).chain(processes.iter().copied()).collect();
        let mut p = Covariance::diagonal(&variances);
        if let Some(first) = self.problem.dynamics.quaternion() {
            // the three rotations about an attitude are uncertain; the norm of the quaternion is
            // not
            let turns = turns(std::array::from_fn::<[f64; L], 4, _>(|k| x[first + k]));
            let mut w = vec![[0.0; L]; n * 3];
            for (row, turns) in turns.iter().enumerate() {
                w[(first + row) * 3..(first + row) * 3 + 3].copy_from_slice(turns);
            }
            let identity: Vec<[f64; L]> = (0..n * n).map(|k| [f64::from(u8::from(k / n == k % n)); L]).collect();
            let filled = (0..n).map(|k| vec![k]).collect();
            p.predict(Plain, &identity, &w, &mut Work::new(vec![First::default(); n], filled, 3));
        }
        Belief { x: crate::simd::Lanes::of(&x), p }
    }

    /// Mean interval of the time grid, s.
    pub fn sample_time(&self) -> f64 {
        let problem = &self.problem;
        let spans = problem.segments.iter().map(|s| {
            let time = &problem.tracks[s.track].time;
            (time[s.last] - time[s.first], s.last - s.first)
        });
        let (seconds, count) = spans.fold((0.0, 0), |(t, n), (span, steps)| (t + span, n + steps));
        seconds / count.max(1) as f64
    }

    /// Number of samples of an output.
    pub fn samples_of(&self, output: usize) -> usize {
        self.problem.samples_of(output)
    }
}

/// ∂q/∂(rotation) times [`UNKNOWN`], rows w, x, y, z: half of q's own matrix.
fn turns<const L: usize>([w, x, y, z]: [[f64; L]; 4]) -> [[[f64; L]; 3]; 4] {
    let half = |a: [f64; L], sign: f64| a.map(|a| 0.5 * sign * a * UNKNOWN);
    [
        [half(x, -1.0), half(y, -1.0), half(z, -1.0)],
        [half(w, 1.0), half(z, -1.0), half(y, 1.0)],
        [half(z, 1.0), half(w, 1.0), half(x, -1.0)],
        [half(y, -1.0), half(x, 1.0), half(w, 1.0)],
    ]
}

/// x₀ and its variances.
fn start(problem: &Problem, model: &Model, stretch: usize, mut x: Vec<f64>) -> Start {
    let Stretch { track, first, last } = problem.segments[stretch];
    let (nx, ny) = (problem.dynamics.states.len(), problem.dynamics.outputs.len());
    let memories = problem.dynamics.memories();
    let range = |output: usize| {
        let samples = (first..=last).map(|k| problem.tracks[track].observed[k * ny + output]).filter(|y| !y.is_nan());
        let (low, high) = samples.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
        (high > low).then_some(high - low)
    };
    let states = problem.dynamics.states[..nx - memories].iter();
    let mut variance: Vec<f64> = states
        .map(|id| match id {
            StateId::Quaternion(_) => 0.0,
            StateId::Position(dof) if !dof.is_rotation() && observed(problem, *dof).is_none() => 0.0,
            id => {
                let output = id.channel().and_then(|c| problem.dynamics.outputs.iter().position(|o| o == c));
                let known = output.map(|output| range(output).unwrap_or(0.0) + 10.0 * problem.sigma[output]);
                known.unwrap_or(UNKNOWN).powi(2)
            }
        })
        .collect();
    for velocity in unseen_velocity::of(problem, model, problem.segments[stretch], &x) {
        (x[velocity.state], variance[velocity.state]) = (velocity.value, velocity.variance);
    }
    if memories > 0 {
        let all: Vec<Vec<f64>> =
            (0..problem.segments.len()).map(|k| if k == stretch { x.clone() } else { vec![] }).collect();
        let (_, std) = problem.memory_prior(model, &all, stretch);
        // the standard deviation of the prior is half the size of the memory; at the start of a log
        // it may have any value of that size
        variance.extend(std.iter().map(|s| (2.0 * s).powi(2)));
    }
    Start { x, variance }
}

fn observed(problem: &Problem, dof: Dof) -> Option<usize> {
    problem.dynamics.outputs.iter().position(|o| o == dof.position())
}
