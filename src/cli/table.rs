//! Tables for people, as wide as the terminal.

use comfy_table::{Cell, CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, Table, TableStyle, Width};

use crate::wording;

/// Table style: one line under the headers.
const STYLE: TableStyle = TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─'));

/// Distance between two columns, characters: the style's own and the padding on the left.
const BETWEEN: usize = 2;

/// Number of columns of the terminal, `None` without a terminal; the environment variable `COLUMNS`
/// has priority, as in other tools.
pub(super) fn width() -> Option<usize> {
    let told = std::env::var("COLUMNS").ok().and_then(|text| text.trim().parse().ok()).filter(|width| *width > 0);
    told.or_else(|| Table::new().width().map(usize::from))
}

/// A table with these headers; numbers are aligned to the right. If the terminal is too narrow for
/// it without breaking words, each row becomes a block of lines.
pub(super) fn table(headers: &[&str], rows: &[Vec<String>]) -> String {
    let mut table = Table::new();
    table.load_style(STYLE).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header(headers.to_vec());
    let room = width();
    if let Some(room) = room {
        table.set_width(u16::try_from(room).unwrap_or(u16::MAX));
    }
    for row in rows {
        table.add_row(row.iter().map(|text| {
            let number = text.trim_start_matches("± ").split(' ').next().is_some_and(|n| n.parse::<f64>().is_ok());
            Cell::new(text).set_alignment(if number { CellAlignment::Right } else { CellAlignment::Left })
        }));
    }
    let words = longest_words(headers, rows);
    let least = words.iter().map(|word| word + BETWEEN).sum::<usize>();
    if let Some(room) = room.filter(|room| *room < least) {
        return blocks(headers, rows, room);
    }
    for (column, word) in table.column_iter_mut().zip(words) {
        let least = Width::Fixed(u16::try_from(word + 1).unwrap_or(u16::MAX));
        column.set_padding((1, 0)).set_constraint(ColumnConstraint::LowerBoundary(least));
    }
    table.to_string().lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}

/// A sentence folded to the width of the terminal; unchanged without a terminal.
pub(super) fn wrapped(text: &str) -> String {
    folded(text, width().unwrap_or(usize::MAX))
}

/// A sentence in lines of at most `width` characters, unless a word is longer.
pub(super) fn folded(text: &str, width: usize) -> String {
    let (mut lines, mut length) = (String::new(), 0);
    for word in text.split(' ') {
        let more = word.chars().count();
        let breaks = length > 0 && length + 1 + more > width;
        if length > 0 {
            lines.push(if breaks { '\n' } else { ' ' });
        }
        lines.push_str(word);
        length = if breaks || length == 0 { more } else { length + 1 + more };
    }
    lines
}

/// Length of the longest word of each column, including its header.
fn longest_words(headers: &[&str], rows: &[Vec<String>]) -> Vec<usize> {
    let longest = |text: &str| text.split_whitespace().map(|word| word.chars().count()).max().unwrap_or(0);
    let column = |k: usize| rows.iter().filter_map(|row| row.get(k)).map(|text| longest(text)).max().unwrap_or(0);
    headers.iter().enumerate().map(|(k, head)| longest(head).max(column(k))).collect()
}

/// `header  cell` per line, a blank line between two rows; empty cells are left out, and long ones
/// continue below.
fn blocks(headers: &[&str], rows: &[Vec<String>], width: usize) -> String {
    let widest = headers.iter().map(|head| head.chars().count()).max().unwrap_or(0);
    let line = |(head, cell): (&&str, &String)| {
        let blank = " ".repeat(widest - head.chars().count());
        let below = format!("\n{}", " ".repeat(widest + 3));
        let cell = folded(cell, width.saturating_sub(widest + 3)).replace('\n', &below);
        (!cell.is_empty()).then(|| format!(" {head}{blank}  {cell}\n"))
    };
    let block = |row: &Vec<String>| headers.iter().zip(row).filter_map(line).collect::<String>();
    rows.iter().map(block).collect::<Vec<_>>().join("\n").trim_end().to_string()
}

/// A number with four significant digits, with an exponent only if it is very small or large.
pub(super) fn number(x: f64) -> String {
    let size = x.abs();
    if !x.is_finite() {
        return "-".into();
    }
    if size == 0.0 {
        return "0".into();
    }
    if !(1e-4..1e7).contains(&size) {
        return format!("{x:.3e}");
    }
    let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
    format!("{x:.decimals$}")
}

/// A number with three significant digits, for errors, which are not known better.
pub(super) fn size(x: f64) -> String {
    match x.abs() {
        size if (1e-4..1e3).contains(&size) => {
            let decimals = (2 - size.log10().floor() as i32).max(0) as usize;
            format!("{x:.decimals$}")
        }
        _ => number(x),
    }
}

/// Mark after a standard deviation of a fit that did not converge, and of the note that explains
/// it.
pub(super) const UNSETTLED: &str = "?";

/// A value with its standard deviation; marked if the estimator did not converge, because the
/// standard deviation is then meaningless.
pub(super) fn estimated(value: f64, std: Option<f64>, converged: bool) -> String {
    let text = measured(value, std);
    if converged || std.is_none() { text } else { format!("{text} {UNSETTLED}") }
}

/// A value with its standard deviation, to two digits of the standard deviation.
pub(super) fn measured(value: f64, std: Option<f64>) -> String {
    match std.filter(|s| *s > 0.0 && s.is_finite()) {
        Some(std) => wording::measured(value, std),
        None => number(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_that_is_too_wide_becomes_a_block() {
        let rows = [
            vec!["run00.csv".to_string(), "0.1 ± 0.2".into(), String::new()],
            vec!["b".into(), "1".into(), "m".into()],
        ];
        let heads = ["run", "|error| (25)", "unit"];
        assert_eq!(longest_words(&heads, &rows), [9, 7, 4]);
        let text = blocks(&heads, &rows, 80);
        assert_eq!(
            text,
            " run           run00.csv\n |error| (25)  0.1 ± 0.2\n\n run           b\n |error| (25)  1\n unit          m"
        );
    }

    #[test]
    fn numbers_have_the_digits_they_deserve() {
        assert_eq!(number(309.0712), "309.1");
        assert_eq!(number(0.012344), "0.01234");
        assert_eq!(number(-1.5e9), "-1.500e9");
        assert_eq!((size(0.0054821), size(0.9871), size(12.34)), ("0.00548".into(), "0.987".into(), "12.3".into()));
        assert_eq!(measured(309.07, Some(18.8)), "309 ± 19");
        assert_eq!(measured(0.123456, Some(0.0012)), "0.1235 ± 0.0012");
        assert_eq!(measured(5.0, None), "5.000");
        assert_eq!(estimated(309.07, Some(18.8), true), "309 ± 19");
        assert_eq!(estimated(309.07, Some(18.8), false), "309 ± 19 ?");
        assert_eq!(estimated(5.0, None, false), "5.000");
    }
}
