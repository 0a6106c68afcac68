//! Vehicles among the reference problems, built from effects of the catalogue and simulated by the
//! library: model, compiled equations and integrator together give the reference solution.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::sync::Arc;

use crate::ode_reference::{Problem, problems};
use hydrosysid::chain::Available;
use hydrosysid::dynamics::Dynamics;
use hydrosysid::effects::Coriolis;
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model};
use hydrosysid::run::{Run, Signal};
use hydrosysid::simulate::{Track, free_run};

const PLANAR: [Dof; 3] = [Dof::Surge, Dof::Sway, Dof::Yaw];

/// A degree of freedom and the force there as a function of time.
type Command = (Dof, Box<dyn Fn(f64) -> f64>);

/// A vehicle under commands that are functions of time.
struct Vehicle {
    model: Model,
    input: Interpolation,
    commands: Vec<Command>,
}

fn vehicle(dofs: &[Dof], effects: &[&str], values: &[(&str, f64)]) -> Vehicle {
    let mut model = Model::with_effects(dofs, Coriolis::Tied, effects).expect("catalogue effects");
    for (name, value) in values {
        assert!(model.set(name, *value), "{name}");
    }
    Vehicle { model, input: Interpolation::Linear, commands: Vec::new() }
}

impl Vehicle {
    fn command(mut self, dof: Dof, tau: impl Fn(f64) -> f64 + 'static) -> Vehicle {
        self.commands.push((dof, Box::new(tau)));
        self
    }

    /// The channels `observed` at the instants `time`, row by row, from the initial state `y0` (by channel).
    fn simulate(&self, time: &[f64], observed: &[&str], y0: &dyn Fn(&str) -> f64) -> Vec<f64> {
        let stamps: Arc<[f64]> = time.into();
        let mut run = Run { name: "reference".into(), ..Run::default() };
        for name in observed {
            run.signals.insert((*name).into(), Signal::new(stamps.clone(), vec![0.0; time.len()]));
        }
        // commands have samples where the scheme reads them: at the ends and in the middle of each step
        let halves: Vec<f64> =
            time.windows(2).flat_map(|w| [w[0], 0.5 * (w[0] + w[1])]).chain(time.last().copied()).collect();
        let reads: Arc<[f64]> = if self.input == Interpolation::Hold { stamps.clone() } else { halves.into() };
        for (dof, tau) in &self.commands {
            let values: Vec<f64> = reads.iter().map(|t| tau(*t)).collect();
            run.signals.insert(dof.force().into(), Signal::new(reads.clone(), values));
        }
        let channels = run.signals.keys().cloned().collect();
        let available = Available { channels, position: true, ..Available::default() };
        let names: BTreeSet<String> = observed.iter().map(|s| (*s).to_string()).collect();
        let dynamics = Dynamics::compile(&self.model, &available, &names, &[]);
        let theta = self.model.values();
        let track = Track::new(&run, 0, &dynamics, &theta, self.input, 1e9).expect("the run has every channel");
        let x0: Vec<f64> = dynamics.states.iter().map(|id| id.channel().map_or(0.0, y0)).collect();
        let found = free_run(&dynamics, &track, &theta, &x0, 0, time.len() - 1);
        let column = |name: &str| dynamics.outputs.iter().position(|n| *n == name).expect("it is observed");
        let columns: Vec<usize> = observed.iter().map(|name| column(name)).collect();
        let rows = found.outputs.chunks(dynamics.outputs.len());
        rows.flat_map(|row| columns.iter().map(|c| row[*c]).collect::<Vec<_>>()).collect()
    }
}

fn planar(p: &dyn Fn(&str) -> f64) -> Vehicle {
    vehicle(
        &PLANAR,
        &["inertia", "linear_drag", "quadratic_drag", "coriolis_surge", "coriolis_sway", "coriolis_yaw"],
        &[
            ("inertia@surge", p("mu")),
            ("inertia@sway", p("mv")),
            ("inertia@yaw", p("Ir")),
            ("linear_drag@surge", p("ku")),
            ("linear_drag@sway", p("kv")),
            ("linear_drag@yaw", p("kr")),
            ("quadratic_drag@surge", p("kuu")),
            ("quadratic_drag@sway", p("kvv")),
            ("quadratic_drag@yaw", p("krr")),
        ],
    )
}

