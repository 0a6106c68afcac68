//! The chain command → actuator → body → sensor → log of a model, as formulas.
//!
//! ```text
//! τ  = actuators(command)
//! ν_r = ν − Rᵀ(φ, θ, ψ) V_water
//! d π(ν_r)/dt = w(ν_r, η) + τ          solved for ν̇ in `chain/accelerate`; Coriolis terms are in w
//! η̇  = J(η) ν            attitude by angles, or by a quaternion near the vertical
//! log = sensors(ν, η)
//! ```
//!
//! The whole momentum, including that of the dry vehicle, is computed in the frame that moves with
//! the water: [`effects::current`](crate::effects) explains why the mass of the rigid body alone is
//! not needed.
//!
//! The formulas are assembled once, here; the simulator, its sensitivities and the regressor
//! compile what they need.

mod accelerate;
mod attitude;
mod nature;
mod sense;
mod touched;

use std::collections::{BTreeMap, BTreeSet};

use crate::effects::{CommandDelay, Instant, Scope, Six};
use crate::frame::Dof;
use crate::model::{Model, Term};
use crate::navigation::upright;
use crate::symbolic::{Expr, Graph, Lateness, Leaf};
use crate::units::Dimension;

pub use attitude::{Attitude, turns_freely};
pub use nature::{Nature, nature, nature_at};
pub use touched::{acts_in, alters, delays_thrust, follows, memory_count, reads_time};

/// Kind of a simulated state. Its [`Leaf::State`] index is fixed: ν, then η, then memory. The
/// components of a quaternion have the indices 9 to 12, in place of the angles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum StateId {
    /// Velocity or rate in a degree of freedom.
    Velocity(Dof),
    /// Position or angle of the same index.
    Position(Dof),
    /// Component of the attitude quaternion, in the order w, x, y, z.
    Quaternion(u8),
    /// State `index` of the term `term`.
    Memory {
        /// Index of the term.
        term: u16,
        /// Index among its states.
        index: u16,
    },
}

impl StateId {
    /// Name of the log column of the state; `None` for memory and the quaternion.
    pub fn channel(self) -> Option<&'static str> {
        match self {
            StateId::Velocity(dof) => Some(dof.velocity()),
            StateId::Position(dof) => Some(dof.position()),
            StateId::Quaternion(_) | StateId::Memory { .. } => None,
        }
    }
}

/// Leaf index of the first component of a quaternion, and of the first memory state.
const FIRST_COMPONENT: usize = 9;
const FIRST_MEMORY: usize = 13;

/// Channels and options of the equations, besides the model.
#[derive(Debug, Clone, Default)]
pub struct Available {
    /// Channels that every run has.
    pub channels: BTreeSet<String>,
    /// Whether the position (x, y, z) is simulated, as is done when it is measured independently;
    /// otherwise it is read from the log.
    pub position: bool,
    /// Whether velocities and positions are all read from the log, so that only memory is simulated.
    pub from_log: bool,
    /// Representation of the attitude.
    pub attitude: Attitude,
}

/// The assembled formulas of a model.
#[derive(Debug)]
pub struct Equations<'g> {
    /// Simulated states, each with its leaf, its time derivative and, for memory, its quasi-steady value.
    pub states: Vec<State<'g>>,
    /// Predictions of the sensors, by column name: the simulated states, and the observed functions
    /// of them.
    pub logged: Vec<(String, Expr<'g>)>,
    /// π(ν_r), kg·m/s and kg·m²/s.
    pub momentum: Six<'g>,
    /// w + τ: the total force on the vehicle, which changes the momentum, N and N·m.
    pub force: Six<'g>,
    /// Terms that move the water, by their index.
    pub waters: Vec<usize>,
    /// Contribution of each term to the wrench, by the index of the term; actuators are in the last entry.
    pub components: Vec<(Option<usize>, Six<'g>)>,
    /// Input channels, by the index of their leaf.
    pub inputs: Vec<String>,
}

/// One simulated state.
#[derive(Debug, Clone, Copy)]
pub struct State<'g> {
    /// Its kind.
    pub id: StateId,
    /// Its leaf.
    pub leaf: Leaf,
    /// Its time derivative.
    pub rate: Expr<'g>,
    /// Its value in quasi-steady motion; memory only.
    pub start: Option<Expr<'g>>,
}

/// Registers channels at their first use.
struct Inputs<'g, 'a> {
    graph: &'g Graph,
    available: &'a Available,
    names: Vec<String>,
}

