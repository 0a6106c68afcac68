//! Refits by filter error on resampled data.
//!
//! ```text
//! bootstrap:    θ* = θ̂ − (Σ n_b A_b)⁻¹ Σ n_b g_b       A_b, g_b: JᵀJ and Jᵀe of block b, J = (∂e/∂θ)/√s
//! Monte Carlo:  x₊ = f(x, τ, d),   y = h(x) + e         d and e: drawn from the noise of the fit
//! ```
//!
//! A bootstrap draw takes one Gauss-Newton step under the noise of the fit: if the model is right,
//! the innovations are independent of each other, and the noise matters in second order only. Monte
//! Carlo estimates parameters and noise anew.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::noise::NoiseModel;
use super::options::FilterErrorOptions;
use super::problem::{Batch, Filtered};
use super::sensor::Sensors;
use super::transition::Transition;
use super::{FilterErrorFit, ascent};
use crate::estimate::output_error::{OutputErrorError, value};
use crate::least_squares::{Draws, REFITTING};
use crate::model::Model;
use crate::noise::Noise;
use crate::progress::{look, tell};
use crate::run::Run;
use crate::simd::Plain;
use crate::simulate::{Evaluator, Feed, prepared};

impl FilterErrorFit {
    /// Estimates of the unknowns on resamplings of blocks of about `length` seconds, for the draws
    /// of these numbers. A draw is the same whichever other draws are made.
    ///
    /// # Errors
    /// [`OutputErrorError::TooFewClusters`] for fewer than two blocks.
    pub fn bootstrap(&self, draws: Range<u64>, seed: u64, length: f64) -> Result<Draws, OutputErrorError> {
        let blocks = self.blocks(length);
        if blocks.len() < 2 {
            return Err(OutputErrorError::TooFewClusters { clusters: blocks.len() });
        }
        let (here, priors) = (self.values(), self.prior_sums());
        let (done, count) = (AtomicUsize::new(0), draws.clone().count());
        let refit = |draw: u64| {
            look();
            let mut noise = Noise::new(seed, draw);
            let mut sums = priors.clone();
            (0..blocks.len()).for_each(|_| sums += &blocks[noise.below(blocks.len())]);
            let p = here.len();
            let step = sums.columns(0, p).into_owned().cholesky().map(|a| a.solve(&sums.column(p)));
            tell(REFITTING, done.fetch_add(1, Ordering::Relaxed) + 1, count);
            Some(here.iter().zip(step?.iter()).map(|(here, by)| here - by).collect())
        };
        let first = draws.start;
        Ok(Draws::of(draws, (0..count).into_par_iter().map(|k| refit(first + k as u64)).collect()))
    }

    /// Values of the unknowns.
    fn values(&self) -> Vec<f64> {
        self.filtered.problem.unknowns.iter().map(|u| value(&self.model, *u)).collect()
    }

    /// JᵀJ and, as the last column, Jᵀe over the unknowns, of each block of about `length` seconds.
    fn blocks(&self, length: f64) -> Vec<DMatrix<f64>> {
        let problem = &self.filtered.problem;
        let p = problem.unknowns.len();
        let steps: usize = problem.segments.iter().map(|s| s.last - s.first).sum();
        let seconds = self.filtered.sample_time() * steps as f64;
        let rows = (length * self.samples as f64 / seconds.max(f64::MIN_POSITIVE)).ceil().max(1.0) as usize;
        let products = self.filtered.products_in_blocks(&self.model, &self.noise, self.limit, rows);
        let mut blocks = Vec::new();
        for (stretch, products) in problem.segments.iter().zip(&products) {
            let columns = problem.columns_of(stretch.track);
            for product in products {
                let mut block = DMatrix::zeros(p, p + 1);
                for (i, to_i) in columns.iter().enumerate() {
                    block[(*to_i, p)] += product[(i, columns.len())];
                    for (j, to_j) in columns.iter().enumerate() {
                        block[(*to_i, *to_j)] += product[(i, j)];
                    }
                }
                // a stretch that divides into whole blocks ends with an empty one
                if block.iter().any(|x| *x != 0.0) {
                    blocks.push(block);
                }
            }
        }
        blocks
    }

    /// The priors, as a block.
    fn prior_sums(&self) -> DMatrix<f64> {
        let p = self.filtered.problem.unknowns.len();
        let mut sums = DMatrix::zeros(p, p + 1);
        for (k, unknown) in self.filtered.problem.unknowns.iter().enumerate() {
            if let Some((mean, std)) = self.model.parameters[unknown.parameter].prior {
                sums[(k, k)] = 1.0 / (std * std);
                sums[(k, p)] = (value(&self.model, *unknown) - mean) / (std * std);
            }
        }
        sums
    }

