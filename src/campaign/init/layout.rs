//! The layout of a text table: separator, decimal mark, comment lines, header.

use std::collections::BTreeSet;
use std::io::Read;
use std::path::Path;

use super::{commands, meaning, units, words};
use crate::log::clock::duration;
use crate::log::columns::{self, split_header};
use crate::log::encoding::{Opening, opening};
use crate::log::{LogOptions, iso8601, number};

/// Number of bytes of the file that are examined: some hundred rows of any log.
const LOOKED_AT: u64 = 1 << 16;

/// The layout of a table, as its first lines show it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Layout {
    /// Names of the columns.
    pub headers: Vec<String>,
    /// Whether the line below the header holds units; these are then part of `headers`.
    pub unit_row: bool,
    /// Cells of the first rows.
    pub rows: Vec<Vec<String>>,
    /// Character between fields.
    pub delimiter: char,
    /// Decimal mark.
    pub decimal: char,
    /// Beginning of lines that are no data, if there are such lines before the header.
    pub comment: Option<String>,
    /// Whether `comment` marks the first of two header lines, which says where the columns come
    /// from: the second has their names.
    pub two_headers: bool,
    /// What the file is if it is no CSV, and what reads it.
    pub no_csv: Option<String>,
}

/// Finds the layout from the beginning of a file. Options of `given` that differ from the default
/// take precedence.
///
/// # Errors
/// The system's reason why the file cannot be read.
pub fn of(path: &Path, given: &LogOptions) -> std::io::Result<Layout> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(LOOKED_AT).read_to_end(&mut bytes)?;
    Ok(Layout { no_csv: no_csv(&bytes), ..of_text(&String::from_utf8_lossy(&bytes), given) })
}

/// What a file with these first bytes is, if it is no CSV.
fn no_csv(bytes: &[u8]) -> Option<String> {
    match opening(bytes) {
        Opening::Log(name, extra) => Some(format!(
            "this is {name}: `init` of the command of the Python package reads it (pip install 'hydrosysid[{extra}]')"
        )),
        Opening::Other(name) => Some(format!("this is {name}, not UTF-8 text; convert or unpack it first")),
        Opening::Text(_) if bytes.contains(&0) => Some(
            "this is not text, and its first bytes are not those of a known log format; the command of the Python \
             package reads some formats by the file's name (.mat, .bin)"
                .into(),
        ),
        Opening::Text(_) => None,
    }
}

fn of_text(text: &str, given: &LogOptions) -> Layout {
    let usual = LogOptions::default();
    let text = text.trim_start_matches('\u{feff}');
    let lines: Vec<&str> = text.lines().filter(|line| !line.trim().is_empty()).take(200).collect();
    // the last line may be cut off
    let lines = if lines.len() > 2 { &lines[..lines.len() - 1] } else { &lines[..] };
    let delimiter = if given.delimiter == usual.delimiter { delimiter_of(lines) } else { given.delimiter };
    let decimal = if given.decimal == usual.decimal { decimal_of(lines, delimiter) } else { given.decimal };
    let width = lines.last().map_or(0, |line| fields(line, delimiter).len());
    // comment: a line before the header that begins with a mark and does not split as rows do;
    // rostopic's `%time` is a header
    let told = given.comment.clone();
    let is_comment = |line: &str| match &told {
        Some(mark) => line.trim_start().starts_with(mark.as_str()),
        None => line.starts_with(['#', '%', '!']) && fields(line, delimiter).len() != width,
    };
    let comment = lines.iter().find(|line| is_comment(line)).map(|line| line.chars().take(1).collect());
    let mut data = lines.iter().filter(|line| !is_comment(line));
    let mut headers = data.next().map_or_else(Vec::new, |line| fields(line, delimiter));
    let mut rows: Vec<Vec<String>> =
        data.map(|line| fields(line, delimiter)).filter(|row| row.len() == headers.len()).collect();
    let comment = told.clone().or(comment);
    let of_sources = (!given.unit_row && comment.is_none() && has_units(&rows, decimal as u8) && are_names(&rows[0]))
        .then(|| beginning(lines))
        .flatten();
    let two_headers = of_sources.is_some();
    if two_headers {
        headers = rows.remove(0);
    }
    let comment = comment.or(of_sources);
    let unit_row = given.unit_row || has_units(&rows, decimal as u8);
    if unit_row && !rows.is_empty() {
        for (header, unit) in headers.iter_mut().zip(rows.remove(0)) {
            let unit = unit.trim_matches(['[', ']', '(', ')']);
            if !unit.is_empty() && split_header(header).1.is_none() {
                *header = format!("{header} [{unit}]");
            }
        }
    }
    Layout { unit_row, headers, rows, delimiter, decimal, comment, two_headers, no_csv: None }
}

