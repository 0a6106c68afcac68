//! The fit by filter error, in the common form of fits.

use std::collections::BTreeMap;

use super::super::codes;
use super::super::discover;
use super::super::error::Error;
use super::super::file::Estimator;
use super::super::first_samples;
use super::super::identifiability::of_covariance;
use super::super::load::Campaign;
use super::super::noise;
use super::super::steps_as_lines;
use super::result::FitStage;
use super::rows::paper;
use super::{Raw, residuals, thrust, untold_inertias, with_deviations};
use crate::discover::{fitted, lacking};
use crate::effects::Family;
use crate::estimate::filter_error::{
    FilterErrorFit, FilterErrorOptions, Filtered, Forecast, filter_error, with_all_open,
};
use crate::estimate::output_error::OutputErrorError;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::{Model, Parameter};
use crate::progress::tell;
use crate::run::{Role, Run};
use crate::wording::p_value;

/// Verdict on a model whose predictions have lost all value.
const RUNS_AWAY: &str = "Do not use these numbers: 8 s ahead the model's prediction diverges from the measured motion; \
                         `hydrosysid check` may say why.";

/// Returns the options that the campaign asks for.
pub(in crate::campaign) fn options(campaign: &Campaign) -> FilterErrorOptions {
    FilterErrorOptions {
        base: campaign.options.output_error.clone(),
        forces: campaign.file.noise.forces().unwrap_or_default(),
        ..FilterErrorOptions::default()
    }
}

pub(super) fn by_filter_error(campaign: &Campaign, runs: &[Run]) -> Result<Raw, Error> {
    let options = FilterErrorOptions { told: true, ..options(campaign) };
    let fitted = fitted(&campaign.model, runs, &options, &discover::options(campaign))?;
    tell("predicting with the model", 0, 0);
    let mut warnings = Vec::new();
    if !fitted.converged {
        let text = format!("filter error stopped after {} passes without converging", fitted.iterations);
        warnings.push(Finding::new(&codes::NOT_CONVERGED, text));
    }
    let (filtered, model) = held_out(campaign, &fitted, &options)?;
    let held = if campaign.validates() { &filtered.problem.tracks[..] } else { &[] };
    warnings.extend(first_samples::findings(fitted.filtered.problem.tracks.iter().chain(held)));
    warnings.extend(own_values(campaign, &model));
    let of_training = fitted.forecast();
    let forecasts = match &others(campaign)[..] {
        [] => of_training.clone(),
        others => filtered.forecast(&model, &fitted.noise.elsewhere(&model, others), fitted.limit),
    };
    let found = noise::of_fit((&fitted, &of_training), runs, &campaign.file.noise.sensors, (&filtered, &forecasts));
    let errs = |forecasts: &[Forecast]| -> Vec<String> {
        let all = noise::by_dof(&filtered, forecasts, Some(8.0));
        let erring = all.iter().filter(|(_, p)| p.errs(all.len()));
        erring.map(|(dof, p)| format!("{:.1} times in {dof}", p.ratio())).collect()
    };
    let lost = noise::by_dof(&filtered, &forecasts, Some(8.0)).iter().any(|(_, p)| p.runs_away());
    let (mut erring, others) = (errs(&forecasts), others(campaign));
    if !erring.is_empty() && !lost && !others.is_empty() {
        let at = (&others[..], &options.base);
        erring = errs(&with_all_open(&fitted, &model, &forecasts, at, campaign.options.seed)?);
    }
    let lacking = match fitted.converged && !lost {
        // if the catalogue cannot be tried on a log, `discover` reports it, and the fit stands
        true => lacking(&fitted, runs, &campaign.candidates, &options, &discover::options(campaign)).unwrap_or(None),
        false => None,
    };
    let mut refuted = Vec::new();
    if steps_as_lines::refuted(&campaign.findings, &fitted, runs, &options) {
        refuted.push(codes::STEPS_AS_LINES.code);
    }
    let mut covariance = in_model_order(&fitted);
    let mut fitted = fitted;
    let carried = thrust::carried(campaign, runs, |runs| {
        let moved = filter_error(&fitted.model, runs, &fitted.nearby(&options))?;
        Ok::<_, Error>(
            fitted.model.parameters.iter().zip(&moved.model.parameters).map(|(a, b)| b.value - a.value).collect(),
        )
    })?;
    widen(&mut covariance, &mut fitted.model, carried.iter().flatten());
    // if thruster curves are uncertain, a missing effect of the actuators is taken for their error,
    // which the deviations include already
    let unknown = lacking.as_ref().filter(|lacking| carried.is_none() || lacking.family != Family::Actuator);
    let included = |what: &str| match unknown {
        Some(_) => format!(", and their standard errors include how far {what} would shift them"),
        None => String::new(),
    };
    warnings.extend(lacking.as_ref().filter(|_| erring.is_empty()).map(|lacking| {
        let text = format!(
            "the innovations match the signature of an effect that the model lacks ({}, of {} candidates): parameters \
             are biased by it{}; `hydrosysid discover` looks for its name",
            p_value(lacking.p_value),
            lacking.candidates,
            included("it")
        );
        Finding::new(&codes::LACKING, text)
    }));
    if lost {
        warnings.push(Finding::new(&codes::MORE_MISSING, RUNS_AWAY));
    } else if !erring.is_empty() {
        let text = format!(
            "predictions 8 s ahead err by more than sensor noise and random force explain ({}): the model is \
             incomplete and its parameters are biased{}; `hydrosysid discover` looks for the missing effect",
            erring.join(", "),
            included("the likeliest effect")
        );
        warnings.push(Finding::new(&codes::MORE_MISSING, text));
    }
    let std_paper = paper(&campaign.model, runs);
    if std_paper.iter().all(Option::is_none) {
        warnings.push(Finding::new(&codes::NOT_AT_START, codes::NOT_AT_START.meaning));
    }
    // what the data separates, whatever else moves the parameters
    let identifiability = of_covariance(&fitted.model, &covariance, runs, &mut warnings);
    // inertias that the data determines by itself, but not if the missing effect moves them
    let told_by_data = untold_inertias(&fitted.model).is_empty();
    if let Some(unknown) = unknown {
        widen(&mut covariance, &mut fitted.model, unknown.covariance().iter());
    }
    let bent = if told_by_data { untold_inertias(&fitted.model) } else { Vec::new() };
    let sentence = if lost { RUNS_AWAY.into() } else { sentence(&fitted, &found, &erring, (lacking.is_some(), &bent)) };
    Ok(Raw {
        stages: stages(&fitted, &of_training, runs, &identifiability),
        residuals: residuals::innovations(&fitted, &of_training),
        model: fitted.model,
        elsewhere: campaign.validates().then_some(model),
        std_method: thrust::told(
            if unknown.is_some() { "information, with the moves by an effect that is missing" } else { "information" },
            carried.is_some(),
        ),
        covariance,
        std_paper,
        efficiency: campaign.file.efficiency.clone(),
        identifiability,
        noise: Some(found),
        converged: fitted.converged,
        sentence: Some(sentence),
        warnings,
        refuted,
    })
}

