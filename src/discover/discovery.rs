//! The answer: what is missing, how sure, what it changes on runs that took no part, and what to do next.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::candidate::Candidate;
use super::held_out::on_others;
use super::next;
use super::residual::{Residual, residuals};
use super::search::{BehavesLike, Search, SearchOptions, Step, Task, search};
use super::verdict::{Verdict, digits, sentence, verdict};
use super::whereabouts::{Where, whereabouts};
use crate::effects::{Effect, Place, common_name};
use crate::estimate::filter_error::{
    Channel, FilterErrorFit, FilterErrorOptions, Filtered, Forecast, Prediction, RandomForce,
};
use crate::estimate::output_error::OutputErrorError;
use crate::finding::{Code, Finding, Severity};
use crate::frame::{Dof, Measured};
use crate::model::{Model, name_of};
use crate::noise::Noise;
use crate::progress;
use crate::run::{Role, Run};

/// A parameter of an effect that was added.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundParameter {
    /// Symbol.
    pub name: String,
    /// Value, SI.
    pub value: f64,
    /// Standard deviation, SI.
    pub std: f64,
    /// Unit.
    pub unit: String,
    /// Values in each run, where each has its own.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub per_run: Vec<f64>,
}

/// An effect that was added.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundEffect {
    /// `id`, `id@dof` or `id@dof:other`.
    pub id: String,
    /// What practitioners call it.
    pub common_name: String,
    /// Degrees of freedom in which it acts.
    pub dofs: Vec<Dof>,
    /// Its parameters in the final fit.
    pub parameters: Vec<FoundParameter>,
    /// Probability of as much by chance, over all candidates.
    pub p_value: f64,
    /// The rest of its class: other names that this data allow.
    pub also_possible: Vec<String>,
    /// One sentence.
    pub evidence: String,
}

/// The gap on held-out runs after one step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GapStep {
    /// What was added; `None` for the refitted baseline.
    pub added: Option<String>,
    /// Whether it was dropped again: what came later does without it.
    pub dropped: bool,
    /// Root mean square of simulated less measured velocity over the free run, by degree of freedom, and of observed
    /// channels.
    pub held_out_rms: BTreeMap<Measured, f64>,
    /// Sensor noise of the same.
    pub noise_floor: BTreeMap<Measured, f64>,
    /// The same for each run.
    pub runs: Vec<GapOfRun>,
    /// The random force at this step: a name that is true makes it fall.
    pub force: Vec<GapForce>,
    /// How held-out runs are predicted at this step.
    pub prediction: Vec<GapPrediction>,
}

/// The random force of one step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GapForce {
    /// Degree of freedom.
    pub dof: Dof,
    /// Standard deviation, N or N·m.
    pub rms: f64,
    /// `N` or `N*m`.
    pub unit: &'static str,
    /// Correlation time, s.
    pub correlation_time: f64,
}

/// How one channel of a held-out run is predicted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GapPrediction {
    /// Name of the run.
    pub run: String,
    /// Degree of freedom, or the channel of an observed function.
    pub dof: Measured,
    /// Seconds ahead: 0 for one sample, `null` for a free run.
    pub ahead: Option<f64>,
    /// Root-mean-square error, in the unit of the channel.
    pub rms: f64,
    /// The error that the filter expects.
    pub expected: f64,
}

/// The gap on one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GapOfRun {
    /// Name of the run.
    pub run: String,
    /// Root mean square by degree of freedom.
    pub held_out_rms: BTreeMap<Measured, f64>,
}

/// The smallest size of an effect that this data would have shown.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SmallestVisible {
    /// `id`, `id@dof` or `id@dof:other`.
    pub id: String,
    /// Size of its first parameter; of a whole row the share of it.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Whether this is the whole row of −C(ν)ν, its coefficients those of the inertias: it has no parameter, and `value` 1
    /// is all of it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub tied: bool,
}

