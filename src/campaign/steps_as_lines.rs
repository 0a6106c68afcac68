//! Commands that are held in a log but read as lines.
//!
//! ```text
//! held: a clock of its own ([`hold`]), or at least half of the changes are isolated
//!       and the median change is above 5 % of the range
//! ```
//!
//! A held command that is read as a line acts up to a row too early on the way to the next step. A
//! coarse value of a smooth command also stays constant for some rows, but its changes are one
//! quantum, far below its range.
//!
//! A log of steps looks the same if the command was a line between two samples. Only the motion can
//! tell: if it agrees with the lines ([`between_rows`]), or the fitted model explains the runs no
//! better with held commands, there is no advice.

use super::between_rows::between_rows;
use super::codes;
use super::moves::moves;
use crate::check::rates::number_of;
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions, cost_of};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::log::check::hold;
use crate::log::check::time::usual_step;
use crate::model::{Interpolation, Model};
use crate::run::{Run, Signal, is_deflection};
use crate::wording::count;

/// Least size of a step, as a part of the range.
const STEP: f64 = 0.05;

/// Least number of changes for a decision.
const FEWEST: usize = 3;

/// Returns the advice for runs that are read as lines; `held` says whether the commands of a run
/// are held according to the campaign.
pub(super) fn finding(runs: &[Run], held: impl Fn(&Run) -> bool) -> Option<Finding> {
    let stepped: Vec<&Run> = runs
        .iter()
        .filter(|run| moves(run.kind) && !held(run) && commands(run).any(|(_, s)| steps(s.values())))
        .collect();
    let first = stepped.first()?;
    if are_lines(&stepped) {
        return None;
    }
    let channels: Vec<&str> = commands(first).filter(|(_, s)| steps(s.values())).map(|(name, _)| name).collect();
    let more = more_runs(stepped.len() - 1);
    let does = if channels.len() == 1 {
        "holds its value over several rows and then steps"
    } else {
        "hold their values over several rows and then step"
    };
    let text = format!(
        "{}: {} {does}{more}, but input = \"linear\" interpolates between the rows; write input = \"hold\" in [model] \
         or in the [[run]]",
        first.name,
        channels.join(", ")
    );
    Some(Finding::new(&codes::STEPS_AS_LINES, text))
}

/// Whether the motion agrees with commands on lines: a logger may ask for the commands now and
/// then, while they change between its rows.
fn are_lines(runs: &[&Run]) -> bool {
    let step = runs.iter().flat_map(|run| commands(run)).find_map(|(_, signal)| usual_step(signal.time()));
    step.and_then(|step| between_rows(runs.iter().copied(), step)).is_some_and(|told| !told.held)
}

/// Whether the motion refutes the advice of `findings`: `fitted` explains these runs no better with
/// held commands.
pub(super) fn refuted(
    findings: &[Finding],
    fitted: &FilterErrorFit,
    runs: &[Run],
    options: &FilterErrorOptions,
) -> bool {
    if fitted.model.input == Interpolation::Hold || !findings.iter().any(|f| f.code == codes::STEPS_AS_LINES.code) {
        return false;
    }
    let mut held = fitted.model.clone();
    held.input = Interpolation::Hold;
    let cost = |model: &Model| cost_of(model, runs, (&fitted.noise, fitted.limit), options);
    matches!((cost(&held), cost(&fitted.model)), (Ok(held), Ok(lines)) if held > lines)
}

/// Returns the commands: the thrusters' commands or forces if they are logged, otherwise the
/// wrench.
fn commands(run: &Run) -> impl Iterator<Item = (&str, &Signal)> {
    let thruster = |name: &str| number_of(name).is_some();
    let any = run.signals.keys().any(|name| thruster(name));
    let wanted = move |name: &str| if any { thruster(name) } else { Dof::ALL.iter().any(|dof| dof.force() == name) };
    run.signals.iter().map(|(name, signal)| (name.as_str(), signal)).filter(move |(name, _)| wanted(name))
}

/// Whether a channel changes continuously from row to row although commands are held: the angle of
/// a fin, or the turns of a propeller, that was measured and not ordered. What moves takes its
/// time, and has the value of a row at that instant only.
pub(super) fn goes_on(name: &str, signal: &Signal) -> bool {
    is_deflection(name) && !steps(signal.values()) && moves_on(signal.values())
}

/// Whether most changes continue in the same direction at the next row, or, if they are as small as
/// those of a coarse value, at the next change: the channel then has a speed. An order is constant
/// between its few steps, and the order of a noisy autopilot turns back as often as it goes on.
fn moves_on(values: &[f64]) -> bool {
    let changes: Vec<(usize, f64)> =
        values.windows(2).map(|w| w[1] - w[0]).enumerate().filter(|c| c.1 != 0.0).collect();
    let small = STEP * range(values);
    let leads_on = |pair: &&[(usize, f64)]| {
        let ((row, change), (next_row, next)) = (pair[0], pair[1]);
        change * next > 0.0 && (next_row == row + 1 || change.abs().max(next.abs()) <= small)
    };
    changes.len() >= FEWEST && 2 * changes.windows(2).filter(leads_on).count() > changes.len()
}

