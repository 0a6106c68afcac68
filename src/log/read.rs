//! Reading of a whole log into signals.

use std::collections::BTreeMap;
use std::io::Read;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use super::LogError;
use super::cells::add_time_order;
use super::check;
use super::codes;
use super::columns::split_header;
use super::derived;
use super::earth_velocity;
use super::faults::Faults;
use super::header::Plan;
use super::number::short;
use super::options::{Duplicates, LogOptions, Repeated, TimeUnit};
use super::rows::{Passage, Rows};
use crate::finding::{Code, Finding, Severity};
use crate::run::Signal;

/// Number of rows below which a warning is given: fewer rows allow at most two parameters, because
/// a fit needs two rows more than parameters.
const FEW_ROWS: usize = 5;

/// A log that was read.
#[derive(Debug, Clone, Default)]
pub struct LogFile {
    /// File name, as given.
    pub file: String,
    /// Signals by canonical name; auxiliary channels by their own name; SI units.
    pub signals: BTreeMap<String, Signal>,
    /// Unit of each known signal after reading; a command keeps its own unit (`V`, `1`, `us`).
    pub units: BTreeMap<String, &'static str>,
    /// Number of rows kept.
    pub rows: usize,
    /// Time stamps of the rows, s.
    pub time: Arc<[f64]>,
    /// Time stamps at which a gap ends, s.
    pub gaps: Vec<f64>,
    /// Value subtracted from the stamps of a wall clock, s (since 1970 for dates).
    pub origin: Option<f64>,
    /// Warnings: findings of what looks wrong.
    pub warnings: Vec<Finding>,
    /// Notes: findings worth knowing, such as ignored columns or a missing line end.
    pub notes: Vec<Finding>,
    /// Headers of the columns that were not kept.
    pub ignored: Vec<String>,
}

/// Reads a log. `required` names the columns that must be present; a known column that is present
/// must be sound too. If `t` is neither in `required` nor in the file, the rows are counted
/// instead, as in a bollard table.
///
/// # Errors
/// See [`LogError`].
pub fn read(path: impl AsRef<Path>, options: &LogOptions, required: &[&str]) -> Result<LogFile, LogError> {
    let rows = Rows::open(path.as_ref(), options, &derived::required(options, required))?;
    collect(rows, &path.as_ref().display().to_string(), options, required)
}

/// Reads a log from any source; `file` is its name in messages.
///
/// # Errors
/// See [`LogError`].
pub fn read_from(source: impl Read, file: &str, options: &LogOptions, required: &[&str]) -> Result<LogFile, LogError> {
    collect(Rows::new(source, file, options, &derived::required(options, required))?, file, options, required)
}

/// Line numbers of the rows. (line − row) changes only where a line was skipped or rows were sorted,
/// so only its changes are kept.
#[derive(Debug, Default)]
struct Lines {
    rows: u64,
    changes: Vec<(u64, u64)>,
}

impl Lines {
    fn push(&mut self, line: u64) {
        let offset = line.wrapping_sub(self.rows);
        if self.changes.last().is_none_or(|c| c.1 != offset) {
            self.changes.push((self.rows, offset));
        }
        self.rows += 1;
    }

    fn line(&self, row: usize) -> u64 {
        let row = row as u64;
        let after = self.changes.partition_point(|c| c.0 <= row);
        self.changes[..after].last().map_or(0, |c| row.wrapping_add(c.1))
    }
}

struct Table {
    time: Vec<f64>,
    values: Vec<Vec<f64>>,
    lines: Lines,
    /// Number of rows dropped after sorting.
    duplicates: u64,
}

