//! Commands against the motion: the sign of each, and how late the vehicle answers.
//!
//! The fit is that of [`Balance`](super::balance). A command whose gain is negative pushes the wrong way; the delay is the
//! one at which the fit leaves least. A lag of the thrusters looks like a delay of about its time constant. In roll and
//! pitch a sine cannot tell a delay from the righting moment: there none is sought. Nor can a pilot's commands, which swing
//! with the motion: half a swing later they push the other way. A gain that has another sign without the delay is told by
//! neither.

use super::balance::{Balance, Term};
use super::codes;
use super::lag;
use super::report::{Answer, FaultKind, Found};
use crate::frame::Dof;
use crate::log::number::short;
use crate::run::Run;
use crate::thrust::thruster::Thruster;
use crate::wording::listed;

/// How many standard deviations a gain must be from zero to speak of its sign or its delay.
pub(super) const CERTAIN: f64 = 8.0;
/// Least part of the changes of velocity that the commands must explain.
const OWED: f64 = 0.3;

/// What to do about thrusters that push the wrong way.
pub const MISPLACED: &str =
    "position, axis or sign of one of them is opposite, or body_frame is; mend the [[thruster]] tables";

/// Answers of one degree of freedom to its commands; none where the motion does not depend on them clearly.
pub fn measure(balance: &Balance) -> Vec<Answer> {
    let free = |f: &super::fit::Fit| f.rows - f.theta.len();
    let righting = balance.terms.contains(&Term::Restoring);
    let least = || lag::least(0.05, |d| balance.fit(d).map(|f| (f.cost, free(&f))));
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
    let clear = |(k, a): &(usize, Answer)| a.gain.abs() > CERTAIN * a.std && a.gain * at_once.theta[*k] > 0.0;
    let answers = channels.iter().enumerate().map(answer).enumerate();
    answers.filter(clear).map(|(_, a)| a).collect()
}

/// How the sign of `channel` is turned in the log of `run`: that of a thruster's force by the command of which it is made.
fn turned(channel: &str, run: &Run) -> String {
    match run.command_of(channel) {
        Some(command) => format!("turn its command, columns.{command} = {{ name = \"its column\", sign = -1 }}"),
        None => format!("set columns.{channel}.sign = -1"),
    }
}

/// Signs that are wrong. A nominal force has a positive gain; a thruster's sign is known when the vehicle's thrusters are.
pub fn judge_signs(run: &Run, answers: &[Answer], thrusters: &[Thruster]) -> Vec<Found> {
    // the sign of several together is that of the strongest
    let wrong = |a: &&Answer| expected(a, thrusters).is_some_and(|right| !a.joined && a.gain * right <= 0.0);
    let wrong: Vec<&Answer> = answers.iter().filter(wrong).collect();
    let velocities: Vec<&str> = wrong.iter().map(|a| a.velocity.as_str()).collect();
    let frame = mirrored(&velocities);
    let mut found: Vec<Found> = Vec::new();
    for a in wrong {
        // one thruster can show in several degrees of freedom
        if found.iter().any(|f| f.channels[0] == a.channel) {
            continue;
        }
        let remedy = match &frame {
            Some(frame) => frame.clone(),
            None => format!(
                "the sign of one of the two is opposite, or two commands are exchanged; check body_frame, or {}",
                turned(&a.channel, run)
            ),
        };
        let text = format!(
            "{} accelerates {} the wrong way ({} ± {} per unit): {remedy}",
            a.channel,
            a.velocity,
            short(a.gain, 3),
            short(a.std, 2),
        );
        found.push(Found::new(&codes::COMMAND_SIGN, &[&a.channel, &a.velocity], text).fault(
            FaultKind::Sign,
            &a.channel,
            -1.0,
        ));
    }
    found
}

/// Velocities that change their sign with the way in which the body axes are laid, forward-left-up for forward-starboard-down.
const MIRRORED: [&str; 4] = ["v", "w", "q", "r"];

/// What commands that push several of those velocities the wrong way have in common: one frame, rather than a fault of each.
/// `None` where others are accused, or one alone.
fn mirrored(accused: &[&str]) -> Option<String> {
    let together: Vec<&str> = MIRRORED.into_iter().filter(|name| accused.contains(name)).collect();
    let alone = accused.iter().all(|name| MIRRORED.contains(name));
    (alone && together.len() > 1).then(|| {
        format!(
            "{} are pushed the wrong way together, so that one frame is wrong rather than each command: set body_frame = \"flu\" in \
             [log] where the log is forward-left-up, or mend the axes of the [[thruster]] tables",
            listed(&together)
        )
    })
}

/// How `dof` answers what the thrusters of a vehicle push together, where they are: τ of `run` is theirs. Two that always push at
/// once show no sign of their own.
pub fn answer_to_thrusters(run: &Run, dof: Dof) -> Option<Answer> {
    measure(&Balance::new(run, dof)?).into_iter().find(|answer| answer.channel == dof.force())
}

