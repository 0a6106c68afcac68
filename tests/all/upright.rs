//! Vehicles that pass the vertical: the attitude is a quaternion in the model, and z-y-x Euler
//! angles in the logs.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign, FitOptions, LoadOptions};
use hydrosysid::chain::{Attitude, Available};
use hydrosysid::compare::{CompareOptions, compare};
use hydrosysid::dynamics::Dynamics;
use hydrosysid::effects::Coriolis;
use hydrosysid::estimate::output_error::{OutputErrorOptions, output_error};
use hydrosysid::estimate::started;
use hydrosysid::frame::Dof;
use hydrosysid::log;
use hydrosysid::model::{Interpolation, Model};
use hydrosysid::navigation::{euler_angles, quaternion};
use hydrosysid::run::{Run, Signal};
use hydrosysid::simulate::{Emission, Stretch, Track, Trajectory, free_run, integrate_fast};
use hydrosysid::tank::{Basin, Law, Measured, Noise, Pilot, Sensor, Sine, Trial};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

const INERTIAS: [f64; 6] = [120.0, 150.0, 160.0, 12.0, 25.0, 28.0];

/// Model of a torpedo-like vehicle with all Coriolis rows; `drag` adds drag and restoring moments.
fn vehicle(drag: bool) -> Model {
    let mut names = vec!["inertia", "coriolis_surge", "coriolis_sway", "coriolis_heave"];
    names.extend(["coriolis_roll", "coriolis_pitch", "coriolis_yaw"]);
    if drag {
        names.extend(["linear_drag", "quadratic_drag", "restoring_roll", "restoring_pitch"]);
    }
    let mut model = Model::with_effects(&Dof::ALL, Coriolis::Tied, &names).expect("it is a model");
    for dof in Dof::ALL {
        let i = dof.index();
        assert!(model.set(&format!("inertia@{dof}"), INERTIAS[i]));
        if drag {
            assert!(model.set(&format!("linear_drag@{dof}"), [20.0, 30.0, 30.0, 8.0, 15.0, 15.0][i]));
            assert!(model.set(&format!("quadratic_drag@{dof}"), [60.0, 150.0, 150.0, 5.0, 20.0, 20.0][i]));
        }
    }
    if drag {
        assert!(model.set("restoring_roll", 15.0));
    }
    model
}

/// Simulates `seconds` from the states `start` without any command; `attitude` is the form of the
/// attitude in the states.
fn free(model: &Model, attitude: Attitude, start: &[f64], step: f64, seconds: f64) -> (Dynamics, Trajectory) {
    let available = Available { attitude, ..Available::default() };
    let observed: BTreeSet<String> = ["u", "v", "w", "p", "q", "r", "phi", "theta", "psi"].map(str::to_string).into();
    let dynamics = Dynamics::compile(model, &available, &observed, &[]);
    let time: Arc<[f64]> = (0..=(seconds / step).round() as usize).map(|k| step * k as f64).collect();
    let mut run = Run::default();
    run.signals.insert("u".into(), Signal::new(time.clone(), vec![0.0; time.len()]));
    let track = Track::new(&run, 0, &dynamics, &model.values(), Interpolation::Linear, 1.0).expect("no inputs");
    let path = free_run(&dynamics, &track, &model.values(), start, 0, track.time.len() - 1);
    (dynamics, path)
}

fn unit() -> [f64; 4] {
    [1.0, 0.0, 0.0, 0.0]
}

