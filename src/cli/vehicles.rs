//! The verb `vehicles`: the vehicles that come with the program.

use serde::Serialize;

use super::answer;
use super::failure::Failure;
use super::output::Output;
use super::table::{number, table};
use crate::campaign::known_vehicles;
use crate::wording::count;

/// A vehicle in the list.
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
    output.print(&format!("{} that come with the program.", count(entries.len(), "vehicle")));
    let heads = ["vehicle", "what", "mass, kg", "thrusters", "published parameters", "sources"];
    let columns = if output.is_verbose() { heads.len() } else { 4 };
    output.print(&table(&heads[..columns], &rows.into_iter().map(|row| row[..columns].to_vec()).collect::<Vec<_>>()));
    output.json(&entries)?;
    answer::next("hydrosysid init LOG --vehicle bluerov2 -o FOLDER", output);
    Ok(())
}