impl SmallestVisible {
    /// Name, size and unit for people: a whole row is told as such, its size in per cent.
    pub fn told(&self) -> (String, f64, &str) {
        match self.tied {
            true => (format!("{}, whole row", self.id), 100.0 * self.value, "% of the row"),
            false => (self.id.clone(), self.value, &self.unit),
        }
    }
}

/// What a check of the log says that could look like missing physics.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogFinding {
    /// `unit`, `sign`, `frame` or `delay`.
    pub kind: String,
    /// Channel.
    pub channel: String,
    /// Factor between what is logged and what is consistent; of a frame −1 or the angle, rad; of a delay the time, s.
    pub factor: f64,
    /// What it is and what to do, in one sentence.
    pub message: String,
}

/// The answer of the discovery.
#[derive(Debug, Clone, Serialize)]
pub struct Discovery {
    /// Version of this form.
    pub format: u32,
    /// The answer in a word.
    pub verdict: Verdict,
    /// The answer in a sentence.
    pub sentence: String,
    /// What was added, in order.
    pub effects: Vec<FoundEffect>,
    /// Where the baseline disagrees with the data.
    #[serde(rename = "where")]
    pub places: Vec<Where>,
    /// The force that the baseline lacks, by degree of freedom.
    pub residuals: Vec<Residual>,
    /// The gap before and after each step.
    pub gap: Vec<GapStep>,
    /// What helped and broke a rule of physics or of held-out runs: no names.
    pub behaves_like: Vec<BehavesLike>,
    /// What was added and dropped again.
    pub removed: Vec<String>,
    /// What looks like a fault of the log.
    pub log_findings: Vec<LogFinding>,
    /// What this data could have shown.
    pub smallest_visible: Vec<SmallestVisible>,
    /// The run that would tell more.
    pub next_experiment: Option<String>,
    /// Seed of anything random.
    pub seed: u64,
    /// What there is to say.
    pub warnings: Vec<Finding>,
    /// The fits of baseline and steps, for whoever goes on working with them.
    #[serde(skip)]
    pub steps: Vec<Step>,
}

/// What stands for the value of an effect that has no parameter.
pub const TIED_ROW: &str = "whole row, tied to the inertias";

impl Discovery {
    /// The model with everything that was added.
    pub fn model(&self) -> Option<&Model> {
        self.steps.last().map(|step| &step.fit.model)
    }
}

/// Codes of the discovery's findings.
pub const CODES: &[Code] = &[HELD_OUT_IN_TURN, TIED, COMMANDS_HELD];

const HELD_OUT_IN_TURN: Code = Code {
    code: "D101",
    kind: "held-out",
    severity: Severity::Warning,
    meaning: "No run has the role `validate`: each run was predicted by an estimate without it, and the gap is that of \
              the runs of the fit.",
};
const TIED: Code = Code {
    code: "D103",
    kind: "also-possible",
    severity: Severity::Warning,
    meaning: "Other effects explain this data as well as the one that was named: see `also_possible`, and run the \
              experiment that would tell them apart.",
};
const COMMANDS_HELD: Code = Code {
    code: "D106",
    kind: "commands-held",
    severity: Severity::Warning,
    meaning: "A delay of half a sample of the commands is what a straight line between held commands looks like: set \
              `input = \"hold\"` in [model], and look again.",
};

