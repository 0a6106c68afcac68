//! Findings and errors as people read them: the place, the line with a caret, what to do.

use std::fmt::Write;

use super::failure::Failure;
use super::output::Output;
use crate::campaign::Error;
use crate::campaign::file::{CampaignError, CampaignErrors};
use crate::export::ExportError;
use crate::finding::{Finding, Quote, Severity};

const RED: &str = "\x1b[1;31m";
const YELLOW: &str = "\x1b[1;33m";
const BLUE: &str = "\x1b[1;34m";
const BOLD: &str = "\x1b[1m";
const PLAIN: &str = "\x1b[0m";

/// Longest line of a file that is shown, in characters: a wider one is cut around what is meant.
const WIDTH: usize = Quote::WIDTH;

/// One finding: `warning: message [L105 gap]`.
pub(super) fn finding(finding: &Finding) -> String {
    let (colour, word) = match finding.severity {
        Severity::Error => (RED, "error"),
        Severity::Warning => (YELLOW, "warning"),
        Severity::Note => (BLUE, "note"),
    };
    format!("{colour}{word}{PLAIN}: {finding}")
}

/// Tells why the command failed.
pub(super) fn failure(failure: &Failure, output: &Output) {
    let text = match failure {
        Failure::Library(Error::File(errors)) | Failure::Export(ExportError::Campaign(errors)) => campaign(errors),
        Failure::Library(error) if !error.findings().is_empty() => refused(error.findings()),
        Failure::Refused { findings, .. } => refused(findings),
        other => format!("{RED}error{PLAIN}: {other}"),
    };
    output.complain(&text);
}

/// Everything that is wrong with a campaign file, each with its line.
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

/// Findings that made the data be refused, each with its cell where it has one.
fn refused(findings: &[Finding]) -> String {
    let mut text = String::new();
    for one in findings {
        let _ = writeln!(text, "{}", finding(one));
        if let (Some(quote), Some(line)) = (&one.quote, one.line) {
            text += &caret(&quote.text, line, quote.start + 1, quote.length);
        }
    }
    text.trim_end().to_string()
}

/// A line, or of a long one what is around, and `^^^` under `length` characters from `column` on (from 1).
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
    fn of_a_long_line_the_place_is_shown() {
        let line = format!("{}wrong{}", "0,".repeat(400), ",0".repeat(400));
        let text = caret(&line, 3, 801, 5);
        let plain = [RED, BLUE, PLAIN].iter().fold(text, |t, code| t.replace(code, ""));
        let lines: Vec<&str> = plain.lines().collect();
        assert!(lines.iter().all(|l| l.chars().count() <= WIDTH + 4), "{plain}");
        assert_eq!(lines[1].find("wrong"), lines[2].find("^^^^^"));
    }
}
