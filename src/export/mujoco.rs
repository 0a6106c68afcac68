//! MuJoCo: an MJCF with the rigid body, and a callback for the hydrodynamics that MuJoCo's fluid
//! models cannot express.
//!
//! ```text
//! MuJoCo:  M_RB ν̇ = w + τ + F − C_RB(ν) ν      w: gravity, applied forces
//! wanted:  (M_RB + M_A) ν̇ = τ + f(ν, η)
//! bias:    F = M_RB a − τ + C_RB(ν) ν − gravity,   a = (M_RB + M_A)⁻¹ (τ + f)
//! ```
//!
//! MuJoCo's own fluid models take their coefficients from shapes and have no added mass in the
//! inertia. So density and viscosity are 0, and the callback computes all hydrodynamic forces. It
//! knows the commands and solves for the acceleration, so an added mass of any size is stable.
//!
//! F is the bias of the six motors. A callback for passive forces would be called for every model
//! of the process, and with one written in Python no model could be compiled any more: the compiler
//! steps a model that Python does not know yet (MuJoCo's issue 1376). The callback for the bias is
//! called only for motors that ask for it, in every stage of a step. Source: MuJoCo 4.0,
//! `mj_fwdActuation`, free joint: velocity of the origin in world axes, rates in body axes.

use super::body::turned_place;
use super::fossen::{CONVENTIONS, Pieces, python};
use super::header::{Bounds, Draft};
use super::number::{number, numbers};
use super::xml::Xml;
use super::{Export, ExportError, ExportOptions, Source, Target};
use crate::frame::Dof;

/// Longest step that is written to the file, s: MuJoCo's own default.
const STEP: f64 = 0.002;

pub(super) fn export(source: &Source<'_>, options: &ExportOptions) -> Result<Export, ExportError> {
    let mut draft = Draft::new(Target::Mujoco);
    let pieces = Pieces::new(source, options, &mut draft)?;
    let own = [
        "Use: model, data = load(); data.ctrl[:] = forces and moments, forward-starboard-down; mujoco.mj_step(model, data)",
        "World of the MJCF: z up; body forward-port-up; the callback transforms",
        "Fluid: the coefficients are in hydrodynamics(), the bias of the six motors; data.actuator_force holds it beside the command",
        "density, viscosity and fluidcoef of the MJCF stay 0; other models of the process are left as they are",
    ];
    let limits = "one vehicle, first in the file; contacts and other joints see only its dry mass, without the added \
                  mass; so do actuators of your own, and forces in data.qfrc_applied: command by data.ctrl or \
                  data.xfrc_applied";
    let step = STEP.min(0.1 * pieces.longest_steps[0]);
    let stability = format!("{}; the MJCF has RK4 and a step of {} s", pieces.stability(), number(step));
    let head = draft.head(source, &[&CONVENTIONS[..], &own[..]].concat(), &Bounds { limits, stability: &stability });
    let mjcf = mjcf(source, options, &pieces, step);
    let named = python(&head, &pieces).replacen("import numpy", "import weakref\n\nimport numpy", 1);
    let text = format!("{}\n\nMJCF = \"\"\"{}\"\"\"\n{CALLBACK}", named.trim_end(), mjcf.replace('\\', "/"));
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
        // forward-starboard-down converted to forward-port-up
        let gear: Vec<f64> = Dof::ALL.map(|d| if d == dof { super::body::TURN[d.index()] } else { 0.0 }).to_vec();
        let gear = numbers(&gear, " ");
        xml.empty("general", &[("name", dof.force()), ("site", link), ("gear", &gear), ("biastype", "user")]);
    }
    String::from_utf8_lossy(&xml.finish()).into_owned()
}

const CALLBACK: &str = r#"
# forward-port-up by forward-starboard-down
TURN = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])


# the models that load() made
LOADED = weakref.WeakSet()
# of each state, what the motors give beside the command
FORCES = weakref.WeakKeyDictionary()


def load(mjcf=MJCF):
    """The model and its state, with the callback in place; of an MJCF of your own with vehicle and motors first in it."""
    import mujoco

    # the compiler steps its model, which Python does not know yet
    before = mujoco.get_mjcb_act_bias()
    mujoco.set_mjcb_act_bias(None)
    try:
        model = mujoco.MjModel.from_xml_string(mjcf)
    finally:
        mujoco.set_mjcb_act_bias(before)
    LOADED.add(model)
    vehicles = getattr(before, "vehicles", [])
    if not any(loaded is LOADED for loaded in vehicles):

        def callback(model, data, motor):
            if model in LOADED and motor < 6:
                return bias(model, data, motor)
            if before is not None:
                return before(model, data, motor)
            if model.actuator(motor).name == "tau_u":
                raise RuntimeError("this model is none that load() made: make it by load(), or put a copy in LOADED")
            return 0.0

        callback.vehicles = [*vehicles, LOADED]
        mujoco.set_mjcb_act_bias(callback)
    return model, mujoco.MjData(model)


def velocity(data):
    """nu, forward-starboard-down."""
    world_from_body = data.xmat[1].reshape(3, 3)
    return TURN * np.concatenate([world_from_body.T @ data.qvel[:3], data.qvel[3:6]])


def bias(model, data, motor):
    """What a motor gives beside its command. They are asked one after the other, with the same state."""
    if motor == 0 or data not in FORCES:
        FORCES[data] = hydrodynamics(model, data)
    return FORCES[data][motor]


def hydrodynamics(model, data):
    """The forces beside the commands by which the body accelerates as the identified model does."""
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
    return M_RB @ acceleration + coriolis - weight - tau - outside
"#;
