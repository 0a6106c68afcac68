//! Effects that a log often cannot tell apart, and the run that separates them.

/// The run that separates `id` from one of `others`; `None` if none is known.
pub fn separating(id: &str, others: &[&str]) -> Option<&'static str> {
    let separates = |ids: &[&str]| ids.contains(&id) && others.iter().any(|other| ids.contains(other));
    LOOK_ALIKES.iter().find(|(ids, _)| separates(ids)).map(|(_, run)| *run)
}

/// Ids of effects, and the run that separates them.
const LOOK_ALIKES: &[(&[&str], &str)] = &[
    (
        &["linear_drag", "quadratic_drag", "cubic_drag", "mixed_drag"],
        "hold constant speeds, one after the other, from the slowest to full speed and in both directions: forms of \
         drag differ most at the ends of the range",
    ),
    (
        &["thrust_lag", "thrust_delay", "fluid_memory", "inertia"],
        "step the command up and down, logged at 10 Hz or faster: a delay responds late but abruptly, a lag at once \
         but slowly, and an inertia in proportion to the step",
    ),
    (
        &["coulomb_friction", "bias", "drag_asymmetry", "thrust_reverse_loss", "thrust_deadband", "restoring_surge"],
        "pass slowly through rest in both directions, once under small commands and once coasting: friction changes \
         sign with the motion, a loss of thrust with the command, a bias with neither",
    ),
    (
        &["thrust_interaction_loss", "supply_voltage", "inertia", "sensor_dvl_scale"],
        "measure one force or one speed by itself: a bollard pull with load cells, or a position that is independent of \
         the velocity sensor; no log of a free vehicle gives the scale of both",
    ),
    (
        &["current", "earth_force", "bias", "linear_drag", "tether_spring", "wave"],
        "sail the same straight run on four headings, slowly and at full speed, and twice as far: the forces of a \
         current and of a steady push rotate with the heading, and only the current's grows with the speed; a tether's \
         grows with the distance; a bias does neither",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Coriolis, catalogue};

    #[test]
    fn each_is_an_effect_of_the_catalogue() {
        let known = catalogue(Coriolis::Tied);
        for id in LOOK_ALIKES.iter().flat_map(|(ids, _)| *ids) {
            assert!(known.iter().any(|e| e.about().id == *id), "{id}");
        }
    }

    #[test]
    fn a_run_separates_those_that_it_is_of() {
        assert!(separating("thrust_lag", &["fluid_memory"]).is_some_and(|run| run.starts_with("step the command")));
        assert_eq!(separating("thrust_lag", &["current"]), None);
    }
}
