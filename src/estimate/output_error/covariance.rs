//! Covariance of an output-error estimate.
//!
//! ```text
//! white residuals:       Σ = (JᵀJ)⁻¹ s²                              s² = cost / (samples − unknowns)
//! correlated residuals:  by clusters ([`crate::least_squares::clusters`])
//!                        g_c = Jᵀr summed over cluster c
//! ```
//!
//! J is the Jacobian by the unknowns with the initial states projected out; under a robust loss r
//! stands for ψ and JᵀJ for its curvature Σψ'. The second form requires only that residuals of
//! different clusters, stretches of some 24 s, are independent.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::{Fold, Linearised, OutputErrorError, OutputErrorFit, OutputErrorOptions, Problem, normal_factor, value};
use crate::least_squares::clusters::of_clusters;
use crate::least_squares::singular_ratio;
use crate::model::Model;

/// How standard deviations were computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StdMethod {
    /// Inverse information, for white residuals.
    Information,
    /// Sandwich over clusters of residuals.
    Clusters,
    /// Inverse information, widened by the evidence of clusters that are too few for a sandwich.
    FewClusters,
}

/// Covariance of the unknowns, and the method that the residuals require.
pub(super) fn of(
    problem: &Problem,
    model: &Model,
    segments: &[Linearised],
    options: &OutputErrorOptions,
) -> Result<(Vec<f64>, StdMethod), OutputErrorError> {
    let p = problem.unknowns.len();
    let factor = normal_factor(problem, model, segments);
    let bread = bread(problem, model, &factor)?;
    let samples: usize = segments.iter().map(|s| s.samples).sum();
    let (curved, scale) = scales(problem, segments);
    let bread: Vec<f64> = bread.iter().map(|b| b * curved).collect();
    let freedom = freedom(problem, segments);
    if !problem.loss.is_robust() && problem.is_white(segments) {
        return Ok((bread.iter().map(|b| b * scale).collect(), StdMethod::Information));
    }
    let gradients = cluster_gradients(problem, segments, options.cluster);
    let clusters = gradients.len() as f64;
    let bread = DMatrix::from_row_slice(p, p, &bread);
    let shifts: Vec<DVector<f64>> = gradients.iter().map(|g| &bread * DVector::from_column_slice(g)).collect();
    let correction = clusters / (clusters - 1.0) * samples as f64 / freedom;
    let found = of_clusters(&(bread * scale), &shifts, correction);
    let method = if found.few { StdMethod::FewClusters } else { StdMethod::Clusters };
    Ok((found.covariance.as_slice().to_vec(), method))
}

/// Samples minus unknowns and initial states, at least 1.
fn freedom(problem: &Problem, segments: &[Linearised]) -> f64 {
    let samples: usize = segments.iter().map(|s| s.samples).sum();
    samples.saturating_sub(problem.unknowns.len() + problem.free_states() * segments.len()).max(1) as f64
}

/// Factors of (JᵀJ)⁻¹: for the curvature of the loss and, if residuals are white, for their
/// variance.
fn scales(problem: &Problem, segments: &[Linearised]) -> (f64, f64) {
    let samples: usize = segments.iter().map(|s| s.samples).sum();
    let sum = |f: &dyn Fn(&Linearised) -> f64| segments.iter().map(f).sum::<f64>();
    // the factor holds J times ds/dr, whose square is not the curvature of a robust loss
    let steep = sum(&|s| s.curvature[0]);
    // if most residuals were outliers, the curvature would vanish: the standard deviations then
    // grow, tenfold at most
    let bend = sum(&|s| s.curvature[1]).max(0.1 * steep);
    (steep / bend, sum(&|s| s.pull) / freedom(problem, segments) * samples as f64 / bend)
}

/// (JᵀJ)⁻¹ of a factor, row-major.
///
/// # Errors
/// [`OutputErrorError::NotIdentified`] with the unknowns that the factor does not determine.
pub(crate) fn bread(problem: &Problem, model: &Model, factor: &Fold<1>) -> Result<Vec<f64>, OutputErrorError> {
    let p = problem.unknowns.len();
    let (weak, values): (Vec<String>, Vec<f64>) = (0..p)
        .filter(|k| {
            let length: f64 = (0..=*k).map(|i| factor.at(i, *k)[0].powi(2)).sum::<f64>().sqrt();
            factor.at(*k, *k)[0].abs() <= 1e-9 * length || length == 0.0
        })
        .map(|k| (model.parameters[problem.unknowns[k].parameter].full_name(), value(model, problem.unknowns[k])))
        .unzip();
    let Some(inverse) = factor.inverse(p).filter(|_| weak.is_empty()) else {
        return Err(OutputErrorError::NotIdentified { parameters: weak, values });
    };
    // (RᵀR)⁻¹ = R⁻¹ R⁻ᵀ
    Ok((0..p * p).map(|k| (0..p).map(|j| inverse[(k / p) * p + j] * inverse[(k % p) * p + j]).sum()).collect())
}

