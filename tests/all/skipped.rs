//! A test without its reference data reports that it was skipped, and fails if `CI` is `true`.

use std::process::{Command, Output};

use crate::shared;

/// Runs the test below in a separate process with this environment.
fn run(environment: &[(&str, &str)]) -> Output {
    let mut command = Command::new(std::env::current_exe().expect("this is a program"));
    // it is in the same module as the current test
    let here = std::thread::current().name().expect("a test has a name").to_string();
    let name = here.replace("absence_is_said_and_in_ci_a_failure", "reads_reference_data");
    command.args(["--exact", &name, "--ignored", "--test-threads=1"]);
    command.env_remove("CI").env("HYDROSYSID_SHARED", "/nowhere");
    command.envs(environment.iter().copied()).output().expect("it starts")
}

#[test]
#[ignore = "run by the test below"]
fn reads_reference_data() {
    let Some(_) = shared::path("badlogs") else { return };
}

#[test]
fn absence_is_said_and_in_ci_a_failure() {
    let output = run(&[]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && told.contains("reads_reference_data: skipped"), "{told}");
    assert!(!run(&[("CI", "true")]).status.success());
    let there = std::env::temp_dir().join(format!("hydrosysid-skipped-{}", std::process::id()));
    std::fs::create_dir_all(there.join("badlogs")).expect("the temporary folder can be made");
    let output = run(&[("CI", "true"), ("HYDROSYSID_SHARED", &there.display().to_string())]);
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    std::fs::remove_dir_all(&there).expect("the temporary folder can be removed");
}
