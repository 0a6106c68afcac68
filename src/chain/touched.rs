//! Dependencies of an effect, read off its formulas on an instant of independent symbols.

use crate::effects::{Effect, Instant, Logged, Place, Six};
use crate::frame::Dof;
use crate::model::Model;
use crate::symbolic::{Expr, Graph, Leaf};
use crate::units::Dimension;

/// Number of states that an effect carries at a place of `model`.
pub fn memory_count(graph: &Graph, model: &Model, effect: &dyn Effect, place: Place) -> usize {
    let at = somewhere(graph, model, &effect.channels(place));
    effect.memory(&at, place, &at.command).len()
}

/// Degrees of freedom of `model` in which an effect changes the momentum, the force or the logged
/// values.
pub fn acts_in(effect: &dyn Effect, place: Place, model: &Model) -> Vec<Dof> {
    let graph = Graph::new();
    let at = somewhere(&graph, model, &effect.channels(place));
    let theta = parameters(&graph, effect, place);
    if effect.delays_command().is_some() || effect.water(&at, place, &theta).is_some() {
        return model.dofs.clone();
    }
    let memory = memories(&at, effect, place);
    let zero = [graph.zero(); 6];
    let (mut momentum, mut wrench, mut tau) = (zero, zero, at.command);
    effect.momentum(&at, place, &theta, &mut momentum);
    effect.wrench(&at, place, &theta, &memory, &mut wrench);
    effect.actuate(&at, place, &theta, &memory, &mut tau);
    let altered = altered(&at, effect, place, &theta, &memory);
    let touched = |dof: &Dof| {
        let i = dof.index();
        let pushed = !(momentum[i].is_zero() && wrench[i].is_zero() && tau[i].same(at.command[i]));
        pushed || altered.contains(&dof.velocity()) || altered.contains(&dof.position())
    };
    model.dofs.iter().copied().filter(touched).collect()
}

/// Logged channels of the motion that an effect alters, as a sensor error does.
pub fn alters(effect: &dyn Effect, place: Place, model: &Model) -> Vec<&'static str> {
    let graph = Graph::new();
    let at = somewhere(&graph, model, &effect.channels(place));
    let (theta, memory) = (parameters(&graph, effect, place), memories(&at, effect, place));
    altered(&at, effect, place, &theta, &memory)
}

/// Whether an effect delays the thrust against its command: by a dead time, or by a state that
/// replaces the command.
pub fn delays_thrust(effect: &dyn Effect, place: Place, model: &Model) -> bool {
    let graph = Graph::new();
    let at = somewhere(&graph, model, &effect.channels(place));
    let (theta, memory) = (parameters(&graph, effect, place), memories(&at, effect, place));
    let mut tau = at.command;
    effect.actuate(&at, place, &theta, &memory, &mut tau);
    let instead = |e: &Expr<'_>| e.leaves().iter().any(|leaf| matches!(leaf, Leaf::Rate(_)));
    effect.delays_command().is_some() || tau.iter().any(instead)
}

/// Degrees of freedom of `model` whose velocity the memory of an effect follows.
pub fn follows(effect: &dyn Effect, place: Place, model: &Model) -> Vec<Dof> {
    let graph = Graph::new();
    let at = somewhere(&graph, model, &effect.channels(place));
    let (theta, memory) = (parameters(&graph, effect, place), memories(&at, effect, place));
    let read: Vec<Leaf> =
        effect.memory_rate(&at, place, &theta, &memory, &at.command).iter().flat_map(|rate| rate.leaves()).collect();
    let follows = |dof: &Dof| at.nu[dof.index()].leaves().iter().any(|leaf| read.contains(leaf));
    model.dofs.iter().copied().filter(follows).collect()
}

/// Whether momentum or force of an effect depends on the time of the run.
pub fn reads_time(effect: &dyn Effect, place: Place, model: &Model) -> bool {
    let graph = Graph::new();
    let at = somewhere(&graph, model, &effect.channels(place));
    let (theta, memory) = (parameters(&graph, effect, place), memories(&at, effect, place));
    let zero = [graph.zero(); 6];
    let (mut momentum, mut wrench, mut tau) = (zero, zero, at.command);
    effect.momentum(&at, place, &theta, &mut momentum);
    effect.wrench(&at, place, &theta, &memory, &mut wrench);
    effect.actuate(&at, place, &theta, &memory, &mut tau);
    let time = at.time.leaves();
    momentum.iter().chain(&wrench).chain(&tau).any(|e| e.leaves().iter().any(|leaf| time.contains(leaf)))
}

/// The parameters of an effect as symbols.
pub(super) fn parameters<'g>(graph: &'g Graph, effect: &dyn Effect, place: Place) -> Vec<Expr<'g>> {
    let specs = effect.parameters(place);
    specs.iter().enumerate().map(|(k, spec)| graph.leaf(Leaf::Parameter(k as u16), spec.dimension)).collect()
}

/// The states that an effect carries as symbols.
pub(super) fn memories<'g>(at: &Instant<'g>, effect: &dyn Effect, place: Place) -> Vec<Expr<'g>> {
    let starts = effect.memory(at, place, &at.command);
    let state = |(k, start): (usize, &Expr<'g>)| {
        at.graph.leaf(Leaf::Rate(k as u16), start.dimension().unwrap_or(Dimension::ONE))
    };
    starts.iter().enumerate().map(state).collect()
}

