//! Shared parts of the tests of exports: models, their motion by the library, and an integrator for
//! the equations of the targets.

#[allow(dead_code)] // not every test steps an engine
pub mod engine;
pub mod quoted;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use hydrosysid::campaign::file::ModelTable;
use hydrosysid::campaign::{Estimator, ModelFile, ModelForce, ModelNoise, ModelParameter, ModelSensor};
use hydrosysid::chain::Available;
use hydrosysid::dynamics::Dynamics;
use hydrosysid::effects::Coriolis;
use hydrosysid::export::{Export, ExportOptions, Target, export_model};
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model};
use hydrosysid::run::{Run, Signal};
use hydrosysid::simulate::{Track, free_run};
use hydrosysid::thrust::efficiency::Efficiency;
use hydrosysid::vehicle::{Vehicle, Water};
use nalgebra::{Matrix6, Vector6};
use roxmltree::Node;

pub const PLANAR: [Dof; 3] = [Dof::Surge, Dof::Sway, Dof::Yaw];
pub const PATH: &str = "model.toml";

/// A model file with these terms, each with a value for its first parameter.
pub fn file(dofs: &[Dof], terms: &[(&str, f64)], coriolis: Coriolis) -> ModelFile {
    let mut model = Model::new(dofs, coriolis);
    for (name, value) in terms {
        for term in model.add_named(name).expect("the term can stand there") {
            let first = model.terms[term].parameters.first().copied();
            first.into_iter().for_each(|p| model.parameters[p].value = *value);
        }
    }
    let parameters = model.parameters.iter().map(|p| ModelParameter {
        effect: p.term.clone(),
        name: p.spec.name.clone(),
        value: p.value,
        std: Some(0.01 * p.value.abs()),
        unit: p.spec.dimension,
        fixed: false,
        per_run: BTreeMap::new(),
    });
    ModelFile {
        format: 1,
        hydrosysid: "0.1.0".into(),
        campaign: "campaign.toml".into(),
        estimator: Estimator::OutputError,
        std_method: "clusters".into(),
        converged: true,
        vehicle: Vehicle { name: "a -- \"craft\" & <co>".into(), mass: Some(200.0), ..Vehicle::default() },
        water: Water::default(),
        model: ModelTable {
            dofs: dofs.to_vec(),
            effects: model.terms.iter().map(|t| t.name().parse().expect("a term's name is a name")).collect(),
            coriolis,
            input: Interpolation::Linear,
            undriven: Vec::new(),
        },
        log: hydrosysid::log::LogOptions::default(),
        readings: Vec::new(),
        thrusters: Vec::new(),
        efficiency: Efficiency::default(),
        envelope: BTreeMap::from([("u".to_string(), [-0.5, 1.0])]),
        effects: Vec::new(),
        observed: Vec::new(),
        tied: Vec::new(),
        sensors: BTreeMap::new(),
        noise: None,
        covariance: vec![vec![0.0; model.parameters.len()]; model.parameters.len()],
        parameters: parameters.collect(),
    }
}

pub fn planar(more: &[(&str, f64)]) -> ModelFile {
    let mut terms = vec![
        ("inertia@surge", 250.0),
        ("inertia@sway", 320.0),
        ("inertia@yaw", 60.0),
        ("coriolis_surge", 0.0),
        ("coriolis_sway", 0.0),
        ("coriolis_yaw", 0.0),
        ("linear_drag@surge", 20.0),
        ("linear_drag@sway", 35.0),
        ("linear_drag@yaw", 15.0),
        ("quadratic_drag@surge", 120.0),
        ("quadratic_drag@sway", 260.0),
        ("quadratic_drag@yaw", 40.0),
    ];
    terms.extend(more);
    file(&PLANAR, &terms, Coriolis::Tied)
}

