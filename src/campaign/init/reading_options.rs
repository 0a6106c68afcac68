//! Reading options as text: those that differ from the defaults, each guess with its reason and its
//! alternatives.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::quoted;
use super::reading::Understood;
use crate::log::options::{ColumnSource, LogOptions};

/// The table of a log's reading options with its header; empty if all are defaults.
pub fn table(understood: &Understood, name: &str) -> String {
    headed(&write_options(&understood.options, &understood.reasons, &understood.choices, name), name)
}

/// Options below the header of their table. Columns have a header of their own and need none.
fn headed(options: &str, name: &str) -> String {
    if options.is_empty() || options.starts_with("\n[") { options.to_string() } else { format!("[{name}]\n{options}") }
}

/// The options that several logs have in common.
#[derive(Debug, Default)]
pub struct Common {
    options: LogOptions,
    reasons: BTreeMap<String, String>,
    choices: BTreeMap<String, Vec<ColumnSource>>,
}

impl Common {
    /// The common options of these logs; without logs, the options that the user has given.
    pub fn of(logs: &[&Understood], given: &LogOptions) -> Common {
        let Some((first, others)) = logs.split_first() else {
            return Common { options: given.clone(), ..Common::default() };
        };
        let keys = |log: &Understood| toml::Table::try_from(&log.options).unwrap_or_default();
        let mut shared = keys(first);
        for other in others.iter().map(|log| keys(log)) {
            shared.retain(|key, value| key == "columns" || other.get(key) == Some(value));
        }
        let mut options = shared.try_into::<LogOptions>().unwrap_or_default();
        options.columns.retain(|name, source| others.iter().all(|log| log.options.columns.get(name) == Some(source)));
        // the longest reason is kept: a log that contradicts the others has it
        let mut reasons = first.reasons.clone();
        for (key, reason) in &mut reasons {
            let said = logs.iter().filter_map(|log| log.reasons.get(key));
            reason.clone_from(said.max_by_key(|text| text.len()).unwrap_or(&reason.clone()));
        }
        Common { options, reasons, choices: first.choices.clone() }
    }

    /// The options as text, columns in a table of their own.
    pub fn text(&self, name: &str) -> String {
        write_options(&self.options, &self.reasons, &self.choices, name)
    }

    /// The table of the options of one log that are not common.
    pub fn rest(&self, log: &Understood, name: &str) -> String {
        let keys = |options: &LogOptions| toml::Table::try_from(options).unwrap_or_default();
        let common = keys(&self.options);
        let mut own = keys(&log.options);
        own.retain(|key, value| key == "columns" || common.get(key) != Some(value));
        let mut options = own.try_into::<LogOptions>().unwrap_or_default();
        options.columns.retain(|name, source| self.options.columns.get(name) != Some(source));
        headed(&write_options(&options, &log.reasons, &log.choices, name), name)
    }
}

fn write_options(
    options: &LogOptions,
    reasons: &BTreeMap<String, String>,
    choices: &BTreeMap<String, Vec<ColumnSource>>,
    name: &str,
) -> String {
    let usual = toml::Table::try_from(LogOptions::default()).unwrap_or_default();
    let own = toml::Table::try_from(options).unwrap_or_default();
    let mut text = String::new();
    let comment = |key: &str| reasons.get(key).map(|why| format!("# guessed: {why}\n")).unwrap_or_default();
    for (key, value) in own.iter().filter(|(key, value)| *key != "columns" && usual.get(*key) != Some(value)) {
        let _ = writeln!(text, "{}{key} = {value}", comment(key));
    }
    if !options.columns.is_empty() {
        let _ = writeln!(text, "\n[{name}.columns]");
        for (channel, source) in &options.columns {
            let _ = writeln!(text, "{}{}", comment(&format!("columns.{channel}")), column(channel, source));
            for other in choices.get(channel).into_iter().flatten() {
                let _ = writeln!(text, "# or: {}", column(channel, other));
            }
        }
    }
    text
}

/// The line that assigns a column to a channel.
fn column(channel: &str, source: &ColumnSource) -> String {
    let mut parts = vec![format!("name = {}", toml::Value::from(source.name.clone()))];
    parts.extend(source.unit.as_ref().map(|unit| format!("unit = {}", quoted(unit))));
    if (source.scale - 1.0).abs() > 0.0 {
        parts.push(format!("scale = {:?}", source.scale));
    }
    if source.sign < 0 {
        parts.push("sign = -1".into());
    }
    let value = if parts.len() == 1 {
        toml::Value::from(source.name.clone()).to_string()
    } else {
        format!("{{ {} }}", parts.join(", "))
    };
    let plain = channel.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let key = if plain { channel.to_string() } else { quoted(channel) };
    format!("{key} = {value}")
}
