//! `effects` and `explain`: information that needs no data.

use serde::Serialize;

use super::answer;
use super::arguments::{Effects, Explain};
use super::failure::Failure;
use super::message::hanging;
use super::output::Output;
use super::table::{folded, table, width, wrapped};
use crate::campaign::codes;
use crate::effects::{Coriolis, Effect, Place, Scope, catalogue, common_name, meant, search};
use crate::frame::Dof;
use crate::model::places_of;
use crate::nearest::{most_alike, nearest};
use crate::wording::{count, listed as listed_in_words};

/// Maximum number of ids that are suggested if none is close.
const ALIKE: usize = 3;

/// An effect in the list.
#[derive(Debug, Serialize)]
struct Entry {
    id: String,
    common_name: String,
    family: &'static str,
    #[serde(rename = "where")]
    place: String,
    formula: String,
    meaning: String,
    parameters: Vec<Symbol>,
    source: String,
    shown_by: String,
}

#[derive(Debug, Serialize)]
struct Symbol {
    name: String,
    unit: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    sname: Option<String>,
    linear: bool,
}

pub(super) fn effects(arguments: &Effects, output: &Output) -> Result<(), Failure> {
    output.may_write(None)?;
    let all = catalogue(Coriolis::Free);
    let Some(id) = &arguments.id else {
        let text = arguments.search.as_deref().unwrap_or_default();
        let entries: Vec<Entry> = search(&all, text).into_iter().map(entry).collect();
        if entries.is_empty() {
            let near = meant(&all, text).map(|words| format!("; did you mean `{words}`?"));
            output.print(&format!(
                "no effect has `{text}` in its id, common name or meaning{}",
                near.unwrap_or_default()
            ));
        } else {
            output.print(&format!("{} that a model may hold, or lack.", count(entries.len(), "effect")));
            output.print(&listed(&entries, output.is_verbose()));
            answer::next(&format!("hydrosysid effects {}", entries[0].id), output);
        }
        return output.json(&entries);
    };
    let id = id.split('@').next().unwrap_or(id);
    let Some(effect) = all.iter().find(|e| e.about().id == id) else {
        return Err(Failure::Argument(unknown(id, all.iter().map(|e| e.about().id))));
    };
    let e = entry(effect.as_ref());
    let symbols: Vec<String> = e
        .parameters
        .iter()
        .map(|p| {
            let sname = p.sname.as_ref().map(|s| format!(", SNAME {s}")).unwrap_or_default();
            format!("{} [{}]{sname}{}", p.name, p.unit, if p.linear { "" } else { ", a shape parameter" })
        })
        .collect();
    output.print(&wrapped(&format!("{}, {}: {}", e.id, e.common_name, e.meaning)));
    let rows = [
        ("formula", e.formula.clone()),
        ("where", format!("{} ({})", e.place, e.family)),
        ("parameters", if symbols.is_empty() { "none".into() } else { symbols.join("; ") }),
        ("shown by", e.shown_by.clone()),
        ("source", e.source.clone()),
    ];
    output.print("");
    for (head, text) in rows {
        output.print(&row(head, &text, width()));
    }
    output.json(&e)?;
    // related effects share the first word of their ids
    answer::next(&format!("hydrosysid effects --search {}", id.split('_').next().unwrap_or(id)), output);
    Ok(())
}

/// `  formula     − k_uv u v`; text that does not fit continues below the text.
fn row(head: &str, text: &str, width: Option<usize>) -> String {
    const LEFT: usize = 14;
    let text = folded(text, width.map_or(usize::MAX, |width| width.saturating_sub(LEFT)));
    format!("  {head:<12}{}", text.replace('\n', &format!("\n{}", " ".repeat(LEFT))))
}

/// The error message for an unknown id.
fn unknown<'a>(id: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    let near = match nearest(id, known.clone()) {
        Some(one) => format!("did you mean `{one}`?"),
        None => {
            let ids: Vec<String> = most_alike(id, known, ALIKE).iter().map(|id| format!("`{id}`")).collect();
            format!("the nearest are {};", listed_in_words(&ids))
        }
    };
    format!("no effect is called `{id}`: {near} `hydrosysid effects --search WORD` finds effects by their meaning")
}

