//! Exported files are read by a parser of the target's format, and their vehicle moves as the model does.
//!
//! The simulators in these tests are written from the equations of the targets, with their signs
//! and axes, independently of the library.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::exported::*;
use hydrosysid::campaign::ModelParameter;
use hydrosysid::effects::Coriolis;
use hydrosysid::export::{Export, ExportOptions, Target, export_model};
use hydrosysid::frame::Dof;
use hydrosysid::model::Model;
use nalgebra::{Matrix6, Vector6};
use roxmltree::{Document, Node};

/// Inertia matrix of the rigid body of an `<inertial>`, about the origin of the link.
fn rigid(inertial: Node<'_, '_>) -> Matrix6<f64> {
    let mass = number(child(inertial, "mass"));
    let pose = numbers(child(inertial, "pose"));
    let [x, y, z] = [pose[0], pose[1], pose[2]];
    let about = |name: &str| number(child(child(inertial, "inertia"), name));
    let skew = nalgebra::Matrix3::new(0.0, -z, y, z, 0.0, -x, -y, x, 0.0);
    let central = nalgebra::Matrix3::new(
        about("ixx"),
        about("ixy"),
        about("ixz"),
        about("ixy"),
        about("iyy"),
        about("iyz"),
        about("ixz"),
        about("iyz"),
        about("izz"),
    );
    let mut m = Matrix6::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(mass);
    m.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-mass * skew));
    m.fixed_view_mut::<3, 3>(3, 0).copy_from(&(mass * skew));
    m.fixed_view_mut::<3, 3>(3, 3).copy_from(&(central - mass * skew * skew));
    m
}

/// The Hydrodynamics system of gz-sim, with its derivatives by the names of the elements.
#[derive(Default)]
struct Hydrodynamics {
    added: Matrix6<f64>,
    linear: Matrix6<f64>,
    absolute: Vec<(usize, usize, usize, f64)>,
    product: Vec<(usize, usize, usize, f64)>,
}

impl Hydrodynamics {
    fn read(plugin: Node<'_, '_>) -> Hydrodynamics {
        let mut found = Hydrodynamics::default();
        let velocity = |c: &str| "UVWPQR".find(c).filter(|_| c.len() == 1);
        for element in plugin.children().filter(Node::is_element) {
            let name = element.tag_name().name();
            let (Some(row), rest) = ("xyzkmn".find(&name[..1]), &name[1..]) else { continue };
            let pair = |text: &str| Some((velocity(text.get(..1)?)?, velocity(text.get(1..)?)?));
            if let Some(j) = rest.strip_prefix("Dot").and_then(velocity) {
                found.added[(row, j)] = number(element);
            } else if let Some(j) = velocity(rest) {
                found.linear[(row, j)] = number(element);
            } else if let Some((j, k)) = rest.split_once("abs").and_then(|(j, k)| Some((velocity(j)?, velocity(k)?))) {
                found.absolute.push((row, j, k, number(element)));
            } else if let Some((j, k)) = pair(rest) {
                found.product.push((row, j, k, number(element)));
            }
        }
        found
    }

    /// Force of the damping: D_ij = −(linear + absolute |ν_k| + product ν_k), F = −D ν.
    fn force(&self, nu: &Vector6<f64>) -> Vector6<f64> {
        let mut d = -self.linear;
        for (i, j, k, x) in &self.absolute {
            d[(*i, *j)] -= x * nu[*k].abs();
        }
        for (i, j, k, x) in &self.product {
            d[(*i, *j)] -= x * nu[*k];
        }
        -d * nu
    }
}

/// Tolerance of the motion: the integrators of the library and of these tests differ by a few parts
/// in a million where drag changes its sign.
const FINE: f64 = 2e-5;

/// Motion of a gz-sim file in forward-starboard-down axes: M a = τ − C(M) ν + damping, where M is
/// the inertia in the engine. An explicit added mass is taken in the limit of short steps, as
/// −M_A a on the right-hand side.
fn gazebo_path(export: &Export, dofs: &[Dof]) -> Vec<Vector6<f64>> {
    let text = text(export);
    let document = Document::parse(&text).expect("it is XML");
    let inertial = child(document.root(), "inertial");
    let plugin = child(document.root(), "plugin");
    assert_eq!(plugin.attribute("filename"), Some("gz-sim-hydrodynamics-system"));
    assert_eq!(child(plugin, "disable_coriolis").text(), Some("true"));
    let mut engine = rigid(inertial);
    if let Some(fluid) = inertial.children().find(|n| n.has_tag_name("fluid_added_mass")) {
        assert_eq!(fluid.children().filter(Node::is_element).count(), 21, "the upper triangle");
        for cell in fluid.children().filter(Node::is_element) {
            let axis = |c: &str| "xyzpqr".find(c).expect("it is an axis");
            let (i, j) = (axis(&cell.tag_name().name()[..1]), axis(&cell.tag_name().name()[1..]));
            engine[(i, j)] += number(cell);
            if i != j {
                engine[(j, i)] += number(cell);
            }
        }
    }
    let system = Hydrodynamics::read(plugin);
    let samples = samples(dofs);
    let inverse = (engine - system.added).try_inverse().expect("the inertia is regular");
    let rate =
        |t: f64, nu: &Vector6<f64>| inverse * (turn(&force(&samples, t)) + coriolis(&engine, nu) + system.force(nu));
    integrate(&rate).iter().map(turn).collect()
}

