//! The answer: what is missing, how sure, what it changes on runs that took no part, and what to do next.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::held_out::held_out;
use super::left_over::{LEFT_OVER, left_over};
use super::next;
use super::residual::{Residual, residuals};
use super::search::{Search, SearchOptions, Step, search};
use super::stand_in::{STANDS_IN, stand_in};
use super::whereabouts::{Where, whereabouts};
use super::{Candidate, Gap, candidates, floor, left_open, unstable};
use crate::effects::{Effect, Place};
use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions};
use crate::finding::{Code, Finding, Severity};
use crate::frame::{Dof, Measured};
use crate::model::{Model, name_of};
use crate::progress;
use crate::run::{Role, Run};
use crate::units::Dimension;

/// The four answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The baseline predicts the data down to the noise.
    NothingMissing,
    /// With what was added the model predicts the data down to the noise.
    Explained,
    /// Something was found, and something is left that no effect of the catalogue explains.
    PartlyExplained,
    /// Something is missing that no effect of the catalogue explains.
    Unexplained,
}

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
    /// Root mean square of simulated less measured velocity, by degree of freedom, and of observed channels.
    pub held_out_rms: BTreeMap<Measured, f64>,
    /// Sensor noise of the same.
    pub noise_floor: BTreeMap<Measured, f64>,
    /// The same for each run.
    pub runs: Vec<GapOfRun>,
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
    /// What was added, in order.
    pub effects: Vec<FoundEffect>,
    /// Where the baseline disagrees with the data.
    #[serde(rename = "where")]
    pub places: Vec<Where>,
    /// The force that the baseline lacks, by degree of freedom.
    pub residuals: Vec<Residual>,
    /// The gap before and after each step.
    pub gap: Vec<GapStep>,
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
pub const CODES: &[Code] = &[HELD_OUT_IN_TURN, UNSTABLE, TIED, STANDS_IN, LEFT_OVER];

const HELD_OUT_IN_TURN: Code = Code {
    code: "D101",
    kind: "held-out",
    severity: Severity::Warning,
    meaning: "No run has the role `validate`: whole runs, or the last third of a single one, were held out in turn and \
              the models refitted without them.",
};
const UNSTABLE: Code = Code {
    code: "D102",
    kind: "unstable",
    severity: Severity::Warning,
    meaning: "The motion is unstable under the commands of this run: what its first seconds leave open of the initial \
              state, and the runs of the fit of the parameters, grows beyond the noise, so that it was compared in \
              segments of some seconds.",
};
const TIED: Code = Code {
    code: "D103",
    kind: "also-possible",
    severity: Severity::Warning,
    meaning: "Other effects explain this data as well as the one that was named: see `also_possible`, and run the \
              experiment that would tell them apart.",
};

/// A held-out disagreement counts as closed up to this multiple of the noise floor.
const CLOSED: f64 = 1.15;

