//! The exported file for gz-sim moves as the model does for a minute, by the update of its
//! Hydrodynamics system.
//!
//! The update is written from gz-sim 8, `src/systems/hydrodynamics/Hydrodynamics.cc` (`Configure`,
//! `PreUpdate`): the wrench is that of the state before the step, the force of the added mass that
//! of the acceleration of the step before, and the wrench acts at the origin of the link.

use crate::exported::engine::{Forces, GRAVITY, Link, Seen};
use crate::exported::quoted::assert_quoted;
use crate::exported::*;
use hydrosysid::export::{Export, ExportOptions, Target};
use hydrosysid::frame::Dof;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use roxmltree::{Document, Node};

/// Coefficients of the system by its own names; 0 if the file has none.
struct Hydrodynamics {
    added: Matrix6<f64>,
    linear: Matrix6<f64>,
    absolute: Vec<f64>,
    product: Vec<f64>,
    with_added: bool,
    before: Vector6<f64>,
}

impl Hydrodynamics {
    fn configure(plugin: Node<'_, '_>) -> Hydrodynamics {
        let (rows, velocities) = (["x", "y", "z", "k", "m", "n"], ["U", "V", "W", "P", "Q", "R"]);
        let value = |name: String| plugin.children().find(|n| n.has_tag_name(name.as_str())).map_or(0.0, number);
        let flag = |name: &str| child(plugin, name).text() == Some("true");
        assert!(flag("disable_coriolis"));
        let each = |name: &dyn Fn(usize, usize, usize) -> String| -> Vec<f64> {
            (0..216).map(|n| value(name(n / 36, n / 6 % 6, n % 6))).collect()
        };
        Hydrodynamics {
            added: Matrix6::from_fn(|i, j| value(format!("{}Dot{}", rows[i], velocities[j]))),
            linear: Matrix6::from_fn(|i, j| value(format!("{}{}", rows[i], velocities[j]))),
            absolute: each(&|i, j, k| format!("{}{}abs{}", rows[i], velocities[j], velocities[k])),
            product: each(&|i, j, k| format!("{}{}{}", rows[i], velocities[j], velocities[k])),
            with_added: plugin.children().all(|n| !n.has_tag_name("disable_added_mass")),
            before: Vector6::zeros(),
        }
    }

    fn update(&mut self, seen: &Seen) -> Forces {
        let rate = (seen.nu - self.before) / seen.step;
        self.before = seen.nu;
        let damping = Matrix6::from_fn(|i, j| {
            let quadratic = |k: usize| {
                let n = 36 * i + 6 * j + k;
                self.absolute[n] * seen.nu[k].abs() + self.product[n] * seen.nu[k]
            };
            -self.linear[(i, j)] - (0..6).map(quadratic).sum::<f64>()
        });
        let mut wrench = -damping * seen.nu;
        if self.with_added {
            wrench += self.added * rate;
        }
        Forces { at_origin: wrench, ..Forces::default() }
    }
}

fn link(inertial: Node<'_, '_>) -> Link {
    let pose = numbers(child(inertial, "pose"));
    let about = |name: &str| number(child(child(inertial, "inertia"), name));
    let [ixx, ixy, ixz, iyy, iyz, izz] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(about);
    let mut fluid = Matrix6::zeros();
    if let Some(cells) = inertial.children().find(|n| n.has_tag_name("fluid_added_mass")) {
        for cell in cells.children().filter(Node::is_element) {
            let axis = |c: &str| "xyzpqr".find(c).expect("it is an axis");
            let (i, j) = (axis(&cell.tag_name().name()[..1]), axis(&cell.tag_name().name()[1..]));
            (fluid[(i, j)], fluid[(j, i)]) = (number(cell), number(cell));
        }
    }
    Link {
        mass: number(child(inertial, "mass")),
        centre: Vector3::new(pose[0], pose[1], pose[2]),
        inertia: Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz),
        fluid,
    }
}

/// Motion in the simulator, with the buoyancy of the volume that the warning X012 states.
fn moved(export: &Export, step: f64) -> Vec<Vector6<f64>> {
    let text = text(export);
    let document = Document::parse(&text).expect("it is XML");
    let mut system = Hydrodynamics::configure(child(document.root(), "plugin"));
    let told = export.warnings.iter().find(|w| w.code == "X012").expect("the volume is told");
    let between = |start: &str, end: &str| {
        let rest = told.message.split_once(start).expect("it is told").1;
        rest.split_once(end).expect("it ends").0.to_string()
    };
    let volume: f64 = between("volume must be ", " m3").parse().expect("a number");
    let at: Vec<f64> = between("centre at ", " (").split(", ").map(|x| x.parse().expect("a number")).collect();
    let at = Vector3::from_row_slice(&at);
    let samples = samples(&Dof::ALL);
    let mut plugin = |seen: &Seen| {
        let mut forces = system.update(seen);
        let up = seen.attitude.inverse() * Vector3::new(0.0, 0.0, 1000.0 * volume * GRAVITY);
        let moment = at.cross(&up);
        forces.at_origin += Vector6::new(up[0], up[1], up[2], moment[0], moment[1], moment[2]);
        forces
    };
    link(child(document.root(), "inertial")).run([step, STEP, SECONDS], &|t| force(&samples, t), &mut plugin)
}

#[test]
fn the_system_moves_as_the_model_in_both_forms() {
    let file = floating(&EVERY_COUPLING);
    let options = ExportOptions { inertia: Some([20.0, 25.0, 40.0]), ..ExportOptions::default() };
    let truth = truth(&file);
    for target in [Target::GazeboAddedMass, Target::Gazebo] {
        let export = made(&file, target, &options);
        assert!(export.lost.is_empty(), "{:?}", export.lost);
        // steps of 1 ms, forces of the step before
        assert_quoted(target, &moved(&export, 0.001), &truth);
    }
}

#[test]
fn a_version_that_reads_no_couplings_is_refused() {
    let options = |version: &str| ExportOptions { version: Some(version.into()), ..ExportOptions::default() };
    let path = std::path::Path::new(PATH);
    let refused = hydrosysid::export::export_model(&planar(&[]), path, Target::Gazebo, &options("7.1")).unwrap_err();
    assert!(refused.to_string().contains("needs gz-sim 7.2"), "{refused}");
    assert!(codes(&made(&planar(&[]), Target::Gazebo, &options("9"))).contains("X020"));
    assert!(!codes(&made(&planar(&[]), Target::GazeboAddedMass, &options("9"))).contains("X020"));
}