/// Adds further uncertainty to a covariance and to the deviations of the model.
fn widen<'a>(covariance: &mut [Vec<f64>], model: &mut Model, more: impl Iterator<Item = &'a Vec<f64>>) {
    for (i, row) in more.enumerate() {
        covariance[i].iter_mut().zip(row).for_each(|(entry, more)| *entry += more);
        let parameter = &mut model.parameters[i];
        parameter.std = parameter.std.map(|_| covariance[i][i].max(0.0).sqrt());
    }
}

/// Returns the held-out runs of free motion.
fn others(campaign: &Campaign) -> Vec<Run> {
    campaign.motion(Some(Role::Validate))
}

/// Returns the held-out runs, prepared for the filter with all parameters held; the training runs
/// if there are none.
pub(in crate::campaign) fn held_out(
    campaign: &Campaign,
    fitted: &FilterErrorFit,
    options: &FilterErrorOptions,
) -> Result<(Filtered, Model), Error> {
    let others = others(campaign);
    if others.is_empty() {
        return Ok((fitted.filtered.clone(), fitted.model.clone()));
    }
    let model = match fitted.on_others(&others, options) {
        // where the model runs away there are no values of the runs' own, and how far it runs must
        // be reported
        Err(OutputErrorError::Diverges { .. }) => {
            let mut mean = noise::with_parameters_fixed(&fitted.model);
            mean.parameters.iter_mut().for_each(|p| p.per_run.clear());
            mean
        }
        model => model?,
    };
    let noise = fitted.noise.elsewhere(&model, &others);
    Ok((Filtered::begun(&model, &others, (&noise, fitted.limit), &options.base)?, model))
}

