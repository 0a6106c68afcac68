//! Fits of rows: integral least squares on all runs, and the staged procedure.

use super::super::codes;
use super::super::error::Error;
use super::super::file::Estimator;
use super::super::identifiability::of_covariance;
use super::super::load::{Campaign, with_nominal_forces};
use super::result::FitStage;
use super::{Raw, residuals, thrust};
use crate::estimate::{AtBound, IntegralOptions, RegressorOptions, RowFit, Span, StdMethod, integral_least_squares};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::procedure::{Estimate, staged, without_steady_runs};
use crate::run::{Role, Run};
use crate::wording::listed;

/// Returns standard deviations by (14), of the one-sample trapezoid; `None` if there is no such
/// regressor.
pub(super) fn paper(model: &Model, runs: &[Run]) -> Vec<Option<f64>> {
    let mut std = vec![None; model.parameters.len()];
    let all: Vec<&Run> = runs.iter().collect();
    let options =
        IntegralOptions { regressor: RegressorOptions::default(), std: StdMethod::Paper, ..IntegralOptions::default() };
    if let Ok((_, fits)) = integral_least_squares(&all, model, options) {
        for fit in &fits {
            for (column, value) in fit.parameters.iter().zip(&fit.std_paper) {
                std[column.parameter] = Some(*value);
            }
        }
    }
    std
}

/// Returns the options of the rows, with windows `times` as long as the campaign asks for.
fn integral_options(campaign: &Campaign, times: usize) -> IntegralOptions {
    let window = campaign.file.stage.oscillatory.window * times;
    let regressor = RegressorOptions { span: Span::Samples(window), ..RegressorOptions::default() };
    IntegralOptions { regressor, ..IntegralOptions::default() }
}

/// Returns the campaign's model as an estimator of rows finds it from these runs alone, with
/// windows `times` as long.
///
/// # Errors
/// As [`super::fit()`].
pub(in crate::campaign) fn again(
    campaign: &Campaign,
    estimator: Estimator,
    runs: Vec<Run>,
    times: usize,
) -> Result<Model, Error> {
    if estimator == Estimator::Staged {
        let mut stage = campaign.file.stage.clone();
        stage.oscillatory.window *= times;
        stage.zigzag.window *= times;
        stage.direct.skip = true;
        return Ok(staged(&with_nominal_forces(runs), &campaign.model, campaign.bench(), &stage)?.model);
    }
    let all: Vec<&Run> = runs.iter().collect();
    Ok(integral_least_squares(&all, &campaign.model, integral_options(campaign, times))?.0)
}

/// Returns the campaign's model by integral least squares on other runs.
///
/// # Errors
/// As [`super::fit()`].
pub(in crate::campaign) fn integral_again(campaign: &Campaign, runs: &[Run]) -> Result<Model, Error> {
    let all: Vec<&Run> = runs.iter().collect();
    Ok(integral_least_squares(&all, &campaign.model, integral_options(campaign, 1))?.0)
}

pub(super) fn by_integral(campaign: &Campaign, runs: &[Run]) -> Result<Raw, Error> {
    let all: Vec<&Run> = runs.iter().collect();
    let options = integral_options(campaign, 1);
    let (model, fits) = integral_least_squares(&all, &campaign.model, options)?;
    let names: Vec<String> = runs.iter().map(|run| run.name.clone()).collect();
    let mut raw = of_rows(model, &fits, &names, campaign);
    raw.residuals = residuals::of_rows(&raw.model, &all, options);
    let before: Vec<f64> = raw.model.parameters.iter().map(|p| p.value).collect();
    let carried = thrust::carried(campaign, runs, |runs| {
        let runs: Vec<&Run> = runs.iter().collect();
        let (moved, _) = integral_least_squares(&runs, &campaign.model, options)?;
        Ok::<_, Error>(moved.parameters.iter().zip(&before).map(|(p, b)| p.value - b).collect())
    })?;
    for (i, row) in carried.iter().flatten().enumerate() {
        for (j, more) in row.iter().enumerate() {
            raw.covariance[i][j] += more;
        }
        let parameter = &mut raw.model.parameters[i];
        parameter.std = parameter.std.map(|_| raw.covariance[i][i].max(0.0).sqrt());
    }
    raw.std_method = thrust::told(&raw.std_method, carried.is_some());
    raw.identifiability = of_covariance(&raw.model, &raw.covariance, runs, &mut raw.warnings);
    Ok(raw)
}

