//! Laws of whole models: quantities that the assembled equations conserve, and agreement of the
//! simulator with the balance that the regressor uses.

use std::collections::{BTreeMap, BTreeSet};

use hydrosysid::chain::{Available, Equations, StateId, assemble};
use hydrosysid::dynamics::Dynamics;
use hydrosysid::effects::{Coriolis, Family, GridUnit, ParameterKind, catalogue};
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model, name_of, places_of};
use hydrosysid::run::{Run, Signal};
use hydrosysid::simulate::{Track, free_run};
use hydrosysid::symbolic::{Expr, Graph, Leaf};
use proptest::prelude::*;

/// Power Σᵢ νᵢ wᵢ of the wrenches of the chosen terms, W.
fn power(equations: &Equations<'_>, model: &Model, chosen: &dyn Fn(&str) -> bool, read: &dyn Fn(Leaf) -> f64) -> f64 {
    let nu = |i: usize| read(Leaf::State(i as u16));
    let of = |six: &[Expr<'_>; 6]| (0..6).map(|i| nu(i) * six[i].evaluate(read)).sum::<f64>();
    let terms = equations.components.iter().filter(|(k, _)| k.is_some_and(|k| chosen(&model.terms[k].name())));
    terms.map(|(_, wrench)| of(wrench)).sum()
}

fn with(effects: &[&str]) -> Model {
    let mut model = Model::with_effects(&Dof::ALL, Coriolis::Tied, effects).expect("catalogue effects");
    model.weight = 1854.1;
    model
}

fn available() -> Available {
    let names = Dof::ALL.iter().map(|d| d.force().to_string());
    let others = ["t", "supply_voltage_ratio", "anchor_north", "anchor_east"].map(String::from);
    let amplitudes = Dof::ALL.iter().map(|d| format!("KC_{}", d.velocity()));
    Available { channels: names.chain(others).chain(amplitudes).collect(), position: true, ..Available::default() }
}

proptest! {
    /// Tied Coriolis terms do no work: ν·(ν ×* π) = 0. The tolerance is 1e-13 of the terms that cancel.
    #[test]
    fn law_tied_coriolis_terms_do_no_work(x in prop::array::uniform12(-2.0f64..2.0), m in prop::array::uniform12(1.0f64..900.0)) {
        let model = with(&["inertia", "added_mass_coupling@surge:pitch", "added_mass_coupling@sway:roll",
            "added_mass_coupling@heave:yaw", "coriolis_surge", "coriolis_sway", "coriolis_heave", "coriolis_roll",
            "coriolis_pitch", "coriolis_yaw"]);
        let graph = Graph::new();
        let equations = assemble(&graph, &model, &available());
        let read = |leaf| match leaf {
            Leaf::State(k) => x[usize::from(k)],
            Leaf::Parameter(k) => m[usize::from(k)],
            _ => 0.0,
        };
        let total = power(&equations, &model, &|name| name.starts_with("coriolis"), &read);
        let parts: f64 = ["coriolis_surge", "coriolis_sway", "coriolis_heave", "coriolis_roll", "coriolis_pitch", "coriolis_yaw"]
            .iter().map(|row| power(&equations, &model, &|name| name == *row, &read).abs()).sum();
        prop_assert!(total.abs() <= 1e-13 * parts.max(1.0), "{total} W of {parts} W");
    }

    /// Restoring forces, trim and the spring of the tether have a potential: their power is minus
    /// its rate along the motion that the kinematics give.
    #[test]
    fn law_restoring_forces_conserve(nu in prop::array::uniform6(-2.0f64..2.0), at in prop::array::uniform6(-1.2f64..1.2),
                                     net in -200.0f64..200.0, righting in -300.0f64..300.0, k in 0.0f64..50.0) {
        let restoring = ["restoring_surge", "restoring_sway", "restoring_heave", "restoring_roll", "restoring_pitch",
            "trim_offset", "tether_spring"];
        let mut model = with(&["inertia"]);
        for effect in restoring {
            model.add_named(effect).expect("stands in six degrees of freedom");
        }
        for (name, value) in [("restoring_surge", net), ("restoring_roll", righting), ("tether_spring", k)] {
            model.set(name, value);
        }
        for (symbol, value) in [("x_g", 0.01), ("y_g", -0.02)] {
            let p = model.parameter("trim_offset", symbol).expect("trim has it");
            model.parameters[p].value = value;
        }
        let theta = model.values();
        let graph = Graph::new();
        let equations = assemble(&graph, &model, &available());
        let read = |leaf| match leaf {
            Leaf::State(k) if k < 6 => nu[usize::from(k)],
            Leaf::State(k) => at[usize::from(k) - 6],
            Leaf::Parameter(k) => theta[usize::from(k)],
            _ => 0.0,
        };
        // potential, J, as a function of the position
        let potential = |eta: &[f64]| {
            let (x, y, z, phi, pitch) = (eta[0], eta[1], eta[2], eta[3], eta[4]);
            let down = [-pitch.sin(), pitch.cos() * phi.sin(), pitch.cos() * phi.cos()];
            -net * z - righting * down[2] - 1854.1 * (0.01 * down[0] - 0.02 * down[1]) + 0.5 * k * (x * x + y * y)
        };
        let rate = |dof: Dof| {
            let state = equations.states.iter().find(|s| s.id == StateId::Position(dof)).expect("positions are simulated");
            state.rate.evaluate(&read)
        };
        let found = power(&equations, &model, &|name| name != "inertia", &read);
        let h = 1e-4;
        let moved = |by: f64| Dof::ALL.map(|dof| at[dof.index()] + by * rate(dof));
        let lost = (potential(&moved(-h)) - potential(&moved(h))) / (2.0 * h);
        // central differences: h²/6 times third derivatives of about 1e4 W/s², with rates up to 10
        // because of tan θ
        prop_assert!((found - lost).abs() <= 1e-3 + 2e-6 * found.abs().max(2000.0), "{found} W against {lost} W");
    }
}

/// A run with slow sinusoidal forces of different periods in all six degrees of freedom, long
/// enough to turn and to go astern.
fn a_run(seconds: f64, step: f64) -> Run {
    let n = (seconds / step).round() as usize;
    let time: std::sync::Arc<[f64]> = (0..=n).map(|k| step * k as f64).collect();
    let mut run = Run { name: "made".into(), ..Run::default() };
    let mut put = |name: &str, value: &dyn Fn(f64) -> f64| {
        let values: Vec<f64> = time.iter().map(|t| value(*t)).collect();
        run.signals.insert(name.into(), Signal::new(time.clone(), values));
    };
    for dof in Dof::ALL {
        let i = dof.index() as f64;
        let size = if dof.is_rotation() { 20.0 } else { 120.0 };
        put(dof.force(), &|t| size * (0.3 + (t * (0.9 + 0.2 * i) + i).sin()));
        put(dof.velocity(), &|_| 0.0);
        put(dof.position(), &|_| 0.0);
        put(&format!("KC_{}", dof.velocity()), &|_| 1.5);
    }
    put("supply_voltage_ratio", &|t| 1.0 - 0.02 * t);
    put("anchor_north", &|_| 1.0);
    put("anchor_east", &|_| -1.0);
    run
}

/// A baseline in six degrees of freedom, of a vehicle of some 300 kg, without `effect`.
fn baseline(effect: &str) -> Model {
    let mut model = with(&["inertia", "linear_drag", "quadratic_drag", "restoring_roll", "restoring_pitch"]);
    if let Some(known) = model.term(effect) {
        model.remove(known);
    }
    for dof in Dof::ALL {
        let i = dof.index() as f64;
        let scale = if dof.is_rotation() { 0.2 } else { 1.0 };
        model.set(&format!("inertia@{dof}"), scale * (260.0 + 40.0 * i));
        model.set(&format!("linear_drag@{dof}"), scale * 60.0);
        model.set(&format!("quadratic_drag@{dof}"), scale * 110.0);
    }
    model.set("restoring_roll", 150.0);
    model
}

/// Sets the parameters of the last term away from neutral, small against the baseline.
fn turn_on(model: &mut Model, name: &str) {
    let term = model.term(name).expect("it was added");
    let id = model.terms[term].effect.about().id.to_string();
    for p in model.terms[term].parameters.clone() {
        let family = model.terms[term].effect.about().family;
        let parameter = &mut model.parameters[p];
        parameter.value = match &parameter.spec.kind {
            ParameterKind::Linear if family == Family::Actuator => parameter.spec.neutral - 0.15,
            ParameterKind::Linear if family == Family::Sensor => 0.03,
            ParameterKind::Linear if id == "trim_offset" => 0.02,
            ParameterKind::Linear if id == "inertia" => 200.0,
            ParameterKind::Linear => 7.0,
            ParameterKind::Shape { grid, .. } if parameter.spec.grid_in == GridUnit::GreatestCommand => 60.0 * grid[0],
            ParameterKind::Shape { grid, .. } => grid[grid.len() / 2] + 0.1,
        };
    }
}

/// The largest imbalance |π(b) − π(a) − ∫ (w + τ) dt| over the run and the degrees of freedom,
/// relative to ∫ |w + τ| dt; and the largest difference between the simulated outputs and the
/// sensors' formulas of the states.
fn imbalance(model: &Model, run: &Run, observed: &BTreeSet<String>) -> (f64, f64) {
    let available = available_in(run);
    let dynamics = Dynamics::compile(model, &available, observed, &[]);
    let theta = model.values();
    let track = Track::new(run, 0, &dynamics, &theta, Interpolation::Linear, 10.0).expect("the run has every channel");
    let x0 = vec![0.1; dynamics.states.len()];
    let trajectory = free_run(&dynamics, &track, &theta, &x0, 0, track.time.len() - 1);
    let graph = Graph::new();
    let equations = assemble(&graph, model, &available);
    let place: BTreeMap<Leaf, usize> = equations
        .states
        .iter()
        .filter_map(|s| Some((s.leaf, dynamics.states.iter().position(|id| *id == s.id)?)))
        .collect();
    let (nx, slots) = (dynamics.states.len(), dynamics.inputs.len());
    let read = |k: usize, leaf: Leaf| match leaf {
        Leaf::State(_) => trajectory.states[k * nx + place[&leaf]],
        Leaf::Parameter(p) => theta[usize::from(p)],
        _ => {
            let known = dynamics.inputs.iter().position(|(l, _)| *l == leaf);
            known.map_or_else(
                || match leaf {
                    Leaf::Input(c) => run.signals[&equations.inputs[usize::from(c)]].values()[k],
                    _ => panic!("the balance reads {leaf:?}, which the rates do not"),
                },
                |slot| track.inputs_at[k * slots + slot],
            )
        }
    };
    let (mut worst, mut sensed) = (0.0f64, 0.0f64);
    // seconds of the vehicle in a second of the log
    let pace = model.value("sensor_clock_drift").map_or(1.0, |drift| 1.0 - drift);
    for dof in &model.dofs {
        let i = dof.index();
        let force: Vec<f64> = (0..track.time.len()).map(|k| equations.force[i].evaluate(&|l| read(k, l))).collect();
        let pi = |k: usize| equations.momentum[i].evaluate(&|l| read(k, l));
        let (start, mut integral, mut size) = (pi(0), 0.0, 0.0);
        for k in 1..force.len() {
            let h = track.time[k] - track.time[k - 1];
            integral += 0.5 * h * pace * (force[k] + force[k - 1]);
            size += 0.5 * h * (force[k].abs() + force[k - 1].abs());
            worst = worst.max((pi(k) - start - integral).abs() / (size + 1.0));
        }
    }
    let ny = dynamics.outputs.len();
    for (name, formula) in equations.logged.iter().filter(|(name, _)| observed.contains(name)) {
        let column = dynamics.outputs.iter().position(|n| n == name).expect("it is observed");
        for k in 0..track.time.len() {
            sensed = sensed.max((trajectory.outputs[k * ny + column] - formula.evaluate(&|l| read(k, l))).abs());
        }
    }
    (worst, sensed)
}

fn available_in(run: &Run) -> Available {
    let mut channels: BTreeSet<String> = run.signals.keys().cloned().collect();
    channels.insert("t".into());
    Available { channels, position: true, ..Available::default() }
}

/// For every effect, the simulator integrates the balance. Over 6 s at 200 Hz, the trapezoid of a
/// force that changes within 0.3 s has an error of about 1e-5; a dead band, the edge of a fault
/// (0.05 s) and a change of direction add a little. A wrong sign or a forgotten term would give
/// 1e-2.
#[test]
fn law_round_trip_of_every_effect() {
    let run = a_run(6.0, 0.005);
    let observed: BTreeSet<String> =
        Dof::ALL.iter().flat_map(|d| [d.velocity(), d.position()]).map(String::from).collect();
    for coriolis in [Coriolis::Tied, Coriolis::Free] {
        let all = catalogue(coriolis);
        // only these differ with free Coriolis terms
        let differ = |id: &str| coriolis == Coriolis::Tied || id.starts_with("coriolis");
        for effect in all.into_iter().filter(|e| differ(e.about().id)) {
            for place in places_of(effect.as_ref(), &Dof::ALL) {
                let name = name_of(effect.about().id, place);
                let mut model = baseline(&name);
                model.coriolis = coriolis;
                model.add(effect.clone(), place).expect("it may stand there");
                turn_on(&mut model, &name);
                let (worst, sensed) = imbalance(&model, &run, &observed);
                assert!(worst < 3e-4, "{name}: the balance is off by {worst}");
                assert!(sensed < 1e-9, "{name}: the log is off by {sensed}");
            }
        }
    }
}

/// A velocity that is logged and not simulated also has momentum: the simulator takes its
/// acceleration from the interpolation of the log.
#[test]
fn law_round_trip_with_logged_velocities() {
    let mut run = a_run(6.0, 0.005);
    let time = run.signals["u"].shared_time().clone();
    for (name, size) in [("w", 0.2), ("q", 0.1)] {
        let values: Vec<f64> = time.iter().map(|t| size * (0.8 * t).sin()).collect();
        run.signals.insert(name.into(), Signal::new(time.clone(), values));
    }
    let planar = [Dof::Surge, Dof::Sway, Dof::Yaw];
    let effects = [
        "inertia",
        "linear_drag",
        "added_mass_coupling@surge:pitch",
        "coriolis_surge",
        "coriolis_sway",
        "coriolis_yaw",
        "mixed_drag@surge:heave",
    ];
    let mut model = Model::with_effects(&planar, Coriolis::Tied, &effects).expect("catalogue effects");
    for p in &mut model.parameters {
        p.value = 50.0;
    }
    for dof in planar {
        model.set(&format!("inertia@{dof}"), 300.0);
    }
    let observed = ["u", "v", "r"].map(String::from).into();
    let (worst, _) = imbalance(&model, &run, &observed);
    assert!(worst < 1e-4, "the balance is off by {worst}");
}
