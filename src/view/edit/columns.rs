//! Edits of the assignment of log columns to channels: the table `columns` of the reading options.

use std::collections::BTreeMap;

use toml_edit::{InlineTable, Item, Table, Value};

use super::{document, put, run};
use crate::log::options::ColumnSource;
use crate::view::answer::Refusal;

/// The place of the reading options to edit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// `[log]`: all runs without options of their own.
    Campaign,
    /// `[run.log]` of a run.
    Run(usize),
    /// `[run.file.log]` of one log of a run.
    File(usize, usize),
}

/// Replaces the columns at a place by `columns`. Entries that do not change keep their comments.
pub fn set(text: &str, place: Place, columns: &BTreeMap<String, ColumnSource>) -> Result<String, Refusal> {
    let mut document = document(text)?;
    let log = match place {
        Place::Campaign => document.entry("log").or_insert(Item::Table(Table::new())),
        Place::Run(index) => run(&mut document, index)?.entry("log").or_insert(Item::Table(Table::new())),
        Place::File(index, file) => {
            let files = run(&mut document, index)?.get_mut("file").and_then(Item::as_array_of_tables_mut);
            let table = files.and_then(|list| list.get_mut(file));
            table.ok_or_else(inline)?.entry("log").or_insert(Item::Table(Table::new()))
        }
    };
    let log = log.as_table_mut().ok_or_else(inline)?;
    if columns.is_empty() {
        log.remove("columns");
        return Ok(document.to_string());
    }
    let table = log.entry("columns").or_insert(Item::Table(Table::new())).as_table_mut().ok_or_else(inline)?;
    let gone: Vec<String> =
        table.iter().map(|(key, _)| key.to_string()).filter(|key| !columns.contains_key(key)).collect();
    gone.iter().for_each(|key| drop(table.remove(key)));
    for (channel, source) in columns {
        let there = table.get(channel).and_then(Item::as_value).and_then(read);
        if there.as_ref() != Some(source) {
            put(table, channel, written(source));
        }
    }
    Ok(document.to_string())
}

fn inline() -> Refusal {
    Refusal::unusable("the reading options are written in one line: write a table [log.columns] to edit them here")
}

/// Parses a source from its TOML value.
fn read(value: &Value) -> Option<ColumnSource> {
    let mut bare = value.clone();
    bare.decor_mut().clear();
    let text = format!("source = {bare}");
    toml::from_str::<BTreeMap<String, ColumnSource>>(&text).ok()?.remove("source")
}

/// The TOML value of a source: the name alone, or a table if it has other properties.
fn written(source: &ColumnSource) -> Value {
    let scaled = (source.scale - 1.0).abs() > 0.0;
    if source.unit.is_none() && source.frame.is_none() && !scaled && source.sign > 0 {
        return Value::from(source.name.as_str());
    }
    let mut table = InlineTable::new();
    table.insert("name", Value::from(source.name.as_str()));
    if let Some(unit) = &source.unit {
        table.insert("unit", Value::from(unit.as_str()));
    }
    if scaled {
        table.insert("scale", Value::from(source.scale));
    }
    if source.sign < 0 {
        table.insert("sign", Value::from(-1));
    }
    if let Some(toml::Value::String(frame)) = source.frame.and_then(|frame| toml::Value::try_from(frame).ok()) {
        table.insert("frame", Value::from(frame));
    }
    Value::InlineTable(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::options::Frame;

    fn source(name: &str, unit: Option<&str>, sign: i8) -> ColumnSource {
        ColumnSource { unit: unit.map(Into::into), sign, ..ColumnSource::from(name) }
    }

    #[test]
    fn columns_change_and_the_others_keep_their_comments() {
        let text = "# mine\n[log]\nsort = true\n\n[log.columns]\n# guessed: by its name\nu = 'speed' # m/s\nr = { name = 'gyro', unit = 'deg/s' }\npsi = 'yaw'\n\n[[run]]\nfile = 'a.csv'\n";
        let columns = [
            ("u", source("speed", None, 1)),
            ("r", source("gyro", Some("deg/s"), -1)),
            ("x", source("north", None, 1)),
            ("v", ColumnSource { frame: Some(Frame::Ned), ..source("east_speed", None, 1) }),
        ];
        let columns: BTreeMap<String, ColumnSource> = columns.map(|(k, v)| (k.to_string(), v)).into();
        let text = set(text, Place::Campaign, &columns).unwrap();
        assert!(text.contains("# guessed: by its name\nu = 'speed' # m/s\n"), "{text}");
        let read: toml::Table = toml::from_str(&text).unwrap();
        let table = read["log"]["columns"].as_table().unwrap();
        assert_eq!(table["r"]["sign"].as_integer(), Some(-1));
        assert_eq!((table["x"].as_str(), table.get("psi")), (Some("north"), None));
        assert_eq!(table["v"]["frame"].as_str(), Some("ned"));
        let none = set(&text, Place::Campaign, &BTreeMap::new()).unwrap();
        assert!(!none.contains("columns") && none.contains("sort = true"), "{none}");
    }

    #[test]
    fn a_run_gets_a_table_of_its_own() {
        let text = "[[run]]\nfile = 'a.csv' # the first\n\n[[run]]\nfile = 'b.csv'\n";
        let columns = [("u".to_string(), source("speed", Some("kn"), 1))].into();
        let text = set(text, Place::Run(0), &columns).unwrap();
        let read: toml::Table = toml::from_str(&text).unwrap();
        assert_eq!(read["run"][0]["log"]["columns"]["u"]["unit"].as_str(), Some("kn"), "{text}");
        assert_eq!(read["run"][1]["file"].as_str(), Some("b.csv"));
        assert_eq!(set(&text, Place::File(0, 0), &BTreeMap::new()).unwrap_err().status, 422);
    }
}
