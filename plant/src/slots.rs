//! For each effect of the catalogue: the places of its parameters in the plant, their names, and
//! their realistic values.

use crate::hide::Setup;
use crate::instrument::{Channel, Instrument};
use crate::naming::{Name, Place};
use crate::vehicle::Vehicle;

/// Symbols of the velocities.
pub(crate) const V: [&str; 6] = ["u", "v", "w", "p", "q", "r"];

/// The places of an effect's parameters, each with its name in `hydrosysid`; `None` if the effect
/// is more than numbers of the plant, or if its instrument is missing.
pub(crate) fn slots<'s>(name: &Name<'_>, setup: &'s mut Setup) -> Option<Vec<(String, &'s mut f64)>> {
    let Setup { plant, instruments, amplitude, waves, .. } = setup;
    let water = &mut plant.water;
    let losses = &mut plant.actuation.losses;
    Some(match (name.id, name.place) {
        ("linear_drag", Place::One(i)) => vec![(format!("k_{}", V[i]), &mut water.linear[(i, i)])],
        ("quadratic_drag", Place::One(i)) => vec![(format!("k_{0}|{0}|", V[i]), &mut water.quadratic[(i, i)])],
        ("cubic_drag", Place::One(i)) => vec![(format!("k_{0}{0}{0}", V[i]), &mut water.cubic[i])],
        ("drag_asymmetry", Place::One(i)) => vec![(format!("k_{0}|{0}|-", V[i]), &mut water.asymmetry[i])],
        ("coulomb_friction", Place::One(i)) => vec![(format!("c_{}", V[i]), &mut water.friction[i])],
        ("power_drag", Place::One(i)) => vec![("d_power".into(), &mut water.three_halves[i])],
        ("linear_cross_damping", Place::Pair(i, j)) => {
            vec![(format!("k_{}{}", V[i], V[j]), &mut water.linear[(i, j)])]
        }
        ("cross_drag", Place::Pair(i, j)) => {
            vec![(format!("k_{1}|{1}|@{0}", V[i], V[j]), &mut water.quadratic[(i, j)])]
        }
        ("mixed_drag", Place::Pair(i, j)) => vec![(format!("k_|{1}|{0}", V[i], V[j]), &mut water.mixed[(i, j)])],
        ("even_drag", Place::Pair(i, j)) => vec![(format!("k_{0}{0}", V[j]), &mut water.even[(i, j)])],
        ("lift_moment", Place::Pair(i, j)) => vec![(format!("k_lift{}", V[i]), &mut water.lift[(i, j)])],
        ("fluid_memory", Place::One(i)) => {
            let (strength, time) = &mut water.memory[i];
            vec![(format!("k_mem{}", V[i]), strength), (format!("T_mem{}", V[i]), time)]
        }
        ("added_mass_amplitude", Place::One(i)) => vec![(format!("c_KC{}", V[i]), &mut amplitude[i])],
        ("bias", Place::One(i)) => vec![(format!("b_{}", V[i]), &mut plant.bias[i])],
        ("thrust_interaction_loss", Place::One(i)) => vec![(format!("eta_{}", V[i]), &mut losses.interaction[i])],
        ("thrust_advance_loss", Place::One(i)) => vec![(format!("k_adv{}", V[i]), &mut losses.advance[i])],
        ("thrust_reverse_loss", Place::One(i)) => vec![(format!("k_rev{}", V[i]), &mut losses.reverse[i])],
        ("thrust_deadband", Place::One(i)) => vec![(format!("c_dead{}", V[i]), &mut losses.deadband[i])],
        ("thrust_saturation", Place::One(i)) => vec![(format!("c_sat{}", V[i]), &mut losses.saturation[i])],
        ("thrust_crosstalk", Place::Pair(i, j)) => {
            vec![(format!("k_{}{}", V[i], V[j]), &mut losses.crosstalk[(i, j)])]
        }
        ("thruster_fault", Place::One(i)) => {
            let (k, from) = &mut losses.fault[i];
            vec![(format!("k_fault{}", V[i]), k), (format!("t_fault{}", V[i]), from)]
        }
        ("thrust_lag", Place::Whole) => vec![("T_lag".into(), &mut losses.lag)],
        ("thrust_delay", Place::Whole) => vec![("T_delay".into(), &mut plant.actuation.delay)],
        ("supply_voltage", Place::Whole) => vec![("n_supply".into(), &mut losses.supply_exponent)],
        ("earth_force", Place::Whole) => {
            let [north, east] = &mut plant.earth_force;
            vec![("F_N".into(), north), ("F_E".into(), east)]
        }
        ("tether_spring", Place::Whole) => vec![("k_tether".into(), &mut plant.tether_spring)],
        ("tether_drag", Place::One(i)) => vec![(format!("k_z{0}|{0}|", V[i]), &mut plant.tether_drag[i])],
        ("wave", Place::One(i)) => {
            let (amplitude, period) = &mut waves[i];
            vec![(format!("amplitude_wave{}", V[i]), amplitude), (format!("T_wave{}", V[i]), period)]
        }
        ("sensor_gyro_bias", Place::Whole) => vec![("b_gyro".into(), &mut of(instruments, "r")?.bias)],
        ("sensor_gyro_scale", Place::Whole) => vec![("s_gyro".into(), &mut of(instruments, "r")?.scale)],
        ("sensor_heading_offset", Place::Whole) => vec![("c_psi".into(), &mut of(instruments, "psi")?.bias)],
        ("sensor_compass_magnetic", Place::Whole) => {
            let k = instruments.iter().position(|i| i.has("psi"))?;
            vec![("a_mag".into(), &mut instruments[k].magnetic)]
        }
        ("sensor_compass_deviation", Place::Whole) => {
            let k = instruments.iter().position(|i| i.has("psi"))?;
            let (a, b) = &mut instruments[k].deviation;
            vec![("a_dev".into(), a), ("b_dev".into(), b)]
        }
        ("sensor_dvl_lever_arm", Place::Whole) => {
            let k = instruments.iter().position(|i| i.has("u"))?;
            let [x, y, _] = &mut instruments[k].lever_arm.data.0[0];
            vec![("x_dvl".into(), x), ("y_dvl".into(), y)]
        }
        ("sensor_position_lever_arm", Place::Whole) => {
            let k = instruments.iter().position(|i| i.has("x"))?;
            let [x, y, _] = &mut instruments[k].lever_arm.data.0[0];
            vec![("x_pos".into(), x), ("y_pos".into(), y)]
        }
        ("sensor_dvl_misalignment", Place::Whole) => {
            let k = instruments.iter().position(|i| i.has("u"))?;
            vec![("alpha_dvl".into(), &mut instruments[k].misalignment)]
        }
        _ => return None,
    })
}

