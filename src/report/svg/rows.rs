//! Charts of rows: bars, waterfall and forest plot, with names on the left and one axis below.

use super::canvas::{Anchor, Canvas, Shape, Swatch, fitted, text_width};
use super::scale::{Scale, axis_title, range, ticks};
use super::{Drawing, Sheet};
use crate::report::chart::{Axis, Bars, Forest};
use crate::report::escape::escape;
use crate::report::label::Label;
use crate::report::number::{Style, estimate};

/// Draws bars or a waterfall on a sheet.
pub fn draw_bars(chart: &Bars, sheet: &Sheet) -> Drawing {
    let mut canvas = Canvas::default();
    let mut ends: Vec<[f64; 2]> = Vec::new();
    for bar in &chart.bars {
        let start = match ends.last() {
            Some([_, end]) if chart.waterfall && !bar.total => *end,
            _ => 0.0,
        };
        ends.push([start, if chart.waterfall && !bar.total { start + bar.value } else { bar.value }]);
    }
    let whiskers = chart.bars.iter().zip(&ends).flat_map(|(bar, [_, end])| {
        let std = bar.std.unwrap_or(0.0);
        [end - std, end + std]
    });
    let reference = chart.reference.iter().map(|(_, value)| *value);
    let values = ends.iter().flatten().copied().chain(whiskers).chain(reference).chain([0.0]);
    let (low, high) = range(values, 0.0);
    let texts: Vec<String> =
        chart.bars.iter().map(|bar| signed(bar.value, bar.std, chart.waterfall && !bar.total)).collect();
    let room = texts.iter().map(|t| text_width(&Label::from(t.as_str()))).fold(0.0, f64::max) + 10.0;
    let labels: Vec<&Label> = chart.bars.iter().map(|b| &b.label).collect();
    let columns = Columns::new(&labels, room, sheet);
    let legend: Vec<(Swatch, Label)> =
        chart.reference.iter().map(|(name, _)| (Swatch::Line("reference".into()), name.as_str().into())).collect();
    let top = canvas.legend(&legend, 2.0, sheet.width - 4.0);
    let (row, bottom) = (30.0, top + 30.0 * chart.bars.len() as f64 + 4.0);
    let x = Scale { low, high, from: columns.left, to: columns.right };
    draw_axis(&mut canvas, &chart.axis, &x, [top, bottom], sheet);
    for (k, (bar, [start, end])) in chart.bars.iter().zip(&ends).enumerate() {
        let middle = top + row * (k as f64 + 0.5) + 2.0;
        canvas.text("row-name", Anchor::End, [columns.left - 9.0, middle + 4.0], &columns.name(&bar.label).svg());
        let class = match (chart.waterfall && !bar.total, end < start) {
            (false, _) => "bar total",
            (true, true) => "bar down",
            (true, false) => "bar up",
        };
        if start.is_finite() && end.is_finite() {
            canvas.rect(class, [x.px(*start), middle - 9.0], [x.px(*end) - x.px(*start), 18.0], "rx=\"2\"");
        }
        if let Some(std) = bar.std.filter(|s| s.is_finite() && end.is_finite()) {
            canvas.line("whisker", [x.px(end - std), middle], [x.px(end + std), middle]);
        }
        if chart.waterfall && k + 1 < chart.bars.len() && end.is_finite() {
            canvas.line("joint", [x.px(*end), middle + 9.0], [x.px(*end), middle + row - 9.0]);
        }
        canvas.text("value", Anchor::End, [sheet.width - 2.0, middle + 4.0], &escape(&texts[k]));
    }
    if let Some((_, value)) = chart.reference.as_ref().filter(|(_, v)| v.is_finite()) {
        canvas.line("reference", [x.px(*value), top], [x.px(*value), bottom]);
    }
    Drawing { elements: canvas.finish(), height: bottom + 44.0 }
}

