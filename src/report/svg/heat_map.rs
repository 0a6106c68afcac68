//! A matrix of values: colour shows the large ones, digits give the values.

use super::canvas::{Anchor, Canvas, fitted, text_width};
use super::scale::axis_title;
use super::{Drawing, Sheet};
use crate::report::chart::{Colours, HeatMap};
use crate::report::escape::escape;
use crate::report::label::Label;

/// Greatest opacity of a cell's colour, so that digits stay readable on it.
const STRONGEST: f64 = 0.92;

/// Room for the longest name of a column, px.
const LONGEST: f64 = 150.0;

/// Orientation of the names of the columns.
#[derive(Clone, Copy)]
enum Heads {
    Level,
    Slanted,
    Upright,
}

/// Draws the matrix on a sheet.
pub fn draw(chart: &HeatMap, sheet: &Sheet) -> Drawing {
    let mut canvas = Canvas::default();
    let widest = chart.rows.iter().map(text_width).fold(0.0, f64::max) + 12.0;
    let left = widest.clamp(30.0, if sheet.narrow() { 0.3 } else { 0.34 } * sheet.width);
    let columns = chart.columns.len().max(1) as f64;
    let longest = chart.columns.iter().map(text_width).fold(0.0, f64::max).min(LONGEST);
    let whole = ((sheet.width - left - 2.0) / columns).min(86.0);
    let heads = match (longest > whole - 4.0, sheet.narrow()) {
        (false, _) => Heads::Level,
        (true, false) => Heads::Slanted,
        (true, true) => Heads::Upright,
    };
    // Slanted names extend to the right of the last column; the others stay within it.
    let (head, lean) = match heads {
        Heads::Level => (20.0, 0.0),
        Heads::Slanted => (0.62 * longest + 20.0, 0.79 * longest),
        Heads::Upright => (longest + 12.0, 0.0),
    };
    let width = whole.min((sheet.width - left - lean) / (columns - 0.5));
    let height = width.clamp(26.0, 36.0);
    canvas.text("axis-title", Anchor::Start, [2.0, 13.0], &axis_title(&chart.value, 0, sheet.width - 4.0));
    let top = 22.0 + if chart.x.label.text().is_empty() { 0.0 } else { 20.0 } + head;
    if !chart.x.label.text().is_empty() {
        canvas.text(
            "axis-title",
            Anchor::Start,
            [left, 34.0],
            &format!("{} →", axis_title(&chart.x, 0, sheet.width - left - 20.0)),
        );
    }
    if !chart.y.label.text().is_empty() {
        canvas.text(
            "axis-title",
            Anchor::End,
            [left - 9.0, top - 6.0],
            &format!("{} ↓", axis_title(&chart.y, 0, left - 24.0)),
        );
    }
    for (c, label) in chart.columns.iter().enumerate() {
        let x = left + width * (c as f64 + 0.5);
        let text = fitted(label, LONGEST).svg();
        let turned = |x: f64, angle: i32| {
            let place = format!("translate({x:.1} {:.1}) rotate({angle})", top - 6.0);
            format!("<text class=\"row-name\" transform=\"{place}\">{text}</text>")
        };
        match heads {
            Heads::Level => canvas.text("row-name", Anchor::Middle, [x, top - 6.0], &text),
            Heads::Slanted => canvas.raw(&turned(x, -38)),
            Heads::Upright => canvas.raw(&turned(x + 4.0, -90)),
        }
    }
    let size = [width * chart.columns.len() as f64, height * chart.rows.len() as f64];
    canvas.rect("cell", [left, top], size, "");
    for (r, label) in chart.rows.iter().enumerate() {
        let y = top + height * r as f64;
        let name = fitted(label, left - 9.0).svg();
        canvas.text("row-name", Anchor::End, [left - 9.0, y + height / 2.0 + 4.0], &name);
        let values = chart.values.get(r).map_or(&[][..], Vec::as_slice);
        for (c, value) in values.iter().enumerate().take(chart.columns.len()) {
            let x = left + width * c as f64;
            let (class, strength) = colour(*value, chart.colours);
            // kept short: there are hundreds of cells
            canvas.raw(&format!(
                "<rect class=\"{class}\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill-opacity=\"{:.2}\"><title>{} | {}: {}</title></rect>",
                x + 1.0,
                y + 1.0,
                width - 2.0,
                height - 2.0,
                STRONGEST * strength,
                escape(label.text()),
                escape(chart.columns.get(c).map_or("", Label::text)),
                digits(*value, chart.decimals)
            ));
            if value.is_finite() && width >= 22.0 {
                let class = if strength > 0.6 { "digits strong" } else { "digits" };
                canvas.text(
                    class,
                    Anchor::Middle,
                    [x + width / 2.0, y + height / 2.0 + 4.0],
                    &fitting(*value, chart.decimals, width - 2.0),
                );
            }
        }
    }
    Drawing { elements: canvas.finish(), height: top + height * chart.rows.len() as f64 + 4.0 }
}

/// Class and strength (0 to 1) of the colour of a value.
fn colour(value: f64, colours: Colours) -> (&'static str, f64) {
    if !value.is_finite() {
        return ("heat none", 0.0);
    }
    let share = |part: f64, whole: f64| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
    match colours {
        Colours::Diverging { limit } if value < 0.0 => ("heat low", share(-value, limit)),
        Colours::Diverging { limit } => ("heat high", share(value, limit)),
        Colours::Sequential { low, high } => ("heat high", share(value - low, high - low)),
    }
}

/// The value with as many decimals as fit into the cell, if necessary without the leading 0; empty
/// if a number below 1 would become a 0 or a 1.
fn fitting(value: f64, decimals: usize, room: f64) -> String {
    let fewest = usize::from(value.abs() < 1.0).min(decimals);
    let texts = (fewest..=decimals).rev().flat_map(|decimals| {
        let text = digits(value, decimals);
        let zero = text.bytes().all(|b| b == b'0' || b == b'.');
        let short = if zero { "0".to_string() } else { text.replacen("0.", ".", 1) };
        [text.clone(), if value.abs() < 1.0 { short } else { text }]
    });
    let mut narrow = texts.skip_while(|text| text_width(&Label::from(text.as_str())) > room);
    narrow.next().unwrap_or_default()
}

fn digits(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| b == b'0' || b == b'.') => rest.to_string(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_cell_gives_up_decimals() {
        assert_eq!(fitting(117.13, 1, 80.0), "117.1");
        assert_eq!(fitting(117.13, 1, 26.0), "117");
        let room = text_width(&Label::from("−.6"));
        assert_eq!(fitting(-0.56, 2, room), "−.6", "and never −1");
        assert_eq!(fitting(0.01, 2, text_width(&Label::from("0"))), "0");
        assert_eq!(fitting(0.25, 2, 3.0), "");
    }
}
