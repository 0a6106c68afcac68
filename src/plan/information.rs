//! Information of runs on the free parameters of a model, as a triangular factor.
//!
//! ```text
//! F = RᵀR = JᵀJ        [R₁; R₂] = Q R   for two sets of runs        Σ = F⁻¹ = R⁻¹R⁻ᵀ
//! ```
//!
//! J is the Jacobian of the logged samples over their noise, with respect to the parameters that all runs share;
//! initial states and per-run parameters are projected out. F is never formed. If a random force acts on the vehicle,
//! J is that of the innovations of a Kalman filter over their standard deviations: information that the force hides
//! does not count.

use crate::estimate::filter_error::{Filtered, NoiseModel, RandomForce, SensorNoise};
use crate::estimate::output_error::{Fold, Linearised, OutputErrorError, OutputErrorOptions, Problem, normal_factor};
use crate::model::Model;
use crate::run::Run;

/// Information on `parameters`.
#[derive(Debug, Clone)]
pub struct Information {
    /// Indices of its parameters in the model: the free ones that all runs share.
    pub parameters: Vec<usize>,
    /// Upper triangle R, row-major.
    r: Vec<f64>,
}

/// Mean square of the residual, in units of the noise, up to which a linearisation about a simulated run is valid.
const NEAR: f64 = 0.1;

/// Free parameters of `model` that all runs share.
pub(super) fn shared(model: &Model) -> Vec<usize> {
    model.free().into_iter().filter(|p| !model.parameters[*p].spec.per_run).collect()
}

impl Information {
    /// No information.
    pub fn none(parameters: Vec<usize>) -> Information {
        let p = parameters.len();
        Information { parameters, r: vec![0.0; p * p] }
    }

    /// Information that a fit with these options would gain from `run`, a noise-free log simulated by `model`. The
    /// fit is by filter error with the random `forces` that will act on the vehicle, possibly none (the Cramér-Rao
    /// bound with the force); by output error if they are `None`.
    ///
    /// # Errors
    /// [`OutputErrorError`] when the run lacks what the model reads or logs nothing that the model predicts.
    pub fn of(
        model: &Model,
        run: &Run,
        options: &OutputErrorOptions,
        forces: Option<&[RandomForce]>,
    ) -> Result<Information, OutputErrorError> {
        let mut model = model.clone();
        for parameter in &mut model.parameters {
            parameter.prior = None;
        }
        if let Some(forces) = forces {
            let filtered = Filtered::new(&model, std::slice::from_ref(run), options)?;
            let sensors = filtered.problem.sigma.iter().map(|std| SensorNoise { std: *std, coloured: None });
            let noise = NoiseModel { forces: forces.to_vec(), sensors: sensors.collect() };
            let diverges = || OutputErrorError::Diverges { values: "a singular inertia".into() };
            let factor = filtered.information_factor(&model, &noise).ok_or_else(diverges)?;
            return Ok(Information::beside_own(&model, &filtered.problem, &factor));
        }
        let linearised = |options: &OutputErrorOptions| -> Result<(Problem, Vec<Linearised>), OutputErrorError> {
            let problem = Problem::new(&model, std::slice::from_ref(run), options)?;
            let segments = problem.linearise(&model, &problem.initial_states(&model));
            Ok((problem, segments))
        };
        let (mut problem, mut segments) = linearised(options)?;
        if options.join {
            // a fit that joins its segments has one initial state per run, unless the motion is unstable
            let whole = linearised(&OutputErrorOptions { segment: f64::INFINITY, ..options.clone() })?;
            let cost: f64 = whole.1.iter().map(Linearised::cost).sum();
            let samples: usize = whole.1.iter().map(|s| s.samples).sum();
            if cost < NEAR * samples as f64 {
                (problem, segments) = whole;
            }
        }
        Ok(Information::beside_own(&model, &problem, &normal_factor(&problem, &model, &segments)))
    }

    /// Information on the shared parameters, from a factor for all unknowns of a run, the others being unknown.
    fn beside_own(model: &Model, problem: &Problem, factor: &Fold<1>) -> Information {
        // this run's own unknowns come first, so that the lower rows hold the information on the others beside them
        let own = |k: &usize| problem.unknowns[*k].run.is_some();
        let all = problem.unknowns.len();
        let order: Vec<usize> = (0..all).filter(own).chain((0..all).filter(|k| !own(k))).collect();
        let nuisance = (0..all).filter(own).count();
        let mut sorted = Fold::<1>::new(all);
        for i in 0..all {
            sorted.push(order.iter().map(|k| [if *k >= i { factor.at(i, *k)[0] } else { 0.0 }]));
        }
        sorted.fold();
        let parameters = shared(model);
        let p = parameters.len();
        let at = |k: usize| if k % p >= k / p { sorted.at(nuisance + k / p, nuisance + k % p)[0] } else { 0.0 };
        Information { r: (0..p * p).map(at).collect(), parameters }
    }

