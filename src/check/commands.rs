//! Commands compared with the motion: the sign of each, and the delay of the answer.
//!
//! The fit is that of [`Balance`](super::balance). A command with a negative gain pushes the wrong way;
//! the delay is the one with the least residual. A lag of the thrusters looks like a delay of about its
//! time constant. With a righting moment in the balance (roll and pitch) no delay is estimated: in a
//! sinusoidal motion the two cannot be distinguished. Commands of a pilot that oscillate with the
//! motion are ambiguous, too: half a period later they push the other way. An answer is therefore
//! reported only if its gain has the same sign with and without the delay.

use super::balance::{Balance, Term};
use super::codes;
use super::lag::{self, Lag};
use super::report::{Answer, FaultKind, Found};
use super::velocity_sign;
use crate::effects::id;
use crate::frame::Dof;
use crate::log::number::short;
use crate::run::Run;
use crate::thrust::thruster::Thruster;

/// Number of standard deviations from zero at which the sign and the delay of a gain are certain.
pub(super) const CERTAIN: f64 = 8.0;
/// Least share of the changes of velocity, after the other terms, that the commands must explain.
const OWED: f64 = 0.3;

/// Least number of times that a command must go from one side of its range to the other: drag,
/// Coriolis force and a constant explain the answer to a single step as well.
const SWINGS: usize = 2;

/// Advice for thrusters that push the wrong way.
pub const MISPLACED: &str =
    "the position, axis or sign of one of them is reversed, or body_frame is wrong; correct the [[thruster]] tables";

/// Returns the answers of one degree of freedom to its commands; empty if the motion does not
/// clearly depend on them.
pub fn measure(balance: &Balance) -> Vec<Answer> {
    let free = |f: &super::fit::Fit| f.rows - f.theta.len();
    let righting = balance.terms.contains(&Term::Restoring);
    let least = || lag::least(0.05, |d| balance.fit_with_any_curve(d).map(|f| (f.cost, free(&f))));
    let delay = if righting { None } else { least() };
    let Some(fit) = balance.fit(delay.map_or(0.0, |d| d.seconds)) else { return Vec::new() };
    if balance.owed_to_commands(&fit) < OWED {
        return Vec::new();
    }
    let Some(at_once) = balance.fit(0.0) else { return Vec::new() };
    let channels = balance.channels();
    let answer = |(k, channel): (usize, &&str)| Answer {
        channel: (*channel).to_string(),
        velocity: balance.dof.velocity().to_string(),
        gain: fit.theta[k],
        std: fit.std[k],
        delay,
        joined: balance.is_joined(k),
    };
    let clear = |(k, a): &(usize, Answer)| {
        a.gain.abs() > CERTAIN * a.std && a.gain * at_once.theta[*k] > 0.0 && balance.swings(*k) >= SWINGS
    };
    let answers = channels.iter().enumerate().map(answer).enumerate();
    answers.filter(clear).map(|(_, a)| a).collect()
}

/// Returns the command as it is in the log: for the force of a thruster, the control from which it
/// is computed.
pub fn as_logged(channel: &str, run: &Run) -> String {
    run.command_of(channel).unwrap_or_else(|| channel.to_string())
}

/// Advice on how to reverse the sign of `channel` in the log of `run`: for the force of a thruster,
/// that of the command from which it is computed.
fn turned(channel: &str, run: &Run) -> String {
    match run.command_of(channel) {
        Some(command) => format!("reverse its command, columns.{command} = {{ name = \"its column\", sign = -1 }}"),
        None => format!("set columns.{channel}.sign = -1"),
    }
}

/// Returns whether each answer has the sign that it should have, where that is known. An answer to
/// several joined commands is skipped: its sign is that of the strongest.
pub fn signs<'a>(answers: &'a [Answer], thrusters: &[Thruster]) -> Vec<(&'a Answer, bool)> {
    let told = |a: &'a Answer| Some((a, a.gain * expected(a, thrusters).filter(|_| !a.joined)? > 0.0));
    answers.iter().filter_map(told).collect()
}

/// The same by degree of freedom.
pub fn by_dof(signs: &[(&Answer, bool)]) -> Vec<(Dof, bool)> {
    signs.iter().filter_map(|(a, right)| Some((dof_of(a)?, *right))).collect()
}

