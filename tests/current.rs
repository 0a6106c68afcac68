//! Water that moves over ground: drag and Coriolis act on ν − Rᵀ(V_N, V_E, 0), inertia on the acceleration over ground.

use hydrosysid::chain::Available;
use hydrosysid::dynamics::Dynamics;
use hydrosysid::effects::Coriolis;
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model};
use hydrosysid::run::{Run, Signal};
use hydrosysid::simulate::{Track, free_run};

/// Accelerations of the planar model, written out by hand from the formulas of the catalogue.
fn by_hand(nu: [f64; 3], psi: f64, [north, east]: [f64; 2], tau: [f64; 3]) -> [f64; 3] {
    let [mu, mv, ir] = [800.0, 600.0, 190.0];
    let (s, c) = psi.sin_cos();
    let [u, v, r] = [nu[0] - (c * north + s * east), nu[1] - (-s * north + c * east), nu[2]];
    [
        (tau[0] - 80.0 * u - 310.0 * u * u.abs() + mv * v * r) / mu,
        (tau[1] - 110.0 * v - 500.0 * v * v.abs() - mu * u * r) / mv,
        (tau[2] - 16.0 * r - 95.0 * r * r.abs() - (mv - mu) * u * v) / ir,
    ]
}

#[test]
fn drag_and_coriolis_act_on_the_velocity_through_the_water() {
    let effects =
        ["inertia", "linear_drag", "quadratic_drag", "coriolis_surge", "coriolis_sway", "coriolis_yaw", "current"];
    let mut model = Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Tied, &effects).unwrap();
    for (name, values) in [
        ("inertia", [800.0, 600.0, 190.0]),
        ("linear_drag", [80.0, 110.0, 16.0]),
        ("quadratic_drag", [310.0, 500.0, 95.0]),
    ] {
        for (dof, value) in ["surge", "sway", "yaw"].iter().zip(values) {
            assert!(model.set(&format!("{name}@{dof}"), value));
        }
    }
    let (water, tau) = ([0.2, -0.3], [150.0, -60.0, 40.0]);
    for (symbol, value) in ["V_N", "V_E"].iter().zip(water) {
        let p = model.parameter("current", symbol).unwrap();
        model.parameters[p].value = value;
    }
    let (nu, psi, step) = ([0.5, -0.2, 0.3], 0.7, 1e-4);
    let time: std::sync::Arc<[f64]> = vec![0.0, step].into();
    let mut run = Run::default();
    for (name, value) in [("tau_u", tau[0]), ("tau_v", tau[1]), ("tau_r", tau[2]), ("u", 0.0), ("v", 0.0), ("r", 0.0)] {
        run.signals.insert(name.into(), Signal::new(time.clone(), vec![value; 2]));
    }
    run.signals.insert("psi".into(), Signal::new(time.clone(), vec![psi; 2]));
    let available = Available { channels: run.signals.keys().cloned().collect(), ..Available::default() };
    let observed = run.signals.keys().cloned().collect();
    let dynamics = Dynamics::compile(&model, &available, &observed, &[]);
    let theta = model.values();
    let track = Track::new(&run, 0, &dynamics, &theta, Interpolation::Linear, 1.0).unwrap();
    let x0: Vec<f64> = dynamics
        .states
        .iter()
        .map(|id| match id.channel() {
            Some("u") => nu[0],
            Some("v") => nu[1],
            Some("r") => nu[2],
            _ => psi,
        })
        .collect();
    let end = free_run(&dynamics, &track, &theta, &x0, 0, 1);
    let exact = by_hand(nu, psi, water, tau);
    let still = by_hand(nu, psi, [0.0; 2], tau);
    for (k, name) in ["u", "v", "r"].iter().enumerate() {
        let column = dynamics.outputs.iter().position(|o| o == name).unwrap();
        let found = (end.outputs[dynamics.outputs.len() + column] - nu[k]) / step;
        // the acceleration itself changes by some 1e-4 of itself within the step
        assert!((found - exact[k]).abs() < 1e-3 * exact[k].abs().max(0.1), "{name}: {found}, by hand {}", exact[k]);
        assert!((found - still[k]).abs() > 0.02, "{name}: the current must matter");
    }
}
