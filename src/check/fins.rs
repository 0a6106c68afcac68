//! Angle of a fin compared with the turn that it causes.
//!
//! ```text
//! Δr = g ∫ u|u| δ dt + drag, Coriolis and a constant        q: g ∫ −u|u| δ dt        g > 0
//! ```
//!
//! A rudder angle is positive if it turns the vehicle to starboard, the angle of a stern plane if
//! it turns the nose down (`rudder_force`). Many logs have the opposite sign: port rudder is often
//! counted positive.
//!
//! The rudder of an autopilot repeats the noise of the gyro, which is also on the left-hand side:
//! if the vehicle moves little, that can give the gain either sign. [`feedback`](super::feedback)
//! reports such a log, and no fin is accused.

use super::balance::{Balance, WINDOW};
use super::codes;
use super::commands::CERTAIN;
use super::report::{Answer, FaultKind, Found};
use crate::effects::id::{self, FinIds};
use crate::frame::Dof;
use crate::log::number::short;
use crate::run::{Run, Signal};

/// Lengths of the windows, relative to the shortest: a ship answers its rudder within half a
/// minute. The length with the most certain gain is used.
const WINDOWS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// Answer of the turn rate to a fin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Channel of the fin's angle.
    pub channel: &'static str,
    /// Degree of freedom that it turns.
    pub turns: Dof,
    /// g, rad/s² per rad at 1 m/s; at the speed of the run if no speed is logged.
    pub value: f64,
    /// Standard deviation of g.
    pub std: f64,
}

impl Gain {
    /// Whether the sign of the fin's angle is certainly opposite to that of the model.
    pub fn is_reversed(&self) -> bool {
        self.value < -CERTAIN * self.std
    }

    /// Whether it certainly has the same sign.
    pub fn is_right(&self) -> bool {
        self.value > CERTAIN * self.std
    }
}

/// Returns the answer to each fin that a run logs.
pub fn measure(run: &Run) -> Vec<Gain> {
    let over = |(turns, channel): (Dof, &'static str), steered: &Run, times: f64| {
        let balance = Balance::over(steered, turns, times * WINDOW)?;
        let fit = balance.fit(0.0)?;
        Some(Gain { channel, turns, value: fit.theta[0], std: fit.std[0] })
    };
    let certain = |gain: &Gain| gain.value.abs() / gain.std;
    let of = |fin: &FinIds| {
        let steered = with_lift(run, fin.turns, fin.channel)?;
        let gains = WINDOWS.into_iter().filter_map(|times| over((fin.turns, fin.channel), &steered, times));
        gains.filter(|gain| gain.std > 0.0).max_by(|a, b| certain(a).total_cmp(&certain(b)))
    };
    id::fins().iter().filter_map(of).collect()
}

/// Returns the degrees of freedom in which fins with a varying angle turn and push: these need no thruster.
pub fn steered(run: &Run) -> Vec<Dof> {
    let varies = |fin: &FinIds| run.signal(fin.channel).is_some_and(Signal::varies);
    id::fins().into_iter().filter(varies).flat_map(|fin| [fin.turns, fin.across]).collect()
}

/// Returns the gains as answers to a command.
pub fn answers(gains: &[Gain]) -> Vec<Answer> {
    let answer = |gain: &Gain| Answer {
        channel: gain.channel.to_string(),
        velocity: gain.turns.velocity().to_string(),
        gain: gain.value,
        std: gain.std,
        delay: None,
        joined: false,
    };
    gains.iter().filter(|gain| gain.is_right() || gain.is_reversed()).map(answer).collect()
}

/// Finds fins whose angle has the wrong sign.
pub fn judge(gains: &[Gain]) -> Vec<Found> {
    let wrong = |gain: &Gain| {
        let Gain { channel, turns, value, std } = *gain;
        let text = format!(
            "{channel} turns the vehicle the wrong way ({} ± {} per unit of {} by u² {channel}): a positive angle must \
             turn it {}; set columns.{channel}.sign = -1",
            short(value, 3),
            short(std, 2),
            turns.velocity(),
            if turns == Dof::Yaw { "to starboard" } else { "nose down" },
        );
        let found = Found::new(&codes::COMMAND_SIGN, &[channel], text);
        found.fault(FaultKind::Sign, channel, -1.0)
    };
    gains.iter().filter(|gain| gain.is_reversed()).map(wrong).collect()
}

