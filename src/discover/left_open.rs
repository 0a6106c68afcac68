//! What the data leave open of a simulation: noise on the first seconds of a run and on the runs of the fit.
//!
//! ```text
//! x̂₀ = x₀ + Rₓ⁻¹ (ε − Rₓθ δθ)             R: factor of the first seconds of the run, by initial state and parameters
//! δy(t) = ∂y/∂x₀ Rₓ⁻¹ ε + g δθ            g = ∂y/∂θ − ∂y/∂x₀ Rₓ⁻¹ Rₓθ
//! var δy = τ(n) |Rₓ⁻ᵀ (∂y/∂x₀)ᵀ|² + τ(m) gᵀ (JᵀJ)⁻¹ g       in units of the noise
//! ```
//!
//! ε: noise on n samples; J: Jacobian of the fit, segments of m samples; τ allows for the colour of the noise
//! ([`super::colour`]). Of the residuals of the fit nothing is asked: what a missing effect leaves in them must not pass
//! for something that the data leave open. Where the motion is unstable δy grows without bound.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::colour::{colours, taken_up};
use super::gap::{Sums, beginning, rms, started_anew, stretch_of, variance};
use crate::estimate::output_error::{
    Linearised, OutputErrorError, OutputErrorFit, OutputErrorOptions, Problem, normal_factor,
};
use crate::frame::Measured;
use crate::run::Run;
use crate::simulate::{Emission, Stretch, integrate_fast, values_in_run};

/// For each of `runs` the root mean square over the run of what the data leave open of its simulation, in units of the
/// noise, by what is measured; NaN where the motion has run away altogether.
///
/// # Errors
/// As [`super::gap`].
pub fn left_open(
    fit: &OutputErrorFit,
    runs: &[Run],
    options: &OutputErrorOptions,
) -> Result<Vec<BTreeMap<Measured, f64>>, OutputErrorError> {
    let uncertain = Uncertain::of(fit);
    runs.iter().map(|run| of_run(fit, &uncertain, run, options)).collect()
}

/// Which runs cannot be simulated whole, however good the model: what is [`left_open`] of a velocity outgrows the noise.
pub fn unstable(left_open: &[BTreeMap<Measured, f64>]) -> Vec<bool> {
    let velocity = |measured: &Measured| matches!(measured, Measured::Velocity(_));
    let away = |size: &f64| size.is_nan() || *size > 1.0;
    left_open.iter().map(|run| run.iter().any(|(measured, size)| velocity(measured) && away(size))).collect()
}

/// The parameters that all runs share, and their covariance under white noise of the assumed size.
struct Uncertain {
    parameters: Vec<usize>,
    covariance: DMatrix<f64>,
    /// Samples of a segment of the fit.
    samples: f64,
}

impl Uncertain {
    fn of(fit: &OutputErrorFit) -> Uncertain {
        let problem = &fit.problem;
        let p = problem.unknowns.len();
        let shared: Vec<usize> = (0..p).filter(|k| problem.unknowns[*k].run.is_none()).collect();
        let inverse =
            normal_factor(problem, &fit.model, &fit.linearised).inverse(p).unwrap_or_else(|| vec![0.0; p * p]);
        let element = |i: usize, j: usize| {
            let (i, j) = (shared[i], shared[j]);
            (0..p).map(|k| inverse[i * p + k] * inverse[j * p + k]).sum::<f64>()
        };
        let points: usize = problem.segments.iter().map(|s| s.last - s.first + 1).sum();
        Uncertain {
            covariance: DMatrix::from_fn(shared.len(), shared.len(), element),
            parameters: shared.into_iter().map(|k| problem.unknowns[k].parameter).collect(),
            samples: points as f64 / problem.segments.len().max(1) as f64,
        }
    }

    /// gᵀ C g for the parameters `directions`.
    fn variance(&self, directions: &[usize], g: &DVector<f64>) -> f64 {
        let at = |parameter: &usize| directions.iter().position(|d| d == parameter).map_or(0.0, |d| g[d]);
        let g = DVector::from_iterator(self.parameters.len(), self.parameters.iter().map(at));
        g.dot(&(&self.covariance * &g))
    }
}

