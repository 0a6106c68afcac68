//! The exported URDF moves as the model does for a minute, by the equations of the library that reads it.
//!
//! The equations are written from the Robotic Decision Making Laboratory's `hydrodynamics` (2025),
//! `src/hydrodynamics.cpp`: `parse_model_from_xml`, `Inertia`, `Coriolis`, `Damping`,
//! `RestoringForces`, `forward_dynamics`.

use crate::exported::quoted::assert_quoted;
use crate::exported::*;
use hydrosysid::export::{ExportOptions, Target};
use hydrosysid::frame::Dof;
use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3, Vector6};
use roxmltree::{Document, Node};

/// `Params` of the library.
struct Params {
    rigid: Matrix6<f64>,
    added: Matrix6<f64>,
    linear: Vector6<f64>,
    quadratic: Vector6<f64>,
    weight: f64,
    buoyancy: f64,
    gravity_at: Vector3<f64>,
    buoyancy_at: Vector3<f64>,
}

fn attribute(node: Node<'_, '_>, name: &str) -> f64 {
    let text = node.attribute(name).unwrap_or_else(|| panic!("{} has {name}", node.tag_name().name()));
    text.parse().expect("it is a number")
}

/// A direct child element of `parent`, as the library looks for it.
fn own<'a, 'i>(parent: Node<'a, 'i>, name: &str) -> Node<'a, 'i> {
    parent.children().find(|n| n.has_tag_name(name)).unwrap_or_else(|| panic!("there is a <{name}>"))
}

impl Params {
    fn parse(text: &str) -> Params {
        let document = Document::parse(text).expect("it is XML");
        assert_eq!(document.root_element().tag_name().name(), "robot");
        let hydrodynamics = own(document.root_element(), "hydrodynamics");
        let inertial = own(hydrodynamics, "inertial");
        let (damping, statics) = (own(hydrodynamics, "damping"), own(hydrodynamics, "hydrostatics"));
        let six = |node: Node<'_, '_>, names: [&str; 6]| Vector6::from_iterator(names.map(|n| attribute(node, n)));
        let place = |parent, name| Vector3::from_iterator(["x", "y", "z"].map(|n| attribute(own(parent, name), n)));
        let mass = attribute(own(inertial, "mass"), "value");
        let centre: Vector3<f64> = place(inertial, "center_of_gravity");
        let moments = Vector3::from_iterator(["ixx", "iyy", "izz"].map(|n| attribute(own(inertial, "inertia"), n)));
        let mut rigid = Matrix6::zeros();
        rigid.fixed_view_mut::<3, 3>(0, 0).copy_from(&(mass * Matrix3::identity()));
        rigid.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-mass * centre.cross_matrix()));
        rigid.fixed_view_mut::<3, 3>(3, 0).copy_from(&(mass * centre.cross_matrix()));
        rigid.fixed_view_mut::<3, 3>(3, 3).copy_from(&Matrix3::from_diagonal(&moments));
        let added = six(own(inertial, "added_mass"), ["Xdu", "Ydv", "Zdw", "Kdp", "Mdq", "Ndr"]);
        Params {
            rigid,
            added: Matrix6::from_diagonal(&-added),
            linear: -six(own(damping, "linear"), ["Xu", "Yv", "Zw", "Kp", "Mq", "Nr"]),
            quadratic: -six(own(damping, "quadratic"), ["Xuu", "Yvv", "Zww", "Kpp", "Mqq", "Nrr"]),
            weight: mass * 9.81,
            buoyancy: attribute(own(statics, "buoyancy"), "value"),
            gravity_at: centre,
            buoyancy_at: place(statics, "center_of_buoyancy"),
        }
    }

    fn restoring(&self, attitude: &Rotation3<f64>) -> Vector6<f64> {
        let back = attitude.inverse();
        let (down, up) = (back * Vector3::new(0.0, 0.0, self.weight), back * Vector3::new(0.0, 0.0, -self.buoyancy));
        let (force, moment) = (down + up, self.gravity_at.cross(&down) + self.buoyancy_at.cross(&up));
        -Vector6::new(force[0], force[1], force[2], moment[0], moment[1], moment[2])
    }

    fn forward(&self, nu: &Vector6<f64>, tau: &Vector6<f64>, attitude: &Rotation3<f64>) -> Vector6<f64> {
        let mass = self.rigid + self.added;
        let damping = (self.linear + self.quadratic.component_mul(&nu.abs())).component_mul(nu);
        let force = tau + coriolis(&self.rigid, nu) + coriolis(&self.added, nu) - damping - self.restoring(attitude);
        mass.try_inverse().expect("the inertia is regular") * force
    }

    /// Velocities at the samples: the midpoint rule at 2 ms.
    fn run(&self) -> Vec<Vector6<f64>> {
        let samples = samples(&Dof::ALL);
        let (h, steps) = (STEP / 50.0, 50);
        let (mut nu, mut attitude) = (Vector6::zeros(), Rotation3::identity());
        let mut path = vec![nu];
        let turned =
            |r: &Rotation3<f64>, nu: &Vector6<f64>, h: f64| *r * Rotation3::new(h * Vector3::new(nu[3], nu[4], nu[5]));
        for k in 0..(SECONDS / h).round() as usize {
            let t = h * k as f64;
            let half = nu + 0.5 * h * self.forward(&nu, &force(&samples, t), &attitude);
            let between = turned(&attitude, &nu, 0.5 * h);
            nu += h * self.forward(&half, &force(&samples, t + 0.5 * h), &between);
            attitude = turned(&attitude, &half, h);
            if (k + 1) % steps == 0 {
                path.push(nu);
            }
        }
        path
    }
}

