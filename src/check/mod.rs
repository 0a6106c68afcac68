//! Checks of a log: rates, clocks, units, signs, frames, delays, and whether it can show what is asked.
//!
//! [`run()`] checks one run, [`log()`] a log together with the findings of reading it. Each check
//! is a small file with its equation in the heading: `measure` computes figures with standard
//! deviations, and `judge` turns them into findings. Nothing in the log is changed, dropped or
//! rescaled. Two channels are compared only if both move clearly above their noise; the light stays
//! off if the data cannot answer the question.

pub mod attitude;
pub mod balance;
pub mod change;
pub mod clock;
pub mod closed_loop;
pub mod codes;
pub mod coming_round;
pub mod commands;
pub mod coupling;
pub mod dead_rate;
pub mod depth;
pub mod excitation;
pub mod factor;
pub mod feedback;
pub mod fins;
pub mod fit;
pub mod geodetic;
pub mod lag;
pub mod limits;
pub mod motion;
pub mod options;
pub mod path;
pub mod pose_velocity;
pub mod rates;
pub mod report;
pub mod samples;
pub mod smoothed;
pub mod together;
pub mod values;
pub mod velocity_sign;
pub mod wiring;

pub use options::{CheckOptions, Geodetic};
pub use report::{Agreement, Answer, CheckReport, FaultKind, Found, Light, LogFault, Topic, TopicLight};

use balance::Balance;

use crate::finding::{Code, Finding, Severity};
use crate::frame::Dof;
use crate::log::LogFile;
use crate::log::check::far;
use crate::log::codes as reading;
use crate::run::Run;

/// Checks one run.
pub fn run(run: &Run, options: &CheckOptions) -> CheckReport {
    let mut found = clock::check(run);
    let rates = rates::measure(run);
    found.extend(rates::judge(&rates));
    found.extend(values::check(run));
    found.extend(motion::judge(run));
    found.extend(limits::judge(run, &options.thrusters));
    found.extend(closed_loop::judge_modes(run));
    // bad samples must not affect the checks of units, signs, delays and excitation
    let run = &without_bad_samples(run);
    let mended = coming_round::mended(run);
    found.extend(mended.iter().map(|(of_unit, _)| of_unit.clone()));
    let run = mended.as_ref().map_or(run, |(_, mended)| mended);
    let steps = |channel: &str| rates.iter().find(|r| r.channel == channel).map_or(0.0, |r| 1.0 / r.rate_hz);

    let geodetic = Geodetic::of(run, options);
    let mut agreements = attitude::measure(run);
    found.extend(attitude::judge(&agreements, steps));
    found.extend(smoothed::judge(&smoothed::measure(run, &agreements)));
    dead_rates(run, &mut found);
    let position = [&geodetic.north, &geodetic.east].map(|n| n.clone().unwrap_or_default());
    let path = path::measure(run, position.each_ref().map(String::as_str));
    if let Some(path) = path.filter(|_| !options.through_water) {
        let said = path::judge(&path, steps).into_iter();
        found.extend(said.filter(|f| !options.arm_is_known || *f.code != codes::LEVER_ARM));
        agreements.extend(path.agreements);
    }
    let degrees = geodetic::measure(run, &geodetic);
    found.extend(geodetic::judge(&degrees));
    explained_by_position(&mut found, &degrees);
    if !degrees.is_empty() && !geodetic.guessed.is_empty() {
        let names: Vec<&str> = geodetic.guessed.iter().map(String::as_str).collect();
        let text = format!(
            "the columns {} were guessed from their names; name them in the options to be sure",
            names.join(", ")
        );
        found.push(Found::new(&codes::GUESSED, &names, text));
    }
    agreements.extend(degrees);
    let sinking = depth::measure(run);
    agreements.extend(sinking.clone());

    let balances: Vec<Balance> = Dof::ALL.into_iter().filter_map(|dof| Balance::new(run, dof)).collect();
    let answers: Vec<(Vec<Answer>, f64)> = balances.iter().map(|b| (commands::measure(b), b.step())).collect();
    found.extend(commands::judge_delays(run, &answers, options.lag_is_known));
    let mut answers: Vec<Answer> = answers.into_iter().flat_map(|(a, _)| a).collect();
    let loops = closed_loop::measure(run);
    let mut closed = closed_loop::judge(&loops);
    closed.extend(feedback::judge(run, &closed));
    let signs_of_commands = open_loop_signs(run, &answers, &closed, options);
    found.extend(signs(run, &signs_of_commands, &balances, &agreements));
    if let Some(sinking) = sinking {
        let mut of_heave = signs_of_commands.iter().filter(|(a, _)| a.velocity == "w").map(|(_, right)| *right);
        let first = of_heave.next();
        let pushed_right = first.filter(|first| of_heave.all(|other| other == *first));
        found.extend(depth::judge(&sinking, pushed_right, steps));
    }
    let gains: Vec<fins::Gain> = fins::measure(run).into_iter().filter(|g| !is_closed(&closed, g.channel)).collect();
    found.extend(fins::judge(&gains));
    answers.extend(fins::answers(&gains));
    let of = |dof: Dof| balances.iter().find(|b| b.dof == dof);
    if let (Some(surge), Some(sway)) = (of(Dof::Surge), of(Dof::Sway)) {
        let ratios = coupling::measure(surge, sway);
        found.extend(coupling::judge(&ratios));
        agreements.extend(ratios);
    }
    let excitation: Vec<_> = Dof::ALL.into_iter().filter_map(|dof| excitation::of_run(run, dof)).collect();
    found.extend(excitation::judge(run, &excitation, options));
    found.extend(closed);

    let examined = |topic: Topic| match topic {
        Topic::Consistency => !agreements.is_empty(),
        Topic::Commands => !answers.is_empty(),
        Topic::Excitation => !excitation.is_empty() || !options.dofs.is_empty(),
        Topic::Loop => !loops.is_empty() || run.signals.contains_key(closed_loop::MODE),
        Topic::Reading => false,
        Topic::Clock | Topic::Sampling | Topic::Values => !rates.is_empty(),
    };
    let lights = Topic::ALL.map(|topic| TopicLight { topic, light: examined(topic).then_some(Light::Green) });
    let mut log_findings: Vec<LogFault> = Vec::new();
    for fault in found.iter().flat_map(|f| &f.faults) {
        // two checks may find the same fault
        if !log_findings.iter().any(|l| (l.kind, &l.channel) == (fault.kind, &fault.channel)) {
            log_findings.push(fault.clone());
        }
    }
    let findings = found.into_iter().map(|f| in_words(f, &run.name)).collect();
    let (run, lights) = (run.name.clone(), lights.to_vec());
    let mut report = CheckReport { run, lights, findings, log_findings, rates, agreements, answers, excitation, loops };
    report.light_up();
    report
}

