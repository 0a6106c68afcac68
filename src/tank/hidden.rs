//! Effects that a blind campaign hides, and their sizes.
//!
//! ```text
//! value = neutral + size · (sensible − neutral)
//! ```
//!
//! With its sensible value an effect accounts for about a tenth to a third of the force, speed or
//! inertia of its degree of freedom. `size` 1 is clearly visible, 0.1 mostly not, 0 is no effect.
//! Values are relative to the vehicle's own scale.

use std::sync::Arc;

use super::outside::{PowerDrag, Sloshing, VortexShedding};
use super::{Craft, Noise, TankError};
use crate::effects::{Coriolis, Effect, ParameterSpec, Place, Scope, catalogue};
use crate::frame::Dof;
use crate::model::{Model, name_of, places_of};

/// An effect that the true model contains and the baseline lacks.
#[derive(Debug, Clone, PartialEq)]
pub struct Hidden {
    /// `id`, `id@dof` or `id@dof:other` of the catalogue, or an id of [`super::outside`]. A plain
    /// id means surge for an effect of single degrees of freedom, and `@sway:yaw` for a coupling.
    pub name: String,
    /// Size, 1 for the sensible value.
    pub size: f64,
}

impl Hidden {
    /// An effect of the given size.
    pub fn new(name: impl Into<String>, size: f64) -> Hidden {
        Hidden { name: name.into(), size }
    }
}

/// Hides an effect: adds it to the true `model` and removes it from the `baseline` (names of
/// effects) if that contains it. Returns its canonical name.
pub(super) fn hide(
    model: &mut Model,
    baseline: &mut Vec<String>,
    hidden: &Hidden,
    craft: &Craft,
    runs: usize,
    noise: &mut Noise,
) -> Result<String, TankError> {
    let refuse = |reason| TankError::CannotHide { name: hidden.name.clone(), reason };
    let id = hidden.name.split('@').next().unwrap_or_default();
    let outside: [Arc<dyn Effect>; 3] = [Arc::new(VortexShedding), Arc::new(Sloshing), Arc::new(PowerDrag)];
    let effect = catalogue(model.coriolis)
        .into_iter()
        .chain(outside)
        .find(|e| e.about().id == id)
        .ok_or_else(|| refuse("no effect has this id"))?;
    let place = place(&hidden.name, effect.about().scope).ok_or_else(|| refuse("no such degree of freedom"))?;
    let name = name_of(id, place);

    lose(baseline, &name, id, model);
    for (other, at) in partners(effect.as_ref(), place, model) {
        let part = name_of(other.about().id, at);
        lose(baseline, &part, other.about().id, model);
        if model.term(&part).is_none() {
            model.add(other, at)?;
        }
    }
    let known = model.term(&name);
    let term = known.map_or_else(|| model.add(effect, place), Ok)?;
    let parameters = model.terms[term].parameters.clone();
    if parameters.is_empty() {
        resize_coriolis(model, term, place, hidden.size, craft).ok_or_else(|| refuse("it has no size of its own"))?;
        return Ok(name);
    }
    if known.is_some() {
        // its value comes from the vehicle; a value shared with other effects is not changed
        for p in parameters {
            let parameter = &mut model.parameters[p];
            parameter.value *= if parameter.spec.shared.is_none() { hidden.size } else { 1.0 };
        }
        return Ok(name);
    }
    let sensible = sensible(id, place, craft).ok_or_else(|| refuse("no sensible size is known"))?;
    let last = sensible.len() - 1;
    for (k, p) in parameters.iter().enumerate() {
        let parameter = &mut model.parameters[*p];
        let value = sensible[k.min(last)].at(hidden.size, &parameter.spec);
        parameter.value = value.clamp(parameter.min, parameter.max);
    }
    if id == "wave" {
        let phases: Vec<f64> = (0..runs).map(|_| noise.between(0.0, std::f64::consts::TAU)).collect();
        let amplitude = model.parameters[parameters[0]].value;
        model.parameters[parameters[0]].per_run = phases.iter().map(|p| amplitude * p.cos()).collect();
        model.parameters[parameters[1]].per_run = phases.iter().map(|p| amplitude * p.sin()).collect();
    }
    Ok(name)
}

/// The other effects that share the parameter of this one in other degrees of freedom: they are
/// hidden together.
fn partners(effect: &dyn Effect, place: Place, model: &Model) -> Vec<(Arc<dyn Effect>, Place)> {
    let key = |effect: &dyn Effect, place| effect.parameters(place).first().and_then(|p| p.shared);
    let Some(own) = key(effect, place) else { return Vec::new() };
    catalogue(model.coriolis)
        .into_iter()
        .filter(|other| other.about().id != effect.about().id)
        .flat_map(|other| places_of(other.as_ref(), &model.dofs).into_iter().map(move |at| (other.clone(), at)))
        .filter(|(other, at)| key(other.as_ref(), *at) == Some(own))
        .collect()
}

