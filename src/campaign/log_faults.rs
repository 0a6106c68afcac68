//! Faults of the log that look like missing physics: they are reported and mended before the
//! search.
//!
//! ```text
//! unit, sign      channel → channel/f
//! frame           ψ → −ψ, y → −y (an axis counts the wrong way);  ψ → ψ + π;
//!                 (x, y) → (y, x);  (u, v) → (v, u)
//! delay           channel(t) → channel(t + T)
//! ```
//!
//! The evidence is the checks of each run ([`crate::check`]). A fault is accepted if at least two
//! runs, and more than half of those that show anything about the channel, agree on it. A wrong
//! sign of a command is not accepted if any run clearly responds to the command with the right
//! sign: a sign that depends on the run is no fault of the log. If two channels contradict each
//! other, a third one decides which is wrong: a yaw rate that responds to its moment as it should
//! is right, so that the heading counts the wrong way. A vehicle that is mirrored as a whole moves
//! like its mirror image, so that one correction serves both a log in forward-port-up axes and a
//! heading of east-north-up. A command that comes late is physics, not a fault.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

use rayon::prelude::*;

use super::load::Campaign;
use crate::chain::{alters, memory_count};
use crate::check::commands::{self, MISPLACED};
use crate::check::{self, CheckOptions, CheckReport, FaultKind};
use crate::discover::LogFinding;
use crate::effects::{Effect, Place, catalogue};
use crate::frame::Dof;
use crate::model::{Model, places_of};
use crate::run::{Role, Run, Signal, is_command, thruster_force};
use crate::symbolic::Graph;

/// Ratio from which a factor counts as a wrong unit: a factor nearer to 1 may be an effect and is
/// left to the search.
const WRONG_UNIT: f64 = 5.0;
/// Largest difference between an angle and the one that it is taken for, rad.
const NEAR: f64 = 0.25;
/// Shortest latency that is mended, s.
const LATE: f64 = 0.05;

/// A fault of the log.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Fault {
    /// A channel in another unit, or with the opposite sign; `factor` is the logged value over the
    /// true one.
    Factor { channel: String, factor: f64 },
    /// The heading counts the wrong way for the body axes.
    Mirrored,
    /// Heading and velocity differ by half a turn.
    Turned,
    /// North and east are exchanged.
    PositionSwapped,
    /// Surge and sway velocity are exchanged, with their forces or without.
    VelocitySwapped { forces: bool },
    /// A sensor that comes later than the others, by so many seconds.
    Late { channel: String, seconds: f64 },
}

/// Returns the reports of the checks of each run, for the degrees of freedom and the velocity
/// reference of the model.
pub(super) fn reports(runs: &[Run], model: &Model) -> Vec<CheckReport> {
    let (dofs, through_water) = (model.dofs.clone(), model.through_water);
    let options = CheckOptions { dofs, through_water, ..CheckOptions::default() };
    runs.par_iter().map(|run| check::run(run, &options)).collect()
}

/// Returns the faults on which the runs agree.
///
/// A latency for which the model has a term is no fault.
pub(super) fn faults(runs: &[Run], model: &Model) -> Vec<Fault> {
    let reports = reports(runs, model);
    let mut found = frames(&reports);
    let framed = !found.is_empty();
    let votes = factors(&reports);
    let wrong = |channel: &str| votes.iter().any(|(name, f)| name == channel && *f < 0.0);
    for (channel, factor) in &votes {
        // a rate that contradicts both its angle and its moment is wrong itself
        let own_rate = Dof::ALL.iter().find(|d| d.force() == channel).map(|d| d.velocity());
        let blamed = own_rate.is_some_and(|rate| *factor < 0.0 && wrong(rate));
        // signs that a wrong frame causes are mended with the frame
        let reflected = framed && (-1.5..0.0).contains(factor);
        if !blamed && !reflected {
            found.push(Fault::Factor { channel: channel.clone(), factor: *factor });
        }
    }
    let known = model.terms.iter().flat_map(|t| made_late(t.effect.as_ref(), t.place, model));
    let known: Vec<&str> = known.collect();
    found.extend(delays(&reports).into_iter().filter(|fault| !fault.is_late_in(&known)));
    found
}

