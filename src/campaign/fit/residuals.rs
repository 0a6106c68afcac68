//! Residuals of a fit, as its estimator defines them.
//!
//! ```text
//! filter error    measured − predicted one sample ahead          unit of the channel
//! output error    measured − simulated                           unit of the channel
//! integral        rhs − H θ̂, the impulse that the balance lacks   N·s, N·m·s
//! ```

use crate::estimate::filter_error::{FilterErrorFit, Forecast};
use crate::estimate::output_error::OutputErrorFit;
use crate::estimate::{IntegralOptions, regressors_of};
use crate::model::Model;
use crate::navigation::upright;
use crate::run::Run;

/// Residuals of one run in one channel, or for fits by rows in one degree of freedom.
#[derive(Debug, Clone, PartialEq)]
pub struct Residuals {
    /// Name of the run.
    pub run: String,
    /// The channel, `u`; for fits by rows the degree of freedom, `surge`.
    pub channel: String,
    /// Time stamps, s; of a row, its end.
    pub time: Vec<f64>,
    /// Residuals, SI.
    pub values: Vec<f64>,
    /// Standard deviation that the filter expects of each; empty if the estimator expects none.
    pub std: Vec<f64>,
}

/// Returns the innovations of a fit by filter error, from its forecast of its own runs.
pub(super) fn innovations(fitted: &FilterErrorFit, forecasts: &[Forecast]) -> Vec<Residuals> {
    let mut all = Vec::new();
    for forecast in forecasts {
        for channel in &forecast.channels {
            let name = &fitted.filtered.problem.dynamics.outputs[channel.output];
            let here = of(&mut all, &forecast.run, name);
            for point in channel.next.iter().filter(|point| point.measured.is_finite()) {
                here.time.push(point.time);
                here.values.push(point.measured - point.mean);
                here.std.push(point.std);
            }
        }
    }
    all
}

/// Returns measured minus simulated values of a fit by output error.
pub(super) fn output_errors(fitted: &OutputErrorFit) -> Vec<Residuals> {
    let problem = &fitted.problem;
    let predicted = problem.predicted(&fitted.model, &fitted.initial_states);
    let mut all = Vec::new();
    for (track, predicted) in problem.tracks.iter().zip(&predicted) {
        for (output, name) in problem.dynamics.outputs.iter().enumerate() {
            let here = of(&mut all, &track.name, name);
            let width = problem.dynamics.outputs.len();
            for (k, time) in track.time.iter().enumerate() {
                let left = track.observed[k * width + output] - predicted[k * width + output];
                if left.is_finite() {
                    here.time.push(*time);
                    here.values.push(left);
                }
            }
        }
    }
    all
}

/// Returns the residuals of the rows of integral least squares.
pub(super) fn of_rows(model: &Model, runs: &[&Run], options: IntegralOptions) -> Vec<Residuals> {
    let mut all = Vec::new();
    for dof in &model.dofs {
        // a balance without rows took no part
        let Ok(rows) = regressors_of(*dof, runs, model, options.regressor) else { continue };
        let theta: Vec<f64> = rows
            .parameters
            .iter()
            .map(|column| {
                let parameter = &model.parameters[column.parameter];
                column.run.and_then(|run| parameter.per_run.get(run).copied()).unwrap_or(parameter.value)
            })
            .collect();
        for block in &rows.blocks {
            let here = of(&mut all, &runs[block.run].name, dof.name());
            for row in block.rows.clone() {
                let explained: f64 = rows.columns.iter().zip(&theta).map(|(column, theta)| column[row] * theta).sum();
                here.time.push(rows.span[row].1);
                here.values.push(rows.rhs[row] - explained);
            }
        }
    }
    all
}

/// Returns the residuals of this run and channel, new if there are none yet: a run with gaps has
/// several stretches.
fn of<'a>(all: &'a mut Vec<Residuals>, run: &str, channel: &str) -> &'a mut Residuals {
    let channel = upright::instrument_of(channel).unwrap_or(channel);
    let at = all.iter().position(|r| r.run == run && r.channel == channel).unwrap_or_else(|| {
        let (time, values, std) = (Vec::new(), Vec::new(), Vec::new());
        all.push(Residuals { run: run.into(), channel: channel.into(), time, values, std });
        all.len() - 1
    });
    &mut all[at]
}
