//! The verb `fit`: parameters from the training runs, with what is needed to believe them or not.

use std::collections::BTreeMap;

use serde::Serialize;

use super::codes;
use super::error::Error;
use super::file::Estimator;
use super::identifiability::{self, Identifiability};
use super::load::{Campaign, moves};
use crate::effects::Place;
use crate::envelope::{self, Envelope};
use crate::estimate::output_error::{OutputErrorFit, OutputErrorOptions, Problem, output_error};
use crate::estimate::{IntegralOptions, RegressorOptions, RowFit, Span, StdMethod, integral_least_squares, started};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::{Model, Parameter};
use crate::plan::{Instrument, Instruments};
use crate::procedure::sensitivity::{Setting, filter_table, usual_filters};
use crate::procedure::{Estimate, FlowNumbers, Stage, staged};
use crate::run::{Role, Run, RunKind};
use crate::thrust::efficiency::Efficiency;
use crate::vehicle::Vehicle;

/// Options of the verb.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FitOptions {
    /// The estimator; that of the campaign, else the one that suits its runs, when absent.
    pub estimator: Option<Estimator>,
}

/// A fitted campaign. Serialises as `hydrosysid fit --json`.
#[derive(Debug, Clone, Serialize)]
pub struct Fit {
    /// Format of the result: 1.
    pub format: u32,
    /// Parameters, in the order of the model.
    pub parameters: Vec<FitParameter>,
    /// What estimated them.
    pub estimator: Estimator,
    /// How `std` was found.
    pub std_method: String,
    /// Covariance in the order of `parameters`, SI; 0 for those that were held.
    pub covariance: Vec<Vec<f64>>,
    /// Fits of which it is made.
    pub stages: Vec<FitStage>,
    /// What the data can tell and what it cannot; output error only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub identifiability: Option<Identifiability>,
    /// How the estimates move with window and degree of a polynomial filter, where [`filters`] was asked.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub filters: Vec<Setting>,
    /// What there is to say.
    pub warnings: Vec<Finding>,
    /// The model with the estimates in place.
    #[serde(skip)]
    pub model: Model,
    /// Losses of thrust that the values go with: those of the campaign, and what bollard runs have shown.
    #[serde(skip)]
    pub efficiency: Efficiency,
    /// Speeds, angles, forces and amplitudes of the runs that took part.
    #[serde(skip)]
    pub envelope: Envelope,
    /// Noise and rate of the channels that the model predicts, in the runs that took part.
    #[serde(skip)]
    pub instruments: Instruments,
}

/// One parameter of a fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitParameter {
    /// Id of the effect.
    pub effect: String,
    /// Degree of freedom in whose balance it stands; `null` for the whole vehicle.
    pub dof: Option<Dof>,
    /// The other degree of freedom of a coupling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other: Option<Dof>,
    /// Symbol.
    pub name: String,
    /// Value, SI.
    pub value: f64,
    /// Standard deviation, SI; 0 for one that was held.
    pub std: Option<f64>,
    /// Standard deviation by the paper's (14), SI; `null` where no linear regressor has it.
    pub std_paper: Option<f64>,
    /// Unit.
    pub unit: String,
    /// SNAME's name of the same quantity.
    pub sname: Option<String>,
    /// SNAME's value: the opposite sign; of an inertia the added part alone where the dry mass is known.
    pub sname_value: Option<f64>,
    /// Whether it was held.
    pub fixed: bool,
    /// Values of a parameter with one in each run, by the name of the run.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub per_run: BTreeMap<String, f64>,
}

/// One fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitStage {
    /// What was done.
    pub name: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// Names of the runs that took part.
    pub runs: Vec<String>,
    /// Number of rows or samples.
    pub rows: usize,
    /// Standard deviation of the residual, in the unit of what was fitted.
    pub residual_std: f64,
    /// cond(HᵀH), as the paper prints.
    pub condition_number: f64,
    /// cond(H) with columns of unit length.
    pub condition_number_scaled: f64,
    /// What this stage of the staged procedure has estimated; empty for other estimators, whose one fit the
    /// `parameters` show.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub estimates: Vec<Estimate>,
    /// Flow numbers of a single oscillatory run: Re, KC, λ, C_m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub numbers: Option<FlowNumbers>,
}