/// Checks the placement of the thrusters of a vehicle: the total forces and moments of the thrusters
/// as placed, which `run` holds, are compared with the motion.
pub fn placement(run: &Run, dofs: &[Dof]) -> Vec<Finding> {
    let sound = without_bad_samples(run);
    let balances: Vec<Balance> = dofs.iter().filter_map(|dof| Balance::new(&sound, *dof)).collect();
    let mut agreements = attitude::measure(&sound);
    agreements.extend(path::measure(&sound, ["x", "y"]).into_iter().flat_map(|path| path.agreements));
    agreements.extend(depth::measure(&sound));
    let holds = |dof: Dof| velocity_sign::holds(dof, &agreements, &balances);
    commands::judge_placement(&sound, dofs, holds).into_iter().map(|f| in_words(f, &run.name)).collect()
}

/// Returns the answers to commands that no controller moves, and whether each has the right sign: the gain of a controller
/// determines the sign of the relation between its command and the motion.
fn open_loop_signs<'a>(
    run: &Run,
    answers: &'a [Answer],
    closed: &[Found],
    options: &CheckOptions,
) -> Vec<(&'a Answer, bool)> {
    let mut signs = commands::signs(answers, &options.thrusters);
    signs.retain(|(a, _)| !is_closed(closed, &commands::as_logged(&a.channel, run)) && !is_closed(closed, &a.velocity));
    signs
}

/// Returns findings for commands with a wrong sign, or for the velocities if all thrusters indicate that.
fn signs(run: &Run, signs: &[(&Answer, bool)], balances: &[Balance], agreements: &[Agreement]) -> Vec<Found> {
    let by_dof = commands::by_dof(signs);
    let has_thrusters = run.signals.keys().any(|name| rates::number_of(name).is_some());
    let holds = |dof: Dof| velocity_sign::holds(dof, agreements, balances);
    match velocity_sign::instead(&by_dof, holds).filter(|_| has_thrusters) {
        Some(instead) => vec![velocity_sign::judge(&instead, &by_dof)],
        None => commands::judge_signs(run, signs),
    }
}

/// Whether a controller was found in this channel.
fn is_closed(closed: &[Found], channel: &str) -> bool {
    closed.iter().any(|f| f.channels.iter().any(|other| other == channel))
}

/// Returns the run without sentinels, outliers and values above the plausible limit; the checks of
/// reading report these.
fn without_bad_samples(run: &Run) -> Run {
    let mut sound = run.clone();
    for (name, signal) in &mut sound.signals {
        if let Some(left) = far::without(name, signal) {
            *signal = left;
        }
    }
    sound
}

/// Adds findings of dead rates, and removes those that the noise of such a channel caused.
fn dead_rates(run: &Run, found: &mut Vec<Found>) {
    let dead = dead_rate::judge(run);
    let is_dead = |f: &Found| dead.iter().any(|d| d.channels.first() == f.channels.first());
    found.retain(|f| ![&codes::UNIT, &codes::SIGN, &codes::SCALE, &codes::LATENCY].contains(&f.code) || !is_dead(f));
    found.extend(dead);
}

