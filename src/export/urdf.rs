//! URDF with a `<hydrodynamics>` element: the diagonal of the derivatives as attributes.
//!
//! ```text
//! <added_mass Xdu= …/>   <linear Xu= …/>   <quadratic Xuu= …/>       X_u̇, X_u, X_u|u|: negative where they brake
//! ```
//!
//! The element is read by tools of the marine ROS community; it has no place for couplings. URDF's axes are
//! forward-port-up (REP 103), in which the diagonal is the same.

use super::body::{split, turned_place};
use super::buoyancy::buoyancy;
use super::coefficients::coefficients;
use super::header::{Cell, Draft};
use super::number::{number, numbers};
use super::xml::Xml;
use super::{Export, ExportError, ExportOptions, Source, Target};
use crate::frame::Dof;

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
    let held = buoyancy(&found, source.model, &parts.body, vehicle, &source.file.water);
    let head = draft.head(
        source,
        &[
            "Signs: SNAME derivatives, negative where they brake or add mass",
            "Axes: forward-port-up at the body origin, SI units; the diagonal is the same as in forward-starboard-down",
            "Coriolis forces of rigid body and added mass are left to the reader of this file",
        ],
    );
    let mut xml = Xml::new(&head);
    let name = if vehicle.name.is_empty() { "vehicle" } else { &vehicle.name };
    let body = &parts.body;
    let [ixx, iyy, izz, ixy, ixz, iyz] = body.central().map(number);
    let negative =
        |x: &str| if x == "0" { x.to_string() } else { x.strip_prefix('-').map_or(format!("-{x}"), str::to_string) };
    let mass = number(body.mass);
    let cg = numbers(&turned_place(body.cg), " ");
    xml.open("robot", &[("name", name)]);
    xml.open("link", &[("name", options.link.as_deref().unwrap_or("base_link"))]);
    xml.open("inertial", &[]);
    xml.empty("origin", &[("xyz", &cg), ("rpy", "0 0 0")]);
    xml.empty("mass", &[("value", &mass)]);
    let (ixy, ixz) = (negative(&ixy), negative(&ixz));
    xml.empty("inertia", &[("ixx", &ixx), ("ixy", &ixy), ("ixz", &ixz), ("iyy", &iyy), ("iyz", &iyz), ("izz", &izz)]);
    xml.close();
    xml.close();
    xml.open("hydrodynamics", &[]);
    let six = |cells: [f64; 6], quadratic: bool, dotted: bool| -> Vec<(String, String)> {
        let attribute = |dof: Dof| {
            let v = dof.velocity();
            let name = match (dotted, quadratic) {
                (true, _) => format!("{}d{v}", dof.sname()),
                (false, true) => format!("{}{v}{v}", dof.sname()),
                (false, false) => format!("{}{v}", dof.sname()),
            };
            (name, number(cells[dof.index()]))
        };
        Dof::ALL.map(attribute).to_vec()
    };
    let mut element = |name: &str, cells: [f64; 6], quadratic: bool, dotted: bool| {
        let owned = six(cells, quadratic, dotted);
        let attributes: Vec<(&str, &str)> = owned.iter().map(|(n, v)| (n.as_str(), v.as_str())).collect();
        xml.empty(name, &attributes);
    };
    element("added_mass", std::array::from_fn(|i| -parts.added[i][i]), false, true);
    element("linear", std::array::from_fn(|i| found.linear[i][i]), false, false);
    element("quadratic", std::array::from_fn(|i| found.absolute[i][i][i]), true, false);
    xml.empty("volume", &[("value", &number(held.volume))]);
    xml.empty("center_of_buoyancy", &[("xyz", &numbers(&turned_place(held.centre), " "))]);
    Ok(draft.finish(xml.finish()))
}
