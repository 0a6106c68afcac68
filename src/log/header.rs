//! The header of a log: assigns columns to channels and converts their cells to SI.

use std::collections::BTreeSet;

use super::codes;
use super::columns::{self, Quantity, Unit};
use super::earth_velocity::VELOCITIES;
use super::frames;
use super::number;
use super::options::{BodyFrame, ColumnSource, Frame, LogOptions, TimeUnit};
use super::records::Record;
use crate::finding::{Code, Finding, Quote};
use crate::spreadsheet::without_mark;

/// One channel of the log.
#[derive(Debug, Clone)]
pub struct Column {
    /// Canonical name; an auxiliary channel keeps its own name.
    pub name: String,
    /// Number of the field, from 0.
    pub index: usize,
    /// Unit of the values after reading; empty if unknown.
    pub unit: &'static str,
    /// Whether the log is refused if a cell is not a number; otherwise the channel is dropped.
    pub strict: bool,
    times: f64,
    over: f64,
    offset: f64,
    /// Whether the conversion changes nothing.
    plain: bool,
}

impl Column {
    /// Returns the channel `name` in field `index`, written in `unit` and in the axes of `source`
    /// or, without those, of `options`.
    pub fn new(name: &str, index: usize, unit: Option<Unit>, source: &ColumnSource, options: &LogOptions) -> Column {
        let frame = source.frame;
        let along_earth = VELOCITIES.contains(&name) && frame.and_then(Frame::earth).is_some();
        // components along earth axes take no sign from the body axes
        let own_body = if along_earth { Some(BodyFrame::Frd) } else { frame.and_then(Frame::body) };
        let body = own_body.unwrap_or(options.body_frame);
        let turn = frames::turn(name, body, frame.and_then(Frame::earth).unwrap_or(options.earth_frame));
        let (times, over) = unit.map_or((1.0, 1.0), |u| (u.times, u.over));
        let times = times * source.scale * f64::from(source.sign) * turn.sign;
        let quantity = columns::quantity(name);
        Column {
            name: turn.name.to_string(),
            index,
            unit: si_unit(quantity, unit),
            strict: quantity.is_some(),
            times,
            over,
            offset: turn.offset,
            plain: (times, over, turn.offset) == (1.0, 1.0, 0.0),
        }
    }

    /// Returns the value in SI units and in the axes of the crate.
    #[inline]
    pub fn convert(&self, x: f64) -> f64 {
        if self.plain {
            return x;
        }
        let y = x * self.times / self.over;
        if self.offset == 0.0 {
            return y;
        }
        let y = y + self.offset;
        // φ + π is wrapped to (−π, π]; π/2 − ψ may be unwrapped and stays so
        if self.name == "phi" { y - std::f64::consts::TAU * (y / std::f64::consts::TAU).round() } else { y }
    }
}

/// Result of reading the header.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Number of fields.
    pub width: usize,
    /// Field of `t` and its header; `None` in a table without time.
    pub time: Option<(usize, String)>,
    /// Field of the date, if `columns.date` names one.
    pub date: Option<usize>,
    /// Unit of `t`.
    pub time_unit: TimeUnit,
    /// All channels except `t`, in order of field.
    pub columns: Vec<Column>,
    /// Headers that are not kept: without a name, overruled by `columns`, or repeated.
    pub ignored: Vec<String>,
}

/// The header line, with the units of the line below it if `unit_row` is set.
pub struct Heading {
    line: u64,
    quote: Quote,
    raw: String,
    width: usize,
    headers: Vec<String>,
}

impl Heading {
    /// Returns the header line.
    pub fn of(record: &Record, options: &LogOptions) -> Heading {
        let headers = (0..record.width().min(options.max_columns)).map(|i| record.text(i)).collect();
        Heading {
            line: record.line,
            quote: record.quote(usize::MAX),
            raw: record.raw(),
            width: record.width(),
            headers,
        }
    }

    /// Returns the header with a unit after each name that has none: `surge`, `m/s` become `surge [m/s]`.
    #[must_use]
    pub fn with_units(mut self, units: &Record) -> Heading {
        for (i, header) in self.headers.iter_mut().enumerate() {
            let unit = units.text(i);
            let unit = unit.trim().trim_matches(['[', ']', '(', ')']);
            if !unit.is_empty() && columns::split_header(header).1.is_none() {
                *header = format!("{} [{unit}]", header.trim());
            }
        }
        self
    }
}

/// The header, and what it is checked against.
struct Reader<'a> {
    options: &'a LogOptions,
    required: &'a [&'a str],
    file: &'a str,
    line: u64,
    quote: Quote,
    headers: Vec<String>,
    found: Vec<Finding>,
}

