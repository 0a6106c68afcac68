//! What a report says, as plain data; it knows nothing of identification and nothing of HTML.
//!
//! A document is a verdict, the checks it rests on, what stands on the first screen, and sections of paragraphs and blocks
//! (tables, figures, equations, definitions). Other rooms fill it; [`super::html`] makes one file of it.

use super::chart::Figure;
use super::label::Label;

/// A whole report.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Document {
    /// What the report is about.
    pub title: String,
    /// One line below the title: vehicle, campaign, date.
    pub subtitle: String,
    /// The answer, in one sentence.
    pub verdict: String,
    /// What the verdict rests on.
    pub checks: Vec<Check>,
    /// What the answer is seen in: the first screen, before the contents.
    pub first_screen: Vec<Block>,
    /// The body.
    pub sections: Vec<Section>,
    /// How this report came to be.
    pub origin: Origin,
}

/// How a check came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Light {
    /// In order.
    Green,
    /// To be kept in mind.
    Amber,
    /// Not to be trusted.
    Red,
}

/// One thing that was checked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Check {
    /// How it came out.
    pub light: Light,
    /// Short stable name, the same as in the JSON output.
    pub code: String,
    /// One sentence for people.
    pub text: String,
}

/// A heading and what stands under it: first the paragraphs, then the blocks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Section {
    /// Heading.
    pub heading: String,
    /// Running text.
    pub paragraphs: Vec<String>,
    /// Tables, figures, equations, definitions, in order.
    pub blocks: Vec<Block>,
    /// Whether the blocks are shown on demand alone.
    pub folded: bool,
}

/// What can stand in a section.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a document has dozens of blocks; a box would burden every caller")]
pub enum Block {
    /// Rows and columns.
    Table(Table),
    /// A figure.
    Figure(Figure),
    /// Small figures side by side.
    Multiples(Multiples),
    /// Equations, each with a word on it.
    Equations(Vec<Equation>),
    /// Terms and what they mean.
    Definitions(Vec<Definition>),
}

/// Small figures side by side, to be compared at a glance.
#[derive(Debug, Clone, PartialEq)]
pub struct Multiples {
    /// What they show.
    pub title: String,
    /// What the reader should see in them; may be empty.
    pub caption: String,
    /// The figures; of each the title stands above it, the caption is not shown.
    pub figures: Vec<Figure>,
}

/// One equation, in Unicode; `_` lowers and `^` raises (see [`Label::Symbol`]).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Equation {
    /// `m_u·u̇ = τ_u − k_u|u|·|u|·u`.
    pub formula: String,
    /// What it says, or where it comes from; may be empty.
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

/// A table of equally long rows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// What the table shows.
    pub title: String,
    /// Heads of the columns.
    pub columns: Vec<Column>,
    /// Cells, row by row; a row that is too short ends in empty cells.
    pub rows: Vec<Vec<Cell>>,
    /// A word below the table; may be empty.
    pub note: String,
}

/// Head of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name of what stands in it.
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
    /// A number to so many significant digits.
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
    /// Whether nothing stands in it.
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

/// How a report came to be: enough to make it again.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Origin {
    /// Name and version of the program.
    pub version: String,
    /// The command that was given.
    pub command: String,
    /// The files that were read.
    pub inputs: Vec<Input>,
    /// Seed of everything random; `None` when nothing was.
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
