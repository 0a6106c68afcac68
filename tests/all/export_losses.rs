//! Losses of thrust of a model: exported in matrices, functions and curves, or refused.

use std::collections::BTreeMap;
use std::path::Path;

use crate::exported::*;
use hydrosysid::campaign::ModelFile;
use hydrosysid::export::{ExportOptions, Target, export, export_model};
use hydrosysid::thrust::efficiency::Efficiency;

/// A planar model with the `[efficiency]` of `text`.
fn with_losses(text: &str) -> ModelFile {
    let efficiency: Efficiency = toml::from_str(text).expect("it is an [efficiency]");
    ModelFile { efficiency, ..planar(&COUPLED) }
}

const BOTH: &str =
    "eta_inter = { surge = 0.9, yaw = 0.8 }\neta_adv = { slope = -0.2, intercept = 0.98, valid = [0, 1] }";

fn linear(file: &ModelFile, at: &[(&str, f64)]) -> serde_json::Value {
    let at: BTreeMap<String, f64> = at.iter().map(|(k, v)| ((*k).to_string(), *v)).collect();
    let export = made(file, Target::LinearJson, &ExportOptions { at, ..ExportOptions::default() });
    serde_json::from_slice(&export.bytes).expect("it is JSON")
}

#[test]
fn the_linear_model_takes_commands() {
    let (bare, lossy) = (planar(&COUPLED), with_losses(BOTH));
    let (without, with) = (linear(&bare, &[("u", 0.5)]), linear(&lossy, &[("u", 0.5)]));
    let cell = |of: &serde_json::Value, m: &str, i: usize, j: usize| of[m][i][j].as_f64().expect("a number");
    // 0.9 (0.98 − 0.2·0.5) in surge; yaw by the speed ahead; sway at rest
    for (k, eta) in [(0, 0.9 * 0.88), (1, 0.98), (2, 0.8 * 0.88)] {
        for i in 0..3 {
            let expected = eta * cell(&without, "B", i, k);
            assert!((cell(&with, "B", i, k) - expected).abs() < 1e-12 * (1.0 + expected.abs()), "B[{i}][{k}]");
        }
    }
    let tau0 = with["tau0"][0].as_f64().expect("a number");
    let acting = without["tau0"][0].as_f64().expect("a number");
    assert!((0.9 * 0.88 * tau0 - acting).abs() < 1e-9, "the command that holds the point");
    // thrust decreases with speed: −0.9·0.2 τ₀ on the diagonal of surge
    let slope = cell(&with, "A", 0, 0) - cell(&without, "A", 0, 0);
    assert!((slope + 0.18 * tau0 * cell(&without, "B", 0, 0)).abs() < 1e-12, "{slope}");
    let given = linear(&lossy, &[("u", 0.5), ("tau_u", tau0)]);
    assert!(given["rate0"][0].as_f64().expect("a number").abs() < 1e-9, "a given force is a command too");
}

#[test]
fn functions_carry_the_losses_and_files_of_coefficients_refuse_them() {
    let file = with_losses(BOTH);
    let python = text(&made(&file, Target::FossenPython, &ExportOptions::default()));
    assert!(
        python.contains("ETA_INTER = np.array([0.9, 1, 1, 1, 1, 0.8])") && python.contains("ETA_ADV = (-0.2, 0.98)")
    );
    assert!(python.contains("Forces here are nominal") && python.contains("Nothing of the model is lost"));
    // the effect of these numbers is tested in export_c_header.rs, and for Python in test_consumers.py
    for (target, inter, adv) in [
        (Target::FossenMatlab, "eta_inter = [0.9; 1; 1; 1; 1; 0.8];", "eta_adv = [-0.2; 0.98];"),
        (Target::CHeader, "eta_inter[6] = {0.9, 1, 1, 1, 1, 0.8};", "eta_adv[2] = {-0.2, 0.98};"),
        (Target::VehicleSimulator, "ETA_INTER = np.array([0.9, 1, 1, 1, 1, 0.8])", "ETA_ADV = (-0.2, 0.98)"),
        (Target::Mujoco, "ETA_INTER = np.array([0.9, 1, 1, 1, 1, 0.8])", "ETA_ADV = (-0.2, 0.98)"),
    ] {
        let text = text(&made(&file, target, &ExportOptions::default()));
        assert!(text.contains(inter) && text.contains(adv), "{target:?}");
        assert!(text.contains("Forces here are nominal"), "{target:?}");
    }
    for target in [Target::Gazebo, Target::GazeboAddedMass, Target::Uuv, Target::Urdf] {
        let refused = export_model(&file, Path::new(PATH), target, &ExportOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("eta_inter of surge 0.9") && refused.contains("--acting"), "{refused}");
        let acting = ExportOptions { acting: true, inertia: Some([40.0, 45.0, 50.0]), ..ExportOptions::default() };
        assert!(text(&made(&file, target, &acting)).contains("Forces here are effective ones"), "{target:?}");
    }
    let table = text(&made(&file, Target::Csv, &ExportOptions::default()));
    assert!(table.contains("The values refer to effective forces, after losses of thrust: eta_inter of surge 0.9"));
}

