//! A table as CSV for a spreadsheet and as LaTeX for a paper.
//!
//! CSV contains all digits, and an estimate in two columns (value, standard deviation); text that a
//! spreadsheet would take for a formula (`=`, `+`, `-`, `@` at the start) gets an apostrophe. LaTeX
//! contains what the report shows.

use csv::Terminator;

use super::document::{Cell, Column, Table};
use super::label::{Label, unit};
use super::number::{Style, estimate, exact, number};
use crate::spreadsheet::{self, harmless};

impl Table {
    /// RFC 4180 text with a header line; columns are `name [unit]`.
    pub fn csv(&self) -> String {
        let mut head = Vec::new();
        for (k, column) in self.columns.iter().enumerate() {
            head.push(harmless(&head_of(column, "")).into_owned());
            if self.has_std(k) {
                head.push(harmless(&head_of(column, " std")).into_owned());
            }
        }
        let row = |row: &Vec<Cell>| {
            let mut fields = Vec::new();
            for k in 0..self.columns.len() {
                let (value, std) = match row.get(k).unwrap_or(&Cell::Empty) {
                    Cell::Empty => (String::new(), String::new()),
                    Cell::Text(label) => (harmless(label.text()).into_owned(), String::new()),
                    Cell::Number { value, .. } => (exact(*value), String::new()),
                    Cell::Estimate { value, std } => (exact(*value), std.map_or(String::new(), exact)),
                };
                fields.push(value);
                if self.has_std(k) {
                    fields.push(std);
                }
            }
            fields
        };
        spreadsheet::csv(std::iter::once(head).chain(self.rows.iter().map(row)), Terminator::CRLF)
    }

    /// A `tabular` with rules of the booktabs package.
    pub fn latex(&self) -> String {
        let columns = self.filled();
        let places: String = columns.iter().map(|k| if self.is_numeric(*k) { 'r' } else { 'l' }).collect();
        let line = |cells: Vec<String>| format!("{} \\\\\n", cells.join(" & "));
        let head = |column: &Column| match column.unit.as_str() {
            "" => column.name.latex(),
            text => format!("{} ({})", column.name.latex(), Label::Plain(unit(text)).latex()),
        };
        let mut out = format!("\\begin{{tabular}}{{{places}}}\n\\toprule\n");
        out.push_str(&line(columns.iter().map(|k| head(&self.columns[*k])).collect()));
        out.push_str("\\midrule\n");
        for row in &self.rows {
            let cell = |k: &usize| match row.get(*k).unwrap_or(&Cell::Empty) {
                Cell::Empty => String::new(),
                Cell::Text(label) => label.latex(),
                Cell::Number { value, digits } => format!("${}$", number(*value, *digits, Style::Latex)),
                Cell::Estimate { value, std } => format!("${}$", estimate(*value, *std, Style::Latex)),
            };
            out.push_str(&line(columns.iter().map(cell).collect()));
        }
        out.push_str("\\bottomrule\n\\end{tabular}\n");
        out
    }

    /// Numbers of the columns in which some row has content; all columns if the table has no rows.
    pub(super) fn filled(&self) -> Vec<usize> {
        let holds = |k: &usize| self.rows.iter().filter_map(|row| row.get(*k)).any(|cell| !cell.is_empty());
        (0..self.columns.len()).filter(|k| self.rows.is_empty() || holds(k)).collect()
    }

    /// Whether column `k` contains a number: such columns are aligned to the right.
    pub fn is_numeric(&self, k: usize) -> bool {
        self.rows.iter().filter_map(|row| row.get(k)).any(|c| matches!(c, Cell::Number { .. } | Cell::Estimate { .. }))
    }

    fn has_std(&self, k: usize) -> bool {
        self.rows.iter().filter_map(|row| row.get(k)).any(|c| matches!(c, Cell::Estimate { std: Some(_), .. }))
    }
}

fn head_of(column: &Column, suffix: &str) -> String {
    match column.unit.as_str() {
        "" => format!("{}{suffix}", column.name.text()),
        unit => format!("{}{suffix} [{unit}]", column.name.text()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        Table {
            title: "Estimates".into(),
            columns: vec![Column::new("parameter", ""), Column::new("value", "kg/m"), Column::new("n", "")],
            rows: vec![
                vec![
                    Cell::Text(Label::symbol("k_u|u|")),
                    Cell::Estimate { value: 309.07, std: Some(18.8) },
                    Cell::Number { value: 1e7, digits: 3 },
                ],
                vec!["=HYPERLINK(\"x\",\"y\")".into(), Cell::Estimate { value: -0.1, std: None }],
            ],
            note: String::new(),
        }
    }

    #[test]
    fn csv_keeps_all_digits_and_defuses_formulas() {
        let expected = "parameter,value [kg/m],value std [kg/m],n\r\n\
                        k_u|u|,309.07,18.8,10000000\r\n\
                        \"'=HYPERLINK(\"\"x\"\",\"\"y\"\")\",-0.1,,\r\n";
        assert_eq!(table().csv(), expected);
    }

    #[test]
    fn csv_reads_back_with_a_csv_reader() {
        let text = table().csv();
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let rows: Vec<csv::StringRecord> = reader.records().collect::<Result<_, _>>().unwrap();
        assert_eq!(rows[1].get(0), Some("'=HYPERLINK(\"x\",\"y\")"));
        assert!(rows.iter().all(|row| row.len() == 4));
    }

    #[test]
    fn columns_without_content_are_not_shown() {
        let mut table = table();
        table.columns.push(Column::new("stated", ""));
        table.columns.push(Column::new("also possible", ""));
        table.rows[0].extend([Cell::Empty, "".into()]);
        assert_eq!(table.filled(), [0, 1, 2]);
        assert!(table.latex().contains(r"\begin{tabular}{lrr}") && table.csv().contains("n,stated,also possible"));
        table.rows[1].extend([Cell::Empty, Cell::Empty, "k_uv".into()]);
        assert_eq!(table.filled(), [0, 1, 2, 4]);
        assert_eq!(Table { rows: vec![], ..table }.filled().len(), 5);
    }

    #[test]
    fn latex_has_a_cell_for_every_column() {
        let text = table().latex();
        assert!(text.contains(r"$k_{u|u|}$ & $309 \pm 19$ & $1.00\times 10^{7}$ \\"), "{text}");
        assert!(text.contains(r"\begin{tabular}{lrr}"));
        assert!(text.lines().filter(|l| l.ends_with(r"\\")).all(|l| l.matches(" & ").count() == 2));
    }
}
