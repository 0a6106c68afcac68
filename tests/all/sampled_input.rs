//! Inputs that are given as samples: the values that a step reads at its beginning, middle and end
//! determine the order of the scheme. Both classic mistakes (the last stage of a held input reads
//! the next sample; the middle stages read the left one) reduce the order and would show here.

use std::collections::BTreeSet;

use crate::ode_reference::{number, numbers, read};
use hydrosysid::chain::Available;
use hydrosysid::dynamics::Dynamics;
use hydrosysid::effects::Coriolis;
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model};
use hydrosysid::run::{Run, Signal};
use hydrosysid::simulate::{Track, free_run};
use serde_json::Value;

/// A model of inertia, linear and quadratic drag in one degree of freedom, with these values.
fn model(dof: Dof, values: [f64; 3]) -> Model {
    let effects = ["inertia", "linear_drag", "quadratic_drag"];
    let mut model = Model::with_effects(&[dof], Coriolis::Tied, &effects).expect("catalogue effects");
    for (effect, value) in effects.iter().zip(values) {
        assert!(model.set(&format!("{effect}@{dof}"), value));
    }
    model
}

fn laurs() -> Model {
    model(Dof::Surge, [841.93, 82.3, 309.07])
}

/// Velocity at the sample instants, from rest, with `substeps` steps in each interval.
fn simulate(model: &Model, time: &[f64], tau: &[f64], input: Interpolation, substeps: f64) -> Vec<f64> {
    observed(model, (time, tau), time, input, substeps)
}

/// The same at instants `seen` of their own.
fn observed(
    model: &Model,
    (time, tau): (&[f64], &[f64]),
    seen: &[f64],
    input: Interpolation,
    substeps: f64,
) -> Vec<f64> {
    let dof = model.dofs[0];
    let mut run = Run::default();
    run.signals.insert(dof.force().into(), Signal::new(time.into(), tau.to_vec()));
    run.signals.insert(dof.velocity().into(), Signal::new(seen.into(), vec![0.0; seen.len()]));
    let available = Available { channels: run.signals.keys().cloned().collect(), ..Available::default() };
    let observed: BTreeSet<String> = [dof.velocity().to_string()].into();
    let dynamics = Dynamics::compile(model, &available, &observed, &[]);
    let theta = model.values();
    let longest = (seen[1] - seen[0]) / substeps;
    let track = Track::new(&run, 0, &dynamics, &theta, input, longest).expect("the run has every channel");
    free_run(&dynamics, &track, &theta, &[0.0], 0, seen.len() - 1).outputs
}

/// Commands that come faster than the samples of the sensors act as they do beside fast sensors, held or as lines: no
/// step crosses an edge or a corner. Steps of 0.05 and 0.025 s agree to 2e-6 of the speed, because corners below a thousandth
/// of the command are crossed; across all corners a step of 0.067 s would be off by a hundred times that.
#[test]
fn commands_faster_than_the_sensors_are_followed() {
    let time = stamps(401, 0.1);
    let tau: Vec<f64> = (0..401).map(|k| 60.0 * (7.3 * f64::from(k * k)).sin()).collect();
    for input in [Interpolation::Hold, Interpolation::Linear] {
        let fast = simulate(&laurs(), &time, &tau, input, 4.0);
        let slow = observed(&laurs(), (&time, &tau), &stamps(101, 0.4), input, 6.0);
        let same: Vec<f64> = fast.iter().step_by(4).copied().collect();
        let size = same.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        assert!(worst(&slow, &same) < 1e-5 * size, "{input:?}: {} of {size}", worst(&slow, &same));
    }
}

fn stamps(n: usize, step: f64) -> Vec<f64> {
    (0..n).map(|k| step * k as f64).collect()
}