/// Describes the degrees of freedom that the thrusters, as they are placed, push the wrong way in
/// most of the runs of the fit that show it.
pub(super) fn misplaced(campaign: &Campaign) -> Option<String> {
    let runs = campaign.motion(Some(Role::Train));
    let made = |run: &&Run| run.signals.keys().any(|name| check::rates::number_of(name).is_some());
    let wrong = |dof: &Dof| {
        let answers = runs.iter().filter(made).filter_map(|run| commands::answer_to_thrusters(run, *dof));
        let (wrong, right): (Vec<_>, Vec<_>) = answers.partition(|answer| answer.gain < 0.0);
        wrong.len() > right.len()
    };
    let dofs: Vec<String> = campaign.model.dofs.iter().filter(|dof| wrong(dof)).map(ToString::to_string).collect();
    let said = || format!("the thrusters, placed as stated, push {} the wrong way: {MISPLACED}", dofs.join(", "));
    (!campaign.file.thrusters.is_empty() && !dofs.is_empty()).then(said)
}

/// Returns the wrong units and signs, as channel and factor.
fn factors(reports: &[CheckReport]) -> Vec<(String, f64)> {
    let mut seen: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    // a force that is calculated from thrusters is not logged: its fault is a fault of theirs, and
    // has their name
    let derived = |r: &CheckReport, channel: &str| {
        channel.starts_with("tau_") && r.rates.iter().any(|rate| rate.channel == thruster_force(0))
    };
    let told = reports.iter().flat_map(|r| r.log_findings.iter().filter(|fault| !derived(r, &fault.channel)));
    for fault in told {
        let unit = fault.kind == FaultKind::Unit && !(1.0 / WRONG_UNIT..=WRONG_UNIT).contains(&fault.factor.abs());
        if unit || fault.kind == FaultKind::Sign {
            seen.entry(&fault.channel).or_default().push(fault.factor);
        }
    }
    // a unit or a sign is wrong in every run: a run that tests the channel and finds no fault
    // speaks for the channel
    let judged = |channel: &str| {
        let asked = |r: &&CheckReport| {
            let compared = |a: &check::Agreement| a.channel == channel || a.against == format!("d({channel})/dt");
            let known = r.agreements.iter().any(compared) || r.answers.iter().any(|a| a.channel == channel);
            known || r.log_findings.iter().any(|fault| fault.channel == channel)
        };
        reports.iter().filter(asked).count()
    };
    // which sign of a voltage is right is not known here
    let answers = || reports.iter().flat_map(|r| &r.answers).filter(|a| a.channel.starts_with("tau_") && a.gain > 0.0);
    let answered = |channel: &str| answers().any(|a| a.channel == channel);
    let agreed = |(channel, factors): (&str, Vec<f64>)| {
        let alike = |middle: f64, f: f64| (f / middle - 1.0).abs() < 0.1;
        let most = 2 * factors.len() > judged(channel);
        agreed(factors, alike)
            .filter(|f| most && (*f > 0.0 || !answered(channel)))
            .map(|factor| (channel.to_string(), factor))
    };
    seen.into_iter().filter_map(agreed).collect()
}

/// Returns the median, if at least two values and more than half of all are like it: a single run
/// may mislead.
fn agreed(mut values: Vec<f64>, alike: impl Fn(f64, f64) -> bool) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = *values.get(values.len() / 2)?;
    let count = values.iter().filter(|v| alike(middle, **v)).count();
    (count >= 2 && 2 * count > values.len()).then_some(middle)
}

