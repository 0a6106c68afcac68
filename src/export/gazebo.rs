//! gz-sim: the Hydrodynamics system and the inertial of a link.
//!
//! ```text
//! F = −D(ν) ν,   D_ij = −(<iJ> + Σ_k <iJabsK> |ν_k| + <iJK> ν_k)     damping of the system: SNAME's signs
//! F −= M_A ν̇,    M_A = −<iDotJ>                                     explicit: ν̇ of the previous step
//! (M_RB + <fluid_added_mass>) ν̇ + C ν = …                            in the engine: positive; adds C itself
//! ```
//!
//! The system's own Coriolis force was wrong in its sign and in two entries over several versions.
//! It is switched off here; in the explicit form the products `<xVR>` … contain the Coriolis force
//! of the added mass exactly. Source: gz-sim, `Hydrodynamics.hh` (8) and its theory page (10);
//! SDFormat 1.10, `inertial.sdf`.

use super::body::{Parts, added_share, split, turned, turned_absolute, turned_place, turned_product};
use super::buoyancy::buoyancy;
use super::coefficients::coefficients;
use super::header::{Bounds, Cell, Draft};
use super::number::{number, numbers};
use super::stability::{longest_step, told, with_late_added_mass};
use super::xml::Xml;
use super::{Export, ExportError, ExportOptions, Source, Target, codes};
use crate::finding::Finding;

/// Rows and velocities in the names of the elements.
const ROWS: [&str; 6] = ["x", "y", "z", "k", "m", "n"];
const VELOCITIES: [&str; 6] = ["U", "V", "W", "P", "Q", "R"];
/// Axes in the names of `<fluid_added_mass>`.
const AXES: [&str; 6] = ["x", "y", "z", "p", "q", "r"];

