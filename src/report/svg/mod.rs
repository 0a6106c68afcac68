//! Figures as static SVG.
//!
//! Own code, because the libraries do not fit: plotters 0.3 writes `#RRGGBB` into every element and
//! has no hooks for a script; kuva 0.6 has panels over a shared axis, but also writes colours into
//! the elements, and its script reads values but cannot zoom and has no numbers from which to
//! redraw. A figure for light, dark and print modes that zooms needs its own classes and marks; the
//! rest is text, lines, rectangles and paths.

mod canvas;
mod curves;
mod decimate;
mod heat_map;
mod rows;
mod scale;

use super::chart::{Chart, Figure};
use super::escape::escape;
use super::palette;

pub use decimate::{decimate, thin};
pub(super) use scale::range;

/// Width of a figure on a desk and on paper, px.
pub const WIDE: f64 = 760.0;
/// Width of a figure on a phone, px.
pub const NARROW: f64 = 340.0;

/// The area on which a figure is drawn.
#[derive(Debug, Clone)]
pub struct Sheet {
    /// Width of the drawing, px.
    pub width: f64,
    /// A name that no other figure of the page has; letters, digits and hyphens.
    pub id: String,
    /// Maximum number of points drawn of one series.
    pub points: usize,
}

impl Sheet {
    /// Whether the sheet is narrow, as on a phone: fewer ticks, lower panels, less text.
    fn narrow(&self) -> bool {
        self.width < 500.0
    }

    /// Whether it is one of many side by side.
    fn small(&self) -> bool {
        self.width < 300.0
    }
}

/// Elements and their total height, px.
struct Drawing {
    elements: String,
    height: f64,
}

/// The figure as an `<svg>` element for a page that contains the style sheet of the palette.
pub fn inline(figure: &Figure, sheet: &Sheet) -> String {
    let Drawing { elements, height } = draw(figure, sheet);
    let (width, title) = (sheet.width, escape(&figure.title));
    format!(
        "<svg class=\"chart\" viewBox=\"0 0 {width} {height:.0}\" width=\"{width}\" height=\"{height:.0}\" \
         role=\"img\" aria-label=\"{title}\">{elements}</svg>"
    )
}

/// The figure as a file of its own, with title, style sheet and background. Colours are written as
/// values, so that programs without style variables show it too.
pub fn standalone(figure: &Figure) -> String {
    let sheet = Sheet { width: WIDE, id: "figure".into(), points: 4000 };
    let Drawing { elements, height } = draw(figure, &sheet);
    let (width, whole, title) = (WIDE + 32.0, height + 60.0, escape(&figure.title));
    let style = palette::standalone_style();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" \
         viewBox=\"-16 -44 {width} {whole:.0}\" width=\"{width}\" height=\"{whole:.0}\"><title>{title}</title>\
         <style>{style}</style><rect class=\"sheet\" x=\"-16\" y=\"-44\" width=\"{width}\" height=\"{whole:.0}\"/>\
         <text class=\"title\" x=\"2\" y=\"-20\">{title}</text>{elements}</svg>\n"
    )
}

fn draw(figure: &Figure, sheet: &Sheet) -> Drawing {
    match &figure.chart {
        Chart::Curves(chart) => curves::draw(chart, sheet),
        Chart::Bars(chart) => rows::draw_bars(chart, sheet),
        Chart::HeatMap(chart) => heat_map::draw(chart, sheet),
        Chart::Forest(chart) => rows::draw_forest(chart, sheet),
    }
}
