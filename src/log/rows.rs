//! The rows of a log, one after the other, in SI units; memory is one block of the file.
//!
//! [`super::read`] keeps all rows; code that processes rows as they come uses [`Rows`] directly.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::LogError;
use super::cells::{Cell, Cells, OtherWidth, add_time_order, comment_hint, decimals};
use super::clock::Clock;
use super::codes;
use super::fast_rows::{Row, Sheet, Way};
use super::faults::Faults;
use super::header::{Heading, Plan};
use super::number;
use super::options::{Duplicates, LogOptions, Missing, Truncated};
use super::records::{Broken, Records};
use crate::finding::Finding;
use crate::progress;

/// Number of rows between two checks for cancellation: some milliseconds.
const ROWS_A_LOOK: u64 = 4096;

/// What was met while reading: counts and places.
#[derive(Debug, Clone, Default)]
pub struct Passage {
    /// Number of rows given out.
    pub rows: u64,
    /// Number of rows dropped for a missing value.
    pub missing: u64,
    /// Number of rows dropped for a repeated time stamp.
    pub duplicates: u64,
    /// Number of rows at the end dropped because they were cut short.
    pub truncated: u64,
    /// First blank line between rows, and the number of such places.
    pub blank: Option<(u64, u64)>,
    /// Line of the last row, if it has no line end.
    pub open_end: Option<u64>,
    /// Decimals of the last field of that row, and the fewest of all others, if the former are fewer.
    pub short_field: Option<(usize, usize)>,
    /// Name and first bad line of auxiliary columns that were dropped.
    pub given_up: Vec<(String, u64)>,
    /// Value subtracted from the time stamps, s.
    pub origin: Option<f64>,
}

impl Passage {
    /// Returns the findings: dropped rows, blank lines, a last row that may be cut.
    pub fn findings(&self, file: &str) -> Vec<Finding> {
        let mut found = Vec::new();
        let mut tell = |code, line, text: &str| found.push(Finding::at(code, file, line, None, text));
        let rows = |n: u64| if n == 1 { "1 row".to_string() } else { format!("{n} rows") };
        for (count, why) in [
            (self.missing, "because of a missing value (missing = \"drop\")"),
            (self.duplicates, "because of a repeated time stamp (duplicates = \"first\")"),
            (self.truncated, "because the log ends inside it (truncated = \"drop\")"),
        ] {
            if count > 0 {
                tell(&codes::ROWS_DROPPED, None, &format!("{} dropped {why}", rows(count)));
            }
        }
        if let Some((line, count)) = self.blank {
            let more = if count > 1 { format!(" ({count} such lines)") } else { String::new() };
            tell(&codes::BLANK_LINE, Some(line), &format!("a blank line was skipped{more}"));
        }
        match (self.open_end, self.short_field) {
            (Some(line), Some((decimals, others))) => {
                let text = format!(
                    "the file ends without a line end and its last number has {decimals} decimals where all others \
                     have {others} or more: it may be truncated"
                );
                tell(&codes::SHORT_LAST_FIELD, Some(line), &text);
            }
            (Some(line), None) => {
                tell(&codes::NO_FINAL_NEWLINE, Some(line), "the last row has no line end");
            }
            _ => {}
        }
        found
    }
}

/// A reader of rows.
pub struct Rows<R> {
    file: String,
    records: Records<R>,
    plan: Plan,
    options: LogOptions,
    missing_numbers: Vec<f64>,
    decimal: u8,
    clock: Clock,
    previous: f64,
    values: Vec<f64>,
    /// Slots of the columns that are still read.
    alive: Vec<usize>,
    faults: Faults,
    /// A row with too few fields, which may turn out to be the last.
    short: Option<OtherWidth>,
    fewest_decimals: usize,
    passage: Passage,
    /// Description of the fields for the fast path; `None` before it is made and after a column was
    /// dropped.
    way: Option<Way>,
    /// Rows that the fast path has read ahead.
    sheet: Sheet,
}

impl Rows<File> {
    /// Opens a file and reads its header.
    ///
    /// # Errors
    /// See [`LogError`].
    pub fn open(path: &Path, options: &LogOptions, required: &[&str]) -> Result<Rows<File>, LogError> {
        let file = path.display().to_string();
        let source = File::open(path).map_err(|source| LogError::Open { file: file.clone(), source })?;
        Rows::new(source, &file, options, required)
    }
}

