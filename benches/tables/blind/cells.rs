//! The rows of the table: random force, instruments, commands and hidden effects of each.

use super::drawn::{Drawn, drawn};
use hydrosysid_plant::{Campaign, Commands, Dof, Hidden, Input, Pilots, RandomForce, Suite, Vehicle, hide};

/// One row.
pub struct Cell {
    /// Section of the page.
    pub section: &'static str,
    /// Name of the row.
    pub name: String,
    /// Whether the hidden effects are in the catalogue.
    pub named: bool,
    /// The campaign of a seed.
    pub campaign: Box<dyn Fn(u64) -> Campaign + Sync>,
}

/// A planar campaign of one of the two vehicles, chosen by the seed.
fn planar(suite: &Suite, force: f64, correlation: f64, hidden: &[String], seed: u64) -> Campaign {
    let name = if seed.is_multiple_of(2) { "laurs" } else { "small" };
    of_vehicle(name, suite, (force, correlation), hidden, seed)
}

/// A planar campaign of the vehicle `name` with commands of single thrusters.
fn driven(name: &str, hidden: &[String], seed: u64) -> Campaign {
    let planar = of_vehicle(name, &Suite::default(), (2.0, 1.0), hidden, seed);
    Campaign { commands: Commands::Thrusters, ..planar }
}

pub(super) fn of_vehicle(name: &str, suite: &Suite, noise: (f64, f64), hidden: &[String], seed: u64) -> Campaign {
    moving(name, &Dof::PLANE, suite, noise, hidden, seed)
}

/// A campaign in these degrees of freedom.
fn moving(
    name: &str,
    dofs: &[Dof],
    suite: &Suite,
    (force, correlation): (f64, f64),
    hidden: &[String],
    seed: u64,
) -> Campaign {
    let vehicle = Vehicle::named(name).unwrap_or_else(|| unreachable!("the plant has this vehicle"));
    let force = RandomForce { share: force / 100.0, correlation };
    let hidden = hidden.iter().map(|name| Hidden::new(name)).collect();
    let instruments = suite.instruments(dofs);
    Campaign { force, hidden, instruments, seed, ..Campaign::new(vehicle, dofs) }
}

fn cell(
    section: &'static str,
    name: impl Into<String>,
    hidden: &[&str],
    named: bool,
    campaign: impl Fn(&[String], u64) -> Campaign + Sync + 'static,
) -> Cell {
    let hidden: Vec<String> = hidden.iter().map(|h| (*h).to_string()).collect();
    Cell { section, name: name.into(), named, campaign: Box::new(move |seed| campaign(&hidden, seed)) }
}

/// Two effects at once, of different families.
const PAIRS: [[&str; 2]; 4] = [
    ["coriolis_yaw", "thrust_lag"],
    ["current", "drag_asymmetry@surge"],
    ["coulomb_friction@surge", "sensor_gyro_bias"],
    ["thrust_reverse_loss@surge", "cross_drag@yaw:sway"],
];

/// All rows.
pub fn cells() -> Vec<Cell> {
    let mut all = Vec::new();
    let null = "Nothing hidden";
    for force in [0.0, 2.0, 5.0, 10.0] {
        for correlation in [0.5, 3.0] {
            if force > 0.0 || correlation < 1.0 {
                let name = if force > 0.0 { format!("force {force} %, {correlation} s") } else { "no force".into() };
                let made = move |h: &[String], s| planar(&Suite::default(), force, correlation, h, s);
                all.push(cell(null, name, &[], true, made));
            }
        }
    }
    let coloured = Suite { colour: 0.8, ..Suite::default() };
    let made = move |h: &[String], s| planar(&coloured, 2.0, 1.0, h, s);
    all.push(cell(null, "sensor noise AR(1) 0.8, force 2 %, 1 s", &[], true, made));
    all.push(cell(null, "closed loop, force 2 %, 1 s", &[], true, |h, s| Campaign {
        pilots: Pilots::Closed,
        ..planar(&Suite::default(), 2.0, 1.0, h, s)
    }));
    all.push(cell(null, "linear commands, force 2 %, 1 s", &[], true, |h, s| Campaign {
        input: Input::Linear,
        ..planar(&Suite::default(), 2.0, 1.0, h, s)
    }));
    let single = "One effect, force 2 %, 1 s";
    for name in hide::catalogue(&Dof::PLANE, &[]) {
        let made = |h: &[String], s| planar(&Suite::default(), 2.0, 1.0, h, s);
        all.push(cell(single, name.clone(), &[&name], true, made));
    }
    let thrusters = "Commands of single thrusters, force 2 %, 1 s";
    for (vehicle, names) in [
        ("laurs", ["", "thruster_loss@T2", "thruster_loss@T6", "thruster_swap@T2:T5", "thruster_swap@T6:T8"]),
        ("small", ["", "thruster_loss@T1", "thruster_loss@T4", "thruster_swap@T2:T3", "thruster_swap@T1:T2"]),
    ] {
        for name in names.into_iter().chain(["thruster_advance_loss"]) {
            let hidden: &[&str] = if name.is_empty() { &[] } else { &[name] };
            let row = format!("{} on {vehicle}", if name.is_empty() { "nothing" } else { name });
            all.push(cell(thrusters, row, hidden, true, move |h, s| driven(vehicle, h, s)));
        }
    }
    for pair in PAIRS {
        let made = |h: &[String], s| planar(&Suite::default(), 2.0, 1.0, h, s);
        all.push(cell("Two effects, force 2 %, 1 s", pair.join(" + "), &pair, true, made));
    }
    for name in std::iter::once(String::new()).chain(hide::catalogue(&Dof::ALL, &[])) {
        let hidden: &[&str] = if name.is_empty() { &[] } else { &[&name] };
        let row = if name.is_empty() { "nothing" } else { &name };
        let made = |h: &[String], s| moving("heavy", &Dof::ALL, &Suite::default(), (2.0, 1.0), h, s);
        all.push(cell("Six degrees of freedom, force 2 %, 1 s", row, hidden, true, made));
    }
    for name in hide::OUTSIDE {
        let outside = "Outside of the catalogue, force 2 %, 1 s";
        let name = if name == "power_drag" { "power_drag@surge" } else { name };
        match name {
            "thruster_failure" => {
                all.push(cell(outside, name, &["thruster_failure@T2"], false, |h, s| driven("laurs", h, s)));
            }
            _ => {
                let made = |h: &[String], s| planar(&Suite::default(), 2.0, 1.0, h, s);
                all.push(cell(outside, name, &[name], false, made));
            }
        }
    }
    let by_chance = "Everything drawn";
    for (name, what) in [
        ("nothing", Drawn::Nothing),
        ("one effect", Drawn::Effects(1)),
        ("two effects", Drawn::Effects(2)),
        ("two thrusters exchanged", Drawn::Exchange),
        ("a thruster without thrust", Drawn::Loss),
        ("outside of the catalogue", Drawn::Outside),
    ] {
        let named = !matches!(what, Drawn::Outside);
        all.push(cell(by_chance, name, &[], named, move |_, seed| drawn(what, seed)));
    }
    all
}