/// Finds what `baseline` lacks on `runs`. Runs with the role `validate` take no part in the search; where there are
/// none, runs are held out in turn for the gap.
///
/// # Errors
/// [`OutputErrorError`] when the baseline cannot be fitted or a run lacks what it reads.
pub fn discover(
    baseline: &Model,
    runs: &[Run],
    own: &[(Arc<dyn Effect>, Place)],
    fitting: &OutputErrorOptions,
    options: &SearchOptions,
) -> Result<Discovery, OutputErrorError> {
    let (train, held): (Vec<Run>, Vec<Run>) = runs.iter().cloned().partition(|r| r.role == Role::Train);
    let found = search(&crate::estimate::started(baseline, &train), &train, own, fitting, options)?;
    let last = found.last_fit();
    let mut warnings = Vec::new();
    let judges = if held.is_empty() { train.clone() } else { held.clone() };
    let fitting = &OutputErrorOptions { segment: found.segment, longest_step: found.longest_step, ..fitting.clone() };
    // a last model that runs away on runs it has not seen leaves the baseline to tell the noise
    let mut noise =
        floor(&last.model, &judges, fitting).or_else(|_| floor(&found.steps[0].fit.model, &judges, fitting))?;
    for (measured, floor) in &mut noise {
        // what is known of a sensor is not beaten by how well short segments fit it
        let known = fitting.sigma.as_ref().and_then(|sigma| sigma.get(measured.channel()));
        *floor = known.map_or(*floor, |known| floor.max(*known));
    }
    let left_open = match left_open(last, &judges, fitting) {
        // what runs away is open everywhere: nothing is allowed for
        Err(OutputErrorError::Diverges { .. }) => vec![BTreeMap::new(); judges.len()],
        left_open => left_open?,
    };
    let cut = unstable(&left_open);
    let mut steps = Vec::new();
    for (k, step) in found.steps.iter().enumerate() {
        progress::tell("the gap on held-out runs", k, found.steps.len());
        let gap = held_out(&step.fit.model, &train, &held, fitting, &cut)?;
        steps.push(gap_step(step.name.clone(), dropped(&found, k), gap, &noise));
    }
    if held.is_empty() {
        warnings.push(Finding::new(&HELD_OUT_IN_TURN, HELD_OUT_IN_TURN.meaning));
    }
    let open: Vec<Measured> = steps.last().map_or_else(Vec::new, |last| {
        let above =
            |(dof, rms): (&Measured, &f64)| (*rms > closed(dof, &left_open, &cut) * noise[dof]).then(|| dof.clone());
        last.held_out_rms.iter().filter_map(above).collect()
    });
    let runs_away: Vec<&str> =
        judges.iter().zip(&cut).filter(|(_, cut)| **cut).map(|(run, _)| run.name.as_str()).collect();
    if !runs_away.is_empty() {
        warnings.push(Finding::new(&UNSTABLE, format!("{}: {}", runs_away.join(", "), UNSTABLE.meaning)));
    }
    let effects = found_effects(&found);
    if effects.iter().any(|e| !e.also_possible.is_empty()) {
        warnings.push(Finding::new(&TIED, TIED.meaning));
    }
    let stands_in = stand_in(&effects);
    if let Some(reason) = &stands_in {
        warnings.push(Finding::new(&STANDS_IN, reason.clone()));
    }
    let asked = !effects.is_empty() && open.is_empty();
    let over = if asked { left_over(last, &train, fitting) } else { Ok(Vec::new()) };
    let said = match &over {
        Ok(over) if over.is_empty() => None,
        Ok(over) => {
            let size =
                |(measured, left): &(Measured, f64)| format!("{} {:.0} %", measured.channel(), 100.0 * (left - 1.0));
            let sizes = over.iter().map(size).collect::<Vec<_>>().join(", ");
            Some(format!("{sizes} more than the variance of the noise: {}", LEFT_OVER.meaning))
        }
        Err(reason) => Some(format!("{reason}: {}", LEFT_OVER.meaning)),
    };
    let all_told = said.is_none();
    warnings.extend(said.map(|message| Finding::new(&LEFT_OVER, message)));
    let verdict = match (effects.is_empty(), open.is_empty()) {
        (true, true) => Verdict::NothingMissing,
        (true, false) => Verdict::Unexplained,
        (false, true) if stands_in.is_none() && all_told => Verdict::Explained,
        (false, _) => Verdict::PartlyExplained,
    };
    let residuals = residuals(&found.steps[0].fit, &train);
    let seen = |name: &String| found.last.iter().any(|(known, _)| known == name);
    let all = candidates(&last.model, &train, own);
    let unseen: Vec<String> = all.iter().map(Candidate::name).filter(|name| !seen(name)).collect();
    Ok(Discovery {
        format: 1,
        verdict,
        next_experiment: next::experiment(verdict, &effects, &open, &residuals, &unseen),
        residuals,
        places: whereabouts(&found.steps[0].fit, &train),
        effects,
        gap: steps,
        removed: found.removed.clone(),
        log_findings: Vec::new(),
        smallest_visible: smallest_visible(&found, &all),
        seed: 1,
        warnings,
        steps: found.steps,
    })
}

