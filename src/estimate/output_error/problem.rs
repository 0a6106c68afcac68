//! The output-error problem: tracks, segments, weights and initial states.

use rayon::prelude::*;

use super::fold::Fold;
use super::loss::{Loss, RobustResidual};
use super::noise;
use super::observed::{available, observed, upright};
use super::{LONGEST_STEP, OutputErrorError, OutputErrorOptions};
use crate::chain::StateId;
use crate::dynamics::Dynamics;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, rounding};
use crate::simd::{Machine, Wide, Widths as _, Work};
use crate::simulate::{Emission, Stretch, Track, integrate, memory_start, quickest_time_constants, values_in_run};

/// Number of stretches that are integrated side by side.
pub(crate) const LANES: usize = 8;

/// A compiled model, runs divided into segments, and what is needed to linearise the model on the
/// runs.
#[derive(Debug, Clone)]
pub struct Problem {
    /// The compiled model.
    pub dynamics: Dynamics,
    /// The prepared runs.
    pub tracks: Vec<Track>,
    /// Segments, each with a free initial state.
    pub segments: Vec<Stretch>,
    /// Standard deviation of the noise of each output, in its unit.
    pub sigma: Vec<f64>,
    /// Unknowns apart from initial states: which parameter, and of which run if each has its own.
    pub unknowns: Vec<Unknown>,
    /// The cost of a residual.
    pub loss: Loss,
    /// Longest step of the integrator, s, if one is given.
    pub longest_step: Option<f64>,
}

/// One unknown of the fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unknown {
    /// Index of the parameter in the model.
    pub parameter: usize,
    /// Run whose value it is; `None` for a common one.
    pub run: Option<usize>,
}

/// A segment linearised at the current values: the triangular factor of
/// [∂y/∂x₀ | ∂y/∂θ | y − measured] / σ, with residuals as transformed by their loss.
#[derive(Debug, Clone)]
pub struct Linearised {
    /// Row-major upper triangle, `n × n`.
    pub r: Vec<f64>,
    /// Number of columns: states, directions, residual.
    pub n: usize,
    /// Number of samples.
    pub samples: usize,
    /// Σ residual², by output, in units of σ.
    pub squares: Vec<f64>,
    /// Number of samples under squares; under another loss Σ (ds/dr)², the curvature that the
    /// factor holds, and Σ dψ/dr, that of the loss.
    pub curvature: [f64; 2],
    /// Σ ψ²; Σ residual² under squares.
    pub pull: f64,
}

impl Linearised {
    /// Element (i, j).
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.r[i * self.n + j]
    }

    /// Σ ρ: the sum of squares of the residuals in units of σ, or of the residuals as transformed
    /// by the loss.
    pub fn cost(&self) -> f64 {
        (0..self.n).map(|i| self.at(i, self.n - 1).powi(2)).sum()
    }
}

impl Problem {
    /// Prepares the fit of the free parameters of `model` to `runs`.
    ///
    /// # Errors
    /// [`OutputErrorError`] when a run lacks what the model reads, or no run logs anything the
    /// model predicts.
    pub fn new(model: &Model, runs: &[Run], options: &OutputErrorOptions) -> Result<Problem, OutputErrorError> {
        let directions = model.free();
        let upright = upright(model, runs);
        let runs = upright.as_deref().unwrap_or(runs);
        let available = available(model, runs, options);
        let observed = observed(model, runs, options);
        let dynamics = Dynamics::sensitive(model, &available, &observed, &directions);
        if dynamics.outputs.is_empty() {
            return Err(OutputErrorError::NothingObserved);
        }
        let longest = options.longest_step_of_quick_motion();
        let tracks = runs
            .iter()
            .enumerate()
            .map(|(k, run)| Track::new(run, k, &dynamics, &values_in_run(model, k), model.input, longest))
            .collect::<Result<Vec<_>, _>>()?;
        let segments = segments(&tracks, options.segment);
        let sigma = noise::of_outputs(&dynamics, &tracks, options.sigma.as_ref());
        let unknowns = directions
            .iter()
            .flat_map(|p| match model.parameters[*p].spec.per_run {
                false => vec![Unknown { parameter: *p, run: None }],
                true => (0..runs.len()).map(|run| Unknown { parameter: *p, run: Some(run) }).collect(),
            })
            .collect();
        let OutputErrorOptions { loss, longest_step, .. } = *options;
        let mut problem = Problem { dynamics, tracks, segments, sigma, unknowns, loss, longest_step };
        problem.follow(model);
        Ok(problem)
    }

