//! Every hidden effect changes the log, is listed in the truth by its name, and is not in the baseline.

use hydrosysid_plant::hide::{OUTSIDE, catalogue};
use hydrosysid_plant::{Campaign, Commands, Dof, Hidden, PlantError, Sailed, Suite, Vehicle};

/// A short campaign without noise.
fn campaign(vehicle: &str, commands: Commands) -> Campaign {
    let dofs: &[Dof] = if vehicle == "heavy" { &Dof::ALL } else { &Dof::PLANE };
    let mut campaign = Campaign::new(Vehicle::named(vehicle).expect("it exists"), dofs);
    (campaign.duration, campaign.commands, campaign.spread) = (30.0, commands, 0.0);
    campaign.instruments = Suite { noise: 0.0, ..Suite::default() }.instruments(dofs);
    campaign
}

fn with(campaign: &Campaign, name: &str, size: f64) -> Result<Sailed, PlantError> {
    let hidden = vec![Hidden { name: name.to_string(), size }];
    Campaign { hidden, ..campaign.clone() }.sail()
}

/// Largest difference between two logs in a measured channel, in units of the ordinary noise.
fn gap(a: &Sailed, b: &Sailed) -> f64 {
    let noise = |name: &str| match name {
        "u" | "v" | "w" => 0.005,
        "p" | "q" | "r" => 0.003,
        "x" | "y" => 0.05,
        "z" => 0.02,
        _ => 0.009,
    };
    let mut most: f64 = 0.0;
    for (one, other) in a.logs.iter().zip(&b.logs) {
        for signal in one.signals.iter().filter(|s| !s.name.starts_with("tau_") && !s.name.starts_with('V')) {
            let second = other.signal(&signal.name).expect("both log it");
            // a difference of 0.01 s in the time stamps counts as much as the noise
            let late = signal.time.iter().zip(&second.time).map(|(s, t)| (s - t).abs() / 0.01);
            most = late.fold(most, f64::max);
            for (x, y) in signal.values.iter().zip(&second.values) {
                let angle = matches!(signal.name.as_str(), "phi" | "theta" | "psi");
                let off = if angle { hydrosysid_plant::attitude::wrapped(x - y) } else { x - y };
                most = most.max(off.abs() / noise(&signal.name));
            }
        }
    }
    most
}

#[test]
fn every_effect_of_the_catalogue_shows() {
    for vehicle in ["small", "laurs", "heavy"] {
        let base = campaign(vehicle, Commands::Thrusters);
        let complete = base.sail().expect("it sails");
        // thrusters that act in the horizontal plane
        let horizontal = base.vehicle.thrusters.iter().filter(|t| t.axis.z.abs() < 0.1);
        let thrusters: Vec<&str> = horizontal.map(|t| t.name).take(2).collect();
        // for the heavy vehicle, only effects that the planar vehicles cannot show, and thruster faults
        let spatial = |name: &String| {
            ["coriolis_heave", "coriolis_roll", "coriolis_pitch", "restoring", "trim", "sensor_tilt", "thruster_"]
                .iter()
                .any(|id| name.starts_with(id))
        };
        for name in catalogue(&base.dofs, &thrusters).into_iter().filter(|n| vehicle != "heavy" || spatial(n)) {
            let sailed = with(&base, &name, 1.0).unwrap_or_else(|e| panic!("{vehicle}: {e}"));
            assert!(!sailed.baseline.contains(&name) && sailed.truth.hidden == [name.as_str()]);
            let known = complete.baseline.contains(&name);
            if name.starts_with("thruster_swap") {
                assert!(gap(&complete, &sailed) > 3.0, "{vehicle}, {name}");
                continue;
            }
            let value = sailed.truth.value(&name);
            assert!(value.is_some_and(|v| v != 0.0), "{vehicle}, {name}: {value:?}");
            if known {
                // an effect of the vehicle itself leaves the baseline but not the plant
                assert_eq!(sailed.baseline.len() + 1, complete.baseline.len() - shared(&name));
                assert!(gap(&complete, &sailed) < 1e-6, "{vehicle}, {name}");
            } else {
                let gap = gap(&complete, &sailed);
                assert!(gap > 3.0, "{vehicle}, {name}: {gap} times the noise");
            }
        }
    }
}

/// Number of other terms, in six degrees of freedom, that share the parameter of this one and leave
/// the baseline with it.
fn shared(name: &str) -> usize {
    match name {
        "restoring_surge" | "restoring_sway" | "restoring_heave" => 2,
        "restoring_roll" | "restoring_pitch" => 1,
        _ => 0,
    }
}

