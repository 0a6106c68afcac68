//! URDF with the `<hydrodynamics>` element of the library `hydrodynamics` of the Robotic Decision
//! Making Laboratory, which auv_controllers and blue read.
//!
//! ```text
//! (M_RB + M_A) ν̇ + C(ν) ν + (D + D_q |ν|) ν + g(R) = τ       M_A, D, D_q diagonal, W = 9.81 m along +z
//! <inertial> mass, inertia, center_of_gravity, added_mass   <damping> linear, quadratic
//! <hydrostatics> buoyancy, center_of_buoyancy
//! ```
//!
//! Because the weight is along +z, its axes are forward-starboard-down, like those of the model;
//! signs are SNAME's, negative where they brake. The inertia is about the body origin: the library
//! does not add m r_g² to it. In addition the `<link>` contains the rigid body as every reader of
//! URDF takes it: forward-port-up (REP 103), about the centre of gravity. Source:
//! `hydrodynamics.cpp` of that library (2025), `parse_model_from_xml`, `forward_dynamics`.

use super::body::{Body, split, turned_place};
use super::buoyancy::under;
use super::coefficients::coefficients;
use super::header::{Bounds, Cell, Draft};
use super::number::{number, numbers};
use super::stability::{longest_step, longest_step_of_angles, told_with_angles};
use super::xml::Xml;
use super::{Export, ExportError, ExportOptions, Source, Target};
use crate::frame::Dof;

/// The library's own acceleration of gravity, m/s².
const GRAVITY: f64 = 9.81;

pub(super) fn export(source: &Source<'_>, options: &ExportOptions) -> Result<Export, ExportError> {
    let found = coefficients(source.model);
    let vehicle = &source.file.vehicle;
    let mut draft = Draft::new(Target::Urdf);
    draft.left_out(&found);
    draft.not_modelled(&found);
    let parts = split(&found, vehicle, options, &mut draft.warnings)?;
    draft.body(&parts);
    draft.missing(&found, &parts.rest, &parts.added, &|cell| match cell {
        Cell::Added(i, j) | Cell::Linear(i, j) => i == j,
        Cell::Absolute(i, j, k) => i == j && j == k,
        Cell::Product(..) | Cell::Constant(_) => false,
    });
    let held = under(GRAVITY, &found, source.model, &parts.body, vehicle, &source.file.water);
    let [longest, of_angles] =
        [longest_step, longest_step_of_angles].map(|of| of(&found, &parts, &source.file.envelope));
    let stability = format!(
        "the library inverts M as a whole, the calling program integrates: {}",
        told_with_angles(longest, of_angles)
    );
    let head = draft.head(
        source,
        &[
            "Signs: SNAME derivatives, negative where they brake or add mass",
            "Axes of <hydrodynamics>: forward-starboard-down at the body origin, weight along +z, SI units; of <link>: forward-port-up",
            "Coriolis forces of rigid body and added mass are computed by the library",
        ],
        &Bounds { limits: "fully submerged; no surface, no walls, no tether", stability: &stability },
    );
    let mut xml = Xml::new(&head);
    let name = if vehicle.name.is_empty() { "vehicle" } else { &vehicle.name };
    xml.open("robot", &[("name", name)]);
    link(&mut xml, options.link.as_deref().unwrap_or("base_link"), &parts.body);
    xml.open("hydrodynamics", &[]);
    xml.open("inertial", &[]);
    xml.empty("mass", &[("value", &number(parts.body.mass))]);
    let [ixx, iyy, izz] = parts.body.inertia.map(number);
    xml.empty("inertia", &[("ixx", &ixx), ("iyy", &iyy), ("izz", &izz)]);
    place(&mut xml, "center_of_gravity", parts.body.cg);
    // <added_mass Xdu="…" …/>
    six(&mut xml, "added_mass", std::array::from_fn(|i| -parts.added[i][i]), |dof| format!("d{}", dof.velocity()));
    xml.close();
    xml.open("damping", &[]);
    six(&mut xml, "linear", std::array::from_fn(|i| found.linear[i][i]), |dof| dof.velocity().into());
    six(&mut xml, "quadratic", std::array::from_fn(|i| found.absolute[i][i][i]), |dof| dof.velocity().repeat(2));
    xml.close();
    xml.open("hydrostatics", &[]);
    xml.empty("buoyancy", &[("value", &number(held.up()))]);
    place(&mut xml, "center_of_buoyancy", held.centre);
    Ok(draft.finish(xml.finish()))
}

fn link(xml: &mut Xml, name: &str, body: &Body) {
    // products with one reversed axis change sign; the one with two does not
    let [ixx, iyy, izz, ixy, ixz, iyz] = body.central();
    let [ixx, ixy, ixz, iyy, iyz, izz] = [ixx, -ixy, -ixz, iyy, iyz, izz].map(number);
    xml.open("link", &[("name", name)]);
    xml.open("inertial", &[]);
    xml.empty("origin", &[("xyz", &numbers(&turned_place(body.cg), " ")), ("rpy", "0 0 0")]);
    xml.empty("mass", &[("value", &number(body.mass))]);
    xml.empty("inertia", &[("ixx", &ixx), ("ixy", &ixy), ("ixz", &ixz), ("iyy", &iyy), ("iyz", &iyz), ("izz", &izz)]);
    xml.close();
    xml.close();
}

fn place(xml: &mut Xml, name: &str, [x, y, z]: [f64; 3]) {
    xml.empty(name, &[("x", &number(x)), ("y", &number(y)), ("z", &number(z))]);
}

/// Writes six derivatives as attributes with SNAME's letters.
fn six(xml: &mut Xml, name: &str, values: [f64; 6], index: impl Fn(Dof) -> String) {
    let owned = Dof::ALL.map(|dof| (format!("{}{}", dof.sname(), index(dof)), number(values[dof.index()])));
    let attributes: Vec<(&str, &str)> = owned.iter().map(|(n, v)| (n.as_str(), v.as_str())).collect();
    xml.empty(name, &attributes);
}