    /// Information of a covariance of `parameters` (row-major); `None` if the covariance is not positive definite.
    pub fn of_covariance(parameters: Vec<usize>, covariance: &[f64]) -> Option<Information> {
        let p = parameters.len();
        let std: Vec<f64> = (0..p).map(|k| covariance[k * p + k].sqrt()).collect();
        if std.iter().any(|s| !(s.is_finite() && *s > 0.0)) {
            return None;
        }
        let correlation = nalgebra::DMatrix::from_fn(p, p, |i, j| covariance[i * p + j] / (std[i] * std[j]));
        let inverse = correlation.cholesky()?.l().try_inverse()?;
        let mut fold = Fold::<1>::new(p.max(1));
        for i in 0..p {
            fold.push((0..p).map(|j| [inverse[(i, j)] / std[j]]));
        }
        fold.fold();
        Some(Information { r: upper(&fold, p), parameters })
    }

    /// Information of independent knowledge with these standard deviations.
    pub(super) fn of_deviations(parameters: Vec<usize>, std: &[f64]) -> Information {
        let p = parameters.len();
        let r = (0..p * p).map(|k| if k / p == k % p { 1.0 / std[k % p] } else { 0.0 }).collect();
        Information { parameters, r }
    }

    /// Sum of these pieces of information, which must be about the same parameters.
    pub fn together<'a>(parts: impl IntoIterator<Item = &'a Information>, parameters: &[usize]) -> Information {
        let p = parameters.len();
        let mut fold = Fold::<1>::new(p.max(1));
        for part in parts {
            for row in part.r.chunks_exact(p.max(1)) {
                fold.push(row.iter().map(|x| [*x]));
            }
        }
        fold.fold();
        Information { r: upper(&fold, p), parameters: parameters.to_vec() }
    }

    /// Covariance of the parameters, row-major; `None` if some combination of them is not identifiable.
    pub fn covariance(&self) -> Option<Vec<f64>> {
        let p = self.parameters.len();
        let inverse = self.inverse()?;
        let sum = |a: usize, b: usize| (a.max(b)..p).map(|j| inverse[a * p + j] * inverse[b * p + j]).sum();
        Some((0..p * p).map(|k| sum(k / p, k % p)).collect())
    }

    /// Standard deviations; `None` if some combination of the parameters is not identifiable.
    pub fn deviations(&self) -> Option<Vec<f64>> {
        let p = self.parameters.len();
        let inverse = self.inverse()?;
        Some((0..p).map(|k| inverse[k * p..(k + 1) * p].iter().map(|x| x * x).sum::<f64>().sqrt()).collect())
    }

    /// R⁻¹, row-major.
    fn inverse(&self) -> Option<Vec<f64>> {
        let p = self.parameters.len();
        let mut fold = Fold::<1>::new(p.max(1));
        for row in self.r.chunks_exact(p.max(1)) {
            fold.push(row.iter().map(|x| [*x]));
        }
        fold.fold();
        fold.inverse(p)
    }
}

fn upper(fold: &Fold<1>, p: usize) -> Vec<f64> {
    (0..p * p).map(|k| if k % p >= k / p { fold.at(k / p, k % p)[0] } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Covariance → information → covariance, to rounding; twice the information is half the variance.
    #[test]
    fn law_information_and_covariance_are_inverse() {
        let covariance = [4.0, 1.0, -0.2, 1.0, 9.0, 0.3, -0.2, 0.3, 0.1];
        let one = Information::of_covariance(vec![0, 1, 2], &covariance).unwrap();
        for (found, exact) in one.covariance().unwrap().iter().zip(&covariance) {
            assert!((found - exact).abs() < 1e-13 * 9.0, "{found} {exact}");
        }
        let two = Information::together([&one, &one], &one.parameters);
        for (found, exact) in two.deviations().unwrap().iter().zip([4.0_f64, 9.0, 0.1]) {
            assert!((found - (exact / 2.0).sqrt()).abs() < 1e-13 * found);
        }
    }

    #[test]
    fn what_is_no_covariance_or_shows_nothing_is_none() {
        assert!(Information::of_covariance(vec![0, 1], &[1.0, 2.0, 2.0, 1.0]).is_none());
        assert!(Information::of_covariance(vec![0], &[0.0]).is_none());
        assert!(Information::none(vec![0, 1]).deviations().is_none());
    }
}
