//! The verb `fit`: parameters from the training runs, with what is needed to judge them.

mod bollard;
pub(in crate::campaign) mod filter_error;
mod judge;
mod output_error;
mod residuals;
mod result;
mod rows;
pub(super) mod thrust;

pub use self::residuals::Residuals;
pub(super) use self::result::row_of;
pub use self::result::{Fit, FitParameter, FitStage, described};
pub(super) use self::rows::{again, integral_again, of_rows};
pub(in crate::campaign) use judge::{dry_mass, is_below};

use super::codes;
use super::error::Error;
use super::file::Estimator;
use super::identifiability::Identifiability;
use super::load::{Campaign, moves};
use super::log_faults;
use super::noise::Noise;
use super::reversed_thruster::Reversed;
use super::thrusters::FittedCurve;
use super::unexcited;
use crate::envelope::{self, Envelope};
use crate::estimate::output_error::Problem;
use crate::finding::{Finding, Severity};
use crate::frame::Dof;
use crate::log::number::short;
use crate::model::{Model, Parameter};
use crate::navigation::upright;
use crate::plan::{Instrument, Instruments};
use crate::procedure::sensitivity::{Setting, filter_table, usual_filters};
use crate::procedure::without_steady_runs;
use crate::progress::tell;
use crate::run::{Role, Run, RunKind};
use crate::thrust::efficiency::Efficiency;
use crate::wording::listed;

/// Options of the fit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FitOptions {
    /// The estimator; if absent, that of the campaign, otherwise the one that suits its runs.
    pub estimator: Option<Estimator>,
}

impl FitOptions {
    /// Returns the estimator by which `campaign` is fitted and refitted.
    pub fn estimator_for(self, campaign: &Campaign) -> Estimator {
        self.estimator.or(campaign.options.estimator).unwrap_or_else(|| suitable(campaign))
    }
}

/// Result of an estimator, before it is brought into the common form.
pub(super) struct Raw {
    pub model: Model,
    /// The model with its values in the held-out runs of free motion.
    pub elsewhere: Option<Model>,
    pub std_method: String,
    pub covariance: Vec<Vec<f64>>,
    pub std_paper: Vec<Option<f64>>,
    pub stages: Vec<FitStage>,
    pub residuals: Vec<Residuals>,
    pub efficiency: Efficiency,
    pub identifiability: Option<Identifiability>,
    pub noise: Option<Noise>,
    pub converged: bool,
    pub sentence: Option<String>,
    pub warnings: Vec<Finding>,
    /// Codes of findings of the campaign that the fit refutes.
    pub refuted: Vec<&'static str>,
}

/// Fits the free parameters of the campaign's model to its training runs.
///
/// # Errors
/// [`Error`] if there is no run to fit or the data does not determine the parameters.
pub fn fit(campaign: &Campaign, options: FitOptions) -> Result<Fit, Error> {
    let estimator = options.estimator_for(campaign);
    if estimator == Estimator::Staged {
        return fitted(campaign, estimator, None);
    }
    match bollard::losses(campaign) {
        Some((under, told)) => fitted(&under, estimator, Some(told)),
        None => fitted(campaign, estimator, None),
    }
}

