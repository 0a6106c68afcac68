//! The form of every answer: a verdict of at most three lines, one table, the next command to type.
//! All other results are in `--verbose`, in `--json` and in the report.

use super::output::Output;
use super::table::{folded, width, wrapped};

/// Maximum number of lines of a verdict.
const LINES: usize = 3;

/// Prints the verdict: as many of its first sentences as fit into three lines; all with
/// `--verbose`. Returns whether that was all.
pub(super) fn verdict(text: &str, output: &Output) -> bool {
    let told = if output.is_verbose() { wrapped(text) } else { shortened(text, width(), LINES).0 };
    output.print(&told);
    told.split_whitespace().eq(text.split_whitespace())
}

/// Prints the verdict in at most three lines, with `--verbose` as well, and returns the part that
/// did not fit. If a part is left out, the last of these lines is `key`: the most important
/// information of the rest.
pub(super) fn verdict_with(text: &str, key: Option<&str>, output: &Output) -> Option<String> {
    let (told, rest) = keyed(text, key, width());
    output.print(&told);
    rest
}

/// Verdict and key in [`LINES`] lines of this width, and the sentences that are left out.
fn keyed(text: &str, key: Option<&str>, width: Option<usize>) -> (String, Option<String>) {
    let (told, rest) = shortened(text, width, LINES);
    let (Some(width), Some(_), Some(key)) = (width, &rest, key) else { return (told, rest) };
    let (least, _) = shortened(text, Some(width), 1);
    let key = in_lines(key, width, LINES - least.lines().count().min(LINES - 1));
    let (told, rest) = shortened(text, Some(width), LINES - key.lines().count());
    (format!("{told}\n{key}"), rest)
}

/// Prints the command to type next, the last line of an answer.
pub(super) fn next(command: &str, output: &Output) {
    output.print(&format!("next: {command}"));
}

/// The first characters of a text, with an ellipsis if some are left out.
pub(super) fn cut(text: &str, room: usize) -> String {
    if text.chars().count() <= room {
        return text.to_string();
    }
    let kept: String = text.chars().take(room.saturating_sub(1)).collect();
    format!("{}…", kept.trim_end())
}

/// The sentences before the first one that no longer fits into `most` lines of this width, because
/// a later one may refer to it; at least the first sentence. And the rest: the other sentences, or
/// the whole text if the first sentence is cut.
fn shortened(text: &str, width: Option<usize>, most: usize) -> (String, Option<String>) {
    let Some(width) = width else { return (text.to_string(), None) };
    let all = sentences(text);
    let fits = |n: &usize| folded(&all[..*n].join(" "), width).lines().count() <= most;
    let kept = (2..=all.len()).take_while(fits).last().unwrap_or(1);
    let first = all[..kept].join(" ");
    let lines = in_lines(&first, width, most);
    let rest = if fits(&kept) { all[kept..].join(" ") } else { text.to_string() };
    (lines, Some(rest).filter(|rest| !rest.is_empty()))
}

/// A text in at most `most` lines; an ellipsis replaces the rest.
fn in_lines(text: &str, width: usize, most: usize) -> String {
    let lines = folded(text, width);
    if lines.lines().count() <= most {
        return lines;
    }
    let mut first: Vec<String> = lines.lines().take(most).map(str::to_string).collect();
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
        let (told, rest) = shortened(text, Some(20), LINES);
        assert_eq!(told, "It fits. The force\nof run 1.5 is 3 N.");
        assert_eq!(rest.as_deref(), Some("This third one is much too long for what is left here. That is more."));
        assert_eq!(shortened(text, None, LINES), (text.to_string(), None));
        let (long, rest) = shortened(&"word ".repeat(60), Some(20), LINES);
        assert_eq!(rest, Some("word ".repeat(60)));
        assert!(long.lines().count() == 3 && long.ends_with('…'), "{long}");
        assert!(long.lines().all(|line| line.chars().count() <= 20), "{long}");
    }

    #[test]
    fn a_verdict_and_its_key_are_three_lines() {
        let text = "It converged. This second sentence is a long one. So is the third one that stands here.";
        let of = |key| keyed(text, Some(key), Some(30));
        let rest = Some("So is the third one that stands here.".to_string());
        assert_eq!(of("force: 3 N"), ("It converged. This second\nsentence is a long one.\nforce: 3 N".into(), rest));
        // a key of two lines leaves one line, and a longer one is cut
        let (told, rest) = of("force: surge 3 N, sway 4 N, yaw 5 N m, pitch 7 N m, roll 1 N m");
        assert_eq!(told, "It converged.\nforce: surge 3 N, sway 4 N,\nyaw 5 N m, pitch 7 N m, roll…");
        assert_eq!(rest.as_deref(), Some("This second sentence is a long one. So is the third one that stands here."));
        // a verdict that fits needs no key
        assert_eq!(keyed("It fits.", Some("force: 3 N"), Some(30)), ("It fits.".into(), None));
    }
}
