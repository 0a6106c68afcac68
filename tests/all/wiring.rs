//! Faults of the wiring, the units and the depth in a whole campaign of the independent plant: a vehicle with eight thrusters
//! in six degrees of freedom, each of which is moved in a run of its own.

use std::path::PathBuf;

use hydrosysid::campaign::{self, Campaign, Check, FitOptions, LoadOptions, check_campaign};
use hydrosysid::check::Light;
use hydrosysid::discover::Verdict;
use hydrosysid_plant::{Campaign as Sea, Commands, Dof, RandomForce, Suite, Vehicle};

use crate::changed_logs::change_logs;
use crate::discovery::{names, sea};

/// The checks of the campaign with its logs changed: `change` maps the name of a column and a value to the value that is
/// logged instead.
fn checked(name: &str, change: impl Fn(&str, f64) -> f64) -> Check {
    let folder = heavy(name, change);
    check_campaign(&folder.join("campaign.toml"), LoadOptions::default()).expect("a campaign")
}

/// The folder with the campaign.
fn heavy(name: &str, change: impl Fn(&str, f64) -> f64) -> PathBuf {
    let vehicle = Vehicle::named("heavy").expect("the plant has this vehicle");
    let instruments = Suite::default().instruments(&Dof::ALL);
    let force = RandomForce { share: 0.02, correlation: 1.0 };
    let commands = Commands::Thrusters;
    let sea = Sea { force, instruments, seed: 6101, duration: 40.0, commands, ..Sea::new(vehicle, &Dof::ALL) };
    written(name, &sea, change)
}

/// The folder with the logs of a campaign, changed.
fn written(name: &str, sea: &Sea, change: impl Fn(&str, f64) -> f64) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("wiring_{name}"));
    sea.sail().expect("the plant sails").write(&folder).expect("the folder is written");
    change_logs(&folder, |text| {
        let (header, rows) = text.split_once('\n').expect("it has rows");
        let columns: Vec<&str> = header.split(',').map(|column| column.split(' ').next().unwrap_or(column)).collect();
        let cell = |(cell, column): (&str, &&str)| match cell.parse::<f64>() {
            Ok(value) => change(column, value).to_string(),
            Err(_) => cell.to_string(),
        };
        let row = |row: &str| row.split(',').zip(&columns).map(cell).collect::<Vec<_>>().join(",");
        std::iter::once(header.to_string()).chain(rows.lines().map(row)).collect::<Vec<_>>().join("\n") + "\n"
    });
    folder
}

fn told(check: &Check, code: &str) -> Vec<String> {
    check.warnings.iter().filter(|f| f.code == code).map(|f| f.message.clone()).collect()
}

/// Every run leaves most degrees of freedom at rest, and that is no fault: the others move them.
#[test]
fn a_campaign_with_one_run_for_each_degree_of_freedom_is_green() {
    let found = checked("clean", |_, value| value);
    assert_eq!((found.verdict, found.warnings.len()), (Light::Green, 0), "{:?}", found.warnings);
}

/// No single run tells a reversed vertical thruster from the three that push with it; all runs together do.
#[test]
fn a_reversed_thruster_is_found_in_all_runs_together() {
    for column in ["V5", "V7"] {
        let found = checked(column, |name, value| if name == column { -value } else { value });
        let sign = told(&found, "K121");
        assert!(
            sign.len() == 1 && sign[0].starts_with(&format!("with {column} reversed the thrusters explain")),
            "{sign:?}"
        );
        assert_eq!(found.verdict, Light::Red);
        assert!(found.warnings.iter().any(|f| f.code == "K121" && f.column.as_deref() == Some(column)));
    }
}

/// The search works on the turned force of a reversed thruster, and finds what is missing besides; a fit of the log as it is
/// must not be used. The thruster pushes weaker astern, so that its turned command is another force than its turned axis.
#[test]
fn blind_what_is_missing_beside_a_reversed_thruster_is_named() {
    let sea = Sea { commands: Commands::Thrusters, ..sea("small", 0.02, &["coriolis_yaw"], 8613) };
    let folder = written("munk", &sea, |name, value| if name == "V3" { -value } else { value });
    let loaded = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("a campaign");
    let fit = campaign::fit(&loaded, FitOptions::default()).expect("it is fitted");
    assert!(fit.sentence.starts_with("Do not use these numbers: the wiring is wrong"), "{}", fit.sentence);
    let found = campaign::discover(&loaded).expect("a fit");
    assert_eq!((names(&found), found.verdict), (vec!["coriolis_yaw"], Verdict::Explained), "{}", found.sentence);
    assert!(found.sentence.starts_with("The wiring is wrong: thruster 3 is reversed (V3)"), "{}", found.sentence);
    assert!(found.sentence.contains("set sign = -1 in columns.V3"), "{}", found.sentence);
    assert_eq!(found.log_findings.len(), 1, "{:?}", found.log_findings);
}

#[test]
fn a_height_for_a_depth_and_a_depth_in_centimetres_are_found() {
    let height = told(&checked("height", |name, value| if name == "z" { -value } else { value }), "K112");
    assert!(!height.is_empty() && height.iter().all(|text| text.contains("columns.z.sign = -1")), "{height:?}");
    let centimetres =
        told(&checked("centimetres", |name, value| if name == "z" { 100.0 * value } else { value }), "K111");
    assert!(
        !centimetres.is_empty() && centimetres.iter().all(|text| text.contains("columns.z.unit = \"cm\"")),
        "{centimetres:?}"
    );
}

#[test]
fn commands_in_per_cent_are_found() {
    let unit =
        told(&checked("per_cent", |name, value| if name.starts_with('V') { 100.0 * value } else { value }), "K124");
    assert!(!unit.is_empty() && unit.iter().all(|text| text.contains("per cent")), "{unit:?}");
}
