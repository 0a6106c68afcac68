//! The verb `check`: tests of logs and campaigns before anything is fitted.

use std::path::Path;

use serde::Serialize;

use super::baseline;
use super::codes;
use super::error::Error;
use super::load::{Campaign, LoadOptions, moves};
use crate::chain::delays_thrust;
use crate::check::closed_loop::Loop;
use crate::check::excitation::Excitation;
use crate::check::rates::{ChannelRate, number_of};
use crate::check::{self, Agreement, Answer, CheckOptions, CheckReport, Light, LogFault, TopicLight};
use crate::effects::Family;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::log::{self, LogError, LogOptions};
use crate::model::Term;
use crate::progress::Count;
use crate::run::{Role, Run, RunKind};
use crate::tank::derived;
use crate::units::Dimension;

/// Result of the checks. Serialises as `hydrosysid check --json`.
#[derive(Debug, Clone, Serialize)]
pub struct Check {
    /// Format of the result: 1.
    pub format: u32,
    /// The worst verdict of `logs` and `warnings`.
    pub verdict: Light,
    /// One entry per log or run.
    pub logs: Vec<CheckedLog>,
    /// Warnings and notes of all logs.
    pub warnings: Vec<Finding>,
    /// Reasons why data is refused.
    pub errors: Vec<Finding>,
}

/// One log or run.
#[derive(Debug, Clone, Serialize)]
pub struct CheckedLog {
    /// File, or name of the run in its campaign.
    pub file: String,
    /// Its own verdict.
    pub verdict: Light,
    /// Kind of experiment, in a campaign.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<RunKind>,
    /// Fit or validation, in a campaign.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub role: Option<Role>,
    /// Number of samples of the longest channel.
    pub rows: usize,
    /// Last minus first time stamp, s.
    pub duration: f64,
    /// Number of stretches without a gap.
    pub segments: usize,
    /// Channels that were kept.
    pub channels: Vec<String>,
    /// One light per topic.
    pub lights: Vec<TopicLight>,
    /// Faults of the log that a model could mistake for an effect.
    pub log_findings: Vec<LogFault>,
    /// Rate of each channel, with its gaps and the number of rows over which a value is held.
    pub rates: Vec<ChannelRate>,
    /// Comparison of sensors with each other: factor, angle and latency.
    pub agreements: Vec<Agreement>,
    /// Response of the motion to the commands: gain and delay.
    pub answers: Vec<Answer>,
    /// What the run can show about each degree of freedom.
    pub excitation: Vec<Excitation>,
    /// Speeds that a controller may hold, and their commands.
    pub loops: Vec<Loop>,
}

/// Checks logs without a campaign; `required` names the columns that must be there.
///
/// # Errors
/// [`Error::Log`] if a file does not exist or an option is invalid; refused data is part of the
/// result.
pub fn check_logs(paths: &[&Path], options: &LogOptions, required: &[&str]) -> Result<Check, Error> {
    let mut check =
        Check { format: 1, verdict: Light::Green, logs: Vec::new(), warnings: Vec::new(), errors: Vec::new() };
    let count = Count::begun("reading logs", paths.len());
    for path in paths {
        let file = path.display().to_string();
        match log::read(path, options, required) {
            Ok(read) => {
                let report = check::log(&read, &CheckOptions::default());
                let (first, last) = (read.time.first().copied(), read.time.last().copied());
                check.warnings.extend(report.findings.iter().cloned());
                check.logs.push(CheckedLog {
                    rows: read.rows,
                    duration: last.zip(first).map_or(0.0, |(b, a)| b - a),
                    segments: read.segments(),
                    channels: read.signals.keys().cloned().collect(),
                    ..CheckedLog::of(file, report)
                });
            }
            Err(LogError::Refused { findings, .. }) => {
                check.logs.push(CheckedLog::refused(file));
                check.errors.extend(findings);
            }
            Err(source) => return Err(Error::Log { run: file, source }),
        }
        count.one_done();
    }
    check.judge();
    Ok(check)
}