/// Fits by `estimator`; `losses` states the losses of thrust that bollard runs have shown.
fn fitted(campaign: &Campaign, estimator: Estimator, losses: Option<Finding>) -> Result<Fit, Error> {
    campaign.refuse_bench_alone()?;
    let runs: Vec<Run> = match estimator {
        Estimator::Staged => campaign.runs.iter().filter(|run| run.role == Role::Train).cloned().collect(),
        _ => campaign.motion(Some(Role::Train)),
    };
    if runs.is_empty() {
        let text = match campaign.runs.iter().any(|run| run.role == Role::Train) {
            false => "no run takes part in the fit: at least one needs role = \"train\"".to_string(),
            true => {
                format!("`{}` uses runs of free motion, and no such run has role = \"train\"", estimator.name())
            }
        };
        return Err(Error::Refused { findings: vec![Finding::new(&codes::NO_TRAINING, text)] });
    }
    if estimator != Estimator::Staged {
        // a stage of the staged procedure estimates only what its own runs are about
        unexcited::refuse(campaign, &runs)?;
    }
    tell(format!("fitting by {}", estimator.name().replace('_', " ")), 0, 0);
    let fitted = match estimator {
        Estimator::FilterError => filter_error::by_filter_error(campaign, &runs),
        Estimator::OutputError => output_error::by_output_error(campaign, &runs),
        Estimator::Staged => rows::by_stages(campaign),
        Estimator::Integral => rows::by_integral(campaign, &runs),
    };
    let at_rest = unexcited::at_rest(&runs);
    let mut raw = fitted.map_err(|error| match &at_rest {
        Some(finding) => Error::Refused { findings: vec![finding.clone()] },
        None => because_scale(campaign, because_contradicted(campaign, error)),
    })?;
    if is_untouched(&raw.model) {
        return Err(Error::Refused { findings: vec![Finding::new(&codes::NO_KIND, of_other_kinds(estimator, &runs))] });
    }
    let left_out: Vec<&str> = campaign
        .runs
        .iter()
        .filter(|run| run.role == Role::Train && !runs.iter().any(|used| used.name == run.name))
        .filter(|run| losses.is_none() || run.kind != RunKind::Bollard)
        .map(|run| run.name.as_str())
        .collect();
    if !left_out.is_empty() {
        let text =
            format!("{}: left out, `{}` cannot use bollard and towing runs", left_out.join(", "), estimator.name());
        raw.warnings.push(Finding::new(&codes::LEFT_OUT, text));
    }
    raw.warnings.extend(losses);
    contradicted(campaign, &mut raw);
    if let Some(finding) = at_rest {
        raw.sentence = Some(format!("Do not use these numbers: {}.", finding.message));
        raw.warnings.push(finding);
    }
    place_runs(&mut raw.model, campaign, &runs, raw.elsewhere.as_ref());
    let envelope = envelope::of(runs.iter().filter(|run| moves(run.kind)));
    Ok(assembled(raw, campaign, estimator, envelope, instruments(campaign, &runs)))
}

/// Describes how the sensors of the log contradict each other, or how the thrusters are misplaced.
fn contradiction(campaign: &Campaign) -> Option<String> {
    let runs = campaign.motion(None);
    let faults = log_faults::faults(&runs, &campaign.model);
    let told: Vec<String> = faults.iter().map(ToString::to_string).chain(log_faults::misplaced(campaign)).collect();
    let log = (!told.is_empty()).then(|| format!("the log contradicts itself: {}", told.join("; ")));
    // thrusters are judged by sensors that agree with each other
    log.or_else(|| Some(format!("the wiring is wrong: {}", Reversed::shown(campaign, &runs)?)))
}

/// Adds the finding that the log contradicts itself, if it does.
fn contradicted(campaign: &Campaign, raw: &mut Raw) {
    let Some(text) = contradiction(campaign) else { return };
    raw.sentence = Some(format!("Do not use these numbers: {text}."));
    raw.warnings.push(Finding::new(&codes::CONTRADICTED, text));
}

/// Replaces the error of a fit, unless it is a usage error, by the contradiction in the log, if
/// there is one: that is the cause.
fn because_contradicted(campaign: &Campaign, error: Error) -> Error {
    if error.is_wrong_use() {
        return error;
    }
    match contradiction(campaign) {
        Some(text) => {
            let finding = Finding::new(&codes::CONTRADICTED, format!("{text} ({error})"));
            Error::Refused { findings: vec![Finding { severity: Severity::Error, ..finding }] }
        }
        None => error,
    }
}

/// Replaces the error of a fit, unless it is a usage error or a refusal, by the finding that no
/// force is known absolutely, if there is one: that is the cause, whatever the estimator says.
fn because_scale(campaign: &Campaign, error: Error) -> Error {
    let scale = campaign.findings.iter().find(|finding| finding.code == codes::NO_SCALE.code);
    match scale {
        Some(finding) if !matches!(error, Error::Refused { .. }) && !error.is_wrong_use() => {
            Error::Refused { findings: vec![Finding { severity: Severity::Error, ..finding.clone() }] }
        }
        _ => error,
    }
}

