//! Balances that share free parameters, with their rows stacked.
//!
//! ```text
//! c ← c + Δν̂ − Δν in the column of each balance's own inertia,   y ← y + m (Δν̂ − Δν)
//! every row times its weight
//! ```
//!
//! Weights and predicted increments come from [`super::shared`]. The effect of velocity noise and
//! its removal are described in [`super::coupling_noise`].

use rayon::prelude::*;

use super::coupling_noise::{Members, calibrate, noise_of, shaken};
use super::row_fit::{IntegralOptions, RowFit, Together, fit_rows};
use super::shared::{Member, settled, weights};
use super::{Block, Columns};
use crate::frame::Dof;
use crate::least_squares::{LeastSquaresError, StdMethod};
use crate::model::Model;
use crate::run::Run;

/// Solves degrees of freedom together, each with the parameter of its own inertia, and removes the
/// effect of velocity noise on columns and estimates. `None` if the solution does not converge, or
/// if that noise moves an inertia by more than half of it.
pub(super) fn without_noise(
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
    let shift = |noisier: Members| -> Result<Option<Vec<f64>>, LeastSquaresError> {
        let noisier = fitted(noisier, 2.0, Some(&fit.values))?;
        Ok(noisier.map(|noisier| noisier.values.iter().zip(&fit.values).map(|(new, old)| new - old).collect()))
    };
    let shifts: Result<Option<Vec<Vec<f64>>>, _> = shaken.into_par_iter().map(shift).collect();
    let Some(shifts) = shifts? else { return Ok(None) };
    let draws = shifts.len() as f64;
    for k in 0..fit.values.len() {
        let shift = shifts.iter().map(|shift| shift[k]).sum::<f64>() / draws;
        if own.contains(&Some(fit.parameters[k].parameter)) && shift.abs() > 0.5 * fit.values[k].abs() {
            return Ok(None);
        }
        fit.values[k] -= shift;
        // the uncertainty of the shift from few draws, and half of the shift for the part that does
        // not grow with the variance
        let spread = shifts.iter().map(|s| (s[k] - shift).powi(2)).sum::<f64>() / (draws * (draws - 1.0));
        fit.covariance[k][k] += spread + 0.25 * shift * shift;
    }
    Ok(Some(fit))
}

/// Solves degrees of freedom together, each with the parameter of its own inertia; `None` if the
/// solution does not converge. With a solution that is `near`, only the values are wanted, with the
/// covariance of white residuals.
pub(super) fn fit_together(
    members: &[(Dof, Columns)],
    own: &[Option<usize>],
    near: Option<&[f64]>,
    options: IntegralOptions,
) -> Result<Option<RowFit>, LeastSquaresError> {
    let joint = stack(members, &vec![1.0; members.len()], &[]);
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
            let at_first = at.filter(|_| near.is_none());
            let alone = at_first.and_then(|at| Some(fit_rows(columns, *own, StdMethod::Paper).ok()?.values[at]));
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
        let turned = |(k, (_, columns)): (usize, &(Dof, Columns))| {
            let at = own[k].and_then(|p| columns.column_of(p));
            theta.zip(at).map(|(theta, at)| columns.turned(at, &of(k, theta)))
        };
        let turned: Vec<Option<Turned>> = members.iter().enumerate().map(turned).collect();
        fit_rows(&stack(members, weights, &turned), None, method)
    };
    if options.together == Together::AsForces {
        return settled(&described, options.together, near, |theta, weights| solve(theta, weights, options.std), rms);
    }
    // the covariance of correlated residuals costs as much as the solution: it is computed for the
    // last one alone
    let found = settled(&described, options.together, near, |t, weights| solve(t, weights, StdMethod::Paper), rms)?;
    match found {
        Some(fit) if options.std != StdMethod::Paper && near.is_none() => {
            solve(Some(&fit.values), &weights(&described, rms, &fit.values), options.std).map(Some)
        }
        found => Ok(found),
    }
}

impl Columns {
    /// Root mean square of y − Σ θⱼ cⱼ.
    fn residual_rms(&self, theta: &[f64]) -> f64 {
        let square = |row: usize| (self.rhs[row] - self.sum(row, theta)).powi(2);
        ((0..self.rows()).map(square).sum::<f64>() / self.rows().max(1) as f64).sqrt()
    }

    fn sum(&self, row: usize, theta: &[f64]) -> f64 {
        self.columns.iter().zip(theta).map(|(c, value)| c[row] * value).sum()
    }

    /// The change of the rows if column `at` is replaced by what the other columns predict of it.
    fn turned(&self, at: usize, theta: &[f64]) -> Turned {
        let left = |row: usize| (self.rhs[row] - self.sum(row, theta)) / theta[at];
        Turned { at, inertia: theta[at], by: (0..self.rows()).map(left).collect() }
    }
}

/// Rows of a balance with the predicted increment in the column of its own inertia: c + by, and y + m by.
struct Turned {
    at: usize,
    inertia: f64,
    /// Residual of each row, as an increment.
    by: Vec<f64>,
}

/// The rows of all balances stacked, each weighted, some with predicted increments.
fn stack(members: &[(Dof, Columns)], weights: &[f64], turned: &[Option<Turned>]) -> Columns {
    let mut all = Columns::default();
    for (_, member) in members {
        for column in &member.parameters {
            if !all.parameters.contains(column) {
                all.parameters.push(column.clone());
                all.columns.push(Vec::new());
            }
        }
    }
    let turned = turned.iter().map(Option::as_ref).chain(std::iter::repeat(None));
    for (((_, member), weight), turned) in members.iter().zip(weights).zip(turned) {
        let begin = all.rows();
        match turned {
            None => all.rhs.extend(member.rhs.iter().map(|y| y * weight)),
            Some(t) => all.rhs.extend(member.rhs.iter().zip(&t.by).map(|(y, by)| (y + t.inertia * by) * weight)),
        }
        all.span.extend(&member.span);
        for (column, values) in all.parameters.iter().zip(&mut all.columns) {
            match member.parameters.iter().position(|c| c == column) {
                Some(k) => match turned.filter(|t| t.at == k) {
                    None => values.extend(member.columns[k].iter().map(|x| x * weight)),
                    Some(t) => values.extend(member.columns[k].iter().zip(&t.by).map(|(x, by)| (x + by) * weight)),
                },
                None => values.resize(begin + member.rows(), 0.0),
            }
        }
        let shifted = |b: &Block| Block { rows: b.rows.start + begin..b.rows.end + begin, ..b.clone() };
        all.blocks.extend(member.blocks.iter().map(shifted));
    }
    all
}
