//! The exported file for uuv_simulator and DAVE moves as the model does for a minute, by the update
//! of the plugin.
//!
//! The update is written from uuv_simulator 0.6.13, `uuv_gazebo_plugins/src/HydrodynamicModel.cc` (`ToNED`,
//! `ComputeAcc`, `ComputeAddedCoriolisMatrix`, `ComputeDampingMatrix`, `ApplyHydrodynamicForces`) and
//! `BuoyantObject.cc`; forces and buoyancy act at the centre of mass, velocities are those of the link.

use crate::exported::engine::{Forces, GRAVITY, Link, Seen};
use crate::exported::quoted::assert_quoted;
use crate::exported::*;
use hydrosysid::export::{ExportOptions, Target};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use roxmltree::Document;

/// `HMFossen` of the plugin.
struct Fossen {
    added: Matrix6<f64>,
    linear: Matrix6<f64>,
    forward: Matrix6<f64>,
    quadratic: Vector6<f64>,
    volume: f64,
    density: f64,
    buoyancy: Vector3<f64>,
    filtered: Vector6<f64>,
    last: Vector6<f64>,
}

impl Fossen {
    fn read(document: &Document<'_>) -> Fossen {
        let model = child(document.root(), "hydrodynamic_model");
        assert_eq!(child(model, "type").text(), Some("fossen"));
        let matrix = |name: &str| Matrix6::from_row_slice(&numbers(child(model, name)));
        Fossen {
            added: matrix("added_mass"),
            linear: matrix("linear_damping"),
            forward: matrix("linear_damping_forward_speed"),
            quadratic: Vector6::from_row_slice(&numbers(child(model, "quadratic_damping"))),
            volume: number(child(document.root(), "volume")),
            density: number(child(document.root(), "fluid_density")),
            buoyancy: Vector3::from_row_slice(&numbers(child(document.root(), "center_of_buoyancy"))),
            filtered: Vector6::zeros(),
            last: Vector6::zeros(),
        }
    }

    fn update(&mut self, seen: &Seen) -> Forces {
        // ToNED
        let nu = turn(&seen.nu);
        self.filtered = 0.7 * self.filtered + 0.3 * (nu - self.last) / seen.step;
        self.last = nu;
        let mut damping = -self.linear - nu[0] * self.forward;
        for i in 0..6 {
            damping[(i, i)] -= self.quadratic[i] * nu[i].abs();
        }
        let hydrodynamic = -damping * nu - self.added * self.filtered + coriolis(&self.added, &nu);
        // buoyancy, upwards in the world, at its position relative to the centre of mass
        let up = seen.attitude.inverse() * Vector3::new(0.0, 0.0, self.volume * self.density * GRAVITY);
        let moment = self.buoyancy.cross(&up);
        let buoyant = Vector6::new(up[0], up[1], up[2], moment[0], moment[1], moment[2]);
        Forces { at_centre: turn(&hydrodynamic) + buoyant, ..Forces::default() }
    }
}

/// The link as the comment of the file describes it.
fn link(text: &str) -> Link {
    let after = |start: &str| text.split_once(start).unwrap_or_else(|| panic!("{start} is told")).1;
    let until = |text: &str, end: &str| text.split_once(end).expect("the line ends").0.to_string();
    let list = |text: String| -> Vec<f64> {
        text.split_whitespace().map(|x| x.trim_end_matches(',').parse().expect("a number")).collect()
    };
    let mass = list(until(after("of the link: mass "), " kg"))[0];
    let centre = list(until(after("centre of gravity "), "\n"));
    let inertia = list(until(after("ixx iyy izz about it: "), ", products 0"));
    Link {
        mass,
        centre: Vector3::from_row_slice(&centre),
        inertia: Matrix3::from_diagonal(&Vector3::from_row_slice(&inertia)),
        fluid: Matrix6::zeros(),
    }
}

/// Couplings that the plugin can represent.
const HELD: [(&str, f64); 4] = [
    ("linear_cross_damping@sway:yaw", 12.0),
    ("linear_cross_damping@roll:sway", 5.0),
    ("linear_cross_damping@surge:pitch", 9.0),
    ("added_mass_coupling@roll:yaw", 3.0),
];

fn moved(text: &str) -> Vec<Vector6<f64>> {
    let document = Document::parse(text).expect("it is XML");
    let mut plugin = Fossen::read(&document);
    let samples = samples(&hydrosysid::frame::Dof::ALL);
    link(text).run([0.001, STEP, SECONDS], &|t| force(&samples, t), &mut |seen| plugin.update(seen))
}

#[test]
fn the_plugin_moves_as_the_model_with_a_centre_of_gravity_off_the_origin() {
    let file = floating(&HELD);
    let options = ExportOptions { inertia: Some([20.0, 25.0, 28.0]), ..ExportOptions::default() };
    let export = made(&file, Target::Uuv, &options);
    assert!(export.lost.is_empty(), "{:?}", export.lost);
    // the engine has steps of 1 ms, and its filtered acceleration is 2 ms late
    assert_quoted(Target::Uuv, &moved(&text(&export)), &truth(&file));
}

#[test]
fn cross_terms_turned_to_the_axes_of_the_link_would_move_another_way() {
    let file = floating(&HELD);
    let options = ExportOptions { inertia: Some([20.0, 25.0, 28.0]), ..ExportOptions::default() };
    let text = text(&made(&file, Target::Uuv, &options));
    // a file for a plugin in forward-port-up axes would have X_q and Y_r with the other sign
    let document = Document::parse(&text).expect("it is XML");
    let linear = numbers(child(document.root(), "linear_damping"));
    assert!((linear[4] + 9.0).abs() < 1e-9 && (linear[11] + 12.0).abs() < 1e-9, "forward-starboard-down");
    assert!((numbers(child(document.root(), "added_mass"))[23] - 3.0).abs() < 1e-9);
}
