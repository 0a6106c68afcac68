//! The verb `vehicles`: the vehicles that come with the program.

use serde::Serialize;

use super::failure::Failure;
use super::output::Output;
use super::table::{number, table};
use crate::campaign::known_vehicles;

/// A vehicle as it is listed.
#[derive(Debug, Serialize)]
struct Entry {
    name: String,
    title: String,
    thrusters: Vec<String>,
    mass: Option<f64>,
    published: bool,
    sources: Vec<String>,
}

pub(super) fn vehicles(output: &Output) -> Result<(), Failure> {
    output.may_write(None)?;
    let entries: Vec<Entry> = known_vehicles()
        .into_iter()
        .map(|known| Entry {
            name: known.id,
            title: known.file.vehicle.name.clone(),
            thrusters: known.file.thrusters.iter().map(|t| t.name.clone()).collect(),
            mass: known.file.vehicle.mass,
            published: known.file.published.is_some(),
            sources: known.file.sources,
        })
        .collect();
    let rows: Vec<Vec<String>> = entries
        .iter()
        .map(|e| {
            vec![
                e.name.clone(),
                e.title.clone(),
                e.mass.map_or_else(|| "-".into(), number),
                e.thrusters.len().to_string(),
                if e.published { "yes" } else { "no" }.into(),
                e.sources.join("\n"),
            ]
        })
        .collect();
    output.print(&table(&["vehicle", "what", "mass, kg", "thrusters", "published parameters", "sources"], &rows));
    output.print(
        "`hydrosysid init LOG --vehicle NAME -o FOLDER` takes one, or a file that extends one: extends = \"bluerov2\".",
    );
    output.json(&entries)
}
