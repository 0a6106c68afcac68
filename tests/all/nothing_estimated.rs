//! A fit is refused if its estimator can use none of the runs; another fit gives its warnings on
//! standard error only.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hydrosysid_plant as plant;

fn hydrosysid(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hydrosysid")).args(arguments).current_dir(folder).output().expect("it runs")
}

/// A campaign of free runs.
fn sailed() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("nothing_estimated");
    let vehicle = plant::Vehicle::named("small").expect("the plant has it");
    let sea = plant::Campaign { duration: 40.0, seed: 11, ..plant::Campaign::new(vehicle, &plant::Dof::PLANE) };
    sea.sail().expect("it sails").write(&folder).expect("it is written");
    let file = folder.join("campaign.toml");
    let text = std::fs::read_to_string(&file).expect("it was written");
    let text = ["oscillatory", "zigzag"].iter().fold(text, |text, kind| text.replace(&format!("{kind:?}"), "\"free\""));
    std::fs::write(&file, text).expect("it can be written");
    // left by an earlier run of this test
    let _ = std::fs::remove_file(folder.join("none.toml"));
    folder
}

#[test]
fn a_fit_that_estimates_nothing_is_refused_with_the_kinds_that_it_uses() {
    let folder = sailed();
    let refused = hydrosysid(&["fit", ".", "--estimator", "staged", "--model", "none.toml"], &folder);
    let told = String::from_utf8_lossy(&refused.stderr);
    assert_eq!((refused.status.code(), refused.stdout.as_slice()), (Some(1), &b""[..]), "{told}");
    assert!(told.contains("M015") && told.contains("kind free") && told.contains("towing"), "{told}");
    assert!(!told.contains("next:") && !folder.join("none.toml").exists(), "{told}");

    let fitted = hydrosysid(&["fit", ".", "--estimator", "integral"], &folder);
    let (table, told) = (String::from_utf8_lossy(&fitted.stdout), String::from_utf8_lossy(&fitted.stderr));
    assert!(fitted.status.success() && table.contains("next: hydrosysid"), "{told}");
    // warnings are on standard error only
    assert!(!table.contains("warning: "), "{table}");
}
