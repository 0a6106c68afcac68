//! Least squares on integral regressors.
//!
//! ```text
//! per unit inertia (4):   Δνᵢ = (1/m) [y − Σ θⱼ cⱼ]        θⱼ = −aⱼ/a_y,  m = 1/a_y,  deviations by the delta method
//! as a force:             Σ θⱼ cⱼ = y
//! ```
//!
//! The paper's form is the first: the noise of the velocity's increment then stands on the left, where least squares
//! expects it. As a regressor it would pull the inertia towards zero. Where several degrees of freedom share a free
//! parameter (tied Coriolis terms) they are solved together, weighed by their residuals, and the increment on the left as
//! well: see [`super::shared`].

use std::collections::BTreeSet;

use thiserror::Error;

use super::coupling_noise::{Members, calibrate, noise_of, shaken};
use super::shared::{Member, settled};
use super::{Block, Column, Columns, RegressorError, RegressorOptions, regressors_of};
use crate::frame::Dof;
use crate::least_squares::{Fit, LeastSquaresError, LeastSquaresOptions, Names, StdMethod, least_squares_with};
use crate::model::{Model, Parameter};
use crate::run::Run;

/// Why a fit by integral least squares is not possible.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum IntegralError {
    /// There is no linear regressor.
    #[error(transparent)]
    Regressor(#[from] RegressorError),
    /// The rows do not determine the parameters.
    #[error("{dofs}: {source}")]
    Linear {
        /// Degrees of freedom solved.
        dofs: String,
        /// What is wrong.
        source: LeastSquaresError,
    },
    /// Inertias that several balances share need the rows themselves.
    #[error(
        "{dofs}: the balances share their inertias, which cannot be found without bias from a log that is read piece by \
         piece; fit without --stream, by estimator = \"filter_error\" where the log is too large to keep, or with \
         coriolis = \"free\""
    )]
    SharedInStream {
        /// Degrees of freedom that share them.
        dofs: String,
    },
    /// Inertias that several balances share cannot be told from the noise.
    #[error(
        "{dofs}: integral least squares finds no inertias that these balances can share: in a row the velocities change by \
         less than their noise, or an inertia would be negative; use estimator = \"filter_error\", longer rows \
         (stage.oscillatory.window), or coriolis = \"free\""
    )]
    NotSettled {
        /// Degrees of freedom solved together.
        dofs: String,
    },
}

/// How integral least squares is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct IntegralOptions {
    /// Rows.
    pub regressor: RegressorOptions,
    /// Standard deviations.
    pub std: StdMethod,
    /// What is done where several degrees of freedom share free parameters.
    pub together: Together,
}

/// How balances that share free parameters are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Together {
    /// With the increments of the velocities on the left, as one alone is: noise does not shrink the inertias.
    #[default]
    PerInertia,
    /// As forces, linear: always a solution, with inertias that noise shrinks. For starting values.
    AsForces,
}

/// Parameters estimated from rows.
#[derive(Debug, Clone)]
pub struct RowFit {
    /// Degrees of freedom whose rows took part.
    pub dofs: Vec<Dof>,
    /// Which parameters.
    pub parameters: Vec<Column>,
    /// Their values, SI.
    pub values: Vec<f64>,
    /// Their covariance.
    pub covariance: Vec<Vec<f64>>,
    /// Their standard deviations by (14).
    pub std_paper: Vec<f64>,
    /// Parameters of these balances that would lie outside of their bounds and are held there.
    pub at_bound: Vec<AtBound>,
    /// Whether the rows fall into too few independent stretches for the covariance of correlated residuals.
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
    /// A solution as forces, or where `at` is the column of the inertia, per unit of it: then the right-hand side stands
    /// there. `covariance` is that of the solution.
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

    /// Writes those of the parameters `kept` alone.
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
    /// Which parameter of the model.
    pub parameter: usize,
    /// What the rows give without the bound, SI.
    pub unbounded: f64,
    /// Standard deviation of that.
    pub std: f64,
}