/// Returns the run with the moment of the fin, up to a factor, as the only command of the degree of
/// freedom that it turns.
fn with_lift(run: &Run, turns: Dof, channel: &str) -> Option<Run> {
    let angle = run.signal(channel).filter(|s| s.len() > 1)?;
    let speed = run.signal(Dof::Surge.velocity()).filter(|s| !s.is_empty());
    let sign = if turns == Dof::Pitch { -1.0 } else { 1.0 };
    let lift = |(t, delta): (&f64, &f64)| {
        let u = speed.map_or(1.0, |u| u.at(*t));
        sign * u * u.abs() * delta
    };
    let lifts: Vec<f64> = angle.time().iter().zip(angle.values()).map(lift).collect();
    let mut steered = run.clone();
    steered.signals.insert(turns.force().into(), Signal::new(angle.shared_time().clone(), lifts));
    Some(steered)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// A zig-zag under a rudder that turns the vehicle by `gain`.
    fn zigzag(gain: f64) -> Run {
        let (mut psi, mut r, mut delta) = (0.0_f64, 0.0_f64, 0.2_f64);
        let (mut time, mut rows) = (Vec::new(), [Vec::new(), Vec::new()]);
        for k in 0..6000 {
            if psi.abs() > 0.2 {
                delta = -0.2 * (gain * psi).signum();
            }
            if k % 10 == 0 {
                time.push(0.1 * f64::from(k));
                rows[0].push(r + 1e-4 * (f64::from(k) * 1.7).sin());
                rows[1].push(delta);
            }
            // time constant 20 s
            r += 0.1 * (0.05 * (gain * delta - r));
            psi += 0.1 * r;
        }
        let mut run = Run::default();
        let time: std::sync::Arc<[f64]> = time.into();
        for (name, values) in ["r", "rudder"].into_iter().zip(rows) {
            run.signals.insert(name.into(), Signal::new(time.clone(), values));
        }
        run
    }

    /// A vehicle with a time constant of 2 s that an autopilot steers from heading to heading; its
    /// rudder is logged with the opposite sign.
    fn steered_by_autopilot() -> Run {
        let mut noise = Noise::new(7, 1);
        let (mut psi, mut r, mut delta) = (0.0_f64, 0.0_f64, 0.0);
        let (mut time, mut rows) = (Vec::new(), [Vec::new(), Vec::new()]);
        for k in 0..12_000 {
            if k % 10 == 0 {
                let seen = r + 4e-3 * noise.normal();
                let ordered = if (k / 1000) % 2 == 0 { 0.1 } else { -0.1 };
                delta = ordered - psi - 1.5 * seen;
                time.push(0.01 * f64::from(k));
                rows[0].push(seen);
                rows[1].push(-delta);
            }
            r += 0.01 * (0.6 * delta - 0.5 * r);
            psi += 0.01 * r;
        }
        let mut run = Run::default();
        let time: std::sync::Arc<[f64]> = time.into();
        for (name, values) in ["r", "rudder"].into_iter().zip(rows) {
            run.signals.insert(name.into(), Signal::new(time.clone(), values));
        }
        run
    }

    #[test]
    fn a_log_in_which_an_autopilot_steers_accuses_no_rudder() {
        let run = steered_by_autopilot();
        assert!(measure(&run)[0].is_reversed());
        let report = crate::check::run(&run, &crate::check::CheckOptions::default());
        let told: Vec<&str> = report.findings.iter().map(|f| f.code).collect();
        assert!(told.contains(&codes::CLOSED_LOOP.code) && !told.contains(&codes::COMMAND_SIGN.code), "{told:?}");
    }

    #[test]
    fn a_rudder_of_the_other_sign_is_told() {
        assert!(judge(&measure(&zigzag(0.07))).is_empty());
        let told = judge(&measure(&zigzag(-0.07)));
        assert_eq!(told.len(), 1);
        assert!(told[0].text.contains("columns.rudder.sign = -1"), "{}", told[0].text);
        let mut still = zigzag(0.07);
        still.signals.insert("rudder".into(), still.signals["r"].clone());
        let straight =
            Run { signals: still.signals.into_iter().filter(|(name, _)| name == "r").collect(), ..Run::default() };
        assert!(measure(&straight).is_empty() && steered(&straight).is_empty(), "no fin is logged");
        assert_eq!(steered(&zigzag(0.07)), [Dof::Yaw, Dof::Sway]);
    }
}
