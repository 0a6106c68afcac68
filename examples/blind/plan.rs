//! The rows of the table: which effects are hidden, in which kind of campaign.

use hydrosysid::tank::{BlindOptions, CraftKind, Hidden};

/// Effects hidden one at a time in the horizontal plane.
pub const SINGLE: &[&str] = &[
    "coriolis_yaw",
    "coriolis_surge",
    "coriolis_sway",
    "linear_drag@yaw",
    "quadratic_drag@sway",
    "cubic_drag@surge",
    "drag_asymmetry@surge",
    "coulomb_friction@surge",
    "mixed_drag@yaw:surge",
    "cross_drag@yaw:sway",
    "linear_cross_damping@yaw:sway",
    "added_mass_coupling@sway:yaw",
    "added_mass_amplitude@surge",
    "fluid_memory@surge",
    "bias@surge",
    "restoring_surge",
    "thrust_lag",
    "thrust_delay",
    "thrust_deadband@surge",
    "thrust_saturation@surge",
    "thrust_advance_loss@surge",
    "thrust_reverse_loss@surge",
    "thrust_interaction_loss@yaw",
    "thruster_fault@surge",
    "supply_voltage",
    "thrust_crosstalk@yaw:surge",
    "current",
    "tether_spring",
    "tether_drag@surge",
    "wave@surge",
    "sensor_gyro_bias",
    "sensor_gyro_scale",
    "sensor_heading_offset",
    "sensor_compass_magnetic",
    "sensor_compass_deviation",
    "sensor_dvl_lever_arm",
    "sensor_dvl_misalignment",
    "sensor_dvl_scale",
];

/// Effects of heave, roll and pitch, hidden one at a time in six degrees of freedom.
pub const SPATIAL: &[&str] = &[
    "coriolis_heave",
    "coriolis_pitch",
    "linear_drag@heave",
    "quadratic_drag@heave",
    "linear_drag@roll",
    "quadratic_drag@pitch",
    "restoring_surge",
    "restoring_roll",
    "trim_offset",
    "thrust_reverse_loss@heave",
    "sensor_tilt_offset",
];

/// Two at once, of different families.
const PAIRS: &[[&str; 2]] = &[
    ["coriolis_yaw", "thrust_lag"],
    ["current", "drag_asymmetry@surge"],
    ["tether_spring", "thrust_reverse_loss@surge"],
    ["thrust_delay", "cross_drag@yaw:sway"],
    ["sensor_dvl_lever_arm", "bias@surge"],
    ["coulomb_friction@surge", "sensor_gyro_bias"],
    ["thruster_fault@surge", "linear_drag@yaw"],
    ["supply_voltage", "mixed_drag@yaw:surge"],
];

/// In no catalogue, with the neighbouring forms that are right names for them.
const OUTSIDE: &[(&str, &[&str])] = &[
    ("vortex_shedding", &[]),
    ("sloshing", &["fluid_memory@surge"]),
    ("power_drag@surge", &["cubic_drag@surge", "linear_drag@surge", "coulomb_friction@surge"]),
];

/// Effects of which the rows of other noise, rates and sizes are made: one or two of each family.
const SOME: &[&str] = &["coriolis_yaw", "cubic_drag@surge", "thrust_reverse_loss@surge", "current", "sensor_gyro_bias"];

/// One row of the table for one vehicle.
#[derive(Debug, Clone)]
pub struct Cell {
    /// Heading under which it stands.
    pub section: &'static str,
    /// Name of the row.
    pub row: String,
    /// What to make, but for the seed.
    pub options: BlindOptions,
    /// Names that count as right beside what is hidden.
    pub allowed: &'static [&'static str],
    /// Number of seeds.
    pub seeds: u64,
}

impl Cell {
    /// Name that no other cell has.
    pub fn id(&self) -> String {
        format!("{} / {} / {:?}", self.section, self.row, self.options.craft)
    }
}

/// Headings, in the order of the document.
pub const SECTIONS: [&str; 6] = [NOTHING, ONE, TWO, ABSENT, OTHER, SIX];
/// Nothing hidden.
pub const NOTHING: &str = "Nothing hidden";
/// One effect.
pub const ONE: &str = "One effect";
const TWO: &str = "Two effects";
/// Not in the catalogue.
pub const ABSENT: &str = "Not in the catalogue";
const OTHER: &str = "One effect under other conditions";
const SIX: &str = "One effect in six degrees of freedom";

/// All cells, `seeds` of the main rows; nulls have fifteen times as many.
pub fn cells(seeds: u64) -> Vec<Cell> {
    let mut all = Vec::new();
    for craft in [CraftKind::Large, CraftKind::Small] {
        let usual = BlindOptions { craft, ..BlindOptions::default() };
        let hiding =
            |names: &[&str], size: f64| -> Vec<Hidden> { names.iter().map(|n| Hidden::new(*n, size)).collect() };
        let mut add = |section, row: String, options, allowed, seeds| {
            all.push(Cell { section, row, options, allowed, seeds });
        };
        for (row, colour, disturbance, times) in
            [("white noise", 0.0, 0.0, 15), ("coloured noise, 0.8", 0.8, 0.0, 15), ("random force, 2 %", 0.0, 0.02, 2)]
        {
            let options = BlindOptions { colour, disturbance, ..usual.clone() };
            add(NOTHING, row.to_string(), options, &[][..], times * seeds / 2);
        }
        for name in SINGLE {
            add(ONE, (*name).to_string(), BlindOptions { hidden: hiding(&[name], 1.0), ..usual.clone() }, &[], seeds);
        }
        for pair in PAIRS {
            add(TWO, pair.join(" + "), BlindOptions { hidden: hiding(pair, 1.0), ..usual.clone() }, &[], seeds);
        }
        for (name, allowed) in OUTSIDE {
            let options = BlindOptions { hidden: hiding(&[name], 1.0), ..usual.clone() };
            add(ABSENT, (*name).to_string(), options, allowed, seeds);
        }
        for (kind, change) in others() {
            for name in SOME {
                let mut options = BlindOptions { hidden: hiding(&[name], 1.0), ..usual.clone() };
                change(&mut options);
                add(OTHER, format!("{kind}: {name}"), options, &[], seeds.div_ceil(4));
            }
        }
        for name in SPATIAL {
            let options = BlindOptions { hidden: hiding(&[name], 1.0), six: true, ..usual.clone() };
            add(SIX, (*name).to_string(), options, &[], seeds.div_ceil(4));
        }
    }
    all
}

/// Changes of the usual campaign, with their names.
#[allow(clippy::type_complexity)] // a name and what it does
fn others() -> [(&'static str, fn(&mut BlindOptions)); 7] {
    [
        ("size 0.3", |o| o.hidden.iter_mut().for_each(|h| h.size = 0.3)),
        ("4 times the noise", |o| o.noise = 4.0),
        ("a fifth of the noise", |o| o.noise = 0.2),
        ("coloured noise, 0.8", |o| o.colour = 0.8),
        ("random force, 2 %", |o| o.disturbance = 0.02),
        ("3 Hz", |o| o.rate = 3.0),
        ("20 Hz", |o| o.rate = 20.0),
    ]
}