impl Plan {
    /// Reads the header.
    ///
    /// # Errors
    /// All faults of the header.
    pub fn new(heading: Heading, options: &LogOptions, required: &[&str], file: &str) -> Result<Plan, Vec<Finding>> {
        let Heading { line, quote, raw, width, headers } = heading;
        let mut reader = Reader { options, required, file, line, quote, headers, found: Vec::new() };
        if width > options.max_columns {
            let text = format!("{width} columns, more than max_columns = {}", options.max_columns);
            return Err(vec![reader.finding(&codes::COLUMN_LIMIT, None, &text)]);
        }
        if let Some(finding) = reader.no_header() {
            return Err(vec![finding]);
        }
        let (named, ignored) = reader.names();
        if let Some(finding) = reader.other_delimiter(&raw, named.len()) {
            return Err(vec![finding]);
        }
        reader.missing(&named);
        let plan = reader.plan(&named, ignored);
        if reader.found.is_empty() { Ok(plan) } else { Err(reader.found) }
    }
}

impl Reader<'_> {
    fn finding(&self, code: &Code, column: Option<&str>, text: &str) -> Finding {
        Finding::at(code, self.file, Some(self.line), column, text).quoting(Some(self.quote.clone()))
    }

    fn is_asked_for(&self, header: &str) -> bool {
        let (base, _) = columns::split_header(header);
        columns::quantity(base).is_some()
            || self.required.contains(&base)
            || self.options.columns.values().any(|s| s.name.trim() == header || s.name.trim() == base)
    }

    /// Returns a finding if the first line is a comment or a row of numbers.
    fn no_header(&self) -> Option<Finding> {
        let first = self.headers.first().map_or("", String::as_str);
        let mark = ["#", "%", "//", "!", ";", "*"].into_iter().find(|m| first.starts_with(m));
        if let Some(mark) = mark.filter(|_| !self.is_asked_for(first)) {
            let text = format!(
                "{} where the header should be; if these lines are comments set comment = \"{mark}\"",
                quoted(first)
            );
            return Some(self.finding(&codes::HEADER, None, &text));
        }
        let decimal = self.options.decimal as u8;
        let numbers = self.headers.iter().filter(|h| number::parse(h.as_bytes(), decimal).is_some()).count();
        if 2 * numbers >= self.headers.len().max(1) && !self.headers.iter().any(|h| self.is_asked_for(h)) {
            let text = "numbers where the header should be; put a header line with the names of the columns first";
            return Some(self.finding(&codes::HEADER, None, text));
        }
        None
    }

    /// Returns the canonical name and the field of every column, and the headers that are ignored.
    fn names(&mut self) -> (Vec<(String, usize)>, Vec<String>) {
        let mut named: Vec<(String, usize)> = Vec::new();
        let mut taken = BTreeSet::new();
        for (canonical, source) in &self.options.columns {
            let wanted = source.name.trim();
            let mut fields: Vec<usize> = self.fields(|h| h == wanted);
            if fields.is_empty() {
                fields = self.fields(|h| columns::split_header(h).0 == wanted);
            }
            match fields[..] {
                [] => {
                    let text = format!(
                        "columns.{canonical} = {} is not in the header, which has {}",
                        quoted(wanted),
                        self.listed()
                    );
                    self.found.push(self.finding(&codes::MISSING_COLUMN, Some(canonical), &text));
                }
                [index] => {
                    taken.insert(index);
                    named.push((canonical.clone(), index));
                }
                [_, ..] => self.duplicate(canonical, &fields),
            }
        }
        let mut ignored = Vec::new();
        for index in 0..self.headers.len() {
            let (base, _) = columns::split_header(&self.headers[index]);
            if taken.contains(&index) {
                continue;
            }
            if base.is_empty() || self.options.columns.contains_key(base) {
                ignored.push(self.headers[index].clone());
            } else {
                named.push((without_mark(base).to_string(), index));
            }
        }
        (self.unique(named, &mut ignored), ignored)
    }

    fn fields(&self, wanted: impl Fn(&str) -> bool) -> Vec<usize> {
        (0..self.headers.len()).filter(|i| wanted(&self.headers[*i])).collect()
    }

    fn duplicate(&mut self, name: &str, fields: &[usize]) {
        let places: Vec<String> = fields.iter().map(|i| (i + 1).to_string()).collect();
        let text = format!(
            "the name {} heads fields {}; rename one, or name the right one in columns",
            quoted(name),
            places.join(" and ")
        );
        self.found.push(self.finding(&codes::DUPLICATE_COLUMN, Some(name), &text));
    }

    /// Refuses known names that occur twice; of equal auxiliary names the first is kept.
    fn unique(&mut self, mut named: Vec<(String, usize)>, ignored: &mut Vec<String>) -> Vec<(String, usize)> {
        named.sort();
        let mut unique: Vec<(String, usize)> = Vec::with_capacity(named.len());
        for same in named.chunk_by(|a, b| a.0 == b.0) {
            let (name, _) = &same[0];
            if same.len() > 1 && (columns::quantity(name).is_some() || self.required.contains(&name.as_str())) {
                let fields: Vec<usize> = same.iter().map(|(_, i)| *i).collect();
                self.duplicate(name, &fields);
            }
            ignored.extend(same[1..].iter().map(|(_, i)| self.headers[*i].clone()));
            unique.push(same[0].clone());
        }
        unique
    }

    /// Returns the names in the header as a list for a message.
    fn listed(&self) -> String {
        const SHOWN: usize = 20;
        let names: Vec<String> = self.headers.iter().take(SHOWN).map(|h| quoted(h)).collect();
        let more = self.headers.len().saturating_sub(SHOWN);
        if more > 0 { format!("{} and {more} more", names.join(", ")) } else { names.join(", ") }
    }

    /// Returns a finding if another delimiter yields more of the expected names.
    fn other_delimiter(&self, raw: &str, named: usize) -> Option<Finding> {
        let asked = self.headers.iter().filter(|h| self.is_asked_for(h)).count();
        if asked == named && named > 1 {
            return None;
        }
        let better =
            |d: &char| raw.split(*d).filter(|h| self.is_asked_for(h.trim().trim_matches('"'))).count() > asked.max(1);
        let d = [';', '\t', '|', ',', ' ', ':'].into_iter().find(|d| *d != self.options.delimiter && better(d))?;
        let text = format!(
            "the header does not split at {:?} but does at {d:?}; set delimiter = {:?}",
            self.options.delimiter,
            d.to_string()
        );
        Some(self.finding(&codes::DELIMITER, None, &text))
    }

    fn missing(&mut self, named: &[(String, usize)]) {
        for name in self.required {
            let is_there = named.iter().any(|(n, _)| n == name);
            if !is_there && !self.found.iter().any(|f| f.column.as_deref() == Some(name)) {
                let text = format!(
                    "no column {}; the header has {}; if one of them is it, set columns.{name} = \"its header\"",
                    quoted(name),
                    self.listed()
                );
                self.found.push(self.finding(&codes::MISSING_COLUMN, Some(name), &text));
            }
        }
    }

    fn plan(&mut self, named: &[(String, usize)], ignored: Vec<String>) -> Plan {
        let mut plan = Plan {
            width: self.headers.len(),
            time: None,
            date: None,
            time_unit: TimeUnit::S,
            columns: Vec::new(),
            ignored,
        };
        for (name, index) in named {
            if name == "date" && self.options.columns.contains_key("date") {
                plan.date = Some(*index);
                continue;
            }
            let unit = self.unit(name, *index);
            if name == "t" {
                plan.time = Some((*index, self.headers[*index].clone()));
                let written = unit.and_then(|u| TimeUnit::from_name(u.name));
                plan.time_unit = self.options.time_unit.or(written).unwrap_or(TimeUnit::S);
                continue;
            }
            let source = self.options.columns.get(name).cloned().unwrap_or_else(|| ColumnSource::from(name.as_str()));
            let mut column = Column::new(name, *index, unit, &source, self.options);
            column.strict |= self.required.contains(&name.as_str());
            plan.columns.push(column);
        }
        plan.columns.sort_by_key(|c| c.index);
        plan
    }

    /// Returns the unit that a column is written in; an unknown unit of a known column is an error.
    fn unit(&mut self, name: &str, index: usize) -> Option<Unit> {
        let written = columns::split_header(&self.headers[index]).1.filter(|u| !u.is_empty());
        let given = self.options.columns.get(name).and_then(|s| s.unit.as_deref()).or(written)?;
        let Some(quantity) = columns::quantity(name) else { return columns::any_unit(given) };
        let overruled = name == "t" && (self.options.time_unit.is_some() || self.options.time_format.is_some());
        let unit = quantity.unit(given);
        if unit.is_none() && !overruled {
            let text = format!(
                "the unit {} is not one of {}; if the header means one of these set columns.{name} = {{ name = {:?}, unit = \"…\" }}",
                quoted(given),
                quantity.accepted(),
                self.headers[index]
            );
            self.found.push(self.finding(&codes::UNIT_UNKNOWN, Some(name), &text));
        }
        unit
    }
}

