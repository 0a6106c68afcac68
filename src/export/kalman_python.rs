//! The model of a Kalman filter as a Python module, with the system of python-control and the
//! stationary gain as functions.

use super::kalman::{Kalman, matrices};
use super::number::{number, numbers};

/// The module.
pub(super) fn write(head: &[String], found: &Kalman) -> String {
    let head = head.join("\n").replace('\\', "/").replace('"', "'");
    let list = |names: &[String]| names.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
    let matrix = |(name, rows, _): (&str, &Vec<Vec<f64>>, usize)| {
        let rows: Vec<String> = rows.iter().map(|row| format!("    [{}],\n", numbers(row, ", "))).collect();
        format!("{} = [\n{}]\n", name.to_uppercase(), rows.concat())
    };
    let vector = |x: &[f64]| x.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", ");
    let unseen = found.unseen();
    let names = [
        ("STATES", &found.states),
        ("INPUTS", &found.inputs),
        ("OUTPUTS", &found.outputs),
        ("NOISES", &found.noises),
        ("UNSEEN", &unseen),
    ];
    let names: String = names.map(|(name, all)| format!("{name} = [{}]\n", list(all))).concat();
    format!(
        "\"\"\"{head}\n\"\"\"\n\n{names}{}X0 = [{}]\nTAU0 = [{}]\nDT = {}\n{FUNCTIONS}",
        matrices(found).map(matrix).concat(),
        vector(&found.x0),
        vector(&found.tau0),
        number(found.dt),
    )
}

const FUNCTIONS: &str = r#"

def system():
    """The linear model of python-control; its inputs are forces, then noises."""
    import control
    import numpy as np

    zero = np.zeros((len(OUTPUTS), len(NOISES)))
    return control.ss(A, np.hstack([B, G]), C, np.hstack([D, zero]), states=STATES, inputs=INPUTS + NOISES)


def gain():
    """Gain L of the stationary filter, for samples of all outputs every DT seconds.

    x[k + 1] = A_D x[k] + B_D u[k] + L (y[k] - C x[k] - D u[k]), x, u and y less their values at the operating point. Rows
    of UNSEEN states, which no output tells of, are 0. ValueError where no random force keeps the filter awake.
    """
    import control
    import numpy as np

    seen = [k for k, name in enumerate(STATES) if name not in UNSEEN]
    among = np.ix_(seen, seen)
    found = np.zeros((len(STATES), len(OUTPUTS)))
    of_seen = np.array(C)[:, seen]
    step, noise = np.array(A_D)[among], np.array(Q_D)[among]
    asleep = (
        "no stationary gain: states that neither decay nor are pushed by a random force (Q_D) would in the end be known "
        "exactly; give Q_D what pushes your vehicle"
    )
    try:
        found[seen] = control.dlqe(step, np.eye(len(seen)), of_seen, noise, np.array(R))[0]
    except np.linalg.LinAlgError as error:
        raise ValueError(asleep) from error
    if np.abs(np.linalg.eigvals(step - found[seen] @ of_seen)).max() > 1.0 - 1e-9:
        raise ValueError(asleep)
    return found
"#;