    /// Limits the steps of the integrator to half the quickest time constant about each instant,
    /// with the values of `model`; returns whether the steps have changed. A time constant quicker
    /// than the steps would be determined by the size of the steps.
    ///
    /// If no longest step is given, it is [`LONGEST_STEP`] or a fifth of that time constant,
    /// whichever is longer: a ship with a time constant of half a minute that is logged once a
    /// second takes one step from sample to sample. It stays [`LONGEST_STEP`] if the motion may
    /// also follow something quick, a wave or a command that arrives between two samples. It also
    /// stays if a velocity is not logged: what a random force does to a pose between two samples
    /// tells that velocity, and is not slow.
    pub(crate) fn follow(&mut self, model: &Model) -> bool {
        let Problem { dynamics, .. } = &*self;
        let is_logged = |dof: &Dof| dynamics.outputs.iter().any(|output| output == dof.velocity());
        let is_timed = dynamics.inputs.iter().any(|(_, name)| name == "t");
        let is_slow = dynamics.delays().is_empty() && !is_timed && dynamics.velocities().iter().all(is_logged);
        let longest = |constant: f64| match self.longest_step {
            Some(given) => given,
            None if is_slow => LONGEST_STEP.max(0.2 * constant),
            None => LONGEST_STEP,
        };
        let steps =
            |constants: Vec<f64>| constants.into_iter().map(move |c| longest(c).min(0.5 * c)).collect::<Vec<_>>();
        let Problem { dynamics, tracks, .. } = self;
        let mut changed = false;
        for track in tracks {
            let theta = values_in_run(model, track.run);
            let constants = quickest_time_constants(dynamics, track, &theta);
            if track.follow(steps(constants).into_iter()) {
                track.read_inputs(dynamics, &theta);
                changed = true;
            }
        }
        changed
    }

    /// Initial states of all segments from the log: a straight line through the first samples of
    /// each channel.
    pub fn initial_states(&self, model: &Model) -> Vec<Vec<f64>> {
        let measured = self.dynamics.states.len() - self.dynamics.memories();
        self.segments
            .iter()
            .map(|segment| {
                let track = &self.tracks[segment.track];
                let mut x: Vec<f64> = self.dynamics.states[..measured]
                    .iter()
                    .map(|id| {
                        if let StateId::Quaternion(k) = id {
                            let attitude = noise::logged_attitude(&self.dynamics, track, segment.first);
                            return attitude.map_or([1.0, 0.0, 0.0, 0.0], |q| [q.w, q.i, q.j, q.k])[usize::from(*k)];
                        }
                        let output = id.channel().and_then(|c| self.dynamics.outputs.iter().position(|o| *o == c));
                        output.map_or(0.0, |output| level_at(track, output, self.dynamics.outputs.len(), segment))
                    })
                    .collect();
                let theta = values_in_run(model, track.run);
                x.extend(memory_start(&self.dynamics, track, &theta, segment.first, &x));
                x
            })
            .collect()
    }

    /// Linearises every segment at the values of `model` and the initial states `x0`.
    pub fn linearise(&self, model: &Model, x0: &[Vec<f64>]) -> Vec<Linearised> {
        let order: Vec<usize> = (0..self.segments.len()).collect();
        let batches: Vec<&[usize]> = order.chunks(LANES).collect();
        let parts: Vec<Vec<Linearised>> =
            batches.into_par_iter().map(|batch| self.linearise_batch(model, x0, batch)).collect();
        parts.into_iter().flatten().collect()
    }

