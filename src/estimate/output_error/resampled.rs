//! Scatter of an output-error estimate by refits: on resampled stretches, and on simulated data.
//!
//! ```text
//! block bootstrap   θ* = θ̂ − (Σ_c n_c J_cᵀJ_c)⁻¹ Σ_c n_c J_cᵀ r_c        clusters c drawn with replacement
//! Monte Carlo       θ* = the fit of ŷ + e,   e white, with the residuals' standard deviation
//! ```
//!
//! The bootstrap takes one Gauss-Newton step from the estimate, with factors that are at hand:
//! thousands of draws take seconds. It requires that stretches of some 24 s are independent of each
//! other, not that residuals are white. Monte Carlo requires that the model is right, and repeats
//! the whole fit; it shows bias and skewness, which no covariance does. Efron and Tibshirani, *An
//! Introduction to the Bootstrap* (1993), ch. 6 and 9.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::problem::LANES;
use super::{OutputErrorError, OutputErrorFit, OutputErrorOptions, Problem, fit_from, value};
use crate::least_squares::{Draws, REFITTING, Triangle, resample};
use crate::model::Model;
use crate::noise::Noise;
use crate::progress::{look, tell};
use crate::run::Run;
use crate::simulate::{Emission, integrate_fast};

impl OutputErrorFit {
    /// Estimates of the unknowns on resamplings of clusters of about `length` seconds, for the draws
    /// of these numbers. A draw is the same whichever other draws are made.
    ///
    /// # Errors
    /// [`OutputErrorError::TooFewClusters`] for fewer than two clusters: a joined fit has few.
    pub fn bootstrap(&self, draws: Range<u64>, seed: u64, length: f64) -> Result<Draws, OutputErrorError> {
        let clusters = self.problem.clusters(length);
        if clusters.len() < 2 {
            return Err(OutputErrorError::TooFewClusters { clusters: clusters.len() });
        }
        let factors: Vec<Triangle> = clusters.iter().map(|members| self.factor_of(members)).collect();
        let here: Vec<f64> = self.problem.unknowns.iter().map(|u| value(&self.model, *u)).collect();
        let mut found = resample(&self.priors(), &factors, draws, seed);
        for step in &mut found.values {
            step.iter_mut().zip(&here).for_each(|(x, here)| *x = here - *x);
        }
        Ok(found)
    }

    /// The factor of the information of some segments on the unknowns, and of their residuals.
    fn factor_of(&self, members: &[usize]) -> Triangle {
        let (nx, p) = (self.problem.dynamics.states.len(), self.problem.unknowns.len());
        let mut rows = Vec::new();
        for member in members {
            let segment = &self.linearised[*member];
            let columns = self.problem.columns_of(self.problem.segments[*member].track);
            for i in nx..segment.n {
                let mut row = vec![0.0; p + 1];
                for (direction, column) in columns.iter().enumerate() {
                    row[*column] = segment.at(i, nx + direction);
                }
                row[p] = segment.at(i, segment.n - 1);
                rows.push(row);
            }
        }
        Triangle::of_rows(p + 1, &rows)
    }

    /// The factor of the priors.
    fn priors(&self) -> Triangle {
        let p = self.problem.unknowns.len();
        let prior = |(k, unknown): (usize, &super::Unknown)| {
            let (mean, std) = self.model.parameters[unknown.parameter].prior?;
            let mut row = vec![0.0; p + 1];
            row[k] = 1.0 / std;
            row[p] = (value(&self.model, *unknown) - mean) / std;
            Some(row)
        };
        let rows: Vec<Vec<f64>> = self.problem.unknowns.iter().enumerate().filter_map(prior).collect();
        Triangle::of_rows(p + 1, &rows)
    }

    /// Estimates of the unknowns from `draws` sets of data simulated with the fitted model, with
    /// white noise of the size of the residuals. The refit of a draw reads its inputs from the runs
    /// that `inputs` gives for it, e.g. if the thrust is uncertain, and from those of the fit if it
    /// gives none.
    pub fn monte_carlo_under(
        &self,
        options: &OutputErrorOptions,
        draws: Range<u64>,
        seed: u64,
        inputs: impl Fn(u64) -> Option<Vec<Run>> + Sync,
    ) -> Draws {
        let clean = self.problem.predicted(&self.model, &self.initial_states);
        let (done, count) = (AtomicUsize::new(0), draws.clone().count());
        let refit = |draw: u64| {
            look();
            let problem = match inputs(draw) {
                None => self.problem.clone(),
                Some(runs) => {
                    let tracks = Problem::new(&self.model, &runs, options).ok()?.tracks;
                    Problem { tracks, ..self.problem.clone() }
                }
            };
            let problem = self.with_noise(problem, &clean, &mut Noise::new(seed, draw));
            let fit = fit_from(&self.model, problem, self.initial_states.clone(), options);
            tell(REFITTING, done.fetch_add(1, Ordering::Relaxed) + 1, count);
            let fit = fit.ok().filter(|fit| fit.converged)?;
            Some(fit.problem.unknowns.iter().map(|u| value(&fit.model, *u)).collect())
        };
        let first = draws.start;
        Draws::of(draws, (0..count).into_par_iter().map(|k| refit(first + k as u64)).collect())
    }

    /// The problem with `clean` and fresh noise in place of the measurements.
    fn with_noise(&self, mut problem: Problem, clean: &[Vec<f64>], noise: &mut Noise) -> Problem {
        let width = problem.dynamics.outputs.len();
        for (track, clean) in problem.tracks.iter_mut().zip(clean) {
            for (k, (y, clean)) in track.observed.iter_mut().zip(clean).enumerate() {
                if !y.is_nan() {
                    *y = clean + self.residual_rms[k % width] * noise.normal();
                }
            }
        }
        problem
    }
}

impl Problem {
    /// The outputs of the model at every grid point of every track, row by row as
    /// [`crate::simulate::Track::observed`]; NaN outside segments.
    pub(crate) fn predicted(&self, model: &Model, x0: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut all: Vec<Vec<f64>> = self.tracks.iter().map(|t| vec![f64::NAN; t.observed.len()]).collect();
        let width = self.dynamics.outputs.len();
        let order: Vec<usize> = (0..self.segments.len()).collect();
        for batch in order.chunks(LANES) {
            let (stretches, theta, start) = self.lanes::<LANES>(model, x0, batch);
            integrate_fast(&self.dynamics, &self.tracks, &stretches, &theta, &start, false, &mut |at: &Emission<
                '_,
                LANES,
            >| {
                for lane in 0..LANES {
                    let (Some(stretch), Some(grid)) = (stretches[lane], at.grid[lane]) else { continue };
                    for output in 0..width {
                        all[stretch.track][grid * width + output] = at.outputs[output][lane];
                    }
                }
            });
        }
        all
    }
}
