//! The time of a log: its column, and its unit or format.

use super::commands::{self, COMMAND, FORCE, names};
use super::layout::Layout;
use super::reading::Understood;
use super::words;
use crate::log;
use crate::log::columns;
use crate::log::options::{ColumnSource, TimeFormat, TimeUnit};

impl Understood {
    /// Finds the time, by its name or as the first column that grows in each row.
    pub(super) fn time(&mut self, layout: &Layout, own: &mut Vec<String>, left: &mut Vec<String>) {
        if self.date_and_time(layout, own, left) {
            return;
        }
        if !own.iter().any(|o| o == "t") {
            let cell = |row: &Vec<String>, k: usize| row[k].replace(self.options.decimal, ".").parse::<f64>().ok();
            let grows = |k: usize| {
                let x: Option<Vec<f64>> = layout.rows.iter().map(|row| cell(row, k)).collect();
                x.is_some_and(|x| x.len() > 2 && x.windows(2).all(|w| w[1] > w[0]))
            };
            // commands and forces of a table may grow, too
            let is_thrust = |k: usize| {
                let words = words::of(&layout.headers[k]);
                commands::of(&layout.headers[k], &words).is_some() || names(&words, FORCE) || names(&words, COMMAND)
            };
            let is_time = |k: &usize| layout.is_date(*k) || grows(*k) && !is_thrust(*k);
            let counts = |k: &usize| log::check::time::is_called_counter(&layout.headers[*k]);
            // a counter of rows is taken only if no other column grows in each row
            let found = (0..layout.headers.len()).filter(is_time).min_by_key(counts);
            if let Some(k) = found {
                let header = layout.headers[k].clone();
                left.retain(|h| *h != header);
                self.options.columns.retain(|_, source| source.name != header);
                self.options.columns.insert("t".into(), ColumnSource::from(header.as_str()));
                self.guess("columns.t", format!("{header:?} grows in each row, and no column is named time"));
                own.push("t".into());
            }
        }
        let header = self.options.columns.get("t").map_or("t", |s| s.name.as_str());
        let at = layout.headers.iter().position(|h| h == header || columns::split_header(h).0 == header);
        let Some(at) = at else { return };
        if layout.is_date(at) && self.options.time_format.is_none() {
            self.options.time_format = Some(TimeFormat::Iso8601);
            self.options.time_unit = None;
            self.guess("time_format", "the stamps are dates");
        } else if layout.is_duration(at) && self.options.time_format.is_none() {
            self.options.time_format = Some(TimeFormat::Duration);
            self.options.time_unit = None;
            self.guess("time_format", "the stamps are numbers with a unit");
        } else if layout.is_time_of_day(at) && self.options.time_format.is_none() {
            self.options.time_format = Some(TimeFormat::TimeOfDay);
            self.options.time_unit = None;
            self.guess("time_format", "the stamps are times of day");
        } else if self.options.time_unit.is_none() && self.options.time_format.is_none() {
            self.time_unit(layout, at);
        }
    }

    /// The message for a file of commands and forces without a time: it is a table of a thruster,
    /// not a run.
    pub(super) fn table(&self, layout: &Layout) -> Option<String> {
        let is_timed = |h: &String| columns::split_header(h).0 == "t";
        if self.options.columns.contains_key("t") || layout.headers.iter().any(is_timed) {
            return None;
        }
        let of = |wanted: &[&str]| layout.headers.iter().find(|h| names(&words::of(h), wanted));
        let (command, force) = (of(COMMAND).or_else(|| Some(&self.commands.first()?.header))?, of(FORCE)?);
        Some(format!(
            "no column is a time: a table of a thruster (command {command:?}, force {force:?}), not a run. With the \
             columns V1 and force and their units, as V1 [us] and force [N], it is the bollard table of a \
             [[thruster]]: bollard = {:?}",
            self.shown
        ))
    }

    /// Places a date in one column and a time of day in another; returns whether the log has them.
    fn date_and_time(&mut self, layout: &Layout, own: &mut Vec<String>, left: &mut Vec<String>) -> bool {
        let columns = 0..layout.headers.len();
        let date = columns.clone().find(|k| layout.is_day(*k));
        let time = columns.clone().find(|k| layout.is_time_of_day(*k));
        let (Some(date), Some(time)) = (date, time) else { return false };
        if ["t", "date"].iter().any(|name| self.given.columns.contains_key(*name)) || self.given.time_format.is_some() {
            return false;
        }
        for (channel, at) in [("date", date), ("t", time)] {
            let header = layout.headers[at].clone();
            left.retain(|h| *h != header);
            self.options.columns.retain(|_, source| source.name != header);
            let why = if channel == "date" { "dates, for the times of day" } else { "times of day, of the dates" };
            self.guess(format!("columns.{channel}"), format!("{header:?} holds {why} in another column"));
            self.options.columns.insert(channel.into(), ColumnSource::from(header.as_str()));
        }
        self.choices.remove("t");
        if !own.iter().any(|o| o == "t") {
            own.push("t".into());
        }
        true
    }

    fn time_unit(&mut self, layout: &Layout, at: usize) {
        if words::of(&layout.headers[at]).unit.as_deref().is_some_and(|u| TimeUnit::from_name(u).is_some()) {
            return;
        }
        let stamps: Vec<f64> =
            layout.rows.iter().filter_map(|row| row[at].replace(self.options.decimal, ".").parse().ok()).collect();
        let Some(step) = log::check::time::usual_step(&stamps).filter(|s| *s > 0.0) else { return };
        let first = stamps.first().copied().unwrap_or(0.0);
        // the size of the stamps gives the unit of a wall clock, the step that of others: no
        // vehicle logs every 5 s or more
        let (unit, why) = match (first, step) {
            (x, _) if x > 1e17 => (TimeUnit::Ns, "stamps of that size are nanoseconds since 1970".to_string()),
            (x, _) if x > 1e14 => (TimeUnit::Us, "stamps of that size are microseconds since 1970".to_string()),
            (x, _) if x > 1e11 => (TimeUnit::Ms, "stamps of that size are milliseconds since 1970".to_string()),
            (_, s) if s >= 5e5 => (TimeUnit::Ns, format!("the usual step is {s}")),
            (_, s) if s > 2e3 => (TimeUnit::Us, format!("the usual step is {s}")),
            (_, s) if s >= 5.0 => (TimeUnit::Ms, format!("the usual step is {s}")),
            _ => return,
        };
        self.options.time_unit = Some(unit);
        self.guess("time_unit", why);
    }
}