/// Finds what `baseline` lacks on `runs`. Runs with the role `validate` take no part in the search and judge it; where
/// there are none, each run judges an estimate without it.
///
/// # Errors
/// [`OutputErrorError`] when the baseline cannot be fitted or a run lacks what it reads.
pub fn discover(
    baseline: &Model,
    runs: &[Run],
    own: &[(Arc<dyn Effect>, Place)],
    fitting: &FilterErrorOptions,
    options: &SearchOptions,
) -> Result<Discovery, OutputErrorError> {
    let (train, held): (Vec<Run>, Vec<Run>) = runs.iter().cloned().partition(|r| r.role == Role::Train);
    let task = Task { train: &train, held: &held, own, fitting, options };
    let found = search(&crate::estimate::started(baseline, &train), &task)?;
    let mut warnings = Vec::new();
    if held.is_empty() {
        warnings.push(Finding::new(&HELD_OUT_IN_TURN, HELD_OUT_IN_TURN.meaning));
    }
    let mut predicted = Vec::new();
    for (k, step) in found.steps.iter().enumerate() {
        progress::tell("the gap on held-out runs", k, found.steps.len());
        predicted.push(predictions(&step.fit, &held, fitting)?);
    }
    let floor = noise_floor(found.last_fit());
    let gap: Vec<GapStep> = found
        .steps
        .iter()
        .zip(&predicted)
        .enumerate()
        .map(|(k, (step, (outputs, forecasts)))| gap_step(&found, k, step, outputs, forecasts, &floor))
        .collect();
    let (outputs, last) = &predicted[predicted.len() - 1];
    let mut failing = super::verdict::failing(outputs, last);
    if !failing.is_empty() && !held.is_empty() {
        let allowed = with_parameters_open(found.last_fit(), last, &held, fitting, options.seed)?;
        failing = super::verdict::failing(outputs, &allowed);
    }
    let mut effects = found_effects(&found);
    if effects.iter().any(|e| !e.also_possible.is_empty()) {
        warnings.push(Finding::new(&TIED, TIED.meaning));
    }
    warnings.extend(half_a_sample(&effects, &train));
    let mut behaves_like = found.behaves_like.clone();
    if !failing.is_empty() {
        stand_ins(&found, &mut effects, &mut behaves_like);
    }
    let verdict = verdict(!effects.is_empty(), failing.is_empty());
    let residuals = residuals(&found.steps[0].fit, &train);
    let open: Vec<Measured> = found.steps[0]
        .fit
        .model
        .measured()
        .into_iter()
        .filter(|m| failing.iter().any(|(name, _)| name == m.channel()))
        .collect();
    let seen: Vec<String> = found.screen.scores.iter().map(|s| found.candidates[s.candidate].name()).collect();
    let unseen: Vec<String> =
        found.candidates.iter().map(Candidate::name).filter(|name| !seen.contains(name)).collect();
    let better = improvement(&gap);
    let places = if verdict == Verdict::NothingMissing {
        Vec::new()
    } else {
        let of = |fit: &FilterErrorFit| fit.filtered.forecast(&fit.model, &fit.noise, fit.limit);
        let (first, last) = (&found.steps[0].fit, found.last_fit());
        let outputs = &first.filtered.problem.dynamics.outputs;
        whereabouts(&first.model, outputs, (&of(first), &of(last)), &train)
    };
    Ok(Discovery {
        format: 1,
        verdict,
        sentence: sentence(verdict, &effects, &behaves_like, &found.last_fit().noise.forces, better, &failing),
        next_experiment: next::experiment(verdict, &effects, &open, &residuals, &unseen),
        residuals,
        places,
        effects,
        gap,
        behaves_like,
        removed: found.removed.clone(),
        log_findings: Vec::new(),
        smallest_visible: smallest_visible(&found),
        seed: options.seed,
        warnings,
        steps: found.steps,
    })
}

/// Names that help but leave a failing model are no physics: all but one that takes most of the fall of the likelihood
/// stand in for something else, and are told as what it behaves like.
fn stand_ins(found: &Search, effects: &mut Vec<FoundEffect>, behaves_like: &mut Vec<BehavesLike>) {
    let total: f64 = found.added.iter().map(|a| a.gain).sum();
    for added in &found.added {
        if added.gain < 0.5 * total {
            let id = added.candidate.name();
            effects.retain(|e| e.id != id);
            let why = "something else is left that the catalogue does not hold, for which it may stand in".to_string();
            behaves_like.push(BehavesLike { id, why, gain: added.gain });
        }
    }
    behaves_like.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    behaves_like.truncate(2);
}

