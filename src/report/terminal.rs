//! Curves in a terminal: a plot in braille dots that fits the terminal's width and needs no colour.
//!
//! Own code: textplots 0.8 draws all series with the same dots, in f32, and kuva's terminal backend
//! requires all of kuva. A character has 2 × 4 dots, U+2800 plus one bit per dot. Lines are braille
//! and points are `o`, so that measured and simulated values are distinct without colour.

use super::chart::{Axis, Curves, Mark, Panel, Series};
use super::label::unit;
use super::number::{Style, number};
use super::svg::{decimate, range};

/// Bits of the dots of a braille character, [row][column].
const DOTS: [[u32; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];

/// The first panel of the chart in at most `width` × `height` characters, with axes and legend;
/// each line ends with a line feed. The least size is 30 × 8.
pub fn plot(chart: &Curves, width: usize, height: usize) -> String {
    let Some(panel) = chart.panels.first() else { return String::new() };
    let (width, rows) = (width.max(30), height.max(8) - 4);
    let (x0, x1) = range(panel.series.iter().flat_map(|s| s.x.iter().copied()), 0.0);
    let (y0, y1) = range(panel.series.iter().flat_map(|s| s.y.iter().copied()), 0.02);
    let ends = [number(y1, 3, Style::Text), number(y0, 3, Style::Text)];
    let left = ends.iter().map(|e| e.chars().count()).max().unwrap_or(0);
    let mut screen = Screen::new(width - left - 2, rows);
    for series in &panel.series {
        draw(&mut screen, series, [x0, x1], [y0, y1]);
    }
    let mut out = cut(&title(&panel.y), width);
    for row in 0..rows {
        let end = match row {
            0 => ends[0].as_str(),
            r if r + 1 == rows => ends[1].as_str(),
            _ => "",
        };
        let pad = left - end.chars().count();
        out.push_str(&format!("{}{end} │{}\n", " ".repeat(pad), screen.row(row).trim_end()));
    }
    let (from, to) = (number(x0, 3, Style::Text), number(x1, 3, Style::Text));
    out.push_str(&format!("{} └{}\n", " ".repeat(left), "─".repeat(screen.columns)));
    let middle = title(&chart.x);
    let taken = from.chars().count() + to.chars().count() + middle.chars().count();
    let gap = screen.columns.saturating_sub(taken);
    let (before, after) = (" ".repeat(gap / 2), " ".repeat(gap - gap / 2));
    out.push_str(&cut(&format!("{}{from}{before}{middle}{after}{to}", " ".repeat(left + 2)), width));
    out.push_str(&cut(&legend(panel), width));
    out
}

fn title(axis: &Axis) -> String {
    match axis.unit.as_str() {
        "" => axis.label.text().to_string(),
        text => format!("{} ({})", axis.label.text(), unit(text)),
    }
}

fn legend(panel: &Panel) -> String {
    let named = panel.series.iter().filter(|s| !s.name.text().is_empty());
    let entries = named.map(|s| format!("{} {}", if s.mark == Mark::Line { "⠒⠒" } else { "o" }, s.name.text()));
    entries.collect::<Vec<_>>().join("   ")
}

fn cut(text: &str, width: usize) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(width).collect::<String>() + "\n"
}

struct Screen {
    columns: usize,
    dots: Vec<Vec<u32>>,
    marks: Vec<Vec<bool>>,
}

impl Screen {
    fn new(columns: usize, rows: usize) -> Screen {
        Screen { columns, dots: vec![vec![0; columns]; rows], marks: vec![vec![false; columns]; rows] }
    }

    fn row(&self, row: usize) -> String {
        let glyph = |(dots, mark): (&u32, &bool)| match (*dots, *mark) {
            (0, true) => 'o',
            (0, false) => ' ',
            (dots, _) => char::from_u32(0x2800 + dots).unwrap_or(' '),
        };
        self.dots[row].iter().zip(&self.marks[row]).map(glyph).collect()
    }

