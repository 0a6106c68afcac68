//! Rehearsal of a plan: campaigns of its runs are simulated with noise and fitted, and the scatter of the estimates is
//! compared with the prediction.

use rayon::prelude::*;
use serde::Serialize;

use super::codes;
use super::information::shared;
use super::instrument;
use super::proposal::Proposal;
use super::sail::Course;
use crate::estimate::output_error::{OutputErrorOptions, output_error};
use crate::estimate::started;
use crate::finding::Finding;
use crate::run::Run;

/// Result of a rehearsal.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rehearsal {
    /// Number of simulated campaigns.
    pub campaigns: usize,
    /// Number of fits that failed or did not converge; they are not counted below.
    pub failed: usize,
    /// Seed of the noise.
    pub seed: u64,
    /// Parameters that the plan identifies.
    pub parameters: Vec<RehearsedParameter>,
}

/// One parameter of a rehearsal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RehearsedParameter {
    /// Index in the model.
    pub parameter: usize,
    /// Predicted standard deviation, SI.
    pub predicted: f64,
    /// Root mean square of estimate − truth, SI: scatter and bias.
    pub reached: f64,
    /// Mean of estimate − truth, SI.
    pub bias: f64,
    /// Share of the fits whose 95 % confidence interval contains the truth.
    pub covered: f64,
}

impl RehearsedParameter {
    /// Ratio of the reached to the predicted deviation.
    pub fn ratio(&self) -> f64 {
        self.reached / self.predicted
    }
}

/// Ratio of reached to predicted deviation from which a finding warns that the plan does not hold.
const WORSE: f64 = 1.2;

/// Simulates `campaigns` campaigns of `plan` with the noise of the instruments, drawn from `seed`, and fits each from
/// its own least-squares start. `progress` is called after each fit. A prediction that uses knowledge from other runs
/// cannot be reached here: rehearse a plan that stands alone.
pub fn rehearse(
    course: &Course,
    plan: &Proposal,
    fitting: &OutputErrorOptions,
    (campaigns, seed): (usize, u64),
    progress: &(dyn Fn() + Sync),
) -> (Rehearsal, Vec<Finding>) {
    let options = instrument::fitting(fitting, &course.instruments, &course.model);
    let count = plan.runs.len().max(1);
    let fits: Vec<Option<Vec<(f64, f64)>>> = (0..campaigns)
        .into_par_iter()
        .map(|campaign| {
            let log = |(k, run): (usize, &super::ProposedRun)| course.logged(&run.sailed, campaign * count + k, seed);
            let runs: Vec<Run> = plan.runs.iter().enumerate().map(log).collect();
            let fitted = output_error(&started(&course.model, &runs), &runs, &options);
            progress();
            let fitted = fitted.ok().filter(|f| f.converged)?;
            let of = |p: usize| (fitted.model.parameters[p].value, fitted.model.parameters[p].std.unwrap_or(0.0));
            Some(shared(&course.model).into_iter().map(of).collect())
        })
        .collect();
    let good: Vec<&Vec<(f64, f64)>> = fits.iter().flatten().collect();
    let n = good.len() as f64;
    let mut warnings = Vec::new();
    let mut parameters = Vec::new();
    for (k, told) in plan.parameters.iter().enumerate().filter(|_| !good.is_empty()) {
        let Some(predicted) = told.std else { continue };
        let errors: Vec<f64> = good.iter().map(|fit| fit[k].0 - told.value).collect();
        let held = good.iter().filter(|fit| (fit[k].0 - told.value).abs() <= 1.96 * fit[k].1).count();
        let one = RehearsedParameter {
            parameter: told.parameter,
            predicted,
            reached: (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
            bias: errors.iter().sum::<f64>() / n,
            covered: held as f64 / n,
        };
        // three standard errors of the ratio beyond WORSE, so that chance alone does not warn
        if one.ratio() > WORSE + 3.0 * WORSE / (2.0 * n).sqrt() {
            let p = &course.model.parameters[told.parameter];
            let text = format!(
                "{} of `{}`: simulated fits scatter by {:.3e}, {:.2} times what the plan predicts",
                p.spec.name,
                p.term,
                one.reached,
                one.ratio()
            );
            warnings.push(Finding::new(&codes::REHEARSED_WORSE, text));
        }
        parameters.push(one);
    }
    let failed = campaigns - good.len();
    if failed * 20 > campaigns {
        let text = format!("{failed} of {campaigns} simulated campaigns of this plan cannot be fitted");
        warnings.push(Finding::new(&codes::REHEARSED_WORSE, text));
    }
    (Rehearsal { campaigns, failed, seed, parameters }, warnings)
}