/// Channels that an effect alters.
fn altered<'g>(
    at: &Instant<'g>,
    effect: &dyn Effect,
    place: Place,
    theta: &[Expr<'g>],
    memory: &[Expr<'g>],
) -> Vec<&'static str> {
    let told = Logged { nu: at.nu, position: at.position, attitude: at.attitude };
    let mut logged = told.clone();
    effect.sense(at, place, theta, memory, &mut logged);
    let pose = |i: usize| match i {
        0..3 => logged.position[i].same(told.position[i]),
        _ => logged.attitude[i - 3].same(told.attitude[i - 3]),
    };
    let velocities = Dof::ALL.iter().filter(|dof| !logged.nu[dof.index()].same(told.nu[dof.index()]));
    let poses = Dof::ALL.iter().filter(|dof| !pose(dof.index()));
    velocities.map(|dof| dof.velocity()).chain(poses.map(|dof| dof.position())).collect()
}

/// An instant in which every quantity is a separate symbol.
pub(super) fn somewhere<'g>(graph: &'g Graph, model: &Model, channels: &[String]) -> Instant<'g> {
    let state = |first: usize, i: usize, unit| graph.leaf(Leaf::State((first + i) as u16), unit);
    let input = |k: usize, unit| graph.leaf(Leaf::Input(k as u16), unit);
    let by_kind = |first: usize, moves: Dimension, turns: Dimension| -> Six<'g> {
        std::array::from_fn(|i| state(first, i, if i < 3 { moves } else { turns }))
    };
    let nu = by_kind(0, Dimension::VELOCITY, Dimension::RATE);
    let pose = by_kind(6, Dimension::LENGTH, Dimension::ONE);
    let impulse = |force: Dimension| force.times(Dimension::TIME);
    Instant {
        graph,
        time: input(0, Dimension::TIME),
        nu,
        nu_r: nu,
        nu_logged: nu,
        position: [pose[0], pose[1], pose[2]],
        attitude: [pose[3], pose[4], pose[5]],
        turned: None,
        command: by_kind(12, Dimension::FORCE, Dimension::MOMENT),
        momentum: by_kind(18, impulse(Dimension::FORCE), impulse(Dimension::MOMENT)),
        dofs: model.dofs.clone(),
        // without a weight the formulas of trim would vanish
        weight: model.weight.max(1.0),
        channels: channels.iter().enumerate().map(|(k, name)| (name.clone(), input(k + 1, Dimension::ONE))).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Coriolis, SingleThruster, ThrusterLoss, catalogue};
    use crate::model::places_of;

    /// Degrees of freedom in which effects act, by the meaning of their formulas.
    #[test]
    fn effects_act_where_their_formulas_do() {
        let model = Model::new(&Dof::ALL, Coriolis::Tied);
        let of = |id: &str| {
            let effect = catalogue(Coriolis::Tied).into_iter().find(|e| e.about().id == id).unwrap();
            acts_in(effect.as_ref(), places_of(effect.as_ref(), &Dof::ALL)[0], &model)
        };
        use Dof::*;
        assert_eq!(of("coriolis_pitch"), [Pitch]);
        assert_eq!(of("sensor_gyro_scale"), [Yaw]);
        assert_eq!(of("sensor_compass_deviation"), [Yaw]);
        assert_eq!(of("sensor_tilt_offset"), [Roll, Pitch]);
        assert_eq!(of("sensor_dvl_lever_arm"), [Surge, Sway]);
        assert_eq!(of("sensor_dvl_scale"), [Surge, Sway, Heave]);
        assert_eq!(of("tether_spring"), [Surge, Sway, Heave]);
        assert_eq!(of("trim_offset"), [Roll, Pitch, Yaw]);
        assert_eq!(of("fluid_memory"), [Surge], "at the first of its places");
        assert_eq!(of("current"), Dof::ALL);
        assert_eq!(of("thrust_delay"), Dof::ALL);
        assert_eq!(of("thrust_lag"), Dof::ALL);
    }

    /// Channels that a sensor alters, and velocities that its memory follows.
    #[test]
    fn sensors_alter_their_channels_and_memories_follow_velocities() {
        use Dof::*;
        let model = Model::new(&[Surge, Sway, Yaw], Coriolis::Tied);
        let of = |id: &str| {
            let effect = catalogue(Coriolis::Tied).into_iter().find(|e| e.about().id == id).unwrap();
            let place = places_of(effect.as_ref(), &model.dofs)[0];
            (alters(effect.as_ref(), place, &model), follows(effect.as_ref(), place, &model))
        };
        assert_eq!(of("sensor_position_delay"), (vec!["x", "y"], vec![Surge, Sway]));
        assert_eq!(of("sensor_dvl_delay").1, [Surge, Sway]);
        assert_eq!(of("sensor_gyro_lag"), (vec!["r"], vec![Yaw]));
        assert_eq!(of("sensor_compass_deviation"), (vec!["psi"], vec![]));
        assert_eq!(of("fluid_memory"), (vec![], vec![Surge]));
        assert_eq!(of("thrust_lag"), (vec![], vec![]));
    }

    #[test]
    fn a_single_thruster_acts_where_it_pushes() {
        let wrench = [0.0, 1.0, 0.0, 0.0, 0.0, 0.4];
        let thruster = SingleThruster { name: "bow".into(), channel: "F1".into(), unit_wrench: wrench, wrench };
        let loss = ThrusterLoss::of(thruster);
        let of = |dofs: &[Dof]| acts_in(&loss, Place::VEHICLE, &Model::new(dofs, Coriolis::Tied));
        assert_eq!(of(&Dof::ALL), [Dof::Sway, Dof::Yaw]);
        assert_eq!(of(&[Dof::Surge, Dof::Heave]), []);
    }
}
