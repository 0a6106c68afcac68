//! Errors of a formula, with their columns.

use thiserror::Error;

/// Error of a formula. Columns count characters from 1.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FormulaError {
    /// The text is no formula.
    #[error("`{formula}`: {} at column {column}, where {expected} would be right", found_text(.found))]
    Syntax {
        /// The whole text.
        formula: String,
        /// Column of the first character that does not fit.
        column: usize,
        /// That character; `None` at the end of the text.
        found: Option<char>,
        /// What is allowed there.
        expected: &'static str,
    },
    /// An unknown name.
    #[error("`{formula}`: no {kind} is called `{name}` (column {column}){}", suggestion(.nearest))]
    UnknownName {
        /// The whole text.
        formula: String,
        /// Column of the name.
        column: usize,
        /// The name.
        name: String,
        /// Kind of the name: a function, or a channel.
        kind: &'static str,
        /// The nearest known name.
        nearest: Option<String>,
    },
    /// A function has the wrong number of arguments.
    #[error("`{formula}`: `{name}` at column {column} takes {takes} argument(s), not {found}")]
    Arguments {
        /// The whole text.
        formula: String,
        /// Column of the function.
        column: usize,
        /// Its name.
        name: String,
        /// Number of arguments that it takes.
        takes: usize,
        /// Number of arguments in the formula.
        found: usize,
    },
    /// The text is longer, or its brackets are nested deeper, than in any formula of physics.
    #[error(
        "a formula of {length} characters and {depth} nested brackets is too large: at most {longest} and {deepest}"
    )]
    TooLarge {
        /// Number of characters.
        length: usize,
        /// Deepest nesting of brackets.
        depth: usize,
        /// Maximum number of characters.
        longest: usize,
        /// Maximum nesting of brackets.
        deepest: usize,
    },
}

fn found_text(found: &Option<char>) -> String {
    found.map_or_else(|| "the formula ends".to_string(), |c| format!("`{c}`"))
}

fn suggestion(nearest: &Option<String>) -> String {
    nearest.as_ref().map(|n| format!(", did you mean `{n}`?")).unwrap_or_default()
}
