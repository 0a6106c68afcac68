//! Puts effects into the truth that the baseline lacks.
//!
//! An effect of the catalogue is a number of the plant or of an instrument (`slots`) or one of the few below;
//! hiding one that the vehicle has anyway (its drag, a row of C(ν)ν, its weight less buoyancy) takes it out of the
//! baseline alone. Effects outside the catalogue are listed in [`OUTSIDE`].

use std::f64::consts::TAU;

use nalgebra::Vector3;

use crate::campaign::{Campaign, Commands, Hidden, PlantError};
use crate::commands::Wiring;
use crate::dof::Dof;
use crate::instrument::Instrument;
use crate::naming::{Name, Place};
use crate::outside::Outside;
use crate::plant::Plant;
use crate::random::Random;
use crate::sail::PAUSE;
use crate::slots::{sensible, slots};
use crate::truth::baseline;
use crate::vehicle::Vehicle;
use crate::water::{Current, Sea, Wave};

/// What can be hidden that no catalogue has; `power_drag` stands at a degree of freedom, `thruster_failure`
/// at a thruster.
pub const OUTSIDE: [&str; 17] = [
    "power_drag",
    "thrust_hysteresis",
    "drag_step",
    "mass_step",
    "thrust_step",
    "tidal_current",
    "ground_effect",
    "swapped_wire",
    "thrust_ripple",
    "snagging_tether",
    "heading_dependent_current",
    "stiction",
    "sliding_payload",
    "vortex_shedding",
    "sloshing",
    "wave_spectrum",
    "thruster_failure",
];

/// Everything that sails, with what is hidden in it.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The vehicle that was drawn, as its owner knows it.
    pub vehicle: Vehicle,
    /// The plant as it is.
    pub plant: Plant,
    /// Instruments as they are.
    pub instruments: Vec<Instrument>,
    /// Wires between pilot and actuators.
    pub wiring: Wiring,
    /// Names of the baseline's effects.
    pub baseline: Vec<String>,
    /// Inertia by the Keulegan-Carpenter number, c of each degree of freedom, kg or kg·m².
    pub amplitude: [f64; 6],
    /// Keulegan-Carpenter numbers by run and degree of freedom.
    pub run_numbers: Vec<[f64; 6]>,
    /// Amplitude and period of a wave in each degree of freedom; its phase is another in each run.
    pub waves: [(f64, f64); 6],
    /// Irregular waves.
    pub sea: Option<Sea>,
    /// Velocity of the water in each run, m/s; empty where it is the same in all.
    pub currents: Vec<Vector3<f64>>,
    /// Push north and east in each run, N; empty where it is the same in all.
    pub pushes: Vec<[f64; 2]>,
    /// Constant force of each run in a degree of freedom, N or N·m; empty where it is the same in all.
    pub biases: [Vec<f64>; 6],
    /// δ: the instruments stamp t/(1 − δ), t from the beginning of each run.
    pub clock_drift: f64,
    seed: u64,
}

impl Setup {
    /// Makes of the plant what it is in one run.
    pub fn of_run(&self, plant: &mut Plant, run: usize) {
        if let Some(velocity) = self.currents.get(run) {
            plant.current = Current::Steady(*velocity);
        }
        if let Some(push) = self.pushes.get(run) {
            plant.earth_force = *push;
        }
        for (bias, of_runs) in plant.bias.iter_mut().zip(&self.biases) {
            *bias = of_runs.get(run).copied().unwrap_or(*bias);
        }
        for i in 0..6 {
            if let Some(numbers) = self.run_numbers.get(run) {
                plant.water.added_mass[(i, i)] += self.amplitude[i] * numbers[i];
            }
            let (amplitude, period) = self.waves[i];
            if amplitude > 0.0 {
                let phase = Random::new(self.seed, 0x8000 + ((run as u64) << 8) + i as u64).between(0.0, TAU);
                plant.waves.push(Wave { dof: i, amplitude, frequency: TAU / period, phase });
            }
        }
    }

    /// Instants, s of a run that begins at `clock`, at which the equations change.
    pub fn events(&self, clock: f64) -> Vec<f64> {
        let actuation = &self.plant.actuation;
        let own = actuation.losses.fault.iter().filter(|(k, _)| *k != 0.0).map(|(_, from)| *from);
        let outside = self.plant.outside.iter().filter_map(Outside::event);
        let thrusters = actuation.thrusters.iter().map(|t| t.loss.1);
        let thrust = thrusters.chain([actuation.weakened.1]).filter(|from| from.is_finite());
        own.chain(outside.chain(thrust).map(|from| from - clock)).collect()
    }
}