impl<'g> Inputs<'g, '_> {
    fn index(&mut self, name: &str) -> u16 {
        let known = self.names.iter().position(|n| n == name);
        known.unwrap_or_else(|| {
            self.names.push(name.to_string());
            self.names.len() - 1
        }) as u16
    }

    /// The channel's leaf; 0 if the log has no such channel.
    fn read(&mut self, name: &str, dimension: Dimension) -> Expr<'g> {
        if !self.available.channels.contains(name) {
            return self.graph.zero();
        }
        let index = self.index(name);
        self.graph.leaf(Leaf::Input(index), dimension)
    }
}

fn velocity_dimension(dof: Dof) -> Dimension {
    if dof.is_rotation() { Dimension::RATE } else { Dimension::VELOCITY }
}

fn force_dimension(dof: Dof) -> Dimension {
    if dof.is_rotation() { Dimension::MOMENT } else { Dimension::FORCE }
}

/// Assembles the equations of `model` in `graph`.
pub fn assemble<'g>(graph: &'g Graph, model: &Model, available: &Available) -> Equations<'g> {
    let mut inputs = Inputs { graph, available, names: Vec::new() };
    let simulated = |dof: Dof| model.dofs.contains(&dof) && !available.from_log;
    let state = |index: usize, dimension| graph.leaf(Leaf::State(index as u16), dimension);

    let nu: Six<'g> = Dof::ALL.map(|dof| match simulated(dof) {
        true => state(dof.index(), velocity_dimension(dof)),
        false => inputs.read(dof.velocity(), velocity_dimension(dof)),
    });
    let mut components = |read: bool| -> [Expr<'g>; 4] {
        std::array::from_fn(|k| match read {
            true => inputs.read(upright::LOGGED[k], Dimension::ONE),
            false => state(FIRST_COMPONENT + k, Dimension::ONE),
        })
    };
    let logs_attitude = available.channels.contains(upright::LOGGED[0]);
    let upright =
        available.attitude == Attitude::Quaternion && turns_freely(model) && (logs_attitude || !available.from_log);
    let quaternion = upright.then(|| components(available.from_log));
    let measured = quaternion.filter(|_| logs_attitude).map(|_| components(true));
    let turned = quaternion.map(attitude::rotation);
    let angles = turned.as_ref().map(attitude::angles);
    let pose: Six<'g> = Dof::ALL.map(|dof| {
        if let (Some(angles), true) = (angles, dof.is_rotation()) {
            return angles[dof.index() - 3];
        }
        let dimension = if dof.is_rotation() { Dimension::ONE } else { Dimension::LENGTH };
        match if dof.is_rotation() { simulated(dof) } else { available.position && simulated(dof) } {
            true => state(6 + dof.index(), dimension),
            false => inputs.read(dof.position(), dimension),
        }
    });
    let parameters: Vec<Expr<'g>> = (0..model.parameters.len())
        .map(|p| graph.leaf(Leaf::Parameter(p as u16), model.parameters[p].spec.dimension))
        .collect();
    let theta =
        |term: usize| -> Vec<Expr<'g>> { model.terms[term].parameters.iter().map(|p| parameters[*p]).collect() };

    let mut channels = BTreeMap::new();
    let read = model.terms.iter().flat_map(|term| term.effect.channels(term.place));
    for name in read.chain(model.observers.iter().flat_map(crate::effects::Observer::channels)) {
        let leaf = inputs.read(&name, Dimension::ONE);
        channels.insert(name, leaf);
    }
    let lengths = [crate::effects::channel::ANCHOR_NORTH, crate::effects::channel::ANCHOR_EAST];
    for name in lengths {
        if channels.contains_key(name) {
            channels.insert(name.to_string(), inputs.read(name, Dimension::LENGTH));
        }
    }

    let command = commands(graph, &mut inputs, None);
    let mut at = Instant {
        graph,
        time: graph.leaf(Leaf::Input(inputs.index("t")), Dimension::TIME),
        nu,
        nu_r: nu,
        nu_logged: nu,
        position: [pose[0], pose[1], pose[2]],
        attitude: [pose[3], pose[4], pose[5]],
        turned,
        command,
        momentum: [graph.zero(); 6],
        dofs: model.dofs.clone(),
        weight: model.weight,
        channels,
    };

    let waters = through_the_water(&mut at, model, &theta, available.from_log);
    if model.through_water {
        at.nu_logged = at.nu_r;
    }
    for (k, term) in model.terms.iter().enumerate() {
        let mut momentum = at.momentum;
        term.effect.momentum(&at, term.place, &theta(k), &mut momentum);
        at.momentum = momentum;
    }

    let mut memory = Vec::new();
    let tau = actuate(&at, model, &theta, &parameters, &mut inputs, &mut memory);
    let mut components = Vec::new();
    let mut remembered = Vec::new();
    let mut force = tau;
    for (k, term) in model.terms.iter().enumerate() {
        let mut wrench = [graph.zero(); 6];
        let states = remember(&at, model, k, &theta(k), &at.command, (&mut inputs, &mut memory), false);
        term.effect.wrench(&at, term.place, &theta(k), &states, &mut wrench);
        for i in 0..6 {
            if let Some(blend) = term.blend {
                wrench[i] = parameters[blend] * wrench[i];
            }
            force[i] += wrench[i];
        }
        components.push((Some(k), wrench));
        remembered.push(states);
    }
    components.push((None, tau));

    let mut states = Vec::new();
    let rates = attitude::kinematics(&at);
    for dof in Dof::ALL {
        let leaf = Leaf::State(6 + dof.index() as u16);
        if pose[dof.index()].leaves() == [leaf] {
            states.push(State { id: StateId::Position(dof), leaf, rate: rates[dof.index()], start: None });
        }
    }
    if let (Some(q), false) = (quaternion, available.from_log) {
        for (k, rate) in attitude::quaternion_rate(q, &at.nu).into_iter().enumerate() {
            let leaf = Leaf::State((FIRST_COMPONENT + k) as u16);
            states.push(State { id: StateId::Quaternion(k as u8), leaf, rate, start: None });
        }
    }
    if !available.from_log {
        let accelerations = accelerate::accelerations(&at, &force, &states, &inputs.names);
        let velocity = |(dof, rate): (&Dof, Expr<'g>)| State {
            id: StateId::Velocity(*dof),
            leaf: Leaf::State(dof.index() as u16),
            rate,
            start: None,
        };
        states.splice(0..0, model.dofs.iter().zip(accelerations).map(velocity));
    }
    states.extend(memory);
    if let Some(pace) = pace(graph, model, &theta, &parameters) {
        states.iter_mut().for_each(|state| state.rate = pace * state.rate);
    }

    let logged = sense::sense(&at, model, (&theta, &parameters), &remembered, &pose, quaternion.zip(measured));
    Equations { states, logged, waters, momentum: at.momentum, force, components, inputs: inputs.names }
}

