//! Errors of a campaign file, and their places in it.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use thiserror::Error;

use crate::frame::Dof;
use crate::log::OptionsError;
use crate::thrust::efficiency::EfficiencyError;
use crate::thrust::thruster::ThrusterError;
use crate::vehicle::VehicleError;

/// All errors of one campaign file, in the order of the file, at most [`CampaignErrors::MOST`].
#[derive(Debug, Clone, PartialEq)]
pub struct CampaignErrors {
    /// The campaign file.
    pub file: PathBuf,
    /// Its text, into which the spans of `errors` point; empty if it could not be read.
    pub text: Arc<str>,
    /// The errors, at least one.
    pub errors: Vec<CampaignError>,
    /// Whether there are more errors than are listed.
    pub more: bool,
}

impl CampaignErrors {
    /// Maximum number of errors listed: with more, the file is better reviewed as a whole.
    pub const MOST: usize = 20;
}

impl fmt::Display for CampaignErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, error) in self.errors.iter().enumerate() {
            write!(f, "{}{error}", if i > 0 { "\n" } else { "" })?;
        }
        if self.more {
            write!(f, "\n{}: and more", self.file.display())?;
        }
        Ok(())
    }
}

impl std::error::Error for CampaignErrors {}

/// One error of a campaign file. Prints as `file:line:column: key: what`.
#[derive(Debug, Clone, PartialEq)]
pub struct CampaignError {
    /// The campaign file.
    pub file: PathBuf,
    /// Place in the file; `None` if the file could not be read at all.
    pub location: Option<Location>,
    /// The key, as in `run[2].kind`; empty for the file as a whole.
    pub key: String,
    /// The text there, cut to a line; `None` if there is none.
    pub value: Option<String>,
    /// What is wrong, and what would be right.
    pub problem: Problem,
}

/// A place in the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Location {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Bytes of the faulty text: a key, a value or the header of a table.
    pub span: Range<usize>,
    /// Bytes of the key it belongs to; equal to `span` if there is none.
    pub key: Range<usize>,
}

