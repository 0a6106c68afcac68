//! Fast path of reading: plain rows are read many at a time in one pass over their bytes.
//!
//! Most rows of most logs are plain decimals between delimiters. The fast path ends at the first
//! row that needs more (a missing value, a blank line, a stamp that does not increase);
//! [`Rows`](super::Rows) then reads that row by the careful path, which reports its faults. The
//! fast path gives the same values as the careful path, to the bit.

use super::cells::decimals;
use super::clock::Clock;
use super::header::{Column, Plan};
use super::number::{self, leading};
use super::options::{LogOptions, Missing};
use super::records::trim;

/// One row.
#[derive(Debug, Clone, Copy)]
pub struct Row<'a> {
    /// Physical line, from 1.
    pub line: u64,
    /// Time, s.
    pub t: f64,
    /// A value for each of [`Rows::names`](super::Rows::names), SI; NaN where this sensor has no sample.
    pub values: &'a [f64],
}

/// Use of a field.
#[derive(Debug, Clone, Copy)]
enum Field {
    /// The time.
    Time,
    /// The value of this slot.
    Value(usize),
    /// Unused.
    Nothing,
}

/// Description of the fields of a row for the fast path.
#[derive(Debug)]
pub(super) struct Way {
    /// Use of each field; empty if the fast path cannot read the rows.
    fields: Vec<Field>,
    slots: usize,
    delimiter: u8,
    decimal: u8,
    comment: Option<Vec<u8>>,
    max_line: usize,
    /// Whether an empty cell means no sample.
    may_lack: bool,
    /// Whether stamps may be in any order.
    any_order: bool,
}

impl Way {
    /// Returns the description for the columns `alive` of a plan.
    pub fn new(plan: &Plan, alive: &[usize], options: &LogOptions) -> Way {
        let mut fields = vec![Field::Nothing; plan.width];
        let mut once = true;
        let values = alive.iter().map(|slot| (plan.columns[*slot].index, Field::Value(*slot)));
        let time = plan.time.as_ref().map(|(index, _)| (*index, Field::Time));
        for (index, field) in values.chain(time) {
            once &= matches!(std::mem::replace(&mut fields[index], field), Field::Nothing);
        }
        // rare cases are left to the careful path: a table without time (its rows are counted),
        // dates in two fields, a space as delimiter, a field that two channels read
        if !once || plan.time.is_none() || plan.date.is_some() || options.delimiter == ' ' {
            fields.clear();
        }
        Way {
            fields,
            slots: plan.columns.len(),
            delimiter: options.delimiter as u8,
            decimal: options.decimal as u8,
            comment: options.comment.as_deref().map(|c| c.trim().as_bytes().to_vec()),
            max_line: options.max_line_bytes,
            may_lack: options.missing == Missing::NoSample,
            any_order: options.sort,
        }
    }

    #[inline]
    fn is_blank(&self, byte: Option<&u8>) -> bool {
        match byte {
            Some(b' ') => true,
            Some(b'\t') => self.delimiter != b'\t',
            _ => false,
        }
    }

    /// Whether a field ends with this byte.
    #[inline]
    fn ends(&self, byte: u8) -> bool {
        byte == self.delimiter || byte == b'\n' || byte == b'\r'
    }

    /// Returns the field at the start of `text`, trimmed, and its length in bytes.
    #[inline]
    fn cell<'a>(&self, text: &'a [u8]) -> (&'a [u8], usize) {
        let bytes = memchr::memchr3(self.delimiter, b'\n', b'\r', text).unwrap_or(text.len());
        (trim(&text[..bytes]), bytes)
    }

    /// Returns the number at the start of `text` (NaN for an empty cell that means no sample), and
    /// the length and the decimals of its field; `None` if the field holds no finite number.
    #[inline]
    fn number(&self, text: &[u8]) -> Option<(f64, usize, usize)> {
        if let Some(plain) = leading(text, self.decimal)
            && text.get(plain.bytes).is_some_and(|b| self.ends(*b))
        {
            return Some((plain.value, plain.bytes, plain.decimals));
        }
        self.long_number(text)
    }

    /// The same for a number with an exponent, many digits or blanks after it, and for an empty cell.
    fn long_number(&self, text: &[u8]) -> Option<(f64, usize, usize)> {
        let (cell, bytes) = self.cell(text);
        if cell.is_empty() && self.may_lack {
            return Some((f64::NAN, bytes, 0));
        }
        let x = number::parse(cell, self.decimal).filter(|x| x.is_finite())?;
        Some((x, bytes, decimals(cell, self.decimal).unwrap_or(0)))
    }
}

