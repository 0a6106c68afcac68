//! A vehicle class for PythonVehicleSimulator and for the Fossen dynamics of HoloOcean.
//!
//! ```text
//! [ν, u_actual] = vehicle.dynamics(η, ν, u_actual, u_control, sampleTime)  u_control: six forces and moments
//! ```
//!
//! One Runge-Kutta step of the velocities with the attitude held; the simulator then updates the
//! attitude with the new velocities. HoloOcean asks for an acceleration instead. It converts NWU to
//! NED itself, its state is that of the centre of mass, and it rotates the returned acceleration to
//! world axes without further terms. So the class returns the acceleration with respect to the
//! world:
//!
//! ```text
//! v_c = v + ω × r_g,     a_c = v̇ + ω̇ × r_g + ω × v_c
//! ```
//!
//! Sources: PythonVehicleSimulator, `lib/mainLoop.py`, `vehicles/remus100.py`; HoloOcean 2, `fossen_dynamics`
//! (`FossenInterface.update`, `convert_NWU_to_NED`, `convert_NED_to_NWU`; `DynamicsSensor` with `UseCOM`).

use super::fossen::{CONVENTIONS, Pieces, python};
use super::header::{Bounds, Draft, one_line};
use super::number::{number, numbers};
use super::{Export, ExportError, ExportOptions, Source, Target};

pub(super) fn export(source: &Source<'_>, options: &ExportOptions) -> Result<Export, ExportError> {
    let mut draft = Draft::new(Target::VehicleSimulator);
    let pieces = Pieces::new(source, options, &mut draft)?;
    let own = [
        "Put the file into vehicles/, or import it, and hand identified() to simulate(N, sampleTime, vehicle)",
        "Control: six forces and moments, N and N m; override stepInput(t), or set tau",
        "A current, V_current (m/s) and beta_current (rad), is the same everywhere",
        "HoloOcean: fossen_model_keys[\"identified\"] = IdentifiedHoloOcean; it converts NWU to NED itself; its state \
         is that of the",
        "centre of mass, CENTRE_OF_MASS from the body origin, and its accelerations are those in the world: the class \
         converts both",
    ];
    let limits = "no walls, no surface, no tether; roll and pitch below 90 degrees";
    let bounds = Bounds { limits, stability: &pieces.stability() };
    let head = draft.head(source, &[&CONVENTIONS[..], &own[..]].concat(), &bounds);
    let text = python(&head, &pieces) + &class(source, &pieces);
    Ok(draft.finish(text.into_bytes()))
}

fn class(source: &Source<'_>, pieces: &Pieces) -> String {
    let vehicle = &source.file.vehicle;
    let name = if vehicle.name.is_empty() { "a vehicle" } else { &vehicle.name };
    let longest = pieces.longest_steps[0];
    let longest = if longest.is_finite() { number(longest) } else { "float(\"inf\")".into() };
    // the name last: it may contain text that looks like another placeholder
    CLASS
        .replace("{length}", &number(vehicle.characteristic_length().unwrap_or(1.0)))
        .replace("{longest}", &longest)
        .replace("{centre}", &numbers(&pieces.body.cg, ", "))
        .replace("{name}", &one_line(name).replace('\\', "/").replace('"', "'"))
}

const CLASS: &str = r#"

# s: longest sample time at which explicit Euler is stable at the speeds of the fit
LONGEST_STEP = {longest}

# m, forward-starboard-down from the body origin
CENTRE_OF_MASS = np.array([{centre}])


class identified:
    """The vehicle for PythonVehicleSimulator."""

    def __init__(self, controlSystem="stepInput", tau=(0.0,) * 6, V_current=0.0, beta_current=0.0):
        self.name = "{name}"
        self.L = {length}
        self.controlMode = controlSystem
        self.controlDescription = "Forces and moments in body axes"
        self.controls = ["Surge (N)", "Sway (N)", "Heave (N)", "Roll (N m)", "Pitch (N m)", "Yaw (N m)"]
        self.dimU = 6
        self.nu = np.zeros(6)
        self.u_actual = np.zeros(6)
        self.tau = np.array(tau, dtype=float)
        self.V_c = V_current
        self.beta_c = beta_current

    def stepInput(self, t):
        """Forces and moments at a time."""
        return self.tau

    def acceleration(self, eta, nu, u_control):
        """nu_dot, the velocity through the water in place of that over ground."""
        u_c, v_c = self.V_c * np.cos(self.beta_c - eta[5]), self.V_c * np.sin(self.beta_c - eta[5])
        current = np.array([u_c, v_c, 0.0, 0.0, 0.0, 0.0])
        turning = np.array([nu[5] * v_c, -nu[5] * u_c, 0.0, 0.0, 0.0, 0.0])
        return turning + nu_dot(eta, np.asarray(nu, dtype=float) - current, u_control)

    def dynamics(self, eta, nu, u_actual, u_control, sampleTime):
        """The velocities and forces a sample later."""
        nu, tau, h = np.asarray(nu, dtype=float), np.asarray(u_control, dtype=float), sampleTime
        a = self.acceleration(eta, nu, tau)
        b = self.acceleration(eta, nu + 0.5 * h * a, tau)
        c = self.acceleration(eta, nu + 0.5 * h * b, tau)
        d = self.acceleration(eta, nu + h * c, tau)
        return nu + h / 6.0 * (a + 2.0 * b + 2.0 * c + d), tau


class IdentifiedHoloOcean(identified):
    """The vehicle for HoloOcean, which asks for accelerations and integrates them itself."""

    config_fnc = None

    def dynamics(self, eta, nu, u_actual, u_control, sampleTime):
        """Acceleration of the centre of mass in the world, along body axes, that of the rates, and the forces."""
        v, omega = np.split(np.asarray(nu, dtype=float), 2)
        tau = np.asarray(u_control, dtype=float)
        of_origin = np.concatenate([v - np.cross(omega, CENTRE_OF_MASS), omega])
        rate = self.acceleration(eta, of_origin, tau)
        linear = rate[:3] + np.cross(rate[3:], CENTRE_OF_MASS) + np.cross(omega, v)
        return np.concatenate([linear, rate[3:]]), tau
"#;