/// Returns the finding that rows contradict a bound, if they do so by more than two standard
/// deviations.
fn without_bound(model: &Model, held: &AtBound) -> Option<Finding> {
    let p = &model.parameters[held.parameter];
    let AtBound { unbounded, std, .. } = *held;
    let text = format!(
        "{} of `{}` is held at its bound of {}: without it the rows give {unbounded:.4} ± {std:.2} {}; a sign, a frame \
         or the scale of thrust is wrong, or this data does not determine it",
        p.spec.name, p.term, p.value, p.spec.dimension
    );
    let far = (p.value - unbounded).abs() > 2.0 * std;
    far.then(|| Finding::new(&codes::UNPHYSICAL, text))
}

/// Puts fits of rows together.
pub(in crate::campaign) fn of_rows(model: Model, fits: &[RowFit], runs: &[String], campaign: &Campaign) -> Raw {
    let count = model.parameters.len();
    let mut covariance = vec![vec![0.0; count]; count];
    let mut std_paper = vec![None; count];
    let mut stages = Vec::new();
    for fit in fits {
        for (i, a) in fit.parameters.iter().enumerate() {
            std_paper[a.parameter] = Some(fit.std_paper[i]);
            for (j, b) in fit.parameters.iter().enumerate() {
                covariance[a.parameter][b.parameter] = fit.covariance[i][j];
            }
        }
        stages.extend(fit.dofs.iter().map(|dof| FitStage {
            name: Estimator::Integral.name().into(),
            dof: *dof,
            runs: runs.to_vec(),
            rows: fit.rows,
            residual_std: fit.residual_std,
            condition_number: fit.condition_number,
            condition_number_scaled: fit.condition_number_scaled,
            estimates: Vec::new(),
            covariance: Vec::new(),
            numbers: None,
        }));
    }
    let efficiency = campaign.file.efficiency.clone();
    let std_method = "hac".into();
    let at_bound = fits.iter().flat_map(|fit| &fit.at_bound);
    let warnings = at_bound.filter_map(|held| without_bound(&model, held)).collect();
    let identifiability = None;
    let (noise, converged, sentence) = (None, true, None);
    Raw {
        model,
        elsewhere: None,
        std_method,
        covariance,
        std_paper,
        stages,
        residuals: Vec::new(),
        efficiency,
        identifiability,
        noise,
        converged,
        sentence,
        warnings,
        refuted: Vec::new(),
    }
}

pub(super) fn by_stages(campaign: &Campaign) -> Result<Raw, Error> {
    let bench = campaign.bench();
    let result = staged(&campaign.nominal_runs(), &campaign.model, bench, &campaign.file.stage)?;
    let mut std_paper = vec![None; result.model.parameters.len()];
    for (k, p) in result.model.parameters.iter().enumerate() {
        let named = |e: &&Estimate| e.name == p.spec.name && e.effect == p.effect;
        let own = result.stages.iter().rev().filter(|s| s.name != "direct");
        std_paper[k] = own.filter_map(|s| s.estimates.iter().find(named)).map(|e| e.std_paper).next();
    }
    let mut warnings = result.warnings;
    warnings.extend(result.stages.iter().flat_map(|s| s.warnings.iter().cloned()));
    let moving = campaign.motion(Some(Role::Train));
    let identifiability = of_covariance(&result.model, &result.covariance, &moving, &mut warnings);
    let stages = result.stages.into_iter().map(FitStage::from).collect();
    let sentence = beside_no_drag(campaign, &result.model);
    let rows = match campaign.file.stage.std {
        StdMethod::Paper => "paper",
        StdMethod::Hac => "hac",
    };
    Ok(Raw {
        model: result.model,
        elsewhere: None,
        std_method: thrust::told(
            &format!("{rows}, with what earlier stages leave uncertain by the delta method"),
            !campaign.curves.is_empty(),
        ),
        covariance: result.covariance,
        std_paper,
        stages,
        residuals: Vec::new(),
        efficiency: result.efficiency,
        identifiability,
        noise: None,
        converged: true,
        sentence,
        warnings,
        refuted: Vec::new(),
    })
}

/// Returns the verdict on inertias that were found together with a drag that no run shows and that
/// stays absent, if any.
fn beside_no_drag(campaign: &Campaign, fitted: &Model) -> Option<String> {
    let found = |dof: &Dof| fitted.inertia(*dof).is_some_and(|p| fitted.parameters[p].std.is_some());
    let blind: Vec<Dof> = without_steady_runs(&campaign.runs, fitted).into_iter().filter(found).collect();
    let names: Vec<&str> = blind.iter().map(|dof| dof.name()).collect();
    (!blind.is_empty()).then(|| {
        format!(
            "Do not use these numbers for {}: no run at constant speed shows the drag there, and the inertia was \
             estimated without any; add such runs, or use estimator = \"filter_error\", which estimates both.",
            listed(&names)
        )
    })
}
