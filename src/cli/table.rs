//! Tables for people, as wide as their terminal.

use comfy_table::{Cell, CellAlignment, ContentArrangement, LineStyle, Table, TableStyle};

/// One line under the headers.
const STYLE: TableStyle = TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─'));

/// A table with these headers; columns of numbers stand to the right.
pub(super) fn table(headers: &[&str], rows: &[Vec<String>]) -> String {
    let mut table = Table::new();
    table.load_style(STYLE).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header(headers.to_vec());
    for row in rows {
        table.add_row(row.iter().map(|text| {
            let number = text.trim_start_matches("± ").split(' ').next().is_some_and(|n| n.parse::<f64>().is_ok());
            Cell::new(text).set_alignment(if number { CellAlignment::Right } else { CellAlignment::Left })
        }));
    }
    table.to_string()
}

/// Four significant digits, without an exponent where a person would not use one.
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

/// A value with its standard deviation, to the two digits that the deviation deserves.
pub(super) fn measured(value: f64, std: Option<f64>) -> String {
    match std.filter(|s| *s > 0.0 && s.is_finite()) {
        Some(std) if (1e-6..1e7).contains(&std) => {
            let decimals = (1 - std.log10().floor() as i32).clamp(0, 9) as usize;
            format!("{value:.decimals$} ± {std:.decimals$}")
        }
        Some(std) => format!("{} ± {}", number(value), number(std)),
        None => number(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_they_deserve() {
        assert_eq!(number(309.0712), "309.1");
        assert_eq!(number(0.012344), "0.01234");
        assert_eq!(number(-1.5e9), "-1.500e9");
        assert_eq!(measured(309.07, Some(18.8)), "309 ± 19");
        assert_eq!(measured(0.123456, Some(0.0012)), "0.1235 ± 0.0012");
        assert_eq!(measured(5.0, None), "5.000");
    }
}
