//! Laws that every effect of the catalogue must obey; they are checked on its formulas.

use std::collections::BTreeSet;
use std::sync::Arc;

use hydrosysid::chain::{Nature, nature_at};
use hydrosysid::effects::{
    Coriolis, Effect, Family, Instant, Logged, ParameterKind, ParameterSpec, Place, SingleThruster, Six,
    ThrusterAdvanceLoss, ThrusterLoss, ThrusterSwap, catalogue,
};
use hydrosysid::frame::Dof;
use hydrosysid::model::{Model, name_of, places_of};
use hydrosysid::symbolic::{Expr, Graph, Leaf};
use hydrosysid::units::Dimension;
use proptest::prelude::*;

mod galilei;

/// Ids of the catalogue that users and other programs use.
const IDS: [&str; 63] = [
    "inertia",
    "added_mass_coupling",
    "added_mass_amplitude",
    "fluid_memory",
    "coriolis_surge",
    "coriolis_sway",
    "coriolis_heave",
    "coriolis_roll",
    "coriolis_pitch",
    "coriolis_yaw",
    "linear_drag",
    "quadratic_drag",
    "cubic_drag",
    "drag_asymmetry",
    "coulomb_friction",
    "linear_cross_damping",
    "cross_drag",
    "even_drag",
    "mixed_drag",
    "lift_moment",
    "restoring_surge",
    "restoring_sway",
    "restoring_heave",
    "restoring_roll",
    "restoring_pitch",
    "bias",
    "trim_offset",
    "thrust_interaction_loss",
    "thrust_advance_loss",
    "thrust_reverse_loss",
    "thrust_deadband",
    "thrust_saturation",
    "thrust_lag",
    "thrust_delay",
    "thrust_crosstalk",
    "thruster_fault",
    "thruster_loss",
    "thruster_swap",
    "supply_voltage",
    "propeller_advance",
    "rudder_force",
    "stern_plane_force",
    "rudder_drag",
    "stern_plane_drag",
    "current",
    "earth_force",
    "tether_spring",
    "tether_drag",
    "wave",
    "sensor_gyro_bias",
    "sensor_gyro_scale",
    "sensor_heading_offset",
    "sensor_tilt_offset",
    "sensor_compass_magnetic",
    "sensor_dvl_lever_arm",
    "sensor_compass_deviation",
    "sensor_dvl_misalignment",
    "sensor_dvl_scale",
    "sensor_dvl_delay",
    "sensor_gyro_lag",
    "sensor_position_delay",
    "sensor_delay",
    "sensor_clock_drift",
];

const FORCES: [Dimension; 6] =
    [Dimension::FORCE, Dimension::FORCE, Dimension::FORCE, Dimension::MOMENT, Dimension::MOMENT, Dimension::MOMENT];

fn velocity(i: usize) -> Dimension {
    if i < 3 { Dimension::VELOCITY } else { Dimension::RATE }
}

/// An instant whose quantities are leaves of the graph: states 0 to 5 are ν, 6 to 11 η, from 12 on
/// the memories; input 0 is the time, inputs 1 to 6 the commands, 7 to 12 the total momentum, from
/// 13 on the channels.
fn instant<'g>(graph: &'g Graph, effect: &dyn Effect, place: Place) -> Instant<'g> {
    let state = |k: usize, dimension| graph.leaf(Leaf::State(k as u16), dimension);
    let input = |k: usize, dimension| graph.leaf(Leaf::Input(k as u16), dimension);
    let nu: Six<'g> = std::array::from_fn(|i| state(i, velocity(i)));
    let channels = effect.channels(place).into_iter().enumerate().map(|(k, name)| {
        let dimension = if name.starts_with("anchor") { Dimension::LENGTH } else { Dimension::ONE };
        (name, input(13 + k, dimension))
    });
    Instant {
        graph,
        time: input(0, Dimension::TIME),
        nu,
        nu_r: nu,
        nu_logged: nu,
        position: std::array::from_fn(|i| state(6 + i, Dimension::LENGTH)),
        attitude: std::array::from_fn(|i| state(9 + i, Dimension::ONE)),
        turned: None,
        command: std::array::from_fn(|i| input(1 + i, FORCES[i])),
        momentum: std::array::from_fn(|i| input(7 + i, FORCES[i].times(Dimension::TIME))),
        dofs: Dof::ALL.to_vec(),
        weight: 1854.1,
        channels: channels.collect(),
    }
}

