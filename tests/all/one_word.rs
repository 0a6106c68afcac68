//! The id of an effect is written in one file only: no module outside `effects` refers to an effect
//! by a literal id.
//!
//! The nature of an effect is derived from its formulas ([`hydrosysid::chain::nature`]); code that
//! means one particular effect takes its id from [`hydrosysid::effects::id`]. The tank and the demo
//! hide effects by name, as a campaign file does.

use std::fs;
use std::path::Path;

use hydrosysid::effects::{Coriolis, catalogue};

use crate::rooms::sources;

/// Words that are equal to an id but mean something else in the given file.
const OTHER_WORDS: [(&str, &str); 7] = [
    ("run.rs", "supply_voltage"),             // a column of a log
    ("campaign/init/commands.rs", "current"), // of a motor, in A
    ("export/urdf.rs", "inertia"),            // an element of URDF
    ("export/gazebo.rs", "inertia"),          // an element of SDF
    ("export/mod.rs", "inertia"),             // an option
    ("cli/scatter.rs", "bias"),               // of an estimator
    ("check/excitation.rs", "inertia"),       // in a sentence
];

/// Ids in string literals, alone or with a place (`inertia@surge`), outside the tests of a file.
fn ids_in<'i>(text: &str, ids: &'i [String]) -> Vec<&'i str> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let words =
        lines.flat_map(|line| line.split('"').skip(1).step_by(2)).map(|word| word.split('@').next().unwrap_or(word));
    words.filter_map(|word| ids.iter().find(|id| *id == word)).map(String::as_str).collect()
}

#[test]
fn no_other_room_knows_an_effect_by_its_id() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let ids: Vec<String> = catalogue(Coriolis::Tied).iter().map(|e| e.about().id.to_string()).collect();
    let mut files = Vec::new();
    sources(&src, &mut files);
    let mut wrong = Vec::new();
    let mut met = Vec::new();
    for file in files {
        let inside = file.strip_prefix(&src).expect("it lies in src").to_string_lossy().replace('\\', "/");
        let names_effects = ["effects/", "tank/", "demo/"].iter().any(|room| inside.starts_with(room));
        if names_effects || inside.ends_with("tests.rs") {
            continue;
        }
        let text = fs::read_to_string(&file).expect("src can be read");
        for id in ids_in(&text, &ids) {
            match OTHER_WORDS.iter().find(|(place, word)| *place == inside && *word == id) {
                Some(other) => met.push(*other),
                None => wrong.push(format!("{inside}: {id}")),
            }
        }
    }
    assert!(wrong.is_empty(), "ids outside `effects`: {wrong:#?}");
    let gone: Vec<_> = OTHER_WORDS.iter().filter(|word| !met.contains(word)).collect();
    assert!(gone.is_empty(), "no longer written: {gone:?}");
}

#[test]
fn ids_are_found_where_they_are_written() {
    let ids = ["inertia".to_string(), "bias".to_string()];
    let text = "let a = [\"inertia\", \"the bias\"];\n// \"bias\"\nlet b = \"bias@surge\";\n#[cfg(test)]\n\"inertia\"";
    assert_eq!(ids_in(text, &ids), ["inertia", "bias"]);
}
