//! What the commands do between their rows, if the data contradict the model's `input`.
//!
//! ```text
//! T̂      delay of the motion behind the commands, from the shortest probe of thrust_delay;  h: time between their rows
//! lines:  T̂ ≈ h/2, beyond chance      they may be held:   hold at least as likely as lines with a delay of any size
//! hold:  −h < T̂ < 0, beyond chance    they change between the rows:   lines likelier than hold
//! ```
//!
//! A held command that is taken as a straight line acts half a row late. A logger that is slower than the controller
//! writes the last command it has seen: held, each change acts up to one row late, and no effect makes a vehicle move
//! before it is commanded to. A delay that is named is known to half a row only together with the interpolation.

use super::candidate::Candidate;
use super::refit::beside;
use super::screen::{Score, Screen};
use super::task::{TIE, Task};
use crate::effects::{CommandDelay, id};
use crate::estimate::filter_error::{FilterErrorFit, filter_error};
use crate::finding::{Code, Finding, Severity};
use crate::frame::Dof;
use crate::model::{Interpolation, Model};
use crate::run::Run;

/// Commands are held.
pub(super) const COMMANDS_HELD: Code = Code {
    code: "D106",
    kind: "commands-held",
    severity: Severity::Warning,
    meaning: "A delay of half a sample of the commands is the signature of held commands that are interpolated linearly: \
              set `input = \"hold\"` in [model]. The search worked with held commands.",
};

/// Commands change between the logged rows.
pub(super) const BETWEEN_ROWS: Code = Code {
    code: "D112",
    kind: "commands-between-rows",
    severity: Severity::Warning,
    meaning: "Held commands would act late: the motion precedes them by less than a row, and straight lines between the \
              rows explain it better. Set `input = \"linear\"` in [model], or log every change of the commands. The search \
              worked with straight lines.",
};

/// Largest deviation of a delay from half a row, in rows, that held commands may have.
const NEAR_HALF: f64 = 0.25;

/// The fit of the baseline with the other interpolation of the commands, if the data ask for it.
pub(super) fn otherwise(
    fit: &FilterErrorFit,
    (candidates, screen): (&[Candidate], &Screen),
    task: &Task<'_>,
) -> Option<FilterErrorFit> {
    let delay = candidates.iter().position(|candidate| candidate.name() == id::THRUST_DELAY)?;
    let (candidate, probes) = (&candidates[delay], candidates[delay].grid()?);
    let scores = screen.scores.iter().filter(|s| s.candidate == delay && s.log_p < screen.threshold);
    let score: &Score = scores.min_by(|a, b| probes[a.probe].total_cmp(&probes[b.probe]))?;
    let rows = score.estimate.first()? * probes[score.probe] / row(task.train)?;
    let refitted = |model: &Model| filter_error(model, task.train, &beside(fit, task)).ok();
    match fit.model.input {
        Interpolation::Hold if (-1.0..0.0).contains(&rows) => {
            refitted(&other(&fit.model)).filter(|lines| lines.plain < fit.plain - TIE)
        }
        Interpolation::Linear if (rows - 0.5).abs() < NEAR_HALF => {
            let held = refitted(&other(&fit.model)).filter(|held| held.plain < fit.plain - TIE)?;
            let late = refitted(&candidate.started_in_part(&fit.model, score)?)?;
            (held.plain < late.plain + TIE).then_some(held)
        }
        _ => None,
    }
}

/// The fit `before` a delay was named, with held commands instead, if the delay in `after` is half a row of commands that
/// are taken as lines and holding them explains as much.
pub(super) fn held_instead(before: &FilterErrorFit, after: &FilterErrorFit, task: &Task<'_>) -> Option<FilterErrorFit> {
    let named = after.model.term(id::THRUST_DELAY).filter(|_| before.model.term(id::THRUST_DELAY).is_none())?;
    let delay = after.model.terms[named].parameters.first().map(|p| after.model.parameters[*p].value)?;
    if before.model.input == Interpolation::Hold || (delay / row(task.train)? - 0.5).abs() >= NEAR_HALF {
        return None;
    }
    let held = filter_error(&other(&before.model), task.train, &beside(before, task)).ok()?;
    (held.plain < after.plain + TIE).then_some(held)
}

/// The fit with the other interpolation of the commands and the delays of the model half a row longer or shorter, if
/// it is likelier than `fit`.
pub(super) fn otherwise_delayed(fit: &FilterErrorFit, task: &Task<'_>) -> Option<FilterErrorFit> {
    let half = 0.5 * row(task.train)?;
    let mut model = other(&fit.model);
    let shift = if model.input == Interpolation::Linear { half } else { -half };
    let delays: Vec<usize> = model
        .terms
        .iter()
        .filter_map(|term| match term.effect.delays_command()? {
            CommandDelay::Constant(k) => term.parameters.get(k).copied(),
            CommandDelay::Growing(_) => None,
        })
        .collect();
    if delays.is_empty()
        || delays.iter().any(|p| model.parameters[*p].fixed || model.parameters[*p].value + shift <= 0.0)
    {
        return None;
    }
    delays.into_iter().for_each(|p| model.parameters[p].value += shift);
    let other = filter_error(&model, task.train, &beside(fit, task)).ok()?;
    (other.plain < fit.plain - TIE).then_some(other)
}

/// `model` with the other interpolation.
fn other(model: &Model) -> Model {
    let input = match model.input {
        Interpolation::Hold => Interpolation::Linear,
        Interpolation::Linear => Interpolation::Hold,
    };
    Model { input, ..model.clone() }
}

/// Mean time between the rows of the commands, s.
fn row(runs: &[Run]) -> Option<f64> {
    let commands = || runs.iter().flat_map(|r| Dof::ALL.into_iter().filter_map(|d| r.signal(d.force())));
    let spans = commands().filter(|s| s.len() > 1).map(|s| (s.time()[s.len() - 1] - s.time()[0], s.len() - 1));
    let (seconds, rows) = spans.fold((0.0, 0), |(t, n), (span, count)| (t + span, n + count));
    (rows > 0).then(|| seconds / rows as f64)
}

/// The finding about the interpolation with which the search worked.
pub(super) fn finding(input: Interpolation) -> Finding {
    match input {
        Interpolation::Hold => Finding::new(&COMMANDS_HELD, COMMANDS_HELD.meaning),
        Interpolation::Linear => Finding::new(&BETWEEN_ROWS, BETWEEN_ROWS.meaning),
    }
}

/// A verdict after the interpolation with which it was found, if that is not the baseline's.
pub(super) fn told_before(input: Option<Interpolation>, verdict: String) -> String {
    let why = match input {
        None => return verdict,
        Some(Interpolation::Hold) => {
            "Held commands were interpolated linearly, which looks like a delay of half of their sample time: set \
             `input = \"hold\"` in [model]"
        }
        Some(Interpolation::Linear) => {
            "The commands change between the logged rows, not at them: set `input = \"linear\"` in [model]"
        }
    };
    format!("{why}. With that: {verdict}")
}