/// The vehicle of a problem whose states are channels of a log; `None` for every other problem.
fn vehicle_of(problem: &Problem) -> Option<Vehicle> {
    let p = |name: &str| problem.p(name);
    let surge = |linear: f64, quadratic: f64, force: f64| {
        let values = [("inertia@surge", p("m")), ("linear_drag@surge", linear), ("quadratic_drag@surge", quadratic)];
        vehicle(&[Dof::Surge], &["inertia", "linear_drag", "quadratic_drag"], &values)
            .command(Dof::Surge, move |_| force)
    };
    let sinusoid = || {
        let (a, b, period) = (p("A"), p("B"), p("P"));
        move |t: f64| a * (TAU * t / period).sin() + b
    };
    Some(match problem.id.as_str() {
        "surge_quadratic_from_rest" | "surge_quadratic_reversal" => surge(0.0, p("k"), p("F")),
        "surge_quadratic_coastdown" => surge(0.0, p("k"), 0.0),
        "surge_linquad_from_rest" | "surge_linquad_reversal" => surge(p("a"), p("b"), p("F")),
        "surge_linquad_coastdown" => surge(p("a"), p("b"), 0.0),
        "surge_laurs_sinusoid" => {
            let mut vehicle = surge(p("a"), p("b"), 0.0);
            vehicle.commands.clear();
            vehicle.command(Dof::Surge, sinusoid())
        }
        "yaw_linear_sinusoid" => {
            let values = [("inertia@yaw", p("I")), ("linear_drag@yaw", p("kr"))];
            vehicle(&[Dof::Yaw], &["inertia", "linear_drag"], &values).command(Dof::Yaw, sinusoid())
        }
        "munk_libration" | "munk_rotation" => vehicle(
            &PLANAR,
            &["inertia", "coriolis_surge", "coriolis_sway", "coriolis_yaw"],
            &[("inertia@surge", p("mu")), ("inertia@sway", p("mv")), ("inertia@yaw", p("I"))],
        ),
        "planar3_sinusoid_smooth" => planar(&p)
            .command(Dof::Surge, |t| 400.0 + 145.3 * (TAU * t / 28.0).sin())
            .command(Dof::Sway, |t| -30.0 + 10.0 * (TAU * t / 20.0).cos())
            .command(Dof::Yaw, |t| 15.0 + 5.0 * (TAU * t / 16.0).sin()),
        "planar3_sinusoid_reversing" => planar(&p)
            .command(Dof::Surge, |t| 100.0 + 60.0 * (0.5 * t).sin())
            .command(Dof::Sway, |t| 40.0 * (0.3 * t + 1.0).sin())
            .command(Dof::Yaw, |t| 50.0 * (0.8 * t).sin()),
        "planar3_zigzag" => {
            // held from each sample to the next, with the switches at samples
            let moment = |t: f64| if ((t + 1e-6) / 6.0).floor() as i64 % 2 == 0 { 67.8 } else { -67.8 };
            let vehicle = planar(&p).command(Dof::Surge, |_| 140.0).command(Dof::Yaw, moment);
            Vehicle { input: Interpolation::Hold, ..vehicle }
        }
        "euler_zyx_constant_rate" => {
            let dofs = [Dof::Roll, Dof::Pitch, Dof::Yaw];
            vehicle(&dofs, &["inertia"], &[("inertia@roll", 1.0), ("inertia@pitch", 1.0), ("inertia@yaw", 1.0)])
        }
        "rigid_body_euler_general" => vehicle(
            &Dof::ALL,
            &["inertia", "coriolis_roll", "coriolis_pitch", "coriolis_yaw"],
            &[
                ("inertia@surge", 1.0),
                ("inertia@sway", 1.0),
                ("inertia@heave", 1.0),
                ("inertia@roll", p("I1")),
                ("inertia@pitch", p("I2")),
                ("inertia@yaw", p("I3")),
            ],
        ),
        "roll_restoring_undamped" => {
            let values = [("inertia@roll", 1.0), ("restoring_roll", p("w2"))];
            vehicle(&[Dof::Roll], &["inertia", "restoring_roll"], &values)
        }
        "roll_restoring_quadratic_damping" => vehicle(
            &[Dof::Roll],
            &["inertia", "restoring_roll", "linear_drag", "quadratic_drag"],
            &[
                ("inertia@roll", 1.0),
                ("restoring_roll", p("w2")),
                ("linear_drag@roll", p("d1")),
                ("quadratic_drag@roll", p("d2")),
            ],
        ),
        _ => return None,
    })
}

