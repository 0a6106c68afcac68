//! A finding: one statement of the crate about the data, as a note, a warning or an error.
//!
//! It has the same form everywhere, in `warnings` and `errors` of every result:
//! `{"code", "kind", "severity", "message", "file", "line", "column", "run"}`, without keys that do
//! not apply. A [`Code`] is the stable name of a kind of finding with one line on its meaning; each
//! module keeps its own list, and `hydrosysid explain CODE` looks a code up in all of them.

use std::ops::Range;

use serde::Serialize;

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// For information; nothing is wrong.
    Note,
    /// The work was done, but the result may not mean what it seems to.
    Warning,
    /// The work was not done.
    Error,
}

/// A kind of finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// Stable short name: the module's letter and three digits, `L012`.
    pub code: &'static str,
    /// Kind in words, `time-not-increasing`. Several codes may share one kind.
    pub kind: &'static str,
    /// Its severity.
    pub severity: Severity,
    /// Its meaning and what to do, in one line.
    pub meaning: &'static str,
}

/// Defines the codes of a module: one constant per line, with its meaning as documentation, and all
/// of them as `ALL`, which `hydrosysid explain` reads.
///
/// ```text
/// NAME = "L012" "kind-in-words" Warning "What it means and what to do.";
/// ```
macro_rules! codes {
    ($($name:ident = $code:literal $kind:literal $severity:ident $meaning:literal;)*) => {
        $(#[doc = $meaning]
        // the meanings are for users, who write [tables] in square brackets
        #[allow(rustdoc::broken_intra_doc_links)]
        pub const $name: $crate::finding::Code = $crate::finding::Code {
            code: $code,
            kind: $kind,
            severity: $crate::finding::Severity::$severity,
            meaning: $meaning,
        };)*
        /// All codes of this module, for `hydrosysid explain`.
        pub const ALL: &[$crate::finding::Code] = &[$($name),*];
    };
}
pub(crate) use codes;

/// One finding with its place.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Stable code, `L012`.
    pub code: &'static str,
    /// Kind in words, `time-not-increasing`.
    pub kind: &'static str,
    /// Its severity.
    pub severity: Severity,
    /// One or two self-contained sentences, which name file, line and column.
    pub message: String,
    /// File, as the user gave it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Physical line, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u64>,
    /// Canonical name of the column, or the key of an option.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Name of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run: Option<String>,
    /// The line, if it was available when the finding was made: no file is read again to show it.
    #[serde(skip)]
    pub quote: Option<Quote>,
}

/// A line of a file, or the part of a long one around the marked place, with this place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Quote {
    /// The text, at most [`Quote::WIDTH`] characters, none of them a control character.
    pub text: String,
    /// First marked character, from 0.
    pub start: usize,
    /// Number of marked characters, at least 1.
    pub length: usize,
}

impl Quote {
    /// Maximum number of characters that are shown.
    pub const WIDTH: usize = 100;

    /// The quote of `line` in which the bytes `marked` are marked.
    pub fn new(line: &[u8], marked: Range<usize>) -> Quote {
        // a character has at most four bytes
        let near = |from: usize| line.len().min(from + 4 * Quote::WIDTH);
        let text = |bytes: Range<usize>| -> String {
            let text = String::from_utf8_lossy(&line[bytes]);
            text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
        };
        let from = if marked.end > Quote::WIDTH { marked.start.saturating_sub(Quote::WIDTH / 2) } else { 0 };
        let before = text(from..marked.start);
        let inside = text(marked.start..marked.end.min(near(marked.start)));
        let start = before.chars().count();
        let length = inside.chars().count().min(Quote::WIDTH.saturating_sub(start)).max(1);
        let after = text(marked.end..near(marked.end));
        let shown = before.chars().chain(inside.chars()).chain(after.chars()).take(Quote::WIDTH);
        Quote { text: shown.collect(), start, length }
    }
}

impl Finding {
    /// A finding without a place.
    pub fn new(code: &Code, message: impl Into<String>) -> Finding {
        Finding {
            code: code.code,
            kind: code.kind,
            severity: code.severity,
            message: message.into(),
            file: None,
            line: None,
            column: None,
            run: None,
            quote: None,
        }
    }

    /// A finding in a file; the message is the place followed by `text`:
    /// `dive.csv, line 8, column u: …`.
    pub fn at(code: &Code, file: &str, line: Option<u64>, column: Option<&str>, text: &str) -> Finding {
        let mut message = file.to_string();
        if let Some(line) = line {
            message += &format!(", line {line}");
        }
        if let Some(column) = column {
            message += &format!(", column {column}");
        }
        Finding {
            file: Some(file.to_string()),
            line,
            column: column.map(str::to_string),
            ..Finding::new(code, format!("{message}: {text}"))
        }
    }

    /// The finding with its line.
    #[must_use]
    pub fn quoting(mut self, quote: Option<Quote>) -> Finding {
        self.quote = quote;
        self
    }

    /// The finding with the name of its run.
    #[must_use]
    pub fn of_run(mut self, run: &str) -> Finding {
        self.run = Some(run.to_string());
        self
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} [{} {}]", self.message, self.code, self.kind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CODE: Code = Code { code: "L000", kind: "parse", severity: Severity::Error, meaning: "not a number" };

    #[test]
    fn of_a_long_line_the_place_is_quoted() {
        let line = format!("{}wrong{}", "0,".repeat(400), ",0".repeat(400));
        let quote = Quote::new(line.as_bytes(), 800..805);
        assert_eq!((quote.text.len(), &quote.text[quote.start..quote.start + quote.length]), (Quote::WIDTH, "wrong"));
        let short = Quote::new("a\tµ,\u{1}b".as_bytes(), 2..4);
        assert_eq!((short.text.as_str(), short.start, short.length), ("a µ, b", 2, 1));
        assert_eq!(Quote::new(b"", 0..0), Quote { text: String::new(), start: 0, length: 1 });
    }

    #[test]
    fn keys_that_do_not_apply_are_absent() {
        let finding = Finding::at(&CODE, "dive.csv", Some(8), Some("u"), "'abc' is not a number");
        let json = serde_json::to_string(&finding).unwrap();
        assert_eq!(
            json,
            r#"{"code":"L000","kind":"parse","severity":"error","message":"dive.csv, line 8, column u: 'abc' is not a number","file":"dive.csv","line":8,"column":"u"}"#
        );
        let json = serde_json::to_string(&Finding::new(&CODE, "x").of_run("dive")).unwrap();
        assert_eq!(json, r#"{"code":"L000","kind":"parse","severity":"error","message":"x","run":"dive"}"#);
    }
}