fn collect<R: Read>(
    mut rows: Rows<R>,
    file: &str,
    options: &LogOptions,
    required: &[&str],
) -> Result<LogFile, LogError> {
    let width = rows.names().count();
    let mut table = Table { time: Vec::new(), values: vec![Vec::new(); width], lines: Lines::default(), duplicates: 0 };
    while let Some(row) = rows.next_row() {
        table.time.push(row.t);
        table.lines.push(row.line);
        for (column, x) in table.values.iter_mut().zip(row.values) {
            column.push(*x);
        }
    }
    let (plan, mut passage) = rows.finish()?;
    let mut faults = Faults::default();
    if options.sort {
        table = sorted(table, options.duplicates, &mut faults);
        passage.duplicates += table.duplicates;
    }
    let repeated = match options.repeated {
        Repeated::Sample => Vec::new(),
        Repeated::Auto | Repeated::NoSample => without_repeats(&plan, &mut table.values),
    };
    let taken = table.time.len();
    if taken == 0 && faults.is_empty() {
        let dropped = passage.missing + passage.duplicates + passage.truncated;
        faults.add(&codes::NO_DATA, None, None, || match dropped {
            0 => "there is a header but no row".to_string(),
            n => format!("none of the {n} rows remains"),
        });
    } else if taken == 1 && plan.time.is_some() {
        faults.add(&codes::ONE_ROW, None, None, || "1 row shows no motion; at least 2 are needed".to_string());
    }
    let time: Arc<[f64]> = std::mem::take(&mut table.time).into();
    let mut log = LogFile {
        file: file.to_string(),
        rows: taken,
        time: time.clone(),
        origin: passage.origin,
        ..LogFile::default()
    };
    keep_signals(&mut log, &plan, &passage, table.values);
    let told = derived::tell(&mut log.signals, &mut log.units, options).unwrap_or_else(|(column, error)| {
        faults.add(&codes::DERIVED, None, Some(column), || error.to_string());
        Vec::new()
    });
    let turned = options.earth_velocity().map(|frame| earth_velocity::to_body(&mut log.signals, frame));
    if let Some(Err(error)) = &turned {
        faults.add(&codes::EARTH_VELOCITY, None, None, || error.to_string());
    }
    for name in required.iter().filter(|n| **n != "t" && !log.signals.contains_key(**n)) {
        faults.add(&codes::MISSING, None, Some(name), || "the column has no value at all".to_string());
    }
    if !faults.is_empty() {
        return Err(LogError::refused(file, faults));
    }
    passage_findings(&mut log, &passage, options);
    for how in told {
        log.note(&codes::TOLD, None, &how);
    }
    if let Some(Ok(how)) = turned {
        log.note(&codes::TURNED, None, &how);
    }
    if !repeated.is_empty() {
        let of = |r: &Repeats| format!("{} of {} values of {}", r.count, r.values, r.column);
        let said: Vec<String> = repeated.iter().map(of).collect();
        let said = format!("{} only repeat the previous one", said.join(", "));
        match options.repeated {
            Repeated::NoSample => {
                log.note(&codes::REPEATED, None, &format!("{said}: treated as no samples (repeated = \"no_sample\")"));
            }
            _ => {
                let text = format!(
                    "{said}: a slower sensor, written at the rate of the log; each of its samples is used once; \
                     repeated = \"no_sample\" confirms this, \"sample\" says that all are measurements"
                );
                log.warn(&codes::HELD, None, None, &text);
            }
        }
        dropped_out(&mut log, &repeated);
    }
    let timed = plan.time.is_some();
    if timed && taken < FEW_ROWS {
        log.warn(
            &codes::TOO_FEW_ROWS,
            None,
            None,
            &format!("{taken} rows; a fit needs at least two rows more than parameters"),
        );
    }
    if let Some(seen) = counted(&plan, &time, options) {
        log.add(Finding::at(&seen.code, &log.file, None, Some("t"), &seen.text));
    }
    if timed {
        log.gaps = check::time::log_gaps(&time, &log.signals);
        for seen in check::all(&time, &log.signals, &log.units) {
            let line = seen.time.map(|t| table.lines.line(time.partition_point(|s| *s < t)));
            let column = if let [only] = &seen.channels[..] { Some(only.as_str()) } else { None };
            log.add(Finding::at(&seen.code, &log.file, line, column, &seen.text));
        }
    }
    Ok(log)
}

/// Returns a finding if a counter of rows is read as seconds although neither header nor options
/// give a unit.
fn counted(plan: &Plan, time: &[f64], options: &LogOptions) -> Option<check::Seen> {
    let (_, header) = plan.time.as_ref()?;
    let stated = options.columns.get("t").is_some_and(|source| source.unit.is_some())
        || split_header(header).1.is_some_and(|unit| TimeUnit::from_name(unit).is_some());
    let said = stated || options.time_unit.is_some() || options.time_format.is_some();
    (!said).then(|| check::time::check_counter(header, time)).flatten()
}

/// Sorts the rows by time; equal stamps keep the order of the file.
fn sorted(table: Table, duplicates: Duplicates, faults: &mut Faults) -> Table {
    let Table { time, values, lines, .. } = table;
    let mut order: Vec<usize> = (0..time.len()).collect();
    order.sort_by(|a, b| time[*a].total_cmp(&time[*b]));
    let mut out =
        Table { time: Vec::with_capacity(time.len()), values: Vec::new(), lines: Lines::default(), duplicates: 0 };
    order.retain(|&row| {
        let repeated = out.time.last().is_some_and(|last| *last >= time[row]);
        if repeated && duplicates == Duplicates::First {
            out.duplicates += 1;
            return false;
        }
        if repeated {
            add_time_order(faults, lines.line(row), time[row], time[row], None);
        }
        out.time.push(time[row]);
        out.lines.push(lines.line(row));
        true
    });
    out.values = values.iter().map(|column| order.iter().map(|row| column[*row]).collect()).collect();
    out
}