#[test]
fn a_thruster_carries_what_is_one_factor_of_its_thrust() {
    let folder = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let path = folder.join("losses.toml");
    let campaign = |efficiency: &str| {
        let text = format!(
            "format = 1\n[vehicle]\nname = \"v\"\n[model]\ndofs = [\"surge\", \"yaw\"]\neffects = [\"inertia\"]\n\
             [[thruster]]\nname = \"port\"\nposition = [0, -0.2, 0]\naxis = [1, 0, 0]\nmax = 1\n\
             forward = {{ a = 40, b = 0 }}\nreverse = {{ a = 30, b = 0 }}\n[efficiency]\n{efficiency}\n[[run]]\nfile = \"a.csv\"\n"
        );
        std::fs::write(&path, text).expect("it can be written");
    };
    let options = ExportOptions::default();
    campaign("eta_inter = { surge = 0.9, yaw = 0.9 }");
    let made = export(&path, Target::GazeboThrusters, &options).expect("one factor");
    let carried = text(&made);
    assert!(carried.contains("<max_thrust_cmd>36</max_thrust_cmd>") && carried.contains("forward a 36"), "{carried}");
    assert!(carried.contains("Losses of thrust are in the curves"));
    campaign("eta_inter = { surge = 0.9, yaw = 0.8 }");
    let refused = export(&path, Target::GazeboThrusters, &options).unwrap_err().to_string();
    assert!(refused.contains("differs between") && refused.contains("--acting"), "{refused}");
    let acting = ExportOptions { acting: true, ..ExportOptions::default() };
    let bare = text(&export(&path, Target::GazeboThrusters, &acting).expect("curves of bollard pull"));
    assert!(bare.contains("<max_thrust_cmd>40</max_thrust_cmd>") && bare.contains("Curves of bollard pull"));
    campaign("eta_adv = { slope = -0.2, intercept = 1.0, valid = [0, 1] }");
    assert!(export(&path, Target::GazeboThrusters, &options).is_err(), "a loss by advance is no factor");
}

/// A vectored vehicle whose thrusters lie 5 cm below the origin, and one that pushes down.
fn vectored(efficiency: &str) -> String {
    let thruster = |name: &str, place: &str, axis: &str| {
        format!(
            "[[thruster]]\nname = \"{name}\"\nposition = {place}\naxis = {axis}\nmax = 1\nneutral = 1500\nspan = 400\n\
             forward = {{ a = 40, b = 0 }}\nreverse = {{ a = 40, b = 0 }}\n"
        )
    };
    let thrusters: String = [
        thruster("port", "[0.2, -0.2, 0.05]", "[1, 1, 0]"),
        thruster("starboard", "[0.2, 0.2, 0.05]", "[1, -1, 0]"),
        thruster("down", "[0.1, 0.1, 0]", "[0, 0, 1]"),
    ]
    .concat();
    format!(
        "format = 1\n[vehicle]\nname = \"v\"\n[model]\ndofs = [\"surge\", \"sway\", \"yaw\"]\neffects = [\"inertia\"]\n\
         {thrusters}[efficiency]\n{efficiency}\n[[run]]\nfile = \"a.csv\"\n"
    )
}

#[test]
fn a_small_lever_about_an_axis_that_the_model_has_not_is_no_other_loss() {
    let path = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("vectored_losses.toml");
    let made = |efficiency: &str, target: Target| {
        std::fs::write(&path, vectored(efficiency)).expect("it can be written");
        export(&path, target, &ExportOptions::default())
    };
    let one = "eta_inter = { surge = 0.9, sway = 0.9, yaw = 0.9 }";
    let told = text(&made(one, Target::GazeboThrusters).expect("roll and pitch are not in the model"));
    assert!(told.contains("factor of each thruster 0.9, 0.9, 1"), "{told}");
    assert!(text(&made(one, Target::Ardusub).expect("one factor")).contains("factor of each thruster 0.9, 0.9, 1"));
    // for a thruster that acts in no degree of freedom of the model, its own η_inter counts
    let heave = "eta_inter = { surge = 0.9, sway = 0.9, yaw = 0.9, heave = 0.8 }";
    let told = text(&made(heave, Target::GazeboThrusters).expect("one factor of each"));
    assert!(told.contains("factor of each thruster 0.9, 0.9, 0.8"), "{told}");
    let refused = made("eta_inter = { surge = 0.9 }", Target::GazeboThrusters).unwrap_err().to_string();
    assert!(refused.contains("\"port\" pushes in (surge 0.9, sway 1, yaw 1)"), "{refused}");
}
