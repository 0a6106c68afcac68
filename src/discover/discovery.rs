//! Result of the discovery: what is missing, how certain it is, its effect on held-out predictions, and what to do
//! next.

use serde::Serialize;

use super::appeared::appeared;
use super::between_rows::{BETWEEN_ROWS, COMMANDS_HELD, finding, told_before};
use super::candidate::Candidate;
use super::constancy::{ChangedParameter, changed, likelier};
use super::disagreement::{Where, disagreement};
use super::found::{FoundEffect, SmallestVisible, found_effects, names_to_list, smallest_visible};
use super::gap::{GapStep, improvement};
use super::judged::Judged;
use super::next;
use super::pushed::overwhelmed;
use super::residual::{Residual, residuals};
use super::search::search;
use super::searched::{BehavesLike, Search, Step};
use super::stepped::stepped;
use super::surrogate::{leave_out, surrogates};
use super::task::Task;
use super::verdict::{Verdict, alike, apart, moved_otherwise, sentence, verdict};
use crate::estimate::output_error::OutputErrorError;
use crate::finding::{Code, Finding, Severity};
use crate::frame::{Dof, Measured};
use crate::model::{Interpolation, Model};
use crate::progress;

/// Finding of a check of the log that could look like missing physics.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogFinding {
    /// `unit`, `sign`, `frame` or `delay`.
    pub kind: String,
    /// Channel.
    pub channel: String,
    /// Ratio of the logged to the consistent value; for a frame −1 or the angle, rad; for a delay the time, s.
    pub factor: f64,
    /// Description and remedy, in one sentence.
    pub message: String,
}

/// Result of the discovery.
#[derive(Debug, Clone, Serialize)]
pub struct Discovery {
    /// Version of this format.
    pub format: u32,
    /// Verdict in a word.
    pub verdict: Verdict,
    /// Verdict in a sentence.
    pub sentence: String,
    /// Effects that were added, in order.
    pub effects: Vec<FoundEffect>,
    /// Where the baseline disagrees with the data.
    #[serde(rename = "where")]
    pub places: Vec<Where>,
    /// The force that the baseline lacks, by degree of freedom.
    pub residuals: Vec<Residual>,
    /// The gap before and after each step.
    pub gap: Vec<GapStep>,
    /// Parameter of the last model that changes with time, if there is one.
    pub changed_parameter: Option<ChangedParameter>,
    /// Effects that improve the fit but break a rule of physics or fail on held-out runs: they are not named.
    pub behaves_like: Vec<BehavesLike>,
    /// Entries to add to `effects` in the campaign's table `model` for all effects that were named.
    pub adopt: Vec<String>,
    /// Runs of the role `validate` that joined the fit, because the `train` runs alone did not explain the others.
    pub took_part: Vec<String>,
    /// Interpolation of the commands with which the search worked, if the baseline's does not fit the data.
    pub input: Option<Interpolation>,
    /// Effects that were added and removed again.
    pub removed: Vec<String>,
    /// Findings that look like a fault of the log.
    pub log_findings: Vec<LogFinding>,
    /// Smallest size at which each absent effect would have shown in this data.
    pub smallest_visible: Vec<SmallestVisible>,
    /// Run that would tell more.
    pub next_experiment: Option<String>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
    /// Fits of the baseline and of each step, for further work.
    #[serde(skip)]
    pub steps: Vec<Step>,
    /// Degrees of freedom that are moved by a random force instead of the commands, if nothing could be named because
    /// of it.
    #[serde(skip)]
    pub moved_otherwise: Vec<Dof>,
    /// Held-out runs on which the last model fails, the worst first.
    #[serde(skip)]
    pub erring: Vec<String>,
}

impl Discovery {
    /// Whether the named effects explain everything.
    pub fn names_are_all(&self) -> bool {
        self.verdict != Verdict::PartlyExplained
    }

    /// Effects of `behaves_like` that the sentence does not mention already.
    pub fn resemblances(&self) -> impl Iterator<Item = &BehavesLike> {
        self.behaves_like.iter().filter(|like| !self.sentence.contains(&format!("({})", like.id)))
    }

    /// The model with all added effects.
    pub fn model(&self) -> Option<&Model> {
        self.steps.last().map(|step| &step.fit.model)
    }
}

/// Codes of the discovery's findings.
pub const CODES: &[Code] =
    &[HELD_OUT_IN_TURN, TIED, COMMANDS_HELD, NO_NAME, BEYOND_THE_FIT, ELSEWHERE, TOOK_PART, CHANGED, BETWEEN_ROWS];

