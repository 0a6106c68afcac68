//! Reports: a document as data, and its rendering as one HTML file.
//!
//! [`Document`] contains the content; [`render`] makes one self-contained file (no network, below
//! 2 MB, light, dark, phone, paper); [`svg::standalone`] makes a file of one figure;
//! [`terminal::plot`] shows curves in a terminal. This module does not depend on identification:
//! other modules fill the document.
//!
//! ```
//! use hydrosysid::report::{Axis, Block, Chart, Curves, Document, Figure, Panel, Section, Series, render};
//!
//! let time: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(k)).collect();
//! let speed = time.iter().map(|t| 0.5 * (1.0 - (-t / 3.0).exp())).collect();
//! let series = vec![Series::line("simulated", time, speed)];
//! let panel = Panel { y: Axis::new("Surge velocity", "m/s"), series, floor: None };
//! let chart = Chart::Curves(Curves { x: Axis::new("Time", "s"), panels: vec![panel], spans: vec![] });
//! let figure = Figure { title: "A step of thrust".into(), caption: String::new(), chart };
//! let section = Section {
//!     heading: "Runs".into(),
//!     paragraphs: vec![],
//!     blocks: vec![Block::Figure(figure)],
//!     folded: false,
//! };
//! let page = render(&Document { title: "Surge".into(), sections: vec![section], ..Document::default() });
//! assert!(page.starts_with("<!doctype html>"));
//! ```

mod chart;
mod data;
mod document;
mod escape;
mod html;
mod label;
mod number;
mod palette;
pub mod svg;
mod table;
pub mod terminal;

pub use chart::{
    Axis, Bar, Bars, Chart, Colours, Curves, Figure, Forest, ForestRow, HeatMap, Interval, Mark, Panel, Series, Span,
};
pub use document::{
    Block, Cell, Check, Column, Definition, Document, Equation, Input, Light, Multiples, Origin, Section, Table,
};
pub use html::{SCRIPT, figure, figure_style, page_style, render};
pub use label::{Label, unit};
pub use number::{Style, estimate, exact, number};