#[test]
fn gazebo_moves_as_the_model_with_added_mass_in_the_engine_or_in_the_system() {
    let file = planar(&COUPLED);
    let truth = truth(&file);
    for target in [Target::Gazebo, Target::GazeboAddedMass] {
        let export = made(&file, target, &ExportOptions::default());
        assert!(export.lost.is_empty(), "{:?}", export.lost);
        assert_same(&gazebo_path(&export, &PLANAR), &truth, FINE);
    }
}

#[test]
fn gazebo_holds_added_mass_once_with_the_sign_of_its_form() {
    let file = planar(&[]);
    let explicit = text(&made(&file, Target::Gazebo, &ExportOptions::default()));
    let engine = text(&made(&file, Target::GazeboAddedMass, &ExportOptions::default()));
    assert!(explicit.contains("<xDotU>-50</xDotU>") && !explicit.contains("<fluid_added_mass>"));
    assert!(engine.contains("<xx>50</xx>") && !engine.contains("<xDotU>"));
    for text in [explicit, engine] {
        assert!(text.contains("<xU>-20</xU>") && text.contains("<xUabsU>-120</xUabsU>"));
        assert!(text.contains("forward-port-up") && text.contains("Target: gazebo"));
    }
}

#[test]
fn cross_terms_of_six_degrees_of_freedom_turn_with_the_axes() {
    let mut terms: Vec<(&str, f64)> = vec![
        ("inertia@surge", 250.0),
        ("inertia@sway", 320.0),
        ("inertia@heave", 340.0),
        ("inertia@roll", 30.0),
        ("inertia@pitch", 45.0),
        ("inertia@yaw", 60.0),
        ("added_mass_coupling@surge:pitch", 8.0),
        ("added_mass_coupling@sway:roll", -6.0),
        ("added_mass_coupling@sway:yaw", 9.0),
        ("added_mass_coupling@heave:yaw", 4.0),
        ("cross_drag@pitch:heave", 11.0),
        ("linear_cross_damping@roll:sway", 5.0),
        ("mixed_drag@heave:surge", 40.0),
        ("drag_asymmetry@heave", 60.0),
        ("drag_asymmetry@pitch", 6.0),
    ];
    let each = ["surge", "sway", "heave", "roll", "pitch", "yaw"];
    let drag: Vec<String> = each.iter().map(|d| format!("linear_drag@{d}")).collect();
    let square: Vec<String> = each.iter().map(|d| format!("quadratic_drag@{d}")).collect();
    let rows: Vec<String> = each.iter().map(|d| format!("coriolis_{d}")).collect();
    for (k, name) in drag.iter().enumerate() {
        terms.push((name, [40.0, 50.0, 60.0, 12.0, 14.0, 15.0][k]));
    }
    for (k, name) in square.iter().enumerate() {
        terms.push((name, [120.0, 200.0, 240.0, 10.0, 12.0, 20.0][k]));
    }
    terms.extend(rows.iter().map(|name| (name.as_str(), 0.0)));
    let mut file = file(&Dof::ALL, &terms, Coriolis::Tied);
    file.vehicle.cg = Some([0.05, 0.02, 0.03]);
    let options = ExportOptions { inertia: Some([20.0, 25.0, 28.0]), ..ExportOptions::default() };
    let truth = truth(&file);
    for target in [Target::Gazebo, Target::GazeboAddedMass] {
        let export = made(&file, target, &options);
        assert!(export.lost.is_empty(), "{:?}", export.lost);
        assert_same(&gazebo_path(&export, &Dof::ALL), &truth, FINE);
    }
    let export = made(&file, Target::FossenMatlab, &options);
    assert_same(&matlab_path(&text(&export), &Dof::ALL), &truth, FINE);
}