#[test]
fn every_effect_outside_the_catalogue_shows() {
    for vehicle in ["small", "laurs"] {
        for commands in [Commands::Wrench, Commands::Thrusters] {
            let base = campaign(vehicle, commands);
            let complete = base.sail().expect("it sails");
            for id in OUTSIDE {
                let name = match id {
                    "power_drag" => "power_drag@yaw",
                    "thruster_failure" => "thruster_failure@T2",
                    _ => id,
                };
                if name.starts_with("thruster_") && commands == Commands::Wrench {
                    assert!(with(&base, name, 1.0).is_err());
                    continue;
                }
                let sailed = with(&base, name, 1.0).unwrap_or_else(|e| panic!("{vehicle}: {e}"));
                let gap = gap(&complete, &sailed);
                assert!(gap > 3.0, "{vehicle}, {commands:?}, {name}: {gap} times the noise");
                assert_eq!(sailed.baseline, complete.baseline);
            }
        }
    }
}

/// With a wrench as the command, an effect is clear at size 1 (above three times the noise),
/// smaller at 0.1, and absent at 0.
#[test]
fn size_goes_from_plain_to_nothing() {
    let base = campaign("small", Commands::Wrench);
    let complete = base.sail().expect("it sails");
    for name in ["cubic_drag@yaw", "thrust_lag", "thrust_interaction_loss@surge", "current", "wave@sway", "sloshing"] {
        let gaps = [1.0, 0.1, 0.0].map(|size| gap(&complete, &with(&base, name, size).expect("it sails")));
        assert!(gaps[0] > 3.0 && gaps[0] > gaps[1] && gaps[1] > gaps[2] && gaps[2] < 1e-3, "{name}: {gaps:?}");
    }
}

#[test]
fn a_row_that_is_switched_off_is_missing_in_the_plant_alone() {
    let base = campaign("small", Commands::Wrench);
    let complete = base.sail().expect("it sails");
    let without = Campaign { without: vec!["coriolis_yaw".to_string()], ..base }.sail().expect("it sails");
    assert_eq!(without.baseline, complete.baseline);
    assert!(gap(&complete, &without) > 3.0);
}

#[test]
fn what_cannot_be_hidden_is_refused() {
    let base = campaign("small", Commands::Wrench);
    for name in ["munk", "cubic_drag", "cubic_drag@sideways", "thruster_loss@T1", "coriolis_pitch"] {
        assert!(matches!(with(&base, name, 1.0), Err(PlantError::CannotHide { .. })), "{name}");
    }
}

/// The random force has the size that is asked for, as a share of the commanded force.
#[test]
fn law_force_is_a_share_of_the_command() {
    let mut base = campaign("laurs", Commands::Wrench);
    (base.force.share, base.force.correlation) = (0.05, 0.5);
    let sailed = base.sail().expect("it sails");
    for force in &sailed.truth.force {
        let column = force.dof.force();
        let (mut sum, mut count) = (0.0, 0.0);
        for signal in sailed.logs.iter().filter_map(|log| log.signal(column)) {
            sum += signal.values.iter().map(|f| f * f).sum::<f64>();
            count += signal.values.len() as f64;
        }
        // 5 %: the zig-zags of the rehearsal turn at other instants, which changes the size of the
        // command by a few per cent
        assert!((force.rms / (0.05 * (sum / count).sqrt()) - 1.0).abs() < 0.05, "{column}");
    }
    assert_eq!(sailed.truth.force.len(), 3);
}

/// The same seed gives the same campaign bit for bit, and another seed another campaign. Open-loop
/// commands do not depend on the random force.
#[test]
fn regress_seeds_repeat() {
    let base = campaign("small", Commands::Wrench);
    let (a, b) = (base.sail().expect("it sails"), base.sail().expect("it sails"));
    assert_eq!(a.logs, b.logs);
    let other = Campaign { seed: 2, spread: 0.1, ..base.clone() }.sail().expect("it sails");
    assert!(a.logs != other.logs && a.vehicle != other.vehicle);
    let mut pushed = base;
    pushed.force.share = 0.05;
    let pushed = pushed.sail().expect("it sails");
    assert_eq!(a.logs[0].signal("tau_u"), pushed.logs[0].signal("tau_u"));
    assert!(gap(&a, &pushed) > 3.0);
}
