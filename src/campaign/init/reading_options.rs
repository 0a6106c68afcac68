//! Reading options as text: what differs from the defaults, each guess with its reason, what else it could be below it.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::quoted;
use super::reading::Understood;
use crate::log::options::{ColumnSource, LogOptions};

/// A table of reading options with its header, where it holds anything.
pub fn table(understood: &Understood, name: &str) -> String {
    let options = options(understood, name);
    if options.is_empty() { options } else { format!("[{name}]\n{options}") }
}

/// The options of a log that differ from the defaults, guesses with their reasons; columns in a table of their own.
pub fn options(understood: &Understood, name: &str) -> String {
    write_options(&understood.options, &understood.reasons, &understood.choices, name)
}

/// Options that somebody has said.
pub fn said(options: &LogOptions, name: &str) -> String {
    write_options(options, &BTreeMap::new(), &BTreeMap::new(), name)
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

/// The line that says where a channel stands.
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