/// Checks a campaign with all its logs.
///
/// # Errors
/// [`Error`] if the campaign file is wrong; refused data is part of the result.
pub fn check_campaign(path: &Path, options: LoadOptions) -> Result<Check, Error> {
    let mut check =
        Check { format: 1, verdict: Light::Green, logs: Vec::new(), warnings: Vec::new(), errors: Vec::new() };
    match Campaign::load(path, options) {
        Ok(campaign) => {
            let of_no_run = campaign.findings.iter().filter(|f| f.run.is_none());
            check.warnings.extend(of_no_run.cloned());
            let count = Count::begun("checking runs", campaign.runs.len());
            let of_run = |run| {
                let report = of_run(run, &campaign);
                count.one_done();
                report
            };
            let mut reports: Vec<CheckReport> = campaign.runs.iter().map(of_run).collect();
            check::together::weigh(&mut reports, &campaign.file.thrusters);
            let of_fit: Vec<bool> =
                campaign.runs.iter().map(|run| run.role == Role::Train && moves(run.kind)).collect();
            check::together::share_excitation(&mut reports, &of_fit);
            if let Some(wrong) = wiring(&campaign, &reports) {
                check::together::withdraw_signs(&mut reports);
                check.warnings.push(wrong);
            }
            for (run, report) in campaign.runs.iter().zip(reports) {
                let of_reading = campaign.findings.iter().filter(|f| f.run.as_ref() == Some(&run.name)).cloned();
                let report = report.after_reading(of_reading);
                check.warnings.extend(report.findings.iter().map(|f| f.clone().of_run(&run.name)));
                check.logs.push(CheckedLog {
                    kind: Some(run.kind),
                    role: Some(run.role),
                    rows: run.signals.values().map(|s| s.len()).max().unwrap_or(0),
                    duration: run.span().map_or(0.0, |(a, b)| b - a),
                    segments: run.gaps.len() + 1,
                    channels: logged(run, &campaign).signals.into_keys().collect(),
                    ..CheckedLog::of(run.name.clone(), report)
                });
            }
            let resting: Vec<String> = check
                .warnings
                .iter()
                .filter(|f| f.code == check::codes::AT_REST.code)
                .filter_map(|f| f.run.clone())
                .collect();
            check.warnings.extend(never_shown(&campaign, &check.logs, &resting));
        }
        Err(error) if error.is_wrong_use() => return Err(error),
        Err(error) => {
            check.errors = error.findings().to_vec();
            let mut names: Vec<String> = check.errors.iter().filter_map(|f| f.run.clone()).collect();
            names.dedup();
            check.logs = names.into_iter().map(CheckedLog::refused).collect();
            check.verdict = Light::Red;
        }
    }
    check.judge();
    Ok(check)
}

/// Returns a run without the channels that the campaign has derived, including the forces from
/// commands of thrusters.
fn logged(run: &Run, campaign: &Campaign) -> Run {
    let thrusters = run.signals.keys().any(|name| number_of(name).is_some());
    let made = |name: &str| {
        let force = Dof::ALL.iter().any(|dof| dof.force() == name);
        derived(name) || name.starts_with("nominal_") || force && thrusters && !campaign.file.thrusters.is_empty()
    };
    let mut logged = run.clone();
    logged.signals.retain(|name, _| !made(name));
    logged
}

fn of_run(run: &Run, campaign: &Campaign) -> CheckReport {
    let (thrusters, model) = (campaign.file.thrusters.clone(), driven(campaign));
    let through_water = campaign.model.through_water;
    let lag_is_known = campaign.model.terms.iter().any(|t| delays_thrust(t.effect.as_ref(), t.place, &campaign.model));
    let is_arm = |t: &Term| {
        let lengths = t.parameters.iter().any(|p| campaign.model.parameters[*p].spec.dimension == Dimension::LENGTH);
        lengths && t.effect.about().family == Family::Sensor
    };
    let arm_is_known = campaign.model.terms.iter().any(is_arm);
    let options =
        CheckOptions { thrusters, model, through_water, lag_is_known, arm_is_known, ..CheckOptions::default() };
    let logged = logged(run, campaign);
    let report = check::run(&logged, &options);
    let told = report.findings.iter().any(|f| f.code == check::codes::COMMAND_SIGN.code);
    let steered = |dof: &Dof| {
        let closed = report.findings.iter().filter(|f| f.code == check::codes::CLOSED_LOOP.code);
        closed.filter_map(|f| f.column.as_deref()).any(|c| c == dof.velocity() || number_of(c).is_some())
    };
    let unsteered = campaign.model.dofs.iter().copied().filter(|dof| !steered(dof));
    let placed = unsteered.filter(|dof| !logged.signals.contains_key(dof.force()));
    let placed: Vec<Dof> = placed.collect();
    report.with(if told { Vec::new() } else { check::placement(run, &placed) })
}