/// Says that commands are held where the one name is a delay of half of their sample time.
fn half_a_sample(effects: &[FoundEffect], runs: &[Run]) -> Option<Finding> {
    let [only] = effects else { return None };
    let delay = only.parameters.first().filter(|_| only.id == "thrust_delay")?;
    let commands = || runs.iter().flat_map(|r| Dof::ALL.into_iter().filter_map(|d| r.signal(d.force())));
    let spans = commands().filter(|s| s.len() > 1).map(|s| (s.time()[s.len() - 1] - s.time()[0], s.len() - 1));
    let (seconds, steps) = spans.fold((0.0, 0), |(t, n), (span, count)| (t + span, n + count));
    let half = 0.5 * seconds / steps.max(1) as f64;
    let near = (delay.value - half).abs() < (2.0 * delay.std).max(0.1 * half);
    let text =
        format!("the delay of {} s is half a sample of the commands: {}", digits(delay.value), COMMANDS_HELD.meaning);
    near.then(|| Finding::new(&COMMANDS_HELD, text))
}

/// How a fit predicts the runs that took no part; those of the fit where there are none.
fn predictions(
    fit: &FilterErrorFit,
    held: &[Run],
    fitting: &FilterErrorOptions,
) -> Result<(Vec<String>, Vec<Forecast>), OutputErrorError> {
    let outputs = fit.filtered.problem.dynamics.outputs.clone();
    if held.is_empty() {
        return Ok((outputs, fit.filtered.forecast(&fit.model, &fit.noise, fit.limit)));
    }
    let model = on_others(fit, held, fitting)?;
    let filtered = Filtered::new(&model, held, &fitting.base)?;
    Ok((outputs, filtered.forecast(&model, &fit.noise, fit.limit)))
}

/// Draws of the parameters by which it is found how far their uncertainty spreads predictions.
const DRAWS: usize = 8;

/// `forecasts` of the held-out runs with what the uncertainty of the parameters adds to the expected errors: the mean of
/// their squares under parameters drawn from the estimate's distribution, less that under the estimate itself. Without a
/// random force it is all that makes an unstable vehicle's predictions err.
fn with_parameters_open(
    fit: &FilterErrorFit,
    forecasts: &[Forecast],
    held: &[Run],
    fitting: &FilterErrorOptions,
    seed: u64,
) -> Result<Vec<Forecast>, OutputErrorError> {
    let unknowns = &fit.filtered.problem.unknowns;
    let p = unknowns.len();
    let mut open = forecasts.to_vec();
    let Some(root) = DMatrix::from_row_slice(p, p, &fit.covariance).cholesky().map(|f| f.l()) else { return Ok(open) };
    let mut noise = Noise::new(seed, 0xd4a3);
    let estimated = on_others(fit, held, fitting)?;
    for _ in 0..DRAWS {
        let step = &root * DVector::from_fn(p, |_, _| noise.normal());
        let mut model = estimated.clone();
        for (unknown, by) in unknowns.iter().zip(step.iter()).filter(|(u, _)| u.run.is_none()) {
            let parameter = &mut model.parameters[unknown.parameter];
            parameter.value = (parameter.value + by).clamp(parameter.min, parameter.max);
        }
        let drawn = Filtered::new(&model, held, &fitting.base)?.forecast(&model, &fit.noise, fit.limit);
        for ((open, drawn), own) in open.iter_mut().zip(&drawn).zip(forecasts) {
            for ((open, drawn), own) in open.channels.iter_mut().zip(&drawn.channels).zip(&own.channels) {
                for ((open, drawn), own) in open.predictions.iter_mut().zip(&drawn.predictions).zip(&own.predictions) {
                    open.expected += (drawn.squares - own.squares) / DRAWS as f64;
                }
            }
        }
    }
    for (open, own) in open.iter_mut().zip(forecasts) {
        for (open, own) in open.channels.iter_mut().zip(&own.channels) {
            for (open, own) in open.predictions.iter_mut().zip(&own.predictions) {
                // a draw that runs away leaves all open
                open.expected = if open.expected.is_nan() { f64::INFINITY } else { open.expected.max(own.expected) };
            }
        }
    }
    Ok(open)
}