/// Brings the result into the common form, with all findings about it.
pub(super) fn assembled(
    mut raw: Raw,
    campaign: &Campaign,
    estimator: Estimator,
    envelope: Envelope,
    instruments: Instruments,
) -> Fit {
    judge::judge(&raw.model, &campaign.vehicle, raw.converged, &mut raw.warnings);
    let stands = |finding: &&Finding| !raw.refuted.contains(&finding.code);
    let mut warnings: Vec<Finding> = campaign.findings.iter().filter(stands).cloned().collect();
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
        residuals: raw.residuals,
        thrusters: campaign.curves.iter().map(|c| FittedCurve::of(c, &campaign.file.thrusters)).collect(),
        identifiability: raw.identifiability,
        sentence: sentence(estimator, &raw.model, raw.converged, raw.sentence),
        converged: raw.converged,
        noise: raw.noise,
        filters: Vec::new(),
        warnings,
        model: raw.model,
        efficiency: raw.efficiency,
        envelope,
        instruments,
    }
}

/// Returns the verdict on the fit: what its estimator says, after what distorts its numbers in any
/// case.
fn sentence(estimator: Estimator, model: &Model, converged: bool, of_estimator: Option<String>) -> String {
    let rest = of_estimator.unwrap_or_else(|| told(estimator, converged));
    // an effect at its neutral value is absent and distorts nothing
    let absent = |p: &Parameter| (p.value - p.spec.neutral).abs() <= 0.0;
    let cut_off =
        |p: &&Parameter| !p.fixed && !p.spec.is_linear() && !absent(p) && (p.value <= p.min || p.value >= p.max);
    let untold = untold_inertias(model);
    // a worse verdict has been given already, with more knowledge of the cause
    if converged && !untold.is_empty() && !rest.starts_with("Do not use") {
        let dofs: Vec<&str> = untold.iter().map(|p| p.place.dof.map_or("", Dof::name)).collect();
        return format!(
            "Do not use these numbers for {}: this data does not determine {}; add runs that move the vehicle there, \
             or leave it out of dofs in [model]. {rest}",
            listed(&dofs),
            with_deviations(&untold)
        );
    }
    match model.parameters.iter().find(cut_off).filter(|_| converged) {
        None => rest,
        Some(p) => format!(
            "Do not use these numbers yet: {} of `{}` stands at its bound ({} {}), which biases related parameters; \
             leave the effect out, or give min, max or a value in [[parameter]]. {rest}",
            p.spec.name,
            p.term,
            short(p.value, 4),
            p.spec.dimension
        ),
    }
}

/// Lists parameters with their deviations: `m_u (144 ± 49 kg) and I_r (13.8 ± 3.6 kg*m2)`.
fn with_deviations(parameters: &[&Parameter]) -> String {
    let one = |p: &&Parameter| {
        let (value, std) = (short(p.value, 3), short(p.std.unwrap_or(0.0), 2));
        format!("{} ({value} ± {std} {})", p.spec.name, p.spec.dimension)
    };
    listed(&parameters.iter().map(one).collect::<Vec<_>>())
}

/// Returns the free inertias whose 95 % interval is wider than ± half of their value: a simulation
/// or a controller divides by them.
fn untold_inertias(model: &Model) -> Vec<&Parameter> {
    let own = model.dofs.iter().filter_map(|dof| model.inertia(*dof)).map(|p| &model.parameters[p]);
    let wide = |p: &&Parameter| p.std.is_some_and(|std| 1.96 * std > 0.5 * p.value.abs());
    own.filter(|p| !p.fixed).filter(wide).collect()
}

/// Whether parameters are free and none was estimated.
fn is_untouched(model: &Model) -> bool {
    let mut free = model.parameters.iter().filter(|p| !p.fixed).peekable();
    free.peek().is_some() && free.all(|p| p.std.is_none())
}

/// Describes the kinds of the given runs, and those that the estimator would use.
fn of_other_kinds(estimator: Estimator, runs: &[Run]) -> String {
    let mut kinds: Vec<&str> = runs.iter().map(|run| run.kind.name()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let (there, name) = (listed(&kinds), estimator.name());
    let staged = "bollard runs for the loss of thrust, towing or constant_velocity runs for drag, oscillatory and zigzag runs \
                  for inertia and couplings";
    let uses = if estimator == Estimator::Staged { staged } else { "runs of free motion" };
    format!(
        "nothing was estimated: the runs of the fit are of kind {there}, and `{name}` uses {uses}; correct `kind` \
         where it is wrong, or choose another estimator (--estimator)"
    )
}

/// Returns the verdict on a fit whose estimator says nothing about its noise.
fn told(estimator: Estimator, converged: bool) -> String {
    let name = estimator.name().replace('_', " ");
    match converged {
        true => format!(
            "The fit with {name} is done; it does not model a random force and does not say whether the model is \
             complete: the default, filter error, does both."
        ),
        false => format!("Do not use these numbers: the fit with {name} did not converge."),
    }
}

/// Returns noise and rate of the channels that the runs of free motion log and the model predicts.
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
    outputs
        .filter_map(|(output, noise)| {
            let name = upright::instrument_of(output).unwrap_or(output);
            Some((name.to_string(), Instrument { noise: *noise, rate: rate(name)? }))
        })
        .collect()
}