/// A model in six degrees of freedom that floats upright, with the couplings `more`, and a centre
/// of gravity off the origin of the body.
pub fn floating(more: &[(&str, f64)]) -> ModelFile {
    let mut terms = vec![
        ("inertia@surge", 250.0),
        ("inertia@sway", 320.0),
        ("inertia@heave", 340.0),
        ("inertia@roll", 30.0),
        ("inertia@pitch", 45.0),
        ("inertia@yaw", 60.0),
        ("restoring_surge", -12.0),
        ("restoring_sway", -12.0),
        ("restoring_heave", -12.0),
        ("restoring_roll", 80.0),
        ("restoring_pitch", 80.0),
        // m r_g of the rigid body, plus a smaller part of the added mass
        ("added_mass_coupling@surge:pitch", 200.0 * 0.03 + 3.0),
        ("added_mass_coupling@sway:roll", -200.0 * 0.03 - 2.0),
        ("added_mass_coupling@sway:yaw", 200.0 * 0.05 - 4.0),
        ("added_mass_coupling@heave:pitch", -200.0 * 0.05 + 3.0),
    ];
    let damping = [
        ("linear_drag@", [40.0, 50.0, 60.0, 12.0, 14.0, 15.0]),
        ("quadratic_drag@", [120.0, 200.0, 240.0, 10.0, 12.0, 20.0]),
    ];
    let names: Vec<(String, f64)> = damping
        .iter()
        .flat_map(|(kind, values)| {
            Dof::ALL.into_iter().zip(values).map(move |(d, v)| (format!("{kind}{}", d.name()), *v))
        })
        .chain(Dof::ALL.into_iter().map(|d| (format!("coriolis_{}", d.name()), 0.0)))
        .collect();
    terms.extend(names.iter().map(|(name, value)| (name.as_str(), *value)));
    terms.extend(more);
    let mut file = file(&Dof::ALL, &terms, Coriolis::Tied);
    file.vehicle.cg = Some([0.05, 0.0, 0.03]);
    file.vehicle.name = "floating".into();
    file.covariance.clear();
    file
}

/// Noise of a model: a random force in every degree of freedom and noise of every velocity, one of
/// them coloured.
pub fn noise(dofs: &[Dof]) -> ModelNoise {
    let force = |dof: &Dof| ModelForce {
        dof: *dof,
        rms: 2.0 + dof.index() as f64,
        std: 0.1,
        correlation_time: 0.8,
        correlation_time_std: 0.1,
        share_of_thrust: None,
    };
    let sensor = |dof: &Dof| ModelSensor {
        channel: dof.velocity().into(),
        std: 0.01,
        coloured_std: (*dof == Dof::Surge).then_some(0.02),
        correlation_time: (*dof == Dof::Surge).then_some(3.0),
        restlessness: 1.0,
    };
    ModelNoise {
        innovations_white: true,
        force: dofs.iter().map(force).collect(),
        sensor: dofs.iter().map(sensor).collect(),
    }
}

/// A campaign under `folder` with two thrusters, for the targets that write thrusters: one along
/// surge, one in the stern at an angle, with a dead band.
pub fn thrusters(folder: &Path, name: &str, more: &str) -> std::path::PathBuf {
    let path = folder.join("campaign.toml");
    let text = format!(
        "format = 1\n[vehicle]\nname = \"{name}\"\n[model]\ndofs = [\"surge\", \"yaw\"]\neffects = [\"inertia\"]\n\
         [[thruster]]\nname = \"bow {name}\"\nposition = [0.2, -0.1, 0.05]\naxis = [1, 0, 0]\nmax = 1\n\
         forward = {{ a = 40, b = 10 }}\nreverse = {{ a = 30, b = 10 }}\nneutral = 1500\nspan = 400\n\
         [[thruster]]\nname = \"stern {name}\"\nposition = [-0.3, 0.15, -0.04]\naxis = [1, 1, 0.5]\nmax = 0.9\ndeadband = 0.07\n\
         forward = {{ a = 50, b = 5 }}\nreverse = {{ a = 45, b = 3 }}\nneutral = 1500\nspan = -400\n\
         {more}\n[[run]]\nfile = \"a.csv\"\n"
    );
    std::fs::create_dir_all(folder).expect("a folder");
    std::fs::write(&path, text).expect("it can be written");
    path
}