fn worst(found: &[f64], exact: &[f64]) -> f64 {
    found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Motion under held and under linear samples agrees with the reference. With 16 steps per sample
/// the error is up to 5e-10 here; with 64, by the fourth order, 2e-12.
#[test]
fn exact_held_and_linear_samples() {
    let Some(file) = read("input_reference.json") else { return };
    let surge = |case: &str, input| {
        let (tau, exact) = (numbers(&file[case]["tau"]), numbers(&file[case]["u_ref"]));
        let found = simulate(&laurs(), &stamps(tau.len(), number(&file[case]["dt"])), &tau, input, 64.0);
        worst(&found, &exact)
    };
    for (case, input) in [("zoh_samples", Interpolation::Hold), ("foh_samples", Interpolation::Linear)] {
        let error = surge(case, input);
        assert!(error < 5e-12, "{case}: {error}");
    }
    assert!(surge("zoh_samples", Interpolation::Linear) > 0.01, "the two differ");
    let case = &file["linear_yaw_samples"];
    let tau = numbers(&case["tau"]);
    let yaw = model(Dof::Yaw, [number(&case["I"]), number(&case["kr"]), 0.0]);
    for (name, input) in [("r_zoh", Interpolation::Hold), ("r_foh", Interpolation::Linear)] {
        let found = simulate(&yaw, &stamps(tau.len(), number(&case["dt"])), &tau, input, 64.0);
        assert!(worst(&found, &numbers(&case[name])) < 5e-12, "{name}");
    }
}

fn sine(t: f64) -> f64 {
    145.3 * (std::f64::consts::TAU * t / 28.0).sin() + 185.7
}

/// Velocity after 28 s with `n` samples of the sinusoidal command.
fn at_28_s(n: usize, input: Interpolation, substeps: f64) -> f64 {
    let time = stamps(n + 1, 28.0 / n as f64);
    let tau: Vec<f64> = time.iter().map(|t| sine(*t)).collect();
    simulate(&laurs(), &time, &tau, input, substeps)[n]
}

/// Errors relative to the continuous input (order 1 if held, 2 if linear) and to the exact sampled
/// problem (order 4 for both) are those of a correct scheme in the reference, to its printed digits
/// (1 %).
#[test]
fn exact_orders_of_sampled_inputs() {
    let Some(file) = read("input_reference.json") else { return };
    let tables = &file["rk4_input_modes"]["tables"];
    let continuous = number(&file["continuous_input_u28"]);
    let hold = |table: &str, error: &dyn Fn(usize) -> f64| {
        let Value::Object(table) = &tables[table] else { panic!("the table {table} is there") };
        for (n, expected) in numbers(&table["n"]).into_iter().zip(numbers(&table["error"])) {
            let found = error(n as usize);
            // 2e-14 is the rounding over some hundred steps
            assert!((found - expected).abs() < 0.01 * expected + 2e-14, "{n} samples: {found} against {expected}");
        }
    };
    use Interpolation::{Hold, Linear};
    hold("ZOH, held over step, vs continuous input", &|n| (at_28_s(n, Hold, 1.0) - continuous).abs());
    hold("linear interpolation vs continuous input", &|n| (at_28_s(n, Linear, 1.0) - continuous).abs());
    // with 32 steps per sample, the sampled problem is solved to 1e-6 of the error of one step
    hold("ZOH, held over step, vs exact ZOH problem", &|n| (at_28_s(n, Hold, 1.0) - at_28_s(n, Hold, 32.0)).abs());
    hold("linear interpolation vs exact FOH problem", &|n| (at_28_s(n, Linear, 1.0) - at_28_s(n, Linear, 32.0)).abs());
}

/// With several steps per sample, the errors on a log of 28 samples, relative to 64 steps per
/// sample, are those of the reference.
#[test]
fn exact_substeps_on_a_fixed_log() {
    let Some(file) = read("input_reference.json") else { return };
    let table = &file["rk4_input_modes"]["substeps_on_fixed_log"];
    for (name, input) in [("zoh", Interpolation::Hold), ("foh", Interpolation::Linear)] {
        let exact = at_28_s(28, input, 64.0);
        for (parts, expected) in numbers(&table["substeps"]).into_iter().zip(numbers(&table["error"][name])) {
            let found = (at_28_s(28, input, parts) - exact).abs();
            // the solution with 64 steps itself has 1/256 of the error of 16
            assert!((found - expected).abs() < 0.01 * expected + 1e-14, "{name}, {parts}: {found} against {expected}");
        }
    }
}