/// Whether most cells are names of channels, no cell occurs twice, and they are no units.
fn are_names(cells: &[String]) -> bool {
    let filled: Vec<&String> = cells.iter().filter(|cell| !cell.is_empty()).collect();
    let is_name = |cell: &&&String| {
        let words = words::of(cell);
        let means = columns::quantity(split_header(cell).0).is_some() || !meaning::of(&words).is_empty();
        !units::is_unit(cell) && (means || commands::of(cell, &words).is_some())
    };
    let once = filled.iter().collect::<BTreeSet<_>>().len() == filled.len();
    once && 2 * filled.iter().filter(is_name).count() > filled.len()
}

/// The beginning of the first line, at most 24 characters; `None` if another line begins with it.
fn beginning(lines: &[&str]) -> Option<String> {
    const LENGTH: usize = 24;
    let begin: String = lines.first()?.trim().chars().take(LENGTH).collect();
    let begin = begin.trim_end().to_string();
    let other = lines[1..].iter().any(|line| line.trim().starts_with(&begin));
    (!begin.is_empty() && !other).then_some(begin)
}

/// Whether the first row holds words in most of the cells in which the second holds numbers.
fn has_units(rows: &[Vec<String>], decimal: u8) -> bool {
    let [first, second, ..] = rows else { return false };
    let is_number = |cell: &str| number::parse(cell.trim().as_bytes(), decimal).is_some();
    let numbers = second.iter().filter(|cell| is_number(cell)).count();
    let words = first.iter().zip(second).filter(|(word, cell)| is_number(cell) && !is_number(word) && word.len() < 16);
    numbers > 1
        && 2 * words.filter(|(word, _)| !word.is_empty()).count() > numbers
        && !first.iter().any(|c| is_number(c))
}

impl Layout {
    /// Whether the first line holds numbers, so that no column has a name.
    pub fn nameless(&self) -> bool {
        !self.headers.is_empty()
            && self.headers.iter().all(|h| number::parse(h.trim().as_bytes(), self.decimal as u8).is_some())
    }

    /// The largest absolute number in the first rows under a header; 0 if there is none.
    pub fn greatest(&self, header: &str) -> f64 {
        let at = self.headers.iter().position(|h| h == header);
        let cells = self.rows.iter().filter_map(|row| row.get(at?));
        let numbers = cells.filter_map(|cell| number::parse(cell.trim().as_bytes(), self.decimal as u8));
        numbers.map(f64::abs).fold(0.0, f64::max)
    }

    /// Whether the cells of a column are days, as `2024-07-01`.
    pub fn is_day(&self, column: usize) -> bool {
        self.first_cell(column).is_some_and(|c| {
            let is_marked = c.iter().any(|b| matches!(b, b'-' | b'/' | b'.'));
            is_marked && iso8601::of_date_and_time(c, b"00:00").is_some()
        })
    }

    /// Whether the cells of a column are times of day, as `10:40:00.1`.
    pub fn is_time_of_day(&self, column: usize) -> bool {
        self.first_cell(column).is_some_and(|c| iso8601::time_of_day(c).is_some())
    }

    fn first_cell(&self, column: usize) -> Option<&[u8]> {
        Some(self.rows.first()?.get(column)?.trim().as_bytes())
    }

    /// Whether the cells of a column are durations, as `12.3 sec`.
    pub fn is_duration(&self, column: usize) -> bool {
        self.first_cell(column).is_some_and(|c| duration(c, self.decimal as u8).is_some())
    }

    /// Whether the cells of a column are dates.
    pub fn is_date(&self, column: usize) -> bool {
        self.rows.first().and_then(|row| row.get(column)).is_some_and(|c| iso8601::nanoseconds(c.as_bytes()).is_some())
    }
}

/// The cells of a line, without quotes.
fn fields(line: &str, delimiter: char) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    for c in line.trim_end_matches(['\r', '\n']).chars() {
        match c {
            '"' => quoted = !quoted,
            c if c == delimiter && !quoted => cells.push(String::new()),
            c => cells.last_mut().expect("there is one").push(c),
        }
    }
    cells.into_iter().map(|cell| cell.trim().to_string()).collect()
}