/// A body with equal inertias turns at a constant rate of pitch, θ = ωt, through 90° and beyond.
/// The angles are those of instruments: beyond the vertical, the vehicle lies on its back with its
/// heading reversed. The error of RK4 is (h ω/2)⁵/120 of half the angle per step, 5e-11 over 950
/// steps, which are one and a half turns. Errors are weighted by cos θ, as φ and ψ are not
/// determined at 90°.
#[test]
fn exact_loop_at_a_constant_rate_of_pitch() {
    let mut model = vehicle(false);
    for dof in [Dof::Roll, Dof::Pitch, Dof::Yaw] {
        model.set(&format!("inertia@{dof}"), 20.0);
    }
    let rate = 0.5;
    let start: Vec<f64> = [0.0, 0.0, 0.0, 0.0, rate, 0.0].into_iter().chain(unit()).collect();
    let (_, path) = free(&model, Attitude::Quaternion, &start, 0.02, 9.0 * PI / 1.5);
    for (t, y) in path.time.iter().zip(path.outputs.chunks(9)) {
        let pitch = rate * t;
        let exact = euler_angles(&quaternion(0.0, pitch, 0.0));
        let cosine = pitch.cos().abs();
        for k in 0..3 {
            let apart = (y[6 + k] - exact[k] + PI).rem_euclid(TAU) - PI;
            assert!(apart.abs() * cosine < 1e-10, "t = {t}, angle {k}: {} for {}", y[6 + k], exact[k]);
        }
        assert!((y[4] - rate).abs() < 1e-14, "the rate of a ball is constant");
    }
}

/// For a body with three different inertias and without torque, kinetic energy and the angular
/// momentum in earth axes are constant through several passes of the vertical. The error of RK4 at
/// h ω of 0.01 is about 1e-11 per second.
#[test]
fn law_torque_free_rotation_keeps_energy_and_momentum() {
    let model = vehicle(false);
    let start: Vec<f64> = [0.0, 0.0, 0.0, 0.3, 0.9, -0.2].into_iter().chain(unit()).collect();
    let (dynamics, path) = free(&model, Attitude::Quaternion, &start, 0.01, 60.0);
    let first = dynamics.quaternion().expect("it carries one");
    let inertia = Vector3::new(INERTIAS[3], INERTIAS[4], INERTIAS[5]);
    let of = |x: &[f64]| {
        let omega = Vector3::new(x[3], x[4], x[5]);
        let q = UnitQuaternion::new_normalize(Quaternion::new(x[first], x[first + 1], x[first + 2], x[first + 3]));
        (0.5 * omega.dot(&inertia.component_mul(&omega)), q * inertia.component_mul(&omega))
    };
    let width = dynamics.states.len();
    let (energy, momentum) = of(&path.states[..width]);
    let mut steepest: f64 = 0.0;
    for (x, y) in path.states.chunks(width).zip(path.outputs.chunks(9)) {
        let (e, l) = of(x);
        assert!((e / energy - 1.0).abs() < 1e-8, "energy {e} for {energy}");
        assert!((l - momentum).norm() < 1e-8 * momentum.norm(), "momentum {l} for {momentum}");
        steepest = steepest.max(y[7].abs());
    }
    assert!(steepest > 80f64.to_radians(), "it came near the vertical: {}°", steepest.to_degrees());
}