/// Finds wrong signs. A nominal force has a positive gain; the sign of a thruster is known if the
/// vehicle's thrusters are.
pub fn judge_signs(run: &Run, signs: &[(&Answer, bool)]) -> Vec<Found> {
    let mut found: Vec<Found> = Vec::new();
    for (a, _) in signs.iter().filter(|(_, right)| !right) {
        let channel = as_logged(&a.channel, run);
        // one thruster can show in several degrees of freedom
        if found.iter().any(|f| f.channels[0] == channel) {
            continue;
        }
        let text = format!(
            "{channel} accelerates {} the wrong way ({} ± {} per unit): one of the two has the opposite sign, or two \
             commands are exchanged; check body_frame, or {}",
            a.velocity,
            short(a.gain, 3),
            short(a.std, 2),
            turned(&a.channel, run)
        );
        let of_sign = Found::new(&codes::COMMAND_SIGN, &[&channel], text);
        found.push(of_sign.fault(FaultKind::Sign, &channel, -1.0));
    }
    found
}

fn dof_of(answer: &Answer) -> Option<Dof> {
    Dof::ALL.into_iter().find(|dof| dof.velocity() == answer.velocity)
}

/// Returns the answer of `dof` to the total force or moment of the thrusters as placed, which is τ of
/// `run`. Two thrusters that always push together do not show their own signs.
pub fn answer_to_thrusters(run: &Run, dof: Dof) -> Option<Answer> {
    measure(&Balance::new(run, dof)?).into_iter().find(|answer| answer.channel == dof.force())
}

/// Finds degrees of freedom that the thrusters, as placed, push the wrong way, or what explains
/// that more simply; `holds` tells whether other channels confirm the sign of a velocity.
pub fn judge_placement(run: &Run, dofs: &[Dof], holds: impl Fn(Dof) -> bool) -> Vec<Found> {
    let answers: Vec<(Dof, Answer)> =
        dofs.iter().filter_map(|dof| Some((*dof, answer_to_thrusters(run, *dof)?))).collect();
    let signs: Vec<(Dof, bool)> = answers.iter().map(|(dof, answer)| (*dof, answer.gain > 0.0)).collect();
    if let Some(instead) = velocity_sign::instead(&signs, holds) {
        return vec![velocity_sign::judge(&instead, &signs)];
    }
    let wrong = |(dof, answer): &(Dof, Answer)| {
        let text = format!(
            "the thrusters, placed as stated, push {dof} the wrong way ({} ± {} per unit of force): {}",
            short(answer.gain, 3),
            short(answer.std, 2),
            MISPLACED
        );
        Found::new(&codes::COMMAND_SIGN, &[dof.force(), dof.velocity()], text)
    };
    answers.iter().filter(|(_, answer)| answer.gain < 0.0).map(wrong).collect()
}

/// Returns a number with the sign that the gain should have; `None` if it is unknown.
fn expected(answer: &Answer, thrusters: &[Thruster]) -> Option<f64> {
    let dof = dof_of(answer)?;
    // the gain of a fin is computed so that it should be positive
    if answer.channel == dof.force() || id::fins().iter().any(|fin| fin.channel == answer.channel) {
        return Some(1.0);
    }
    let number = super::rates::number_of(&answer.channel)?;
    let thruster = thrusters.get(number.checked_sub(1)?)?;
    thruster.validate().ok()?;
    let share = thruster.unit_wrench()[dof.index()];
    // the sign of a very small component is not reliable
    (share.abs() > 0.05).then_some(share)
}