/// A model whose couplings of inertia are those of the rigid body, so that its added mass is diagonal.
fn diagonal() -> hydrosysid::campaign::ModelFile {
    let mut file = floating(&[]);
    let rigid = [("surge:pitch", 6.0), ("sway:roll", -6.0), ("sway:yaw", 10.0), ("heave:pitch", -10.0)];
    for p in &mut file.parameters {
        if let Some((_, value)) = rigid.iter().find(|(at, _)| p.effect == format!("added_mass_coupling@{at}")) {
            p.value = *value;
        }
    }
    file
}

const INERTIA: Option<[f64; 3]> = Some([20.0, 25.0, 28.0]);

#[test]
fn the_library_moves_as_the_model() {
    let file = diagonal();
    let export = made(&file, Target::Urdf, &ExportOptions { inertia: INERTIA, ..ExportOptions::default() });
    assert!(export.lost.is_empty(), "{:?}", export.lost);
    // two integrators of the same equations
    assert_quoted(Target::Urdf, &Params::parse(&text(&export)).run(), &truth(&file));
}

#[test]
fn the_link_is_the_rigid_body_as_every_reader_of_urdf_takes_it() {
    let file = diagonal();
    let text = text(&made(&file, Target::Urdf, &ExportOptions { inertia: INERTIA, ..ExportOptions::default() }));
    let document = Document::parse(&text).expect("it is XML");
    let inertial = own(own(document.root_element(), "link"), "inertial");
    // forward-port-up: a point below the origin has a negative z
    assert_eq!(own(inertial, "origin").attribute("xyz"), Some("0.05 0 -0.03"));
    let central = attribute(own(inertial, "inertia"), "iyy");
    // 25 − m (x² + z²)
    assert!((central - (25.0 - 200.0 * (0.05 * 0.05 + 0.03 * 0.03))).abs() < 1e-9);
}

#[test]
fn what_the_diagonal_does_not_hold_is_named() {
    let file = planar(&COUPLED);
    let export =
        made(&file, Target::Urdf, &ExportOptions { inertia: Some([40.0, 45.0, 50.0]), ..ExportOptions::default() });
    let text = text(&export);
    let params = Params::parse(&text);
    // half of the drag asymmetry is even in u, the other half adds to the quadratic drag
    assert!((params.added[(0, 0)] - 50.0).abs() < 1e-9 && (params.quadratic[0] - 145.0).abs() < 1e-9);
    for name in ["Y_r", "N_v|v|", "N_r|u|", "X_uu", "Y_rdot", "N_vdot"] {
        assert!(export.lost.iter().any(|l| l == name), "{name} is told: {:?}", export.lost);
        assert!(text.contains(name), "{name} stands in the file");
    }
    assert!(codes(&export).contains("X002"));
}