/// Warns of columns in which the sensor dropped out: how long and how often.
fn dropped_out(log: &mut LogFile, repeated: &[Repeats]) {
    let seconds = |rows: &Range<usize>| log.time[rows.end] - log.time[rows.start];
    let of = |r: &Repeats| {
        let longest = r.frozen.iter().max_by(|a, b| seconds(a).total_cmp(&seconds(b)))?;
        let times = match r.frozen.len() {
            1 => String::new(),
            n => format!(", the longest of {n} such stretches"),
        };
        let (for_s, from) = (short(seconds(longest), 3), short(log.time[longest.start], 6));
        Some(format!("{} stays at one value for {for_s} s from t = {from} s{times}", r.column))
    };
    let said: Vec<String> = repeated.iter().filter_map(of).collect();
    if !said.is_empty() {
        let text = format!("{}: the sensor dropped out; these values are treated as no samples", said.join("; "));
        log.warn(&codes::HELD, None, None, &text);
    }
}

/// Repeated values of one column.
struct Repeats {
    column: String,
    /// Number of values of the column, and how many of them are no samples.
    values: usize,
    count: usize,
    /// Rows between which the sensor had dropped out.
    frozen: Vec<Range<usize>>,
}

/// Removes from measured columns the values that only repeat the last sample of a slower sensor.
fn without_repeats(plan: &Plan, values: &mut [Vec<f64>]) -> Vec<Repeats> {
    let measured = plan.columns.iter().zip(values).filter(|(column, _)| check::is_measured(&column.name));
    let mut found = Vec::new();
    for (column, values) in measured {
        // a row without a value belongs to another sensor or a command
        let present: Vec<usize> = (0..values.len()).filter(|row| !values[*row].is_nan()).collect();
        let own: Vec<f64> = present.iter().map(|row| values[*row]).collect();
        let Some(hold) = check::hold::of(&own) else { continue };
        let kept = hold.samples(&own);
        let frozen = hold.frozen(&own).into_iter().map(|s| present[s.start]..present[s.end]).collect();
        found.push(Repeats { column: column.name.clone(), values: own.len(), count: own.len() - kept.len(), frozen });
        let mut sparse = vec![f64::NAN; values.len()];
        kept.into_iter().for_each(|k| sparse[present[k]] = own[k]);
        *values = sparse;
    }
    found
}

/// Turns columns into signals; a column with missing samples gets its own time stamps, shared with
/// columns that have the same.
fn keep_signals(log: &mut LogFile, plan: &Plan, passage: &Passage, values: Vec<Vec<f64>>) {
    let time = log.time.clone();
    let mut clocks: Vec<Arc<[f64]>> = Vec::new();
    log.ignored.clone_from(&plan.ignored);
    for (column, values) in plan.columns.iter().zip(values) {
        let given_up = passage.given_up.iter().any(|(name, _)| *name == column.name);
        let samples = values.iter().filter(|x| !x.is_nan()).count();
        if given_up || samples == 0 {
            log.ignored.push(column.name.clone());
            continue;
        }
        let signal = if samples == values.len() {
            Signal::new(time.clone(), values)
        } else {
            let (t, x): (Vec<f64>, Vec<f64>) = time.iter().zip(values).filter(|(_, x)| !x.is_nan()).unzip();
            let known = clocks.iter().find(|c| ***c == *t).cloned();
            let clock = known.unwrap_or_else(|| t.into());
            clocks.push(clock.clone());
            Signal::new(clock, x)
        };
        if !column.unit.is_empty() {
            log.units.insert(column.name.clone(), column.unit);
        }
        log.signals.insert(column.name.clone(), signal);
    }
}

/// Adds the findings of reading the rows, and the columns that were not kept.
fn passage_findings(log: &mut LogFile, passage: &Passage, options: &LogOptions) {
    for finding in passage.findings(&log.file) {
        log.add(finding);
    }
    if !log.ignored.is_empty() {
        let mut shown: Vec<String> = log.ignored.iter().take(20).map(|h| super::header::quoted(h)).collect();
        if log.ignored.len() > shown.len() {
            shown.push(format!("{} more", log.ignored.len() - shown.len()));
        }
        let reason =
            if options.missing == super::options::Missing::Error { "not a number in every row" } else { "no numbers" };
        log.note(&codes::IGNORED, None, &format!("columns not kept, {reason} or not named: {}", shown.join(", ")));
    }
}

impl LogFile {
    fn add(&mut self, finding: Finding) {
        let list = if finding.severity == Severity::Note { &mut self.notes } else { &mut self.warnings };
        list.push(finding);
    }

    fn warn(&mut self, code: &Code, line: Option<u64>, column: Option<&str>, text: &str) {
        self.warnings.push(Finding::at(code, &self.file, line, column, text));
    }

    fn note(&mut self, code: &Code, line: Option<u64>, text: &str) {
        self.notes.push(Finding::at(code, &self.file, line, None, text));
    }

    /// Number of segments, which are separated by gaps.
    pub fn segments(&self) -> usize {
        self.gaps.len() + 1
    }
}