fn of_run(
    fit: &OutputErrorFit,
    uncertain: &Uncertain,
    run: &Run,
    options: &OutputErrorOptions,
) -> Result<BTreeMap<Measured, f64>, OutputErrorError> {
    let colour = colours(&started_anew(&fit.model, run, options)?).into_iter().fold(0.0, f64::max);
    let mut settled = beginning(&fit.model, run, options)?;
    for (parameter, original) in settled.model.parameters.iter_mut().zip(&fit.model.parameters) {
        parameter.fixed = original.fixed || original.spec.per_run;
    }
    let (segments, sigma) = (settled.problem.segments.clone(), settled.problem.sigma.clone());
    let moving = Problem::new(&settled.model, std::slice::from_ref(run), options)?;
    settled.problem = Problem { segments, sigma, ..moving };
    settled.linearised = settled.problem.linearise(&settled.model, &settled.initial_states);
    let mut sums = Sums::new();
    let stretches = settled.problem.segments.iter().zip(&settled.linearised).zip(&settled.initial_states);
    for ((segment, linear), start) in stretches {
        let first = taken_up(colour, (segment.last - segment.first + 1) as f64);
        let weights = (first, taken_up(colour, uncertain.samples));
        for (measured, (squares, count)) in
            along(&settled, uncertain, &stretch_of(&settled, segment), (linear, start), weights)
        {
            let sum = sums.entry(measured).or_default();
            sum.0 += squares;
            sum.1 += count;
        }
    }
    Ok(rms(&sums))
}

/// Squares of what is open of each thing measured along a stretch, in units of its noise, and their number.
fn along(
    fit: &OutputErrorFit,
    uncertain: &Uncertain,
    stretch: &Stretch,
    (linear, start): (&Linearised, &[f64]),
    (of_state, of_fit): (f64, f64),
) -> Sums {
    let dynamics = &fit.problem.dynamics;
    let (nx, nd) = (dynamics.states.len(), dynamics.directions.len());
    let theta: Vec<[f64; 1]> =
        values_in_run(&fit.model, fit.problem.tracks[stretch.track].run).iter().map(|v| [*v]).collect();
    let start: Vec<[f64; 1]> = start.iter().map(|v| [*v]).collect();
    let follows = followed(linear, nx, nd);
    let column = |measured: &Measured| dynamics.outputs.iter().position(|o| *o == measured.channel());
    let outputs: Vec<(Measured, usize)> =
        fit.model.measured().into_iter().filter_map(|m| column(&m).map(|k| (m, k))).collect();
    let (mut sums, mut count) = (vec![0.0; outputs.len()], 0.0);
    let mut take = |at: &Emission<'_, 1>| {
        count += 1.0;
        for (sum, (_, output)) in sums.iter_mut().zip(&outputs) {
            let row = &at.jacobian[output * (nx + nd)..(output + 1) * (nx + nd)];
            let g =
                DVector::from_fn(nd, |d, _| row[nx + d][0] - (0..nx).map(|i| row[i][0] * follows[(i, d)]).sum::<f64>());
            let open =
                of_state * variance(linear, nx, |i| row[i][0]) + of_fit * uncertain.variance(&dynamics.directions, &g);
            *sum += open / fit.problem.sigma[*output].powi(2);
        }
    };
    integrate_fast(dynamics, &fit.problem.tracks, &[Some(*stretch)], &theta, &start, true, &mut take);
    outputs.into_iter().zip(sums).map(|((measured, _), sum)| (measured, (sum, count))).collect()
}

/// Rₓ⁻¹ Rₓθ: how the initial state that fits the first seconds goes with the parameters; 0 for a state of which they say
/// nothing.
fn followed(linear: &Linearised, nx: usize, nd: usize) -> DMatrix<f64> {
    let mut follows = DMatrix::<f64>::zeros(nx, nd);
    for i in (0..nx).rev() {
        let pivot = linear.at(i, i);
        for d in 0..nd {
            let known: f64 = (i + 1..nx).map(|j| linear.at(i, j) * follows[(j, d)]).sum();
            follows[(i, d)] = if pivot == 0.0 { 0.0 } else { (linear.at(i, nx + d) - known) / pivot };
        }
    }
    follows
}