/// Returns the finding about parameters that have their own values in held-out runs, and where
/// these come from.
fn own_values(campaign: &Campaign, model: &Model) -> Option<Finding> {
    let own: Vec<&str> = model.parameters.iter().filter(|p| !p.per_run.is_empty()).map(|p| &*p.spec.name).collect();
    if own.is_empty() || !campaign.validates() {
        return None;
    }
    let text = format!(
        "{}: in a run that took no part in the fit, the value is estimated from the first half of that run; the \
         prediction starts there, so only the second half is a fair test",
        own.join(", ")
    );
    Some(Finding::new(&codes::OWN_VALUES, text))
}

/// Returns the covariance in the order of the model's parameters.
fn in_model_order(fitted: &FilterErrorFit) -> Vec<Vec<f64>> {
    let unknowns = &fitted.filtered.problem.unknowns;
    let (count, p) = (fitted.model.parameters.len(), unknowns.len());
    let mut covariance = vec![vec![0.0; count]; count];
    for (i, a) in unknowns.iter().enumerate() {
        for (j, b) in unknowns.iter().enumerate().filter(|(_, b)| a.run.is_none() && b.run.is_none()) {
            covariance[a.parameter][b.parameter] = fitted.covariance[i * p + j];
        }
        if a.run.is_some() {
            let own = &mut covariance[a.parameter][a.parameter];
            *own = own.max(fitted.covariance[i * p + i]);
        }
    }
    covariance
}

/// Returns one entry per degree of freedom, with the root mean square of its innovations.
fn stages(
    fitted: &FilterErrorFit,
    forecasts: &[Forecast],
    runs: &[Run],
    identifiability: &Option<super::Identifiability>,
) -> Vec<FitStage> {
    let scaled = identifiability.as_ref().map_or(1.0, |i| i.condition_number_scaled);
    let condition_number = fitted.condition_number();
    let names: Vec<String> = runs.iter().map(|run| run.name.clone()).collect();
    let dofs: BTreeMap<Dof, _> = noise::by_dof(&fitted.filtered, forecasts, Some(0.0)).into_iter().collect();
    dofs.into_iter()
        .map(|(dof, innovations)| FitStage {
            name: Estimator::FilterError.name().into(),
            dof,
            runs: names.clone(),
            rows: innovations.count,
            residual_std: innovations.rms(),
            condition_number,
            condition_number_scaled: scaled,
            estimates: Vec::new(),
            covariance: Vec::new(),
            numbers: None,
        })
        .collect()
}

/// Returns the verdict: `lacks` says whether the model lacks an effect, and `bent` are the inertias
/// that are uncertain because of it.
fn sentence(
    fitted: &FilterErrorFit,
    found: &noise::Noise,
    erring: &[String],
    (lacks, bent): (bool, &[&Parameter]),
) -> String {
    if !fitted.converged {
        let why = found.overwhelming().map_or(String::new(), |why| format!(" {why}"));
        return format!("Do not use these numbers: the fit did not converge.{why}");
    }
    if let Some(why) = found.overwhelming() {
        return format!("Do not use these numbers, although the fit converged. {why}");
    }
    let pushed = found.sentence();
    let white =
        if found.innovations_white { "" } else { " Innovations are not white: standard errors may be too small." };
    let strong = found.beyond_turbulence("");
    if !bent.is_empty() {
        return format!(
            "Do not use these numbers, although the fit converged: the model lacks an effect that would change {}; \
             `hydrosysid discover` looks for it. {pushed}{strong}{white}",
            with_deviations(bent)
        );
    }
    if !erring.is_empty() {
        return format!(
            "The fit converged, but the model is incomplete: predictions 8 s ahead err more than expected, {}. {pushed}",
            erring.join(", ")
        );
    }
    if lacks {
        return format!(
            "The fit converged, but the model lacks an effect: predictions 8 s ahead err as expected, yet the \
             innovations match the signature of one; `hydrosysid discover` looks for it. {pushed}{strong}{white}"
        );
    }
    let strong = found.beyond_turbulence(": `hydrosysid discover` looks for what is missing");
    format!("The fit converged, and predictions 8 s ahead err as much as expected. {pushed}{strong}{white}")
}