/// The first of `;`, tab, `|`, comma and space that splits header and rows into the same number of
/// fields, at least two.
fn delimiter_of(lines: &[&str]) -> char {
    let alike = |d: char| -> usize {
        let widths: Vec<usize> = lines.iter().rev().take(20).map(|line| fields(line, d).len()).collect();
        let first = widths.first().copied().unwrap_or(0);
        if first > 1 && widths.iter().all(|w| *w == first) { first } else { 0 }
    };
    // a comma may be the decimal mark: if a semicolon or tab splits evenly too, it is the separator
    [';', '\t', '|', ',', ' '].into_iter().find(|d| alike(*d) > 1).unwrap_or(',')
}

/// The decimal mark: a comma if it occurs in numbers of the rows and no number has a point.
fn decimal_of(lines: &[&str], delimiter: char) -> char {
    let cells: Vec<String> = lines.iter().skip(1).flat_map(|line| fields(line, delimiter)).collect();
    let number = |cell: &&String| cell.chars().all(|c| c.is_ascii_digit() || "+-.,eE".contains(c));
    let holds = |mark: char| cells.iter().filter(number).filter(|c| c.contains(mark)).count();
    if delimiter != ',' && holds(',') > 0 && holds('.') == 0 { ',' } else { '.' }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> Layout {
        of_text(text, &LogOptions::default())
    }

    #[test]
    fn separators_decimals_and_comments_are_found() {
        let german = layout("Zeit;Kurs;Tiefe\n0,0;12,5;1,0\n0,1;12,6;1,1\n0,2;12,6;1,1\n");
        assert_eq!((german.delimiter, german.decimal, german.headers.len()), (';', ',', 3));
        let commented = layout("# made by a logger\n# v2\nt,u\n0,1\n1,2\n2,3\n");
        assert_eq!((commented.comment.as_deref(), commented.headers[0].as_str()), (Some("#"), "t"));
        let ros = layout("%time,field.data\n1,2\n2,3\n3,4\n");
        assert_eq!((ros.comment.as_deref(), ros.headers[0].as_str()), (None, "%time"));
        assert_eq!(layout("t\tu\n0\t1\n1\t2\n2\t3\n").delimiter, '\t');
        assert_eq!(layout("t u\n0 1\n1 2\n2 3\n").delimiter, ' ');
        assert!(layout("0,1\n1,2\n2,3\n").nameless());
    }

    #[test]
    fn of_two_header_lines_the_second_has_the_names() {
        let two = layout(
            "clock,DVL,DVL,IMU,IMU,Cmd\ntime,u,v,r,psi,tau_u\n0,0.1,0,0,1,2\n0.1,0.1,0,0,1,2\n0.2,0.1,0,0,1,2\n",
        );
        assert!(two.two_headers && !two.unit_row, "{two:?}");
        assert_eq!(two.headers, ["time", "u", "v", "r", "psi", "tau_u"]);
        assert_eq!(two.comment.as_deref(), Some("clock,DVL,DVL,IMU,IMU,Cm"));
        let units = layout("t,u,v,battery,rpm_1\ns,m/s,m/s,V,rpm\n0,1,0,16,9\n1,1,0,16,9\n2,1,0,16,9\n");
        assert!(units.unit_row && !units.two_headers && units.headers[1] == "u [m/s]", "{units:?}");
    }

    #[test]
    fn what_is_no_csv_is_named() {
        assert!(
            no_csv(b"\xa3\x95\x80\x80").is_some_and(|why| why.contains("DataFlash") && why.contains("[ardupilot]"))
        );
        assert!(no_csv(b"PAR1").is_some_and(|why| why.contains("Parquet")));
        assert!(no_csv(b"\x1f\x8b\x08").is_some_and(|why| why.contains("gzip")));
        assert!(no_csv(&[0; 20]).is_some_and(|why| why.contains("not text")));
        assert_eq!(no_csv(b"t,u\n0,1\n"), None);
    }

    #[test]
    fn dates_are_seen_and_given_options_win() {
        assert!(layout("time,u\n2024-07-01T10:40:00.1Z,1\n2024-07-01T10:40:00.2Z,1\n,\n").is_date(0));
        let given = LogOptions { delimiter: '|', ..LogOptions::default() };
        assert_eq!(of_text("a,b|c\n1,2|3\n1,2|3\n", &given).headers, ["a,b", "c"]);
    }
}