#[test]
fn free_coriolis_coefficients_survive_in_gazebo() {
    let mut file = planar(&[]);
    file.model.coriolis = Coriolis::Free;
    for (name, value) in [("coriolis_surge", 280.0), ("coriolis_sway", 240.0), ("coriolis_yaw", 95.0)] {
        let free = Model::with_effects(&PLANAR, Coriolis::Free, &[name]).expect("it can stand there");
        let p = &free.parameters[0];
        file.parameters.push(ModelParameter {
            effect: name.into(),
            name: p.spec.name.clone(),
            value,
            std: None,
            unit: p.spec.dimension,
            fixed: false,
            per_run: BTreeMap::new(),
        });
    }
    let truth = truth(&file);
    for target in [Target::Gazebo, Target::GazeboAddedMass] {
        let export = made(&file, target, &ExportOptions::default());
        assert!(codes(&export).contains("X014"), "{:?}", export.warnings);
        assert_same(&gazebo_path(&export, &PLANAR), &truth, FINE);
    }
}

/// Motion by the equations of the MATLAB function, with the numbers in its text.
fn matlab_path(text: &str, dofs: &[Dof]) -> Vec<Vector6<f64>> {
    let matrix = |name: &str| {
        let rest = text.split_once(&format!("vehicle.{name} = [")).expect("the matrix is there").1;
        let inside = rest.split_once(']').expect("it is closed").0;
        let cells: Vec<f64> =
            inside.split([';', '\n', ' ']).filter(|x| !x.is_empty()).map(|x| x.parse().expect("a number")).collect();
        Matrix6::from_row_slice(&cells)
    };
    let cells = |name: &str| -> Vec<([usize; 3], f64)> {
        let start = format!("vehicle.{name}(");
        let read = |line: &str| {
            let (index, value) = line.strip_prefix(&start)?.split_once(") = ")?;
            let index: Vec<usize> = index.split(", ").map(|i| i.parse::<usize>().expect("an index") - 1).collect();
            Some(([index[0], index[1], index[2]], value.trim_end_matches(';').parse().expect("a number")))
        };
        text.lines().filter_map(read).collect()
    };
    let m = matrix("M_RB") + matrix("M_A");
    let (damping, quadratic, products) = (matrix("D"), cells("D_n"), cells("N"));
    assert!(text.contains("M_RB + vehicle.M_A"));
    let inverse = m.try_inverse().expect("the inertia is regular");
    let samples = samples(dofs);
    integrate(&|t, nu| {
        let mut f = force(&samples, t) + coriolis(&m, nu) - damping * nu;
        for ([i, j, k], d) in &quadratic {
            f[*i] -= d * nu[*j] * nu[*k].abs();
        }
        for ([i, j, k], n) in &products {
            f[*i] += n * nu[*j] * nu[*k];
        }
        inverse * f
    })
}

#[test]
fn fossens_matrices_move_as_the_model() {
    let file = planar(&COUPLED);
    let export = made(&file, Target::FossenMatlab, &ExportOptions::default());
    assert!(export.lost.is_empty(), "{:?}", export.lost);
    assert_same(&matlab_path(&text(&export), &PLANAR), &truth(&file), FINE);
}

#[test]
fn what_no_simulator_of_coefficients_can_do_is_named() {
    let file = planar(&[("cubic_drag@surge", 30.0), ("thrust_lag", 0.3), ("current", 0.1), ("bias@yaw", 0.4)]);
    let export = made(&file, Target::GazeboAddedMass, &ExportOptions::default());
    assert_eq!(export.lost, ["thrust_lag", "cubic_drag@surge", "N_0"].map(str::to_string).to_vec());
    assert!(codes(&export).is_superset(&BTreeSet::from(["X001", "X002", "X003", "X004", "X005"])));
    assert!(text(&export).contains("LOST"));
}

#[test]
fn added_mass_that_would_blow_up_is_told_before_it_does() {
    let heavy = planar(&[]);
    let options = ExportOptions { mass: Some(100.0), ..ExportOptions::default() };
    let export = made(&heavy, Target::Gazebo, &options);
    assert!(codes(&export).contains("X008"), "320 − 100 is more than 100");
    assert!(!codes(&made(&heavy, Target::GazeboAddedMass, &options)).contains("X008"));
    // the scheme of gz-sim: the force of the added mass is that of the acceleration of the step before
    let diverges = |rigid: f64, added: f64| {
        let (mut a, mut v): (f64, f64) = (0.0, 0.0);
        for _ in 0..2000 {
            a = (10.0 - 20.0 * v - added * a) / rigid;
            v += 0.001 * a;
        }
        v.is_nan() || v.abs() > 10.0
    };
    assert!(diverges(100.0, 220.0) && !diverges(200.0, 120.0));
    assert!(!codes(&made(&heavy, Target::Gazebo, &ExportOptions::default())).contains("X008"));
}