/// Couplings in addition to those of [`floating`], of every kind that an exported function can represent.
pub const EVERY_COUPLING: [(&str, f64); 5] = [
    ("linear_cross_damping@sway:yaw", 12.0),
    ("linear_cross_damping@surge:pitch", 9.0),
    ("cross_drag@pitch:heave", 11.0),
    ("mixed_drag@heave:surge", 40.0),
    ("drag_asymmetry@heave", 60.0),
];

/// Couplings of every kind that a simulator with coefficients can represent.
pub const COUPLED: [(&str, f64); 5] = [
    ("mixed_drag@yaw:surge", 25.0),
    ("linear_cross_damping@sway:yaw", 12.0),
    ("cross_drag@yaw:sway", -30.0),
    ("drag_asymmetry@surge", 50.0),
    ("added_mass_coupling@sway:yaw", 9.0),
];

pub fn made(file: &ModelFile, target: Target, options: &ExportOptions) -> Export {
    export_model(file, Path::new(PATH), target, options).expect("it can be exported")
}

pub fn text(export: &Export) -> String {
    String::from_utf8(export.bytes.clone()).expect("it is text")
}

pub fn codes(export: &Export) -> BTreeSet<&str> {
    export.warnings.iter().map(|w| w.code).collect()
}

/// The force of the tests at time `t`, forward-starboard-down, linear between its samples as in runs.
pub fn force(samples: &[[f64; 6]], t: f64) -> Vector6<f64> {
    let k = ((t / STEP) as usize).min(samples.len() - 2);
    let share = t / STEP - k as f64;
    Vector6::from_fn(|i, _| samples[k][i] * (1.0 - share) + samples[k + 1][i] * share)
}

pub const STEP: f64 = 0.1;
pub const SECONDS: f64 = 60.0;

/// Forces that move every modelled degree of freedom, each with its own period.
pub fn samples(dofs: &[Dof]) -> Vec<[f64; 6]> {
    let size = [90.0, 80.0, 70.0, 9.0, 10.0, 12.0];
    let at = |k: usize| {
        let t = STEP * k as f64;
        std::array::from_fn(|i| match dofs.iter().any(|d| d.index() == i) {
            true => size[i] * ((0.5 + 0.13 * i as f64) * t + i as f64).sin() + 0.2 * size[i],
            false => 0.0,
        })
    };
    (0..=(SECONDS / STEP) as usize + 1).map(at).collect()
}

/// Number of sample intervals of the minute.
const COUNT: usize = (SECONDS / STEP) as usize;

/// A run with forces and velocities at the samples.
pub fn run_of(dofs: &[Dof], samples: &[[f64; 6]], velocity: &dyn Fn(usize, Dof) -> f64) -> Run {
    let time: std::sync::Arc<[f64]> = (0..=COUNT).map(|k| STEP * k as f64).collect();
    let mut run = Run { name: "test".into(), ..Run::default() };
    for dof in dofs {
        let forces: Vec<f64> = samples[..=COUNT].iter().map(|row| row[dof.index()]).collect();
        let velocities: Vec<f64> = (0..=COUNT).map(|k| velocity(k, *dof)).collect();
        run.signals.insert(dof.force().into(), Signal::new(time.clone(), forces));
        run.signals.insert(dof.velocity().into(), Signal::new(time.clone(), velocities));
    }
    run
}

/// Velocities of the model at the samples by the library.
pub fn truth(file: &ModelFile) -> Vec<Vector6<f64>> {
    truth_of(file, &run_of(&file.model.dofs, &samples(&file.model.dofs), &|_, _| 0.0))
}

