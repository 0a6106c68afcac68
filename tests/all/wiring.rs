//! Faults of the wiring, the units and the depth in a whole campaign of the independent plant: a vehicle with eight thrusters
//! in six degrees of freedom, each of which is moved in a run of its own.

use std::path::PathBuf;

use hydrosysid::campaign::{Check, LoadOptions, check_campaign};
use hydrosysid::check::Light;
use hydrosysid_plant::{Campaign as Sea, Commands, Dof, RandomForce, Suite, Vehicle};

use crate::changed_logs::change_logs;

/// The checks of the campaign with its logs changed: `change` maps the name of a column and a value to the value that is
/// logged instead.
fn checked(name: &str, change: impl Fn(&str, f64) -> f64) -> Check {
    let vehicle = Vehicle::named("heavy").expect("the plant has this vehicle");
    let instruments = Suite::default().instruments(&Dof::ALL);
    let force = RandomForce { share: 0.02, correlation: 1.0 };
    let commands = Commands::Thrusters;
    let sea = Sea { force, instruments, seed: 6101, duration: 40.0, commands, ..Sea::new(vehicle, &Dof::ALL) };
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
    check_campaign(&folder.join("campaign.toml"), LoadOptions::default()).expect("a campaign")
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
