//! Content of a report as plain data, independent of identification and of HTML.
//!
//! A document consists of a verdict, the checks that support it, the blocks of the first screen,
//! and sections of paragraphs and blocks (tables, figures, equations, definitions). Other modules
//! fill it; [`super::html`] renders it as one file.

use super::chart::Figure;
use super::label::Label;

/// A whole report.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Document {
    /// Subject of the report.
    pub title: String,
    /// One line below the title: vehicle, campaign, date.
    pub subtitle: String,
    /// The answer, in one sentence.
    pub verdict: String,
    /// The checks that support the verdict.
    pub checks: Vec<Check>,
    /// Blocks of the first screen, before the contents, which show the answer.
    pub first_screen: Vec<Block>,
    /// The body.
    pub sections: Vec<Section>,
    /// How this report was made.
    pub origin: Origin,
}

/// Result of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Light {
    /// In order.
    Green,
    /// To be kept in mind.
    Amber,
    /// Not to be trusted.
    Red,
}

/// One check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Check {
    /// Its result.
    pub light: Light,
    /// Short stable name, the same as in the JSON output.
    pub code: String,
    /// One sentence for people.
    pub text: String,
}

/// A heading and its content: first the paragraphs, then the blocks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Section {
    /// Heading.
    pub heading: String,
    /// Running text.
    pub paragraphs: Vec<String>,
    /// Tables, figures, equations, definitions, in order.
    pub blocks: Vec<Block>,
    /// Whether the blocks are shown only on demand.
    pub folded: bool,
}

/// A block of a section.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a document has dozens of blocks; a box would burden every caller")]
pub enum Block {
    /// Rows and columns.
    Table(Table),
    /// A figure.
    Figure(Figure),
    /// Small figures side by side.
    Multiples(Multiples),
    /// Equations, each with a note.
    Equations(Vec<Equation>),
    /// Terms and their meaning.
    Definitions(Vec<Definition>),
}

/// Small figures side by side, for comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Multiples {
    /// What they show.
    pub title: String,
    /// What the reader should see in them; may be empty.
    pub caption: String,
    /// The figures; each title is shown above its figure, the captions are not shown.
    pub figures: Vec<Figure>,
}

/// One equation, in Unicode; `_` makes a subscript and `^` a superscript (see [`Label::Symbol`]).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Equation {
    /// `m_u·u̇ = τ_u − k_u|u|·|u|·u`.
    pub formula: String,
    /// Its meaning or source; may be empty.
    pub note: String,
}

/// A term and its meaning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Definition {
    /// The term.
    pub term: Label,
    /// Its meaning.
    pub meaning: String,
}

/// A table with rows of equal length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// What the table shows.
    pub title: String,
    /// Headers of the columns.
    pub columns: Vec<Column>,
    /// Cells, row by row; a row that is too short is filled with empty cells.
    pub rows: Vec<Vec<Cell>>,
    /// A note below the table; may be empty.
    pub note: String,
}

/// Header of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name of its content.
    pub name: Label,
    /// Unit of the whole column; empty for none.
    pub unit: String,
}

impl Column {
    /// A column `name`, its values in `unit` (empty for none).
    pub fn new(name: impl Into<Label>, unit: &str) -> Column {
        Column { name: name.into(), unit: unit.into() }
    }
}

/// One cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Nothing.
    Empty,
    /// Words or a symbol.
    Text(Label),
    /// A number with a given number of significant digits.
    Number {
        /// The number, in the column's unit.
        value: f64,
        /// Significant digits, 1 to 15.
        digits: u32,
    },
    /// A value and its standard deviation; without one the value was held.
    Estimate {
        /// The value, in the column's unit.
        value: f64,
        /// Its standard deviation, in the same unit.
        std: Option<f64>,
    },
}

impl Cell {
    /// Whether the cell has no content.
    pub fn is_empty(&self) -> bool {
        match self {
            Cell::Empty => true,
            Cell::Text(label) => label.text().is_empty(),
            Cell::Number { .. } | Cell::Estimate { .. } => false,
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Cell {
        Cell::Text(text.into())
    }
}

/// How a report was made, in enough detail to repeat it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Origin {
    /// Name and version of the program.
    pub version: String,
    /// The command that was given.
    pub command: String,
    /// The files that were read.
    pub inputs: Vec<Input>,
    /// Seed of the random numbers; `None` if there were none.
    pub seed: Option<u64>,
}

/// A file that was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// Its name, as the campaign gives it.
    pub name: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}