/// Rows that were read ahead.
#[derive(Debug)]
pub(super) struct Sheet {
    /// Line of the first row.
    line: u64,
    time: Vec<f64>,
    /// Values, row by row.
    values: Vec<f64>,
    slots: usize,
    /// Number of rows given out.
    given: usize,
    fewest_decimals: usize,
}

impl Default for Sheet {
    fn default() -> Sheet {
        Sheet { line: 0, time: Vec::new(), values: Vec::new(), slots: 0, given: 0, fewest_decimals: usize::MAX }
    }
}

impl Sheet {
    /// Whether all of its rows were given out.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.given == self.time.len()
    }

    /// Number of rows it was filled with.
    pub fn rows(&self) -> u64 {
        self.time.len() as u64
    }

    /// Time of its last row, s.
    pub fn last(&self) -> Option<f64> {
        self.time.last().copied()
    }

    /// Fewest digits after the decimal mark of the last field.
    pub fn fewest_decimals(&self) -> usize {
        self.fewest_decimals
    }

    /// Gives out the next row.
    #[inline]
    pub fn next(&mut self) -> Option<Row<'_>> {
        let k = self.given;
        let t = *self.time.get(k)?;
        self.given += 1;
        Some(Row { line: self.line + k as u64, t, values: &self.values[k * self.slots..(k + 1) * self.slots] })
    }

    /// Fills the sheet with plain rows from the start of `text`, as long as the time increases from
    /// `previous` on, where it must; returns the number of bytes read. `text` begins at line `line`
    /// and consists of whole lines.
    pub fn read(
        &mut self,
        text: &[u8],
        line: u64,
        way: &Way,
        columns: &[Column],
        clock: &mut Clock,
        mut previous: f64,
    ) -> usize {
        (self.line, self.slots, self.given, self.fewest_decimals) = (line, way.slots, 0, usize::MAX);
        self.time.clear();
        self.values.clear();
        let mut row = vec![f64::NAN; way.slots];
        let mut taken = 0;
        let next = |rest: &[u8], clock: &mut Clock, row: &mut [f64]| match clock.has_begun() {
            true => read_row(rest, way, columns, clock, row),
            // a row that is rejected must not set the zero of the clock
            false => {
                let mut trial = clock.clone();
                read_row(rest, way, columns, &mut trial, row).inspect(|_| *clock = trial)
            }
        };
        while let Some((t, bytes, decimals)) = next(&text[taken..], clock, &mut row) {
            if t <= previous && !way.any_order {
                break;
            }
            previous = t;
            taken += bytes;
            self.fewest_decimals = self.fewest_decimals.min(decimals);
            self.time.push(t);
            self.values.extend_from_slice(&row);
        }
        taken
    }
}