/// Finds delays; those of all degrees of freedom are one finding. `answers` come with the usual steps of
/// their channels, s. `known`: the model has a lag of the thrusters, so that a late answer is no finding.
pub fn judge_delays(run: &Run, answers: &[(Vec<Answer>, f64)], known: bool) -> Vec<Found> {
    let is_told = |d: Lag, step: f64| d.is_clear(8.0, (1.25 * step).max(0.15)) && !(known && d.seconds > 0.0);
    let late: Vec<(&[Answer], Lag)> = answers
        .iter()
        .filter_map(|(of_dof, step)| Some((&of_dof[..], of_dof.first()?.delay.filter(|d| is_told(*d, *step))?)))
        .collect();
    if late.is_empty() {
        return Vec::new();
    }
    // one delay fits all commands of a degree of freedom
    let pushed_by = |of_dof: &[Answer]| -> String {
        of_dof.iter().map(|a| as_logged(&a.channel, run)).collect::<Vec<_>>().join(", ")
    };
    let says = |(of_dof, d): &(&[Answer], Lag)| {
        format!(
            "{} answers {} {} ± {} s {}",
            of_dof[0].velocity,
            pushed_by(of_dof),
            short(d.seconds.abs(), 3),
            short(2.0 * d.std, 2),
            if d.seconds > 0.0 { "late" } else { "early" }
        )
    };
    let cause = if late.iter().all(|(_, d)| d.seconds < 0.0) {
        "the commands are logged later than they act"
    } else if late.iter().all(|(_, d)| d.seconds > 0.0) {
        "the commands are delayed, or the thrusters lag by about this much"
    } else {
        "the sensors of these velocities have different latencies, or the clocks differ"
    };
    let text = format!("{}: {cause}", late.iter().map(says).collect::<Vec<_>>().join("; "));
    let of = |(of_dof, d): &(&[Answer], Lag)| -> Vec<(String, f64)> {
        of_dof.iter().map(|a| (as_logged(&a.channel, run), d.seconds)).collect()
    };
    let delays: Vec<(String, f64)> = late.iter().flat_map(of).collect();
    let channels: Vec<&str> = delays.iter().map(|(channel, _)| channel.as_str()).collect();
    let found = Found::new(&codes::COMMAND_DELAY, &channels, text);
    vec![delays.iter().fold(found, |found, (channel, seconds)| found.fault(FaultKind::Delay, channel, *seconds))]
}

/// Whether a term is a command's.
pub fn is_command(term: &Term) -> bool {
    matches!(term, Term::Command(_))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{Run, Signal};

    /// Sign of the gain in yaw that is reported; `rate` gives r, `moment` τ_r.
    fn told(rate: impl Fn(f64) -> f64, moment: impl Fn(f64) -> f64) -> Option<f64> {
        let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        let mut run = Run::default();
        for (name, of) in [("r", &rate as &dyn Fn(f64) -> f64), ("tau_r", &moment)] {
            run.signals.insert(name.into(), Signal::new(time.clone(), time.iter().map(|t| of(*t)).collect::<Vec<_>>()));
        }
        let answers = measure(&Balance::new(&run, Dof::Yaw).unwrap());
        answers.first().map(|a| a.gain.signum())
    }

    /// In an oscillation with a period of 2 s a push with the motion equals a push against it half
    /// a period later: no sign is reported. In an irregular motion the sign is reported, for a
    /// command that acts at once and for a late one.
    #[test]
    fn the_sign_of_a_command_that_swings_with_the_motion_is_not_told() {
        let swelling = |t: f64| (1.0 + 0.3 * (0.37 * t).sin()) * (std::f64::consts::PI * t).sin();
        let slope = |f: &dyn Fn(f64) -> f64, t: f64| (f(t + 1e-3) - f(t - 1e-3)) / 2e-3;
        assert_eq!(told(swelling, |t| -slope(&swelling, t + 1.0)), None);
        let wandering = |t: f64| (0.9 * t).sin() + (0.53 * t).cos() + 0.5 * (1.7 * t).sin();
        for late in [0.0, 0.3] {
            assert_eq!(told(wandering, |t| slope(&wandering, t + late)), Some(1.0), "{late} s late");
            assert_eq!(told(wandering, |t| -slope(&wandering, t + late)), Some(-1.0), "{late} s late, and reversed");
        }
    }

    #[test]
    fn the_sign_of_a_force_is_turned_where_it_comes_from() {
        let mut run = Run::default();
        run.signals.insert("V1".into(), Signal::new(vec![0.0, 1.0].into(), vec![0.0, 1.0]));
        assert_eq!(turned("F1", &run), "reverse its command, columns.V1 = { name = \"its column\", sign = -1 }");
        assert_eq!(turned("F2", &run), "set columns.F2.sign = -1", "a force that is logged itself");
        assert_eq!(turned("tau_u", &run), "set columns.tau_u.sign = -1");
    }
}
