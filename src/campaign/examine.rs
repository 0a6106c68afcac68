//! The thorough part of the verb `fit`, which needs further fits.

use std::collections::BTreeMap;

use super::codes;
use super::error::Error;
use super::examine_rows;
use super::file::Estimator;
use super::fit::Fit;
use super::identifiability::{Identifiability, OtherLength, ProfileOf, UNCERTAIN};
use super::load::Campaign;
use super::plan::{PlannedParameter, plan};
use super::plan_request::{PlanRequest, Want};
use super::plan_source::PlanSource;
use crate::estimate::identifiability::profile;
use crate::estimate::output_error::{OutputErrorError, OutputErrorFit, OutputErrorOptions, output_error};
use crate::finding::Finding;
use crate::progress::Count;
use crate::run::{Role, Run};

/// Largest number of parameters with a profile likelihood.
const MOST_PROFILES: usize = 8;

/// Adds the results of further fits to the identifiability and the warnings of `fit`: profile
/// likelihoods of doubtful parameters, fits with segments of other lengths, and for each group the
/// run that would improve it most; for fits by rows, halves of the runs and longer windows.
///
/// # Errors
/// [`Error`] if the campaign cannot be fitted again.
pub fn examine(campaign: &Campaign, fit: &mut Fit) -> Result<(), Error> {
    if !matches!(fit.estimator, Estimator::FilterError | Estimator::OutputError) {
        return examine_rows::examine(campaign, fit);
    }
    let runs = campaign.motion(Some(Role::Train));
    let options = &campaign.options.output_error;
    let mut model = fit.model.clone();
    for p in &mut model.parameters {
        p.per_run.clear();
    }
    let again = match output_error(&model, &runs, options) {
        Ok(again) => again,
        // the fit stands, although a model that diverges when it is simulated again is worth little
        Err(OutputErrorError::Diverges { .. }) => {
            fit.warnings.push(Finding::new(&codes::NOT_EXAMINED, codes::NOT_EXAMINED.meaning));
            return Ok(());
        }
        Err(other) => return Err(other.into()),
    };
    let Some(mut found) = fit.identifiability.take() else { return Ok(()) };
    let mut findings = Vec::new();
    let count = Count::begun("fits with other segments", 2);
    for factor in [0.5, 2.0] {
        found.segment_lengths.extend(other_length(&again, &runs, options, factor, &mut findings));
        count.one_done();
    }
    let doubtful: Vec<usize> = doubtful(&again, &found).into_iter().take(MOST_PROFILES).collect();
    let count = Count::begun("profile likelihoods", doubtful.len());
    for parameter in doubtful {
        let made = profile(&again, &runs, options, parameter)?;
        count.one_done();
        let p = &again.model.parameters[parameter];
        if made.interval.iter().any(Option::is_none) {
            let text = format!(
                "{}: this data does not bound it on both sides within five standard errors or its own bounds",
                again.model.parameters[parameter].full_name()
            );
            findings.push(Finding::new(&codes::NOT_BOUNDED, text));
        }
        found.profiles.push(ProfileOf {
            term: p.term.clone(),
            name: p.spec.name.clone(),
            values: made.points.iter().map(|q| q.value).collect(),
            rise: made.points.iter().map(|q| q.rise).collect(),
            interval: made.interval,
        });
    }
    let count = Count::begun("runs that would help most", found.groups.len());
    for group in &mut found.groups {
        count.one_done();
        if let Some(run) = next_run(campaign, fit, &group.terms) {
            group.run = run;
        }
    }
    fit.identifiability = Some(found);
    fit.warnings.extend(findings);
    Ok(())
}

/// Returns the parameters whose confidence region may not be an ellipse: uncertain ones and members
/// of a group.
fn doubtful(fit: &OutputErrorFit, found: &Identifiability) -> Vec<usize> {
    let uncertain = |p: usize| {
        let told = &fit.model.parameters[p];
        told.std.unwrap_or(0.0) > UNCERTAIN * told.value.abs()
    };
    let grouped = |p: usize| found.groups.iter().any(|g| g.terms.contains(&fit.model.parameters[p].full_name()));
    let shared = fit.problem.unknowns.iter().filter(|u| u.run.is_none()).map(|u| u.parameter);
    shared
        .filter(|p| uncertain(*p) || grouped(*p))
        .filter(|p| fit.model.parameters[*p].std.is_some_and(|s| s > 0.0))
        .collect()
}

/// Fits with segments `factor` times as long and returns the changes of the estimates.
fn other_length(
    fit: &OutputErrorFit,
    runs: &[Run],
    options: &OutputErrorOptions,
    factor: f64,
    findings: &mut Vec<Finding>,
) -> Option<OtherLength> {
    let segment = options.segment * factor;
    let other = output_error(&fit.model, runs, &OutputErrorOptions { segment, ..options.clone() }).ok()?;
    let mut change = BTreeMap::new();
    for unknown in fit.problem.unknowns.iter().filter(|u| u.run.is_none()) {
        let (now, then) = (&fit.model.parameters[unknown.parameter], &other.model.parameters[unknown.parameter]);
        let std = now.std.unwrap_or(0.0).max(then.std.unwrap_or(0.0));
        let ratio = if std > 0.0 { (then.value - now.value) / std } else { 0.0 };
        let name = fit.model.parameters[unknown.parameter].full_name();
        if ratio.abs() > 3.0 {
            let text = format!(
                "{name}: with segments of {segment:.1} s instead of {:.1} s it is {:.4e} instead of {:.4e}, {:.1} \
                 standard errors away: the model lacks something slow",
                options.segment,
                then.value,
                now.value,
                ratio.abs()
            );
            findings.push(Finding::new(&codes::SEGMENT_LENGTH, text));
        }
        change.insert(name, ratio);
    }
    Some(OtherLength { segment, change })
}

/// Describes the run that would improve the parameters of a group most, in addition to the data
/// that is there.
fn next_run(campaign: &Campaign, fit: &Fit, group: &[String]) -> Option<String> {
    let term = |label: &String| label.split(" of ").nth(1).map(str::to_string);
    let wants = group.iter().filter_map(term).map(|t| Want { parameter: Some(t), amount: 1e-3, relative: true });
    let request = PlanRequest { wants: wants.collect(), most: 1, ..PlanRequest::default() };
    let made = plan(&PlanSource::of_fit(campaign, fit), &request, &|| {}).ok()?;
    let run = made.runs.first()?;
    let gain = |p: &PlannedParameter| Some(p.std_now? / p.std?);
    let wanted = made.parameters.iter().filter(|p| p.wanted.is_some());
    let best = wanted.filter_map(gain).fold(1.0, f64::max);
    Some(format!(
        "a run of {:.0} s like `{}` would reduce their standard errors up to {best:.1} times",
        run.length, run.name
    ))
}
