//! Findings and errors for people: the place, the line with a caret, what to do.

use std::fmt::Write;

use super::failure::Failure;
use super::output::Output;
use super::table::{folded, width};
use crate::campaign::Error;
use crate::campaign::file::{CampaignError, CampaignErrors};
use crate::export::ExportError;
use crate::finding::{Finding, Quote, Severity};
use crate::wording::count;

const RED: &str = "\x1b[1;31m";
const YELLOW: &str = "\x1b[1;33m";
const BLUE: &str = "\x1b[1;34m";
const BOLD: &str = "\x1b[1m";
const PLAIN: &str = "\x1b[0m";

/// Maximum length of a displayed line of a file, in characters: a longer one is cut around the
/// error.
const WIDTH: usize = Quote::WIDTH;

/// One finding: `warning: message [L105 gap]`.
pub(super) fn finding(finding: &Finding) -> String {
    let (colour, word) = match finding.severity {
        Severity::Error => (RED, "error"),
        Severity::Warning => (YELLOW, "warning"),
        Severity::Note => (BLUE, "note"),
    };
    format!("{colour}{word}{PLAIN}{}", hanging(&format!(": {finding}"), word.len(), width()))
}

/// A text after a word of length `behind`, folded to the width of the terminal; continuation lines
/// are indented by two.
pub(super) fn hanging(text: &str, behind: usize, width: Option<usize>) -> String {
    let Some(width) = width else { return text.to_string() };
    let text = "x".repeat(behind) + text;
    let fold = |line: &str| {
        let (margin, line) = line.split_at(line.len() - line.trim_start_matches(' ').len());
        let text = folded(line, width.saturating_sub(margin.len().max(2)));
        format!("{margin}{}", text.replace('\n', &format!("\n{}", " ".repeat(margin.len().max(2)))))
    };
    text.split('\n').map(fold).collect::<Vec<_>>().join("\n")[behind..].to_string()
}

/// Maximum number of files that are listed beside the first finding, and of places in each.
const LISTED: usize = 6;

/// Findings grouped by code: the first in full, then the number of others and their places. With
/// `--verbose` all in full.
pub(super) fn grouped(findings: &[Finding], verbose: bool) -> Vec<String> {
    let mut groups: Vec<Vec<&Finding>> = Vec::new();
    for one in findings {
        match groups.iter_mut().find(|group| !verbose && group[0].code == one.code && group[0].severity == one.severity)
        {
            // identical findings are printed once
            Some(group) if group.contains(&one) => {}
            Some(group) => group.push(one),
            None => groups.push(vec![one]),
        }
    }
    let told = |group: &Vec<&Finding>| match group.len() - 1 {
        0 => in_full(group[0]),
        more => {
            let others = format!("  and {more} more of this kind{}", places(&group[1..]));
            format!("{}\n{}", in_full(group[0]), hanging(&others, 0, width()))
        }
    };
    groups.iter().map(told).collect()
}

/// `: run01.csv (tau_u, tau_v), run02.csv (line 8 u)`; empty if findings have no place.
fn places(findings: &[&Finding]) -> String {
    let mut files: Vec<(&str, Vec<String>)> = Vec::new();
    for one in findings {
        let Some(file) = one.file.as_deref().or(one.run.as_deref()) else { continue };
        let within: Vec<String> =
            one.line.map(|line| format!("line {line}")).into_iter().chain(one.column.clone()).collect();
        let at = files.iter().position(|(name, _)| *name == file).unwrap_or_else(|| {
            files.push((file, Vec::new()));
            files.len() - 1
        });
        if !within.is_empty() {
            files[at].1.push(within.join(" "));
        }
    }
    let told = |(file, within): &(&str, Vec<String>)| match within.len() {
        0 => (*file).to_string(),
        n if n > LISTED => format!("{file} ({}, and {} more)", within[..LISTED].join(", "), n - LISTED),
        _ => format!("{file} ({})", within.join(", ")),
    };
    let listed: Vec<String> = files.iter().take(LISTED).map(told).collect();
    match (listed.is_empty(), files.len().saturating_sub(LISTED)) {
        (true, _) => String::new(),
        (false, 0) => format!(": {}", listed.join(", ")),
        (false, rest) => format!(": {}, and {}", listed.join(", "), count(rest, "further file")),
    }
}

/// A finding, with its cell if it has one.
fn in_full(one: &Finding) -> String {
    let mut text = finding(one);
    if let (Some(quote), Some(line)) = (&one.quote, one.line) {
        let _ = write!(text, "\n{}", caret(&quote.text, line, quote.start + 1, quote.length).trim_end());
    }
    text
}

