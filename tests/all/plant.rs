//! Two codes that know nothing of each other: what the plant sails without noise, the fit gives back.
//!
//! The plant (`plant/`) is written from the textbook in vector form, this crate's equations come from its catalogue. A
//! wrong term in either would show here as wrong parameters.

use std::path::PathBuf;

use hydrosysid::campaign::{self, Campaign, FitOptions, LoadOptions};
use hydrosysid_plant::{Campaign as Sea, Commands, Dof, Hidden, Input, Suite, Vehicle};

/// Short segments and steps: the errors of the fit's integrator stay below 1e-5 of the motion, and the small vehicle,
/// which is unstable, is followed.
const FIT: &str = "[fit]\nestimator = \"output_error\"\nsegment = 2.0\nlongest_step = 0.02\n[log]\n";

/// A campaign of 30 s a run, without noise and without force.
fn sea(vehicle: &str, dofs: &[Dof]) -> Sea {
    let mut sea = Sea::new(Vehicle::named(vehicle).expect("it exists"), dofs);
    sea.duration = 30.0;
    sea.instruments = Suite { noise: 0.0, ..Suite::default() }.instruments(dofs);
    sea
}

/// Sails, fits with the effects `more` in the baseline beside it, and returns the largest relative error of a parameter
/// of the baseline and of `more`, with its name.
fn worst(name: &str, sea: &Sea, more: &[&str]) -> (f64, String) {
    let sailed = sea.sail().expect("it sails");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("plant_{name}"));
    sailed.write(&folder).expect("the folder can be written");
    let file = folder.join("campaign.toml");
    let mut text = std::fs::read_to_string(&file).expect("it was written").replace("[log]\n", FIT);
    for effect in more {
        text = text.replace("effects = [", &format!("effects = [\"{effect}\", "));
    }
    std::fs::write(&file, text).expect("it can be written");
    let campaign = Campaign::load(&file, LoadOptions::default()).expect("it is a campaign");
    let fit = campaign::fit(&campaign, FitOptions::default()).expect("it can be fitted");
    let mut worst = (0.0, String::new());
    let mut compared = 0;
    for parameter in &fit.model.parameters {
        let values: Vec<_> = sailed.truth.values.iter().filter(|v| v.effect == parameter.term).collect();
        let value =
            values.iter().find(|v| v.name == parameter.spec.name).or(values.first().filter(|_| values.len() == 1));
        let Some(value) = value else { panic!("{name}: the truth does not know {}", parameter.term) };
        compared += 1;
        let error = (parameter.value / value.value - 1.0).abs();
        if error > worst.0 {
            worst = (error, format!("{} {}: {} for {}", parameter.term, value.name, parameter.value, value.value));
        }
    }
    assert!(compared >= 9, "{name}: {compared} parameters");
    worst
}

/// Figures seen: 1e-6 to 1e-4; the tolerance is what the two must agree to.
const TOLERANCE: f64 = 1e-3;

#[test]
fn exact_planar_campaigns_come_back() {
    for (name, input) in [("laurs", Input::Hold), ("laurs", Input::Linear), ("small", Input::Hold)] {
        let mut sea = sea(name, &Dof::PLANE);
        sea.input = input;
        let (error, what) = worst(&format!("{name}_{input:?}"), &sea, &[]);
        assert!(error < TOLERANCE, "{name}, {input:?}: {what}");
    }
}

#[test]
fn exact_six_degrees_of_freedom_come_back() {
    let mut sea = sea("heavy", &Dof::ALL);
    let (error, what) = worst("heavy", &sea, &[]);
    assert!(error < TOLERANCE, "{what}");
    // through its eight thrusters
    (sea.commands, sea.seed) = (Commands::Thrusters, 2);
    let (error, what) = worst("heavy_thrusters", &sea, &[]);
    assert!(error < TOLERANCE, "{what}");
}

/// Effects of body, actuator, environment and sensor whose equations the two codes write apart. What depends on the time
/// before the log (lags, memories) begins at rest here.
#[test]
fn exact_effects_of_the_catalogue_come_back() {
    let names = [
        "added_mass_coupling@sway:yaw",
        "fluid_memory@surge",
        "cubic_drag@yaw",
        "mixed_drag@sway:yaw",
        "thrust_advance_loss@surge",
        "thrust_deadband@surge",
        "thrust_lag",
        "current",
        "tether_spring",
        "sensor_dvl_lever_arm",
    ];
    for name in names {
        let mut sea = sea("laurs", &Dof::PLANE);
        sea.lead_in = 0.0;
        sea.hidden = vec![Hidden::new(name)];
        let (error, what) = worst(&name.replace(['@', ':'], "_"), &sea, &[name]);
        assert!(error < TOLERANCE, "{name}: {what}");
    }
}