/// Far from the vertical, quaternion and Euler angles give the same motion. They differ by the
/// error of the integrator, which decreases by a factor of 16 with half the step.
#[test]
fn law_quaternion_and_angles_are_one_motion() {
    let model = vehicle(true);
    let apart = |step: f64| {
        let nu = [0.5, 0.1, -0.1, 0.2, 0.3, 0.4];
        let angles: Vec<f64> = nu.into_iter().chain([0.1, 0.3, 0.5]).collect();
        let q = quaternion(0.1, 0.3, 0.5);
        let components: Vec<f64> = nu.into_iter().chain([q.w, q.i, q.j, q.k]).collect();
        let (_, a) = free(&model, Attitude::Angles, &angles, step, 5.0);
        let (_, b) = free(&model, Attitude::Quaternion, &components, step, 5.0);
        a.outputs.iter().zip(&b.outputs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (apart(0.1), apart(0.05));
    assert!(coarse < 1e-5 && fine > 1e-13, "{coarse} {fine}");
    assert!((10.0..30.0).contains(&(coarse / fine)), "{}", coarse / fine);
}

/// Runs of 40 s that loop in pitch while all other degrees of freedom move, with white noise of the
/// velocities and small random rotations of the attitude.
fn looping(model: &Model, noise: f64) -> Vec<Run> {
    let rates = Dof::ALL.map(|dof| Sensor::new(dof.velocity(), 10.0, noise * 0.004));
    let angles = [Dof::Roll, Dof::Pitch, Dof::Yaw].map(|dof| Sensor::new(dof.position(), 10.0, 0.0));
    let sensors = rates.into_iter().chain(angles).collect();
    let basin = Basin { sensors, attitude: Attitude::Quaternion, ..Basin::default() };
    let mut draw = Noise::new(4, 1);
    (0..4)
        .map(|k| {
            let force = [60.0, 50.0, 50.0, 6.0, 14.0, 12.0];
            let mut laws: Vec<(Dof, Law)> = Vec::new();
            for dof in Dof::ALL {
                let sines = (0..3).map(|_| Sine {
                    amplitude: force[dof.index()] * draw.between(0.3, 0.6),
                    period: draw.between(4.0, 15.0),
                    phase: draw.between(0.0, TAU),
                });
                // a steady moment for the loop
                let offset = if dof == Dof::Pitch { 26.0 } else { 0.0 };
                laws.push((dof, Law::Sines(offset, sines.collect())));
            }
            let trial = Trial {
                name: format!("loop{k}"),
                duration: 40.0,
                pilot: Pilot::new(laws),
                start: Measured::default(),
                ..Trial::default()
            };
            let mut run = basin.sail(model, &trial, k, 9).expect("it sails");
            turn_a_little(&mut run, noise * 0.005, 100 + k as u64);
            run
        })
        .collect()
}

/// Adds noise to the attitude: a small rotation about every earth axis.
fn turn_a_little(run: &mut Run, size: f64, stream: u64) {
    let mut noise = Noise::new(4, stream);
    let names = ["phi", "theta", "psi"];
    let [phi, theta, psi] = names.map(|name| run.signals[name].clone());
    let mut columns: [Vec<f64>; 3] = Default::default();
    for k in 0..phi.len() {
        let turn = Vector3::from_fn(|_, _| size * noise.normal());
        let q = UnitQuaternion::new(turn) * quaternion(phi.values()[k], theta.values()[k], psi.values()[k]);
        for (column, angle) in columns.iter_mut().zip(euler_angles(&q)) {
            column.push(angle);
        }
    }
    for (name, column) in names.into_iter().zip(columns) {
        run.signals.insert(name.into(), Signal::new(phi.shared_time().clone(), column));
    }
}

fn options(noise: f64) -> OutputErrorOptions {
    let mut sigma: BTreeMap<String, f64> = Dof::ALL.map(|dof| (dof.velocity().to_string(), noise * 0.004)).into();
    sigma.extend(["phi", "theta", "psi"].map(|name| (name.to_string(), noise * 0.005)));
    OutputErrorOptions {
        sigma: Some(sigma),
        segment: 5.0,
        longest_step: Some(if noise < 0.1 { 0.025 } else { 0.1 }),
        ..OutputErrorOptions::default()
    }
}

fn neutral(model: &Model) -> Model {
    let mut neutral = model.clone();
    for p in &mut neutral.parameters {
        p.value = p.spec.neutral;
    }
    neutral
}

fn passes(run: &Run) -> usize {
    let phi = run.signals["phi"].values();
    phi.windows(2).filter(|w| (w[0].cos() < 0.0) != (w[1].cos() < 0.0)).count()
}

/// Without noise the parameters are found within 1e-4; only the steps differ, 10 ms in the tank and
/// 25 ms in the fit.
#[test]
fn exact_parameters_from_runs_that_loop() {
    let model = vehicle(true);
    let runs = looping(&model, 0.0);
    assert!(runs.iter().all(|run| passes(run) > 2), "{:?}", runs.iter().map(passes).collect::<Vec<_>>());
    let fit = output_error(&started(&neutral(&model), &runs), &runs, &options(1e-3)).expect("it fits");
    assert!(fit.problem.dynamics.quaternion().is_some() && fit.converged);
    for (found, exact) in fit.model.parameters.iter().zip(&model.parameters) {
        let off = (found.value / exact.value - 1.0).abs();
        assert!(off < 1e-4, "{} {}: {} for {}", found.term, found.spec.name, found.value, exact.value);
    }
}

/// With noise, at least 15 of 19 95 % intervals cover the truth, and no estimate is off by four
/// standard deviations; by chance this fails in 1 of 200 cases. The cost is that of white noise, so
/// rotations are weighted and counted correctly.
#[test]
fn law_intervals_hold_in_runs_that_loop() {
    let model = vehicle(true);
    let runs = looping(&model, 1.0);
    let fit = output_error(&started(&neutral(&model), &runs), &runs, &options(1.0)).expect("it fits");
    let z = |(found, exact): (&hydrosysid::model::Parameter, &hydrosysid::model::Parameter)| {
        (found.value - exact.value) / found.std.expect("it was fitted")
    };
    let z: Vec<f64> = fit.model.parameters.iter().zip(&model.parameters).map(z).collect();
    assert!(z.iter().filter(|z| z.abs() <= 1.96).count() + 4 >= z.len() && z.iter().all(|z| z.abs() < 4.0), "{z:?}");
    let free = fit.samples - fit.problem.unknowns.len() - fit.problem.free_states() * fit.problem.segments.len();
    let ratio = fit.cost / free as f64;
    // χ²/n of some 14000 samples scatters by 1 %
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    let options = CompareOptions::default();
    let comparison = compare(&fit.model, &runs, &options).expect("it compares");
    for row in &comparison.runs {
        assert!(row.rms < 3.0 * 0.004, "{} {}: {}", row.run, row.dof, row.rms);
    }
}

/// Folder of a campaign of looping runs: logs with forces, velocities and these of the z-y-x Euler angles.
fn folder(name: &str, angles: &[&str]) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("hydrosysid-upright-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let mut text = "format = 1\n[vehicle]\nmass = 100.0\nlength = 1.5\n[model]\n\
        dofs = ['surge', 'sway', 'heave', 'roll', 'pitch', 'yaw']\neffects = ['inertia', 'coriolis_surge', \
        'coriolis_sway', 'coriolis_heave', 'coriolis_roll', 'coriolis_pitch', 'coriolis_yaw', 'linear_drag', \
        'quadratic_drag', 'restoring_roll', 'restoring_pitch']\n"
        .to_string();
    for mut run in looping(&vehicle(true), 1.0) {
        run.signals
            .retain(|name, _| !["phi", "theta", "psi"].contains(&name.as_str()) || angles.contains(&name.as_str()));
        log::write(&run, folder.join(format!("{}.csv", run.name))).expect("it can be written");
        let role = if run.name == "loop3" { "validate" } else { "train" };
        text += &format!("[[run]]\nfile = '{}.csv'\nkind = 'free'\nrole = '{role}'\n", run.name);
    }
    std::fs::write(folder.join("campaign.toml"), text).expect("it can be written");
    folder
}

/// A campaign of CSV files with runs that pass the vertical is fitted, compared and simulated, with
/// Euler angles in input and output. Estimates are within four standard deviations, and the
/// comparison agrees within the noise.
#[test]
fn law_a_campaign_of_files_passes_the_vertical() {
    let folder = folder("whole", &["phi", "theta", "psi"]);
    let campaign =
        Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let said: Vec<(&str, &str)> = campaign.findings.iter().map(|f| (f.code, f.message.as_str())).collect();
    assert_eq!(said.iter().filter(|(code, _)| *code == "M215").count(), 4, "{said:?}");
    let checked = campaign::check_campaign(&folder.join("campaign.toml"), LoadOptions::default())
        .unwrap_or_else(|e| panic!("{e}"));
    // the comparison of rates with angles and of velocities with positions finds no fault in these logs
    let wrong: Vec<_> = checked.warnings.iter().filter(|f| f.code.starts_with("K11")).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
    let fit = campaign::fit(&campaign, FitOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let model = vehicle(true);
    for found in fit.parameters.iter().filter(|p| !p.fixed) {
        let term = found.dof.as_ref().map_or(found.effect.clone(), |dof| format!("{}@{dof}", found.effect));
        let Some(exact) = model.value(&term).or_else(|| model.value(&found.effect)) else { panic!("{term}") };
        let off = (found.value - exact) / found.std.expect("it was fitted");
        assert!(off.abs() < 4.0, "{term}: {} for {exact}, {off} deviations", found.value);
    }
    let comparison = campaign::compare(&campaign, &fit.model, &fit.envelope).unwrap_or_else(|e| panic!("{e}"));
    for row in &comparison.runs {
        assert!(row.rms < 4.0 * 0.004, "{} {}: {}", row.run, row.dof, row.rms);
    }
    let simulation = campaign::simulate(&campaign, &fit.model, &fit.envelope).unwrap_or_else(|e| panic!("{e}"));
    for run in &simulation.runs {
        let names: Vec<&str> = run.simulated.keys().map(String::as_str).collect();
        assert_eq!(names, ["p", "phi", "psi", "q", "r", "theta", "u", "v", "w"]);
        let at = |columns: &BTreeMap<String, Vec<f64>>, k: usize| {
            quaternion(columns["phi"][k], columns["theta"][k], columns["psi"][k])
        };
        for k in 0..run.time.len() {
            let logged = ["phi", "theta", "psi"].map(|name| run.measured[name][k]);
            let [Some(phi), Some(theta), Some(psi)] = logged else { continue };
            let apart = at(&run.simulated, k).angle_to(&quaternion(phi, theta, psi));
            assert!(apart < 0.15, "{} at {} s: {} rad", run.run, run.time[k], apart);
        }
    }
    std::fs::remove_dir_all(folder).expect("it is there");
}

/// Without all three angles there is no initial attitude: the campaign is refused with the channels to log.
#[test]
fn a_log_without_heading_is_refused_at_the_vertical() {
    let folder = folder("part", &["phi", "theta"]);
    let Err(error) = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()) else {
        panic!("it is refused")
    };
    let text = error.to_string();
    assert!(text.contains("log phi, theta and psi at the same instants"), "{text}");
    std::fs::remove_dir_all(folder).expect("it is there");
}

/// A model with pitch only needs no quaternion: its θ continues beyond the vertical, where the log
/// shows a vehicle on its back.
#[test]
fn exact_loop_of_a_model_that_pitches_alone() {
    let mut model = Model::with_effects(&[Dof::Pitch], Coriolis::Tied, &["inertia", "linear_drag", "restoring_pitch"])
        .expect("a model");
    for (name, value) in [("inertia@pitch", 25.0), ("linear_drag@pitch", 15.0), ("restoring_pitch", 6.0)] {
        assert!(model.set(name, value));
    }
    let sensors = [Dof::Pitch.velocity(), Dof::Pitch.position()].map(|c| Sensor::new(c, 10.0, 0.0)).into();
    let basin = Basin { sensors, ..Basin::default() };
    let law = Law::Sines(9.0, vec![Sine { amplitude: 8.0, period: 7.0, phase: 0.0 }]);
    let trial =
        Trial { name: "loop".into(), duration: 60.0, pilot: Pilot::new(vec![(Dof::Pitch, law)]), ..Trial::default() };
    let mut run = basin.sail(&model, &trial, 0, 1).expect("it sails");
    let through = run.signals["theta"].clone();
    assert!(through.values().iter().any(|x| *x > TAU), "it loops");
    // the angles that instruments show
    for (k, name) in ["phi", "theta", "psi"].into_iter().enumerate() {
        let told = through.values().iter().map(|x| euler_angles(&quaternion(0.0, *x, 0.0))[k]).collect::<Vec<f64>>();
        run.signals.insert(name.into(), Signal::new(through.shared_time().clone(), told));
    }
    let text = "format = 1\n[model]\ndofs = ['pitch']\neffects = ['inertia', 'linear_drag', 'restoring_pitch']\n[[run]]\nfile = 'a.csv'\n";
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let file = CampaignFile::from_bytes(text.as_bytes(), std::path::Path::new("a.toml"), &options)
        .unwrap_or_else(|e| panic!("{e}"));
    let campaign = Campaign::from_runs(file, vec![run]).unwrap_or_else(|e| panic!("{e}"));
    let fit = campaign::fit(&campaign, FitOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    for (found, exact) in fit.parameters.iter().zip([25.0, 15.0, 6.0]) {
        // the steps differ: 10 ms in the tank, 100 ms in the fit
        assert!((found.value / exact - 1.0).abs() < 1e-4, "{}: {} for {exact}", found.name, found.value);
    }
}

/// Sensitivities of the rotations in the output to initial states and parameters are the
/// derivatives of the discrete solution, through the vertical as well.
#[test]
fn law_sensitivities_of_the_quaternion_agree_with_differences() {
    let model = vehicle(true);
    let run = hydrosysid::navigation::upright::with_quaternion(&looping(&model, 1.0)[0]);
    let channels: BTreeSet<String> = run.signals.keys().cloned().collect();
    let available = Available { channels, attitude: Attitude::Quaternion, ..Available::default() };
    let turns = hydrosysid::navigation::upright::TURNS.map(str::to_string).into();
    let dynamics = Dynamics::compile(&model, &available, &turns, &model.free());
    let theta = model.values();
    let track = Track::new(&run, 0, &dynamics, &theta, Interpolation::Linear, 0.1).expect("all channels");
    let q = quaternion(0.0, 0.0, 0.0);
    let x0: Vec<f64> = [0.1, 0.0, 0.0, 0.1, 0.4, 0.0, q.w, q.i, q.j, q.k].into();
    let (last, nx) = (60, x0.len());
    let end = |theta: &[f64], x0: &[f64]| {
        let path = free_run(&dynamics, &track, theta, x0, 0, last);
        path.outputs[path.outputs.len() - 3..].to_vec()
    };
    let lanes = |list: &[f64]| list.iter().map(|v| [*v]).collect::<Vec<[f64; 1]>>();
    let mut jacobian = Vec::new();
    let stretch = [Some(Stretch { track: 0, first: 0, last })];
    let mut take = |at: &Emission<'_, 1>| {
        if at.grid[0] == Some(last) {
            jacobian = at.jacobian.iter().map(|g| g[0]).collect();
        }
    };
    integrate_fast(&dynamics, std::slice::from_ref(&track), &stretch, &lanes(&theta), &lanes(&x0), true, &mut take);
    let width = nx + dynamics.directions.len();
    for column in 0..width {
        let size = if column < nx { 1.0 } else { theta[dynamics.directions[column - nx]] };
        let h = 1e-5 * size;
        let at = |sign: f64| {
            let (mut theta, mut x0) = (theta.clone(), x0.clone());
            if column < nx {
                x0[column] += sign * h;
            } else {
                theta[dynamics.directions[column - nx]] += sign * h;
            }
            end(&theta, &x0)
        };
        let (up, down) = (at(1.0), at(-1.0));
        for row in 0..3 {
            let numeric = (up[row] - down[row]) / (2.0 * h) * size;
            let exact = jacobian[row * width + column] * size;
            // central differences: an error of 1e-10 times the third derivative, and rounding of 1e-16/1e-5
            assert!((numeric - exact).abs() < 1e-6 * (1.0 + exact.abs()), "{row} {column}: {exact} for {numeric}");
        }
    }
}
