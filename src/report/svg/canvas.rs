//! A canvas: SVG elements as text. Colours come from classes only, so the page's light, dark and
//! print modes apply to every figure.

use std::fmt::Write;

use crate::report::label::Label;

/// Width of one character of a label, px, on the generous side, at the 12 px of all figures.
const CHARACTER: f64 = 7.2;

/// Position of a text relative to its point.
#[derive(Debug, Clone, Copy)]
pub enum Anchor {
    /// Begins there.
    Start,
    /// Is centred there.
    Middle,
    /// Ends there.
    End,
}

/// Elements of one figure, in order.
#[derive(Debug, Default)]
pub struct Canvas {
    out: String,
}

impl Canvas {
    /// The elements as SVG text.
    pub fn finish(self) -> String {
        self.out
    }

    /// Adds text that is already SVG.
    pub fn raw(&mut self, svg: &str) {
        self.out.push_str(svg);
    }

    /// Opens a group of `class`, with further attributes that are already escaped.
    pub fn open(&mut self, class: &str, attributes: &str) {
        let gap = if attributes.is_empty() { "" } else { " " };
        self.put(format_args!("<g class=\"{class}\"{gap}{attributes}>"));
    }

    /// Closes the group.
    pub fn close(&mut self) {
        self.out.push_str("</g>");
    }

    /// A straight line from (x1, y1) to (x2, y2).
    pub fn line(&mut self, class: &str, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2]) {
        let (x1, y1, x2, y2) = (px(x1), px(y1), px(x2), px(y2));
        self.put(format_args!("<line class=\"{class}\" x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\"/>"));
    }

    /// A rectangle with a corner at (x, y); a negative size extends to the other side.
    pub fn rect(&mut self, class: &str, [x, y]: [f64; 2], [w, h]: [f64; 2], attributes: &str) {
        let (x, y) = (px(x.min(x + w)), px(y.min(y + h)));
        let (w, h) = (px(w.abs()), px(h.abs()));
        let gap = if attributes.is_empty() { "" } else { " " };
        self.put(format_args!(
            "<rect class=\"{class}\" x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"{gap}{attributes}/>"
        ));
    }

    /// A path; `d` may be empty.
    pub fn path(&mut self, class: &str, d: &str, attributes: &str) {
        let gap = if attributes.is_empty() { "" } else { " " };
        self.put(format_args!("<path class=\"{class}\"{gap}{attributes} d=\"{d}\"/>"));
    }

    /// Text at (x, y); `svg` is already escaped.
    pub fn text(&mut self, class: &str, anchor: Anchor, [x, y]: [f64; 2], svg: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        self.put(format_args!("<text class=\"{class}\" x=\"{}\" y=\"{}\"{anchor}>{svg}</text>", px(x), px(y)));
    }

    /// A legend: names with their swatches in rows that fit `width`. Returns its height, px.
    pub fn legend(&mut self, entries: &[(Swatch, Label)], x: f64, width: f64) -> f64 {
        let (mut at, mut row) = (x, 0.0);
        if entries.is_empty() {
            return 0.0;
        }
        for (swatch, label) in entries {
            let taken = 26.0 + text_width(label) + 16.0;
            if at > x && at + taken > x + width {
                at = x;
                row += 1.0;
            }
            let y = 12.0 + 20.0 * row;
            self.swatch(swatch, at, y - 4.0);
            self.text("name", Anchor::Start, [at + 26.0, y], &label.svg());
            at += taken;
        }
        20.0 * (row + 1.0) + 4.0
    }

    fn swatch(&mut self, swatch: &Swatch, x: f64, y: f64) {
        match swatch {
            Swatch::Line(class) => self.path(class, &format!("M{} {}h20", px(x), px(y)), ""),
            Swatch::Dots(class) => self.path(class, &format!("M{} {}h0m7 0h0m7 0h0", px(x + 3.0), px(y)), ""),
            Swatch::Mark(class, shape) => self.path(class, &shape.path(x + 10.0, y), ""),
            Swatch::Box(class) => self.rect(class, [x + 2.0, y - 5.0], [16.0, 10.0], ""),
        }
    }

    fn put(&mut self, text: std::fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = self.out.write_fmt(text);
    }
}

/// Mark of a name in a legend.
#[derive(Debug, Clone)]
pub enum Swatch {
    /// A piece of line, by its class.
    Line(String),
    /// Dots, by their class.
    Dots(String),
    /// A mark, by its class.
    Mark(String, Shape),
    /// A filled box, by its class.
    Box(String),
}

/// Shapes that are distinct without colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// ●
    Disc,
    /// ■
    Square,
    /// ◆
    Diamond,
    /// ▲
    Triangle,
}

impl Shape {
    /// The shape of the `k`-th source; the four shapes repeat.
    pub fn nth(k: usize) -> Shape {
        [Shape::Disc, Shape::Square, Shape::Diamond, Shape::Triangle][k % 4]
    }

    /// Its outline about (x, y).
    pub fn path(self, x: f64, y: f64) -> String {
        let at = |dx: f64, dy: f64| format!("{} {}", px(x + dx), px(y + dy));
        match self {
            Shape::Disc => format!("M{}a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0 -9 0z", at(-4.5, 0.0)),
            Shape::Square => format!("M{}h8v8h-8z", at(-4.0, -4.0)),
            Shape::Diamond => format!("M{}l5.5 5.5l-5.5 5.5l-5.5 -5.5z", at(0.0, -5.5)),
            Shape::Triangle => format!("M{}l5.2 9h-10.4z", at(0.0, -5.6)),
        }
    }
}

/// A coordinate to a tenth of a pixel, in few characters.
pub fn px(v: f64) -> String {
    let text = format!("{:.1}", v.clamp(-1e5, 1e5));
    let text = text.strip_suffix(".0").unwrap_or(&text);
    if text == "-0" { "0".into() } else { text.into() }
}

/// Width of a label, px: an estimate on the generous side, because no font is available here.
pub fn text_width(label: &Label) -> f64 {
    label.length() as f64 * CHARACTER
}

/// `label` shortened to fit into `width` px, with an ellipsis.
pub fn fitted(label: &Label, width: f64) -> Label {
    let room = ((width / CHARACTER) as usize).max(4);
    match label {
        Label::Plain(text) if text.chars().count() > room => {
            Label::Plain(text.chars().take(room - 1).chain(['…']).collect())
        }
        label => label.clone(),
    }
}
