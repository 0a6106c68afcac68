//! The rows of the table: what is random, and what is hidden.

use hydrosysid_plant::{Campaign, Dof, Hidden, Input, Pilots, RandomForce, Suite, Vehicle, hide};

/// One row.
pub struct Cell {
    /// Section of the page.
    pub section: &'static str,
    /// What is in it.
    pub name: String,
    /// Names that are hidden.
    pub hidden: Vec<String>,
    /// Whether the catalogue has a name for it.
    pub named: bool,
    /// The campaign of a seed.
    pub campaign: Box<dyn Fn(u64) -> Campaign + Sync>,
}

/// A planar campaign of one of the two vehicles, by the seed.
fn planar(suite: &Suite, force: f64, correlation: f64, hidden: &[String], seed: u64) -> Campaign {
    let name = if seed.is_multiple_of(2) { "laurs" } else { "small" };
    let vehicle = Vehicle::named(name).unwrap_or_else(|| unreachable!("the plant has this vehicle"));
    let force = RandomForce { share: force / 100.0, correlation };
    let hidden = hidden.iter().map(|name| Hidden::new(name)).collect();
    let instruments = suite.instruments(&Dof::PLANE);
    Campaign { force, hidden, instruments, seed, ..Campaign::new(vehicle, &Dof::PLANE) }
}

fn cell(
    section: &'static str,
    name: impl Into<String>,
    hidden: &[&str],
    named: bool,
    campaign: impl Fn(&[String], u64) -> Campaign + Sync + 'static,
) -> Cell {
    let hidden: Vec<String> = hidden.iter().map(|h| (*h).to_string()).collect();
    let own = hidden.clone();
    Cell { section, name: name.into(), hidden, named, campaign: Box::new(move |seed| campaign(&own, seed)) }
}

/// Two at once, of different families.
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
    for pair in PAIRS {
        let made = |h: &[String], s| planar(&Suite::default(), 2.0, 1.0, h, s);
        all.push(cell("Two effects, force 2 %, 1 s", pair.join(" + "), &pair, true, made));
    }
    for name in hide::OUTSIDE {
        let name = if name == "power_drag" { "power_drag@surge" } else { name };
        let made = |h: &[String], s| planar(&Suite::default(), 2.0, 1.0, h, s);
        all.push(cell("Outside of the catalogue, force 2 %, 1 s", name, &[name], false, made));
    }
    all
}