/// Reads the row at the start of `text` into `row`; returns its time, its length in bytes and the
/// decimals of its last field, or `None` if the row is not plain.
#[inline]
fn read_row(
    text: &[u8],
    way: &Way,
    columns: &[Column],
    clock: &mut Clock,
    row: &mut [f64],
) -> Option<(f64, usize, usize)> {
    let (last, mut at, mut t, mut places) = (way.fields.len().checked_sub(1)?, 0, None, 0);
    if way.comment.as_ref().is_some_and(|comment| trim(text).starts_with(comment)) {
        return None;
    }
    for (k, field) in way.fields.iter().enumerate() {
        while way.is_blank(text.get(at)) {
            at += 1;
        }
        let cell = text.get(at..)?;
        match field {
            Field::Nothing => {
                let (cell, bytes) = way.cell(cell);
                if k == last {
                    places = decimals(cell, way.decimal).unwrap_or(0);
                }
                at += bytes;
            }
            Field::Value(slot) => {
                let (x, bytes, decimals) = way.number(cell)?;
                row[*slot] = columns[*slot].convert(x);
                (at, places) = (at + bytes, decimals);
            }
            Field::Time => {
                if let (Some(seconds), Some(plain)) = (clock.per_second(), leading(cell, way.decimal))
                    && cell.get(plain.bytes).is_some_and(|b| way.ends(*b))
                {
                    t = Some(plain.value / seconds);
                    (at, places) = (at + plain.bytes, plain.decimals);
                } else {
                    let (cell, bytes) = way.cell(cell);
                    t = Some(clock.read(cell).ok()?);
                    (at, places) = (at + bytes, decimals(cell, way.decimal).unwrap_or(0));
                }
            }
        }
        let end = text.get(at);
        if k < last {
            (end == Some(&way.delimiter)).then_some(())?;
            at += 1;
        }
    }
    let length = at;
    at += usize::from(text.get(at) == Some(&b'\r'));
    (text.get(at) == Some(&b'\n') && length <= way.max_line).then_some(())?;
    Some((t?, at + 1, places))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::read_from;
    use super::*;
    use crate::finding::Finding;

    /// Result of a reading as text: stamps and values to the bit, and messages.
    fn outcome(text: &str, options: &LogOptions) -> String {
        let said = |findings: &[Finding]| findings.iter().map(|f| f.message.clone()).collect::<Vec<_>>();
        match read_from(text.as_bytes(), "f.csv", options, &["t", "u"]) {
            Ok(log) => {
                let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                let signals = log.signals.iter().map(|(name, s)| (name.clone(), bits(s.time()), bits(s.values())));
                let signals: Vec<_> = signals.collect();
                format!("{:?} {signals:?} {:?} {:?}", log.rows, said(&log.warnings), said(&log.notes))
            }
            Err(error) => error.to_string(),
        }
    }

    /// Results of both paths: a byte beyond ASCII makes every line take the careful path.
    fn both_ways(rows: &str, options: &LogOptions) -> (String, String) {
        let [plain, careful] = ["aux", "a\u{e9}x"].map(|name| outcome(&format!("t,u,{name},v\n{rows}"), options));
        (plain, careful.replace('\u{e9}', "u"))
    }

    #[test]
    fn rows_of_any_kind_are_read_as_the_careful_way_reads_them() {
        let lines = [
            "0.1,1.5,a,2\n0.2,-1.25,b,3.125\r\n 0.3 ,\t2.5 , c ,1e-3\n0.4,1234567890.123456789,,0.00000000000000000000001\n",
            "0.1,1,,\n0.2,2,,4\n0.3,3,,\n",
            "0.1,1,,1\n\n0.2,2,,2\n0.2,3,,3\n0.3,4,,4",
            "0.1,1,,1\n0.2,2,,1\n0.3,2,,1\n0.4,2,,1\n0.5,2,,1.25\n0.6,2,,1.2\n0.7,3,,1",
            "0.1,1,1\n0.2,2,,2,9\n0.3,nan,,3\n0.4,inf,,3\n0.5,1e999,,x\n",
            "1719830400.0,1,,1\n1719830400.1,2,,1\n1719830400.3,2,,1\n",
            "# 1,2,3,4\n0.1,1,#,1\n # 0.2\n0.3,1,,1\n",
        ];
        let mut all = vec![LogOptions::default()];
        for missing in [Missing::Drop, Missing::NoSample] {
            all.push(LogOptions { missing, comment: Some("#".into()), ..LogOptions::default() });
        }
        all.push(LogOptions { sort: true, max_line_bytes: 30, ..LogOptions::default() });
        for (rows, options) in lines.iter().flat_map(|rows| all.iter().map(move |options| (rows, options))) {
            let (plain, careful) = both_ways(rows, options);
            assert_eq!(plain, careful, "{rows:?} {options:?}");
        }
    }

    proptest! {
        #[test]
        fn law_the_plain_way_is_the_careful_way(
            cells in proptest::collection::vec(
                ("[-+]?[0-9]{0,9}[.]?[0-9]{0,12}", "[-+ ]?[0-9]{0,3}[.,]?[0-9e]{0,3}", 0u8..9), 1..30),
            missing in prop_oneof![Just(Missing::Error), Just(Missing::Drop), Just(Missing::NoSample)],
        ) {
            let mut rows = String::new();
            for (k, (u, v, odd)) in cells.iter().enumerate() {
                let t = if *odd == 0 { v.clone() } else { format!("{:.1}", 0.1 * (k + 1) as f64) };
                rows += &format!("{t},{u},,{}{}", if *odd == 1 { v } else { u }, if *odd == 2 { "\r\n" } else { "\n" });
            }
            let (plain, careful) = both_ways(&rows, &LogOptions { missing, ..LogOptions::default() });
            prop_assert_eq!(plain, careful);
        }
    }
}
