//! MuJoCo: an MJCF with the rigid body, and a callback for what MuJoCo's fluid cannot hold.
//!
//! ```text
//! MuJoCo:  M_RB ν̇ = w + F − C_RB(ν) ν          w: gravity, actuators, applied forces
//! wanted:  (M_RB + M_A) ν̇ = τ + f(ν, η)
//! passive: F = M_RB a − τ + C_RB(ν) ν − gravity,   a = (M_RB + M_A)⁻¹ (τ + f)
//! ```
//!
//! MuJoCo's own fluid models take their coefficients from shapes and have no added mass in the inertia; so density and
//! viscosity are 0 and the whole of the hydrodynamics is the callback, which knows the commands and solves for the
//! acceleration: an added mass of any size is stable. Source: MuJoCo 4.0, `mj_passive`, `mj_fwdVelocity` (the passive
//! forces come before those of actuators), free joint: velocity of the origin in world axes, rates in body axes.

use super::body::turned_place;
use super::fossen::{CONVENTIONS, Pieces, python};
use super::header::{Bounds, Draft};
use super::number::{number, numbers};
use super::xml::Xml;
use super::{Export, ExportError, ExportOptions, Source, Target};
use crate::frame::Dof;

/// Longest step that is written, s: MuJoCo's own default.
const STEP: f64 = 0.002;

pub(super) fn export(source: &Source<'_>, options: &ExportOptions) -> Result<Export, ExportError> {
    let mut draft = Draft::new(Target::Mujoco);
    let pieces = Pieces::new(source, options, &mut draft)?;
    let own = [
        "Use: model, data = load(); data.ctrl[:] = forces and moments, forward-starboard-down; mujoco.mj_step(model, data)",
        "World of the MJCF: z up; body forward-port-up; the callback turns",
        "Fluid: the coefficients are in the callback passive(); density, viscosity and fluidcoef of the MJCF stay 0",
    ];
    let limits = "one vehicle, first in the file; contacts and other joints feel its dry mass alone, without the added one; \
                  actuators of your own, and forces in data.qfrc_applied, too: command by data.ctrl or data.xfrc_applied";
    let step = STEP.min(0.1 * pieces.longest_steps[0]);
    let stability = format!("{}; the MJCF has RK4 and a step of {} s", pieces.stability(), number(step));
    let head = draft.head(source, &[&CONVENTIONS[..], &own[..]].concat(), &Bounds { limits, stability: &stability });
    let mjcf = mjcf(source, options, &pieces, step);
    let text =
        format!("{}\n\nMJCF = \"\"\"{}\"\"\"\n{CALLBACK}", python(&head, &pieces).trim_end(), mjcf.replace('\\', "/"));
    Ok(draft.finish(text.into_bytes()))
}

fn mjcf(source: &Source<'_>, options: &ExportOptions, pieces: &Pieces, step: f64) -> String {
    let link = options.link.as_deref().unwrap_or("base_link");
    let body = &pieces.body;
    let [ixx, iyy, izz, ixy, ixz, iyz] = body.central();
    let mut xml = Xml::new(&["the rigid body; added mass, damping and restoring forces are in the callback".into()]);
    let name = if source.file.vehicle.name.is_empty() { "vehicle" } else { &source.file.vehicle.name };
    xml.open("mujoco", &[("model", name)]);
    let step = number(step);
    let still = [("integrator", "RK4"), ("timestep", &*step), ("density", "0"), ("viscosity", "0")];
    xml.empty("option", &still);
    xml.open("worldbody", &[]);
    xml.open("body", &[("name", link)]);
    xml.empty("freejoint", &[("name", link)]);
    let full = numbers(&[ixx, iyy, izz, -ixy, -ixz, iyz], " ");
    let (place, mass) = (numbers(&turned_place(body.cg), " "), number(body.mass));
    xml.empty("inertial", &[("pos", &place), ("mass", &mass), ("fullinertia", &full)]);
    xml.empty("site", &[("name", link), ("pos", "0 0 0")]);
    xml.close();
    xml.close();
    xml.open("actuator", &[]);
    for dof in Dof::ALL {
        // forward-starboard-down in forward-port-up
        let gear: Vec<f64> = Dof::ALL.map(|d| if d == dof { super::body::TURN[d.index()] } else { 0.0 }).to_vec();
        xml.empty("motor", &[("name", dof.force()), ("site", link), ("gear", &numbers(&gear, " "))]);
    }
    String::from_utf8_lossy(&xml.finish()).into_owned()
}

const CALLBACK: &str = r#"
# forward-port-up by forward-starboard-down
TURN = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])


def load():
    """The model and its state, with the callback in place."""
    import mujoco

    # the compiler steps its model, which is none of ours yet
    mujoco.set_mjcb_passive(None)
    model = mujoco.MjModel.from_xml_string(MJCF)
    mujoco.set_mjcb_passive(passive)
    return model, mujoco.MjData(model)


def velocity(data):
    """nu, forward-starboard-down."""
    world_from_body = data.xmat[1].reshape(3, 3)
    return TURN * np.concatenate([world_from_body.T @ data.qvel[:3], data.qvel[3:6]])


def passive(model, data):
    """Adds the forces by which the body accelerates as the identified model does."""
    world_from_body = data.xmat[1].reshape(3, 3)
    # z-y-x angles of the turned body in the turned world
    turn = np.diag([1.0, -1.0, -1.0])
    attitude = turn @ world_from_body @ turn
    eta = np.zeros(6)
    eta[3] = np.arctan2(attitude[2, 1], attitude[2, 2])
    eta[4] = -np.arcsin(np.clip(attitude[2, 0], -1.0, 1.0))
    nu = velocity(data)
    tau = np.array(data.ctrl[:6])
    # forces on the body from outside, about its origin, which act as they are
    outside = np.zeros(6)
    force = world_from_body.T @ data.xfrc_applied[1, :3]
    outside[:3] = turn @ force
    outside[3:] = turn @ (world_from_body.T @ data.xfrc_applied[1, 3:] + np.cross(model.body_ipos[1], force))
    acceleration = nu_dot(eta, nu, tau) + np.linalg.solve(M, outside)
    down = attitude.T @ np.array([0.0, 0.0, M_RB[0, 0] * -model.opt.gravity[2]])
    weight = np.concatenate([down, np.cross(turn @ model.body_ipos[1], down)])
    P, L = np.split(M_RB @ nu, 2)
    coriolis = np.concatenate([np.cross(nu[3:], P), np.cross(nu[3:], L) + np.cross(nu[:3], P)])
    wrench = TURN * (M_RB @ acceleration + coriolis - weight - tau - outside)
    data.qfrc_passive[:3] += world_from_body @ wrench[:3]
    data.qfrc_passive[3:6] += wrench[3:]
"#;