/// Seconds of the vehicle in a second of the log, 1 − δ, if the clock of the log drifts.
fn pace<'g>(
    graph: &'g Graph,
    model: &Model,
    theta: &dyn Fn(usize) -> Vec<Expr<'g>>,
    parameters: &[Expr<'g>],
) -> Option<Expr<'g>> {
    let one = graph.constant(1.0);
    let drifts = model.terms.iter().enumerate().filter_map(|(k, term)| {
        let Some(CommandDelay::Growing(index)) = term.effect.delays_command() else { return None };
        let pace = one - theta(k)[index];
        Some(term.blend.map_or(pace, |blend| one + parameters[blend] * (pace - one)))
    });
    drifts.reduce(|all, next| all * next)
}

/// The nominal forces in the log, including those of degrees of freedom that are not modelled,
/// delayed if they are late.
fn commands<'g>(graph: &'g Graph, inputs: &mut Inputs<'g, '_>, late: Option<Lateness>) -> Six<'g> {
    Dof::ALL.map(|dof| {
        if !inputs.available.channels.contains(dof.force()) {
            return graph.zero();
        }
        let input = inputs.index(dof.force());
        let leaf = match late {
            None => Leaf::Input(input),
            Some(late) => Leaf::Delayed { input, late },
        };
        graph.leaf(leaf, force_dimension(dof))
    })
}

/// Computes ν_r = ν − Rᵀ V for the sum of the velocities of all waters, in the directions in which
/// ν is simulated or logged; ν = ν_r + Rᵀ V if the log contains the velocity through the water.
/// Returns the terms that move the water.
fn through_the_water<'g>(
    at: &mut Instant<'g>,
    model: &Model,
    theta: &dyn Fn(usize) -> Vec<Expr<'g>>,
    from_log: bool,
) -> Vec<usize> {
    let mut moving = Vec::new();
    for (k, term) in model.terms.iter().enumerate() {
        if let Some(water) = term.effect.water(at, term.place, &theta(k)) {
            moving.push(k);
            for (i, v) in at.to_body(water).into_iter().enumerate() {
                let simulated = model.dofs.contains(&Dof::ALL[i]) && !from_log;
                match at.nu[i].is_zero() {
                    true => {}
                    false if model.through_water && !simulated => at.nu[i] += v,
                    false => at.nu_r[i] -= v,
                }
            }
        }
    }
    moving
}

