//! uuv_simulator and DAVE: the underwater object plugin with the model `fossen`.
//!
//! ```text
//! F = −M_A ν̇ − C_A(ν) ν − D(ν) ν,   D = −D_lin − u D_fwd − diag(D_quad |ν|)
//! ```
//!
//! The plugin converts velocities by `ToNED` before it multiplies, and converts forces back: its
//! matrices are in forward-starboard-down axes like those of the model, while positions and the
//! link are in forward-port-up axes. It reads velocities at the link and applies forces and
//! buoyancy at the centre of mass. So the centre of mass of the link is put at the body origin; the
//! couplings m r_g of the rigid body go into `added_mass`, and its righting moment into the centre
//! of buoyancy, r_b B − r_g W. The motion is that of the vehicle, also in a steady current, because
//! m r_g has the form of an added mass. `added_mass` is positive, the dampings have SNAME's signs,
//! D_fwd contains the products with the forward velocity. Source: uuv_simulator 0.6,
//! `HydrodynamicModel.cc`, `BuoyantObject.cc`; Fossen (2011), eq. 6.43, 8.136.

use super::body::{Body, added_share, split, turned_place};
use super::buoyancy::buoyancy;
use super::coefficients::{Matrix, coefficients};
use super::header::{Bounds, Cell, Draft};
use super::number::{number, numbers};
use super::stability::{longest_step, told, with_late_added_mass};
use super::xml::Xml;
use super::{Export, ExportError, ExportOptions, Source, Target, codes};
use crate::finding::Finding;

/// Ratios s of added to rigid inertia between which the filtered acceleration of the plugin is
/// stable. The filter takes 0.3 of its value from the acceleration of the previous step, so
/// a ← (0.7 − 0.3 s) a, which decays for −1 < s < 1.7/0.3.
const STABLE: [f64; 2] = [-1.0, 1.7 / 0.3];

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
    // the link's own inertia, and the inertia that the plugin has to add
    let body = Body { cg: [0.0; 3], ..parts.body };
    let (own, whole) = (body.matrix(), parts.body.matrix());
    let added: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| parts.added[i][j] + whole[i][j] - own[i][j]));
    let [least, most] = added_share(&own, &added);
    if least <= STABLE[0] || most >= STABLE[1] {
        let text = format!(
            "the added mass is {least:.2} to {most:.2} times the rigid mass: the plugin applies it from filtered \
             earlier accelerations, which is stable only between {} and {:.2}",
            STABLE[0], STABLE[1]
        );
        draft.warnings.push(Finding::new(&codes::UNSTABLE, text));
    }
    let held = buoyancy(&found, source.model, &parts.body, vehicle, &source.file.water);
    let gravity = held.weight / body.mass;
    let centre = turned_place(std::array::from_fn(|i| held.centre[i] - parts.body.cg[i] * held.weight / held.up()));
    let longest = longest_step(&found, &parts, &source.file.envelope);
    let stability = format!(
        "added over rigid inertia, {least:.2} to {most:.2}, must lie between {} and {:.2} (acceleration filtered by \
         0.3); {}",
        STABLE[0],
        STABLE[1],
        told(with_late_added_mass(longest, most, STABLE[1]))
    );
    let head = draft.head(
        source,
        &[
            "Signs: added_mass positive; linear_damping, quadratic_damping negative where they brake",
            "Axes: matrices forward-starboard-down, to which the plugin transforms velocities; positions \
             forward-port-up; SI units",
            "The link needs the inertial given below; its centre of mass is at the body origin, and the couplings m \
             r_g",
            "of the true one are in added_mass and center_of_buoyancy; add a <box> where the vehicle comes near the surface",
        ],
        &Bounds { limits: "fully submerged; no walls, no tether", stability: &stability },
    );
    let mut xml = Xml::new(&head);
    let link = options.link.as_deref().unwrap_or("base_link");
    let forward: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| parts.rest[i][0][j]));
    let quadratic: [f64; 6] = std::array::from_fn(|i| found.absolute[i][i][i]);
    xml.open("gazebo", &[]);
    xml.comment(&[
        format!("<inertial> of the link: mass {} kg, centre of gravity 0 0 0", number(body.mass)),
        format!("ixx iyy izz about it: {}, products 0", numbers(&body.inertia, " ")),
        format!("gravity of the world: {} m/s2", number(gravity)),
    ]);
    xml.open("plugin", &[("name", "uuv_plugin"), ("filename", "libuuv_underwater_object_ros_plugin.so")]);
    xml.leaf("fluid_density", &number(source.file.water.density));
    xml.leaf("flow_velocity_topic", "hydrodynamics/current_velocity");
    xml.open("link", &[("name", link)]);
    xml.leaf("neutrally_buoyant", "0");
    xml.leaf("volume", &number(held.volume));
    xml.leaf("center_of_buoyancy", &numbers(&centre, " "));
    xml.open("hydrodynamic_model", &[]);
    xml.leaf("type", "fossen");
    xml.leaf("added_mass", &rows(&added));
    xml.leaf("linear_damping", &rows(&found.linear));
    xml.leaf("linear_damping_forward_speed", &rows(&forward));
    xml.leaf("quadratic_damping", &numbers(&quadratic, " "));
    Ok(draft.finish(xml.finish()))
}

fn rows(m: &Matrix) -> String {
    m.iter().map(|row| numbers(row, " ")).collect::<Vec<_>>().join(" ")
}