impl fmt::Display for CampaignError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(location) = &self.location {
            write!(f, ":{}:{}", location.line, location.column)?;
        }
        if !self.key.is_empty() {
            write!(f, ": {}", self.key)?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl std::error::Error for CampaignError {}

/// What is wrong, and what would be right.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Problem {
    /// The campaign file cannot be read.
    #[error("cannot be read: {}", io_text(*.kind))]
    CannotRead {
        /// Reason for the failure.
        kind: std::io::ErrorKind,
    },
    /// The file is not text.
    #[error("byte 0x{byte:02x} is not UTF-8: save the file as UTF-8 text")]
    NotUtf8 {
        /// The first invalid byte.
        byte: u8,
    },
    /// A log in a format that its first bytes identify.
    #[error(
        "this is {name}, not a campaign file: `hydrosysid init LOG -o FOLDER` of the Python package writes a campaign \
         from it (pip install 'hydrosysid[{extra}]')"
    )]
    OtherLog {
        /// Name of the format.
        name: &'static str,
        /// The extra of the Python package that reads it.
        extra: &'static str,
    },
    /// A file of another kind: a model, a log.
    #[error("{told}")]
    OtherFile {
        /// What it is, and what would be right.
        told: &'static str,
    },
    /// The file is not TOML.
    #[error("{message}")]
    Syntax {
        /// Message of the TOML parser.
        message: String,
    },
    /// A key that does not exist.
    #[error("unknown key `{key}`{}", suggest(.nearest, .known))]
    UnknownKey {
        /// The key.
        key: String,
        /// The nearest known key.
        nearest: Option<String>,
        /// All known keys.
        known: Vec<String>,
    },
    /// A word that is not in the list of allowed words (a degree of freedom, a kind, a role).
    #[error("unknown word `{word}`{}", suggest(.nearest, .known))]
    UnknownWord {
        /// The word.
        word: String,
        /// The nearest word of the list.
        nearest: Option<String>,
        /// The list.
        known: Vec<String>,
    },
    /// A value of the wrong type.
    #[error("{found} found where {expected} is expected")]
    WrongType {
        /// The type that was found.
        found: String,
        /// The type that is wanted.
        expected: String,
    },
    /// A required key is missing.
    #[error("`{key}` is missing: {right}")]
    MissingKey {
        /// The key.
        key: String,
        /// What it should say.
        right: &'static str,
    },
    /// A text that its own parser refuses: the name of an effect, a unit.
    #[error("{message}")]
    Unreadable {
        /// Message of the parser.
        message: String,
    },
    /// A format that this version does not know.
    #[error("format {found} is not known: this version reads format 1")]
    Format {
        /// The format of the file.
        found: i64,
    },
    /// Infinite, or not a number.
    #[error("must be a finite number")]
    NotFinite,
    /// A number outside its range.
    #[error("{value} is not valid here: {right}")]
    OutOfRange {
        /// The number.
        value: f64,
        /// What would be right.
        right: &'static str,
    },
    /// A list or text that must not be empty.
    #[error("is empty: {right}")]
    Empty {
        /// What it should hold.
        right: &'static str,
    },
    /// Something that is given twice.
    #[error("{what} is given twice, first in line {first_line}: keep one")]
    Twice {
        /// What is given twice.
        what: String,
        /// Line of the first one.
        first_line: usize,
    },
    /// No effect has this id.
    #[error("no effect is called `{id}`{}; `hydrosysid effects` lists them", did_you_mean(.nearest))]
    UnknownEffect {
        /// The id.
        id: String,
        /// The nearest known id.
        nearest: Option<String>,
    },
    /// A user's own effect with the id of a catalogue effect.
    #[error("`{id}` is an effect of the catalogue: choose another id for your own")]
    EffectTaken {
        /// The id.
        id: String,
    },
    /// An effect in a degree of freedom that is not modelled.
    #[error("`{dof}` is not among the `dofs` of [model]: add it there, or leave this out")]
    NotModelled {
        /// The degree of freedom.
        dof: Dof,
    },
    /// `fixed = true` without a value.
    #[error("`{effect}` is fixed, but has no value: add `value`")]
    FixedWithoutValue {
        /// The effect.
        effect: String,
    },
    /// A prior without a mean.
    #[error("`std` is the standard deviation of a prior around `value`: add `value`")]
    PriorWithoutValue,
    /// A parameter that is fixed and has a prior.
    #[error("`fixed` holds the value, `std` lets it vary: keep one")]
    FixedWithPrior,
    /// A tied parameter with a value, bounds or a prior of its own.
    #[error("`tie` makes it equal to another parameter, which has the value, bounds and prior: remove `{key}` here")]
    TiedWithOwn {
        /// The key.
        key: &'static str,
    },
    /// Bounds in the wrong order.
    #[error("min = {min} is above max = {max}")]
    MinAboveMax {
        /// Lower bound.
        min: f64,
        /// Upper bound.
        max: f64,
    },
    /// A value outside its own bounds.
    #[error("value = {value} is outside min = {min}, max = {max}")]
    OutsideBounds {
        /// The value.
        value: f64,
        /// Lower bound.
        min: f64,
        /// Upper bound.
        max: f64,
    },
    /// A run that ends before it begins.
    #[error("from = {from} is not before to = {to}")]
    FromAfterTo {
        /// First instant, s.
        from: f64,
        /// Last instant, s.
        to: f64,
    },
    /// Ties that form a cycle.
    #[error("this tie leads back to its own parameter: leave one of them untied")]
    TieCycle,
    /// A campaign without runs.
    #[error("no run: add a [[run]] table with at least `file`")]
    NoRuns,
    /// A campaign without runs that `init` has written, because it could read no log.
    #[error(
        "no run: `hydrosysid init` could read none of the logs; the reasons are given in this file. Repair the logs, \
         or say how to read them (hydrosysid init --help), and call init again: it replaces this file"
    )]
    NoneRead,
    /// A log that does not exist.
    #[error("no such file: {}", .path.display())]
    MissingFile {
        /// Where it was looked for.
        path: PathBuf,
    },
    /// A log that cannot be opened.
    #[error("{} cannot be opened: {}", .path.display(), io_text(*.kind))]
    UnreadableFile {
        /// Where it is.
        path: PathBuf,
        /// Reason for the failure.
        kind: std::io::ErrorKind,
    },
    /// A folder or a device where a log should be.
    #[error("{} is not a file", .path.display())]
    NotAFile {
        /// What was named.
        path: PathBuf,
    },
    /// A log outside the campaign's folder.
    #[error(
        "{} is outside the campaign's folder {}: move it there, or allow files outside",
        .path.display(), .folder.display()
    )]
    OutsideFolder {
        /// Where the path leads.
        path: PathBuf,
        /// The campaign's folder.
        folder: PathBuf,
    },
    /// A wrong property of the vehicle or the water.
    #[error(transparent)]
    Vehicle(VehicleError),
    /// A wrong thruster.
    #[error(transparent)]
    Thruster(ThrusterError),
    /// A wrong efficiency.
    #[error(transparent)]
    Efficiency(EfficiencyError),
    /// A wrong reading option.
    #[error(transparent)]
    Log(OptionsError),
}

pub(in crate::campaign) fn io_text(kind: std::io::ErrorKind) -> String {
    match kind {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::FileTooLarge => "larger than 64 MiB: this is neither a campaign nor a model".into(),
        std::io::ErrorKind::InvalidData => "this is not UTF-8 text".into(),
        other => std::io::Error::from(other).to_string(),
    }
}

fn did_you_mean(nearest: &Option<String>) -> String {
    nearest.as_ref().map(|n| format!(", did you mean `{n}`?")).unwrap_or_default()
}

fn suggest(nearest: &Option<String>, known: &[String]) -> String {
    match (nearest, known) {
        (Some(_), _) => did_you_mean(nearest),
        (None, []) => String::new(),
        (None, known) => format!("; there are {}", known.join(", ")),
    }
}
