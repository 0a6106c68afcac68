//! Edits of the text of a campaign that keep everything else unchanged, comments included: text in,
//! text out.

pub(super) mod columns;
pub(super) mod effects;
pub(super) mod runs;

use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, Value};

use super::answer::Refusal;

/// The text as a TOML document.
fn document(text: &str) -> Result<DocumentMut, Refusal> {
    text.parse().map_err(|e: toml_edit::TomlError| {
        Refusal::unusable(format!("the campaign file is not valid TOML, correct it first: {}", e.message()))
    })
}

/// The `[[run]]` tables.
fn runs(document: &mut DocumentMut) -> Result<&mut ArrayOfTables, Refusal> {
    let item = document.entry("run").or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
    item.as_array_of_tables_mut().ok_or_else(|| {
        Refusal::unusable("`run` is written as a list in one line: write [[run]] tables to edit them here")
    })
}

/// One `[[run]]` table.
fn run(document: &mut DocumentMut, index: usize) -> Result<&mut Table, Refusal> {
    runs(document)?.get_mut(index).ok_or_else(|| Refusal::absent(format!("there is no run {}", index + 1)))
}

/// Sets the value of a key; a comment after the old value stays.
fn put(table: &mut Table, key: &str, value: impl Into<Value>) {
    let mut value = value.into();
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(before) => {
            *value.decor_mut() = before.decor().clone();
            *before = value;
        }
        None => drop(table.insert(key, Item::Value(value))),
    }
}

/// Clears the positions of a table and those within it, so that they are written where they are
/// inserted.
fn unplaced(table: &mut Table) {
    table.set_position(None);
    for (_, item) in table.iter_mut() {
        match item {
            Item::Table(inner) => unplaced(inner),
            Item::ArrayOfTables(list) => list.iter_mut().for_each(unplaced),
            _ => {}
        }
    }
}