/// Returns the greatest minus the least value.
fn range(values: &[f64]) -> f64 {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    high - low
}

/// Returns the note about channels that are read as lines although commands are held.
pub(super) fn measured(runs: &[Run], held: impl Fn(&Run) -> bool) -> Option<Finding> {
    let of = |run: &Run| -> Vec<String> {
        run.signals.iter().filter(|(name, signal)| goes_on(name, signal)).map(|(name, _)| name.clone()).collect()
    };
    let going: Vec<&Run> = runs.iter().filter(|run| moves(run.kind) && held(run) && !of(run).is_empty()).collect();
    let first = going.first()?;
    let (channels, more) = (of(first), more_runs(going.len() - 1));
    let text = format!(
        "{}: {} {} on from row to row{more}: interpolated between the rows, although input = \"hold\"",
        first.name,
        channels.join(", "),
        if channels.len() == 1 { "goes" } else { "go" },
    );
    Some(Finding::new(&codes::MEASURED_DEFLECTION, text))
}

fn more_runs(more: usize) -> String {
    if more == 0 { String::new() } else { format!(" (and in {})", count(more, "more run")) }
}

/// Whether these values are those of a held command.
fn steps(values: &[f64]) -> bool {
    if hold::of(values).is_some() {
        return true;
    }
    let changes: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    let alone = |k: usize| changes[k] > 0.0 && changes.get(k + 1).is_none_or(|next| *next == 0.0);
    let mut sizes: Vec<f64> = changes.iter().copied().filter(|c| *c > 0.0).collect();
    sizes.sort_by(f64::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    let isolated = (0..changes.len()).filter(|k| alone(*k)).count();
    sizes.len() >= FEWEST && 2 * isolated >= sizes.len() && median > STEP * range(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(of: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..400).map(|k| of(f64::from(k))).collect()
    }

    #[test]
    fn runs_and_columns_are_counted_in_english() {
        let run = |name: &str, columns: &[&str]| {
            let time: std::sync::Arc<[f64]> = values(|k| 0.1 * k).into();
            let steps = values(|k| if (k / 60.0).floor() % 2.0 == 0.0 { 30.0 } else { -30.0 });
            let signal = |column: &&str| (column.to_string(), Signal::new(time.clone(), steps.clone()));
            Run { name: name.into(), signals: columns.iter().map(signal).collect(), ..Run::default() }
        };
        let told = |runs: &[Run]| finding(runs, |_| false).map(|f| f.message).unwrap_or_default();
        let one = told(&[run("a", &["tau_r"]), run("b", &["tau_r"])]);
        assert!(
            one.starts_with("a: tau_r holds its value over several rows and then steps (and in 1 more run), but"),
            "{one}"
        );
        let two = told(&[run("a", &["tau_r", "tau_u"])]);
        assert!(two.starts_with("a: tau_r, tau_u hold their values over several rows and then step, but"), "{two}");
    }

    #[test]
    fn steps_are_told_from_smooth_coarse_and_resting_commands() {
        let sine = |k: f64| 40.0 * (0.05 * k).sin();
        assert!(steps(&values(|k| if (k / 60.0).floor() % 2.0 == 0.0 { 30.0 } else { -30.0 })), "square");
        assert!(steps(&values(|k| sine((k / 5.0).floor() * 5.0))), "a slower clock");
        assert!(!steps(&values(sine)), "smooth");
        assert!(!steps(&values(|k| sine(k).round())), "coarse");
        assert!(!steps(&values(|k| if k < 250.0 { 0.0 } else { sine(k) })), "a rest before it");
        assert!(!steps(&values(|_| 20.0)), "one value");
    }

    #[test]
    fn a_steering_gear_takes_its_time_and_an_order_does_not() {
        let time: std::sync::Arc<[f64]> = values(|k| k).into();
        let signal = |of: &dyn Fn(f64) -> f64| Signal::new(time.clone(), values(of));
        // over to the other side at 3 degrees a second, once a minute
        let order = |k: f64| if (k / 60.0).floor() % 2.0 == 0.0 { 20.0 } else { -20.0 };
        let gear = |k: f64| {
            let side = order(k);
            if k < 60.0 { side } else { side - 2.0 * side * (1.0 - (k % 60.0) * 3.0 / 40.0).max(0.0) }
        };
        assert!(goes_on("rudder", &signal(&gear)));
        assert!(!goes_on("rudder", &signal(&order)));
        assert!(!goes_on("tau_r", &signal(&gear)), "a command is what input says");
        assert!(!goes_on("rudder", &signal(&|_| 2.0)));
        // a turning circle: one order out of rest, one over to the other side
        assert!(!goes_on(
            "rudder",
            &signal(&|k| if k < 40.0 {
                0.0
            } else if k < 300.0 {
                18.7
            } else {
                -15.2
            })
        ));
        // an autopilot's order, to a heading that swings and has noise
        let noise = |k: f64| ((k * 12.9898).sin() * 43758.545).fract();
        assert!(!goes_on("rudder", &signal(&|k| 10.0 * (0.05 * k).sin() + 4.0 * noise(k))));
        // a gear that is read in whole degrees
        assert!(goes_on("rudder", &signal(&|k| (25.0 * (0.02 * k).sin()).round())));
    }
}