impl From<Stage> for FitStage {
    fn from(stage: Stage) -> FitStage {
        FitStage {
            name: stage.name,
            dof: stage.dof,
            runs: stage.runs,
            rows: stage.rows,
            residual_std: stage.residual_std,
            condition_number: stage.condition_number,
            condition_number_scaled: stage.condition_number_scaled,
            estimates: stage.estimates,
            numbers: stage.numbers,
        }
    }
}

/// What an estimator hands over before it is put into one form.
pub(super) struct Raw {
    pub model: Model,
    pub std_method: String,
    pub covariance: Vec<Vec<f64>>,
    pub std_paper: Vec<Option<f64>>,
    pub stages: Vec<FitStage>,
    pub efficiency: Efficiency,
    pub identifiability: Option<Identifiability>,
    pub warnings: Vec<Finding>,
}

/// Fits the free parameters of the campaign's model to its training runs.
///
/// # Errors
/// [`Error`] when there is no run to fit or the data does not determine the parameters.
pub fn fit(campaign: &Campaign, options: FitOptions) -> Result<Fit, Error> {
    let estimator = options.estimator.or(campaign.options.estimator).unwrap_or_else(|| suitable(campaign));
    let used = |run: &&Run| run.role == Role::Train && (moves(run.kind) || estimator == Estimator::Staged);
    let runs: Vec<Run> = campaign.runs.iter().filter(used).cloned().collect();
    if runs.is_empty() {
        let text = match campaign.runs.iter().any(|run| run.role == Role::Train) {
            false => "no run takes part in the fit: at least one needs role = \"train\"".to_string(),
            true => {
                format!("`{}` works on runs of free motion, and no such run has role = \"train\"", estimator.name())
            }
        };
        return Err(Error::Refused { findings: vec![Finding::new(&codes::NO_TRAINING, text)] });
    }
    let mut raw = match estimator {
        Estimator::OutputError => by_output_error(campaign, &runs)?,
        Estimator::Staged => by_stages(campaign)?,
        Estimator::Integral => by_integral(campaign, &runs)?,
    };
    let left_out: Vec<&str> = campaign
        .runs
        .iter()
        .filter(|run| run.role == Role::Train && !runs.iter().any(|used| used.name == run.name))
        .map(|run| run.name.as_str())
        .collect();
    if !left_out.is_empty() {
        let text =
            format!("{}: left out, `{}` cannot use bollard and towing runs", left_out.join(", "), estimator.name());
        raw.warnings.push(Finding::new(&codes::LEFT_OUT, text));
    }
    place_runs(&mut raw.model, campaign, &runs);
    let envelope = envelope::of(runs.iter().filter(|run| moves(run.kind)));
    Ok(assembled(raw, campaign, estimator, envelope, instruments(campaign, &runs)))
}

/// The result in its one form, with what there is to say about it.
pub(super) fn assembled(
    mut raw: Raw,
    campaign: &Campaign,
    estimator: Estimator,
    envelope: Envelope,
    instruments: Instruments,
) -> Fit {
    judge(&raw.model, &campaign.vehicle, &mut raw.warnings);
    let mut warnings = campaign.findings.clone();
    warnings.extend(raw.warnings);
    let parameters = raw
        .model
        .parameters
        .iter()
        .zip(&raw.std_paper)
        .map(|(p, paper)| described(p, *paper, &campaign.vehicle, &campaign.runs))
        .collect();
    Fit {
        format: 1,
        parameters,
        estimator,
        std_method: raw.std_method,
        covariance: raw.covariance,
        stages: raw.stages,
        identifiability: raw.identifiability,
        filters: Vec::new(),
        warnings,
        model: raw.model,
        efficiency: raw.efficiency,
        envelope,
        instruments,
    }
}