/// All formulas of an effect at an instant, by method of the effect.
struct Said<'g> {
    momentum: Six<'g>,
    wrench: Six<'g>,
    tau: Six<'g>,
    water: Option<[Expr<'g>; 3]>,
    logged: Logged<'g>,
    memory: Vec<Expr<'g>>,
    memory_rate: Vec<Expr<'g>>,
}

fn say<'g>(effect: &dyn Effect, place: Place, at: &Instant<'g>) -> Said<'g> {
    let graph = at.graph;
    let specs = effect.parameters(place);
    let theta: Vec<_> =
        specs.iter().enumerate().map(|(k, s)| graph.leaf(Leaf::Parameter(k as u16), s.dimension)).collect();
    let zero = [graph.zero(); 6];
    let (mut momentum, mut wrench, mut tau) = (zero, zero, at.command);
    let mut logged = Logged { nu: at.nu, position: at.position, attitude: at.attitude };
    let memory = effect.memory(at, place, &at.command);
    let dimension = |e: &Expr<'g>| e.dimension().expect("a memory has a unit");
    let states: Vec<_> =
        memory.iter().enumerate().map(|(k, m)| graph.leaf(Leaf::State(12 + k as u16), dimension(m))).collect();
    effect.momentum(at, place, &theta, &mut momentum);
    effect.wrench(at, place, &theta, &states, &mut wrench);
    effect.actuate(at, place, &theta, &states, &mut tau);
    effect.sense(at, place, &theta, &states, &mut logged);
    let water = effect.water(at, place, &theta);
    let memory_rate = effect.memory_rate(at, place, &theta, &states, &at.command);
    Said { momentum, wrench, tau, water, logged, memory, memory_rate }
}

impl<'g> Said<'g> {
    /// Every formula with the dimension that it must have.
    fn formulas(&self) -> Vec<(Expr<'g>, Dimension)> {
        let mut all = Vec::new();
        for i in 0..6 {
            all.push((self.momentum[i], FORCES[i].times(Dimension::TIME)));
            all.push((self.wrench[i], FORCES[i]));
            all.push((self.tau[i], FORCES[i]));
            all.push((self.logged.nu[i], velocity(i)));
        }
        for i in 0..3 {
            all.push((self.logged.position[i], Dimension::LENGTH));
            all.push((self.logged.attitude[i], Dimension::ONE));
        }
        all.extend(self.water.into_iter().flatten().map(|v| (v, Dimension::VELOCITY)));
        for (m, rate) in self.memory.iter().zip(&self.memory_rate) {
            let dimension = m.dimension().expect("a memory has a unit");
            all.extend([(*m, dimension), (*rate, dimension.over(Dimension::TIME))]);
        }
        all
    }
}

/// The catalogue, with effects of single thrusters for two thrusters that act in all degrees of freedom.
fn with_thrusters(coriolis: Coriolis) -> Vec<Arc<dyn Effect>> {
    let thruster = |name: &str, channel: &str, wrench| SingleThruster {
        name: name.into(),
        channel: channel.into(),
        unit_wrench: wrench,
        wrench,
    };
    let port = thruster("port", "F1", [0.8, 0.6, 0.1, -0.2, 0.3, 0.5]);
    let starboard = thruster("starboard", "F2", [0.7, -0.5, 0.2, 0.2, 0.4, -0.5]);
    let advance = ThrusterAdvanceLoss::of(vec![port.clone(), starboard.clone()]);
    let advance: Arc<dyn Effect> = Arc::new(advance);
    let of_vehicle = |effect: Arc<dyn Effect>| -> Arc<dyn Effect> {
        match effect.about().id {
            ThrusterLoss::ID => Arc::new(ThrusterLoss::of(port.clone())),
            ThrusterSwap::ID => Arc::new(ThrusterSwap::of([port.clone(), starboard.clone()])),
            id if id == advance.about().id => advance.clone(),
            _ => effect,
        }
    };
    catalogue(coriolis).into_iter().map(of_vehicle).collect()
}

/// Calls `law` with every effect, tied and free, at every place in six degrees of freedom.
fn everywhere(law: &dyn Fn(&str, &dyn Effect, Place)) {
    for coriolis in [Coriolis::Tied, Coriolis::Free] {
        for effect in with_thrusters(coriolis) {
            let places = places_of(effect.as_ref(), &Dof::ALL);
            assert!(!places.is_empty(), "{} stands nowhere", effect.about().id);
            for place in places {
                law(&name_of(effect.about().id, place), effect.as_ref(), place);
            }
        }
    }
}