/// Up to which multiple of the noise floor a disagreement counts as closed: what the data leave open of the runs that are
/// simulated whole comes to the noise.
fn closed(dof: &Measured, left_open: &[BTreeMap<Measured, f64>], cut: &[bool]) -> f64 {
    let of_run = |(open, cut): (&BTreeMap<Measured, f64>, &bool)| match cut {
        true => 0.0,
        // of what is open without bound nothing is allowed for
        false => open.get(dof).filter(|size| size.is_finite()).map_or(0.0, |size| size * size),
    };
    let mean = left_open.iter().zip(cut).map(of_run).sum::<f64>() / left_open.len().max(1) as f64;
    (CLOSED * CLOSED + mean).sqrt()
}

/// Whether what came in step `k` is not in the final model, or came again later.
fn dropped(found: &Search, k: usize) -> bool {
    let name = found.steps[k].name.as_ref();
    name.is_some_and(|name| {
        let again = found.steps[k + 1..].iter().any(|later| later.name.as_ref() == Some(name));
        again || found.added.iter().all(|added| added.candidate.name() != *name)
    })
}

fn gap_step(added: Option<String>, dropped: bool, gap: Gap, noise: &BTreeMap<Measured, f64>) -> GapStep {
    let runs = gap.runs.into_iter().map(|(run, held_out_rms)| GapOfRun { run, held_out_rms }).collect();
    GapStep { added, dropped, held_out_rms: gap.rms, noise_floor: noise.clone(), runs }
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
            let gains = &added.evidence.left_out_gain;
            let helped = gains.iter().filter(|g| **g > 0.0).count();
            let held_out = match gains.len() {
                0 => String::new(),
                n => format!("; estimated without a run it predicts that run better in {helped} of {n}"),
            };
            FoundEffect {
                id: added.candidate.name(),
                dofs: added.candidate.dofs(model),
                parameters,
                p_value: added.evidence.p_value,
                also_possible: added.also_possible.clone(),
                evidence: format!(
                    "beside a refit of the model {:.0} % of its signal is its own, and it takes {:.3} of the sum of squares \
                     of the residuals away{held_out}",
                    100.0 * added.evidence.left.min(1.0),
                    added.gain / (added.gain + found.last_fit().cost).max(f64::MIN_POSITIVE),
                ),
            }
        })
        .collect()
}

/// Of each candidate the smallest size that any of its probes would have shown, most easily seen first by name.
fn smallest_visible(found: &Search, all: &[Candidate]) -> Vec<SmallestVisible> {
    let mut best: BTreeMap<String, (f64, String)> = BTreeMap::new();
    for (name, evidence) in &found.last {
        let Some(candidate) = all.iter().find(|c| c.name() == *name) else { continue };
        let (effect, place) = &candidate.terms[0];
        let specs = effect.parameters(*place);
        let Some(spec) = specs.iter().find(|s| s.is_linear()).or(specs.first()) else { continue };
        let probe = candidate.probes.get(evidence.probe).and_then(|probe| probe.first().copied());
        // of a limit the greatest one that shows is the smallest effect
        let limit = effect.about().id == "thrust_saturation";
        let value = match probe.filter(|_| candidate.blended) {
            Some(at) if limit && evidence.visible <= 1.0 => at,
            Some(_) if limit => continue,
            // τ + α (effect(τ) − τ) is, for a small α, the effect at α times the probe
            Some(at) => evidence.visible * at,
            None => evidence.visible,
        };
        let smaller = |known: f64| if limit { value > known } else { value < known };
        if value.is_finite() && best.get(name).is_none_or(|(known, _)| smaller(*known)) {
            best.insert(name.clone(), (value, spec.dimension.to_string()));
        }
    }
    let single = best.into_iter().map(|(id, (value, unit))| SmallestVisible { id, value, unit, tied: false });
    let mut all: Vec<SmallestVisible> = single.collect();
    for (name, evidence) in found.rows.iter().filter(|(_, e)| e.visible.is_finite()) {
        let row =
            SmallestVisible { id: name.clone(), value: evidence.visible, unit: Dimension::ONE.to_string(), tied: true };
        // behind the leading product of the same row
        let at = all.iter().rposition(|s| s.id == *name).map_or(all.len(), |k| k + 1);
        all.insert(at, row);
    }
    all
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