/// Returns the wrong frame that one run shows.
fn frame_of(report: &CheckReport) -> Option<Fault> {
    let of = |channel: &str| report.agreements.iter().find(|a| a.channel == channel);
    let angle = |channel: &str| of(channel).and_then(|a| a.angle);
    let near = |angle: Option<f64>, target: f64| angle.is_some_and(|a| ((a - target).cos()) > NEAR.cos());
    let turned_back = of("r").is_some_and(|a| (a.factor + 1.0).abs() < 0.35);
    let answers = |dof: Dof| report.answers.iter().any(|a| a.channel == dof.force() && a.gain > 0.0);
    let mirrored = |fault: &&check::LogFault| fault.kind == FaultKind::Frame && (fault.factor.abs() - PI).abs() < 1e-9;
    let told = report.log_findings.iter().any(|fault| mirrored(&fault));
    let (ahead, abeam) = (near(angle("u"), 0.5 * PI), near(angle("v"), -0.5 * PI));
    // exchanged positions look the same, but with the heading mirrored
    if !told && (ahead || abeam) && (ahead || angle("u").is_none()) && (abeam || angle("v").is_none()) {
        return Some(Fault::VelocitySwapped { forces: answers(Dof::Surge) || answers(Dof::Sway) });
    }
    let half_turn = near(angle("u"), PI) && angle("v").is_none_or(|v| near(Some(v), PI));
    match (told, turned_back) {
        (_, true) if answers(Dof::Yaw) || told => Some(Fault::Mirrored),
        (true, false) if half_turn => Some(Fault::Turned),
        (true, false) if of("r").is_some() => Some(Fault::PositionSwapped),
        _ => None,
    }
}

/// Returns the wrong frame on which the runs agree, if any.
fn frames(reports: &[CheckReport]) -> Vec<Fault> {
    let told: Vec<Fault> = reports.iter().filter_map(frame_of).collect();
    let count = |fault: &Fault| told.iter().filter(|t| *t == fault).count();
    let Some(most) = told.iter().max_by_key(|fault| count(fault)) else { return Vec::new() };
    // a run that compares the heading with its rate can show a mirrored heading, one that compares
    // velocity with position the other axes; on a straight path with one velocity a wrong axis
    // looks like a wrong heading
    let able = |r: &&CheckReport| {
        let compared = r.agreements.iter().filter(|a| a.angle.is_some()).count();
        match most {
            Fault::Mirrored => r.agreements.iter().any(|a| a.channel == "r"),
            Fault::VelocitySwapped { .. } => compared > 0,
            _ => compared > 1,
        }
    };
    let witnesses = reports.iter().filter(able).count();
    // with one velocity alone the heading could be off by a right angle instead
    let turned = |channel: &str| {
        let angles = reports.iter().flat_map(|r| &r.agreements).filter(|a| a.channel == channel);
        angles.filter_map(|a| a.angle).any(|a| (a.abs() - 0.5 * PI).abs() < NEAR)
    };
    let both = !matches!(most, Fault::VelocitySwapped { .. }) || (turned("u") && turned("v"));
    if both && count(most) >= 2 && 2 * count(most) > witnesses { vec![most.clone()] } else { Vec::new() }
}

/// Returns the channels that an effect makes late: those of a sensor with memory.
fn made_late(effect: &dyn Effect, place: Place, model: &Model) -> Vec<&'static str> {
    let remembers = memory_count(&Graph::new(), model, effect, place) > 0;
    if remembers { alters(effect, place, model) } else { Vec::new() }
}

/// Returns the sensors that come later than the others. A command that comes late is not among
/// them.
fn delays(reports: &[CheckReport]) -> Vec<Fault> {
    let mut seen: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for fault in reports.iter().flat_map(|r| &r.log_findings) {
        if fault.kind == FaultKind::Delay && !is_command(&fault.channel) {
            seen.entry(&fault.channel).or_default().push(fault.factor);
        }
    }
    let agreed = |(channel, seconds): (&str, Vec<f64>)| {
        let alike = |middle: f64, s: f64| (s - middle).abs() < (0.3 * middle.abs()).max(LATE);
        // a latency is there in every run: one that only some runs show may be a lever arm
        let most = 2 * seconds.len() > reports.len();
        let seconds = agreed(seconds, alike).filter(|s| most && s.abs() > LATE)?;
        Some(Fault::Late { channel: channel.to_string(), seconds })
    };
    seen.into_iter().filter_map(agreed).collect()
}

impl Fault {
    /// Whether it is a latency that an effect of the catalogue describes, and that the likelihood
    /// can estimate.
    pub fn has_name(&self, model: &Model) -> bool {
        let of_effect = |effect: &Arc<dyn Effect>| -> Vec<&str> {
            let places = places_of(effect.as_ref(), &model.dofs).into_iter();
            places.flat_map(|place| made_late(effect.as_ref(), place, model)).collect()
        };
        catalogue(model.coriolis).iter().any(|effect| self.is_late_in(&of_effect(effect)))
    }

