//! Names that come from outside stay text in every exported file: no code, no element, no formula is made of them.

use std::path::Path;

use crate::exported::{file, made, planar, text};
use hydrosysid::campaign::ModelFile;
use hydrosysid::effects::Coriolis;
use hydrosysid::export::{ExportOptions, Target, export};
use hydrosysid::frame::Dof;
use roxmltree::Document;

/// Ends a comment of every target, and holds what XML has no place for.
const HOSTILE: &str =
    "boat\nsystem('echo code')\r%}\u{2028}\u{1}\u{0}\u{b}\"\"\"\n--> <x/> \u{ffff}\u{85},=cmd|' /C calc'!A0";

const OF_MODELS: [Target; 11] = [
    Target::Gazebo,
    Target::GazeboAddedMass,
    Target::Uuv,
    Target::Urdf,
    Target::FossenPython,
    Target::FossenMatlab,
    Target::LinearJson,
    Target::LinearPython,
    Target::LinearMat,
    Target::Latex,
    Target::Csv,
];

fn hostile() -> ModelFile {
    let mut hostile = planar(&[]);
    hostile.vehicle.name = HOSTILE.into();
    hostile.hydrosysid = HOSTILE.into();
    hostile
}

/// Whether a line of the file begins with what stands behind a line end of the name.
fn leaks(text: &str) -> bool {
    text.split(['\n', '\r', '\u{2028}', '\u{85}']).any(|line| line.trim_start().starts_with("system("))
}

#[test]
fn a_line_end_in_a_name_writes_no_line_of_its_own() {
    let options = ExportOptions { link: Some(HOSTILE.into()), ..ExportOptions::default() };
    for target in OF_MODELS {
        let export = made(&hostile(), target, &options);
        let text = String::from_utf8_lossy(&export.bytes);
        assert!(!leaks(&text), "{target:?}: {text}");
    }
}

#[test]
fn a_matlab_file_is_its_function_and_comments() {
    let text = text(&made(&hostile(), Target::FossenMatlab, &ExportOptions::default()));
    let head: Vec<&str> = text.lines().skip(1).take_while(|line| !line.starts_with("vehicle.")).collect();
    assert!(head.len() > 5 && head.iter().all(|line| line.starts_with("% ")), "{head:?}");
}

#[test]
fn a_python_file_has_one_docstring_and_no_control_character() {
    for target in [Target::FossenPython, Target::LinearPython] {
        let text = text(&made(&hostile(), target, &ExportOptions::default()));
        let head = text.strip_prefix("\"\"\"").expect("it begins with its docstring").split_once("\"\"\"").unwrap();
        let code = head.1.trim_start();
        assert!(code.starts_with("import") || code.starts_with("STATES"), "{target:?}: {code}");
        assert!(!text.contains(|c: char| c.is_control() && c != '\n'), "{target:?}");
    }
}

#[test]
fn xml_stays_well_formed_whatever_the_name() {
    let options = ExportOptions { link: Some(HOSTILE.into()), ..ExportOptions::default() };
    for target in [Target::Gazebo, Target::GazeboAddedMass, Target::Uuv, Target::Urdf] {
        let text = text(&made(&hostile(), target, &options));
        assert!(!text.contains(|c: char| c.is_control() && c != '\n'), "{target:?}");
        let document = Document::parse(&text).unwrap_or_else(|e| panic!("{target:?}: {e}"));
        assert!(document.descendants().all(|node| !node.has_tag_name("x")), "{target:?}");
    }
}

#[test]
fn no_cell_of_a_csv_is_a_formula() {
    let mut model = file(&[Dof::Surge], &[("inertia@surge", -250.0), ("linear_drag@surge", 20.0)], Coriolis::Tied);
    model.vehicle.name = HOSTILE.into();
    let text = text(&made(&model, Target::Csv, &ExportOptions::default()));
    let formula = |cell: &str| cell.starts_with(['=', '@', '+', '-']) && cell.parse::<f64>().is_err();
    let cells = text.lines().flat_map(|line| line.split([',', ';']));
    assert_eq!(cells.filter(|cell| formula(cell)).collect::<Vec<_>>(), Vec::<&str>::new(), "{text}");
    assert!(text.lines().any(|line| line.contains(",-250,")), "a number below 0 stays one: {text}");
}

#[test]
fn thrusters_keep_their_names_in_their_place() {
    let folder = std::env::temp_dir().join(format!("hydrosysid-escaping-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("the temporary folder can be made");
    let path = folder.join("campaign.toml");
    let name = "T1\\nsystem('echo code')\\u0001-->,=cmd";
    let thruster = "position = [0.0, 0.0, 0.0]\naxis = [1.0, 0.0, 0.0]\nforward = { a = 1.0, b = 0.0 }\nreverse = { a = 0.8, b = 0.0 }\nneutral = 1500.0\nspan = 400.0\nmax = 1.0\n";
    let text = format!(
        "format = 1\n[vehicle]\nname = \"{name}\"\n[model]\ndofs = ['surge']\neffects = ['inertia']\n[[thruster]]\nname = \"{name}\"\n{thruster}[[run]]\nfile = 'a.csv'\n"
    );
    std::fs::write(&path, text).expect("the temporary folder can be written");
    for target in [Target::GazeboThrusters, Target::Ardusub] {
        let export = export(Path::new(&path), target, &ExportOptions::default()).expect("it can be exported");
        let text = String::from_utf8(export.bytes).expect("it is text");
        assert!(!leaks(&text), "{target:?}: {text}");
        if target == Target::GazeboThrusters {
            Document::parse(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
        }
    }
    std::fs::remove_dir_all(&folder).expect("the temporary folder can be removed");
}
