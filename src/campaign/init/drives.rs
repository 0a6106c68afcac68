//! Unit and scale of the thrusters' commands: the same in all logs of one vehicle.
//!
//! ```text
//! V = n / n₁        n: turns a minute in the log;
//!                   n₁: those of the vehicle file (full_rpm), else the greatest of all logs
//! ```

use std::collections::BTreeMap;

use super::commands::{self, Column, Kind};
use super::degrees::is_steered;
use super::reading::Understood;
use super::{units, words};
use crate::log::columns;
use crate::log::options::ColumnSource;
use crate::run::Signal;

/// Standard deviation of a command over its mean up to which it is constant: the noise of a
/// tachometer or of a governor.
const STEADY: f64 = 0.02;

/// The commands V1, V2, … of a log.
pub fn signals(this: &Understood) -> Vec<&Signal> {
    let letter = if this.kind == Some(Kind::Force) { "F" } else { "V" };
    let Some(log) = &this.log else { return Vec::new() };
    (1..).map(|k| log.signals.get(&format!("{letter}{k}"))).take_while(Option::is_some).flatten().collect()
}

/// The largest absolute value of all signals.
pub fn greatest(signals: &[&Signal]) -> f64 {
    signals.iter().flat_map(|s| s.values()).fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// Headers of the commands of a log: logs with the same headers are written alike.
pub fn headers(this: &Understood) -> Vec<&str> {
    this.commands.iter().map(|column| column.header.as_str()).collect()
}

/// Reassigns commands if the values of all logs with the same headers contradict the names: a
/// channel that never changes is no thruster, and a thrust that stays within ±1.5 is a part of the
/// full one. `thrusters`: number of thrusters of the vehicle, if it is known. Returns the logs to
/// read again.
pub fn place_anew(logs: &mut [Understood], thrusters: Option<usize>) -> Vec<usize> {
    let mut changed = Vec::new();
    for k in 0..logs.len() {
        let Some((columns, remark)) = other_columns(&logs[k], logs, thrusters) else { continue };
        changed.push((k, columns, remark));
    }
    let numbers = changed.iter().map(|(k, ..)| *k).collect();
    for (k, columns, remark) in changed {
        logs[k].assign_anew(columns);
        logs[k].remarks.extend(remark);
    }
    numbers
}

/// The commands of a log by the values of all logs with the same headers, with a remark; `None` if
/// they are as their names say.
fn other_columns(
    log: &Understood,
    logs: &[Understood],
    thrusters: Option<usize>,
) -> Option<(Vec<Column>, Option<String>)> {
    // commands that the user has given, or whose columns have names of channels, stay as they are
    let is_said = |column: &Column| columns::quantity(columns::split_header(&column.header).0).is_some();
    if log.commands.iter().any(is_said) || !commands::given(&log.given).is_empty() {
        return None;
    }
    let together: Vec<Vec<&Signal>> = logs
        .iter()
        .filter(|l| headers(l) == headers(log))
        .map(signals)
        .filter(|s| s.len() == log.commands.len())
        .collect();
    let values = |k: usize| together.iter().flat_map(move |log| log[k].values()).copied();
    let mut kept = log.commands.clone();
    let mut remark = None;
    let is_idle = |k: usize| values(k).next().is_some_and(|first| values(k).all(|x| x.to_bits() == first.to_bits()));
    let idle: Vec<usize> = (0..log.commands.len()).filter(|k| is_idle(*k)).collect();
    let moving = log.commands.len() - idle.len();
    // outputs of a known vehicle are identified by their number; a side says where a thruster sits
    let by_number = log.commands.iter().all(|c| c.label.bytes().all(|b| b.is_ascii_digit()));
    let counts = thrusters.is_none_or(|count| count == moving && count < log.commands.len());
    if !idle.is_empty() && moving > 0 && by_number && counts {
        let told = |k: &usize| format!("{:?} ({})", log.commands[*k].header, values(*k).next().unwrap_or_default());
        remark = Some(format!(
            "guessed: a channel that never changes belongs to no thruster: {}. If it does, number the thrusters in \
             [log.columns] or give the vehicle with --vehicle",
            idle.iter().map(told).collect::<Vec<_>>().join(", ")
        ));
        kept = kept.into_iter().enumerate().filter(|(k, _)| !idle.contains(k)).map(|(_, column)| column).collect();
    }
    let is_steady = |k: usize| {
        let (n, sum, squares) = values(k).fold((0.0, 0.0, 0.0), |(n, s, q), x| (n + 1.0, s + x, q + x * x));
        let mean: f64 = sum / n;
        n > 0.0 && squares / n - mean * mean <= (STEADY * mean).powi(2)
    };
    if (moving == 0 || (0..log.commands.len()).all(is_steady)) && thrusters.is_none() && is_steered(logs) {
        let headers: Vec<&str> = log.commands.iter().map(|column| column.header.as_str()).collect();
        remark = Some(format!(
            "guessed: the thrust of {} is one constant force, because the command does not change in any log: no \
             thruster is made of it",
            headers.join(", ")
        ));
        kept.clear();
    }
    let most = (0..log.commands.len()).flat_map(values).fold(0.0, |m: f64, x| m.max(x.abs()));
    if !kept.is_empty() && kept.iter().all(commands::is_force_by_name) && 0.0 < most && most <= commands::PARTS {
        kept.iter_mut().for_each(|column| column.kind = Some(Kind::Part));
    }
    (kept != log.commands).then_some((kept, remark))
}

/// Sets unit and scale of the commands of all logs together; `full_rpm`: turns a minute of a full
/// command of the vehicle.
pub fn settle(logs: &mut [Understood], full_rpm: Option<f64>) {
    let kinds = kinds(logs);
    for (log, kind) in logs.iter_mut().zip(&kinds) {
        log.kind = *kind;
    }
    let turning = |log: &&Understood| log.kind == Some(Kind::Turns);
    let most = logs.iter().filter(turning).map(|log| greatest(&signals(log))).fold(0.0, f64::max);
    let turns = match full_rpm {
        Some(full) => Some((1.0 / full, format!("rpm as a fraction of {full}, full_rpm of the vehicle"))),
        None if most > 0.0 => Some((1.0 / most, format!("rpm as a fraction of {most}, the largest of all logs"))),
        None => None,
    };
    for log in logs {
        let (unit, scale, why) = match (log.kind, &turns) {
            (Some(Kind::Pulse), _) => ("us", 1.0, "pulse widths by name or size"),
            (Some(Kind::Part), _) => ("1", 1.0, "they stay between -1 and 1"),
            (Some(Kind::Percent), _) => ("1", 0.01, "per cent of the full command"),
            // `write` multiplies this by the factor of the column's own unit
            (Some(Kind::Turns), Some((scale, why))) => ("1", *scale, why.as_str()),
            _ => continue,
        };
        write(log, unit, scale, why);
    }
}

/// The kind of each log's commands: by name, else by the values of all logs with the same columns.
fn kinds(logs: &[Understood]) -> Vec<Option<Kind>> {
    let mut alike: BTreeMap<Vec<&str>, Vec<&Understood>> = BTreeMap::new();
    for log in logs {
        alike.entry(headers(log)).or_default().push(log);
    }
    let of = |log: &Understood| {
        let together = &alike[&headers(log)];
        let signals: Vec<&Signal> = together.iter().flat_map(|log| signals(log)).collect();
        let named = together.iter().find_map(|log| log.kind.or_else(|| said(log)));
        named.or_else(|| (!signals.is_empty()).then(|| commands::kind_of(&signals)))
    };
    logs.iter().map(of).collect()
}

/// The kind by the unit with which the reader read the first command.
fn said(this: &Understood) -> Option<Kind> {
    match this.log.as_ref()?.units.get("V1").copied() {
        Some("us") => Some(Kind::Pulse),
        Some("1") => Some(Kind::Part),
        _ => None,
    }
}

/// Sets unit and scale of each command that the user has not given.
fn write(this: &mut Understood, unit: &str, scale: f64, why: &str) {
    let Some(log) = &this.log else { return };
    let there = |channel: &String| log.signals.contains_key(channel) && !this.given.columns.contains_key(channel);
    let read_as = log.units.clone();
    let channels: Vec<String> = (1..=this.commands.len().max(log.signals.len())).map(|k| format!("V{k}")).collect();
    for channel in channels.into_iter().filter(there).collect::<Vec<_>>() {
        let before = this.options.columns.get(&channel).map_or(1.0, |s| s.scale);
        let scale = match this.kind {
            Some(Kind::Turns) => {
                let header = this.options.columns.get(&channel).map_or(channel.as_str(), |s| s.name.as_str());
                scale * units::turns_a_minute(words::of(header).unit.as_deref())
            }
            _ => scale,
        };
        if read_as.get(&channel).copied() == Some(unit) && (scale - before).abs() < f64::EPSILON {
            continue;
        }
        let source =
            this.options.columns.entry(channel.clone()).or_insert_with(|| ColumnSource::from(channel.as_str()));
        let same = columns::split_header(&source.name).1.is_some_and(|u| u == unit);
        source.unit = (!same).then(|| unit.to_string());
        source.scale = scale;
        let key = format!("columns.{channel}");
        let text = this.reasons.get(&key).map_or_else(|| why.to_string(), |r| format!("{r}; {why}"));
        this.guess(key, text);
    }
}
