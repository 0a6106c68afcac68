//! The fit by output error, in the common form of fits.

use super::super::codes;
use super::super::discover;
use super::super::error::Error;
use super::super::file::Estimator;
use super::super::first_samples;
use super::super::identifiability;
use super::super::load::Campaign;
use super::filter_error::options as filter_error_options;
use super::result::FitStage;
use super::rows::paper;
use super::{Raw, residuals, thrust};
use crate::discover::begun;
use crate::estimate::filter_error::{FilterErrorOptions, filter_error};
use crate::estimate::output_error::{OutputErrorFit, OutputErrorOptions, StdMethod, output_error};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::progress::tell;
use crate::run::Run;

/// Returns a start that is near enough if a time constant or another shape is sought, which no
/// regression gives: the result of filter error, which allows for model errors and so converges
/// from further away.
fn near(start: Model, runs: &[Run], base: &OutputErrorOptions) -> Model {
    if start.parameters.iter().all(|p| p.fixed || p.spec.is_linear()) {
        return start;
    }
    let base = OutputErrorOptions { told: false, ..base.clone() };
    let options = FilterErrorOptions { base, refine: false, tolerance: 1.0, ..FilterErrorOptions::default() };
    filter_error(&start, runs, &options).map_or(start, |fit| fit.model)
}

pub(super) fn by_output_error(campaign: &Campaign, runs: &[Run]) -> Result<Raw, Error> {
    let options = OutputErrorOptions { join: campaign.file.fit.join, ..campaign.options.output_error.clone() };
    let telling = OutputErrorOptions { told: true, ..options.clone() };
    let start = begun(&campaign.model, runs, &filter_error_options(campaign), &discover::options(campaign));
    let mut fitted = output_error(&near(start, runs, &options), runs, &telling)?;
    tell("checking what the data identifies", 0, 0);
    let mut warnings = Vec::new();
    if !fitted.converged {
        let text = format!("output error stopped after {} steps without converging", fitted.iterations);
        warnings.push(Finding::new(&codes::NOT_CONVERGED, text));
    }
    warnings.extend(first_samples::findings(fitted.problem.tracks.iter()));
    if fitted.std_method == StdMethod::FewClusters {
        warnings.push(Finding::new(&codes::FEW_STRETCHES, codes::FEW_STRETCHES.meaning));
    }
    warnings.extend(far_above_noise(&fitted));
    let carried = thrust::carried(campaign, runs, |runs| fitted.response(runs, &options))?;
    if let Some(carried) = &carried {
        widen(&mut fitted, carried);
    }
    let std_paper = paper(&campaign.model, runs);
    if std_paper.iter().all(Option::is_none) {
        warnings.push(Finding::new(&codes::NOT_AT_START, codes::NOT_AT_START.meaning));
    }
    let count = fitted.model.parameters.len();
    let mut covariance = vec![vec![0.0; count]; count];
    let unknowns = &fitted.problem.unknowns;
    let p = unknowns.len();
    for (i, a) in unknowns.iter().enumerate() {
        for (j, b) in unknowns.iter().enumerate().filter(|(_, b)| a.run.is_none() && b.run.is_none()) {
            covariance[a.parameter][b.parameter] = fitted.covariance[i * p + j];
        }
        if a.run.is_some() {
            let own = &mut covariance[a.parameter][a.parameter];
            *own = own.max(fitted.covariance[i * p + i]);
        }
    }
    let std_method = match fitted.std_method {
        StdMethod::Information => "information",
        StdMethod::Clusters => "clusters",
        StdMethod::FewClusters => "few clusters",
    };
    let stages = output_error_stages(&fitted, runs);
    let identifiability = identifiability::of_fit(campaign, &fitted, runs, &mut warnings);
    Ok(Raw {
        residuals: residuals::output_errors(&fitted),
        model: fitted.model,
        elsewhere: None,
        std_method: thrust::told(std_method, carried.is_some()),
        covariance,
        std_paper,
        stages,
        efficiency: campaign.file.efficiency.clone(),
        identifiability,
        noise: None,
        converged: fitted.converged,
        sentence: None,
        warnings,
        refuted: Vec::new(),
    })
}

/// Ratio of the residual to the noise of the sensor above which a model lacks something, whatever
/// else is said of it.
const FAR: f64 = 3.0;

/// Returns the finding that the model is far from the data to which it was fitted, if it is.
fn far_above_noise(fitted: &OutputErrorFit) -> Option<Finding> {
    let times = fitted.times_noise();
    let outputs = fitted.problem.dynamics.outputs.iter().zip(times);
    let far: Vec<String> =
        outputs.filter(|(_, times)| *times > FAR).map(|(name, times)| format!("{name} by {times:.1}")).collect();
    let text = format!(
        "the fitted runs are off by several times the noise of their sensors ({}): the model lacks something, and its \
         parameters compensate for it; `hydrosysid discover` looks for it",
        far.join(", ")
    );
    (!far.is_empty()).then(|| Finding::new(&codes::MORE_MISSING, text))
}

/// Adds to the covariance of the unknowns, and to the deviations of the model's parameters.
fn widen(fitted: &mut OutputErrorFit, carried: &[Vec<f64>]) {
    let p = fitted.problem.unknowns.len();
    for (k, more) in carried.iter().flatten().enumerate() {
        fitted.covariance[k] += more;
    }
    for (k, unknown) in fitted.problem.unknowns.iter().enumerate() {
        let std = &mut fitted.model.parameters[unknown.parameter].std;
        // for a parameter per run the largest deviation is shown
        let other = if unknown.run.is_some_and(|r| r > 0) { std.unwrap_or(0.0) } else { 0.0 };
        *std = Some(fitted.covariance[k * p + k].max(0.0).sqrt().max(other));
    }
}

fn output_error_stages(fitted: &OutputErrorFit, runs: &[Run]) -> Vec<FitStage> {
    let (condition_number, condition_number_scaled) = fitted.condition_numbers();
    let outputs = fitted.problem.dynamics.outputs.iter().enumerate();
    outputs
        .filter_map(|(k, channel)| Some((k, Dof::ALL.into_iter().find(|dof| dof.velocity() == *channel)?)))
        .map(|(k, dof)| FitStage {
            name: Estimator::OutputError.name().into(),
            dof,
            runs: runs.iter().map(|run| run.name.clone()).collect(),
            rows: fitted.problem.samples_of(k),
            residual_std: fitted.residual_rms[k],
            condition_number,
            condition_number_scaled,
            estimates: Vec::new(),
            covariance: Vec::new(),
            numbers: None,
        })
        .collect()
}