/// Returns the finding of a thruster that is reversed, or of two that are exchanged, unless sensors contradict each other.
fn wiring(campaign: &Campaign, reports: &[CheckReport]) -> Option<Finding> {
    if reports.iter().flat_map(|report| &report.findings).any(|f| f.code == check::codes::SIGN.code) {
        return None;
    }
    let runs = campaign.motion(Some(Role::Train));
    let found = check::wiring::judge(&runs.iter().collect::<Vec<_>>(), &driven(campaign), &campaign.file.thrusters)?;
    let column = found.channels.first().cloned();
    Some(Finding { column, ..Finding::new(found.code, found.text) })
}

/// Returns the modelled degrees of freedom that have a command. The others cannot be excited,
/// because no thruster drives them.
pub(super) fn driven(campaign: &Campaign) -> Vec<Dof> {
    campaign.model.dofs.iter().copied().filter(|dof| !campaign.file.model.undriven.contains(dof)).collect()
}

/// Returns the degrees of freedom that a fin drives whose angle varies in a run of the fit: the
/// angle is their command. If there are any, surge is added, because turns slow it.
fn steered(campaign: &Campaign) -> Vec<Dof> {
    let steered: Vec<Dof> = campaign.motion(Some(Role::Train)).iter().flat_map(check::fins::steered).collect();
    let mut moved: Vec<Dof> =
        baseline::driven_by_fins(&campaign.file).into_iter().filter(|dof| steered.contains(dof)).collect();
    moved.extend((!moved.is_empty()).then_some(Dof::Surge));
    moved
}

/// Returns a finding for each modelled degree of freedom whose inertia and drag no run of the fit
/// can show. Runs at rest are left out, because they have a finding of their own.
fn never_shown(campaign: &Campaign, logs: &[CheckedLog], resting: &[String]) -> Vec<Finding> {
    let free: Vec<&CheckedLog> = logs
        .iter()
        .filter(|log| log.role == Some(Role::Train) && log.kind.is_some_and(moves) && !resting.contains(&log.file))
        .collect();
    if free.is_empty() {
        return Vec::new();
    }
    let shown = |dof: Dof| {
        free.iter().any(|log| log.excitation.iter().any(|e| e.dof == dof && (e.enough || e.hidden_by_noise)))
    };
    let steered = steered(campaign);
    let absent = driven(campaign).into_iter().filter(|dof| !shown(*dof) && !steered.contains(dof));
    let absent: Vec<Dof> = absent.collect();
    let text = |dof: &Dof| {
        format!(
            "no run of the fit shows inertia and drag of {dof} by itself: what is estimated there relies on other runs \
             or on prior knowledge; add a run in which the command of {dof} varies without a controller"
        )
    };
    absent.iter().map(|dof| Finding::new(&codes::NEVER_SHOWN, text(dof))).collect()
}

impl CheckedLog {
    /// Returns an entry with the verdict and figures of a report; the other fields are those of a
    /// refused log.
    fn of(file: String, report: CheckReport) -> CheckedLog {
        CheckedLog {
            verdict: report.worst().max(light(&report.findings)),
            lights: report.lights,
            log_findings: report.log_findings,
            rates: report.rates,
            agreements: report.agreements,
            answers: report.answers,
            excitation: report.excitation,
            loops: report.loops,
            ..CheckedLog::refused(file)
        }
    }

    fn refused(file: String) -> CheckedLog {
        CheckedLog {
            file,
            verdict: Light::Red,
            kind: None,
            role: None,
            rows: 0,
            duration: 0.0,
            segments: 0,
            channels: Vec::new(),
            lights: Vec::new(),
            log_findings: Vec::new(),
            rates: Vec::new(),
            agreements: Vec::new(),
            answers: Vec::new(),
            excitation: Vec::new(),
            loops: Vec::new(),
        }
    }
}

impl Check {
    fn judge(&mut self) {
        let logs = self.logs.iter().map(|log| log.verdict).max().unwrap_or(Light::Green);
        self.verdict = self.verdict.max(logs).max(light(&self.warnings));
    }
}

fn light(findings: &[Finding]) -> Light {
    findings.iter().map(check::light_of).max().unwrap_or(Light::Green)
}
