//! Matrices of Fossen's equations as a Python module or a MATLAB function.
//!
//! ```text
//! M ν̇ + C(ν) ν + D ν + D_n(ν) ν + g(η) = τ + τ_0 + N(ν)       M = M_RB + M_A
//! ```
//!
//! Axes forward-starboard-down, as in the model. M_RB, M_A positive definite, D and D_n positive
//! where they brake; D_n has an entry i, j, k for ν_j |ν_k|. N contains the products ν_j ν_k that C
//! does not: free Coriolis coefficients, lift, drag that differs astern. τ is the nominal force;
//! the losses of thrust that belong to the model are applied to it. Fossen (2021), ch. 6.

use std::fmt::Write;

use super::body::{Body, split};
use super::coefficients::{Coefficients, Matrix, Tensor, coefficients};
use super::header::{Bounds, Draft};
use super::losses::Losses;
use super::number::{number, numbers};
use super::stability::{longest_step, longest_step_of_angles, told_with_angles};
use super::{Export, ExportError, ExportOptions, Source, Target};

pub(super) fn export(source: &Source<'_>, target: Target, options: &ExportOptions) -> Result<Export, ExportError> {
    let mut draft = Draft::new(target);
    let pieces = Pieces::new(source, options, &mut draft)?;
    let head = draft.head(source, &CONVENTIONS, &Bounds { limits: LIMITS, stability: &pieces.stability() });
    let text = match target {
        Target::FossenPython => python(&head, &pieces),
        _ => matlab(&head, &pieces),
    };
    Ok(draft.finish(text.into_bytes()))
}

/// Signs and axes of a file of Fossen's equations.
pub(super) const CONVENTIONS: [&str; 3] = [
    "Signs: M_RB, M_A positive; D, D_n positive where they brake; g(eta) on the left, as Fossen writes it",
    "Axes: forward-starboard-down at the body origin, SI units; eta = (x, y, z, phi, theta, psi), z-y-x angles",
    "M nu_dot + C(nu) nu + D nu + D_n(nu) nu + g(eta) = tau + tau_0 + N(nu)",
];

/// Limits of validity of the equations.
const LIMITS: &str = "no walls, no surface, no tether; the caller integrates, by angles for pitch below 90 degrees";

/// The parts of Fossen's equations of a model.
pub(super) struct Pieces {
    /// The rigid body.
    pub body: Body,
    /// M_A.
    pub added: Matrix,
    /// D.
    pub linear: Matrix,
    /// D_n.
    pub absolute: Vec<([usize; 3], f64)>,
    /// N.
    pub product: Vec<([usize; 3], f64)>,
    /// All coefficients of the model.
    pub found: Coefficients,
    /// Losses of thrust.
    pub losses: Losses,
    /// Longest steps of Euler's rule, s: for the velocities alone, and with the angles.
    pub longest_steps: [f64; 2],
}

impl Pieces {
    /// Computes the parts of a model; what they do not contain is added to the findings of `draft`.
    ///
    /// # Errors
    /// As [`split`].
    pub fn new(source: &Source<'_>, options: &ExportOptions, draft: &mut Draft) -> Result<Pieces, ExportError> {
        let found = coefficients(source.model);
        draft.left_out(&found);
        draft.not_modelled(&found);
        let parts = split(&found, &source.file.vehicle, options, &mut draft.warnings)?;
        draft.cancelled(&found, &parts.rest);
        Ok(Pieces {
            body: parts.body,
            added: parts.added,
            linear: std::array::from_fn(|i| std::array::from_fn(|j| -found.linear[i][j])),
            absolute: entries(&found.absolute, -1.0),
            product: entries(&parts.rest, 1.0),
            longest_steps: [longest_step, longest_step_of_angles].map(|of| of(&found, &parts, &source.file.envelope)),
            found,
            losses: source.losses,
        })
    }

    /// The longest stable step, in words.
    pub fn stability(&self) -> String {
        let [longest, of_angles] = self.longest_steps;
        told_with_angles(longest, of_angles)
    }
}

/// Entries that are not 0.
fn entries(tensor: &Tensor, sign: f64) -> Vec<([usize; 3], f64)> {
    let mut list = Vec::new();
    for i in 0..6 {
        for j in 0..6 {
            for k in (0..6).filter(|k| tensor[i][j][*k] != 0.0) {
                list.push(([i, j, k], sign * tensor[i][j][k]));
            }
        }
    }
    list
}

