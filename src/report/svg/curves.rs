//! Lines and points in panels over a shared abscissa.
//!
//! The script of the page redraws these figures when the reader zooms: it finds the panels by
//! `data-box` (their frame in px) and `data-range` (values at its corners), the series by `data-k`,
//! their numbers in the embedded data.

use super::canvas::{Anchor, Canvas, Swatch, px, text_width};
use super::decimate::{decimate, thin};
use super::scale::{Scale, Ticks, axis_title, range, ticks};
use super::{Drawing, Sheet};
use crate::report::chart::{Curves, Mark, Panel, Series};
use crate::report::escape::escape;
use crate::report::label::Label;

/// Up to this number of points, each gets a larger dot.
const FEW: usize = 120;

/// Draws the chart on a sheet.
pub fn draw(chart: &Curves, sheet: &Sheet) -> Drawing {
    let mut canvas = Canvas::default();
    let series = || chart.panels.iter().flat_map(|p| &p.series);
    // with few points the frame must not cut a point in half; a long record fills the frame
    let few = series().any(|s| s.mark == Mark::Points && (1..=FEW).contains(&s.len()));
    let pad = if few { 0.02 } else { 0.0 };
    let (x_low, x_high) = range(series().flat_map(|s| s.x.iter().copied()), pad);
    let x_ticks = ticks(x_low, x_high, if sheet.narrow() { 4 } else { 8 });
    let ranges: Vec<(f64, f64)> = chart.panels.iter().map(|p| range(ordinates(p), 0.05)).collect();
    let y_ticks: Vec<Ticks> =
        ranges.iter().enumerate().map(|(k, (low, high))| ticks(*low, *high, if k == 0 { 5 } else { 3 })).collect();
    let widest =
        y_ticks.iter().flat_map(|t| &t.labels).map(|l| text_width(&Label::Plain(l.clone()))).fold(0.0, f64::max);
    let left = (widest + 10.0).max(30.0);
    let x = Scale { low: x_low, high: x_high, from: left, to: sheet.width - 12.0 };

    let mut top = canvas.legend(&legend(chart), 2.0, sheet.width - 4.0);
    for (k, panel) in chart.panels.iter().enumerate() {
        let height = match (k, sheet.narrow()) {
            (0, false) => 270.0,
            (0, true) if sheet.small() => 110.0,
            (0, true) => 210.0,
            (_, false) => 84.0,
            (_, true) => 70.0,
        };
        canvas.text(
            "axis-title",
            Anchor::Start,
            [2.0, top + 13.0],
            &axis_title(&panel.y, y_ticks[k].power, sheet.width - 4.0),
        );
        top += 22.0;
        let (low, high) = ranges[k];
        let y = Scale { low, high, from: top + height, to: top };
        draw_panel(
            &mut canvas,
            chart,
            k,
            &Frame { x, y, power: [x_ticks.power, y_ticks[k].power] },
            sheet,
            [&x_ticks, &y_ticks[k]],
        );
        top += height + if k + 1 < chart.panels.len() { 8.0 } else { 0.0 };
    }
    canvas.open("lx", &format!("data-y=\"{}\"", px(top + 17.0)));
    for (at, label) in x_ticks.at.iter().zip(&x_ticks.labels) {
        canvas.text("tick", Anchor::Middle, [x.px(*at), top + 17.0], label);
    }
    canvas.close();
    canvas.text(
        "axis-title",
        Anchor::End,
        [x.to, top + 36.0],
        &axis_title(&chart.x, x_ticks.power, sheet.width - 14.0),
    );
    Drawing { elements: canvas.finish(), height: top + 44.0 }
}

struct Frame {
    x: Scale,
    y: Scale,
    power: [i32; 2],
}