/// A value for a parameter that is not neutral.
fn some_value(spec: &ParameterSpec) -> f64 {
    match &spec.kind {
        ParameterKind::Linear => spec.neutral + 0.37,
        ParameterKind::Shape { grid, .. } => grid[0] + 0.11,
    }
}

fn reader<'a>(x: &'a [f64], input: &'a [f64], theta: &'a [f64]) -> impl Fn(Leaf) -> f64 + 'a {
    move |leaf| match leaf {
        Leaf::State(k) => x[usize::from(k)],
        Leaf::Input(k) => input[usize::from(k)],
        Leaf::Parameter(k) => theta[usize::from(k)],
        _ => panic!("an instant has no rates and no delays"),
    }
}

/// A state with velocities, positions and angles that are all positive.
const STATE: [f64; 18] = [0.9, 0.4, 0.3, 0.2, 0.15, 0.25, 3.0, 2.0, 5.0, 0.1, 0.2, 0.7, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
const INPUT: [f64; 16] = [1.7, 40.0, -12.0, 9.0, 3.0, -2.0, 5.0, 80.0, 30.0, 20.0, 4.0, 3.0, 2.0, 0.9, 0.4, 0.3];

/// No id of [`IDS`] is removed, because campaign files and models of users contain them, and no id
/// is used twice.
#[test]
fn the_catalogue_holds_every_id_once() {
    let found: Vec<String> = catalogue(Coriolis::Tied).iter().map(|e| e.about().id.to_string()).collect();
    let once: BTreeSet<&String> = found.iter().collect();
    assert_eq!(once.len(), found.len(), "an id stands twice: {found:?}");
    for id in IDS {
        assert!(found.iter().any(|known| known == id), "`{id}` is no longer known");
    }
}

#[test]
fn every_effect_says_what_it_is() {
    everywhere(&|name, effect, place| {
        let about = effect.about();
        for text in [about.formula, about.meaning, about.source, about.shown_by] {
            assert!(!text.is_empty(), "{name} leaves something unsaid");
        }
        let mut names: Vec<String> = effect.parameters(place).into_iter().map(|p| p.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), effect.parameters(place).len(), "{name} has two parameters of one name");
    });
}

#[test]
fn law_units_fit_at_every_place() {
    everywhere(&|name, effect, place| {
        let graph = Graph::new();
        for (formula, dimension) in say(effect, place, &instant(&graph, effect, place)).formulas() {
            if !formula.is_zero() {
                assert_eq!(formula.dimension(), Ok(dimension), "{name}: {formula:?}");
            }
        }
    });
}

#[test]
fn law_momentum_is_affine_in_the_velocity() {
    everywhere(&|name, effect, place| {
        let graph = Graph::new();
        for pi in say(effect, place, &instant(&graph, effect, place)).momentum {
            for k in 0..6 {
                let mass = pi.derivative(Leaf::State(k));
                let depends = mass.leaves().into_iter().any(|leaf| matches!(leaf, Leaf::State(_)));
                assert!(!depends, "{name}: the mass {mass:?} depends on a state");
            }
        }
    });
}

#[test]
fn law_linear_parameters_enter_linearly() {
    everywhere(&|name, effect, place| {
        let graph = Graph::new();
        let specs = effect.parameters(place);
        let linear: Vec<u16> = (0..specs.len()).filter(|k| specs[*k].is_linear()).map(|k| k as u16).collect();
        for (formula, _) in say(effect, place, &instant(&graph, effect, place)).formulas() {
            for p in &linear {
                let column = formula.derivative(Leaf::Parameter(*p));
                let again = column.leaves().into_iter().any(|l| matches!(l, Leaf::Parameter(q) if linear.contains(&q)));
                assert!(!again, "{name}: the column {column:?} reads a linear parameter");
            }
        }
    });
}

