//! Collection of the errors of a campaign file, each with its place in the text.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::de::DeTable;

use super::error::{CampaignError, CampaignErrors, Location, Problem};
use super::tree::{Spot, quoted, spots};
use crate::nearest::nearest;

/// Text of a campaign, with the place of every key.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// The campaign file.
    pub file: PathBuf,
    /// Its text.
    pub text: Arc<str>,
    pub(super) spots: BTreeMap<String, Spot>,
}

impl Source {
    /// Returns the source of a TOML text, with the places of its keys.
    pub fn of(file: &Path, text: &str) -> Source {
        let (root, _) = DeTable::parse_recoverable(text);
        Source { file: file.to_path_buf(), text: text.into(), spots: spots(root.get_ref()) }
    }

    /// As [`Source::locate`], or of the nearest table above it that is in the file.
    pub fn locate_near(&self, path: &str) -> Option<Location> {
        let above = path.rsplit_once(['.', '[']).map(|(above, _)| above);
        self.locate(path).or_else(|| self.locate_near(above?))
    }

    /// Returns the place of a key's value by its path: `effect[0].formula`, `run[3].where`. `None`
    /// for a key that is not in the file.
    pub fn locate(&self, path: &str) -> Option<Location> {
        self.spots.get(path).map(|spot| self.location(spot.value.clone(), spot.key.clone()))
    }

    /// Returns the error for the value of the key at this path, for modules that find it later: a
    /// formula that cannot be read, an effect that cannot be where it is put.
    pub fn error_at(&self, path: &str, problem: Problem) -> CampaignError {
        let location = self.locate(path);
        let value = location.as_ref().and_then(|l| self.excerpt(&l.span));
        CampaignError { file: self.file.clone(), location, key: path.to_string(), value, problem }
    }

    fn location(&self, span: Range<usize>, key: Range<usize>) -> Location {
        let before = &self.text.as_bytes()[..span.start.min(self.text.len())];
        let line = 1 + before.iter().filter(|b| **b == b'\n').count();
        let start = before.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
        let in_line = &before[start..];
        let in_line = if start == 0 { in_line.strip_prefix("\u{feff}".as_bytes()).unwrap_or(in_line) } else { in_line };
        // UTF-8: every character has one byte that is no continuation
        let column = 1 + in_line.iter().filter(|b| **b & 0xC0 != 0x80).count();
        Location { line, column, span, key }
    }

    /// Returns the first line of the text there, at most 60 characters of it.
    fn excerpt(&self, span: &Range<usize>) -> Option<String> {
        let line = self.text.get(span.clone())?.lines().next()?;
        let short: String = line.chars().take(60).collect();
        Some(if short.len() < line.len() { format!("{short}…") } else { short })
    }
}

/// The errors found so far.
pub(super) struct Report {
    pub source: Source,
    errors: Vec<CampaignError>,
}

impl Report {
    pub fn new(file: &Path, text: &str) -> Report {
        let source = Source { file: file.to_path_buf(), text: text.into(), spots: BTreeMap::new() };
        Report { source, errors: Vec::new() }
    }

    /// Adds a problem of the value at a path, or of the nearest table above it that is in the file.
    pub fn at(&mut self, path: &str, problem: Problem) {
        let error = self.source.error_at(path, problem);
        let location = self.source.locate_near(path);
        self.errors.push(CampaignError { location, ..error });
    }

    /// Adds a problem of the file as a whole, at its first byte.
    pub fn at_start(&mut self, key: &str, problem: Problem) {
        let location = Some(self.source.location(0..0, 0..0));
        self.errors.push(CampaignError {
            file: self.source.file.clone(),
            location,
            key: key.to_string(),
            value: None,
            problem,
        });
    }

    /// Adds a problem of these bytes of the text.
    pub fn at_span(&mut self, span: Range<usize>, problem: Problem) {
        // the innermost entry whose key or value these bytes are in; a header stands for its table
        let within = |outer: &Range<usize>| outer.start <= span.start && span.end <= outer.end;
        let entry = self.source.spots.iter().filter(|(_, spot)| within(&spot.key) || within(&spot.value));
        let entry = entry.min_by_key(|(path, spot)| (spot.value.len(), std::cmp::Reverse(path.len())));
        let (key, key_span) = entry.map_or((String::new(), span.clone()), |(path, s)| (path.clone(), s.key.clone()));
        let value = self.source.excerpt(&span).filter(|v| !v.is_empty());
        let location = Some(self.source.location(span, key_span));
        self.errors.push(CampaignError { file: self.source.file.clone(), location, key, value, problem });
    }

    /// Adds an error of serde or of the TOML parser.
    pub fn toml(&mut self, error: &toml::de::Error, problem: impl Fn(&str) -> Problem) {
        match error.span() {
            Some(span) => self.at_span(span, problem(error.message())),
            None => self.at_start("", problem(error.message())),
        }
    }

    /// Returns the line of the value at a path.
    pub fn line(&self, path: &str) -> usize {
        self.source.locate(path).map_or(0, |l| l.line)
    }

    /// Whether something is wrong with the key at this path or below it.
    pub fn told(&self, path: &str) -> bool {
        self.errors.iter().any(|e| e.key.starts_with(path))
    }

