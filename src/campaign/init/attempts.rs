//! Repeated reading of a log until nothing in it is refused; each exception is noted with its
//! reason.

use std::path::Path;

use super::reading::Understood;
use super::units;
use crate::log::options::{Duplicates, Missing, Repeated, Truncated};
use crate::log::{self, LogError, LogFile, LogOptions, codes};

/// Maximum number of attempts to read a log.
const ATTEMPTS: usize = 12;

/// Largest step back of the time that counts as rows out of order, s; at a longer one a clock was
/// set or another log begins.
const SET_BACK: f64 = 1.0;

impl Understood {
    /// Reads the file, again with another option for each thing that is refused.
    pub(super) fn attempt(&mut self, path: &Path) {
        for _ in 0..ATTEMPTS {
            match log::read(path, &self.options, &["t"]) {
                Ok(log) => {
                    self.refused.clear();
                    if self.sentinels(&log) || self.holds(&log) {
                        continue;
                    }
                    self.log = Some(log);
                    return;
                }
                Err(error) => {
                    if !self.relax(&error, path) {
                        self.refused = error.to_string().lines().map(str::to_string).collect();
                        self.refused.extend(self.set_back(path));
                        return;
                    }
                }
            }
        }
    }

    /// Allows what was refused; returns whether an option has changed.
    fn relax(&mut self, error: &LogError, path: &Path) -> bool {
        let before = self.options.clone();
        for finding in error.findings() {
            let code = finding.code;
            if code == codes::MISSING.code || code == codes::NON_FINITE.code {
                self.options.missing = Missing::NoSample;
                self.guess("missing", "cells are empty: sensors with their own rates share the file");
                if finding.message.to_lowercase().contains("inf") {
                    for text in ["inf", "-inf"] {
                        if !self.options.missing_values.iter().any(|m| m == text) {
                            self.options.missing_values.push(text.into());
                        }
                    }
                    self.guess("missing_values", "cells hold it where a number is expected");
                }
            } else if code == codes::TIME_ORDER.code {
                if self.options.duplicates == Duplicates::Error {
                    self.options.duplicates = Duplicates::First;
                    self.guess("duplicates", "time stamps are repeated");
                } else if self.set_back(path).is_none() {
                    self.options.sort = true;
                    self.guess("sort", format!("time stamps go back by less than {SET_BACK} s: rows are out of order"));
                }
            } else if code == codes::FIELD_COUNT.code {
                self.options.truncated = Truncated::Drop;
                self.guess("truncated", "the last row is truncated");
            } else if code == codes::UNIT_UNKNOWN.code {
                if let Some(column) = &finding.column {
                    self.options.columns.remove(column);
                    self.remarks.push(format!("the unit of {column} is not known: {}", finding.message));
                }
            } else if code == codes::PARSE.code
                && let Some(text) = quoted(&finding.message)
                && !self.options.missing_values.contains(&text)
            {
                self.options.missing = Missing::NoSample;
                self.options.missing_values.push(text);
                self.guess("missing", "cells are empty: sensors with their own rates share the file");
                self.guess("missing_values", "cells hold it where a number is expected");
            }
        }
        before != self.options
    }

    /// The advice if the time goes back by more than [`SET_BACK`], else `None`: sorting would mix
    /// the rows of two stretches.
    fn set_back(&self, path: &Path) -> Option<String> {
        let sorted = LogOptions { sort: true, ..self.options.clone() };
        let mut rows = log::Rows::open(path, &sorted, &["t"]).ok()?;
        let mut latest = f64::NEG_INFINITY;
        while let Some(row) = rows.next_row() {
            if latest - row.t > SET_BACK {
                return Some(format!(
                    "the time goes back by {:.3} s at line {}: a clock that was set back, or two logs in one. Split \
                     the file before that line and give both parts; if the rows are merely out of order, use --log \
                     sort=true",
                    latest - row.t,
                    row.line
                ));
            }
            latest = latest.max(row.t);
        }
        None
    }

    /// Declares sentinel values as missing; returns whether there was a new one.
    fn sentinels(&mut self, log: &LogFile) -> bool {
        let mut new = false;
        for (name, signal) in &log.signals {
            for seen in log::check::far::check(name, signal).iter().filter(|s| s.code == codes::SENTINEL) {
                let Some(value) = seen.time.map(|t| signal.at(t)) else { continue };
                let text = units::as_written(name, self.options.columns.get(name), value);
                if !self.options.missing_values.contains(&text) {
                    self.options.missing = Missing::NoSample;
                    self.options.missing_values.push(text.clone());
                    self.guess("missing", "a sensor writes a code when it has no value");
                    self.guess(
                        "missing_values",
                        format!(
                            "{name} is exactly {text} now and then, far from all other \
                                                          values"
                        ),
                    );
                    new = true;
                }
            }
        }
        new
    }

    /// Notices sensors whose values are repeated until the next sample; returns whether the option
    /// is new.
    fn holds(&mut self, log: &LogFile) -> bool {
        let told = log.warnings.iter().find(|found| found.code == codes::HELD.code);
        let (Repeated::Auto, Some(told)) = (self.options.repeated, told) else { return false };
        self.options.repeated = Repeated::NoSample;
        self.guess("repeated", told.message.clone());
        true
    }
}

/// The text in the first single quotes of a message.
fn quoted(message: &str) -> Option<String> {
    let (_, rest) = message.split_once('\'')?;
    rest.split_once('\'').map(|(text, _)| text.to_string()).filter(|text| !text.is_empty())
}
