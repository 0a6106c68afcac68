//! Names from a user's file remain text in every exported file; they do not become code, elements
//! or formulas.

use std::path::Path;

use crate::exported::{PLANAR, file, made, noise, planar, text, thrusters};
use hydrosysid::campaign::ModelFile;
use hydrosysid::effects::Coriolis;
use hydrosysid::export::{ExportOptions, Target, export};
use hydrosysid::frame::Dof;
use roxmltree::Document;

/// A name that ends a comment in every target, reverses the direction of the following text, and
/// contains characters that XML does not allow. The Python tests use the same name.
const HOSTILE: &str = "boat\nsystem('echo code')\r%}\u{2028}\u{1}\u{0}\u{b}\"\"\"\\\n--> <x/> */ {longest} \u{202e}\u{2066}\u{ffff}\u{85},=cmd|' /C calc'!A0";

fn of_models() -> impl Iterator<Item = Target> {
    Target::ALL.into_iter().filter(|target| !target.takes_campaign())
}

fn hostile() -> ModelFile {
    let mut hostile = ModelFile { noise: Some(noise(&PLANAR)), ..planar(&[]) };
    hostile.vehicle.name = HOSTILE.into();
    hostile.hydrosysid = HOSTILE.into();
    hostile
}

/// Whether a line of the file begins with the text after a line end in the name.
fn leaks(text: &str) -> bool {
    text.split(['\n', '\r', '\u{2028}', '\u{85}']).any(|line| line.trim_start().starts_with("system("))
}

#[test]
fn a_line_end_in_a_name_writes_no_line_of_its_own() {
    let options = ExportOptions { link: Some(HOSTILE.into()), ..ExportOptions::default() };
    for target in of_models() {
        let export = made(&hostile(), target, &options);
        let text = String::from_utf8_lossy(&export.bytes);
        assert!(!leaks(&text), "{target:?}: {text}");
        assert!(!text.contains(['\u{202e}', '\u{2066}', '\u{2028}']), "{target:?}: marks that turn a line about");
    }
}

#[test]
fn a_header_of_c_is_its_comment_and_code() {
    let text = text(&made(&hostile(), Target::CHeader, &ExportOptions::default()));
    let (comment, code) = text.split_once("*/").expect("the comment ends");
    assert!(comment.starts_with("/*\n") && !comment[2..].contains("/*"), "{comment}");
    assert!(code.trim_start().starts_with("#ifndef HYDROSYSID_VEHICLE_H"), "{code}");
    assert!(!text.contains(|c: char| c.is_control() && c != '\n'));
}

#[test]
fn json_and_toml_hold_the_name_as_text() {
    let json = text(&made(&hostile(), Target::Kalman, &ExportOptions::default()));
    let json: serde_json::Value = serde_json::from_str(&json).expect("it is JSON");
    let toml = text(&made(&hostile(), Target::KalmanToml, &ExportOptions::default()));
    let toml: toml::Table = toml.parse().expect("it is TOML");
    let first = json["comment"][0].as_str().expect("a comment");
    assert!(first.starts_with("boat system('echo code')"), "{first}");
    assert_eq!(toml["comment"][0].as_str(), Some(first));
}

#[test]
fn a_matlab_file_is_its_function_and_comments() {
    let text = text(&made(&hostile(), Target::FossenMatlab, &ExportOptions::default()));
    let head: Vec<&str> = text.lines().skip(1).take_while(|line| !line.starts_with("vehicle.")).collect();
    assert!(head.len() > 5 && head.iter().all(|line| line.starts_with("% ")), "{head:?}");
}

#[test]
fn a_python_file_has_one_docstring_and_no_control_character() {
    let python =
        [Target::FossenPython, Target::LinearPython, Target::KalmanPython, Target::VehicleSimulator, Target::Mujoco];
    for target in python {
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
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("escaping");
    let path = thrusters(&folder, "T1\\nsystem('echo code')\\u0001-->,=cmd", "");
    for target in [Target::GazeboThrusters, Target::Ardusub] {
        let export = export(&path, target, &ExportOptions::default()).expect("it can be exported");
        let text = String::from_utf8(export.bytes).expect("it is text");
        assert!(!leaks(&text), "{target:?}: {text}");
        if target == Target::GazeboThrusters {
            Document::parse(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
        }
    }
}