/// Prints why the command failed.
pub(super) fn failure(failure: &Failure, output: &Output) {
    let text = match failure {
        Failure::Library(Error::File(errors)) | Failure::Export(ExportError::Campaign(errors)) => campaign(errors),
        Failure::Library(error) if !error.findings().is_empty() => {
            grouped(error.findings(), output.is_verbose()).join("\n")
        }
        Failure::Refused { findings, .. } => grouped(findings, output.is_verbose()).join("\n"),
        other => format!("{RED}error{PLAIN}{}", hanging(&format!(": {other}"), "error".len(), width())),
    };
    output.complain(&text);
}

/// All errors of a campaign file, each with its line.
fn campaign(errors: &CampaignErrors) -> String {
    let mut text = String::new();
    for error in &errors.errors {
        text += &in_campaign(error, &errors.text);
    }
    if errors.more {
        let _ = writeln!(text, "{}: and more", errors.file.display());
    }
    text.trim_end().to_string()
}

fn in_campaign(error: &CampaignError, text: &str) -> String {
    let mut out = format!("{RED}error{PLAIN}: {BOLD}{error}{PLAIN}\n");
    if let Some(location) = &error.location
        && let Some(line) = text.lines().nth(location.line - 1)
    {
        let length = text.get(location.span.clone()).map_or(1, |t| t.lines().next().unwrap_or("").chars().count());
        out += &caret(line, location.line as u64, location.column, length.max(1));
    }
    out
}

/// A line, or a part of a long one, with `^^^` under `length` characters from `column` on (from 1).
fn caret(line: &str, number: u64, column: usize, length: usize) -> String {
    let margin = number.to_string();
    let blank = " ".repeat(margin.len());
    let start = column - 1;
    let from = if start + length > WIDTH { start.saturating_sub(WIDTH / 2) } else { 0 };
    let clean: String = line.chars().skip(from).take(WIDTH).map(|c| if c.is_control() { ' ' } else { c }).collect();
    let length = length.min(clean.chars().count().saturating_sub(start - from)).max(1);
    let under = format!("{}{}", " ".repeat(start - from), "^".repeat(length));
    format!("{BLUE}{blank} |\n{margin} |{PLAIN} {clean}\n{BLUE}{blank} |{PLAIN} {RED}{under}{PLAIN}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_caret_stands_under_what_is_wrong() {
        let text = caret("mass = -1", 3, 8, 2);
        let plain = [RED, BLUE, PLAIN].iter().fold(text, |t, code| t.replace(code, ""));
        assert_eq!(plain, "  |\n3 | mass = -1\n  |        ^^\n");
    }

    #[test]
    fn a_message_is_as_wide_as_the_terminal() {
        let text = ": one two three four\n  five six seven";
        assert_eq!(hanging(text, 5, Some(14)), ": one\n  two three\n  four\n  five six\n  seven");
        assert_eq!(hanging(text, 5, Some(16)), ": one two\n  three four\n  five six seven");
        assert_eq!(hanging(text, 5, None), text);
    }

    #[test]
    fn one_cause_is_one_message_with_its_places() {
        let code = &crate::log::codes::MISSING_COLUMN;
        let of = |file: &str, column: &str| Finding::at(code, file, None, Some(column), "no such column");
        let findings = [of("a.csv", "tau_u"), of("a.csv", "tau_v"), of("b.csv", "tau_u"), of("b.csv", "tau_u")];
        let told = grouped(&findings, false);
        assert_eq!(told.len(), 1);
        assert!(told[0].contains("a.csv, column tau_u: no such column"), "{}", told[0]);
        assert!(told[0].ends_with("\n  and 2 more of this kind: a.csv (tau_v), b.csv (tau_u)"), "{}", told[0]);
        assert_eq!(grouped(&findings, true).len(), 4);
        let many: Vec<Finding> = (0..20).map(|k| of(&format!("{k}.csv"), "u")).collect();
        assert!(grouped(&many, false)[0].ends_with("6.csv (u), and 13 further files"), "{}", grouped(&many, false)[0]);
    }

    #[test]
    fn of_a_long_line_the_place_is_shown() {
        let line = format!("{}wrong{}", "0,".repeat(400), ",0".repeat(400));
        let text = caret(&line, 3, 801, 5);
        let plain = [RED, BLUE, PLAIN].iter().fold(text, |t, code| t.replace(code, ""));
        let lines: Vec<&str> = plain.lines().collect();
        assert!(lines.iter().all(|l| l.chars().count() <= WIDTH + 4), "{plain}");
        assert_eq!(lines[1].find("wrong"), lines[2].find("^^^^^"));
    }
}