fn draw_panel(canvas: &mut Canvas, chart: &Curves, k: usize, frame: &Frame, sheet: &Sheet, [tx, ty]: [&Ticks; 2]) {
    let Frame { x, y, power } = frame;
    let panel = &chart.panels[k];
    let (left, top, width, height) = (x.from, y.to, x.to - x.from, y.from - y.to);
    canvas.open(
        "panel",
        &format!(
            "data-p=\"{k}\" data-box=\"{} {} {} {}\" data-range=\"{:e} {:e} {:e} {:e}\" data-power=\"{} {}\"",
            px(left),
            px(top),
            px(width),
            px(height),
            x.low,
            x.high,
            y.low,
            y.high,
            power[0],
            power[1]
        ),
    );
    let clip = format!("{}-{k}", sheet.id);
    canvas.raw(&format!("<clipPath id=\"{}\">", escape(&clip)));
    canvas.rect("clip", [left, top], [width, height], "");
    canvas.raw("</clipPath>");
    canvas.open("gx", "");
    for at in &tx.at {
        canvas.line("grid", [x.px(*at), top], [x.px(*at), top + height]);
    }
    canvas.close();
    canvas.open("gy", "");
    for (at, label) in ty.at.iter().zip(&ty.labels) {
        canvas.line(if *at == 0.0 { "zero" } else { "grid" }, [left, y.px(*at)], [left + width, y.px(*at)]);
        canvas.text("tick", Anchor::End, [left - 7.0, y.px(*at) + 4.0], label);
    }
    canvas.close();
    canvas.raw(&format!("<g clip-path=\"url(#{})\">", escape(&clip)));
    for (n, span) in chart.spans.iter().enumerate() {
        let d = rectangle(x.px(span.from), x.px(span.to), top, top + height);
        canvas.path("span", &d, &format!("data-span=\"{n}\""));
    }
    if let Some(floor) = panel.floor {
        canvas.path("floor", &rectangle(left, left + width, y.px(-floor), y.px(floor)), "data-floor=\"1\"");
    }
    for (n, series) in panel.series.iter().enumerate() {
        let limit = sheet.points.min(2 * width as usize);
        let kept = match series.mark {
            Mark::Line => decimate(&series.y[..series.len()], limit),
            Mark::Points => thin(&series.y[..series.len()], limit),
        };
        let (mark, interval) = (mark_class(panel, n), interval_class(panel, n));
        if !series.interval.is_empty() {
            canvas.path(&interval, &interval_path(series, &kept, x, y), &format!("data-i=\"{n}\""));
        }
        let d = match series.mark {
            Mark::Line => line_path(series, &kept, x, y),
            Mark::Points => dots_path(series, &kept, x, y),
        };
        canvas.path(&mark, &d, &format!("data-k=\"{n}\""));
    }
    canvas.raw("</g>");
    canvas.rect("frame", [left, top], [width, height], "");
    canvas.close();
}

/// Class of the `n`-th series: each has its own tone, but the first points beside lines (the
/// measurement) are grey, so that the same model has the same tone in every panel.
fn tone(panel: &Panel, n: usize) -> String {
    let lines = panel.series.iter().any(|s| s.mark == Mark::Line);
    let first_points = panel.series.iter().position(|s| s.mark == Mark::Points);
    if lines && first_points == Some(n) {
        return "t0".into();
    }
    let before = panel.series[..n].iter().enumerate().filter(|(k, _)| !(lines && first_points == Some(*k))).count();
    format!("t{}", before % 6 + 1)
}

fn mark_class(panel: &Panel, n: usize) -> String {
    let kind = match panel.series[n].mark {
        Mark::Line => "line",
        Mark::Points if panel.series[n].len() <= FEW => "dots few",
        Mark::Points => "dots",
    };
    format!("{kind} {}", tone(panel, n))
}

fn interval_class(panel: &Panel, n: usize) -> String {
    let kind = match panel.series[n].mark {
        Mark::Line => "band",
        Mark::Points => "bars",
    };
    format!("{kind} {}", tone(panel, n))
}

