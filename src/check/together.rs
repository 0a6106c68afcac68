//! Combined verdict of the logs of one vehicle: on the sign of a command or a velocity, and on what they excite.
//!
//! ```text
//! wrong in all of them:    more logs by which it is wrong than logs by which it is right
//! excited:                 at least one run of the fit shows inertia and drag of the degree of freedom
//! ```
//!
//! One run for each degree of freedom is how a vehicle is tested (Avila et al., 2013): a run that leaves sway at rest is no
//! fault if another one moves it.
//!
//! A sign depends on the wiring and on the columns of the log, and is therefore the same in all logs;
//! a log in which a controller moves the rudder, or that shows little, may mislead. Unless more logs
//! find it wrong than right, the finding in the former only says that the logs disagree, and no sign is
//! to be set for all.

use super::codes;
use super::commands::signs;
use super::rates::number_of;
use super::report::{Answer, CheckReport, FaultKind, Light, Topic};
use crate::finding::Finding;
use crate::thrust::thruster::Thruster;

/// Withdraws from the reports of one vehicle each finding of a wrong sign, unless more logs support
/// than contradict it.
pub fn weigh(reports: &mut [CheckReport], thrusters: &[Thruster]) {
    let mut accused: Vec<String> = reports.iter().flat_map(accusations).collect();
    accused.sort();
    accused.dedup();
    for column in accused {
        let wrong = reports.iter().filter(|r| accusations(r).contains(&column)).count();
        let is_right = |r: &CheckReport| !accusations(r).contains(&column) && finds_right(r, &column, thrusters);
        let right: Vec<String> = reports.iter().filter(|r| is_right(r)).map(|r| r.run.clone()).collect();
        if wrong > right.len() {
            continue;
        }
        for report in reports.iter_mut().filter(|r| accusations(r).contains(&column)) {
            take_back(report, &column, &right);
        }
    }
}

/// Returns the columns whose sign a report finds wrong.
fn accusations(report: &CheckReport) -> Vec<String> {
    let of_sign = report.findings.iter().filter(|f| f.code == codes::COMMAND_SIGN.code);
    of_sign.filter_map(|f| f.column.clone()).collect()
}

/// Whether a report finds the sign of this command or velocity right.
fn finds_right(report: &CheckReport, column: &str, thrusters: &[Thruster]) -> bool {
    let concerns = |a: &Answer| {
        let same_thruster = number_of(column).is_some_and(|number| number_of(&a.channel) == Some(number));
        same_thruster || a.channel == column || a.velocity == column
    };
    let told = signs(&report.answers, thrusters);
    let mut of_column = told.iter().filter(|(a, _)| concerns(a)).peekable();
    of_column.peek().is_some() && of_column.all(|(_, right)| *right)
}

/// Withdraws each finding of a degree of freedom that a run does not excite, if another run of the fit shows it. `of_fit`:
/// whether each report is that of a run of the fit.
pub fn share_excitation(reports: &mut [CheckReport], of_fit: &[bool]) {
    let of_reports = reports.iter().zip(of_fit).filter(|(_, of_fit)| **of_fit).map(|(report, _)| report);
    let shown = of_reports.flat_map(|report| &report.excitation).filter(|e| e.enough);
    let shown: Vec<&str> = shown.map(|e| e.dof.velocity()).collect();
    let is_shown =
        |f: &Finding| f.code == codes::EXCITATION.code && f.column.as_deref().is_some_and(|c| shown.contains(&c));
    for report in reports {
        withdraw(report, Topic::Excitation, is_shown);
    }
}

/// Withdraws all findings of wrong signs of commands: the wiring of the thrusters explains them.
pub fn withdraw_signs(reports: &mut [CheckReport]) {
    for report in reports {
        withdraw(report, Topic::Commands, |f| f.code == codes::COMMAND_SIGN.code);
        report.log_findings.retain(|fault| fault.kind != FaultKind::Sign);
    }
}

/// Withdraws the findings of `topic` that satisfy `is_it`.
fn withdraw(report: &mut CheckReport, topic: Topic, is_it: impl Fn(&Finding) -> bool) {
    report.findings.retain(|f| !is_it(f));
    light_anew(report, topic);
}

/// Lights `topic` by the findings that are left.
fn light_anew(report: &mut CheckReport, topic: Topic) {
    for light in report.lights.iter_mut().filter(|l| l.topic == topic) {
        light.light = light.light.map(|_| Light::Green);
    }
    report.light_up();
}