pub(super) fn export(source: &Source<'_>, target: Target, options: &ExportOptions) -> Result<Export, ExportError> {
    let explicit = target == Target::Gazebo;
    let found = coefficients(source.model);
    let vehicle = &source.file.vehicle;
    let mut draft = Draft::new(target);
    draft.left_out(&found);
    draft.not_modelled(&found);
    let parts = split(&found, vehicle, options, &mut draft.warnings)?;
    draft.body(&parts);
    draft.cancelled(&found, &parts.rest);
    draft.missing(&found, &parts.rest, &parts.added, &|cell| !matches!(cell, Cell::Constant(_)));
    let [least, most] = added_share(&parts.body.matrix(), &parts.added);
    let share = most.max(-least);
    if explicit && share >= 1.0 {
        let text = format!(
            "the added mass is up to {share:.2} times the rigid mass: applied as a force from the previous step, it \
             makes the simulation blow up; use the target `gazebo-added-mass`"
        );
        draft.warnings.push(Finding::new(&codes::UNSTABLE, text));
    }
    let held = buoyancy(&found, source.model, &parts.body, vehicle, &source.file.water);
    let text = format!(
        "weight and buoyancy come from gravity and the Buoyancy system: W - B = {} N, so the collision volume must be \
         {} m3 with its centre at {} (forward, port, up, m)",
        number(held.net_weight),
        number(held.volume),
        numbers(&turned_place(held.centre), ", ")
    );
    draft.warnings.push(Finding::new(&codes::RESTORING, text.clone()));
    let signs = match explicit {
        true => "Signs: SNAME derivatives, negative where they brake or add mass (xU, xUabsU, xDotU < 0)",
        false => "Signs: SNAME derivatives, negative where they brake (xU, xUabsU < 0); fluid_added_mass positive",
    };
    let longest = longest_step(&found, &parts, &source.file.envelope);
    let stability = match explicit {
        true if share >= 1.0 => {
            format!("UNSTABLE however short the step: added mass is {share:.2} times the rigid one")
        }
        true => format!(
            "added mass is {share:.2} times the rigid one and must stay below 1; {}",
            told(with_late_added_mass(longest, most, 1.0))
        ),
        false => told(longest),
    };
    let mut head = draft.head(
        source,
        &[
            signs,
            "Axes: forward-port-up at the body origin, SI units; the model's are forward-starboard-down: cross terms \
             are transformed",
            "Coriolis: the system's own is switched off; the correct one is in the engine and in the products xVR ...",
        ],
        &Bounds { limits: "fully submerged; the system has no surface, no walls, no tether", stability: &stability },
    );
    head.push(text);
    let mut xml = Xml::new(&head);
    let name = if vehicle.name.is_empty() { "vehicle" } else { &vehicle.name };
    let link = options.link.as_deref().unwrap_or("base_link");
    xml.open("sdf", &[("version", if explicit { "1.9" } else { "1.10" })]);
    xml.open("model", &[("name", name)]);
    xml.open("link", &[("name", link)]);
    inertial(&mut xml, &parts, !explicit);
    xml.close();
    let plugin = [("filename", "gz-sim-hydrodynamics-system"), ("name", "gz::sim::systems::Hydrodynamics")];
    xml.open("plugin", &plugin);
    xml.leaf("link_name", link);
    xml.leaf("water_density", &number(source.file.water.density));
    // off in both forms: the products below and the engine give the correct Coriolis force
    xml.leaf("disable_coriolis", "true");
    if explicit {
        let added = turned(&parts.added);
        for i in 0..6 {
            for j in (0..6).filter(|j| i == *j || added[i][*j] != 0.0) {
                xml.leaf(&format!("{}Dot{}", ROWS[i], VELOCITIES[j]), &number(-added[i][j]));
            }
        }
    } else {
        xml.leaf("disable_added_mass", "true");
    }
    let linear = turned(&found.linear);
    let absolute = turned_absolute(&found.absolute);
    let product = turned_product(if explicit { &parts.rest_of_body } else { &parts.rest });
    for i in 0..6 {
        // the diagonal is always written: old versions have defaults other than 0
        for j in (0..6).filter(|j| i == *j || linear[i][*j] != 0.0) {
            xml.leaf(&format!("{}{}", ROWS[i], VELOCITIES[j]), &number(linear[i][j]));
        }
        for j in 0..6 {
            for k in (0..6).filter(|k| (i == j && j == *k) || absolute[i][j][*k] != 0.0) {
                xml.leaf(&format!("{}{}abs{}", ROWS[i], VELOCITIES[j], VELOCITIES[k]), &number(absolute[i][j][k]));
            }
            for k in (j..6).filter(|k| product[i][j][*k] != 0.0) {
                xml.leaf(&format!("{}{}{}", ROWS[i], VELOCITIES[j], VELOCITIES[k]), &number(product[i][j][k]));
            }
        }
    }
    Ok(draft.finish(xml.finish()))
}

fn inertial(xml: &mut Xml, parts: &Parts, fluid: bool) {
    let body = &parts.body;
    xml.open("inertial", &[]);
    xml.leaf("pose", &format!("{} 0 0 0", numbers(&turned_place(body.cg), " ")));
    xml.leaf("mass", &number(body.mass));
    xml.open("inertia", &[]);
    let [ixx, iyy, izz, ixy, ixz, iyz] = body.central();
    // products with one reversed axis change sign; the one with two does not
    let cells = [("ixx", ixx), ("ixy", -ixy), ("ixz", -ixz), ("iyy", iyy), ("iyz", iyz), ("izz", izz)];
    for (name, value) in cells {
        xml.leaf(name, &number(value));
    }
    xml.close();
    if fluid {
        xml.open("fluid_added_mass", &[]);
        let added = turned(&parts.added);
        for i in 0..6 {
            for j in i..6 {
                xml.leaf(&format!("{}{}", AXES[i], AXES[j]), &number(added[i][j]));
            }
        }
        xml.close();
    }
    xml.close();
}