/// Removes findings about the scale of a velocity if degrees of latitude and longitude show that
/// the scale is that of the position.
fn explained_by_position(found: &mut Vec<Found>, degrees: &[Agreement]) {
    let position = |factor: f64| degrees.iter().any(|d| (factor * d.factor - 1.0).abs() < 2.0 * geodetic::TOLERANCE);
    let wrong = found.iter().any(|f| *f.code == codes::POSITION_SCALE);
    found.retain(|f| !(wrong && *f.code == codes::SCALE && f.faults.iter().all(|fault| position(fault.factor))));
}

/// Checks a log that was read, together with the findings of reading it.
pub fn log(log: &LogFile, options: &CheckOptions) -> CheckReport {
    // messages name the file; a log that stands alone is no run of a campaign
    let as_run = Run { name: log.file.clone(), gaps: log.gaps.clone(), signals: log.signals.clone(), ..Run::default() };
    let mut report = run(&as_run, options).after_reading(log.warnings.iter().chain(&log.notes).cloned());
    for finding in &mut report.findings {
        finding.file.get_or_insert_with(|| log.file.clone());
        finding.run = None;
    }
    report
}

fn in_words(found: Found, run: &str) -> Finding {
    let column = if let [only] = &found.channels[..] { Some(only.clone()) } else { None };
    let message = if run.is_empty() { found.text } else { format!("{run}: {}", found.text) };
    let finding = Finding { column, ..Finding::new(found.code, message) };
    if run.is_empty() { finding } else { finding.of_run(run) }
}

/// Light of any finding.
pub fn light_of(finding: &Finding) -> Light {
    place(finding).1
}

/// Topic and light of any finding, of this module or of reading.
fn place(finding: &Finding) -> (Topic, Light) {
    if let Some(place) = codes::place(finding.code) {
        return place;
    }
    let is = |list: &[Code]| list.iter().any(|c| c.code == finding.code);
    if finding.severity == Severity::Error {
        (Topic::Reading, Light::Red)
    } else if is(&[reading::UNIT, reading::FRAME]) {
        (Topic::Consistency, Light::Red)
    } else if is(&[reading::NON_PHYSICAL]) {
        (Topic::Commands, Light::Red)
    } else if is(&[reading::NO_COMMAND]) {
        (Topic::Commands, Light::Amber)
    } else if is(&[reading::GAP]) {
        (Topic::Clock, Light::Amber)
    } else if is(&[reading::TIME_UNIT]) {
        (Topic::Clock, Light::Red)
    } else if is(&[reading::HELD]) {
        (Topic::Sampling, Light::Amber)
    } else if is(&[reading::SENTINEL, reading::MAGNITUDE]) {
        (Topic::Values, Light::Red)
    } else if is(&[reading::OUTLIER, reading::CONSTANT, reading::SATURATION]) {
        (Topic::Values, Light::Amber)
    } else if finding.severity == Severity::Note {
        (Topic::Reading, Light::Green)
    } else {
        (Topic::Reading, Light::Amber)
    }
}

impl CheckReport {
    /// Returns the report with the findings of reading in front. Held samples that both found are
    /// kept once; wrong signs of commands are removed if the quick fit of reading found a negative
    /// inertia or drag, because they follow from the same fault.
    #[must_use]
    pub fn after_reading(mut self, found: impl IntoIterator<Item = Finding>) -> CheckReport {
        let held = self.findings.iter().any(|f| f.code == codes::HELD.code);
        let of_reading: Vec<Finding> = found.into_iter().filter(|f| !(held && f.code == reading::HELD.code)).collect();
        let is = |list: &[Code]| of_reading.iter().any(|f| list.iter().any(|c| c.code == f.code));
        let wrong_sign = is(&[reading::NON_PHYSICAL]);
        self.findings.retain(|f| !(wrong_sign && f.code == codes::COMMAND_SIGN.code));
        for light in self.lights.iter_mut().filter(|l| l.topic == Topic::Reading) {
            light.light = Some(Light::Green);
        }
        self.findings = of_reading.into_iter().chain(self.findings).collect();
        self.light_up();
        self
    }

    /// Returns the report with further findings.
    #[must_use]
    pub fn with(mut self, found: impl IntoIterator<Item = Finding>) -> CheckReport {
        self.findings.extend(found);
        self.light_up();
        self
    }

    /// Sets each light to the worst of its findings.
    fn light_up(&mut self) {
        for finding in &self.findings {
            let (topic, light) = place(finding);
            for l in self.lights.iter_mut().filter(|l| l.topic == topic) {
                l.light = Some(l.light.map_or(light, |old| old.max(light)));
            }
        }
    }
}