    /// Whether it is a latency of one of these channels.
    fn is_late_in(&self, channels: &[&str]) -> bool {
        matches!(self, Fault::Late { channel, .. } if channels.contains(&channel.as_str()))
    }

    /// Returns how much later than the other sensors a gyro comes, s; `None` for any other fault.
    pub fn latency_of_gyro(&self) -> Option<f64> {
        match self {
            Fault::Late { channel, seconds } if ["p", "q", "r"].contains(&channel.as_str()) => Some(*seconds),
            _ => None,
        }
    }

    /// Returns the fault as entries of the discovery's result, one per channel.
    pub fn findings(&self) -> Vec<LogFinding> {
        let of = |kind: &str, channel: &str, factor: f64| LogFinding {
            kind: kind.into(),
            channel: channel.into(),
            factor,
            message: self.to_string(),
        };
        match self {
            Fault::Factor { channel, factor } => {
                let kind = if *factor < 0.0 && *factor > -1.5 { "sign" } else { "unit" };
                vec![of(kind, channel, *factor)]
            }
            Fault::Mirrored => vec![of("frame", "psi", -1.0)],
            Fault::Turned => vec![of("frame", "psi", PI)],
            Fault::PositionSwapped => vec![of("frame", "x", 0.5 * PI), of("frame", "y", 0.5 * PI)],
            Fault::VelocitySwapped { .. } => vec![of("frame", "u", 0.5 * PI), of("frame", "v", -0.5 * PI)],
            Fault::Late { channel, seconds } => vec![of("delay", channel, *seconds)],
        }
    }

    /// Mends the fault in the runs; the files stay unchanged.
    pub fn mend(&self, runs: &mut [Run]) {
        for run in runs {
            let mut scale = |channel: &str, f: &dyn Fn(f64) -> f64| {
                if let Some(signal) = run.signals.get_mut(channel) {
                    let values: Vec<f64> = signal.values().iter().map(|x| f(*x)).collect();
                    *signal = Signal::new(signal.shared_time().clone(), values);
                }
            };
            match self {
                Fault::Factor { channel, factor } => scale(channel, &|x| x / factor),
                Fault::Mirrored => {
                    scale("psi", &|x| -x);
                    scale("y", &|x| -x);
                }
                Fault::Turned => scale("psi", &|x| x + PI),
                Fault::PositionSwapped => swap(run, "x", "y"),
                Fault::VelocitySwapped { forces } => {
                    swap(run, "u", "v");
                    if *forces {
                        swap(run, "tau_u", "tau_v");
                    }
                }
                Fault::Late { channel, seconds } => {
                    let both: &[&str] = if ["x", "y"].contains(&channel.as_str()) { &["x", "y"] } else { &[channel] };
                    both.iter().for_each(|name| earlier(run, name, *seconds));
                }
            }
        }
    }
}

fn swap(run: &mut Run, a: &str, b: &str) {
    if let (Some(x), Some(y)) = (run.signals.remove(a), run.signals.remove(b)) {
        run.signals.insert(a.into(), y);
        run.signals.insert(b.into(), x);
    }
}