    fn linearise_batch(&self, model: &Model, x0: &[Vec<f64>], batch: &[usize]) -> Vec<Linearised> {
        Machine::widest(Linearisation { problem: self, model, x0, batch })
    }

    #[inline(always)]
    fn linearise_lanes<const L: usize, W: Wide<L>>(
        &self,
        wide: W,
        model: &Model,
        x0: &[Vec<f64>],
        batch: &[usize],
    ) -> Vec<Linearised> {
        let (nx, ny) = (self.dynamics.states.len(), self.dynamics.outputs.len());
        let n = nx + self.dynamics.directions.len() + 1;
        let (stretches, theta, start) = self.lanes::<L>(model, x0, batch);
        let mut fold = Fold::with(wide, n);
        self.keep_norm(&mut fold, x0, batch);
        self.remember(&mut fold, model, x0, batch);
        let mut squares = vec![[0.0; L]; ny];
        let mut samples = [0usize; L];
        let (mut curvature, mut pull) = ([[0.0; 2]; L], [0.0; L]);
        let mut take = std::convert::identity(
            #[inline(always)]
            |at: &Emission<'_, L>| {
                for output in 0..ny {
                    let (mut weight, mut residual) = ([0.0; L], [0.0; L]);
                    for lane in 0..L {
                        let measured = self.measured(&stretches, at.grid, lane, output);
                        if !measured.is_nan() {
                            weight[lane] = 1.0 / self.sigma[output];
                            residual[lane] = (at.outputs[output][lane] - measured) * weight[lane];
                            squares[output][lane] += residual[lane] * residual[lane];
                            samples[lane] += 1;
                        }
                    }
                    if self.loss.is_robust() {
                        for lane in 0..L {
                            if weight[lane] <= 0.0 {
                                continue;
                            }
                            let RobustResidual { value, slope, bend } = self.loss.temper(residual[lane]);
                            residual[lane] = value;
                            weight[lane] *= slope;
                            curvature[lane][0] += slope * slope;
                            curvature[lane][1] += bend;
                            pull[lane] += (value * slope).powi(2);
                        }
                    }
                    let row = &at.jacobian[output * (n - 1)..(output + 1) * (n - 1)];
                    let weight = wide.load(&weight);
                    let weighted = row.iter().map(
                        #[inline(always)]
                        |g| wide.store(wide.mul(wide.only_where(wide.load(g), weight), weight)),
                    );
                    fold.push(weighted.chain(std::iter::once(residual)));
                }
            },
        );
        integrate(wide, &self.dynamics, &self.tracks, &stretches, &theta, &start, true, &mut take);
        fold.fold();
        (0..batch.len())
            .map(|lane| Linearised {
                r: (0..n * n).map(|k| fold.at(k / n, k % n)[lane]).collect(),
                n,
                samples: samples[lane],
                squares: squares.iter().map(|s| s[lane]).collect(),
                curvature: if self.loss.is_robust() { curvature[lane] } else { [samples[lane] as f64; 2] },
                pull: if self.loss.is_robust() { pull[lane] } else { squares.iter().map(|s| s[lane]).sum() },
            })
            .collect()
    }

    /// Starting point of one batch of segments: stretches, parameters and initial states by lane.
    #[allow(clippy::type_complexity)] // three lane-wise tables
    pub(crate) fn lanes<const L: usize>(
        &self,
        model: &Model,
        x0: &[Vec<f64>],
        batch: &[usize],
    ) -> ([Option<Stretch>; L], Vec<[f64; L]>, Vec<[f64; L]>) {
        let stretches = std::array::from_fn(|lane| batch.get(lane).map(|s| self.segments[*s]));
        let values: Vec<Vec<f64>> =
            stretches.iter().flatten().map(|s: &Stretch| values_in_run(model, self.tracks[s.track].run)).collect();
        // lanes without a segment repeat the first one's numbers, so that nothing in them can overflow
        let theta = (0..model.parameters.len())
            .map(|p| std::array::from_fn(|lane| values.get(lane).unwrap_or(&values[0])[p]))
            .collect();
        let start = (0..self.dynamics.states.len())
            .map(|k| std::array::from_fn(|lane| x0[*batch.get(lane).unwrap_or(&batch[0])][k]))
            .collect();
        (stretches, theta, start)
    }

    /// The measurement of an output at the grid point at which a lane stands; NaN where there is none.
    #[inline(always)]
    pub(crate) fn measured<const L: usize>(
        &self,
        stretches: &[Option<Stretch>; L],
        grid: &[Option<usize>; L],
        lane: usize,
        output: usize,
    ) -> f64 {
        match (stretches[lane], grid[lane]) {
            (Some(stretch), Some(k)) => self.tracks[stretch.track].observed[k * self.dynamics.outputs.len() + output],
            _ => f64::NAN,
        }
    }

    /// Adds a row that holds the norm of the attitude quaternion, which nothing else determines,
    /// at 1: (|q|² − 1)/2 = 0.
    fn keep_norm<const L: usize, W: Wide<L>>(&self, fold: &mut Fold<L, W>, x0: &[Vec<f64>], batch: &[usize]) {
        let Some(first) = self.dynamics.quaternion() else { return };
        let n = self.dynamics.states.len() + self.dynamics.directions.len() + 1;
        let at = |lane: usize, k: usize| batch.get(lane).map_or(0.0, |s| x0[*s][k]);
        let components = first..first + 4;
        fold.push((0..n).map(|j| {
            std::array::from_fn(|lane| match j {
                _ if components.contains(&j) => at(lane, j),
                _ if j == n - 1 => 0.5 * (components.clone().map(|k| at(lane, k).powi(2)).sum::<f64>() - 1.0),
                _ => 0.0,
            })
        }));
    }

    /// Adds a weak prior on the initial values of memory: near their quasi-steady values, within
    /// half their size.
    fn remember<const L: usize, W: Wide<L>>(
        &self,
        fold: &mut Fold<L, W>,
        model: &Model,
        x0: &[Vec<f64>],
        batch: &[usize],
    ) {
        let (nx, memories) = (self.dynamics.states.len(), self.dynamics.memories());
        let n = nx + self.dynamics.directions.len() + 1;
        if memories == 0 {
            return;
        }
        let prior: Vec<(Vec<f64>, Vec<f64>)> = batch.iter().map(|s| self.memory_prior(model, x0, *s)).collect();
        for m in 0..memories {
            let k = nx - memories + m;
            let value = |lane: usize| prior.get(lane).map_or((0.0, 0.0), |(mean, std)| (mean[m], 1.0 / std[m]));
            fold.push((0..n).map(|j| {
                std::array::from_fn(|lane| {
                    let (mean, weight) = value(lane);
                    match j {
                        _ if j == k => weight,
                        _ if j == n - 1 => batch.get(lane).map_or(0.0, |s| (x0[*s][k] - mean) * weight),
                        _ => 0.0,
                    }
                })
            }));
        }
    }

    /// Mean and standard deviation of the prior on the memories of a segment.
    pub(crate) fn memory_prior(&self, model: &Model, x0: &[Vec<f64>], segment: usize) -> (Vec<f64>, Vec<f64>) {
        let stretch = &self.segments[segment];
        let track = &self.tracks[stretch.track];
        let theta = values_in_run(model, track.run);
        let at = |k: usize| memory_start(&self.dynamics, track, &theta, k, &x0[segment]);
        let mean = at(stretch.first);
        let middle = at((stretch.first + stretch.last) / 2);
        let end = at(stretch.last);
        let std = (0..mean.len()).map(|m| 0.5 * (mean[m].abs() + middle[m].abs() + end[m].abs()).max(1e-6)).collect();
        (mean, std)
    }
}

