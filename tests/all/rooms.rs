//! Layers of the modules: each module uses only modules of earlier layers, so that the code can be
//! read in order.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Modules in order of their layers. Those on one line are of the same layer and do not use each other.
const FLOORS: &[&[&str]] = &[
    &["units", "noise", "progress", "spreadsheet", "text_file", "atomic_file", "simd", "wording", "eigenvalues"],
    &["frame", "finding", "nearest", "least_squares"],
    &["symbolic", "vehicle"],
    &["thrust"],
    &["run"],
    &["formula"],
    &["effects"],
    &["log"],
    &["filter", "navigation"],
    &["check"],
    &["model"],
    &["chain"],
    &["dynamics"],
    &["simulate"],
    &["envelope"],
    &["estimate"],
    &["tank"],
    &["compare"],
    &["discover"],
    &["plan", "monitor"],
    &["procedure"],
    &["campaign"],
    &["report", "export"],
    &["report_content", "demo"],
    &["view"],
    &["cli"],
    &["main"],
];

fn floor(room: &str) -> usize {
    let found = FLOORS.iter().position(|floor| floor.contains(&room));
    found.unwrap_or_else(|| panic!("the room `{room}` has no floor yet: say in this list where it stands"))
}

/// Appends the Rust files of a folder and its subfolders to `list`.
pub fn sources(folder: &Path, list: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("src can be read") {
        let path = entry.expect("src can be read").path();
        if path.is_dir() {
            sources(&path, list);
        } else if path.extension().is_some_and(|e| e == "rs") {
            list.push(path);
        }
    }
}

/// Modules that a file uses as `crate::room` or, in groups, as `crate::{room, …}`, outside its tests.
fn rooms_read(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let code: String = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    let word = |s: &str| s.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        match rest.strip_prefix('{') {
            None => found.push(word(rest)),
            Some(group) => {
                let mut depth = 0;
                let mut start = true;
                for (k, c) in group.char_indices() {
                    if start && c.is_alphabetic() && depth == 0 {
                        found.push(word(&group[k..]));
                        start = false;
                    }
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' => start = true,
                        _ => {}
                    }
                }
            }
        }
    }
    found
}

#[test]
fn each_room_reads_only_rooms_above_it() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    let mut wrong: BTreeMap<String, String> = BTreeMap::new();
    for file in files {
        let inside = file.strip_prefix(&src).expect("it lies in src");
        let first = inside.components().next().expect("a file has a name");
        let room = first.as_os_str().to_string_lossy().trim_end_matches(".rs").to_string();
        if room == "lib" {
            continue;
        }
        let own = floor(&room);
        let text = fs::read_to_string(&file).expect("src can be read");
        for read in rooms_read(&text) {
            if read != room && floor(&read) >= own {
                wrong.insert(inside.display().to_string(), read);
            }
        }
    }
    assert!(wrong.is_empty(), "these files read a room that does not stand above them: {wrong:#?}");
}

#[test]
fn imports_are_found_alone_and_in_groups() {
    let text = "use crate::frame::Dof;\nuse crate::{run::{Run, Signal}, units};\nlet x = crate::model::name();\n";
    assert_eq!(rooms_read(text), ["frame", "run", "units", "model"]);
}