/// Velocities of the model under the forces of a run, from rest.
pub fn truth_of(file: &ModelFile, run: &Run) -> Vec<Vector6<f64>> {
    let model = file.model(&[], Path::new(PATH)).expect("it is a model");
    let observed: BTreeSet<String> = model.dofs.iter().map(|d| d.velocity().to_string()).collect();
    let channels = model.dofs.iter().map(|d| d.force().to_string()).collect();
    let dynamics = Dynamics::compile(&model, &Available { channels, ..Available::default() }, &observed, &[]);
    let track = Track::new(run, 0, &dynamics, &model.values(), model.input, 0.02).expect("the run is complete");
    let start = vec![0.0; dynamics.states.len()];
    let path = free_run(&dynamics, &track, &model.values(), &start, 0, COUNT);
    let width = dynamics.outputs.len();
    let row = |row: &[f64]| {
        let mut nu = Vector6::zeros();
        for (name, value) in dynamics.outputs.iter().zip(row) {
            let dof = Dof::ALL.into_iter().find(|d| d.velocity() == *name).expect("it is a velocity");
            nu[dof.index()] = *value;
        }
        nu
    };
    path.outputs.chunks(width).map(row).collect()
}

/// RK4 of ν̇ = f(t, ν) at 0.02 s, from rest, at the samples.
pub fn integrate(f: &dyn Fn(f64, &Vector6<f64>) -> Vector6<f64>) -> Vec<Vector6<f64>> {
    let h = STEP / 5.0;
    let mut nu = Vector6::zeros();
    let mut path = vec![nu];
    for k in 0..(SECONDS / STEP) as usize {
        for i in 0..5 {
            let t = STEP * k as f64 + h * f64::from(i);
            let a = f(t, &nu);
            let b = f(t + h / 2.0, &(nu + a * (h / 2.0)));
            let c = f(t + h / 2.0, &(nu + b * (h / 2.0)));
            let d = f(t + h, &(nu + c * h));
            nu += (a + b * 2.0 + c * 2.0 + d) * (h / 6.0);
        }
        path.push(nu);
    }
    path
}

pub fn turn(nu: &Vector6<f64>) -> Vector6<f64> {
    Vector6::new(nu[0], -nu[1], -nu[2], nu[3], -nu[4], -nu[5])
}

/// −C(ν) ν of an inertia.
pub fn coriolis(m: &Matrix6<f64>, nu: &Vector6<f64>) -> Vector6<f64> {
    let pi = m * nu;
    let (v, w) = (nu.fixed_rows::<3>(0), nu.fixed_rows::<3>(3));
    let (p, l) = (pi.fixed_rows::<3>(0), pi.fixed_rows::<3>(3));
    let (force, moment) = (-w.cross(&p), -w.cross(&l) - v.cross(&p));
    Vector6::new(force[0], force[1], force[2], moment[0], moment[1], moment[2])
}

/// Asserts that two motions agree within `tolerance` of the largest velocity. The tolerance is for
/// two integrators of fourth order with different steps, and for forces with kinks at the samples.
pub fn assert_same(path: &[Vector6<f64>], truth: &[Vector6<f64>], tolerance: f64) {
    assert_eq!(path.len(), truth.len());
    let size = truth.iter().map(|nu| nu.amax()).fold(0.0, f64::max);
    assert!(size > 0.1, "the test moves the vehicle");
    let worst = path.iter().zip(truth).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
    assert!(worst < tolerance * size, "apart by {worst:e} of {size}");
}

pub fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Node<'a, 'i> {
    node.descendants().find(|n| n.has_tag_name(name)).unwrap_or_else(|| panic!("there is a <{name}>"))
}

pub fn number(node: Node<'_, '_>) -> f64 {
    node.text().expect("there is a text").trim().parse().expect("it is a number")
}

pub fn numbers(node: Node<'_, '_>) -> Vec<f64> {
    let text = node.text().expect("there is a text");
    text.split_whitespace().map(|x| x.parse().expect("it is a number")).collect()
}