const HELD_OUT_IN_TURN: Code = Code {
    code: "D101",
    kind: "held-out",
    severity: Severity::Warning,
    meaning: "No run has the role `validate`: each run was predicted by an estimate without it, and the gap is that on \
              the runs of the fit.",
};

const TIED: Code = Code {
    code: "D103",
    kind: "also-possible",
    severity: Severity::Warning,
    meaning: "Other effects explain this data as well as the one that was named: see `also_possible` in the JSON, and \
              run the experiment that would separate them.",
};

/// Something is missing, and no effect of the catalogue explains it.
pub const NO_NAME: Code = Code {
    code: "D107",
    kind: "no-name",
    severity: Severity::Warning,
    meaning: "The model lacks something that no effect of the catalogue explains. Its parameters compensate for it in \
              these runs and mislead in others: they have no physical meaning yet.",
};

const BEYOND_THE_FIT: Code = Code {
    code: "D108",
    kind: "beyond-the-fit",
    severity: Severity::Warning,
    meaning: "The model fails only on held-out runs that go beyond the speeds or forces of the runs of the fit: those \
              do not show what is missing there. Include such a run in the fit.",
};

const ELSEWHERE: Code = Code {
    code: "D109",
    kind: "not-shown",
    severity: Severity::Warning,
    meaning: "The model fails on held-out runs, and the runs of the fit do not show what it lacks: the missing effect \
              hardly acts in them, like a Coriolis force where each degree of freedom is moved alone. Include such a \
              run in the fit.",
};

/// A run of the role `validate` took part in the fit of a search.
pub(super) const TOOK_PART: Code = Code {
    code: "D110",
    kind: "took-part",
    severity: Severity::Warning,
    meaning: "The runs of the fit alone did not explain the held-out runs, or left at rest a modelled degree of \
              freedom that those move: the search used some of these in its fit, and the remaining ones judged it. \
              Give them role = \"train\" before the model is fitted.",
};

/// Something begins or changes within the runs of the fit, or acts in one of them alone.
const CHANGED: Code = Code {
    code: "D111",
    kind: "changed",
    severity: Severity::Warning,
    meaning: "Something changed within the runs of the fit, or acts in one of them alone: parameters fitted to all of \
              them mix two states of the vehicle. Fit them separately.",
};