/// One effect per row; with `all` also its place, formula and unit.
fn listed(entries: &[Entry], all: bool) -> String {
    let row = |e: &Entry| {
        vec![e.id.clone(), e.common_name.clone(), e.family.into(), e.place.clone(), e.formula.clone(), units(e)]
    };
    let rows: Vec<Vec<String>> = entries.iter().map(row).collect();
    let heads = ["effect", "common name", "family", "where", "formula", "unit"];
    let columns = if all { heads.len() } else { 3 };
    table(&heads[..columns], &rows.into_iter().map(|row| row[..columns].to_vec()).collect::<Vec<_>>())
}

fn entry(effect: &dyn Effect) -> Entry {
    let about = effect.about();
    let names = |list: &[Dof]| list.iter().map(|d| d.name()).collect::<Vec<_>>().join(", ");
    let place = match about.scope {
        Scope::Each(list) if list.len() == 6 => "@ each dof".to_string(),
        Scope::Each(list) => format!("@ {}", names(list)),
        Scope::Pairs => "@ dof:other".to_string(),
        Scope::Couples(list) => {
            format!("@ {}", list.iter().map(|(i, j)| format!("{i}:{j}")).collect::<Vec<_>>().join(", "))
        }
        Scope::Vehicle(list) => format!("vehicle; needs {}", names(list)),
        Scope::VehicleAny(sets) => {
            format!("vehicle; needs {}", sets.iter().map(|set| names(set)).collect::<Vec<_>>().join(", or "))
        }
        Scope::Everywhere => "vehicle".to_string(),
        Scope::Thrusters => "thrusters of [[thruster]]".to_string(),
    };
    let first = places_of(effect, &Dof::ALL).first().copied().unwrap_or(Place::VEHICLE);
    let parameters = effect.parameters(first).into_iter().map(|p| Symbol {
        unit: p.dimension.to_string(),
        linear: p.is_linear(),
        sname: p.sname,
        name: p.name,
    });
    Entry {
        id: about.id.into(),
        common_name: common_name(about.id),
        family: about.family.name(),
        place,
        formula: about.formula.into(),
        meaning: about.meaning.into(),
        parameters: parameters.collect(),
        source: about.source.into(),
        shown_by: about.shown_by.into(),
    }
}

fn units(entry: &Entry) -> String {
    let mut units: Vec<&str> = entry.parameters.iter().map(|p| p.unit.as_str()).collect();
    units.dedup();
    units.join(", ")
}

/// A code in the list.
#[derive(Debug, Serialize)]
struct Told {
    code: &'static str,
    kind: &'static str,
    severity: crate::finding::Severity,
    meaning: &'static str,
}

pub(super) fn explain(arguments: &Explain, output: &Output) -> Result<(), Failure> {
    output.may_write(None)?;
    let all: Vec<Told> = codes::everywhere()
        .chain(crate::export::codes::ALL)
        .map(|c| Told { code: c.code, kind: c.kind, severity: c.severity, meaning: c.meaning })
        .collect();
    let severity = |told: &Told| format!("{:?}", told.severity).to_lowercase();
    let Some(code) = &arguments.code else {
        let rows: Vec<Vec<String>> =
            all.iter().map(|t| vec![t.code.into(), t.kind.into(), severity(t), t.meaning.into()]).collect();
        output.print(&table(&["code", "kind", "severity", "meaning"], &rows));
        return output.json(&all);
    };
    let meant: Vec<&Told> = all.iter().filter(|t| t.code.eq_ignore_ascii_case(code) || t.kind == code).collect();
    if meant.is_empty() {
        return Err(Failure::Argument(format!("no finding has the code `{code}`; `hydrosysid explain` lists them")));
    }
    for told in &meant {
        let meaning = hanging(&format!("  {}", told.meaning), 0, width());
        output.print(&format!("{} {} ({})\n{meaning}", told.code, told.kind, severity(told)));
    }
    output.json(&meant)
}
