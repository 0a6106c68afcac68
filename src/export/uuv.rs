//! uuv_simulator and DAVE: the underwater object plugin with the model `fossen`.
//!
//! ```text
//! F = −M_A ν̇ − C_A(ν) ν − D(ν) ν,   D = −D_lin − u D_fwd − diag(D_quad |ν|)
//! ```
//!
//! `added_mass` is positive, the dampings have SNAME's signs. D_fwd holds the products with the forward velocity.
//! Source: uuv_simulator, `HydrodynamicModel.cc`; Fossen (2011), eq. 6.43, 8.136.

use super::body::{added_share, split, turned, turned_absolute, turned_place, turned_product};
use super::buoyancy::buoyancy;
use super::coefficients::{Matrix, coefficients};
use super::header::{Cell, Draft};
use super::number::{number, numbers};
use super::xml::Xml;
use super::{Export, ExportError, ExportOptions, Source, Target, codes};
use crate::finding::Finding;

/// Added over rigid mass from which the filtered acceleration of the plugin blows up: it holds a share of 0.3 of the
/// acceleration of the step before, so that a ← 0.7 a − 0.3 s a diverges beyond s = 1.7/0.3.
const MOST: f64 = 1.7 / 0.3;

pub(super) fn export(source: &Source<'_>, options: &ExportOptions) -> Result<Export, ExportError> {
    let found = coefficients(source.model);
    let vehicle = &source.file.vehicle;
    let mut draft = Draft::new(Target::Uuv);
    draft.left_out(&found);
    draft.not_modelled(&found);
    let parts = split(&found, vehicle, options, &mut draft.warnings)?;
    draft.body(&parts);
    draft.cancelled(&found, &parts.rest);
    draft.missing(&found, &parts.rest, &parts.added, &|cell| match cell {
        Cell::Linear(..) | Cell::Added(..) => true,
        Cell::Absolute(i, j, k) => i == j && j == k,
        Cell::Product(_, j, _) => j == 0,
        Cell::Constant(_) => false,
    });
    let share = added_share(&parts);
    if share >= MOST {
        let text = format!(
            "the added mass is up to {share:.2} times the rigid mass: the plugin applies it from filtered earlier accelerations and is unstable from {MOST:.2} on"
        );
        draft.warnings.push(Finding::new(&codes::UNSTABLE, text));
    }
    let held = buoyancy(&found, source.model, &parts.body, vehicle, &source.file.water);
    let head = draft.head(
        source,
        &[
            "Signs: added_mass positive; linear_damping, quadratic_damping negative where they brake",
            "Axes: forward-port-up at the body origin, SI units; the model's are forward-starboard-down: cross terms are turned",
            "The link needs the mass and inertia told below; add a <box> where the vehicle comes near the surface",
        ],
    );
    let mut xml = Xml::new(&head);
    let link = options.link.as_deref().unwrap_or("base_link");
    let forward = turned_product(&parts.rest);
    let forward: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| forward[i][0][j]));
    let absolute = turned_absolute(&found.absolute);
    let quadratic: [f64; 6] = std::array::from_fn(|i| absolute[i][i][i]);
    xml.open("gazebo", &[]);
    let body = &parts.body;
    xml.comment(&[
        format!(
            "<inertial> of the link: mass {} kg, centre of gravity {}",
            number(body.mass),
            numbers(&turned_place(body.cg), " ")
        ),
        format!("ixx iyy izz ixy ixz iyz about it: {}", {
            let [ixx, iyy, izz, ixy, ixz, iyz] = body.central();
            numbers(&[ixx, iyy, izz, -ixy, -ixz, iyz], " ")
        }),
    ]);
    xml.open("plugin", &[("name", "uuv_plugin"), ("filename", "libuuv_underwater_object_ros_plugin.so")]);
    xml.leaf("fluid_density", &number(source.file.water.density));
    xml.leaf("flow_velocity_topic", "hydrodynamics/current_velocity");
    xml.open("link", &[("name", link)]);
    xml.leaf("neutrally_buoyant", "0");
    xml.leaf("volume", &number(held.volume));
    xml.leaf("center_of_buoyancy", &numbers(&turned_place(held.centre), " "));
    xml.open("hydrodynamic_model", &[]);
    xml.leaf("type", "fossen");
    xml.leaf("added_mass", &rows(&turned(&parts.added)));
    xml.leaf("linear_damping", &rows(&turned(&found.linear)));
    xml.leaf("linear_damping_forward_speed", &rows(&forward));
    xml.leaf("quadratic_damping", &numbers(&quadratic, " "));
    Ok(draft.finish(xml.finish()))
}

fn rows(m: &Matrix) -> String {
    m.iter().map(|row| numbers(row, " ")).collect::<Vec<_>>().join(" ")
}