/// Draws a forest plot on a sheet.
pub fn draw_forest(chart: &Forest, sheet: &Sheet) -> Drawing {
    let mut canvas = Canvas::default();
    let mut sources: Vec<&str> = Vec::new();
    for interval in chart.rows.iter().flat_map(|row| &row.estimates) {
        if !sources.contains(&interval.source.as_str()) {
            sources.push(&interval.source);
        }
    }
    let all = chart.rows.iter().flat_map(|row| &row.estimates);
    let (low, high) = range(all.clone().flat_map(|i| [i.value, i.low, i.high]).chain(chart.reference), 0.04);
    let written = if sheet.narrow() { 0.0 } else { all.map(|i| i.text.chars().count()).max().unwrap_or(0) as f64 };
    let labels: Vec<&Label> = chart.rows.iter().map(|r| &r.label).collect();
    let columns = Columns::new(&labels, if written > 0.0 { 6.4 * written + 14.0 } else { 10.0 }, sheet);
    let entry =
        |(k, name): (usize, &&str)| (Swatch::Mark(format!("mark t{}", k % 6 + 1), Shape::nth(k)), Label::from(*name));
    let legend: Vec<(Swatch, Label)> = sources.iter().enumerate().map(entry).collect();
    let top = canvas.legend(&legend, 2.0, sheet.width - 4.0);
    let line = 19.0;
    let lines: usize = chart.rows.iter().map(|r| r.estimates.len().max(1)).sum();
    let bottom = top + line * lines as f64 + 10.0 * chart.rows.len() as f64;
    let x = Scale { low, high, from: columns.left, to: columns.right };
    draw_axis(&mut canvas, &chart.axis, &x, [top, bottom], sheet);
    if let Some(value) = chart.reference.filter(|v| v.is_finite()) {
        canvas.line("reference", [x.px(value), top], [x.px(value), bottom]);
    }
    let mut at = top;
    for (k, row) in chart.rows.iter().enumerate() {
        let height = line * row.estimates.len().max(1) as f64 + 10.0;
        if k > 0 {
            canvas.line("rule", [0.0, at], [sheet.width, at]);
        }
        let name = columns.name(&row.label).svg();
        canvas.text("row-name", Anchor::End, [columns.left - 9.0, at + height / 2.0 + 4.0], &name);
        for (n, interval) in row.estimates.iter().enumerate() {
            let y = at + 5.0 + line * (n as f64 + 0.5);
            let source = sources.iter().position(|s| *s == interval.source).unwrap_or(0);
            let tone = format!("t{}", source % 6 + 1);
            if interval.low.is_finite() && interval.high.is_finite() {
                canvas.line(&format!("interval {tone}"), [x.px(interval.low), y], [x.px(interval.high), y]);
            }
            if interval.value.is_finite() {
                canvas.path(&format!("mark {tone}"), &Shape::nth(source).path(x.px(interval.value), y), "");
            }
            if !sheet.narrow() {
                canvas.text("value", Anchor::End, [sheet.width - 2.0, y + 4.0], &escape(&interval.text));
            }
        }
        at += height;
    }
    Drawing { elements: canvas.finish(), height: bottom + 44.0 }
}

/// End of the column of names and start of the texts on the right, px.
struct Columns {
    left: f64,
    right: f64,
}

impl Columns {
    fn new(labels: &[&Label], room: f64, sheet: &Sheet) -> Columns {
        let widest = labels.iter().map(|l| text_width(l)).fold(0.0, f64::max) + 12.0;
        let most = if sheet.narrow() { 0.36 } else { 0.3 };
        Columns { left: widest.clamp(30.0, most * sheet.width), right: sheet.width - room }
    }

    fn name(&self, label: &Label) -> Label {
        fitted(label, self.left - 9.0)
    }
}

fn draw_axis(canvas: &mut Canvas, axis: &Axis, x: &Scale, [top, bottom]: [f64; 2], sheet: &Sheet) {
    let ticks = ticks(x.low, x.high, if sheet.narrow() { 3 } else { 6 });
    for (at, label) in ticks.at.iter().zip(&ticks.labels) {
        canvas.line(if *at == 0.0 { "zero" } else { "grid" }, [x.px(*at), top], [x.px(*at), bottom]);
        canvas.text("tick", Anchor::Middle, [x.px(*at), bottom + 17.0], label);
    }
    let title = axis_title(axis, ticks.power, sheet.width - 4.0);
    // A long title may begin left of the axis, but not left of the sheet.
    let end = (text_width(&axis.label) + 80.0).clamp(x.to, (sheet.width - 2.0).max(x.to));
    canvas.text("axis-title", Anchor::End, [end, bottom + 36.0], &title);
}

fn signed(value: f64, std: Option<f64>, change: bool) -> String {
    let text = match std {
        Some(_) => estimate(value, std, Style::Text),
        None => crate::report::number::number(value, 3, Style::Text),
    };
    if change && value > 0.0 { format!("+{text}") } else { text }
}