/// What a channel measures, of those that are compared.
fn measured(model: &Model, outputs: &[String], channel: &Channel) -> Option<Measured> {
    model.measured().into_iter().find(|m| m.channel() == outputs[channel.output])
}

/// Noise of the sensor of each velocity and observed function.
fn noise_floor(fit: &FilterErrorFit) -> BTreeMap<Measured, f64> {
    let outputs = &fit.filtered.problem.dynamics.outputs;
    let of = |m: Measured| {
        let sensor = fit.noise.sensors[outputs.iter().position(|o| o == m.channel())?];
        Some((m, sensor.std.hypot(sensor.coloured.map_or(0.0, |c| c.rms))))
    };
    fit.model.measured().into_iter().filter_map(of).collect()
}

fn gap_step(
    found: &Search,
    k: usize,
    step: &Step,
    outputs: &[String],
    forecasts: &[Forecast],
    floor: &BTreeMap<Measured, f64>,
) -> GapStep {
    let mut all: BTreeMap<Measured, Prediction> = BTreeMap::new();
    let (mut runs, mut prediction): (Vec<GapOfRun>, Vec<GapPrediction>) = (Vec::new(), Vec::new());
    for forecast in forecasts {
        let mut own = BTreeMap::new();
        for channel in &forecast.channels {
            let Some(dof) = measured(&step.fit.model, outputs, channel) else { continue };
            for p in channel.predictions.iter().filter(|p| p.count > 0) {
                let (run, dof) = (forecast.run.clone(), dof.clone());
                prediction.push(GapPrediction { run, dof, ahead: p.ahead, rms: p.rms(), expected: p.expected_rms() });
            }
            if let Some(free) = channel.predictions.iter().find(|p| p.ahead.is_none() && p.count > 0) {
                own.insert(dof.clone(), free.rms());
                all.entry(dof).and_modify(|sum| *sum = sum.with(free)).or_insert(*free);
            }
        }
        runs.push(GapOfRun { run: forecast.run.clone(), held_out_rms: own });
    }
    let force = |f: &RandomForce| GapForce {
        dof: f.dof,
        rms: f.rms,
        unit: if f.dof.is_rotation() { "N*m" } else { "N" },
        correlation_time: f.time,
    };
    GapStep {
        added: step.name.clone(),
        dropped: dropped(found, k),
        held_out_rms: all.into_iter().map(|(dof, p)| (dof, p.rms())).collect(),
        noise_floor: floor.clone(),
        runs,
        force: step.fit.noise.forces.iter().map(force).collect(),
        prediction,
    }
}