    /// A dot at (x, y), counted in dots from the top left corner.
    fn dot(&mut self, x: i64, y: i64) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if let Some(cell) = self.dots.get_mut(y / 4).and_then(|row| row.get_mut(x / 2)) {
            *cell |= DOTS[y % 4][x % 2];
        }
    }

    fn mark(&mut self, x: i64, y: i64) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if let Some(cell) = self.marks.get_mut(y / 4).and_then(|row| row.get_mut(x / 2)) {
            *cell = true;
        }
    }
}

fn draw(screen: &mut Screen, series: &Series, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) {
    let (wide, high) = (2 * screen.columns - 1, 4 * screen.dots.len() - 1);
    let place = |k: usize, y: f64| {
        let (x, y) = ((series.x[k] - x0) / (x1 - x0), (y1 - y) / (y1 - y0));
        let inside = (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y);
        inside.then(|| ((x * wide as f64).round() as i64, (y * high as f64).round() as i64))
    };
    let mut pen: Option<(i64, i64)> = None;
    for k in decimate(&series.y[..series.len()], 4 * screen.columns) {
        let at = place(k, series.y[k]);
        match (at, pen, series.mark) {
            (Some((x, y)), _, Mark::Points) => screen.mark(x, y),
            (Some((x, y)), Some((a, b)), Mark::Line) => {
                let steps = i64::max((x - a).abs(), (y - b).abs()).max(1);
                for n in 0..=steps {
                    screen.dot(a + (x - a) * n / steps, b + (y - b) * n / steps);
                }
            }
            (Some((x, y)), None, Mark::Line) => screen.dot(x, y),
            (None, ..) => {}
        }
        pen = at;
    }
    // the ends of an interval as separate dots
    for k in decimate(&series.y[..series.len()], screen.columns / 2) {
        let Some((low, high)) = series.interval.get(k) else { break };
        for (x, y) in [*low, *high].into_iter().filter_map(|end| place(k, end)) {
            screen.dot(x, y);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(series: Vec<Series>) -> Curves {
        let panel = Panel { y: Axis::new("u", "m/s"), series, floor: None };
        Curves { x: Axis::new("Time", "s"), panels: vec![panel], spans: Vec::new() }
    }

    #[test]
    fn a_rising_line_goes_from_the_lower_left_to_the_upper_right() {
        let x: Vec<f64> = (0..50).map(f64::from).collect();
        let text = plot(&chart(vec![Series::line("simulated", x.clone(), x)]), 60, 14);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 14);
        assert!(lines.iter().all(|l| l.chars().count() <= 60), "{text}");
        let at = |row: usize| lines[row].chars().position(|c| ('\u{2801}'..='\u{28ff}').contains(&c)).unwrap();
        assert!((2..10).all(|row| at(row) > at(row + 1)), "{text}");
    }

    #[test]
    fn a_band_is_drawn_on_either_side_of_its_line() {
        let x: Vec<f64> = (0..50).map(f64::from).collect();
        let line = Series::line("simulated", x.clone(), x.iter().map(|x| if *x < 25.0 { 0.0 } else { 1.0 }).collect());
        let dots = |text: &str| text.chars().filter(|c| ('\u{2801}'..='\u{28ff}').contains(c)).count();
        let bare = dots(&plot(&chart(vec![line.clone()]), 60, 14));
        let interval = line.y.iter().map(|y| (y - 0.3, y + 0.3)).collect();
        assert!(dots(&plot(&chart(vec![line.with_interval(interval)]), 60, 14)) > bare + 10);
    }

    #[test]
    fn no_data_and_wild_data_are_no_reason_to_panic() {
        for values in [vec![], vec![f64::NAN], vec![1e308, -1e308], vec![0.0], vec![f64::INFINITY, 2.0]] {
            let x = (0..values.len()).map(|k| k as f64).collect::<Vec<_>>();
            let both = vec![Series::line("a\nb", x.clone(), values.clone()), Series::points("c", x, values)];
            assert_eq!(plot(&chart(both), 0, 0).lines().count(), 8);
        }
    }
}