/// One batch of segments, linearised.
struct Linearisation<'a> {
    problem: &'a Problem,
    model: &'a Model,
    x0: &'a [Vec<f64>],
    batch: &'a [usize],
}

impl Work<LANES> for Linearisation<'_> {
    type Output = Vec<Linearised>;
    #[inline(always)]
    fn with<W: Wide<LANES>>(self, wide: W) -> Vec<Linearised> {
        self.problem.linearise_lanes(wide, self.model, self.x0, self.batch)
    }
}

/// Divides tracks into segments of about `length` seconds, none of which spans a gap.
fn segments(tracks: &[Track], length: f64) -> Vec<Stretch> {
    let mut all = Vec::new();
    for (track, t) in tracks.iter().enumerate() {
        for (i, begin) in t.starts.iter().enumerate() {
            let end = t.starts.get(i + 1).copied().unwrap_or(t.time.len()) - 1;
            if end <= *begin {
                continue;
            }
            let span = t.time[end] - t.time[*begin];
            let parts = (span / length).round().max(1.0) as usize;
            let mut first = *begin;
            for part in 1..=parts {
                let until = t.time[*begin] + span * part as f64 / parts as f64;
                let last =
                    if part == parts { end } else { t.time.partition_point(|x| *x < until - rounding(until)).min(end) };
                // the sample at a border belongs to the segment that it begins
                let close = if part == parts { last } else { last.saturating_sub(1) };
                if close > first {
                    all.push(Stretch { track, first, last: close });
                    first = last;
                }
            }
        }
    }
    all
}