/// Thrusters that push a degree of freedom the wrong way, as they are placed.
pub fn judge_placement(run: &Run, dofs: &[Dof]) -> Vec<Found> {
    let gain = |dof: &Dof| Some((*dof, answer_to_thrusters(run, *dof).filter(|answer| answer.gain < 0.0)?));
    let wrong: Vec<(Dof, Answer)> = dofs.iter().filter_map(gain).collect();
    let velocities: Vec<&str> = wrong.iter().map(|(dof, _)| dof.velocity()).collect();
    let remedy = mirrored(&velocities).unwrap_or_else(|| MISPLACED.to_string());
    let told = |(dof, answer): (Dof, Answer)| {
        let text = format!(
            "the thrusters, as they are placed, push {dof} the wrong way ({} ± {} per unit of force): {remedy}",
            short(answer.gain, 3),
            short(answer.std, 2)
        );
        Found::new(&codes::COMMAND_SIGN, &[dof.force(), dof.velocity()], text)
    };
    wrong.into_iter().map(told).collect()
}

/// The sign that the gain should have; `None` when it is not known.
fn expected(answer: &Answer, thrusters: &[Thruster]) -> Option<f64> {
    let dof = Dof::ALL.into_iter().find(|d| d.velocity() == answer.velocity)?;
    if answer.channel == dof.force() {
        return Some(1.0);
    }
    let number = super::rates::number_of(&answer.channel)?;
    let thruster = thrusters.get(number.checked_sub(1)?)?;
    thruster.validate().ok()?;
    let share = thruster.unit_wrench()[dof.index()];
    // a hair's breadth of leverage has no sign to rely on
    (share.abs() > 0.05).then_some(share)
}

/// Delays, those of all degrees of freedom in one finding. `steps` are the usual steps of their channels, s.
pub fn judge_delays(answers: &[(Vec<Answer>, f64)]) -> Vec<Found> {
    let late: Vec<&Answer> = answers
        .iter()
        .filter_map(|(of_dof, step)| of_dof.first().map(|a| (a, *step)))
        .filter(|(a, step)| a.delay.is_some_and(|d| d.is_clear(8.0, (1.25 * step).max(0.15))))
        .map(|(a, _)| a)
        .collect();
    if late.is_empty() {
        return Vec::new();
    }
    let says = |a: &&Answer| {
        let d = a.delay.unwrap_or(lag::Lag { seconds: 0.0, std: 0.0, certainty: 0.0 });
        format!(
            "{} answers {} {} ± {} s {}",
            a.velocity,
            a.channel,
            short(d.seconds.abs(), 3),
            short(2.0 * d.std, 2),
            if d.seconds > 0.0 { "late" } else { "early" }
        )
    };
    let early = late.iter().all(|a| a.delay.is_some_and(|d| d.seconds < 0.0));
    let cause = if early {
        "the commands are logged later than they act"
    } else {
        "a delay of the commands, or a lag of the thrusters of about this size"
    };
    let text = format!("{}: {cause}", late.iter().map(says).collect::<Vec<_>>().join(", "));
    let channels: Vec<&str> = late.iter().map(|a| a.channel.as_str()).collect();
    let mut found = Found::new(&codes::COMMAND_DELAY, &channels, text);
    for a in &late {
        found = found.fault(FaultKind::Delay, &a.channel, a.delay.map_or(0.0, |d| d.seconds));
    }
    vec![found]
}

/// Whether a term is a command's.
pub fn is_command(term: &Term) -> bool {
    matches!(term, Term::Command(_))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{Run, Signal};

    /// The sign of the gain of yaw that is told; ṙ is the slope of `rate`.
    fn told(rate: impl Fn(f64) -> f64, moment: impl Fn(f64) -> f64) -> Option<f64> {
        let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        let mut run = Run::default();
        for (name, of) in [("r", &rate as &dyn Fn(f64) -> f64), ("tau_r", &moment)] {
            run.signals.insert(name.into(), Signal::new(time.clone(), time.iter().map(|t| of(*t)).collect::<Vec<_>>()));
        }
        let answers = measure(&Balance::new(&run, Dof::Yaw).unwrap());
        answers.first().map(|a| a.gain.signum())
    }

    /// A swing of 2 s is as well a push with it as one against it that is half a swing late: its sign is not told. That of a
    /// swing that is not regular is, for a command that acts at once, and late.
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
    fn commands_that_accuse_several_velocities_together_accuse_one_frame() {
        let answer = |channel: &str, velocity: &str| Answer {
            channel: channel.into(),
            velocity: velocity.into(),
            gain: -1.0,
            std: 0.01,
            delay: None,
            joined: false,
        };
        let told = |answers: &[Answer]| -> Vec<String> {
            let found = judge_signs(&Run::default(), answers, &[]);
            found.into_iter().map(|f| f.text).collect()
        };
        let both = told(&[answer("tau_v", "v"), answer("tau_w", "w")]);
        assert!(
            both.len() == 2 && both.iter().all(|text| text.contains("v and w are pushed the wrong way together")),
            "{both:?}"
        );
        let forward = told(&[answer("tau_u", "u"), answer("tau_w", "w")]);
        assert!(forward.iter().all(|text| text.contains("set columns.tau_")), "{forward:?}");
        assert!(told(&[answer("tau_w", "w")])[0].contains("set columns.tau_w.sign = -1"));
    }

    #[test]
    fn the_sign_of_a_force_is_turned_where_it_comes_from() {
        let mut run = Run::default();
        run.signals.insert("V1".into(), Signal::new(vec![0.0, 1.0].into(), vec![0.0, 1.0]));
        assert_eq!(turned("F1", &run), "turn its command, columns.V1 = { name = \"its column\", sign = -1 }");
        assert_eq!(turned("F2", &run), "set columns.F2.sign = -1", "a force that is logged itself");
        assert_eq!(turned("tau_u", &run), "set columns.tau_u.sign = -1");
    }
}