impl OutputErrorFit {
    /// Variance of an estimate, assuming white residuals, over that of its factor.
    pub(crate) fn white_scale(&self) -> f64 {
        let (curved, scale) = scales(&self.problem, &self.linearised);
        curved * scale
    }

    /// cond(JᵀJ), as the paper prints it for its regressors, and cond(J) with columns of unit
    /// length; J by the unknowns, with the initial states projected out.
    pub fn condition_numbers(&self) -> (f64, f64) {
        let p = self.problem.unknowns.len();
        if p == 0 {
            return (1.0, 1.0);
        }
        let factor = normal_factor(&self.problem, &self.model, &self.linearised);
        let at = |i: usize, j: usize| if i <= j { factor.at(i, j)[0] } else { 0.0 };
        let length: Vec<f64> = (0..p).map(|j| (0..=j).map(|i| at(i, j).powi(2)).sum::<f64>().sqrt()).collect();
        let ratio = |scale: &dyn Fn(usize) -> f64| {
            singular_ratio((0..p).map(|j| (0..p).map(|i| at(i, j) / scale(j)).collect()).collect())
        };
        (ratio(&|_| 1.0).powi(2), ratio(&|j| length[j]))
    }
}

/// Jᵀr of each cluster: stretches of about `length` seconds of one run.
pub(crate) fn cluster_gradients(problem: &Problem, segments: &[Linearised], length: f64) -> Vec<Vec<f64>> {
    let (nx, p) = (problem.dynamics.states.len(), problem.unknowns.len());
    let gradient = |members: &Vec<usize>| {
        let mut gradient = vec![0.0; p];
        for member in members {
            let segment = &segments[*member];
            let columns = problem.columns_of(problem.segments[*member].track);
            for (direction, column) in columns.into_iter().enumerate() {
                gradient[column] +=
                    (nx..segment.n).map(|i| segment.at(i, nx + direction) * segment.at(i, segment.n - 1)).sum::<f64>();
            }
        }
        gradient
    };
    problem.clusters(length).iter().map(gradient).collect()
}

impl Problem {
    /// Indices of the segments by cluster: stretches of about `length` seconds of one run.
    pub(crate) fn clusters(&self, length: f64) -> Vec<Vec<usize>> {
        let mut clusters: Vec<(usize, f64, Vec<usize>)> = Vec::new();
        for (k, stretch) in self.segments.iter().enumerate() {
            let begin = self.tracks[stretch.track].time[stretch.first];
            match clusters.last_mut() {
                Some((track, from, members)) if *track == stretch.track && begin - *from < length - 1e-6 => {
                    members.push(k);
                }
                _ => clusters.push((stretch.track, begin, vec![k])),
            }
        }
        clusters.into_iter().map(|(_, _, members)| members).collect()
    }

    /// Whether the costs of the segments scatter no more than those of white residuals. The
    /// variance of a sum of n squares is 2n; correlation and misfit raise it. The mean of n squares
    /// of standard normal numbers has a standard deviation of √(2/n): if the mean is more than 2.33
    /// of these above 1, residuals count as not white, which is a false alarm once in a hundred.
    pub(crate) fn is_white(&self, segments: &[Linearised]) -> bool {
        let states = self.dynamics.states.len() as f64;
        let total: f64 = segments.iter().map(Linearised::cost).sum();
        let freedom: f64 = segments.iter().map(|s| s.samples as f64 - states).sum();
        let scale = total / freedom.max(1.0);
        let n = segments.len() as f64;
        let spread: f64 = segments
            .iter()
            .map(|s| {
                let expected = s.samples as f64 - states;
                (s.cost() / scale - expected).powi(2) / (2.0 * expected.max(1.0))
            })
            .sum::<f64>();
        spread / n < 1.0 + 2.33 * (2.0 / n).sqrt()
    }
}