/// The vehicle drawn, the plant with everything hidden in it, the baseline without.
pub(crate) fn setup(campaign: &Campaign) -> Result<Setup, PlantError> {
    let vehicle = campaign.vehicle.clone().drawn(campaign.spread, &mut Random::new(campaign.seed, 1));
    let mut plant = vehicle.plant.clone();
    plant.moves = std::array::from_fn(|i| campaign.moves.iter().any(|dof| dof.index() == i));
    if campaign.commands == Commands::Thrusters {
        plant.actuation.thrusters.clone_from(&vehicle.thrusters);
    }
    let baseline = baseline(&plant, &campaign.dofs);
    let mut setup = Setup {
        vehicle,
        plant,
        instruments: campaign.instruments.clone(),
        wiring: Wiring::default(),
        baseline,
        amplitude: [0.0; 6],
        run_numbers: Vec::new(),
        waves: [(0.0, 5.0); 6],
        sea: None,
        currents: Vec::new(),
        pushes: Vec::new(),
        biases: std::array::from_fn(|_| Vec::new()),
        clock_drift: 0.0,
        seed: campaign.seed,
    };
    for row in &campaign.without {
        let name = Name::parse(row, &setup.vehicle)?;
        let reason = "only a row of the Coriolis matrix can be switched off";
        let row = name.coriolis_row().ok_or(PlantError::CannotHide { name: row.clone(), reason })?;
        setup.plant.coriolis[row] = 0.0;
    }
    for hidden in &campaign.hidden {
        hide(&mut setup, hidden, campaign)?;
    }
    Ok(setup)
}

/// Hides one effect.
fn hide(setup: &mut Setup, hidden: &Hidden, campaign: &Campaign) -> Result<(), PlantError> {
    let vehicle = setup.vehicle.clone();
    let name = Name::parse(&hidden.name, &vehicle)?;
    let refused = |reason| Err(PlantError::CannotHide { name: hidden.name.clone(), reason });
    let size = hidden.size;
    if setup.baseline.contains(&hidden.name) {
        // the vehicle has it: it stays in the plant and goes from the baseline, all parts of a common parameter at once
        let group = |id: &str| match id {
            "restoring_surge" | "restoring_sway" | "restoring_heave" => 1,
            "restoring_roll" | "restoring_pitch" => 2,
            _ => 0,
        };
        let of = group(name.id);
        setup.baseline.retain(|other| *other != hidden.name && (of == 0 || group(other) != of));
        if let Some(row) = name.coriolis_row() {
            setup.plant.coriolis[row] = size;
        } else if (size - 1.0).abs() > f64::EPSILON {
            let Some(list) = slots(&name, setup) else { return refused("it has no other size") };
            list.into_iter().for_each(|(_, value)| *value *= size);
        }
        return Ok(());
    }
    if let Some(values) = sensible(&name, &vehicle, size, campaign.duration) {
        if name.id == "supply_voltage" && !setup.instruments.iter().any(|i| i.has("supply_V")) {
            setup.instruments.push(Instrument::new(campaign.command_rate, &[("supply_V", 0.01)]));
        }
        let Some(list) = slots(&name, setup) else { return refused("it needs another place, or an instrument") };
        for ((_, slot), value) in list.into_iter().zip(values) {
            *slot = value;
        }
        return Ok(());
    }
    special(setup, &name, size, campaign)
}

