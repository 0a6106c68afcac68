//! Cells of a row: a value, no value, or a fault with the option that would allow it.

use super::clock::{Clock, NoTime, duration};
use super::codes;
use super::faults::{Faults, no_number};
use super::header::{Column, quoted};
use super::number;
use super::options::{LogOptions, Missing};
use super::records::Record;
use crate::finding::Quote;

/// Result of reading a cell.
pub(super) enum Cell {
    /// A finite number, in the unit of the file.
    Value(f64),
    /// No value, which the options allow.
    Missing,
    /// A fault; counted if the column is strict.
    Fault,
}

/// Context for reading the cells of one row.
pub(super) struct Cells<'a> {
    pub options: &'a LogOptions,
    /// Entries of `missing_values` that are numbers.
    pub missing_numbers: &'a [f64],
    pub decimal: u8,
    pub record: &'a Record<'a>,
    pub faults: &'a mut Faults,
}

impl Cells<'_> {
    /// Reads a number.
    #[inline]
    pub fn number(&mut self, column: &Column) -> Cell {
        let cell = self.record.field(column.index).unwrap_or_default();
        match number::parse(cell, self.decimal) {
            Some(x) if x.is_finite() && self.missing_numbers.is_empty() => Cell::Value(x),
            number => self.odd(number, cell, column),
        }
    }

    /// Reads a cell that is no finite number, or any cell if `missing_values` lists numbers.
    fn odd(&mut self, number: Option<f64>, cell: &[u8], column: &Column) -> Cell {
        const HINT: &str =
            "set missing = \"drop\" to leave such rows out, or \"no_sample\" if this sensor has no sample there";
        let allowed = self.options.missing != Missing::Error;
        let listed = number.is_some_and(|x| self.missing_numbers.contains(&x))
            || self.options.missing_values.iter().any(|v| v.trim().as_bytes() == cell);
        let infinite = number.is_some_and(f64::is_infinite);
        let nan = number.is_some_and(f64::is_nan);
        if allowed && !infinite && (listed || nan || cell.is_empty()) {
            return Cell::Missing;
        }
        if let Some(x) = number.filter(|x| x.is_finite() && !listed) {
            return Cell::Value(x);
        }
        if column.strict {
            let shown = quoted(&String::from_utf8_lossy(cell));
            let (code, text) = if infinite {
                (codes::NON_FINITE, format!("{shown} is not a finite number; infinities are never dropped"))
            } else if nan {
                (codes::NON_FINITE, format!("{shown} is not a finite number; {HINT}"))
            } else if cell.is_empty() {
                (codes::MISSING, format!("no value; {HINT}"))
            } else if listed {
                (codes::MISSING, format!("{shown} is one of missing_values; {HINT}"))
            } else {
                (codes::PARSE, no_number(cell, self.options.decimal, !allowed))
            };
            let record = self.record;
            self.faults
                .add_quoting(&code, Some(record.line), Some(&column.name), || (text, Some(record.quote(column.index))));
        }
        Cell::Fault
    }

    /// Reads the time in field `index`, a time of day if field `date` holds the date; `header` is
    /// the header of its column. Counts a fault and returns `None` if the cell is no time.
    #[inline]
    pub fn time(&mut self, clock: &mut Clock, index: usize, date: Option<usize>, header: &str) -> Option<f64> {
        let cell = self.record.field(index).unwrap_or_default();
        let read = match date {
            None => clock.read(cell),
            Some(date) => clock.read_dated(self.record.field(date).unwrap_or_default(), cell),
        };
        match read {
            Ok(t) => Some(t),
            Err(fault) => {
                self.no_time(fault, index, header);
                None
            }
        }
    }

    #[cold]
    fn no_time(&mut self, fault: NoTime, index: usize, header: &str) {
        let record = self.record;
        let cell = record.field(index).unwrap_or_default();
        let text = String::from_utf8_lossy(cell);
        let shown = quoted(&text);
        let (code, message) = match fault {
            _ if cell.is_empty() => (codes::MISSING, "no time stamp; a row without time cannot be used".to_string()),
            _ if text == header => {
                let message = format!(
                    "{shown} is not a number: the header line appears again, so two logs were joined; read them as two \
                     runs"
                );
                (codes::PARSE, message)
            }
            NoTime::Date => {
                let message = format!("{shown} is an ISO 8601 date; set time_format = \"iso8601\"");
                (codes::TIME_FORMAT, message)
            }
            NoTime::NoDate => {
                let message = format!("{shown} is not an ISO 8601 date such as 2024-07-01T10:40:00.100Z");
                (codes::TIME_FORMAT, message)
            }
            NoTime::NoDateAndTime => {
                let message = format!(
                    "{shown} and the cell of columns.date are not a time of day and a date such as 10:40:00.100 and \
                     2024-07-01, 20240701 or 01.07.2024"
                );
                (codes::TIME_FORMAT, message)
            }
            NoTime::NoTimeOfDay => (codes::TIME_FORMAT, format!("{shown} is not a time of day such as 10:40:00.100")),
            NoTime::NoDuration => {
                (codes::TIME_FORMAT, format!("{shown} is not a number with a unit of time such as 12.3 sec"))
            }
            NoTime::NonFinite => (codes::NON_FINITE, format!("{shown} is not a finite number")),
            NoTime::Parse if duration(text.as_bytes(), self.decimal).is_some() => {
                (codes::PARSE, format!("{shown} is a number with its unit; set time_format = \"duration\""))
            }
            NoTime::Parse if text.contains(':') => {
                let message = format!(
                    "{shown} is not a number; set time_format = \"time_of_day\", or columns.date = \"its header\" where the date has a column"
                );
                (codes::PARSE, message)
            }
            NoTime::Parse => (codes::PARSE, no_number(cell, self.options.decimal, false)),
        };
        self.faults.add_quoting(&code, Some(record.line), Some("t"), || (message, Some(record.quote(index))));
    }
}