#[test]
fn exact_vehicles_from_the_catalogue() {
    let problems = problems();
    let mut held = 0;
    for problem in &problems {
        let Some(vehicle) = vehicle_of(problem) else { continue };
        held += 1;
        let states: Vec<&str> = problem.states.iter().map(String::as_str).collect();
        let constant_rate = problem.id.starts_with("euler_zyx");
        let start = |name: &str| match states.iter().position(|s| *s == name) {
            Some(k) => problem.y0[k],
            None if constant_rate && ["p", "q", "r"].contains(&name) => problem.p(name),
            None => 0.0,
        };
        problem.hold_against_the_table(&mut |time| vehicle.simulate(time, &states, &start));
        // if |ν|ν changes sign within a step the order does not show, but the solution is as
        // accurate as elsewhere
        let finest = problem.rows.iter().map(|row| row.longest).fold(f64::INFINITY, f64::min);
        let last = problem.grid.last().expect("a grid");
        let time: Vec<f64> = grid(&problem.grid, finest.min(last / 500.0));
        let error = problem.error(&time, &vehicle.simulate(&time, &states, &start));
        assert!(error < 2e-8, "{}: {error}", problem.id);
    }
    assert!(problems.is_empty() || held == 17, "{held} vehicles were held against their reference");
}

/// The grid with every interval divided into parts no longer than `longest`.
fn grid(coarse: &[f64], longest: f64) -> Vec<f64> {
    let parts = |w: &[f64]| ((w[1] - w[0]) / longest).ceil();
    let inner = coarse.windows(2).flat_map(|w| {
        let n = parts(w);
        (1..=n as usize).map(|k| w[0] + (w[1] - w[0]) * k as f64 / n).collect::<Vec<_>>()
    });
    std::iter::once(coarse[0]).chain(inner).collect()
}

/// Six degrees of freedom with drag, restoring and Coriolis forces. The reference has quaternions,
/// the model Euler angles: velocities and the converted attitude agree with short steps, 20 s in
/// 4000 steps.
#[test]
fn exact_six_degrees_of_freedom() {
    let Some(problem) = problems().into_iter().find(|p| p.id == "six_dof_drag_restoring") else { return };
    let list = |name: &str| problem.parameters[name].clone();
    let (m, d1, d2, tau) = (list("m"), list("d1"), list("d2"), list("tau"));
    let effects = [
        "inertia",
        "linear_drag",
        "quadratic_drag",
        "restoring_surge",
        "restoring_sway",
        "restoring_heave",
        "restoring_roll",
        "restoring_pitch",
        "coriolis_surge",
        "coriolis_sway",
        "coriolis_heave",
        "coriolis_roll",
        "coriolis_pitch",
        "coriolis_yaw",
    ];
    let mut six =
        vehicle(&Dof::ALL, &effects, &[("restoring_surge", problem.p("WB")), ("restoring_roll", problem.p("zgW"))]);
    for dof in Dof::ALL {
        let i = dof.index();
        for (effect, values) in [("inertia", &m), ("linear_drag", &d1), ("quadratic_drag", &d2)] {
            assert!(six.model.set(&format!("{effect}@{dof}"), values[i]));
        }
        let force = tau[i];
        six = six.command(dof, move |_| force);
    }
    let observed = ["u", "v", "w", "p", "q", "r", "phi", "theta", "psi"];
    let start = |name: &str| problem.states.iter().position(|s| s == name).map_or(0.0, |k| problem.y0[k]);
    let time = grid(&problem.grid, 0.005);
    let found = six.simulate(&time, &observed, &start);
    let as_reference: Vec<f64> = found
        .chunks(9)
        .flat_map(|row| {
            let half = |k: usize| (row[k] / 2.0).sin_cos();
            let ((sf, cf), (st, ct), (sp, cp)) = (half(6), half(7), half(8));
            // ψ exceeds a full turn without wrapping, and ψ/2 gives the sign of the quaternion in
            // the reference
            let q = [
                cf * ct * cp + sf * st * sp,
                sf * ct * cp - cf * st * sp,
                cf * st * cp + sf * ct * sp,
                cf * ct * sp - sf * st * cp,
            ];
            row[..6].iter().copied().chain(q).collect::<Vec<_>>()
        })
        .collect();
    let error = problem.error(&time, &as_reference);
    assert!(error < 1e-8, "{error}");
}
