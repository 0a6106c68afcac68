//! The kind of an effect in the equation of momentum, read off its formulas.
//!
//! ```text
//! inertia    changes π                     drag        w = w(νᵢ) in its own row i
//! memory     carries states                cross drag  w = w(ν) in its own row i, of other velocities too
//! Coriolis   w = w(ν) or w(ν, π), over all rows
//! restoring  w = w(η)                      steady      w = const
//! ```

use super::touched::{memories, parameters, somewhere};
use crate::effects::{Effect, Family, Instant, Place};
use crate::frame::Dof;
use crate::model::{Model, Term};
use crate::symbolic::{Expr, Graph, Leaf};

/// Kind of an effect in the equation of momentum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Nature {
    /// It adds to the momentum.
    Inertia,
    /// It carries states.
    Memory,
    /// It depends on the velocities of the whole vehicle, as −C(ν)ν does.
    Coriolis,
    /// It acts in one degree of freedom and depends on that motion alone.
    Drag,
    /// It acts in one degree of freedom and depends on other motions.
    CrossDrag,
    /// It depends on attitude or position.
    Restoring,
    /// It is constant.
    Steady,
    /// None of these: it depends on channels, commands or time, or is not a force of the body.
    Other,
}

/// Kind of the effect of a term of `model`.
pub fn nature(model: &Model, term: &Term) -> Nature {
    nature_at(term.effect.as_ref(), term.place, model)
}

/// Kind of `effect` at a place of `model`.
pub fn nature_at(effect: &dyn Effect, place: Place, model: &Model) -> Nature {
    if effect.about().family != Family::Body {
        return Nature::Other;
    }
    let graph = Graph::new();
    let channels = effect.channels(place);
    let at = somewhere(&graph, model, &channels);
    let (theta, memory) = (parameters(&graph, effect, place), memories(&at, effect, place));
    let (mut momentum, mut wrench) = ([graph.zero(); 6], [graph.zero(); 6]);
    effect.momentum(&at, place, &theta, &mut momentum);
    effect.wrench(&at, place, &theta, &memory, &mut wrench);
    if !memory.is_empty() {
        return Nature::Memory;
    }
    if momentum.iter().any(|row| !row.is_zero()) {
        return Nature::Inertia;
    }
    if !channels.is_empty() {
        return Nature::Other;
    }
    of_force(&at, place, &wrench)
}

/// Kind of a force without memory, by the quantities that it reads.
fn of_force<'g>(at: &Instant<'g>, place: Place, wrench: &[Expr<'g>; 6]) -> Nature {
    let read: Vec<Leaf> = wrench.iter().flat_map(|row| row.leaves()).collect();
    let reads = |symbol: &Expr<'g>| symbol.leaves().iter().any(|leaf| read.contains(leaf));
    let moving = |dof: &Dof| reads(&at.nu[dof.index()]) || reads(&at.momentum[dof.index()]);
    let moves: Vec<Dof> = Dof::ALL.into_iter().filter(moving).collect();
    let posed = at.position.iter().chain(&at.attitude).any(reads);
    let driven = at.command.iter().any(reads) || reads(&at.time);
    match (moves.as_slice(), place.dof) {
        _ if driven || wrench.iter().all(|row| row.is_zero()) => Nature::Other,
        ([], _) if posed => Nature::Restoring,
        ([], _) => Nature::Steady,
        _ if posed => Nature::Other,
        ([own], Some(dof)) if *own == dof => Nature::Drag,
        (_, Some(_)) => Nature::CrossDrag,
        (_, None) => Nature::Coriolis,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{self, catalogue};
    use crate::model::places_of;

    #[test]
    fn the_body_s_effects_are_what_their_formulas_say() {
        use Nature::*;
        let known = [
            (Inertia, vec!["inertia", "added_mass_coupling", "added_mass_amplitude"]),
            (Memory, vec!["fluid_memory"]),
            (Coriolis, vec!["coriolis_surge", "coriolis_heave", "coriolis_pitch", "coriolis_yaw"]),
            (Drag, vec!["linear_drag", "quadratic_drag", "cubic_drag", "drag_asymmetry", "coulomb_friction"]),
            (CrossDrag, vec!["linear_cross_damping", "cross_drag", "even_drag", "mixed_drag", "lift_moment"]),
            (Restoring, vec!["restoring_surge", "restoring_heave", "restoring_roll", "restoring_pitch", "trim_offset"]),
            (Steady, vec!["bias"]),
            (Other, vec!["current", "earth_force", "thrust_lag", "rudder_force", "tether_spring", "sensor_gyro_bias"]),
        ];
        for coriolis in [effects::Coriolis::Tied, effects::Coriolis::Free] {
            let model = Model::new(&Dof::ALL, coriolis);
            let catalogue = catalogue(coriolis);
            for (nature, id) in known.iter().flat_map(|(nature, ids)| ids.iter().map(move |id| (nature, *id))) {
                let effect = catalogue.iter().find(|e| e.about().id == id).unwrap().as_ref();
                assert_eq!(nature_at(effect, places_of(effect, &Dof::ALL)[0], &model), *nature, "{id}");
            }
        }
    }
}