/// Noise and rate of what the runs of free motion log and the model predicts.
fn instruments(campaign: &Campaign, runs: &[Run]) -> Instruments {
    let moving: Vec<Run> = runs.iter().filter(|run| moves(run.kind)).cloned().collect();
    let Ok(problem) = Problem::new(&campaign.model, &moving, &campaign.options.output_error) else {
        return Instruments::new();
    };
    let rate = |channel: &str| {
        let signals = moving.iter().filter_map(|run| run.signal(channel)).filter(|s| s.len() > 1);
        let rates = signals.map(|s| (s.len() - 1) as f64 / (s.time()[s.len() - 1] - s.time()[0]));
        rates.fold(None, |most: Option<f64>, r| Some(most.map_or(r, |m| m.max(r))))
    };
    let outputs = problem.dynamics.outputs.iter().zip(&problem.sigma);
    outputs.filter_map(|(name, noise)| Some((name.clone(), Instrument { noise: *noise, rate: rate(name)? }))).collect()
}

/// The staged and the all-at-once fit with filters of several windows and degrees, and without.
///
/// # Errors
/// As the staged procedure.
pub fn filters(campaign: &Campaign) -> Result<Vec<Setting>, Error> {
    let nominal = campaign.nominal_runs();
    Ok(filter_table(&nominal, &campaign.model, campaign.bench(), &campaign.file.stage, &usual_filters())?)
}

/// Load cells can be read by the staged procedure alone; everything else is best fitted by output error.
fn suitable(campaign: &Campaign) -> Estimator {
    let training = || campaign.runs.iter().filter(|run| run.role == Role::Train);
    let cells = training().any(|run| matches!(run.kind, RunKind::Bollard | RunKind::Towing));
    if cells { Estimator::Staged } else { Estimator::OutputError }
}

fn by_output_error(campaign: &Campaign, runs: &[Run]) -> Result<Raw, Error> {
    let options = OutputErrorOptions { join: campaign.file.fit.join, ..campaign.options.output_error.clone() };
    let fitted = output_error(&started(&campaign.model, runs), runs, &options)?;
    let mut warnings = Vec::new();
    if !fitted.converged {
        let text = format!("output error stopped after {} steps without having converged", fitted.iterations);
        warnings.push(Finding::new(&codes::NOT_CONVERGED, text));
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
        crate::estimate::output_error::StdMethod::Information => "information",
        crate::estimate::output_error::StdMethod::Clusters => "clusters",
    };
    let stages = output_error_stages(&fitted, runs);
    let identifiability = identifiability::of_fit(campaign, &fitted, runs, &mut warnings);
    Ok(Raw {
        model: fitted.model,
        std_method: std_method.into(),
        covariance,
        std_paper,
        stages,
        efficiency: campaign.file.efficiency.clone(),
        identifiability,
        warnings,
    })
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
            numbers: None,
        })
        .collect()
}

/// Standard deviations by (14), of the one-sample trapezoid; `None` where there is no such regressor.
fn paper(model: &Model, runs: &[Run]) -> Vec<Option<f64>> {
    let mut std = vec![None; model.parameters.len()];
    let all: Vec<&Run> = runs.iter().collect();
    let options = IntegralOptions { regressor: RegressorOptions::default(), std: StdMethod::Paper };
    if let Ok((_, fits)) = integral_least_squares(&all, model, options) {
        for fit in &fits {
            for (column, value) in fit.parameters.iter().zip(&fit.std_paper) {
                std[column.parameter] = Some(*value);
            }
        }
    }
    std
}

fn by_integral(campaign: &Campaign, runs: &[Run]) -> Result<Raw, Error> {
    let all: Vec<&Run> = runs.iter().collect();
    let stage = &campaign.file.stage.oscillatory;
    let regressor = RegressorOptions { span: Span::Samples(stage.window), ..RegressorOptions::default() };
    let (model, fits) =
        integral_least_squares(&all, &campaign.model, IntegralOptions { regressor, ..IntegralOptions::default() })?;
    let names: Vec<String> = runs.iter().map(|run| run.name.clone()).collect();
    Ok(of_rows(model, &fits, &names, campaign))
}

/// Fits of rows put together.
pub(super) fn of_rows(model: Model, fits: &[RowFit], runs: &[String], campaign: &Campaign) -> Raw {
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
            numbers: None,
        }));
    }
    let efficiency = campaign.file.efficiency.clone();
    let std_method = "hac".into();
    let (identifiability, warnings) = (None, Vec::new());
    Raw { model, std_method, covariance, std_paper, stages, efficiency, identifiability, warnings }
}

