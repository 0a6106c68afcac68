//! If the fit of a model did not converge, every verb that reads the model says so, and so do the
//! files made from it.

use std::collections::BTreeMap;
use std::path::Path;

use hydrosysid::campaign::{self, ModelFile, PlanRequest, PlanSource};
use hydrosysid::export::{ExportOptions, Target, export_model};
use hydrosysid::finding::Finding;
use hydrosysid::frame::Dof;

use crate::exported::{PATH, planar};

fn unsettled() -> ModelFile {
    ModelFile { converged: false, ..planar(&[]) }
}

fn said_first(findings: &[Finding]) -> bool {
    findings.first().is_some_and(|f| f.code == "M130" && f.message.contains("did not converge"))
}

#[test]
fn the_model_file_keeps_it() {
    let path = Path::new(PATH);
    let text = unsettled().to_text(path).expect("a text");
    assert!(text.contains("converged = false"), "{text}");
    assert_eq!(ModelFile::from_text(&text, path).expect("its own text"), unsettled());
    // a file of an earlier version does not have the entry and counts as converged
    let settled = planar(&[]).to_text(path).expect("a text");
    assert!(!settled.contains("converged"), "{settled}");
    assert!(ModelFile::from_text(&settled, path).expect("its own text").converged);
}

#[test]
fn every_verb_says_it_before_all_else() {
    let (file, path) = (unsettled(), Path::new(PATH));
    let names = || ["a.toml".to_string(), "b.toml".to_string()];
    let difference = campaign::difference(&planar(&[]), &file, names());
    assert!(said_first(&difference.warnings) && difference.warnings[0].message.starts_with("b.toml"), "{difference:?}");
    let source = PlanSource::of_file(&file, path).expect("a source");
    let request =
        PlanRequest { limits: BTreeMap::from([(Dof::Surge, 100.0)]), length: 20.0, most: 1, ..PlanRequest::default() };
    let plan = campaign::plan(&source, &request, &|| {}).expect("a plan");
    assert!(said_first(&plan.warnings), "{:?}", plan.warnings);
}

#[test]
fn a_file_made_of_it_says_it_at_the_top() {
    for target in [Target::GazeboAddedMass, Target::CHeader, Target::Csv, Target::LinearJson] {
        let options = ExportOptions { inertia: Some([8.0, 12.0, 14.0]), ..ExportOptions::default() };
        let of = |file: &ModelFile| export_model(file, Path::new(PATH), target, &options).expect("it can be exported");
        let made = of(&unsettled());
        let text = String::from_utf8_lossy(&made.bytes).into_owned();
        assert!(said_first(&made.warnings), "{:?}", made.warnings);
        assert!(text.contains("DO NOT USE THESE NUMBERS"), "{text}");
        assert!(!String::from_utf8_lossy(&of(&planar(&[])).bytes).contains("DO NOT USE"));
    }
}