/// The Python module.
pub(super) fn python(head: &[String], p: &Pieces) -> String {
    // a name may contain quotes and backslashes
    let head = head.join("\n").replace('\\', "/").replace('"', "'");
    let matrix = |m: &Matrix| {
        let rows: Vec<String> = m.iter().map(|row| format!("        [{}],\n", numbers(row, ", "))).collect();
        format!("np.array(\n    [\n{}    ]\n)", rows.concat())
    };
    let table = |list: &[([usize; 3], f64)]| {
        let rows: Vec<String> =
            list.iter().map(|([i, j, k], x)| format!("    ({i}, {j}, {k}): {},\n", number(*x))).collect();
        if rows.is_empty() { "{}".into() } else { format!("{{\n{}}}", rows.concat()) }
    };
    let r = &p.found.restoring;
    let mut text = format!("\"\"\"{head}\n\"\"\"\n\nimport numpy as np\n\n");
    let _ = write!(text, "M_RB = {}\n\nM_A = {}\n\nM = M_RB + M_A\n\n", matrix(&p.body.matrix()), matrix(&p.added));
    let _ = write!(text, "D = {}\n\n", matrix(&p.linear));
    let _ = write!(text, "# D_n(nu)[i, j] += d |nu_k| for each (i, j, k): d\nQUADRATIC = {}\n\n", table(&p.absolute));
    let _ = write!(text, "# N(nu)[i] += n nu_j nu_k for each (i, j, k): n\nPRODUCTS = {}\n\n", table(&p.product));
    let _ = write!(text, "tau_0 = np.array([{}])\n\n", numbers(&p.found.constant, ", "));
    let _ = write!(
        text,
        "# W - B by row, z_g W - z_b B in roll and pitch, x_g W and y_g W\nNET_WEIGHT = ({})\nRIGHTING = ({})\nTRIM = ({})\n",
        numbers(&r.net_weight, ", "),
        numbers(&r.righting, ", "),
        numbers(&r.trim, ", ")
    );
    let _ = write!(
        text,
        "# thrust that acts: ETA_INTER max(slope |v| + intercept, 0) times the nominal one, v its own velocity, u of a moment\nETA_INTER = np.array([{}])\nETA_ADV = ({})\n",
        numbers(&p.losses.interaction, ", "),
        numbers(&p.losses.advance, ", ")
    );
    text + PYTHON
}

const PYTHON: &str = r#"

def C(nu):
    """Coriolis and centripetal matrix of M."""
    nu = np.asarray(nu, dtype=float)
    P, L = np.split(M @ nu, 2)
    matrix = np.zeros((6, 6))
    matrix[:3, 3:] = -S(P)
    matrix[3:, :3] = -S(P)
    matrix[3:, 3:] = -S(L)
    return matrix


def S(a):
    """Matrix of the cross product, S(a) b = a x b."""
    x, y, z = a
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def D_n(nu):
    """Quadratic damping matrix."""
    matrix = np.zeros((6, 6))
    for (i, j, k), d in QUADRATIC.items():
        matrix[i, j] += d * abs(nu[k])
    return matrix


def N(nu):
    """Forces in proportion to products of velocities."""
    force = np.zeros(6)
    for (i, j, k), n in PRODUCTS.items():
        force[i] += n * nu[j] * nu[k]
    return force


def g(eta):
    """Restoring forces, on the left side."""
    phi, theta = eta[3], eta[4]
    down = np.array([-np.sin(theta), np.cos(theta) * np.sin(phi), np.cos(theta) * np.cos(phi)])
    x, y = TRIM
    force = NET_WEIGHT * down
    roll = -RIGHTING[0] * down[1] + y * down[2]
    pitch = RIGHTING[1] * down[0] - x * down[2]
    yaw = x * down[1] - y * down[0]
    return -np.array([*force, roll, pitch, yaw])


def acting(nu, tau):
    """Force that acts on the hull, from the nominal one."""
    speed = np.abs(np.array([nu[0], nu[1], nu[2], nu[0], nu[0], nu[0]]))
    slope, intercept = ETA_ADV
    return ETA_INTER * np.maximum(slope * speed + intercept, 0.0) * tau


