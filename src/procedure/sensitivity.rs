//! Sensitivity of the estimates to the window and the degree of the filter: a trustworthy fit
//! changes little.

use rayon::prelude::*;
use serde::Serialize;

use super::{Bench, Estimate, ProcedureError, StagedOptions, direct_regression, made_ready, staged};
use crate::filter::{PolynomialFilter, Window};
use crate::frame::Dof;
use crate::model::Model;
use crate::run::Run;

/// One entry of the sensitivity table.
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
    /// Estimates with this filter.
    pub estimates: Vec<Estimate>,
}

/// Repeats the staged and the direct fit with each filter, and once without. The direct fit uses
/// the same filter to differentiate. A direct fit without a solution has no row.
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
    let all: Vec<Option<PolynomialFilter>> = std::iter::once(None).chain(filters.iter().copied().map(Some)).collect();
    let settings: Result<Vec<Vec<Setting>>, ProcedureError> =
        all.into_par_iter().map(|filter| with_filter(runs, model, bench, options, filter)).collect();
    Ok(settings?.concat())
}

/// Default filters of the table: windows of 5, 9 and 15 samples, of second and third degree.
pub fn usual_filters() -> Vec<PolynomialFilter> {
    let of = |samples| [2, 3].map(|degree| PolynomialFilter { window: Window::Samples(samples), degree });
    [5, 9, 15].into_iter().flat_map(of).collect()
}

fn with_filter(
    runs: &[Run],
    model: &Model,
    bench: Bench<'_>,
    options: &StagedOptions,
    filter: Option<PolynomialFilter>,
) -> Result<Vec<Setting>, ProcedureError> {
    let mut options = options.clone().filtered(filter);
    options.direct.filter = filter.unwrap_or(options.direct.filter);
    let result = staged(runs, model, bench, &options)?;
    let row = |estimator, stage: &super::Stage| Setting {
        filter,
        estimator,
        stage: stage.name.clone(),
        dof: stage.dof,
        estimates: stage.estimates.clone(),
    };
    let mut table: Vec<Setting> =
        result.stages.iter().filter(|s| s.name != "direct").map(|stage| row("staged", stage)).collect();
    let ready = made_ready(runs, model, &result.efficiency, bench.thrusters, &options.clone().filtered(None))?;
    for dof in &model.dofs {
        let moving: Vec<&Run> = super::of_kind(&ready, direct_regression::kind_of(*dof, &ready), *dof, &model.dofs);
        if let Ok((stage, _)) = direct_regression::direct(*dof, &moving, model, &options) {
            table.push(row("direct", &stage));
        }
    }
    Ok(table)
}

/// Variation of one estimate over the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spread {
    /// `staged` or `direct`.
    pub estimator: &'static str,
    /// Stage.
    pub stage: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// Symbol.
    pub name: String,
    /// Least value, SI.
    pub least: f64,
    /// Greatest value, SI.
    pub most: f64,
    /// (greatest − least)/|mean|, 1.
    pub relative: f64,
    /// Mean reported standard deviation, SI.
    pub std: f64,
    /// Unit.
    pub unit: String,
}

/// The spread of every estimate of the table, in its order.
pub fn spreads(table: &[Setting]) -> Vec<Spread> {
    let mut found: Vec<(Spread, Vec<&Estimate>)> = Vec::new();
    for setting in table {
        for e in &setting.estimates {
            let same = |s: &Spread| {
                s.estimator == setting.estimator && s.stage == setting.stage && s.dof == setting.dof && s.name == e.name
            };
            match found.iter_mut().find(|(s, _)| same(s)) {
                Some((_, values)) => values.push(e),
                None => {
                    let spread = Spread {
                        estimator: setting.estimator,
                        stage: setting.stage.clone(),
                        dof: setting.dof,
                        name: e.name.clone(),
                        least: 0.0,
                        most: 0.0,
                        relative: 0.0,
                        std: 0.0,
                        unit: e.unit.clone(),
                    };
                    found.push((spread, vec![e]));
                }
            }
        }
    }
    let of = |(spread, values): (Spread, Vec<&Estimate>)| {
        let n = values.len() as f64;
        let mean = values.iter().map(|e| e.value).sum::<f64>() / n;
        let most = values.iter().map(|e| e.value).fold(f64::NEG_INFINITY, f64::max);
        let least = values.iter().map(|e| e.value).fold(f64::INFINITY, f64::min);
        let std = values.iter().map(|e| e.std).sum::<f64>() / n;
        Spread { least, most, relative: (most - least) / mean.abs(), std, ..spread }
    };
    found.into_iter().map(of).collect()
}