    /// Estimates of the unknowns from simulated data: the fitted model is driven by its random
    /// force and observed by its sensors, and the noise is estimated anew in each draw. The refit
    /// of a draw reads its inputs from the runs that `inputs` gives for it, e.g. if the thrust is
    /// uncertain, and from those of the fit if it gives none.
    pub fn monte_carlo_under(
        &self,
        options: &FilterErrorOptions,
        draws: Range<u64>,
        seed: u64,
        inputs: impl Fn(u64) -> Option<Vec<Run>> + Sync,
    ) -> Draws {
        // the data have the noise that the fit has found, so which forces there are is not in
        // question
        let options = FilterErrorOptions { refine: false, ..self.nearby(options) };
        let mobilities = self.filtered.mobilities(&self.model);
        let (done, count) = (AtomicUsize::new(0), draws.clone().count());
        let refit = |draw: u64| {
            look();
            let logs =
                self.filtered.logged(&self.model, &self.noise, mobilities.as_ref()?, &mut Noise::new(seed, draw));
            let mut filtered = match inputs(draw) {
                None => self.filtered.clone(),
                Some(runs) => Filtered::new(&self.model, &runs, &options.base).ok()?,
            };
            filtered.problem.tracks.iter_mut().zip(logs).for_each(|(track, log)| track.observed = log);
            filtered.restart(&self.model);
            let fit = ascent::maximised(&self.model, filtered, vec![self.noise.clone()], &options);
            tell(REFITTING, done.fetch_add(1, Ordering::Relaxed) + 1, count);
            Some(fit.ok().filter(|fit| fit.converged)?.values())
        };
        let first = draws.start;
        Draws::of(draws, (0..count).into_par_iter().map(|k| refit(first + k as u64)).collect())
    }
}

impl Filtered {
    /// Simulated sensor readings of every track, row by row as
    /// [`crate::simulate::Track::observed`], with forces and noise drawn from `noise`; NaN where
    /// there is no sample.
    fn logged(
        &self,
        model: &Model,
        noise: &NoiseModel,
        mobilities: &[DMatrix<f64>],
        drawn: &mut Noise,
    ) -> Vec<Vec<f64>> {
        let mut all: Vec<Vec<f64>> = self.problem.tracks.iter().map(|t| vec![f64::NAN; t.observed.len()]).collect();
        for (k, stretch) in self.problem.segments.iter().enumerate() {
            let batch = self.batch::<1>(model, &[k], [noise.clone()], mobilities, f64::INFINITY);
            log_stretch(batch, drawn, &mut all[stretch.track]);
        }
        all
    }
}

/// Writes the simulated sensor readings of the stretch of a batch into `log`.
fn log_stretch(batch: Batch<'_, 1>, drawn: &mut Noise, log: &mut [f64]) {
    let Batch { problem, stretches, theta, noise, mobility, mut belief, limit } = batch;
    let dynamics = &problem.dynamics;
    let (nx, ny) = (dynamics.states.len(), dynamics.outputs.len());
    let coloured: Vec<usize> = noise[0].coloured().map(|(output, _)| output).collect();
    let forces = noise[0].forces.len();
    let white: Vec<f64> = noise[0].sensors.iter().map(|s| s.std).collect();
    let stationary: Vec<f64> =
        noise[0].forces.iter().map(|f| f.rms).chain(noise[0].coloured().map(|(_, c)| c.rms)).collect();
    for (process, rms) in belief.x[nx..].iter_mut().zip(stationary) {
        process[0] = rms * drawn.normal();
    }
    let [mut rates, mut observe] = [&dynamics.rates, &dynamics.observation].map(|f| prepared(f, &theta));
    let rates = Evaluator::new(&dynamics.rates, &mut rates, nx, 0);
    let observe = Evaluator::new(&dynamics.observation, &mut observe, nx, 0);
    let variance = white.iter().map(|std| [std * std]).collect();
    let mut transition = Transition::new(dynamics, rates, noise, mobility);
    let mut sensors = Sensors::new(dynamics, observe, variance, (forces, &coloured), 0, limit);
    let mut feed = Feed::new(&problem.tracks, &stretches, dynamics.inputs.len());
    let longest = feed.steps();
    for step in 0..=longest {
        if let Some(grid) = feed.grid[0] {
            sensors.look(Plain, &feed, if step == 0 { 0 } else { 2 }, &belief.x);
            for (output, std) in white.iter().enumerate() {
                if !problem.measured(&stretches, &feed.grid, 0, output).is_nan() {
                    let ([seen], _) = sensors.expect(Plain, output, &belief);
                    log[grid * ny + output] = seen + std * drawn.normal();
                }
            }
        }
        if step < longest {
            feed.go_on(step);
            transition.predict(Plain, &feed, &mut belief);
            transition.push(&mut belief.x, drawn);
        }
    }
}
