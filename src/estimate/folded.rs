//! Rows of the regression folded as they are made: no column is kept, and the memory needed is that
//! of the run.
//!
//! ```text
//! [H | y] = Q [R z; 0 ρ]
//! ```

use super::balance::{Balance, RegressorError};
use super::nodes::stretches;
use super::regressor::Reading;
use super::shared_stamps::over_rows;
use super::{Column, Columns, IntegralError, RegressorOptions};
use crate::frame::Dof;
use crate::least_squares::{Names, StreamingQr};
use crate::model::Model;
use crate::run::Run;

/// The rows of one degree of freedom in one run as a triangular factor.
#[derive(Debug, Clone)]
pub struct Folded {
    /// What each column multiplies.
    pub parameters: Vec<Column>,
    /// The factor; its right-hand side is that of [`Columns`].
    pub tall: StreamingQr,
}

/// The rows of [`regressors_of`](super::regressors_of) for one run, folded into their factor, in
/// parts with fixed borders.
///
/// # Errors
/// [`IntegralError`] if the balance is not linear in the free parameters, reads what is not logged,
/// or a value is not finite.
pub fn folded(dof: Dof, run: &Run, model: &Model, options: RegressorOptions) -> Result<Folded, IntegralError> {
    let balance = Balance::compile(model, dof, run)?;
    if balance.free.is_empty() {
        return Err(RegressorError::NothingFree { dof }.into());
    }
    let mut columns = Columns::default();
    let places: Vec<usize> = balance.free.iter().map(|p| columns.index(model, *p, 0, &run.name)).collect();
    let names = columns.parameters.iter().map(|c| c.name.clone()).collect();
    let names = Names { columns: names, response: Some(dof.force().into()) };
    let linear = |source| IntegralError::Linear { dofs: dof.name().into(), source };
    let begin = || StreamingQr::new(names.columns.len(), names.clone());
    let fold = |tall: &mut StreamingQr, h: &[&[f64]], y: &[f64]| tall.push(h, y);
    let mut tall = begin().map_err(linear)?;
    let mut parts = Vec::new();
    if let Some(own) = run.signal(dof.velocity()) {
        let mut reading = Reading::new(&balance, own, run, 0, model, options);
        for stretch in stretches(run, dof.velocity(), own, &reading.readers, options.nodes) {
            if let Some(inputs) = reading.at_stamps(&stretch) {
                let width = places.len() + 1;
                let made = over_rows(&balance.plan, &reading.registers, &stretch.time, &inputs, width, &begin, &fold);
                parts.extend(made.map_err(linear)?);
            } else {
                reading.walk(stretch, &places, &mut columns);
            }
        }
    }
    // rows between stamps of several clocks are few enough to be kept
    if columns.rows() > 0 {
        tall.push(&columns.slices(), &columns.rhs).map_err(linear)?;
    }
    parts.into_iter().try_for_each(|part| tall.merge(part)).map_err(linear)?;
    Ok(Folded { parameters: columns.parameters, tall })
}