#[test]
fn a_negative_added_mass_and_an_unknown_mass_are_told() {
    let export = made(&planar(&[]), Target::Gazebo, &ExportOptions { mass: Some(300.0), ..ExportOptions::default() });
    assert!(export.warnings.iter().any(|w| w.code == "X007" && w.message.contains("surge")));
    let mut unknown = planar(&[]);
    unknown.vehicle.mass = None;
    let error = export_model(&unknown, Path::new(PATH), Target::Uuv, &ExportOptions::default()).unwrap_err();
    assert!(error.to_string().contains("--mass"), "{error}");
    let wrong = ExportOptions { inertia: Some([1.0, -1.0, 1.0]), ..ExportOptions::default() };
    let error = export_model(&planar(&[]), Path::new(PATH), Target::Uuv, &wrong).unwrap_err();
    assert_eq!(error.to_string(), "inertia = -1: must be a finite number above 0");
}

#[test]
fn the_linear_model_moves_as_the_model_near_its_point() {
    let file = planar(&COUPLED);
    let at = BTreeMap::from([("u".to_string(), 0.6), ("r".to_string(), 0.1)]);
    let options = ExportOptions { at, ..ExportOptions::default() };
    let json: serde_json::Value =
        serde_json::from_slice(&made(&file, Target::LinearJson, &options).bytes).expect("it is JSON");
    let rows = |name: &str| -> Vec<Vec<f64>> { serde_json::from_value(json[name].clone()).expect("it is a matrix") };
    let (a, b) = (rows("A"), rows("B"));
    assert_eq!(json["states"], serde_json::json!(["u", "v", "r", "psi"]));
    // compared with differences of the nonlinear equations, by the formulas of the MATLAB function
    let script = text(&made(&file, Target::FossenMatlab, &ExportOptions::default()));
    let accelerate = |nu: [f64; 3], tau: [f64; 3]| acceleration(&script, nu, tau);
    let (x0, tau0) = ([0.6, 0.0, 0.1], [0, 1, 2].map(|k| json["tau0"][k].as_f64().expect("a number")));
    assert!(accelerate(x0, tau0).iter().all(|a| a.abs() < 1e-6), "the point is held");
    let step = 1e-6;
    for k in 0..3 {
        let (mut x, mut tau) = (x0, tau0);
        x[k] += step;
        tau[k] += step;
        for i in 0..3 {
            // one-sided differences of |ν| terms have an error of the size of the step
            assert!((accelerate(x, tau0)[i] / step - a[i][k]).abs() < 1e-4, "A[{i}][{k}]");
            assert!((accelerate(x0, tau)[i] / step - b[i][k]).abs() < 1e-6, "B[{i}][{k}]");
        }
    }
}

/// ν̇ in surge, sway and yaw with the numbers of the MATLAB function.
fn acceleration(script: &str, nu: [f64; 3], tau: [f64; 3]) -> [f64; 3] {
    let grab = |name: &str| {
        let rest = script.split_once(&format!("vehicle.{name} = [")).expect("the matrix is there").1;
        let inside = rest.split_once(']').expect("it is closed").0;
        let cells: Vec<f64> =
            inside.split([';', '\n', ' ']).filter(|x| !x.is_empty()).map(|x| x.parse().expect("a number")).collect();
        Matrix6::from_row_slice(&cells)
    };
    let full = |x: [f64; 3]| Vector6::new(x[0], x[1], 0.0, 0.0, 0.0, x[2]);
    let (m, nu, tau) = (grab("M_RB") + grab("M_A"), full(nu), full(tau));
    let mut f = tau + coriolis(&m, &nu) - grab("D") * nu;
    for (name, absolute) in [("D_n", true), ("N", false)] {
        for line in script.lines().filter_map(|l| l.strip_prefix(&format!("vehicle.{name}("))) {
            let (index, value) = line.split_once(") = ").expect("an entry");
            let index: Vec<usize> = index.split(", ").map(|i| i.parse::<usize>().expect("an index") - 1).collect();
            let value: f64 = value.trim_end_matches(';').parse().expect("a number");
            let (j, k) = (nu[index[1]], nu[index[2]]);
            f[index[0]] += if absolute { -value * j * k.abs() } else { value * j * k };
        }
    }
    let a = m.try_inverse().expect("the inertia is regular") * f;
    [a[0], a[1], a[5]]
}