/// At the neutral values of its parameters an effect changes nothing; the tolerance of 4 ε is for
/// formulas like τ + θ·τ.
#[test]
fn law_neutral_parameters_mean_no_effect() {
    everywhere(&|name, effect, place| {
        let graph = Graph::new();
        let at = instant(&graph, effect, place);
        let said = say(effect, place, &at);
        let specs = effect.parameters(place);
        let any_linear = specs.iter().any(ParameterSpec::is_linear);
        // lags and delays vanish only in the limit; in steady motion their output is the signal
        // itself, except for a delayed position, which changes in steady motion and therefore needs
        // a vanishing delay
        let theta: Vec<f64> = specs
            .iter()
            .map(|s| match () {
                () if s.is_linear() || !any_linear && said.memory.is_empty() => s.neutral,
                () if !any_linear && !effect.pose().is_empty() => 1e-300,
                () => some_value(s),
            })
            .collect();
        if specs.is_empty() || effect.delays_command().is_some() {
            return;
        }
        let mut x = STATE.to_vec();
        for (k, m) in said.memory.iter().enumerate() {
            x[12 + k] = m.evaluate(&reader(&STATE, &INPUT, &theta));
        }
        let value = |e: Expr<'_>| e.evaluate(&reader(&x, &INPUT, &theta));
        let same = |found: Expr<'_>, without: f64| {
            let found = value(found);
            assert!((found - without).abs() <= 4.0 * f64::EPSILON * without.abs(), "{name}: {found} is not {without}");
        };
        for i in 0..6 {
            same(said.momentum[i], 0.0);
            same(said.wrench[i], 0.0);
            same(said.tau[i], value(at.command[i]));
            same(said.logged.nu[i], value(at.nu[i]));
        }
        for i in 0..3 {
            same(said.logged.position[i], value(at.position[i]));
            same(said.logged.attitude[i], value(at.attitude[i]));
        }
        said.water.into_iter().flatten().for_each(|v| same(v, 0.0));
        if said.memory.iter().any(|m| m.leaves().iter().any(|l| matches!(l, Leaf::Input(_)))) {
            said.memory_rate.iter().for_each(|rate| same(*rate, 0.0));
        }
    });
}

#[test]
fn law_an_effect_with_parameters_changes_something() {
    everywhere(&|name, effect, place| {
        let graph = Graph::new();
        let specs = effect.parameters(place);
        let formulas = say(effect, place, &instant(&graph, effect, place)).formulas();
        for p in 0..specs.len() {
            let felt = formulas.iter().any(|(f, _)| f.leaves().contains(&Leaf::Parameter(p as u16)));
            let delays = effect.delays_command().is_some_and(|delay| delay.parameter() == p);
            assert!(felt || delays, "{name}: nothing reads {}", specs[p].name);
        }
    });
}

#[test]
fn law_the_same_instant_gives_the_same_value() {
    everywhere(&|name, effect, place| {
        let theta: Vec<f64> = effect.parameters(place).iter().map(some_value).collect();
        let values = || -> Vec<u64> {
            let graph = Graph::new();
            let said = say(effect, place, &instant(&graph, effect, place)).formulas();
            said.iter().map(|(f, _)| f.evaluate(&reader(&STATE, &INPUT, &theta)).to_bits()).collect()
        };
        assert_eq!(values(), values(), "{name}");
    });
}

/// A parameter with an SNAME name has the opposite sign, as SNAME derivatives are forces on the
/// right-hand side.
#[test]
fn law_sname_names_have_the_other_sign() {
    let theta = [0.0; 4];
    everywhere(&|name, effect, place| {
        let graph = Graph::new();
        // every product of velocities is positive; the motion is astern for a term that acts only astern
        let asymmetric = effect.about().id == "drag_asymmetry";
        let state = STATE.map(|x| if asymmetric { -x } else { x });
        let said = say(effect, place, &instant(&graph, effect, place));
        for (p, spec) in effect.parameters(place).iter().enumerate().filter(|(_, s)| s.sname.is_some()) {
            let by = Leaf::Parameter(p as u16);
            let value = |e: Expr<'_>| e.derivative(by).evaluate(&reader(&state, &INPUT, &theta));
            for i in 0..6 {
                let force = value(said.wrench[i]) - value(said.momentum[i]);
                assert!(if asymmetric { force >= 0.0 } else { force <= 0.0 }, "{name}: {spec:?}");
            }
        }
    });
}

fn effect_of(id: &str) -> Arc<dyn Effect> {
    catalogue(Coriolis::Tied).into_iter().find(|e| e.about().id == id).expect("the catalogue has this id")
}

/// Whether an effect declares itself dissipative: a drag, or a force of the environment that is not
/// tied to the ground, with one parameter that may not be negative.
fn takes_power(effect: &dyn Effect, place: Place) -> bool {
    let model = Model::new(&Dof::ALL, Coriolis::Tied);
    let resists = match nature_at(effect, place, &model) {
        Nature::Drag | Nature::CrossDrag => true,
        Nature::Other => effect.about().family == Family::Environment && !effect.tied_to_ground(),
        _ => false,
    };
    let parameters = effect.parameters(place);
    resists && parameters.len() == 1 && parameters[0].least >= 0.0
}