/// The degree of freedom whose held-out predictions 8 s ahead have become better by most, and how many times.
fn improvement(gap: &[GapStep]) -> Option<(Dof, f64)> {
    let (first, last) = (gap.first()?, gap.last()?);
    let of = |step: &GapStep, dof: Dof| {
        let own = step.prediction.iter().filter(|p| p.ahead == Some(8.0) && p.dof.dof() == Some(dof));
        own.map(|p| p.rms * p.rms).sum::<f64>().sqrt()
    };
    let times = |dof: Dof| (dof, of(first, dof) / of(last, dof));
    let all = Dof::ALL.into_iter().map(times).filter(|(_, t)| t.is_finite() && *t > 1.0);
    all.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Whether what came in step `k` is not in the final model, or came again later.
fn dropped(found: &Search, k: usize) -> bool {
    let name = found.steps[k].name.as_ref();
    name.is_some_and(|name| {
        let again = found.steps[k + 1..].iter().any(|later| later.name.as_ref() == Some(name));
        again || found.added.iter().all(|added| added.candidate.name() != *name)
    })
}

fn found_effects(found: &Search) -> Vec<FoundEffect> {
    let model = &found.last_fit().model;
    found
        .added
        .iter()
        .map(|added| {
            let terms: Vec<String> = added.candidate.terms.iter().map(|(e, p)| name_of(e.about().id, *p)).collect();
            let mut indices: Vec<usize> =
                terms.iter().filter_map(|t| model.term(t)).flat_map(|t| model.terms[t].parameters.clone()).collect();
            indices.sort_unstable();
            indices.dedup();
            let parameters = indices
                .into_iter()
                .map(|p| {
                    let parameter = &model.parameters[p];
                    FoundParameter {
                        name: parameter.spec.name.clone(),
                        value: parameter.value,
                        std: parameter.std.unwrap_or(0.0),
                        unit: parameter.spec.dimension.to_string(),
                        per_run: parameter.per_run.clone(),
                    }
                })
                .collect();
            let id = added.candidate.name();
            FoundEffect {
                common_name: common_name(&id).to_string(),
                id,
                dofs: added.candidate.dofs(model),
                parameters,
                p_value: added.p_value,
                also_possible: added.also_possible.clone(),
                evidence: format!(
                    "−2 ln L falls by {} on the runs of the fit and by {} on those that took no part; beside a refit of the \
                     model {:.0} % of its signal is its own",
                    digits(added.gain),
                    digits(added.held_out_gain),
                    100.0 * added.left.min(1.0),
                ),
            }
        })
        .collect()
}

/// Of each candidate the smallest size that this data would have shown, as a rule in half of the cases: its deviation
/// times the threshold of the search.
fn smallest_visible(found: &Search) -> Vec<SmallestVisible> {
    // z at which a candidate of one parameter is as improbable as the threshold asks
    let z = (-2.0 * found.screen.threshold).max(1.0).sqrt();
    let mut best: BTreeMap<(String, bool), (f64, String)> = BTreeMap::new();
    for score in &found.screen.scores {
        let candidate = &found.candidates[score.candidate];
        let (effect, place) = &candidate.terms[0];
        let specs = effect.parameters(*place);
        let tied = specs.is_empty();
        let unit = match specs.iter().find(|s| s.is_linear()).or(specs.first()) {
            Some(spec) => spec.dimension.to_string(),
            None => crate::units::Dimension::ONE.to_string(),
        };
        let Some(std) = score.std.first() else { continue };
        let probe = candidate.probes.get(score.probe).and_then(|probe| probe.first().copied());
        // τ + α (effect(τ) − τ) is, for a small α, the effect at α times the probe
        let value = probe.filter(|_| candidate.blended).map_or(z * std, |at| z * std * at);
        let key = (candidate.name(), tied);
        if value.is_finite() && best.get(&key).is_none_or(|(known, _)| value < *known) {
            best.insert(key, (value, unit));
        }
    }
    best.into_iter().map(|((id, tied), (value, unit))| SmallestVisible { id, value, unit, tied }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_row_is_told_in_per_cent_and_a_coefficient_in_its_unit() {
        let product = SmallestVisible { id: "coriolis_yaw".into(), value: 4.0, unit: "kg".into(), tied: false };
        assert_eq!(product.told(), ("coriolis_yaw".into(), 4.0, "kg"));
        let row = SmallestVisible { value: 0.02, unit: "1".into(), tied: true, ..product.clone() };
        assert_eq!(row.told(), ("coriolis_yaw, whole row".into(), 2.0, "% of the row"));
        assert!(serde_json::to_value(&product).unwrap().get("tied").is_none());
        assert_eq!(serde_json::to_value(&row).unwrap()["tied"], true);
    }
}