/// Searches once for effects that `baseline` lacks, with the runs of `task` divided as they are.
pub(super) fn searched(baseline: &Model, task: &Task<'_>) -> Result<Discovery, OutputErrorError> {
    let Task { train, held, own, options, .. } = *task;
    let mut found = search(baseline, task)?;
    let mut warnings = Vec::new();
    if held.is_empty() {
        warnings.push(Finding::new(&HELD_OUT_IN_TURN, HELD_OUT_IN_TURN.meaning));
    }
    let mut judged = Judged::new(&found, task)?;
    progress::tell("whether parameters are the same at all times", 0, 0);
    let fit = found.last_fit().clone();
    // beside a random force that dominates everything a change of a parameter means nothing
    let mut changed_parameter = match &found.appeared {
        Some(appeared) => Some(appeared.clone()),
        None if found.hopeless => None,
        None => changed(&fit, train, options.seed, |_| true),
    };
    let passes = judged.failing.is_empty() && changed_parameter.is_none() && !found.is_cut_short(options);
    if !passes {
        let fallen = surrogates(&mut found, &judged.gap);
        // everything reported refers to the model with the names that remain
        if !fallen.is_empty() {
            let among = |term: &str| fallen.iter().any(|candidate| candidate.holds(term));
            if changed_parameter.is_some() {
                changed_parameter = changed(&fit, train, options.seed, |term| !among(term));
            }
            leave_out(&mut found, &fallen, task)?;
            // test without an exclusion: the stand-ins are gone and do not hide the size of the change any more
            let plain = changed_parameter.is_some().then(|| changed(found.last_fit(), train, options.seed, |_| true));
            changed_parameter = plain.flatten().or(changed_parameter);
            let failing = std::mem::take(&mut judged.failing);
            judged = Judged::new(&found, task)?;
            if judged.failing.is_empty() {
                judged.failing = failing;
            }
        }
    }
    if let Some(changed) = &mut changed_parameter {
        changed.stand_beside(found.behaves_like.iter().map(|like| like.gain));
    }
    if changed_parameter.as_ref().is_some_and(|changed| !changed.is_event()) {
        changed_parameter = event(&found, task)?.or(changed_parameter);
    }
    let effects = found_effects(&found);
    let Judged { gap, training, failing, mut beyond, mut erring, follows_training } = judged;
    if changed_parameter.is_some() {
        beyond.clear();
        erring.clear();
    }
    let elsewhere = if follows_training { &erring[..] } else { &[] };
    let mut strange: Vec<&str> = beyond.iter().filter_map(|f| f.run.as_deref()).collect();
    strange.dedup();
    let fit = found.last_fit();
    let is_hopeless = found.hopeless && effects.is_empty();
    let otherwise = if is_hopeless { overwhelmed(&fit.noise.forces, train) } else { Vec::new() };
    let alike = alike(&effects);
    if !alike.is_empty() {
        warnings.push(Finding::new(
            &TIED,
            format!("{}: run the experiment that would separate them", alike.trim().trim_end_matches('.')),
        ));
    }
    let input = Some(fit.model.input).filter(|input| *input != baseline.input);
    if !strange.is_empty() {
        warnings.push(Finding::new(&BEYOND_THE_FIT, BEYOND_THE_FIT.meaning));
        warnings.extend(beyond.iter().cloned());
    } else if !elsewhere.is_empty() {
        warnings.push(Finding::new(&ELSEWHERE, ELSEWHERE.meaning));
    } else if changed_parameter.as_ref().is_some_and(ChangedParameter::is_event) {
        warnings.push(Finding::new(&CHANGED, CHANGED.meaning));
    } else if !passes && !is_hopeless {
        warnings.push(Finding::new(&NO_NAME, NO_NAME.meaning));
    }
    let verdict = verdict(!effects.is_empty(), passes);
    let residuals = residuals(&found.steps[0].fit, train);
    let open: Vec<Measured> = found.steps[0]
        .fit
        .model
        .measured()
        .into_iter()
        .filter(|m| {
            let pose = m.dof().map_or("", |dof| dof.position());
            failing.iter().any(|(name, _)| name == m.channel() || name == pose)
        })
        .collect();
    let seen: Vec<String> = found.screen.scores.iter().map(|s| found.candidates[s.candidate].name()).collect();
    let unseen: Vec<String> =
        found.candidates.iter().map(Candidate::name).filter(|name| !seen.contains(name)).collect();
    let better = improvement(&gap, &effects);
    let places = if verdict == Verdict::NothingMissing {
        Vec::new()
    } else {
        let first = &found.steps[0].fit;
        let outputs = &first.filtered.problem.dynamics.outputs;
        disagreement(&first.model, outputs, (&first.forecast(), &training), train)
    };
    let smallest_visible = smallest_visible(&found);
    let dofs: Vec<Dof> = otherwise.iter().map(|(dof, _)| *dof).collect();
    let more = next::experiment(verdict, &effects, changed_parameter.as_ref(), (&open, &residuals), &unseen);
    warnings.extend(input.map(finding));
    Ok(Discovery {
        format: 1,
        verdict,
        sentence: told_before(
            input,
            match is_hopeless {
                true => moved_otherwise(&otherwise),
                false => sentence(
                    verdict,
                    &effects,
                    &found.behaves_like,
                    &fit.noise.forces,
                    better,
                    (&failing, &apart(&strange, elsewhere)),
                    changed_parameter.as_ref(),
                ),
            },
        ),
        next_experiment: next::driven(&dofs).or(next::take_part(&strange).or(next::show(elsewhere))).or(more),
        moved_otherwise: dofs,
        changed_parameter,
        residuals,
        places,
        adopt: names_to_list(&found, own),
        effects,
        gap,
        behaves_like: found.behaves_like,
        took_part: Vec::new(),
        input,
        removed: found.removed,
        log_findings: Vec::new(),
        smallest_visible,
        seed: options.seed,
        warnings,
        steps: found.steps,
        erring,
    })
}

/// What has begun or changed beside the names that were found.
fn event(found: &Search, task: &Task<'_>) -> Result<Option<ChangedParameter>, OutputErrorError> {
    let (fit, scored) = (found.last_fit(), (&found.candidates[..], &found.screen));
    match appeared(fit, scored, task)? {
        Some(appeared) if appeared.alone => Ok(Some(appeared)),
        appeared => Ok(likelier(appeared, stepped((fit, scored), task, 0.0)?)),
    }
}