fn take_back(report: &mut CheckReport, column: &str, right: &[String]) {
    let is_it = |f: &Finding| f.code == codes::COMMAND_SIGN.code && f.column.as_deref() == Some(column);
    let Some(place) = report.findings.iter().position(is_it) else { return };
    let text = format!(
        "{}: in this log {column} acts the wrong way, in {} the right way: check whether a controller moved it here, \
         or its column has the opposite sign in this log; no one sign is right for all",
        report.run,
        right.join(", ")
    );
    let finding = Finding { column: Some(column.to_string()), ..Finding::new(&codes::SIGN_DISAGREES, text) };
    report.findings[place] = finding.of_run(&report.run);
    report.log_findings.retain(|fault| fault.kind != FaultKind::Sign || fault.channel != column);
    light_anew(report, Topic::Commands);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::TopicLight;
    use crate::check::excitation::Excitation;
    use crate::frame::Dof;

    /// A log in which the rudder turns the vehicle the right way (positive gain) or the wrong way.
    fn log(name: &str, gain: f64) -> CheckReport {
        let answer =
            Answer { channel: "rudder".into(), velocity: "r".into(), gain, std: 0.01, delay: None, joined: false };
        let mut findings = Vec::new();
        if gain < 0.0 {
            let of_sign = Finding::new(&codes::COMMAND_SIGN, format!("{name}: rudder turns the wrong way"));
            findings.push(Finding { column: Some("rudder".into()), ..of_sign });
        }
        let mut report = CheckReport {
            run: name.into(),
            lights: vec![TopicLight { topic: Topic::Commands, light: Some(Light::Green) }],
            findings,
            log_findings: Vec::new(),
            rates: Vec::new(),
            agreements: Vec::new(),
            answers: vec![answer],
            excitation: Vec::new(),
            loops: Vec::new(),
        };
        report.light_up();
        report
    }

    /// Each run moves one degree of freedom, as in a campaign by the book.
    #[test]
    fn what_another_run_of_the_fit_excites_is_no_finding() {
        let of = |dof: Dof, enough: bool| Excitation {
            dof,
            commands: vec![dof.force().into()],
            signal_to_noise: 10.0,
            speed: [0.0, 0.1],
            explained: if enough { 0.9 } else { 0.0 },
            condition: 3.0,
            terms: Vec::new(),
            sentence: format!("{dof}"),
            enough,
            hidden_by_noise: false,
        };
        let run = |name: &str, surge: bool, sway: bool| {
            let mut report = log(name, 0.6);
            report.lights.push(TopicLight { topic: Topic::Excitation, light: Some(Light::Green) });
            report.excitation = vec![of(Dof::Surge, surge), of(Dof::Sway, sway)];
            let lacking = report.excitation.iter().filter(|e| !e.enough).map(|e| Finding {
                column: Some(e.dof.velocity().into()),
                ..Finding::new(&codes::EXCITATION, e.sentence.clone())
            });
            report.findings = lacking.collect();
            report.light_up();
            report
        };
        let mut reports = [run("a", true, false), run("b", false, true)];
        assert_eq!(reports.each_ref().map(CheckReport::worst), [Light::Amber, Light::Amber]);
        share_excitation(&mut reports, &[true, false]);
        // b takes no part in the fit: nothing there shows sway
        assert_eq!(reports.each_ref().map(CheckReport::worst), [Light::Amber, Light::Green]);
        share_excitation(&mut reports, &[true, true]);
        assert!(reports.iter().all(|r| r.findings.is_empty() && r.worst() == Light::Green), "{reports:?}");
    }

    #[test]
    fn the_fewer_logs_do_not_turn_a_sign_for_all() {
        let mut logs = [log("a", 0.6), log("b", 0.6), log("c", -1.0)];
        weigh(&mut logs, &[]);
        assert_eq!(logs[2].findings[0].code, codes::SIGN_DISAGREES.code);
        assert!(logs[2].findings[0].message.contains("in a, b the right way"), "{}", logs[2].findings[0].message);
        assert_eq!(logs[2].worst(), Light::Amber);
        let mut turned = [log("a", 0.6), log("b", -0.6), log("c", -1.0)];
        weigh(&mut turned, &[]);
        assert!(turned[1..].iter().all(|log| log.findings[0].code == codes::COMMAND_SIGN.code));
        assert_eq!(turned.map(|log| log.worst()), [Light::Green, Light::Red, Light::Red]);
    }
}