/// Solves rows: per unit of the inertia where its parameter is a column, else as forces.
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

/// Degrees of freedom that share free parameters.
struct Group {
    free: BTreeSet<usize>,
    members: Vec<(Dof, Columns)>,
}

/// Fits the free parameters of `model` to `runs` within their bounds; returns the model with values and standard deviations
/// written in, and what is known of each fit. Degrees of freedom that share no free parameter are fitted apart.
///
/// Linear least squares knows no bounds: of the parameters that end outside of theirs the one that is farthest outside, in
/// deviations, is held at its bound, and the others are fitted again.
///
/// # Errors
/// [`IntegralError`].
pub fn integral_least_squares(
    runs: &[&Run],
    model: &Model,
    options: IntegralOptions,
) -> Result<(Model, Vec<RowFit>), IntegralError> {
    within_bounds(model, |model| balances(runs, model, &model.dofs, options))
}

/// Fits by `fit`, holding at its bound what it takes outside of it.
///
/// # Errors
/// Those of `fit`.
pub(super) fn within_bounds(
    model: &Model,
    mut fit: impl FnMut(&Model) -> Result<(Model, Vec<RowFit>), IntegralError>,
) -> Result<(Model, Vec<RowFit>), IntegralError> {
    let mut within = model.clone();
    let mut held: Vec<AtBound> = Vec::new();
    loop {
        let (mut fitted, mut fits) = fit(&within)?;
        let Some(at_bound) = farthest_outside(&fitted) else {
            for known in &held {
                fitted.parameters[known.parameter].fixed = false;
                fitted.parameters[known.parameter].std = None;
                let dof = fitted.parameters[known.parameter].place.dof;
                let own = fits.iter().position(|fit| dof.is_some_and(|dof| fit.dofs.contains(&dof)));
                if let Some(fit) = fits.get_mut(own.unwrap_or(0)) {
                    fit.at_bound.push(known.clone());
                }
            }
            return Ok((fitted, fits));
        };
        let parameter = &mut within.parameters[at_bound.parameter];
        parameter.value = at_bound.unbounded.clamp(parameter.min, parameter.max);
        parameter.fixed = true;
        held.push(at_bound);
    }
}

/// The free parameter that lies farthest outside of its bounds, in deviations; values of single runs are left as they are.
fn farthest_outside(fitted: &Model) -> Option<AtBound> {
    let outside = |p: &Parameter| {
        let off = (p.min - p.value).max(p.value - p.max);
        let free = !p.fixed && p.per_run.is_empty();
        (free && off > 0.0).then(|| off / p.std.unwrap_or(0.0).max(f64::MIN_POSITIVE))
    };
    let off = fitted.parameters.iter().enumerate().filter_map(|(k, p)| Some((k, outside(p)?)));
    let (parameter, _) = off.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let p = &fitted.parameters[parameter];
    Some(AtBound { parameter, unbounded: p.value, std: p.std.unwrap_or(0.0) })
}

