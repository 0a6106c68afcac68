//! Step 4: runs that took no part must agree.
//!
//! ```text
//! Δ = −2 ln L(held out; θ̂, η̂) without the name less that with it       a name is confirmed where Δ > 0
//! D = Σ_runs (E²_with − E²_without)                                   and no E 8 s ahead is worse: D ≤ 2 √(Σ (D_run − D̄)²)
//! ```
//!
//! Where no run has the role `validate` each run is predicted by an estimate without it, one Gauss-Newton step from the
//! estimate of all, which is exact where the innovations are linear in θ.

use super::search::Task;
use crate::estimate::filter_error::{FilterErrorFit, Filtered, cost_of};
use crate::estimate::output_error::OutputErrorError;
use crate::model::Model;

/// Seconds ahead at which predictions are compared.
const AHEAD: f64 = 8.0;

/// An error that grows by less than this share is the same.
const SAME: f64 = 0.05;

/// What held-out runs say of a name.
#[derive(Debug, Clone)]
pub(super) struct HeldOut {
    /// Fall of −2 ln L on them.
    pub gain: f64,
    /// Why they do not agree, if they do not.
    pub against: Option<String>,
}

/// The model with all parameters held and no values per run.
pub(super) fn held(model: &Model) -> Model {
    let mut held = model.clone();
    for p in &mut held.parameters {
        p.fixed = true;
        p.per_run.clear();
    }
    held
}

/// Asks the held-out runs whether `with` predicts them better than `without`.
pub(super) fn agree(
    without: &FilterErrorFit,
    with: &FilterErrorFit,
    task: &Task<'_>,
) -> Result<HeldOut, OutputErrorError> {
    let own_values = with.model.parameters.iter().any(|p| p.spec.per_run);
    if task.held.is_empty() || own_values {
        let gain = without.left_out_cost() - with.left_out_cost();
        let against = (gain <= 0.0)
            .then(|| "estimated without a run, it predicts that run no better than the model without it".to_string());
        return Ok(HeldOut { gain, against });
    }
    let cost = |fit: &FilterErrorFit| cost_of(&held(&fit.model), task.held, (&fit.noise, fit.limit), task.fitting);
    let gain = cost(without)? - cost(with)?;
    if gain.is_nan() || gain <= 0.0 {
        let against = "runs that took no part are predicted no better with it".to_string();
        return Ok(HeldOut { gain, against: Some(against) });
    }
    let against = worse(without, with, task)?
        .map(|channel| format!("runs that took no part are predicted worse with it {AHEAD} s ahead, in `{channel}`"));
    Ok(HeldOut { gain, against })
}

/// The channel that is predicted worse beyond chance, if there is one.
fn worse(without: &FilterErrorFit, with: &FilterErrorFit, task: &Task<'_>) -> Result<Option<String>, OutputErrorError> {
    let errors = |fit: &FilterErrorFit| -> Result<(Vec<String>, Vec<Vec<f64>>), OutputErrorError> {
        let model = held(&fit.model);
        let filtered = Filtered::new(&model, task.held, &task.fitting.base)?;
        let of = |channel: &crate::estimate::filter_error::Channel| {
            channel.predictions.iter().find(|p| p.ahead == Some(AHEAD)).map_or(0.0, |p| p.squares)
        };
        let forecasts = filtered.forecast(&model, &fit.noise, fit.limit);
        let squares = forecasts.iter().map(|f| f.channels.iter().map(of).collect()).collect();
        Ok((filtered.problem.dynamics.outputs.clone(), squares))
    };
    let ((outputs, before), (_, after)) = (errors(without)?, errors(with)?);
    let n = before.len() as f64;
    for (k, output) in outputs.iter().enumerate() {
        let difference: Vec<f64> = before.iter().zip(&after).map(|(b, a)| a[k] - b[k]).collect();
        let (sum, all): (f64, f64) = (difference.iter().sum(), before.iter().map(|b| b[k]).sum());
        let mean = sum / n;
        let spread = difference.iter().map(|d| (d - mean).powi(2)).sum::<f64>().sqrt();
        if sum > 2.0 * spread && sum > all * ((1.0 + SAME) * (1.0 + SAME) - 1.0) {
            return Ok(Some(output.clone()));
        }
    }
    Ok(None)
}
