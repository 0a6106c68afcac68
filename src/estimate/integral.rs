//! Least squares on integral regressors.
//!
//! ```text
//! per unit inertia (4):   Δνᵢ = (1/m) [y − Σ θⱼ cⱼ]      θⱼ = −aⱼ/a_y,  m = 1/a_y,  std by the delta method
//! as a force:             Σ θⱼ cⱼ = y
//! ```
//!
//! The first form is the paper's: the noise of the velocity increment then stands on the left,
//! where least squares expects it. As a regressor it would pull the inertia towards zero. Degrees
//! of freedom that share a free parameter (tied Coriolis terms) are solved together, weighted by
//! their residuals, also with the increment on the left: see [`super::shared`].

use std::collections::BTreeSet;

use thiserror::Error;

use super::joint::{fit_together, without_noise};
use super::row_fit::{AtBound, IntegralOptions, RowFit, Together, fit_rows};
use super::{Columns, RegressorError, regressors_of};
use crate::frame::Dof;
use crate::least_squares::LeastSquaresError;
use crate::model::{Model, Parameter};
use crate::run::Run;

/// Reason why a fit by integral least squares is not possible.
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
        "{dofs}: the balances share their inertias, which cannot be estimated without bias from a log that is read \
         piece by piece; fit without --stream, with estimator = \"filter_error\" if the log is too large to keep, or \
         with coriolis = \"free\""
    )]
    SharedInStream {
        /// Degrees of freedom that share them.
        dofs: String,
    },
    /// Inertias that several balances share cannot be distinguished from the noise.
    #[error(
        "{dofs}: integral least squares cannot estimate the inertias that these balances share: within a row the \
         velocities change by less than their noise, or an inertia would be negative; use estimator = \
         \"filter_error\", longer rows (stage.oscillatory.window), or coriolis = \"free\""
    )]
    NotSettled {
        /// Degrees of freedom solved together.
        dofs: String,
    },
}

/// Degrees of freedom that share free parameters.
struct Group {
    free: BTreeSet<usize>,
    members: Vec<(Dof, Columns)>,
}

/// Fits the free parameters of `model` to `runs` within their bounds; returns the model with values
/// and standard deviations, and the result of each fit. Degrees of freedom that share no free
/// parameter are fitted separately.
///
/// Linear least squares knows no bounds. Of the parameters that end outside their bounds, the one
/// farthest outside, in standard deviations, is held at its bound, and the others are fitted again.
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

/// Fits by `fit`, and holds at its bound each parameter that ends outside.
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

/// The free parameter that lies farthest outside its bounds, in standard deviations; parameters
/// with values of single runs are left as they are.
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

/// Fits the balances of `dofs` alone, without bounds.
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

/// The inertia of `dof`, if it is free.
pub(super) fn own_inertia(model: &Model, dof: Dof) -> Option<usize> {
    model.inertia(dof).filter(|p| !model.parameters[*p].fixed)
}