/// The same of the balances of `dofs` alone, whatever the bounds.
pub(super) fn balances(
    runs: &[&Run],
    model: &Model,
    dofs: &[Dof],
    options: IntegralOptions,
) -> Result<(Model, Vec<RowFit>), IntegralError> {
    let mut groups: Vec<Group> = Vec::new();
    for dof in dofs {
        let columns = match regressors_of(*dof, runs, model, options.regressor) {
            Err(RegressorError::NothingFree { .. }) => continue,
            other => other?,
        };
        let mut free: BTreeSet<usize> = columns.parameters.iter().map(|c| c.parameter).collect();
        let mut members = vec![(*dof, columns)];
        let (shared, apart): (Vec<_>, Vec<_>) = groups.into_iter().partition(|g| !g.free.is_disjoint(&free));
        for group in shared {
            free.extend(group.free);
            members.splice(0..0, group.members);
        }
        groups = apart;
        groups.push(Group { free, members });
    }
    let mut fitted = model.clone();
    let mut fits = Vec::new();
    for Group { members, .. } in groups {
        let dofs = members.iter().map(|(dof, _)| dof.name()).collect::<Vec<_>>().join(", ");
        let linear = |source| IntegralError::Linear { dofs: dofs.clone(), source };
        let fit = match members.as_slice() {
            [(dof, columns)] => fit_rows(columns, own_inertia(model, *dof), options.std).map_err(linear)?,
            several => {
                let own: Vec<Option<usize>> = several.iter().map(|(dof, _)| own_inertia(model, *dof)).collect();
                let fit = match options.together {
                    Together::AsForces => fit_together(several, &own, None, options),
                    Together::PerInertia => without_noise(several, &own, runs, model, options),
                };
                fit.map_err(linear)?.ok_or(IntegralError::NotSettled { dofs })?
            }
        };
        fit.write_to(&mut fitted);
        fits.push(fit);
    }
    fits.sort_by_key(|fit| fit.dofs.first().copied());
    Ok((fitted, fits))
}

/// The inertia of `dof`, where it is free.
pub(super) fn own_inertia(model: &Model, dof: Dof) -> Option<usize> {
    model.inertia(dof).filter(|p| !model.parameters[*p].fixed)
}

/// As [`fit_together`], without what the noise of the velocities does to columns and estimates: see
/// [`super::coupling_noise`]. `None` too where that is as large as half of an inertia.
fn without_noise(
    members: &[(Dof, Columns)],
    own: &[Option<usize>],
    runs: &[&Run],
    model: &Model,
    options: IntegralOptions,
) -> Result<Option<RowFit>, LeastSquaresError> {
    let Ok(shaken) = shaken(members, runs, model, options.regressor) else { return Ok(None) };
    if shaken.is_empty() {
        return fit_together(members, own, None, options);
    }
    let noise = noise_of(members, own, &shaken);
    let fitted = |mut members: Members, times: f64, near: Option<&[f64]>| {
        calibrate(&mut members, &noise, times);
        fit_together(&members, own, near, options)
    };
    let Some(mut fit) = fitted(members.to_vec(), 1.0, None)? else { return Ok(None) };
    let mut shifts: Vec<Vec<f64>> = Vec::new();
    for noisier in shaken {
        let Some(noisier) = fitted(noisier, 2.0, Some(&fit.values))? else { return Ok(None) };
        shifts.push(noisier.values.iter().zip(&fit.values).map(|(new, old)| new - old).collect());
    }
    let draws = shifts.len() as f64;
    for k in 0..fit.values.len() {
        let shift = shifts.iter().map(|shift| shift[k]).sum::<f64>() / draws;
        if own.contains(&Some(fit.parameters[k].parameter)) && shift.abs() > 0.5 * fit.values[k].abs() {
            return Ok(None);
        }
        fit.values[k] -= shift;
        // how well few draws know the shift, and half of it for what does not grow with the variance
        let spread = shifts.iter().map(|s| (s[k] - shift).powi(2)).sum::<f64>() / (draws * (draws - 1.0));
        fit.covariance[k][k] += spread + 0.25 * shift * shift;
    }
    Ok(Some(fit))
}