/// What is more than a number of the plant.
fn special(setup: &mut Setup, name: &Name<'_>, size: f64, campaign: &Campaign) -> Result<(), PlantError> {
    let refused = |reason| Err(PlantError::CannotHide { name: name.full.to_string(), reason });
    let mut random = Random::new(campaign.seed, 0x9000);
    let Setup { vehicle, plant, instruments, wiring, .. } = setup;
    let (rated, speed, length) = (vehicle.rated, vehicle.speed(), vehicle.length);
    // an instant in the middle of the campaign, well inside a run
    let run = campaign.runs / 2;
    let instant = run as f64 * (campaign.duration + PAUSE) + random.between(0.3, 0.6) * campaign.duration;
    match (name.id, name.place) {
        ("added_mass_coupling", Place::Pair(i, j)) => {
            let inertia = plant.inertia();
            let value = 0.3 * size * (inertia[(i, i)] * inertia[(j, j)]).sqrt();
            plant.water.added_mass[(i, j)] += value;
            plant.water.added_mass[(j, i)] += value;
        }
        ("trim_offset", Place::Whole) => {
            let shift = -size * plant.body.weight / plant.body.buoyancy;
            plant.body.buoyancy_centre += shift * length * Vector3::new(0.03, -0.015, 0.0);
        }
        ("current", Place::Whole) => {
            plant.current = Current::Steady(size * speed[0] * Vector3::new(0.15, -0.1, 0.0));
        }
        ("current_each_run", Place::Whole) => {
            let mut drawn = || polar(random.between(0.1, 0.25) * size * speed[0], random.between(0.0, TAU));
            setup.currents = (0..campaign.runs).map(|_| drawn()).map(|[n, e]| Vector3::new(n, e, 0.0)).collect();
        }
        ("earth_force_each_run", Place::Whole) => {
            let mut drawn = || polar(random.between(0.05, 0.15) * size * rated[0], random.between(0.0, TAU));
            setup.pushes = (0..campaign.runs).map(|_| drawn()).collect();
        }
        ("bias_each_run", Place::One(i)) => {
            setup.biases[i] = (0..campaign.runs).map(|_| random.between(-0.15, 0.15) * size * rated[i]).collect();
        }
        ("thruster_loss", Place::Thruster(k)) if !plant.actuation.thrusters.is_empty() => {
            plant.actuation.thrusters[k].loss.0 = size;
        }
        ("thruster_swap", Place::Thrusters(a, b)) if !plant.actuation.thrusters.is_empty() => wiring.swaps.push((a, b)),
        ("thruster_failure", Place::Thruster(k)) if !plant.actuation.thrusters.is_empty() => {
            plant.actuation.thrusters[k].loss = (0.7 * size, instant);
        }
        ("thruster_advance_loss", Place::Whole) if !plant.actuation.thrusters.is_empty() => {
            plant.actuation.thrusters.iter_mut().for_each(|t| t.advance_loss = 0.25 * size / speed[0]);
        }
        ("thruster_loss" | "thruster_swap" | "thruster_failure" | "thruster_advance_loss", _) => {
            return refused("it needs thrusters that are commanded one by one");
        }
        ("sensor_delay", Place::Whole) => instruments.iter_mut().for_each(|one| one.latency += 0.4 * size),
        ("sensor_clock_drift", Place::Whole) => setup.clock_drift = 4e-3 * size,
        ("sensor_dvl_delay", Place::Whole) => {
            instruments.iter_mut().filter(|one| one.has("u")).for_each(|one| one.latency += 0.2 * size);
        }
        ("sensor_gyro_lag", Place::Whole) => {
            instruments.iter_mut().filter(|one| one.is_gyro()).for_each(|one| one.low_pass += 0.3 * size);
        }
        ("sensor_position_delay", Place::Whole) => {
            instruments.iter_mut().filter(|one| one.has("x")).for_each(|one| one.latency += size);
        }
        ("sensor_dvl_scale", Place::Whole) => {
            let channels = instruments.iter_mut().flat_map(|one| &mut one.channels);
            channels.filter(|c| matches!(c.name, "u" | "v" | "w")).for_each(|c| c.scale = 0.1 * size);
        }
        ("sensor_tilt_offset", Place::Whole) => {
            for channel in instruments.iter_mut().flat_map(|one| &mut one.channels) {
                match channel.name {
                    "phi" => channel.bias = size * 2.0_f64.to_radians(),
                    "theta" => channel.bias = size * -1.5_f64.to_radians(),
                    _ => {}
                }
            }
        }
        ("thrust_hysteresis", Place::Whole) => {
            let command = campaign.commands == Commands::Thrusters;
            wiring.backlash =
                std::array::from_fn(|k| size * if command { 0.06 } else { 0.12 * rated.get(k).unwrap_or(&0.0) });
        }
        ("drag_step", Place::Whole) => plant.outside.push(Outside::DragStep { share: 0.4 * size, from: instant }),
        ("mass_step", Place::Whole) => {
            let (mass, place) = (0.15 * size * plant.inertia()[(0, 0)], Vector3::new(0.2 * length, 0.0, 0.0));
            plant.outside.push(Outside::MassStep { mass, place, from: instant });
        }
        ("thrust_step", Place::Whole) => plant.actuation.weakened = (0.25 * size, instant),
        ("tidal_current", Place::Whole) => {
            let period = 0.8 * campaign.runs as f64 * (campaign.duration + PAUSE);
            let direction = random.between(0.0, TAU);
            plant.current = Current::Tide { speed: 0.2 * size * speed[0], period, direction };
        }
        ("heading_dependent_current", Place::Whole) => {
            let velocity = size * speed[0] * Vector3::new(0.25, 0.15, 0.0);
            plant.current = Current::ByHeading { velocity, heading: random.between(-3.0, 3.0) };
        }
        ("ground_effect", Place::Whole) => plant.outside.push(Outside::GroundEffect {
            strength: 0.8 * size,
            height: 2.0 * length,
            wavelength: 12.0 * length,
        }),
        ("swapped_wire", Place::Whole) => {
            // the last run of all-round motion that trains, or the first one
            let wrong = campaign.runs - (campaign.runs / 3).max(1);
            let run = wrong.saturating_sub(1);
            let channel = if campaign.commands == Commands::Thrusters {
                1
            } else {
                campaign.dofs.last().map_or(0, |d| d.index())
            };
            wiring.reversed = Some((run, channel));
        }
        ("thrust_ripple", Place::Whole) => plant.actuation.ripple = (0.25 * size, 1.7),
        ("snagging_tether", Place::Whole) => plant.outside.push(Outside::SnaggingTether {
            stiffness: 0.3 * size * rated[0],
            damping: 0.3 * size * rated[0] / speed[0],
            length: 8.0 * speed[0],
        }),
        ("stiction", Place::Whole) => {
            plant.outside.push(Outside::Stiction { force: rated.map(|f| 0.15 * size * f) });
        }
        ("sliding_payload", Place::Whole) => {
            plant.outside.push(Outside::SlidingPayload { mass: 0.12 * size * plant.body.mass, period: 4.0 });
        }
        ("vortex_shedding", Place::Whole) => plant.outside.push(Outside::VortexShedding {
            strength: 0.15 * size * rated[1] / (speed[0] * speed[0]),
            breadth: 0.8 * length,
        }),
        ("sloshing", Place::Whole) => {
            plant.outside.push(Outside::Sloshing { mass: 0.1 * size * plant.inertia()[(0, 0)], period: 3.0 });
        }
        ("wave_spectrum", Place::Whole) => {
            setup.sea = Some(Sea { rms: rated.map(|f| 0.08 * size * f), period: 4.0, enhancement: 3.3 });
        }
        _ => return refused("there is no such effect, or it needs a place (@dof, @dof:other)"),
    }
    Ok(())
}