impl<R: Read> Rows<R> {
    /// Reads the header; `file` is the name in messages.
    ///
    /// # Errors
    /// See [`LogError`].
    pub fn new(source: R, file: &str, options: &LogOptions, required: &[&str]) -> Result<Rows<R>, LogError> {
        options.validate()?;
        let decimal = options.decimal as u8;
        let broken = |b: &Broken, quote| {
            let mut faults = Faults::default();
            faults.add_broken(b, quote, options.max_line_bytes, |_| None);
            LogError::refused(file, faults)
        };
        let mut records =
            Records::new(source, options.delimiter as u8, options.comment.as_deref(), options.max_line_bytes)
                .map_err(|b| broken(&b, None))?;
        let mut heading = match records.next_record() {
            Ok(header) => header.map(|header| Heading::of(&header, options)),
            Err(b) => return Err(broken(&b, records.quote(&b))),
        };
        if options.unit_row {
            heading = match (heading, records.next_record()) {
                (Some(heading), Ok(Some(units))) => Some(heading.with_units(&units)),
                (heading, Ok(_)) => heading,
                (_, Err(b)) => return Err(broken(&b, records.quote(&b))),
            };
        }
        let plan = match heading {
            Some(heading) => Plan::new(heading, options, required, file).map_err(|findings| LogError::Refused {
                file: file.to_string(),
                findings,
                further: 0,
            })?,
            None => {
                let mut faults = Faults::default();
                let what = if records.seen_text() { "it holds comments only, no header" } else { "the file is empty" };
                faults.add(&codes::EMPTY_FILE, None, None, || what.to_string());
                return Err(LogError::refused(file, faults));
            }
        };
        let missing_numbers =
            options.missing_values.iter().filter_map(|v| number::parse(v.trim().as_bytes(), decimal)).collect();
        Ok(Rows {
            file: file.to_string(),
            records,
            clock: Clock::new(plan.time_unit, options.time_format, decimal).scaled(options.time_scale()),
            options: options.clone(),
            missing_numbers,
            decimal,
            previous: f64::NEG_INFINITY,
            values: vec![f64::NAN; plan.columns.len()],
            alive: (0..plan.columns.len()).collect(),
            plan,
            faults: Faults::default(),
            short: None,
            fewest_decimals: usize::MAX,
            passage: Passage::default(),
            way: None,
            sheet: Sheet::default(),
        })
    }