fn legend(chart: &Curves) -> Vec<(Swatch, Label)> {
    let mut entries: Vec<(Swatch, Label)> = Vec::new();
    for panel in &chart.panels {
        for (n, series) in panel.series.iter().enumerate() {
            if series.name.text().is_empty() || entries.iter().any(|(_, name)| *name == series.name) {
                continue;
            }
            let class = mark_class(panel, n);
            let swatch = match series.mark {
                Mark::Line => Swatch::Line(class),
                Mark::Points => Swatch::Dots(class),
            };
            entries.push((swatch, series.name.clone()));
        }
    }
    let mut spans: Vec<&str> = chart.spans.iter().map(|s| s.label.as_str()).filter(|l| !l.is_empty()).collect();
    spans.dedup();
    entries.extend(spans.into_iter().map(|label| (Swatch::Box("span".into()), label.into())));
    entries
}

fn ordinates(panel: &Panel) -> impl Iterator<Item = f64> {
    let drawn = panel.series.iter().flat_map(|s| s.y.iter().copied());
    let intervals = panel.series.iter().flat_map(|s| s.interval.iter().flat_map(|(low, high)| [*low, *high]));
    drawn.chain(intervals).chain(panel.floor.into_iter().flat_map(|f| [-f, f]))
}

fn line_path(series: &Series, kept: &[usize], x: &Scale, y: &Scale) -> String {
    let points = kept.iter().map(|k| (x.px(series.x[*k]), y.px(series.y[*k])));
    joined(points)
}

/// A path of relative moves in tenths of a pixel, which need about half the characters of absolute
/// ones. Rounding errors do not add up because each move starts at the rounded pen position.
fn joined(points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut d = String::new();
    let mut pen: Option<(f64, f64)> = None;
    for (px_x, px_y) in points {
        if !(px_x.is_finite() && px_y.is_finite()) {
            pen = None;
            continue;
        }
        let at = (tenth(px_x), tenth(px_y));
        match pen {
            None => d.push_str(&format!("M{} {}", px(at.0), px(at.1))),
            Some(from) => d.push_str(&format!("l{} {}", px(at.0 - from.0), px(at.1 - from.1))),
        }
        pen = Some(at);
    }
    d
}

fn dots_path(series: &Series, kept: &[usize], x: &Scale, y: &Scale) -> String {
    let dot = |k: &usize| {
        let (a, b) = (x.px(series.x[*k]), y.px(series.y[*k]));
        if a.is_finite() && b.is_finite() { format!("M{} {}h0", px(a), px(b)) } else { String::new() }
    };
    kept.iter().map(dot).collect()
}

fn interval_path(series: &Series, kept: &[usize], x: &Scale, y: &Scale) -> String {
    let ends = |k: usize| {
        let (low, high) = *series.interval.get(k)?;
        let all = [x.px(series.x[k]), y.px(low), y.px(high)];
        all.iter().all(|v| v.is_finite()).then_some(all)
    };
    let inside: Vec<[f64; 3]> = kept.iter().filter_map(|k| ends(*k)).collect();
    if series.mark == Mark::Points {
        return inside.iter().map(|[x, low, high]| format!("M{} {}V{}", px(*x), px(*low), px(*high))).collect();
    }
    if inside.is_empty() {
        return String::new();
    }
    let upper = inside.iter().map(|[x, _, high]| (*x, *high));
    let lower = inside.iter().rev().map(|[x, low, _]| (*x, *low));
    joined(upper.chain(lower)) + "z"
}

fn rectangle(x1: f64, x2: f64, y1: f64, y2: f64) -> String {
    format!("M{} {}H{}V{}H{}z", px(x1), px(y1), px(x2), px(y2), px(x1))
}

fn tenth(v: f64) -> f64 {
    (v.clamp(-1e5, 1e5) * 10.0).round() / 10.0
}