/// North and east of what has this size and direction.
fn polar(size: f64, direction: f64) -> [f64; 2] {
    [size * direction.cos(), size * direction.sin()]
}

/// The effects of the catalogue that can be hidden in a campaign with these degrees of freedom, one place each.
pub fn catalogue(dofs: &[Dof], thrusters: &[&str]) -> Vec<String> {
    let six = dofs.len() == 6;
    let mut list: Vec<String> = [
        "added_mass_coupling@sway:yaw",
        "added_mass_amplitude@surge",
        "fluid_memory@surge",
        "coriolis_surge",
        "coriolis_sway",
        "coriolis_yaw",
        "linear_drag@sway",
        "quadratic_drag@yaw",
        "cubic_drag@yaw",
        "drag_asymmetry@surge",
        "coulomb_friction@surge",
        "linear_cross_damping@sway:yaw",
        "cross_drag@yaw:sway",
        "mixed_drag@sway:yaw",
        "even_drag@surge:yaw",
        "lift_moment@yaw:sway",
        "bias@sway",
        "bias_each_run@sway",
        "thrust_interaction_loss@yaw",
        "thrust_advance_loss@surge",
        "thrust_reverse_loss@surge",
        "thrust_deadband@surge",
        "thrust_saturation@surge",
        "thrust_lag",
        "thrust_delay",
        "thrust_crosstalk@yaw:surge",
        "thruster_fault@surge",
        "supply_voltage",
        "current",
        "current_each_run",
        "earth_force",
        "earth_force_each_run",
        "tether_spring",
        "tether_drag@surge",
        "wave@sway",
        "sensor_gyro_bias",
        "sensor_gyro_scale",
        "sensor_heading_offset",
        "sensor_compass_magnetic",
        "sensor_compass_deviation",
        "sensor_dvl_lever_arm",
        "sensor_dvl_misalignment",
        "sensor_dvl_scale",
        "sensor_dvl_delay",
        "sensor_gyro_lag",
        "sensor_position_delay",
        "sensor_position_lever_arm",
        "sensor_delay",
        "sensor_clock_drift",
    ]
    .map(String::from)
    .to_vec();
    if six {
        let more = ["coriolis_heave", "coriolis_roll", "coriolis_pitch", "restoring_heave", "restoring_pitch"];
        list.extend(more.into_iter().chain(["trim_offset", "sensor_tilt_offset"]).map(String::from));
    }
    if let [first, second, ..] = thrusters {
        list.extend([format!("thruster_loss@{first}"), format!("thruster_swap@{first}:{second}")]);
        list.push("thruster_advance_loss".into());
    }
    list
}