/// The effective force: the command after all actuators.
fn actuate<'g>(
    at: &Instant<'g>,
    model: &Model,
    theta: &dyn Fn(usize) -> Vec<Expr<'g>>,
    parameters: &[Expr<'g>],
    inputs: &mut Inputs<'g, '_>,
    memory: &mut Vec<State<'g>>,
) -> Six<'g> {
    let mut tau = at.command;
    let mut at = at.clone();
    // effects that delay the command act on the command itself, so they come first; then single
    // thrusters, whose forces are the command; then effects on the force
    let order = |term: &Term| match term.effect.about().scope {
        _ if term.effect.delays_command().is_some() => 0,
        Scope::Thrusters => 1,
        _ => 2,
    };
    let mut terms: Vec<(usize, &Term)> = model.terms.iter().enumerate().collect();
    terms.sort_by_key(|(_, term)| order(term));
    let mut late = Lateness::default();
    for (k, term) in terms {
        let before = tau;
        if let Some(delay) = term.effect.delays_command() {
            let later = delay.added_to(late, &term.parameters);
            tau = commands(at.graph, inputs, Some(later));
            late_thrusters(&mut at, model, inputs, later, term.blend.map(|blend| parameters[blend]));
            // what is only blended in delays nothing else
            late = if term.blend.is_none() { later } else { late };
        }
        let at = &at;
        let states = remember(at, model, k, &theta(k), &before, (&mut *inputs, &mut *memory), true);
        term.effect.actuate(at, term.place, &theta(k), &states, &mut tau);
        if let Some(blend) = term.blend {
            for i in 0..6 {
                tau[i] = before[i] + parameters[blend] * (tau[i] - before[i]);
            }
        }
    }
    tau
}

/// Delays the forces of single thrusters that the model reads, like the whole command.
fn late_thrusters<'g>(
    at: &mut Instant<'g>,
    model: &Model,
    inputs: &mut Inputs<'g, '_>,
    late: Lateness,
    blend: Option<Expr<'g>>,
) {
    let single = model.terms.iter().filter(|term| term.effect.about().scope == Scope::Thrusters);
    let channels: BTreeSet<String> = single.flat_map(|term| term.effect.channels(term.place)).collect();
    for name in channels.into_iter().filter(|name| inputs.available.channels.contains(name)) {
        let leaf = Leaf::Delayed { input: inputs.index(&name), late };
        let (now, late) = (at.channel(&name), at.graph.leaf(leaf, Dimension::ONE));
        at.channels.insert(name, blend.map_or(late, |blend| now + blend * (late - now)));
    }
}

/// The memory of a term: creates its states at the first call and returns their leaves. Actuators
/// are called with the force that reaches them, all other effects afterwards.
fn remember<'g>(
    at: &Instant<'g>,
    model: &Model,
    k: usize,
    theta: &[Expr<'g>],
    tau: &Six<'g>,
    (inputs, memory): (&mut Inputs<'g, '_>, &mut Vec<State<'g>>),
    actuators: bool,
) -> Vec<Expr<'g>> {
    let term = &model.terms[k];
    if actuators != (term.effect.about().family == crate::effects::Family::Actuator) {
        return Vec::new();
    }
    let starts = term.effect.memory(at, term.place, tau);
    if starts.is_empty() {
        return Vec::new();
    }
    if let Some(channels) = &term.memory_from {
        let read = |(name, start): (&String, &Expr<'g>)| inputs.read(name, start.dimension().unwrap_or(Dimension::ONE));
        return channels.iter().zip(&starts).map(read).collect();
    }
    let base = FIRST_MEMORY + memory.len();
    let leaves: Vec<Leaf> = (0..starts.len()).map(|i| Leaf::State((base + i) as u16)).collect();
    let symbols: Vec<Expr<'g>> = leaves
        .iter()
        .zip(&starts)
        .map(|(leaf, start)| at.graph.leaf(*leaf, start.dimension().unwrap_or(Dimension::ONE)))
        .collect();
    let rates = term.effect.memory_rate(at, term.place, theta, &symbols, tau);
    for (i, (start, rate)) in starts.into_iter().zip(rates).enumerate() {
        let id = StateId::Memory { term: k as u16, index: i as u16 };
        memory.push(State { id, leaf: leaves[i], rate, start: Some(start) });
    }
    symbols
}