/// The first channel of this name in any instrument.
pub(crate) fn of<'i>(instruments: &'i mut [Instrument], name: &str) -> Option<&'i mut Channel> {
    instruments.iter_mut().find_map(|i| i.channel(name))
}

/// Values of an effect's parameters at a size, in the order of its [`slots`]. Size 1 has a clear
/// effect on the log, size 0 none.
pub(crate) fn sensible(name: &Name<'_>, vehicle: &Vehicle, size: f64, duration: f64) -> Option<Vec<f64>> {
    let speed = vehicle.speed();
    let (i, j) = match name.place {
        Place::One(i) => (i, i),
        Place::Pair(i, j) => (i, j),
        _ => (0, 0),
    };
    let (f, u) = (vehicle.rated[i], speed[i]);
    let m = vehicle.plant.inertia()[(i, i)];
    let degree = f64::to_radians(1.0);
    let strength = |value: f64| Some(vec![size * value]);
    let two = |a: f64, b: f64| Some(vec![size * a, size * b]);
    match name.id {
        "cubic_drag" => strength(0.4 * f / u.powi(3)),
        "drag_asymmetry" => strength(0.3 * f / (u * u)),
        "coulomb_friction" => strength(0.1 * f),
        "power_drag" => strength(0.5 * f / u.powf(1.5)),
        "linear_cross_damping" => strength(0.25 * f / speed[j]),
        "cross_drag" => strength(0.25 * f / (speed[j] * speed[j])),
        "even_drag" => strength(0.25 * f / (speed[j] * speed[j])),
        "lift_moment" => strength(0.5 * f / (speed[0] * speed[j])),
        "mixed_drag" => strength(0.6 * f / (u * speed[j])),
        "fluid_memory" => Some(vec![size * 0.4 * f / u, 3.0]),
        "added_mass_amplitude" => strength(0.02 * m),
        "bias" => strength(0.1 * f),
        "thrust_interaction_loss" => Some(vec![1.0 - 0.25 * size]),
        "thrust_advance_loss" => strength(0.25 / u),
        "thrust_reverse_loss" => strength(0.3),
        "thrust_deadband" => strength(0.1 * f),
        "thrust_saturation" => Some(vec![(1.0 - 0.45 * size).max(0.05) * f]),
        "thrust_crosstalk" => strength(0.15 * f / vehicle.rated[j]),
        "thruster_fault" => Some(vec![0.4 * size, 0.45 * duration]),
        "thrust_lag" => strength(0.5),
        "thrust_delay" => strength(0.4),
        "supply_voltage" => strength(1.5),
        "earth_force" => two(0.1 * vehicle.rated[0], -0.05 * vehicle.rated[0]),
        "tether_spring" => strength(0.01 * vehicle.rated[0]),
        "tether_drag" => strength(0.02 * f / (u * u)),
        "wave" => Some(vec![0.1 * size * f, 5.0]),
        "sensor_gyro_bias" => strength(0.02),
        "sensor_gyro_scale" => strength(0.1),
        "sensor_heading_offset" | "sensor_dvl_misalignment" => strength(5.0 * degree),
        "sensor_compass_magnetic" => strength(8.0 * degree / vehicle.rated[0]),
        "sensor_compass_deviation" => two(5.0 * degree, 3.0 * degree),
        "sensor_dvl_lever_arm" => two(0.25, -0.1),
        "sensor_position_lever_arm" => two(0.8, -0.3),
        _ => None,
    }
}