    /// Keeps the first error of every line: further errors of the TOML parser in a line mostly
    /// follow from the first.
    pub fn one_a_line(&mut self) {
        let mut last = 0;
        self.errors.sort_by_key(|e| e.location.as_ref().map_or(0, |l| l.span.start));
        self.errors.retain(|e| {
            let line = e.location.as_ref().map_or(0, |l| l.line);
            std::mem::replace(&mut last, line) != line
        });
    }

    pub fn is_empty(&self) -> bool {
        self.errors.is_empty()
    }

    /// Returns all errors, in the order of the file.
    pub fn into_errors(self) -> CampaignErrors {
        let Report { source, mut errors } = self;
        errors.sort_by_key(|e| e.location.as_ref().map_or(0, |l| l.span.start));
        thrusters_as_one(&mut errors);
        let more = errors.len() > CampaignErrors::MOST;
        errors.truncate(CampaignErrors::MOST);
        CampaignErrors { file: source.file, text: source.text, errors, more }
    }
}

/// Reports only once, at the first of them, that several thrusters lack a position or an axis.
fn thrusters_as_one(errors: &mut Vec<CampaignError>) {
    let lacks = |e: &CampaignError| {
        let place = matches!(&e.problem, Problem::MissingKey { key, .. } if key == "position" || key == "axis");
        place && e.key.starts_with("thruster")
    };
    let count = errors.iter().filter(|e| lacks(e)).count();
    let Some(first) = errors.iter().position(lacks).filter(|_| count > 1) else { return };
    errors[first].problem = Problem::Unreadable {
        message: format!(
            "{count} thrusters, the first of them here, lack `position` (m) or `axis`, in body axes forward, \
             starboard, down: measure them, or take them from a vehicle: hydrosysid init LOG --vehicle NAME"
        ),
    };
    let mut k = 0;
    errors.retain(|e| {
        k += 1;
        k - 1 == first || !lacks(e)
    });
}

/// Converts a message of serde to a problem. Its wording is stable enough to rely on, and the tests
/// of this module check it.
pub(super) fn problem_of(message: &str) -> Problem {
    // every second piece between backticks is a word
    let listed = |message: &str| -> Vec<String> {
        let words = message.split_once(", expected ").map_or("", |(_, words)| words);
        words.split('`').skip(1).step_by(2).map(str::to_string).collect()
    };
    let near = |word: &str, known: &[String]| nearest(word, known.iter().map(String::as_str)).map(str::to_string);
    if let Some(key) = quoted(message, "unknown field") {
        let known = listed(message);
        return Problem::UnknownKey { key: key.to_string(), nearest: near(key, &known), known };
    }
    if let Some(word) = quoted(message, "unknown variant") {
        let known = listed(message);
        return Problem::UnknownWord { word: word.to_string(), nearest: near(word, &known), known };
    }
    if let Some(key) = quoted(message, "missing field") {
        return Problem::MissingKey { key: key.to_string(), right: purpose(key) };
    }
    let wrong = ["invalid type: ", "invalid value: ", "invalid length "].iter().find_map(|p| message.strip_prefix(p));
    match wrong.and_then(|rest| rest.split_once(", expected ")) {
        Some((found, expected)) => {
            let found = match found {
                "map" => "a table".to_string(),
                "sequence" => "a list".to_string(),
                n if message.starts_with("invalid length") => format!("{n} values"),
                other => other.replace('`', ""),
            };
            let expected = match in_words(expected) {
                list if list == "a list" && found == "a table" => "a list of tables, with [[ ]],".to_string(),
                other => other,
            };
            Problem::WrongType { found, expected }
        }
        None if message == "wanted string or table" => {
            Problem::WrongType { found: "another type".to_string(), expected: "a word in quotes".to_string() }
        }
        None => Problem::Unreadable { message: message.to_string() },
    }
}

/// Returns the purpose of a required key.
fn purpose(key: &str) -> &'static str {
    match key {
        "dofs" => "the degrees of freedom to model, as in dofs = [\"surge\", \"sway\", \"yaw\"]",
        "effects" => "the effects of the baseline, as in effects = [\"inertia\", \"linear_drag\"]",
        "file" => "the log, relative to the campaign file, as in file = \"run01.csv\"",
        "effect" => "the effect that the parameter belongs to, as in effect = \"linear_drag@surge\"",
        "formula" => "a formula over states and channels, as in formula = \"u * sin(theta)\"",
        "unit" => "the SI unit of the parameter, as in unit = \"kg/m\"",
        "valid" => "the speeds between which it was measured, m/s, as in valid = [0, 1]",
        _ => "required in a table of this kind",
    }
}

/// Returns serde's names of types in words.
fn in_words(expected: &str) -> String {
    let word = match expected {
        "f64" => "a number",
        "u64" | "u32" | "usize" => "a whole number, 0 or more",
        "i64" | "i8" => "a whole number",
        "a boolean" => "true or false",
        "a string" => "a text in quotes",
        "a sequence" => "a list",
        "a map" => "a table",
        "an array of length 2" => "a list of 2",
        "an array of length 3" => "a list of 3",
        "a character" => "one character in quotes",
        other if other.starts_with("struct ") => "a table",
        other => other,
    };
    word.to_string()
}