/// Fits by the staged and the all-at-once procedure with filters of several windows and degrees,
/// and without a filter.
///
/// # Errors
/// As the staged procedure.
pub fn filters(campaign: &Campaign) -> Result<Vec<Setting>, Error> {
    let nominal = campaign.nominal_runs();
    Ok(filter_table(&nominal, &campaign.model, campaign.bench(), &campaign.file.stage, &usual_filters())?)
}

/// Returns the estimator that suits the runs. Only the staged procedure can read load cells, and it
/// needs the drag from runs at constant speed; everything else is best fitted by filter error.
fn suitable(campaign: &Campaign) -> Estimator {
    let training = || campaign.runs.iter().filter(|run| run.role == Role::Train);
    let cells = training().any(|run| matches!(run.kind, RunKind::Bollard | RunKind::Towing));
    let moving = training().any(|run| moves(run.kind));
    match cells && (!moving || without_steady_runs(&campaign.runs, &campaign.model).is_empty()) {
        true => Estimator::Staged,
        false => Estimator::FilterError,
    }
}

/// Orders values per run by the index of the run in the campaign: a run that took no part has those
/// of `elsewhere`, otherwise the mean of those that did.
fn place_runs(model: &mut Model, campaign: &Campaign, used: &[Run], elsewhere: Option<&Model>) {
    let others = campaign.motion(Some(Role::Validate));
    for (k, p) in model.parameters.iter_mut().enumerate().filter(|(_, p)| !p.per_run.is_empty()) {
        let mean = p.per_run.iter().sum::<f64>() / p.per_run.len() as f64;
        let own = elsewhere.map_or(&[][..], |model| &model.parameters[k].per_run);
        let named = |run: &Run, runs: &[Run], values: &[f64]| {
            runs.iter().position(|u| u.name == run.name).and_then(|k| values.get(k).copied())
        };
        let of = |run: &Run| named(run, used, &p.per_run).or_else(|| named(run, &others, own)).unwrap_or(mean);
        p.per_run = campaign.runs.iter().map(of).collect();
        p.value = mean;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    #[test]
    fn a_shape_at_its_bound_comes_first_and_one_that_is_absent_says_nothing() {
        let mut model =
            Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag", "thrust_lag"]).unwrap();
        let lag = model.parameter_of("thrust_lag").unwrap();
        let told = |model: &Model, converged| {
            sentence(Estimator::FilterError, model, converged, Some("The fit converged.".into()))
        };
        model.parameters[lag].value = 0.3;
        assert_eq!(told(&model, true), "The fit converged.");
        model.parameters[lag].value = model.parameters[lag].min;
        let cut_off = told(&model, true);
        assert!(
            cut_off.starts_with("Do not use these numbers yet: T_lag of `thrust_lag` stands at its bound"),
            "{cut_off}"
        );
        assert!(cut_off.ends_with("The fit converged."), "{cut_off}");
        assert_eq!(told(&model, false), "The fit converged.", "one that has not converged says that already");
        model.parameters[lag].spec.neutral = model.parameters[lag].min;
        assert_eq!(told(&model, true), "The fit converged.", "where it is absent it bends nothing");
    }

    #[test]
    fn an_estimator_that_no_run_suits_says_so() {
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia"]).unwrap();
        let told = |model: &Model| sentence(Estimator::Staged, model, true, None);
        assert!(is_untouched(&model));
        let refused = of_other_kinds(Estimator::Staged, &[]);
        assert!(refused.starts_with("nothing was estimated"), "{refused}");
        (model.parameters[0].value, model.parameters[0].std) = (10.0, Some(1.0));
        assert!(!is_untouched(&model));
        assert!(told(&model).starts_with("The fit with staged is done"), "{}", told(&model));
        model.parameters[0].std = Some(3.0);
        assert!(
            told(&model).starts_with("Do not use these numbers for surge: this data does not determine m_u"),
            "{}",
            told(&model)
        );
    }
}