fn earlier(run: &mut Run, channel: &str, seconds: f64) {
    if let Some(signal) = run.signals.get_mut(channel) {
        let time: Vec<f64> = signal.time().iter().map(|t| t - seconds).collect();
        *signal = Signal::new(time.into(), signal.values().to_vec());
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Fault::Factor { channel, factor } if (-1.5..0.0).contains(factor) => {
                write!(f, "{channel} is logged with the opposite sign; set columns.{channel}.sign = -1")
            }
            Fault::Factor { channel, factor } if factor.abs() < 1.0 => {
                let factor = 1.0 / factor;
                write!(f, "{channel} is logged in a unit {factor:.4} times too coarse; set columns.{channel}.unit")
            }
            Fault::Factor { channel, factor } => {
                write!(f, "{channel} is logged in a unit {factor:.4} times too fine; set columns.{channel}.unit")
            }
            Fault::Mirrored => f.write_str(
                "psi has the opposite sign convention to the body axes: heading of east-north-up, or body axes \
                 forward-port-up; set earth_frame or body_frame",
            ),
            Fault::Turned => f.write_str("psi is off by 180°, or u and v both point backwards"),
            Fault::PositionSwapped => {
                f.write_str("x and y are exchanged (east-north-up instead of north-east-down); set earth_frame")
            }
            Fault::VelocitySwapped { forces } => write!(
                f,
                "u and v are exchanged{}; correct their names in [log] columns",
                if *forces { ", with their forces" } else { "" }
            ),
            Fault::Late { channel, seconds } => {
                write!(f, "{channel} lags the other sensors by {seconds:.3} s; bring it to their clock")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_have_to_agree() {
        let alike = |a: f64, b: f64| (a / b - 1.0).abs() < 0.1;
        assert_eq!(agreed(vec![57.0, 57.5, 3.0], alike), Some(57.0));
        assert_eq!(agreed(vec![57.0], alike), None);
        assert_eq!(agreed(vec![57.0, 57.0, 3.0, 2.0], alike), None);
    }

    /// A run that compared the sway velocity with the position, and found the wrong sign or the
    /// right one.
    fn report(sign: bool) -> CheckReport {
        let fault = check::LogFault { kind: FaultKind::Sign, channel: "v".into(), factor: -1.0 };
        let factor = if sign { -1.0 } else { 1.0 };
        let known = check::Agreement {
            channel: "v".into(),
            against: "position".into(),
            factor,
            std: 0.1,
            angle: None,
            lag: None,
        };
        CheckReport {
            run: "run".into(),
            lights: Vec::new(),
            findings: Vec::new(),
            log_findings: if sign { vec![fault] } else { Vec::new() },
            rates: Vec::new(),
            agreements: vec![known],
            answers: Vec::new(),
            excitation: Vec::new(),
            loops: Vec::new(),
        }
    }

    #[test]
    fn a_sign_needs_most_of_the_runs_that_know_of_the_channel() {
        let with = |signs: usize| -> Vec<CheckReport> { (0..5).map(|k| report(k < signs)).collect() };
        assert_eq!(factors(&with(2)), vec![], "two of five, as a lever arm makes them");
        assert_eq!(factors(&with(3)), vec![("v".to_string(), -1.0)]);
        let rate = check::rates::ChannelRate {
            channel: "F1".into(),
            rate_hz: 10.0,
            logged_hz: 10.0,
            samples: 100,
            gaps: 0,
            held: 1.0,
            jitter: 0.0,
        };
        let of_force = |thrusters: bool| {
            let mut report = report(true);
            report.log_findings[0].channel = "tau_v".into();
            report.rates = if thrusters { vec![rate.clone()] } else { Vec::new() };
            vec![report; 2]
        };
        assert_eq!(factors(&of_force(false)), vec![("tau_v".to_string(), -1.0)]);
        assert_eq!(factors(&of_force(true)), vec![], "thrusters make it");
        let mut answers = of_force(false);
        answers.push(CheckReport {
            log_findings: Vec::new(),
            answers: vec![check::Answer {
                channel: "tau_v".into(),
                velocity: "v".into(),
                gain: 0.1,
                std: 0.01,
                joined: false,
                delay: None,
            }],
            ..report(false)
        });
        assert_eq!(factors(&answers), vec![], "one run of three answers it as it should");
    }

    #[test]
    fn mending_twice_is_as_before_for_reflections() {
        let time: Arc<[f64]> = vec![0.0, 1.0].into();
        let mut run = Run::default();
        for (k, name) in ["x", "y", "psi", "u", "v"].iter().enumerate() {
            run.signals.insert((*name).into(), Signal::new(time.clone(), vec![k as f64, 1.0]));
        }
        for fault in [Fault::Mirrored, Fault::PositionSwapped, Fault::VelocitySwapped { forces: true }] {
            let mut runs = [run.clone()];
            fault.mend(&mut runs);
            assert_ne!(runs[0].signals, run.signals, "{fault}");
            fault.mend(&mut runs);
            assert_eq!(runs[0].signals, run.signals, "{fault}");
        }
    }
}
