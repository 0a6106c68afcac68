//! Conversion of the text to tables, without stopping at the first error.
//!
//! The text becomes a tree that knows the bytes of every key and value. Serde reads the tree into
//! tables; if that fails, the faulty entry is noted and cut off, and the rest is read again. What
//! is left in the tree at the end is what the tables hold, so that an index into either is one into
//! both.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue, Error};

use super::error::CampaignErrors;

/// Bytes of a key and of its value. For a table of its own the value is its header.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spot {
    pub key: Range<usize>,
    pub value: Range<usize>,
}

fn contains(outer: &Range<usize>, inner: &Range<usize>) -> bool {
    outer.start <= inner.start && inner.end <= outer.end
}

/// Reads the tree into tables. What cannot be read is cut off the tree and reported in the errors.
/// `None` if cutting does not help.
pub(super) fn read<T: DeserializeOwned>(root: &mut Spanned<DeTable<'_>>) -> (Option<T>, Vec<Error>) {
    let (whole, mut errors) = (root.get_ref().clone(), Vec::<Error>::new());
    let mut told = BTreeSet::new();
    // an option of [log] is wrong again in each run that inherits it: reported once, cut everywhere
    while errors.len() <= CampaignErrors::MOST {
        let error = match T::deserialize(toml::Deserializer::from(root.clone())) {
            Ok(tables) => return (Some(tables), errors),
            Err(error) => error,
        };
        let Some(span) = error.span() else {
            errors.push(error);
            return (None, errors);
        };
        let of_cutting = quoted(error.message(), "missing field")
            .is_some_and(|key| table_at(&whole, &span).is_some_and(|table| table.contains_key(key)));
        if !of_cutting && told.insert((span.start, span.end, error.message().to_string())) {
            errors.push(error);
        }
        if !cut(root.get_mut(), &span) {
            return (None, errors);
        }
    }
    (None, errors)
}

/// Returns the word in backticks after `start`, if the message begins with it.
pub(super) fn quoted<'m>(message: &'m str, start: &str) -> Option<&'m str> {
    let rest = message.strip_prefix(start)?.trim_start().strip_prefix('`')?;
    rest.split_once('`').map(|(word, _)| word)
}

/// Cuts off the innermost entry whose key or value holds these bytes; returns whether there was
/// one.
fn cut(table: &mut DeTable<'_>, span: &Range<usize>) -> bool {
    if table.iter_mut().any(|(_, value)| cut_below(value.get_mut(), span)) {
        return true;
    }
    let found = table.iter().find(|(k, v)| contains(&k.span(), span) || contains(&v.span(), span));
    match found.map(|(key, _)| key.clone()) {
        Some(key) => table.remove(&key).is_some(),
        None => false,
    }
}

fn cut_below(value: &mut DeValue<'_>, span: &Range<usize>) -> bool {
    match value {
        DeValue::Table(table) => cut(table, span),
        DeValue::Array(array) => {
            if array.iter_mut().any(|element| cut_below(element.get_mut(), span)) {
                return true;
            }
            let Some(at) = array.iter().position(|element| contains(&element.span(), span)) else {
                return false;
            };
            let rest: Vec<_> = array.iter().enumerate().filter(|(i, _)| *i != at).map(|(_, e)| e.clone()).collect();
            let mut shorter = DeArray::new();
            rest.into_iter().for_each(|element| shorter.push(element));
            *array = shorter;
            true
        }
        _ => false,
    }
}

/// Returns the innermost table whose value has exactly these bytes.
fn table_at<'t, 'i>(table: &'t DeTable<'i>, span: &Range<usize>) -> Option<&'t DeTable<'i>> {
    fn below<'t, 'i>(value: &'t Spanned<DeValue<'i>>, span: &Range<usize>) -> Option<&'t DeTable<'i>> {
        match value.get_ref() {
            DeValue::Table(table) => table_at(table, span).or((value.span() == *span).then_some(table)),
            DeValue::Array(array) => array.iter().find_map(|element| below(element, span)),
            _ => None,
        }
    }
    table.values().find_map(|value| below(value, span))
}

/// Returns the bytes of every entry by its path, `run[2].kind`.
pub(super) fn spots(root: &DeTable<'_>) -> BTreeMap<String, Spot> {
    let mut spots = BTreeMap::new();
    walk(root, "", &mut |path, spot, _| {
        spots.insert(path.to_string(), spot);
    });
    spots
}

/// Visits every entry with its path.
pub(super) fn walk<'i>(table: &DeTable<'i>, path: &str, visit: &mut impl FnMut(&str, Spot, &DeValue<'i>)) {
    for (key, value) in table {
        let name = key.get_ref();
        let path = if path.is_empty() { name.to_string() } else { format!("{path}.{name}") };
        walk_value(&path, &key.span(), value, visit);
    }
}

fn walk_value<'i>(
    path: &str,
    key: &Range<usize>,
    value: &Spanned<DeValue<'i>>,
    visit: &mut impl FnMut(&str, Spot, &DeValue<'i>),
) {
    visit(path, Spot { key: key.clone(), value: value.span() }, value.get_ref());
    match value.get_ref() {
        DeValue::Table(table) => walk(table, path, visit),
        DeValue::Array(array) => {
            for (i, element) in array.iter().enumerate() {
                walk_value(&format!("{path}[{i}]"), key, element, visit);
            }
        }
        _ => {}
    }
}

/// Gives every run with a `log` of its own the options of the campaign's `[log]` that it does not
/// set itself, and every file with a `log` of its own those of its run.
pub(super) fn inherit_log(root: &mut DeTable<'_>) {
    let common = match root.get("log").map(Spanned::get_ref) {
        Some(DeValue::Table(common)) => Some(common.clone()),
        _ => None,
    };
    let Some(DeValue::Array(runs)) = root.get_mut("run").map(Spanned::get_mut) else {
        return;
    };
    for run in runs.iter_mut() {
        let DeValue::Table(run) = run.get_mut() else { continue };
        let of_run = inherited(run, common.as_ref());
        match run.get_mut("file").map(Spanned::get_mut) {
            Some(DeValue::Table(file)) => drop(inherited(file, of_run.as_ref())),
            Some(DeValue::Array(files)) => {
                for file in files.iter_mut() {
                    if let DeValue::Table(file) = file.get_mut() {
                        inherited(file, of_run.as_ref());
                    }
                }
            }
            _ => {}
        }
    }
}

/// Merges the `log` of a table with that of the level above; returns the options that then hold
/// there.
fn inherited<'i>(table: &mut DeTable<'i>, common: Option<&DeTable<'i>>) -> Option<DeTable<'i>> {
    match (table.get_mut("log").map(Spanned::get_mut), common) {
        (Some(DeValue::Table(own)), Some(common)) => {
            overlay(own, common);
            Some(own.clone())
        }
        (Some(DeValue::Table(own)), None) => Some(own.clone()),
        (_, common) => common.cloned(),
    }
}

/// Adds what `own` lacks; `columns` is merged column by column.
fn overlay<'i>(own: &mut DeTable<'i>, common: &DeTable<'i>) {
    for (key, value) in common {
        match (own.get_mut(key).map(Spanned::get_mut), value.get_ref()) {
            (None, _) => {
                own.insert(key.clone(), value.clone());
            }
            (Some(DeValue::Table(own)), DeValue::Table(common)) if key.get_ref() == "columns" => overlay(own, common),
            _ => {}
        }
    }
}