/// Value of an output at the beginning of a segment: a straight line through its first samples, at
/// most half a second.
fn level_at(track: &Track, output: usize, width: usize, segment: &Stretch) -> f64 {
    let t0 = track.time[segment.first];
    let samples: Vec<(f64, f64)> = (segment.first..=segment.last)
        .map(|k| (track.time[k] - t0, track.observed[k * width + output]))
        .filter(|(_, y)| !y.is_nan())
        .take(6)
        .enumerate()
        .filter(|(i, (t, _))| *i < 2 || *t < 0.5)
        .map(|(_, sample)| sample)
        .collect();
    let n = samples.len() as f64;
    if samples.is_empty() {
        return 0.0;
    }
    let (mt, my) = samples.iter().fold((0.0, 0.0), |(a, b), (t, y)| (a + t / n, b + y / n));
    let (tt, ty) = samples.iter().fold((0.0, 0.0), |(a, b), (t, y)| (a + (t - mt).powi(2), b + (t - mt) * (y - my)));
    if tt > 0.0 { my - mt * ty / tt } else { my }
}

impl Problem {
    /// Number of free initial states of a segment. Memories have priors and are not counted; a
    /// quaternion has a fixed norm and counts as three.
    pub fn free_states(&self) -> usize {
        self.dynamics.states.len() - self.dynamics.memories() - usize::from(self.dynamics.quaternion().is_some())
    }

    /// Whether a state is a memory of an effect.
    pub fn is_memory(&self, state: usize) -> bool {
        matches!(self.dynamics.states[state], StateId::Memory { .. })
    }
}

impl Problem {
    /// For each direction, the column of the unknown that it moves in the run of `track`.
    pub(crate) fn columns_of(&self, track: usize) -> Vec<usize> {
        let run = self.tracks[track].run;
        self.dynamics
            .directions
            .iter()
            .map(|p| {
                self.unknowns
                    .iter()
                    .position(|u| u.parameter == *p && u.run.is_none_or(|r| r == run))
                    .expect("every direction has an unknown in every run")
            })
            .collect()
    }

    /// Number of samples of an output in all segments.
    pub fn samples_of(&self, output: usize) -> usize {
        let width = self.dynamics.outputs.len();
        let count = |s: &Stretch| {
            (s.first..=s.last).filter(|k| !self.tracks[s.track].observed[k * width + output].is_nan()).count()
        };
        self.segments.iter().map(count).sum()
    }

    /// Number of samples of all outputs in a segment.
    pub fn samples_in(&self, segment: usize) -> usize {
        let (s, width) = (self.segments[segment], self.dynamics.outputs.len());
        let rows = &self.tracks[s.track].observed[s.first * width..(s.last + 1) * width];
        rows.iter().filter(|y| !y.is_nan()).count()
    }
}