    /// Returns the names of the channels, in the order of [`Row::values`].
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.plan.columns.iter().map(|c| c.name.as_str())
    }

    /// Returns the plan made from the header.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Returns the next sound row; `None` at the end. [`Rows::finish`] tells whether all rows were sound.
    pub fn next_row(&mut self) -> Option<Row<'_>> {
        loop {
            if self.passage.rows.is_multiple_of(ROWS_A_LOOK) {
                progress::look();
            }
            if self.sheet.is_empty() {
                self.read_ahead();
            }
            if !self.sheet.is_empty() {
                self.passage.rows += 1;
                return self.sheet.next();
            }
            let record = match self.records.next_record() {
                Ok(Some(record)) => record,
                Ok(None) => return None,
                Err(Broken::OpenQuote(..)) if self.options.truncated == Truncated::Drop => {
                    self.passage.truncated += 1;
                    return None;
                }
                Err(broken) => {
                    let columns = &self.plan.columns;
                    let name = |i| columns.iter().find(|c| c.index == i).map(|c| c.name.clone());
                    let quote = self.records.quote(&broken);
                    self.faults.add_broken(&broken, quote, self.options.max_line_bytes, name);
                    return None;
                }
            };
            if let Some(short) = self.short.take() {
                short.add_to(&mut self.faults, self.plan.width, "");
            }
            if let Some(line) = record.blank {
                let (first, count) = self.passage.blank.unwrap_or((line, 0));
                self.passage.blank = Some((first, count + 1));
            }
            let line = record.line;
            if record.width() != self.plan.width {
                let other = OtherWidth::of(&record);
                if other.fields < self.plan.width {
                    self.short = Some(other);
                } else {
                    other.add_to(&mut self.faults, self.plan.width, &comment_hint(&record));
                }
                continue;
            }
            if !record.ended && self.options.truncated == Truncated::Drop {
                let last = record.field(self.plan.width - 1).unwrap_or_default();
                let used = self.alive.iter().any(|s| self.plan.columns[*s].index == self.plan.width - 1);
                if used && number::parse(last, self.decimal).is_none() {
                    self.passage.truncated += 1;
                    continue;
                }
            }
            let mut cells = Cells {
                options: &self.options,
                missing_numbers: &self.missing_numbers,
                decimal: self.decimal,
                record: &record,
                faults: &mut self.faults,
            };
            // a bollard table has no time: its rows are counted
            #[allow(clippy::cast_precision_loss)]
            let t = match &self.plan.time {
                None => Some((self.passage.rows + self.passage.missing) as f64),
                Some((index, header)) => cells.time(&mut self.clock, *index, self.plan.date, header),
            };
            let Some(t) = t else { continue };
            let (mut sound, mut dropped, mut dead) = (true, false, Vec::new());
            for &slot in &self.alive {
                let column = &self.plan.columns[slot];
                self.values[slot] = match cells.number(column) {
                    Cell::Value(x) => column.convert(x),
                    Cell::Missing => {
                        dropped |= column.strict && self.options.missing == Missing::Drop;
                        f64::NAN
                    }
                    Cell::Fault => {
                        if column.strict {
                            sound = false;
                        } else {
                            dead.push(slot);
                        }
                        f64::NAN
                    }
                };
            }
            let shape = (record.ended, decimals(record.field(self.plan.width - 1).unwrap_or_default(), self.decimal));
            let increasing = t > self.previous || self.options.sort;
            let repeated = !increasing && t >= self.previous && self.options.duplicates == Duplicates::First;
            let time = self.plan.time.as_ref().filter(|_| !increasing && !repeated);
            let quote = time.map(|(index, _)| record.quote(*index));
            if !dead.is_empty() {
                self.give_up(&dead, line);
            }
            if repeated {
                self.passage.duplicates += 1;
                continue;
            }
            let before = std::mem::replace(&mut self.previous, t);
            if !increasing {
                add_time_order(&mut self.faults, line, t, before, quote);
                continue;
            }
            if !sound {
                continue;
            }
            self.last_field(line, shape);
            if dropped {
                self.passage.missing += 1;
                continue;
            }
            self.passage.rows += 1;
            return Some(Row { line, t, values: &self.values });
        }
    }

    /// Reads the next rows by the fast path.
    fn read_ahead(&mut self) {
        if self.short.is_some() || !self.missing_numbers.is_empty() {
            return;
        }
        let way = self.way.get_or_insert_with(|| Way::new(&self.plan, &self.alive, &self.options));
        let (first, text) = self.records.plain_lines();
        let bytes = self.sheet.read(text, first, way, &self.plan.columns, &mut self.clock, self.previous);
        self.records.skip(self.sheet.rows(), bytes);
        self.previous = self.sheet.last().unwrap_or(self.previous);
        self.fewest_decimals = self.fewest_decimals.min(self.sheet.fewest_decimals());
    }

    /// Drops auxiliary columns that hold something other than numbers.
    #[cold]
    fn give_up(&mut self, dead: &[usize], line: u64) {
        self.alive.retain(|slot| !dead.contains(slot));
        self.way = None;
        self.passage.given_up.extend(dead.iter().map(|&slot| (self.plan.columns[slot].name.clone(), line)));
    }

    /// Tracks the decimals of the last field, to detect a file that is cut inside a number.
    fn last_field(&mut self, line: u64, (ended, decimals): (bool, Option<usize>)) {
        if !ended {
            self.passage.open_end = Some(line);
            if let Some(d) = decimals
                && self.passage.rows >= 3
                && self.fewest_decimals != usize::MAX
                && d < self.fewest_decimals
            {
                self.passage.short_field = Some((d, self.fewest_decimals));
            }
        }
        self.fewest_decimals = self.fewest_decimals.min(decimals.unwrap_or(0));
    }

    /// Returns the plan and what was met while reading, if every row was sound.
    ///
    /// # Errors
    /// [`LogError::Refused`] with the first case of each kind and column.
    pub fn finish(mut self) -> Result<(Plan, Passage), LogError> {
        if let Some(short) = self.short.take() {
            if self.options.truncated == Truncated::Drop {
                self.passage.truncated += 1;
            } else {
                let hint = "; if the log was cut off here set truncated = \"drop\"";
                short.add_to(&mut self.faults, self.plan.width, hint);
            }
        }
        if !self.faults.is_empty() {
            return Err(LogError::refused(&self.file, self.faults));
        }
        self.passage.origin = self.clock.origin();
        Ok((self.plan, self.passage))
    }
}
