//! Rows of the regression folded as they are made: no column is kept, and memory is that of the run.
//!
//! ```text
//! [H | y] = Q [R z; 0 ρ]        to the last digit: the rows are made once more, for HᵀH and Hᵀy in twice the precision
//! ```

use super::balance::{Balance, RegressorError};
use super::nodes::stretches;
use super::regressor::Reading;
use super::shared_stamps::over_rows;
use super::{Column, Columns, IntegralError, RegressorOptions, regressors_of};
use crate::frame::Dof;
use crate::least_squares::{
    Fit, LeastSquaresError, LeastSquaresOptions, Names, Products, Refinement, StreamingQr, least_squares_with,
};
use crate::model::Model;
use crate::run::Run;

/// The rows of one degree of freedom in one run as a triangular factor.
#[derive(Debug, Clone)]
pub struct Folded {
    /// What each column multiplies.
    pub parameters: Vec<Column>,
    /// The factor; its right-hand side is that of [`Columns`].
    pub tall: StreamingQr,
    dof: Dof,
}

/// The rows of [`regressors_of`] for one run, folded into their factor.
///
/// # Errors
/// [`IntegralError`] where the balance is not linear in the free parameters, reads what is not logged, or a value is not
/// finite.
pub fn folded(dof: Dof, run: &Run, model: &Model, options: RegressorOptions) -> Result<Folded, IntegralError> {
    let new = |names: &Names| StreamingQr::new(names.columns.len(), names.clone());
    let fold = |tall: &mut StreamingQr, h: &[&[f64]], y: &[f64]| tall.push(h, y);
    let (parameters, parts) = pass(dof, run, model, options, new, fold)?;
    let linear = |source| IntegralError::Linear { dofs: dof.name().into(), source };
    let mut parts = parts.into_iter();
    let mut tall = parts.next().ok_or(LeastSquaresError::NoColumns).map_err(linear)?;
    parts.try_for_each(|part| tall.merge(part)).map_err(linear)?;
    Ok(Folded { parameters, tall, dof })
}

impl Folded {
    /// The solution to the last digit; the rows of `run` are made once more.
    ///
    /// # Errors
    /// As [`folded`], and where the rows do not determine the parameters.
    pub fn refined(&self, run: &Run, model: &Model, options: RegressorOptions) -> Result<Fit, IntegralError> {
        let linear = |source| IntegralError::Linear { dofs: self.dof.name().into(), source };
        let fit = self.tall.fit().map_err(linear)?;
        let new = |names: &Names| Ok(Products::new(names.columns.len() + 1));
        let add = |products: &mut Products, h: &[&[f64]], y: &[f64]| {
            products.add(h, y, &fit);
            Ok(())
        };
        let (_, parts) = pass(self.dof, run, model, options, new, add)?;
        if let Some(refined) = fit.refined_by(&Products::merged(parts), &self.tall) {
            return Ok(refined);
        }
        // columns all but dependent are for the whole system to say
        let columns = regressors_of(self.dof, &[run], model, options)?;
        let always = LeastSquaresOptions { refinement: Refinement::Always, ..LeastSquaresOptions::default() };
        least_squares_with(&columns.slices(), &columns.rhs, &always).map_err(linear)
    }
}

/// One pass over the rows of a run, in parts of fixed borders: what `take` has made of each, begun by `new`. There is one
/// part at least.
fn pass<S: Send>(
    dof: Dof,
    run: &Run,
    model: &Model,
    options: RegressorOptions,
    new: impl Fn(&Names) -> Result<S, LeastSquaresError> + Sync,
    take: impl Fn(&mut S, &[&[f64]], &[f64]) -> Result<(), LeastSquaresError> + Sync,
) -> Result<(Vec<Column>, Vec<S>), IntegralError> {
    let balance = Balance::compile(model, dof, run)?;
    if balance.free.is_empty() {
        return Err(RegressorError::NothingFree { dof }.into());
    }
    let mut columns = Columns::default();
    let places: Vec<usize> = balance.free.iter().map(|p| columns.index(model, *p, 0, &run.name)).collect();
    let names = columns.parameters.iter().map(|c| c.name.clone()).collect();
    let names = Names { columns: names, response: Some(dof.force().into()) };
    let linear = |source| IntegralError::Linear { dofs: dof.name().into(), source };
    let begin = || new(&names);
    let mut parts = vec![begin().map_err(linear)?];
    if let Some(own) = run.signal(dof.velocity()) {
        let mut reading = Reading::new(&balance, own, run, 0, model, options);
        for stretch in stretches(run, dof.velocity(), own, &reading.readers, options.nodes) {
            if let Some(inputs) = reading.at_stamps(&stretch) {
                let width = places.len() + 1;
                let made = over_rows(&balance.plan, &reading.registers, &stretch.time, &inputs, width, &begin, &take);
                parts.extend(made.map_err(linear)?);
            } else {
                reading.walk(stretch, &places, &mut columns);
            }
        }
    }
    // rows between stamps of several clocks are few enough to be kept
    if columns.rows() > 0 {
        take(&mut parts[0], &columns.slices(), &columns.rhs).map_err(linear)?;
    }
    Ok((columns.parameters, parts))
}
