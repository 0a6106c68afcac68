//! Integral least squares on runs that arrive piece by piece and are not kept.
//!
//! ```text
//! [H_d | y_d] = Q R_d  of each degree of freedom d, folded as rows arrive
//! Σ = (HᵀH)⁻¹ Σ_b g_b g_bᵀ (HᵀH)⁻¹ c
//! ```
//!
//! The result of [`super::integral_least_squares`] follows from the factors alone: per unit of the
//! inertia by exchanging two columns, shared parameters by stacking weighted factors, a parameter
//! at its bound by moving its column to the other side. Balances that share inertias (tied Coriolis
//! terms) are refused. Standard deviations are those of clusters: b is a stretch of consecutive
//! rows, g_b = H_bᵀ e_b, c = B/(B − 1) · n/(n − p). At most [`BLOCKS`] factors are kept; beyond
//! that, neighbours are merged and the clusters grow.

use std::collections::BTreeSet;

use super::integral::{IntegralError, own_inertia, within_bounds};
use super::row_fit::RowFit;
use super::{Column, Folded, RegressorError, RegressorOptions, folded};
use crate::frame::Dof;
use crate::least_squares::{LeastSquaresError, StreamingQr};
use crate::model::Model;
use crate::run::Run;

/// Greatest number of factors kept for each degree of freedom.
const BLOCKS: usize = 512;

/// Rows of one degree of freedom.
#[derive(Debug, Clone)]
struct System {
    dof: Dof,
    parameters: Vec<Column>,
    blocks: Vec<StreamingQr>,
}

/// Integral least squares of a model in progress.
#[derive(Debug, Clone)]
pub struct Streamed {
    model: Model,
    options: RegressorOptions,
    systems: Vec<System>,
    /// Number of pieces in one kept factor.
    stride: usize,
    pieces: usize,
}

impl Streamed {
    /// Starts the fit of the free parameters of `model`.
    pub fn new(model: &Model, options: RegressorOptions) -> Streamed {
        Streamed { model: model.clone(), options, systems: Vec::new(), stride: 1, pieces: 0 }
    }

    /// Folds a piece of a run.
    ///
    /// # Errors
    /// [`IntegralError`] if the balance has no linear regressor, reads what is not logged, or a
    /// value is not finite.
    pub fn push(&mut self, piece: &Run) -> Result<(), IntegralError> {
        let begins = self.pieces.is_multiple_of(self.stride);
        for dof in self.model.dofs.clone() {
            let linear = |source| IntegralError::Linear { dofs: dof.name().into(), source };
            let Folded { parameters, tall: block, .. } = match folded(dof, piece, &self.model, self.options) {
                Err(IntegralError::Regressor(RegressorError::NothingFree { .. })) => continue,
                other => other?,
            };
            match self.systems.iter_mut().find(|s| s.dof == dof) {
                None => self.systems.push(System { dof, parameters, blocks: vec![block] }),
                Some(system) => match system.blocks.last_mut().filter(|_| !begins) {
                    Some(last) => last.merge(block).map_err(linear)?,
                    None => system.blocks.push(block),
                },
            }
        }
        self.pieces += 1;
        if self.systems.iter().any(|s| s.blocks.len() > BLOCKS) {
            self.stride *= 2;
            self.systems.iter_mut().for_each(System::halve);
        }
        Ok(())
    }

    /// The model with estimates within their bounds and standard deviations, and the result of each
    /// fit.
    ///
    /// # Errors
    /// [`IntegralError`] if the rows do not determine the parameters.
    pub fn fit(&self) -> Result<(Model, Vec<RowFit>), IntegralError> {
        within_bounds(&self.model, |model| self.fit_free(model))
    }

    /// Fits the parameters that are free in `model`, without bounds; a parameter that was folded as
    /// free and is fixed there has its fixed value.
    fn fit_free(&self, model: &Model) -> Result<(Model, Vec<RowFit>), IntegralError> {
        let mut fitted = model.clone();
        let mut fits = Vec::new();
        let mut systems = Vec::new();
        for system in &self.systems {
            let linear = |source| IntegralError::Linear { dofs: system.dof.name().into(), source };
            systems.extend(system.holding(model).map_err(linear)?);
        }
        for group in groups(&systems) {
            let dofs = group.iter().map(|s| s.dof.name()).collect::<Vec<_>>().join(", ");
            let fit = match group.as_slice() {
                [one] => {
                    let own = own_inertia(model, one.dof);
                    let at = own.and_then(|p| one.parameters.iter().position(|c| c.parameter == p));
                    solve(&one.blocks, at, &one.parameters, &[one.dof])
                }
                // the factors alone would give the solution as forces, with inertias that noise shrinks
                several if several.iter().any(|s| own_inertia(model, s.dof).is_some()) => {
                    return Err(IntegralError::SharedInStream { dofs });
                }
                several => together(several),
            };
            let fit = fit.map_err(|source| IntegralError::Linear { dofs, source })?;
            fit.write_to(&mut fitted);
            fits.push(fit);
        }
        fits.sort_by_key(|fit| fit.dofs.first().copied());
        Ok((fitted, fits))
    }
}

