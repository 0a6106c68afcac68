//! The form of every answer: a verdict of at most three lines, one table, the next command to type. What else there is
//! stands under `--verbose`, in `--json` and in the report.

use super::output::Output;
use super::table::{folded, width, wrapped};
use crate::finding::{Finding, Severity};

/// Most lines of a verdict.
const LINES: usize = 3;

/// Most warnings that are named under a verdict.
const NAMED: usize = 2;

/// The verdict in plain words: as many of its first sentences as three lines hold; all with `--verbose`. Whether that was all.
pub(super) fn verdict(text: &str, output: &Output) -> bool {
    let told = if output.is_verbose() { wrapped(text) } else { shortened(text, width()) };
    output.print(&told);
    told.split_whitespace().eq(text.split_whitespace())
}

/// The command to type next; the last line of an answer.
pub(super) fn next(command: &str, output: &Output) {
    output.print(&format!("next: {command}"));
}

/// The worst warnings, a line each; standard error has them in full.
pub(super) fn worst(findings: &[Finding], output: &Output) {
    let mut kinds: Vec<&Finding> = Vec::new();
    for finding in findings.iter().filter(|f| f.severity != Severity::Note) {
        if !kinds.iter().any(|known| known.code == finding.code) {
            kinds.push(finding);
        }
    }
    // errors before warnings, what is said of the model before what is said of a log; else in the order in which they were found
    kinds.sort_by_key(|f| (std::cmp::Reverse(f.severity), !f.code.starts_with('M')));
    for finding in kinds.iter().take(NAMED) {
        output.print(&one_line(finding));
    }
}

/// `warning: dive.csv: 3 s without samples… [L105 gap]`, as wide as the terminal.
fn one_line(finding: &Finding) -> String {
    let word = if finding.severity == Severity::Error { "error" } else { "warning" };
    let mark = format!(" [{} {}]", finding.code, finding.kind);
    let room = width().unwrap_or(80).saturating_sub(word.len() + 2 + mark.chars().count());
    format!("{word}: {}{mark}", cut(&finding.message, room))
}

/// The first characters of a text, with an ellipsis where some are left out.
pub(super) fn cut(text: &str, room: usize) -> String {
    if text.chars().count() <= room {
        return text.to_string();
    }
    let kept: String = text.chars().take(room.saturating_sub(1)).collect();
    format!("{}…", kept.trim_end())
}

/// The sentences up to the first that no longer fits in [`LINES`] lines of this width, the first one always: one behind it
/// may refer to it.
fn shortened(text: &str, width: Option<usize>) -> String {
    let Some(width) = width else { return text.to_string() };
    let mut kept = String::new();
    for sentence in sentences(text) {
        let longer = if kept.is_empty() { sentence.to_string() } else { format!("{kept} {sentence}") };
        if !kept.is_empty() && folded(&longer, width).lines().count() > LINES {
            break;
        }
        kept = longer;
    }
    let lines = folded(&kept, width);
    if lines.lines().count() <= LINES {
        return lines;
    }
    // one sentence that is too long for itself
    let mut first: Vec<String> = lines.lines().take(LINES).map(str::to_string).collect();
    if let Some(last) = first.last_mut() {
        *last = cut(&format!("{last} …"), width);
    }
    first.join("\n")
}

/// Sentences of a text: each ends with a full stop before a blank and a capital letter.
fn sentences(text: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut start = 0;
    for (at, _) in text.match_indices(". ") {
        if text[at + 2..].starts_with(|c: char| c.is_uppercase()) {
            found.push(&text[start..=at]);
            start = at + 2;
        }
    }
    found.push(&text[start..]);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_keeps_whole_sentences_in_three_lines() {
        let text = "It fits. The force of run 1.5 is 3 N. This third one is much too long for what is left here. That is more.";
        assert_eq!(sentences(text).len(), 4);
        assert_eq!(shortened(text, Some(20)), "It fits. The force\nof run 1.5 is 3 N.");
        assert_eq!(shortened(text, None), text);
        let long = shortened(&"word ".repeat(60), Some(20));
        assert!(long.lines().count() == 3 && long.ends_with('…'), "{long}");
        assert!(long.lines().all(|line| line.chars().count() <= 20), "{long}");
    }
}