/// [`takes_power`] selects the drags of the catalogue by their nature, and misses none.
#[test]
fn the_drags_are_known_by_what_they_are() {
    let all = catalogue(Coriolis::Tied);
    let asked = all
        .iter()
        .filter(|e| places_of(e.as_ref(), &Dof::ALL).first().is_some_and(|place| takes_power(e.as_ref(), *place)));
    let asked: Vec<String> = asked.map(|e| e.about().id.to_string()).collect();
    for drag in ["linear_drag", "quadratic_drag", "cubic_drag", "coulomb_friction", "mixed_drag", "tether_drag"] {
        assert!(asked.iter().any(|id| id == drag), "{drag} is not asked whether it takes power: {asked:?}");
    }
}

/// The sign of a force is that of its written formula: for positive arguments, a formula with a
/// minus gives a negative force for a positive parameter. The law on SNAME names checks the sign of
/// effects with such a name; this one also checks the others, such as weights and righting moments.
#[test]
fn law_the_written_sign_is_the_coded_one() {
    let theta = [0.0; 4];
    everywhere(&|name, effect, place| {
        let model = Model::new(&Dof::ALL, Coriolis::Free);
        let formula = effect.about().formula;
        let forces = [Nature::Drag, Nature::CrossDrag, Nature::Restoring, Nature::Steady];
        if formula.contains('=') || !forces.contains(&nature_at(effect, place, &model)) {
            return;
        }
        let graph = Graph::new();
        let said = say(effect, place, &instant(&graph, effect, place));
        let force = |state: &[f64]| -> f64 {
            let slope = |row: &Expr<'_>| row.derivative(Leaf::Parameter(0)).evaluate(&reader(state, &INPUT, &theta));
            said.wrench.iter().map(slope).sum()
        };
        let written = if formula.starts_with('−') { -1.0 } else { 1.0 };
        // a term that acts only astern is evaluated there, with the opposite sign
        let coded = match force(&STATE) {
            0.0 => -force(&STATE.map(|x| -x)),
            force => force,
        };
        assert!(coded * written > 0.0, "{name}: `{formula}` is coded with the other sign");
    });
}

proptest! {
    #[test]
    fn law_drag_takes_power(nu in prop::array::uniform6(-3.0f64..3.0), depth in 0.0f64..50.0, d in 0.0f64..500.0) {
        let mut x = STATE;
        x[..6].copy_from_slice(&nu);
        x[8] = depth;
        for effect in catalogue(Coriolis::Tied) {
            for place in places_of(effect.as_ref(), &Dof::ALL).into_iter().filter(|p| takes_power(effect.as_ref(), *p)) {
                let graph = Graph::new();
                let said = say(effect.as_ref(), place, &instant(&graph, effect.as_ref(), place));
                let read = reader(&x, &INPUT, std::slice::from_ref(&d));
                let power: f64 = (0..6).map(|i| nu[i] * said.wrench[i].evaluate(&read)).sum();
                prop_assert!(power <= 0.0, "{} gives {power} W", name_of(effect.about().id, place));
            }
        }
    }

    /// The fluid memory is passive: it stores k T z²/2 and dissipates k z², that is,
    /// ν w + d(k T z²/2)/dt = −k z².
    #[test]
    fn law_fluid_memory_is_passive(v in -3.0f64..3.0, z in -3.0f64..3.0, k in 0.0f64..300.0, t in 0.1f64..30.0) {
        let effect = effect_of("fluid_memory");
        let graph = Graph::new();
        let place = Place::at(Dof::Surge);
        let said = say(effect.as_ref(), place, &instant(&graph, effect.as_ref(), place));
        let mut x = STATE;
        (x[0], x[12]) = (v, z);
        let theta = [k, t];
        let read = reader(&x, &INPUT, &theta);
        let stored = k * t * z * said.memory_rate[0].evaluate(&read);
        let balance = v * said.wrench[0].evaluate(&read) + stored + k * z * z;
        // a sum of three products of similar size, each rounded a few times
        prop_assert!(balance.abs() <= 1e-13 * (k * (v * v + z * z) + 1e-300));
    }
}

#[test]
fn effect_degree_of_freedom_and_name_say_which_parameter_is_meant() {
    for coriolis in [Coriolis::Tied, Coriolis::Free] {
        let mut seen = BTreeSet::new();
        for effect in catalogue(coriolis) {
            let id = effect.about().id.to_string();
            for place in places_of(effect.as_ref(), &Dof::ALL) {
                for spec in effect.parameters(place) {
                    let key = (id.clone(), place.dof, spec.name);
                    assert!(seen.insert(key.clone()), "{key:?} is there twice");
                }
            }
        }
    }
}