impl System {
    /// The system with the parameters that are fixed in `model` moved to the other side; `None` if
    /// nothing is free.
    fn holding(&self, model: &Model) -> Result<Option<System>, LeastSquaresError> {
        let mut left = self.clone();
        while let Some(at) = left.parameters.iter().position(|c| model.parameters[c.parameter].fixed) {
            let held = left.parameters.remove(at);
            if left.parameters.is_empty() {
                return Ok(None);
            }
            let value = model.parameters[held.parameter].value;
            left.blocks = left.blocks.iter().map(|block| block.held(at, value)).collect::<Result<_, _>>()?;
        }
        Ok(Some(left))
    }

    /// Merges neighbouring blocks in pairs.
    fn halve(&mut self) {
        let mut merged: Vec<StreamingQr> = Vec::with_capacity(self.blocks.len().div_ceil(2));
        for (k, block) in self.blocks.drain(..).enumerate() {
            match merged.last_mut().filter(|_| k % 2 == 1) {
                // blocks of one system have the same width
                Some(last) => drop(last.merge(block)),
                None => merged.push(block),
            }
        }
        self.blocks = merged;
    }
}

/// Groups of systems that share free parameters.
fn groups(systems: &[System]) -> Vec<Vec<&System>> {
    let free = |s: &System| s.parameters.iter().map(|c| c.parameter).collect::<BTreeSet<usize>>();
    let mut groups: Vec<(BTreeSet<usize>, Vec<&System>)> = Vec::new();
    for system in systems {
        let mut own = free(system);
        let (shared, apart): (Vec<_>, Vec<_>) = groups.into_iter().partition(|(f, _)| !f.is_disjoint(&own));
        groups = apart;
        let mut members: Vec<&System> = Vec::new();
        for (known, others) in shared {
            own.extend(known);
            members.extend(others);
        }
        members.push(system);
        groups.push((own, members));
    }
    groups.into_iter().map(|(_, members)| members).collect()
}

/// The blocks of one system merged into one.
fn merged(blocks: &[StreamingQr]) -> Result<StreamingQr, LeastSquaresError> {
    let mut all = blocks[0].clone();
    for block in &blocks[1..] {
        all.merge(block.clone())?;
    }
    Ok(all)
}

/// Solves one system: per unit of the inertia in column `at`, else as forces.
fn solve(
    blocks: &[StreamingQr],
    at: Option<usize>,
    parameters: &[Column],
    dofs: &[Dof],
) -> Result<RowFit, LeastSquaresError> {
    let force = merged(blocks)?;
    force.judge()?;
    let exchanged = |tall: &StreamingQr| at.map_or_else(|| tall.clone(), |at| tall.exchanged(at));
    let fit = exchanged(&force).fit()?;
    let parts: Vec<StreamingQr> = blocks.iter().map(exchanged).collect();
    let found = fit.covariance_of_blocks(&parts);
    let covariance: Vec<Vec<f64>> = found.covariance.row_iter().map(|row| row.iter().copied().collect()).collect();
    Ok(RowFit { few_clusters: found.few, ..RowFit::of(&fit, at, &covariance, parameters, dofs) })
}

/// Solves systems that share parameters, each weighted by the inverse of its residual rms.
fn together(systems: &[&System]) -> Result<RowFit, LeastSquaresError> {
    // first with the forces' own size as weight, then twice with the residuals of the pass before
    const PASSES: usize = 3;
    let mut parameters: Vec<Column> = Vec::new();
    for column in systems.iter().flat_map(|s| &s.parameters) {
        if !parameters.contains(column) {
            parameters.push(column.clone());
        }
    }
    let places = |s: &System| -> Vec<usize> {
        s.parameters.iter().filter_map(|c| parameters.iter().position(|all| all == c)).collect()
    };
    let factors: Vec<StreamingQr> = systems.iter().map(|s| merged(&s.blocks)).collect::<Result<_, _>>()?;
    let mut weights: Vec<f64> = factors.iter().map(|f| 1.0 / f.residual_rms(&vec![0.0; f.columns()])).collect();
    let dofs: Vec<Dof> = systems.iter().map(|s| s.dof).collect();
    let mut fit = None;
    for _ in 0..PASSES {
        let count = systems.iter().map(|s| s.blocks.len()).max().unwrap_or(0);
        let joint = |b: usize| -> Result<Option<StreamingQr>, LeastSquaresError> {
            let mut all: Option<StreamingQr> = None;
            for (system, weight) in systems.iter().zip(&weights) {
                let Some(block) = system.blocks.get(b) else { continue };
                let wide = block.embedded(&places(system), parameters.len(), *weight);
                match &mut all {
                    Some(all) => all.merge(wide)?,
                    None => all = Some(wide),
                }
            }
            Ok(all)
        };
        let blocks: Vec<StreamingQr> =
            (0..count).map(joint).collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        let found = solve(&blocks, None, &parameters, &dofs)?;
        for ((weight, factor), system) in weights.iter_mut().zip(&factors).zip(systems) {
            let theta: Vec<f64> = places(system).into_iter().map(|k| found.values[k]).collect();
            // a perfect fit needs no other weight
            *weight = 1.0 / factor.residual_rms(&theta).max(1e-12 / *weight);
        }
        fit = Some(found);
    }
    fit.ok_or(LeastSquaresError::NoColumns)
}