/// Unit after conversion. A command keeps its own unit: the effect of a volt or a microsecond
/// depends on the thruster.
fn si_unit(quantity: Option<Quantity>, unit: Option<Unit>) -> &'static str {
    match (quantity, unit) {
        (Some(Quantity::Command), Some(unit)) => unit.name,
        (Some(quantity), _) => quantity.units().first().map_or("", |u| u.name),
        (None, Some(unit)) => columns::si_name(unit),
        (None, None) => "",
    }
}

/// Quotes a text from the file: control characters such as line ends are escaped, long texts are cut.
pub fn quoted(text: &str) -> String {
    const SHOWN: usize = 40;
    let shown: String = text
        .chars()
        .take(SHOWN)
        .flat_map(|c| if c.is_control() { c.escape_default().collect::<Vec<_>>() } else { vec![c] })
        .collect();
    match text.chars().count() {
        length if length > SHOWN => format!("'{shown}…' ({length} characters)"),
        _ => format!("'{shown}'"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::records::Records;

    fn plan(header: &str, options: &str, required: &[&str]) -> Result<Plan, Vec<Finding>> {
        let options: LogOptions = toml::from_str(options).unwrap();
        let mut records = Records::new(header.as_bytes(), options.delimiter as u8, None, 1 << 20).unwrap();
        Plan::new(Heading::of(&records.next_record().unwrap().unwrap(), &options), &options, required, "f.csv")
    }

    fn refused(header: &str, options: &str) -> (&'static str, String) {
        let found = plan(header, options, &["t", "u"]).unwrap_err();
        (found[0].kind, found[0].message.clone())
    }

    #[test]
    fn units_of_header_and_options() {
        let plan = plan(
            "t [ms],u [kn],gyro z,depth [m],wind_dir [deg],V1 [us]",
            "columns.r = { name = \"gyro z\", unit = \"deg/s\", sign = -1 }",
            &["t", "u", "r"],
        )
        .unwrap();
        assert_eq!(plan.time_unit, TimeUnit::Ms);
        let value = |name: &str, x| plan.columns.iter().find(|c| c.name == name).unwrap().convert(x);
        assert_eq!(value("u", 1.0), 1852.0 / 3600.0);
        assert_eq!(value("r", 180.0), -std::f64::consts::PI);
        assert_eq!(value("depth", 12.5), 12.5);
        assert_eq!(value("wind_dir", 180.0), std::f64::consts::PI);
        assert_eq!(value("V1", 1500.0), 1500.0);
        assert_eq!(plan.columns.last().map(|c| c.unit), Some("us"));
    }

    #[test]
    fn headers_are_refused_with_what_would_be_right() {
        for delimiter in [';', '\t', '|'] {
            let (kind, message) = refused(&format!("t{delimiter}u"), "");
            assert!(kind == "delimiter" && message.contains(&format!("{delimiter:?}")), "{message}");
        }
        assert_eq!(refused("t,u", "delimiter = \";\"").0, "delimiter");
        for (header, kind, word) in [
            ("0.0,1e-3,-5", "header", "names"),
            ("% made by", "header", "comment = \"%\""),
            ("t,u,u", "duplicate-column", "2 and 3"),
            ("t,u [km/h]", "unit", "m/s, mm/s, cm/s, kn"),
            ("t,speed", "missing-column", "'speed'"),
        ] {
            let (found, message) = refused(header, "");
            assert!(found == kind && message.contains(word), "{message}");
        }
        assert_eq!(refused("t,u", "columns.r = \"gyro\"").0, "missing-column");
        assert_eq!(refused("t,u,a,b", "max_columns = 3").0, "column-limit");
    }

    #[test]
    fn a_mapped_name_overrules_the_one_in_the_file() {
        let plan = plan("t,u,u_dvl,note,note,", "columns.u = \"u_dvl\"", &["t", "u"]).unwrap();
        assert_eq!(
            plan.columns.iter().map(|c| (c.name.as_str(), c.index)).collect::<Vec<_>>(),
            [("u", 2), ("note", 3)]
        );
        assert_eq!(plan.ignored, ["u", "", "note"]);
    }

    #[test]
    fn texts_are_shown_short_and_on_one_line() {
        assert_eq!(quoted("a\nb"), "'a\\nb'");
        assert!(quoted(&"x".repeat(5000)).ends_with("(5000 characters)"));
    }
}