fn by_stages(campaign: &Campaign) -> Result<Raw, Error> {
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
    let stages = result.stages.into_iter().map(FitStage::from).collect();
    let rows = match campaign.file.stage.std {
        StdMethod::Paper => "paper",
        StdMethod::Hac => "hac",
    };
    Ok(Raw {
        model: result.model,
        std_method: format!("{rows}, with what earlier stages leave uncertain by the delta method"),
        covariance: result.covariance,
        std_paper,
        stages,
        efficiency: result.efficiency,
        identifiability: None,
        warnings,
    })
}

/// Values per run by the index of the run in the campaign: a run that took no part has the mean of those that did.
fn place_runs(model: &mut Model, campaign: &Campaign, used: &[Run]) {
    for p in model.parameters.iter_mut().filter(|p| !p.per_run.is_empty()) {
        let mean = p.per_run.iter().sum::<f64>() / p.per_run.len() as f64;
        let of = |run: &Run| used.iter().position(|u| u.name == run.name).and_then(|k| p.per_run.get(k).copied());
        p.per_run = campaign.runs.iter().map(|run| of(run).unwrap_or(mean)).collect();
        p.value = mean;
    }
}

/// Says what cannot be, stands at a bound, or is hardly seen.
fn judge(model: &Model, vehicle: &Vehicle, warnings: &mut Vec<Finding>) {
    for p in model.parameters.iter().filter(|p| !p.fixed) {
        let std = p.std.unwrap_or(0.0);
        let shown = format!("{} of `{}` = {:.4} ± {:.2} {}", p.spec.name, p.term, p.value, std, p.spec.dimension);
        let least = match (p.effect.as_str(), p.place.dof) {
            ("inertia", Some(dof)) if !dof.is_rotation() => vehicle.mass.map(|mass| (mass, "the dry mass")),
            ("inertia" | "linear_drag" | "quadratic_drag" | "cubic_drag", _) => Some((0.0, "0")),
            _ => None,
        };
        if let Some((least, words)) = least.filter(|(least, _)| p.value < least - 2.0 * std) {
            let text = format!(
                "{shown} lies below {words} ({least}): a sign, a frame or the scale of thrust is wrong, or this data does not show it"
            );
            warnings.push(Finding::new(&codes::UNPHYSICAL, text));
        }
        if p.value <= p.min || p.value >= p.max {
            warnings.push(Finding::new(&codes::AT_BOUND, format!("{shown} stands at its bound")));
        } else if std > p.value.abs() && !p.spec.name.starts_with("b_") {
            warnings.push(Finding::new(&codes::LOOSE, format!("{shown}: this data hardly shows it")));
        }
    }
}

/// Degree of freedom of an effect of the whole vehicle that stands in one balance: `coriolis_yaw` is of yaw.
pub(super) fn row_of(effect: &str, place: Place) -> Option<Dof> {
    place.dof.or_else(|| Dof::ALL.into_iter().find(|dof| effect.ends_with(&format!("_{dof}"))))
}

/// One parameter as it is told: its place, SNAME's name and value; `paper` is its standard deviation by (14), `runs` are
/// those of its values per run.
pub fn described(p: &Parameter, paper: Option<f64>, vehicle: &Vehicle, runs: &[Run]) -> FitParameter {
    let dry = match p.place.dof {
        Some(dof) if p.effect == "inertia" && !dof.is_rotation() => vehicle.mass,
        _ => Some(0.0),
    };
    // SNAME's N_ṙ is the added part of an inertia alone, which nobody knows without the dry one
    let sname = p.spec.sname.clone().filter(|_| p.effect != "inertia" || dry.is_some_and(|d| d > 0.0));
    FitParameter {
        effect: p.effect.clone(),
        dof: row_of(&p.effect, p.place),
        other: p.place.other,
        name: p.spec.name.clone(),
        value: p.value,
        std: if p.fixed { Some(0.0) } else { p.std },
        std_paper: if p.fixed { Some(0.0) } else { paper },
        unit: p.spec.dimension.to_string(),
        sname_value: sname.as_ref().and(dry).map(|dry| dry - p.value),
        sname,
        fixed: p.fixed,
        per_run: runs.iter().zip(&p.per_run).map(|(run, value)| (run.name.clone(), *value)).collect(),
    }
}
