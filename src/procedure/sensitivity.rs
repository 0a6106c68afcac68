//! How estimates move with the window and the degree of the filter: a fit that can be trusted does not.

use serde::Serialize;

use super::{Bench, Estimate, ProcedureError, StagedOptions, made_ready, staged, twin};
use crate::filter::PolynomialFilter;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::Run;

/// One row of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Setting {
    /// Filter of the velocities; none in the first row.
    pub filter: Option<PolynomialFilter>,
    /// `staged` or `direct`.
    pub estimator: &'static str,
    /// Stage.
    pub stage: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// What was estimated with this filter.
    pub estimates: Vec<Estimate>,
}

/// Repeats the staged and the direct fit with each filter, and once without. The direct fit differentiates by the same
/// filter. A direct fit that has no solution has no row.
///
/// # Errors
/// As [`staged`].
pub fn filter_table(
    runs: &[Run],
    model: &Model,
    bench: Bench<'_>,
    options: &StagedOptions,
    filters: &[PolynomialFilter],
) -> Result<Vec<Setting>, ProcedureError> {
    let mut table = Vec::new();
    for filter in std::iter::once(None).chain(filters.iter().copied().map(Some)) {
        let differentiation = filter.unwrap_or(options.differentiation);
        let options = StagedOptions { filter, differentiation, ..*options };
        let result = staged(runs, model, bench, &options)?;
        let row = |estimator, stage: super::Stage| Setting {
            filter,
            estimator,
            stage: stage.name,
            dof: stage.dof,
            estimates: stage.estimates,
        };
        table.extend(result.stages.into_iter().map(|stage| row("staged", stage)));
        let ready = made_ready(runs, model, bench.efficiency, &StagedOptions { filter: None, ..options })?;
        for dof in &model.dofs {
            let moving: Vec<&Run> = super::of_kind(&ready, twin::kind_of(*dof, &ready), *dof, &model.dofs);
            if let Ok((stage, _)) = twin::direct(*dof, &moving, model, &options) {
                table.push(row("direct", stage));
            }
        }
    }
    Ok(table)
}

/// Spread of one estimate over the table, relative to its mean: (greatest − least)/|mean|; `None` where it is not
/// estimated.
pub fn spread(table: &[Setting], estimator: &str, stage: &str, dof: Dof, name: &str) -> Option<f64> {
    let of = |s: &&Setting| s.estimator == estimator && s.stage == stage && s.dof == dof;
    let values: Vec<f64> =
        table.iter().filter(of).filter_map(|s| s.estimates.iter().find(|e| e.name == name)).map(|e| e.value).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let greatest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    (!values.is_empty()).then(|| (greatest - least) / mean.abs())
}
