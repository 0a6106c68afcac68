//! The common names of the effects of the catalogue.

use super::{ThrusterLoss, ThrusterSwap};

/// The common name of an effect: `coriolis_yaw` is the Munk moment. A place behind the id
/// (`@surge`) is included. An id without a common name is turned into words.
pub fn common_name(name: &str) -> String {
    common_name_at(name, None)
}

/// The common name of an effect whose first parameter is known: a thruster that has lost twice its
/// thrust is reversed.
pub fn common_name_at(name: &str, first: Option<f64>) -> String {
    let (id, place) = name.split_once('@').unwrap_or((name, ""));
    let known = NAMES.iter().find(|(known, _)| *known == id).map(|(_, common)| *common);
    let known = first.filter(|_| id == ThrusterLoss::ID).map(lost_of_thruster).or(known);
    let own = known.map_or_else(|| id.replace('_', " "), str::to_string);
    match place {
        "" => own,
        // a thruster's place is its name
        place if [ThrusterLoss::ID, ThrusterSwap::ID].contains(&id) => {
            format!("{own}, {}", place.replace(':', " and "))
        }
        place => format!("{own} in {}", place.replace(':', " from ")),
    }
}

/// The name of a thruster that has lost this share of its thrust.
fn lost_of_thruster(share: f64) -> &'static str {
    match share {
        ..0.0 => "a thruster that is stronger than its curve",
        ..0.8 => "a weak thruster",
        ..1.2 => "a dead thruster",
        _ => "a thruster that is wired, or mounted, the wrong way round",
    }
}

/// Common name and id: `the Munk moment (coriolis_yaw)`.
pub fn named(id: &str) -> String {
    format!("{} ({id})", common_name(id))
}

const NAMES: &[(&str, &str)] = &[
    ("inertia", "virtual mass"),
    ("added_mass_coupling", "coupled added mass"),
    ("added_mass_amplitude", "added mass that grows with the amplitude"),
    ("fluid_memory", "wake memory"),
    ("coriolis_surge", "the Coriolis force in surge"),
    ("coriolis_sway", "the Coriolis force in sway"),
    ("coriolis_yaw", "the Munk moment"),
    ("coriolis_heave", "the Coriolis force in heave"),
    ("coriolis_roll", "the Coriolis moment in roll"),
    ("coriolis_pitch", "the Munk moment in pitch"),
    ("drag_asymmetry", "drag that differs astern"),
    ("coulomb_friction", "dry friction"),
    ("linear_cross_damping", "linear cross damping"),
    ("even_drag", "an even force"),
    ("mixed_drag", "drag that grows with another speed"),
    ("lift_moment", "the lift moment of the hull"),
    ("restoring_surge", "net weight"),
    ("restoring_sway", "net weight"),
    ("restoring_heave", "net weight"),
    ("restoring_roll", "the righting moment"),
    ("restoring_pitch", "the righting moment"),
    ("bias", "a constant force"),
    ("weight_each_run", "a net weight of its own in each run"),
    ("bias_each_run", "a constant force of its own in each run"),
    ("trim_offset", "trim"),
    ("thrust_interaction_loss", "loss of thrust between thruster and hull"),
    ("thrust_advance_loss", "loss of thrust with speed"),
    ("thruster_advance_loss", "loss of thrust of each thruster with its own speed"),
    ("thrust_reverse_loss", "weaker reverse thrust"),
    ("thrust_deadband", "dead band of the thrusters"),
    ("thrust_saturation", "saturation of the thrusters"),
    ("thrust_lag", "rotor lag"),
    ("thrust_delay", "delay of the thrust"),
    ("thrust_crosstalk", "thrust from another command"),
    ("thruster_fault", "a thruster that fails"),
    ("thruster_loss", "a weak, dead or reversed thruster"),
    ("thruster_swap", "two thrusters that are exchanged"),
    ("supply_voltage", "sagging supply voltage"),
    ("current", "a water current"),
    ("earth_force", "a steady push in one compass direction"),
    ("current_each_run", "a water current of its own in each run"),
    ("earth_force_each_run", "a steady push in one compass direction, of its own in each run"),
    ("tether_spring", "the pull of the tether"),
    ("tether_drag", "drag of the tether"),
    ("wave", "waves"),
    ("sensor_gyro_bias", "bias of the gyro"),
    ("sensor_gyro_scale", "scale of the gyro"),
    ("sensor_heading_offset", "offset of the compass"),
    ("sensor_tilt_offset", "offset of the tilt sensor"),
    ("sensor_compass_magnetic", "magnetic field of the thrusters at the compass"),
    ("sensor_compass_deviation", "deviation of the compass"),
    ("sensor_dvl_lever_arm", "lever arm of the DVL"),
    ("sensor_dvl_misalignment", "misalignment of the DVL"),
    ("sensor_dvl_scale", "scale of the DVL"),
    ("sensor_dvl_delay", "latency of the DVL"),
    ("sensor_gyro_lag", "lag of the gyro"),
    ("sensor_position_lever_arm", "lever arm of the position"),
    ("sensor_position_delay", "latency of the position"),
    ("sensor_delay", "late logging"),
    ("sensor_clock_drift", "a drifting clock of the sensors"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Coriolis, catalogue};

    #[test]
    fn every_common_name_is_of_an_effect_and_tells_its_place() {
        let ids: Vec<String> = catalogue(Coriolis::Tied).iter().map(|e| e.about().id.to_string()).collect();
        assert!(NAMES.iter().all(|(id, _)| ids.iter().any(|known| known == id)));
        assert_eq!(common_name("coriolis_yaw"), "the Munk moment");
        assert_eq!(common_name("linear_drag@sway"), "linear drag in sway");
        assert_eq!(common_name("thruster_loss@T6"), "a weak, dead or reversed thruster, T6");
        let lost = |share| common_name_at("thruster_loss@T6", Some(share));
        assert_eq!([lost(0.3), lost(0.98)], ["a weak thruster, T6", "a dead thruster, T6"]);
        assert_eq!(lost(2.0), "a thruster that is wired, or mounted, the wrong way round, T6");
        assert_eq!(common_name_at("bias@sway", Some(2.0)), "a constant force in sway");
        assert_eq!(common_name("cross_drag@yaw:sway"), "cross drag in yaw from sway");
    }
}