def nu_dot(eta, nu, tau):
    """Acceleration under the force tau."""
    nu, tau = np.asarray(nu, dtype=float), np.asarray(tau, dtype=float)
    force = acting(nu, tau) + tau_0 + N(nu) - C(nu) @ nu - D @ nu - D_n(nu) @ nu - g(eta)
    return np.linalg.solve(M, force)
"#;

fn matlab(head: &[String], p: &Pieces) -> String {
    let matrix = |m: &Matrix| {
        let rows: Vec<String> = m.iter().map(|row| format!("  {}", numbers(row, " "))).collect();
        format!("[\n{}\n]", rows.join(";\n"))
    };
    let cells = |name: &str, list: &[([usize; 3], f64)]| {
        let mut text = format!("vehicle.{name} = zeros(6, 6, 6);\n");
        for ([i, j, k], x) in list {
            let _ = writeln!(text, "vehicle.{name}({}, {}, {}) = {};", i + 1, j + 1, k + 1, number(*x));
        }
        text
    };
    let r = &p.found.restoring;
    let mut text: String = "function vehicle = hydrosysid_vehicle()\n".into();
    for line in head {
        let _ = writeln!(text, "% {line}");
    }
    let _ = write!(text, "vehicle.M_RB = {};\nvehicle.M_A = {};\n", matrix(&p.body.matrix()), matrix(&p.added));
    let _ = write!(text, "vehicle.M = vehicle.M_RB + vehicle.M_A;\nvehicle.D = {};\n", matrix(&p.linear));
    let _ = write!(text, "% force -D_n(i, j, k) nu_j |nu_k|\n{}", cells("D_n", &p.absolute));
    let _ = write!(text, "% force +N(i, j, k) nu_j nu_k\n{}", cells("N", &p.product));
    let _ = writeln!(text, "vehicle.tau_0 = [{}];", numbers(&p.found.constant, "; "));
    let _ = writeln!(text, "vehicle.net_weight = [{}];", numbers(&r.net_weight, "; "));
    let _ = writeln!(text, "vehicle.righting = [{}];", numbers(&r.righting, "; "));
    let _ = writeln!(text, "vehicle.trim = [{}];", numbers(&r.trim, "; "));
    text += "% thrust that acts: eta_inter max(slope |v| + intercept, 0) times the nominal one, v its own velocity, u of a moment\n";
    let _ = writeln!(text, "vehicle.eta_inter = [{}];", numbers(&p.losses.interaction, "; "));
    let _ = writeln!(text, "vehicle.eta_adv = [{}];", numbers(&p.losses.advance, "; "));
    text + MATLAB
}

const MATLAB: &str = r"vehicle.nu_dot = @(eta, nu, tau) vehicle.M \ (acting(vehicle, nu, tau) + vehicle.tau_0 + products(vehicle.N, nu) ...
  - coriolis(vehicle.M, nu) * nu - vehicle.D * nu - damping(vehicle.D_n, nu) * nu - restoring(vehicle, eta));
end

function tau = acting(vehicle, nu, tau)
speed = abs(nu([1; 2; 3; 1; 1; 1]));
tau = vehicle.eta_inter .* max(vehicle.eta_adv(1) * speed + vehicle.eta_adv(2), 0) .* tau;
end

function C = coriolis(M, nu)
pi = M * nu;
C = [zeros(3), -skew(pi(1:3)); -skew(pi(1:3)), -skew(pi(4:6))];
end

function S = skew(a)
S = [0, -a(3), a(2); a(3), 0, -a(1); -a(2), a(1), 0];
end

function D = damping(D_n, nu)
D = zeros(6);
for k = 1:6
  D = D + D_n(:, :, k) * abs(nu(k));
end
end

function f = products(N, nu)
f = zeros(6, 1);
for k = 1:6
  f = f + N(:, :, k) * nu * nu(k);
end
end

function g = restoring(vehicle, eta)
phi = eta(4);
theta = eta(5);
down = [-sin(theta); cos(theta) * sin(phi); cos(theta) * cos(phi)];
x = vehicle.trim(1);
y = vehicle.trim(2);
g = -[vehicle.net_weight .* down; ...
  -vehicle.righting(1) * down(2) + y * down(3); ...
  vehicle.righting(2) * down(1) - x * down(3); ...
  x * down(2) - y * down(1)];
end
";