/// The place in the name of an effect, or its default place.
fn place(name: &str, scope: Scope) -> Option<Place> {
    match (name.split_once('@'), scope) {
        (None, Scope::Each(dofs)) => Some(Place::at(*dofs.first()?)),
        (None, Scope::Pairs) => Some(Place::pair(Dof::Sway, Dof::Yaw)),
        (None, _) => Some(Place::VEHICLE),
        (Some((_, place)), _) => Some(match place.split_once(':') {
            None => Place::at(Dof::from_name(place)?),
            Some((dof, other)) => Place::pair(Dof::from_name(dof)?, Dof::from_name(other)?),
        }),
    }
}

/// Removes `name` from the baseline; a plain id, which means all places, is replaced by the other
/// places.
fn lose(baseline: &mut Vec<String>, name: &str, id: &str, model: &Model) {
    if let (true, Some(k)) = (name != id, baseline.iter().position(|b| b == id)) {
        let everywhere = model.terms.iter().map(|t| t.name()).filter(|t| t.split('@').next() == Some(id));
        baseline.splice(k..=k, everywhere.collect::<Vec<_>>());
    }
    baseline.retain(|b| b != name);
}

/// Changes the size of a tied Coriolis row, which has no parameter: a size other than 1 makes it a
/// row with its own, leading coefficient.
fn resize_coriolis(model: &mut Model, term: usize, place: Place, size: f64, craft: &Craft) -> Option<()> {
    let [mu, mv, mw, ..] = craft.inertia;
    let id = model.terms[term].effect.about().id.to_string();
    let coefficient = match id.as_str() {
        "coriolis_surge" => mv,
        "coriolis_sway" | "coriolis_heave" => mu,
        "coriolis_roll" => mw - mv,
        "coriolis_pitch" => mu - mw,
        "coriolis_yaw" => mv - mu,
        _ => return None,
    };
    if (size - 1.0).abs() > f64::EPSILON {
        model.remove(term);
        let free = catalogue(Coriolis::Free).into_iter().find(|e| e.about().id == id)?;
        model.add(free, place).ok()?;
        model.set(&id, size * coefficient);
    }
    Some(())
}

/// Dependence of a parameter on the size.
#[derive(Debug, Clone, Copy)]
enum Value {
    /// From neutral at size 0 to this value at size 1.
    Strength(f64),
    /// From this value, which nothing exceeds, at size 0 to 0.6 of it at size 1.
    Limit(f64),
    /// This value at every size.
    Shape(f64),
}

impl Value {
    fn at(self, size: f64, spec: &ParameterSpec) -> f64 {
        match self {
            Value::Strength(value) => spec.neutral + size * (value - spec.neutral),
            Value::Limit(value) => value * (1.0 - 0.4 * size).max(0.0),
            Value::Shape(value) => value,
        }
    }
}

