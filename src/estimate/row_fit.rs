//! Solution of the rows of the regression.
//!
//! ```text
//! per unit inertia (4):   Δνᵢ = (1/m) [y − Σ θⱼ cⱼ]      θⱼ = −aⱼ/a_y,  m = 1/a_y,  std by the delta method
//! as a force:             Σ θⱼ cⱼ = y
//! ```

use std::collections::BTreeSet;

use super::{Column, Columns, RegressorOptions};
use crate::frame::Dof;
use crate::least_squares::{Fit, LeastSquaresError, LeastSquaresOptions, Names, StdMethod, least_squares_with};
use crate::model::Model;

/// Options of integral least squares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct IntegralOptions {
    /// How the rows are made.
    pub regressor: RegressorOptions,
    /// How standard deviations are computed.
    pub std: StdMethod,
    /// What is done if several degrees of freedom share free parameters.
    pub together: Together,
}

/// How balances that share free parameters are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Together {
    /// With the increments of the velocities on the left, as for a balance alone: noise does not
    /// shrink the inertias.
    #[default]
    PerInertia,
    /// As forces, linear: there is always a solution, but noise shrinks the inertias. For starting
    /// values.
    AsForces,
}

/// Parameters estimated from rows.
#[derive(Debug, Clone)]
pub struct RowFit {
    /// Degrees of freedom whose rows took part.
    pub dofs: Vec<Dof>,
    /// The parameters.
    pub parameters: Vec<Column>,
    /// Their values, SI.
    pub values: Vec<f64>,
    /// Their covariance.
    pub covariance: Vec<Vec<f64>>,
    /// Their standard deviations by (14).
    pub std_paper: Vec<f64>,
    /// Parameters of these balances that would lie outside their bounds and are held there.
    pub at_bound: Vec<AtBound>,
    /// Whether the rows form too few independent stretches for the covariance of correlated
    /// residuals.
    pub few_clusters: bool,
    /// Number of rows.
    pub rows: usize,
    /// Standard deviation of the residual: per unit inertia m/s or rad/s, else N·s or N·m·s.
    pub residual_std: f64,
    /// cond(HᵀH), as the paper prints.
    pub condition_number: f64,
    /// cond(H) with columns of unit length.
    pub condition_number_scaled: f64,
}

impl RowFit {
    /// A solution as forces or, if `at` is the column of the inertia, per unit of it: the
    /// right-hand side then stands in that column. `covariance` is that of the solution.
    pub(super) fn of(
        fit: &Fit,
        at: Option<usize>,
        covariance: &[Vec<f64>],
        parameters: &[Column],
        dofs: &[Dof],
    ) -> RowFit {
        let unit = |matrix: &[Vec<f64>]| at.map_or_else(|| matrix.to_vec(), |at| per_unit_inertia(fit, at, matrix));
        let paper = unit(&fit.covariance);
        let values = match at {
            None => fit.coefficients.clone(),
            Some(at) => {
                let scale = fit.coefficients[at];
                let value = |(j, c): (usize, &f64)| if j == at { 1.0 / scale } else { -c / scale };
                fit.coefficients.iter().enumerate().map(value).collect()
            }
        };
        RowFit {
            dofs: dofs.to_vec(),
            parameters: parameters.to_vec(),
            values,
            covariance: unit(covariance),
            std_paper: (0..paper.len()).map(|k| paper[k][k].max(0.0).sqrt()).collect(),
            at_bound: Vec::new(),
            few_clusters: false,
            rows: fit.rows,
            residual_std: fit.residual_std,
            condition_number: fit.condition_number,
            condition_number_scaled: fit.condition_number_scaled,
        }
    }

    /// Standard deviation of parameter `k`.
    pub fn std(&self, k: usize) -> f64 {
        self.covariance[k][k].max(0.0).sqrt()
    }

    /// Writes values and standard deviations into `model`.
    pub fn write_to(&self, model: &mut Model) {
        let every: Vec<usize> = self.parameters.iter().map(|c| c.parameter).collect();
        self.write_some(&every, model);
    }

    /// Writes values and standard deviations of the parameters `kept` alone.
    pub fn write_some(&self, kept: &[usize], model: &mut Model) {
        for (k, column) in self.parameters.iter().enumerate().filter(|(_, c)| kept.contains(&c.parameter)) {
            let parameter = &mut model.parameters[column.parameter];
            match column.run {
                None => parameter.value = self.values[k],
                Some(run) => {
                    let length = parameter.per_run.len().max(run + 1);
                    parameter.per_run.resize(length, parameter.value);
                    parameter.per_run[run] = self.values[k];
                }
            }
            parameter.std = Some(self.std(k));
        }
    }
}

/// A parameter that is held at its bound.
#[derive(Debug, Clone, PartialEq)]
pub struct AtBound {
    /// Index of the parameter in the model.
    pub parameter: usize,
    /// Estimate from the rows without the bound, SI.
    pub unbounded: f64,
    /// Standard deviation of that estimate.
    pub std: f64,
}

/// Solves rows: per unit of the inertia if its parameter is a column, else as forces.
///
/// # Errors
/// [`LeastSquaresError`].
pub fn fit_rows(columns: &Columns, inertia: Option<usize>, method: StdMethod) -> Result<RowFit, LeastSquaresError> {
    let blocks: Vec<_> = columns.blocks.iter().map(|b| b.rows.clone()).collect();
    let names: Vec<String> = columns.parameters.iter().map(|c| c.name.clone()).collect();
    let mut h = columns.slices();
    let at = inertia.and_then(|p| columns.column_of(p));
    let y = match at {
        None => columns.rhs.as_slice(),
        Some(at) => std::mem::replace(&mut h[at], &columns.rhs),
    };
    let options = LeastSquaresOptions { names: Names { columns: names, response: None }, ..Default::default() };
    let fit = least_squares_with(&h, y, &options)?;
    let covariance = fit.covariance_by(method, &h, y, &blocks)?;
    let dofs: BTreeSet<Dof> = columns.blocks.iter().map(|b| b.dof).collect();
    Ok(RowFit::of(&fit, at, &covariance, &columns.parameters, &dofs.into_iter().collect::<Vec<_>>()))
}

/// Covariance of (m, θ) from that of (1/m, −θ/m), by the delta method.
fn per_unit_inertia(fit: &Fit, at: usize, covariance: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let (p, scale) = (fit.coefficients.len(), fit.coefficients[at]);
    let jacobian = |i: usize, j: usize| match (i == at, j == at) {
        (true, true) => -1.0 / (scale * scale),
        (true, false) => 0.0,
        (false, true) => fit.coefficients[i] / (scale * scale),
        (false, false) if i == j => -1.0 / scale,
        (false, false) => 0.0,
    };
    let product = |a: &dyn Fn(usize, usize) -> f64, b: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..p).map(|i| (0..p).map(|j| (0..p).map(|k| a(i, k) * b(k, j)).sum()).collect()).collect()
    };
    let half = product(&jacobian, &|k, j| covariance[k][j]);
    product(&|i, k| half[i][k], &|k, j| jacobian(j, k))
}
