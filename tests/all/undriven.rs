//! Degrees of freedom that move without a command: the sway of a vessel with two thrusters, on the plant.
#![cfg(feature = "cli")]

use std::path::{Path, PathBuf};
use std::process::Command;

use hydrosysid::campaign::{self, Campaign, FitOptions, LoadOptions};
use hydrosysid::frame::Dof;
use hydrosysid_plant::{Campaign as Sea, Dof as Axis, Manoeuvre, RandomForce, Vehicle};

/// From logs of a vehicle that is driven in surge and yaw, without a column for the force in sway,
/// `init` makes a campaign that models sway as undriven; the estimates are within 3.5 standard
/// deviations.
#[test]
fn the_sway_of_a_vessel_with_two_thrusters_is_modelled() {
    let mut sea = Sea::new(Vehicle::named("small").expect("it exists"), &Axis::PLANE);
    (sea.runs, sea.duration, sea.seed) = (6, 60.0, 5502);
    sea.force = RandomForce { share: 0.02, correlation: 1.0 };
    let surge = Manoeuvre::Alone(Axis::Surge, 0.6, 0.3);
    let yaw = Manoeuvre::Alone(Axis::Yaw, 0.6, 0.0);
    sea.manoeuvres = vec![surge, yaw, Manoeuvre::Zigzag(0.6)];
    let sailed = sea.sail().expect("it sails");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("undriven");
    let _ = std::fs::remove_dir_all(&folder);
    sailed.write(&folder).expect("the folder can be written");
    let logs: Vec<PathBuf> = (0..6).map(|k| folder.join(format!("run0{k}.csv"))).collect();
    for log in &logs {
        let text = std::fs::read_to_string(log).expect("it was written");
        let at = text.split(',').position(|h| h.starts_with("tau_v")).expect("a column");
        let without = |line: &str| {
            let cells = line.split(',').enumerate().filter(|(k, _)| *k != at).map(|(_, cell)| cell);
            cells.collect::<Vec<_>>().join(",") + "\n"
        };
        assert!(text.lines().skip(1).all(|line| line.split(',').nth(at) == Some("0")), "nothing drives the sway");
        std::fs::write(log, text.lines().map(without).collect::<String>()).expect("it can be written");
    }
    let made = folder.join("made");
    let command = Path::new(env!("CARGO_BIN_EXE_hydrosysid"));
    let run = Command::new(command).arg("init").args(&logs).args(["--mass", "11", "-o"]).arg(&made).output();
    assert!(run.expect("the command runs").status.success());
    let campaign = Campaign::load(&made.join("campaign.toml"), LoadOptions::default()).expect("it is a campaign");
    assert_eq!(campaign.file.model.undriven, [Dof::Sway]);
    let fit = campaign::fit(&campaign, FitOptions::default()).expect("it can be fitted");
    assert!(fit.converged && fit.model.parameters.len() == 9, "{}", fit.sentence);
    // by chance one of nine estimates is beyond 3.5 standard deviations in 1 of 240 cases
    for p in &fit.model.parameters {
        let truth = sailed.truth.value(&p.term).expect("the truth knows it");
        let off = (p.value - truth).abs() / p.std.expect("it is estimated");
        assert!(off < 3.5, "{}: {} for {truth}, {off:.1} deviations", p.full_name(), p.value);
    }
}