/// Solves degrees of freedom together, each with the parameter of its own inertia, from a solution that is `near`; `None` where that does not settle.
fn fit_together(
    members: &[(Dof, Columns)],
    own: &[Option<usize>],
    near: Option<&[f64]>,
    options: IntegralOptions,
) -> Result<Option<RowFit>, LeastSquaresError> {
    let joint = stack(members, &vec![1.0; members.len()]);
    let places: Vec<Vec<usize>> = members
        .iter()
        .map(|(_, c)| c.parameters.iter().filter_map(|c| joint.parameters.iter().position(|all| all == c)).collect())
        .collect();
    let of = |k: usize, theta: &[f64]| -> Vec<f64> { places[k].iter().map(|place| theta[*place]).collect() };
    let described: Vec<Member> = members
        .iter()
        .zip(own)
        .map(|((_, columns), own)| {
            let at = own.and_then(|p| columns.column_of(p));
            let alone = at.and_then(|at| Some(fit_rows(columns, *own, StdMethod::Paper).ok()?.values[at]));
            Member {
                own: own.and_then(|p| joint.column_of(p)).filter(|_| at.is_some()),
                alone: alone.filter(|m| m.is_finite() && *m > 0.0),
                size: columns.residual_rms(&vec![0.0; columns.columns.len()]),
                rows: columns.rows() as f64,
            }
        })
        .collect();
    let rms = |k: usize, theta: &[f64]| members[k].1.residual_rms(&of(k, theta));
    let solve = |theta: Option<&[f64]>, weights: &[f64], method: StdMethod| {
        let predicted = |(k, (dof, columns)): (usize, &(Dof, Columns))| {
            let at = own[k].and_then(|p| columns.column_of(p));
            let turned = theta.zip(at).map(|(theta, at)| columns.predicted(at, &of(k, theta)));
            (*dof, turned.unwrap_or_else(|| columns.clone()))
        };
        let members: Vec<(Dof, Columns)> = members.iter().enumerate().map(predicted).collect();
        fit_rows(&stack(&members, weights), None, method)
    };
    if options.together == Together::AsForces {
        return settled(&described, options.together, near, |theta, weights| solve(theta, weights, options.std), rms);
    }
    // correlated residuals cost as much as the solution: they are asked of the last one alone
    let found = settled(&described, options.together, near, |t, weights| solve(t, weights, StdMethod::Paper), rms)?;
    match found {
        Some(fit) if options.std != StdMethod::Paper && near.is_none() => {
            let weights = described.iter().enumerate().map(|(k, m)| 1.0 / rms(k, &fit.values).max(1e-12 * m.size));
            solve(Some(&fit.values), &weights.collect::<Vec<_>>(), options.std).map(Some)
        }
        found => Ok(found),
    }
}

impl Columns {
    /// Root of the mean square of y − Σ θⱼ cⱼ.
    fn residual_rms(&self, theta: &[f64]) -> f64 {
        let square = |row: usize| (self.rhs[row] - self.sum(row, theta)).powi(2);
        ((0..self.rows()).map(square).sum::<f64>() / self.rows().max(1) as f64).sqrt()
    }

    fn sum(&self, row: usize, theta: &[f64]) -> f64 {
        self.columns.iter().zip(theta).map(|(c, value)| c[row] * value).sum()
    }

    /// The same rows with what the others predict of column `at` in its place, and y moved along with it.
    fn predicted(&self, at: usize, theta: &[f64]) -> Columns {
        let mut turned = self.clone();
        for row in 0..self.rows() {
            // what is left of the row, as an increment
            let by = (self.rhs[row] - self.sum(row, theta)) / theta[at];
            turned.columns[at][row] += by;
            turned.rhs[row] += theta[at] * by;
        }
        turned
    }
}

fn stack(members: &[(Dof, Columns)], weights: &[f64]) -> Columns {
    let mut all = Columns::default();
    for (_, member) in members {
        for column in &member.parameters {
            if !all.parameters.contains(column) {
                all.parameters.push(column.clone());
                all.columns.push(Vec::new());
            }
        }
    }
    for ((_, member), weight) in members.iter().zip(weights) {
        let begin = all.rows();
        all.rhs.extend(member.rhs.iter().map(|y| y * weight));
        all.span.extend(&member.span);
        for (column, values) in all.parameters.iter().zip(&mut all.columns) {
            match member.parameters.iter().position(|c| c == column) {
                Some(k) => values.extend(member.columns[k].iter().map(|x| x * weight)),
                None => values.resize(begin + member.rows(), 0.0),
            }
        }
        let shifted = |b: &Block| Block { rows: b.rows.start + begin..b.rows.end + begin, ..b.clone() };
        all.blocks.extend(member.blocks.iter().map(shifted));
    }
    all
}