/// A row whose number of fields differs from that of the header.
pub(super) struct OtherWidth {
    line: u64,
    pub fields: usize,
    quote: Quote,
}

impl OtherWidth {
    #[cold]
    pub fn of(record: &Record) -> OtherWidth {
        OtherWidth { line: record.line, fields: record.width(), quote: record.quote(usize::MAX) }
    }

    /// Adds it to `faults`; `hint` ends the message.
    #[cold]
    pub fn add_to(self, faults: &mut Faults, width: usize, hint: &str) {
        let OtherWidth { line, fields, quote } = self;
        faults.add_quoting(&codes::FIELD_COUNT, Some(line), None, || {
            (format!("{fields} fields where the header has {width}{hint}"), Some(quote))
        });
    }
}

/// Counts a time stamp, in the line of `quote`, that is not later than the previous one.
#[cold]
pub(super) fn add_time_order(faults: &mut Faults, line: u64, t: f64, before: f64, quote: Option<Quote>) {
    faults.add_quoting(&codes::TIME_ORDER, Some(line), Some("t"), || {
        let hint = if t < before {
            "if the clock was set back or two logs were joined read the parts as two runs; if the rows are merely out of order set sort = true"
        } else {
            "if rows are repeated set duplicates = \"first\"; if the clock is too coarse write more decimals"
        };
        (format!("{t:?} s is not later than {before:?} s of the row before; {hint}"), quote)
    });
}

/// Returns a hint for rows that look like comments; empty for others.
pub(super) fn comment_hint(record: &Record) -> String {
    let first = record.text(0);
    match ["#", "%", "//"].into_iter().find(|mark| first.starts_with(mark)) {
        Some(mark) => format!("; if this line is a comment set comment = \"{mark}\""),
        None => String::new(),
    }
}

/// Number of digits after the decimal mark; `None` for anything but a plain decimal.
#[inline]
pub(super) fn decimals(cell: &[u8], decimal: u8) -> Option<usize> {
    let behind = cell.iter().rev().take_while(|b| b.is_ascii_digit()).count();
    match cell.len() - behind {
        0 => (behind > 0).then_some(0),
        rest if cell[rest - 1] == decimal => Some(behind),
        1 if behind > 0 && matches!(cell[0], b'-' | b'+') => Some(0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_counted_in_plain_numbers_only() {
        let count = |text: &str| decimals(text.as_bytes(), b'.');
        assert_eq!(["39.8", "39.", "39", "-3", ".25"].map(count), [Some(1), Some(0), Some(0), Some(0), Some(2)]);
        assert_eq!(["1e-5", "", "-", "AUTO"].map(count), [None; 4]);
    }
}