/// Sensible values of an effect's parameters, in their order (the last one also for those that
/// follow).
fn sensible(id: &str, place: Place, craft: &Craft) -> Option<Vec<Value>> {
    use Value::{Limit, Shape, Strength};
    let (force, speed, inertia) = (craft.force, craft.speed(), craft.inertia);
    let i = place.dof.map_or(0, Dof::index);
    let j = place.other.map_or(0, Dof::index);
    let (f, u, m) = (force[i], speed[i], inertia[i]);
    let degree = f64::to_radians(1.0);
    Some(match id {
        "added_mass_coupling" => vec![Strength(0.3 * (m * inertia[j]).sqrt())],
        "added_mass_amplitude" => vec![Strength(0.02 * m)],
        "fluid_memory" => vec![Strength(0.4 * f / u), Shape(3.0)],
        "cubic_drag" => vec![Strength(0.4 * f / u.powi(3))],
        "drag_asymmetry" => vec![Strength(0.3 * f / (u * u))],
        "coulomb_friction" => vec![Strength(0.1 * f)],
        "linear_cross_damping" => vec![Strength(0.25 * f / speed[j])],
        "cross_drag" => vec![Strength(0.25 * f / (speed[j] * speed[j]))],
        "even_drag" => vec![Strength(0.25 * f / (speed[j] * speed[j]))],
        "mixed_drag" => vec![Strength(0.6 * f / (u * speed[j]))],
        "lift_moment" => vec![Strength(0.5 * f / (speed[0] * speed[j]))],
        "restoring_surge" | "restoring_sway" | "restoring_heave" => vec![Strength(-craft.force[0])],
        "bias" => vec![Strength(0.1 * f)],
        "trim_offset" => vec![Strength(0.01), Strength(-0.005)],
        "thrust_interaction_loss" => vec![Strength(0.75)],
        "thrust_advance_loss" => vec![Strength(0.25 / u)],
        "thrust_reverse_loss" => vec![Strength(0.3)],
        "thrust_deadband" => vec![Strength(0.1 * f)],
        "thrust_saturation" => vec![Limit(1.05 * f)],
        "thrust_lag" => vec![Strength(0.5)],
        "thrust_delay" | "sensor_delay" => vec![Strength(0.4)],
        "sensor_clock_drift" => vec![Strength(4e-3)],
        "sensor_dvl_delay" => vec![Strength(0.2)],
        "sensor_gyro_lag" => vec![Strength(0.3)],
        "sensor_position_delay" => vec![Strength(1.0)],
        "thrust_crosstalk" => vec![Strength(0.15 * f / force[j])],
        "thruster_fault" => vec![Strength(0.4), Shape(40.0)],
        "supply_voltage" => vec![Strength(1.5)],
        "current" => vec![Strength(0.15 * speed[0]), Strength(-0.1 * speed[0])],
        "earth_force" => vec![Strength(0.1 * force[0]), Strength(-0.05 * force[0])],
        "tether_spring" => vec![Strength(0.01 * force[0])],
        "tether_drag" => vec![Strength(0.1 * f / (u * u))],
        "wave" => vec![Strength(0.1 * f), Strength(0.0), Shape(5.0)],
        "sensor_gyro_bias" => vec![Strength(0.02)],
        "sensor_gyro_scale" | "sensor_dvl_scale" => vec![Strength(0.1)],
        "sensor_heading_offset" => vec![Strength(5.0 * degree)],
        "sensor_tilt_offset" => vec![Strength(2.0 * degree)],
        "sensor_compass_magnetic" => vec![Strength(8.0 * degree / force[0])],
        "sensor_compass_deviation" => vec![Strength(5.0 * degree), Strength(3.0 * degree), Strength(0.0)],
        "sensor_dvl_lever_arm" => vec![Strength(0.25), Strength(-0.1)],
        "sensor_dvl_misalignment" => vec![Strength(5.0 * degree)],
        "vortex_shedding" => vec![Strength(0.15 * force[1] / (speed[0] * speed[0])), Shape(0.5)],
        "sloshing" => vec![Strength(0.1 * inertia[0])],
        "power_drag" => vec![Strength(0.5 * f / u.powf(1.5))],
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::super::{Blind, BlindOptions, CraftKind, Noise, TankError, blind};
    use super::*;
    use crate::effects::Family;
    use crate::run::RunKind;

    /// A short campaign without noise.
    fn campaign(craft: CraftKind, six: bool, hidden: &[&str], size: f64) -> Result<Blind, TankError> {
        let hidden = hidden.iter().map(|name| Hidden::new(*name, size)).collect();
        blind(&BlindOptions { craft, six, duration: 50.0, noise: 0.0, rate: 5.0, hidden, ..BlindOptions::default() })
    }

    /// Largest difference of any logged signal except the commands, in units of its ordinary noise.
    /// Zig-zags are left out: a reversal one tick later is a large difference whatever its cause.
    fn gap(a: &Blind, b: &Blind) -> f64 {
        let noise = |name: &str| match name {
            "u" | "v" | "w" => 0.005,
            "p" | "q" | "r" => 0.003,
            "x" | "y" => 0.05,
            "z" => 0.02,
            _ => 0.009,
        };
        let mut most: f64 = 0.0;
        for (one, other) in a.runs.iter().zip(&b.runs).filter(|(run, _)| run.kind != RunKind::Zigzag) {
            for (name, signal) in one.signals.iter().filter(|(name, _)| !name.starts_with("tau_")) {
                let Some(second) = other.signal(name) else { continue };
                for (x, y) in signal.values().iter().zip(second.values()) {
                    most = most.max((x - y).abs() / noise(name));
                }
            }
        }
        most
    }

    /// Names of the catalogue effects that this vehicle can have, one place each.
    fn names(six: bool, baseline: &[String]) -> Vec<String> {
        let dofs: &[Dof] = if six { &Dof::ALL } else { &[Dof::Surge, Dof::Sway, Dof::Yaw] };
        let mut model = Model::new(dofs, Coriolis::Tied);
        let craft = Craft::draw(CraftKind::Large, &mut Noise::new(1, 1));
        let places = |e: &Arc<dyn Effect>| match e.about().scope {
            Scope::Each(list) => list.first().map(|dof| Place::at(*dof)),
            Scope::Pairs => Some(Place::pair(Dof::Sway, Dof::Yaw)),
            _ => Some(Place::VEHICLE),
        };
        catalogue(Coriolis::Tied)
            .into_iter()
            .filter(|e| !matches!(e.about().id, "inertia" | "restoring_heave"))
            // the tank's vehicles have neither fins nor a propeller with logged speed
            .filter(|e| !["rudder", "stern_plane", "propeller"].iter().any(|part| e.about().id.starts_with(part)))
            // an effect without a known size can be fitted and found, but not hidden here
            .filter(|e| {
                let sized = places(e).is_some_and(|place| sensible(e.about().id, place, &craft).is_some());
                sized || baseline.iter().any(|b| b == e.about().id)
            })
            // to limit the work: effects that a plane shows are not repeated in space
            .filter(|e| !six || baseline.iter().any(|b| b == e.about().id) || e.about().id == "trim_offset")
            .filter_map(|e| {
                places(&e).filter(|place| model.add(e.clone(), *place).is_ok()).map(|p| name_of(e.about().id, p))
            })
            .collect()
    }

    #[test]
    fn every_effect_of_the_catalogue_shows_when_hidden() {
        for (craft, six) in [(CraftKind::Large, false), (CraftKind::Small, false), (CraftKind::Small, true)] {
            let complete = campaign(craft, six, &[], 1.0).unwrap();
            for name in names(six, &complete.baseline) {
                let with = campaign(craft, six, &[&name], 1.0).unwrap();
                assert_eq!(with.hidden, std::slice::from_ref(&name));
                assert!(!with.baseline.contains(&name));
                if complete.truth.term(&name).is_some() {
                    let mut without = with.clone();
                    without.truth.remove(without.truth.term(&name).unwrap());
                    assert!(without.truth.terms.len() < complete.truth.terms.len(), "{name}");
                    continue;
                }
                let gap = gap(&complete, &with);
                assert!(gap > 3.0, "{name} on {craft:?}: {gap} times the noise");
                let family = with.truth.terms.last().unwrap().effect.about().family;
                assert!(family != Family::Sensor || gap < 1e3, "{name}: {gap}");
            }
        }
    }

    #[test]
    fn outside_effects_show_too() {
        let complete = campaign(CraftKind::Large, false, &[], 1.0).unwrap();
        for name in ["vortex_shedding", "sloshing", "power_drag@yaw"] {
            let with = campaign(CraftKind::Large, false, &[name], 1.0).unwrap();
            let gap = gap(&complete, &with);
            assert!(gap > 3.0, "{name}: {gap} times the noise");
        }
    }

    #[test]
    fn size_goes_from_plain_to_nothing() {
        let complete = campaign(CraftKind::Large, false, &[], 1.0).unwrap();
        for name in ["cubic_drag@sway", "thrust_lag", "thrust_saturation@surge", "coriolis_yaw", "current"] {
            let gaps =
                [1.0, 0.3, 0.0].map(|size| gap(&complete, &campaign(CraftKind::Large, false, &[name], size).unwrap()));
            if name == "coriolis_yaw" {
                // the true model contains the baseline's effect at size 1 and not at size 0
                assert!(gaps[0] < 1e-6 && gaps[2] > 3.0, "{name}: {gaps:?}");
            } else {
                // the least possible lag is 20 ms, so that some of it is left at size 0
                assert!(gaps[0] > gaps[1] && gaps[1] > gaps[2] && gaps[2] < 0.1 * gaps[0], "{name}: {gaps:?}");
            }
        }
    }

    #[test]
    fn one_place_of_a_plain_id_is_taken_out_alone() {
        let blind = campaign(CraftKind::Small, false, &["quadratic_drag@yaw"], 1.0).unwrap();
        let drags: Vec<&str> =
            blind.baseline.iter().map(String::as_str).filter(|b| b.starts_with("quadratic")).collect();
        assert_eq!(drags, ["quadratic_drag@surge", "quadratic_drag@sway"]);
        assert!(blind.truth.value("quadratic_drag@yaw").unwrap() > 1.0);
    }

    #[test]
    fn parts_that_share_a_parameter_are_hidden_together() {
        let planar = campaign(CraftKind::Large, false, &["restoring_surge"], 1.0).unwrap();
        assert!(planar.truth.term("restoring_sway").is_some());
        let spatial = campaign(CraftKind::Large, true, &["restoring_roll"], 1.0).unwrap();
        assert!(!spatial.baseline.iter().any(|b| b == "restoring_roll" || b == "restoring_pitch"));
    }

    #[test]
    fn what_cannot_be_hidden_is_refused() {
        for name in ["munk", "cubic_drag@sideways", "trim_offset"] {
            assert!(campaign(CraftKind::Small, false, &[name], 1.0).is_err(), "{name}");
        }
    }
}
