//! What is wrong with a formula, and where.

use thiserror::Error;

/// Why a formula cannot be used. Columns count characters from 1.
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
        /// What would fit there.
        expected: &'static str,
    },
    /// Nothing is called so.
    #[error("`{formula}`: no {kind} is called `{name}` (column {column}){}", suggestion(.nearest))]
    UnknownName {
        /// The whole text.
        formula: String,
        /// Column of the name.
        column: usize,
        /// The name.
        name: String,
        /// What it stands for: a function, or a channel.
        kind: &'static str,
        /// The nearest that there is.
        nearest: Option<String>,
    },
    /// A function has another number of arguments.
    #[error("`{formula}`: `{name}` at column {column} takes {takes} argument(s), not {found}")]
    Arguments {
        /// The whole text.
        formula: String,
        /// Column of the function.
        column: usize,
        /// Its name.
        name: String,
        /// How many it takes.
        takes: usize,
        /// How many there are.
        found: usize,
    },
    /// The text is longer or deeper than any formula of physics.
    #[error(
        "a formula of {length} characters and {depth} nested brackets is too large: at most {longest} and {deepest}"
    )]
    TooLarge {
        /// Characters.
        length: usize,
        /// Deepest nesting of brackets.
        depth: usize,
        /// Most characters.
        longest: usize,
        /// Deepest admissible nesting.
        deepest: usize,
    },
}

fn found_text(found: &Option<char>) -> String {
    found.map_or_else(|| "the formula ends".to_string(), |c| format!("`{c}`"))
}

fn suggestion(nearest: &Option<String>) -> String {
    nearest.as_ref().map(|n| format!(", did you mean `{n}`?")).unwrap_or_default()
}
