//! Data for the user's own Kalman filter or linear-quadratic regulator: the linear model with the
//! random force and the noise of the sensors.
//!
//! ```text
//! x = [motion, d, b]:   ẋ = A x + B τ + G w,   y = C x + D τ + e      ḋ = −d/T + w,   Q = 2σ²/T,   R = std²
//! x_{k+1} = A_d x_k + B_d τ_k + w_k,   Q_d = ∫₀^{dt} e^{As} G Q Gᵀ e^{Aᵀs} ds
//! ```
//!
//! d: random force of a degree of freedom, N or N·m, which acts on its velocities through M⁻¹; b:
//! part of a sensor's noise that is correlated in time; w: white, of intensity Q; e: white, of
//! variance R at each sample. Q_d and A_d by Van Loan, *IEEE Transactions on Automatic Control* 23
//! (1978) 395-404.

use std::path::Path;

use nalgebra::DMatrix;
use serde::Serialize;

use super::header::Bounds;
use super::linear::{Linear, SMALL, commanded, told};
use super::number::number;
use super::stability::spectrum;
use super::{Export, ExportError, ExportOptions, Source, Target, codes, kalman_python, mat};
use crate::campaign::ModelNoise;
use crate::chain::{Available, StateId, assemble};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::symbolic::{Graph, Leaf};

/// Time step if the model file contains no rate of a sensor, s.
const STEP: f64 = 0.1;

/// A linear model with its noise. Matrices by rows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Kalman {
    /// Names of the states: `u`, `psi`, `random_force_u`, `noise_r`.
    pub states: Vec<String>,
    /// Names of the inputs: `tau_u`.
    pub inputs: Vec<String>,
    /// Names of the outputs, as columns of a log.
    pub outputs: Vec<String>,
    /// Names of the noises, in the order of the columns of `G`.
    pub noises: Vec<String>,
    /// States at the operating point.
    pub x0: Vec<f64>,
    /// Forces at the operating point, N and N·m.
    pub tau0: Vec<f64>,
    /// Time step of the discrete model, s.
    pub dt: f64,
    /// ∂f/∂x.
    #[serde(rename = "A")]
    pub a: Vec<Vec<f64>>,
    /// ∂f/∂τ.
    #[serde(rename = "B")]
    pub b: Vec<Vec<f64>>,
    /// ∂f/∂w.
    #[serde(rename = "G")]
    pub g: Vec<Vec<f64>>,
    /// ∂h/∂x.
    #[serde(rename = "C")]
    pub c: Vec<Vec<f64>>,
    /// ∂h/∂τ.
    #[serde(rename = "D")]
    pub d: Vec<Vec<f64>>,
    /// Intensity of w, N²/s and N²·m²/s; for coloured sensor noise the square of its unit per
    /// second.
    #[serde(rename = "Q")]
    pub q: Vec<Vec<f64>>,
    /// Variance of each sample.
    #[serde(rename = "R")]
    pub r: Vec<Vec<f64>>,
    /// e^{A dt}.
    #[serde(rename = "A_d")]
    pub a_d: Vec<Vec<f64>>,
    /// ∫ e^{As} ds B, with inputs held over a step.
    #[serde(rename = "B_d")]
    pub b_d: Vec<Vec<f64>>,
    /// Covariance of the discrete noise.
    #[serde(rename = "Q_d")]
    pub q_d: Vec<Vec<f64>>,
}

/// A first-order Gauss-Markov state: name, rms, correlation time, and where it acts.
struct Process {
    name: String,
    rms: f64,
    time: f64,
    into: Enters,
}

enum Enters {
    /// Rates of the motion's states per unit of force.
    Rates(Vec<f64>),
    /// Output of this index.
    Output(usize),
}

/// The filter model of `model`, which `linear` linearises, with `noise` and a time step of `dt`
/// seconds. Outputs without a known noise are omitted.
pub fn kalman(model: &Model, linear: &Linear, noise: &ModelNoise, dt: f64) -> Kalman {
    let kept: Vec<usize> =
        (0..linear.outputs.len()).filter(|k| noise.of_channel(&linear.outputs[*k]).is_some()).collect();
    let outputs: Vec<String> = kept.iter().map(|k| linear.outputs[*k].clone()).collect();
    let forces = model.dofs.iter().enumerate().filter_map(|(k, dof)| {
        let force = noise.force_in(*dof)?;
        let name = format!("random_force_{}", dof.velocity());
        Some(Process {
            name,
            rms: force.rms,
            time: force.correlation_time,
            into: Enters::Rates(pushed(model, linear, k)?),
        })
    });
    let coloured = outputs.iter().enumerate().filter_map(|(k, output)| {
        let sensor = noise.of_channel(output)?;
        let (rms, time) = sensor.coloured_std.zip(sensor.correlation_time)?;
        Some(Process { name: format!("noise_{output}"), rms, time, into: Enters::Output(k) })
    });
    let processes: Vec<Process> = forces.chain(coloured).collect();
    let (nx, n) = (linear.states.len(), linear.states.len() + processes.len());
    let mut a = DMatrix::from_fn(n, n, |i, j| if i < nx && j < nx { linear.a[i][j] } else { 0.0 });
    let b = DMatrix::from_fn(n, linear.inputs.len(), |i, j| if i < nx { linear.b[i][j] } else { 0.0 });
    let mut c = DMatrix::from_fn(kept.len(), n, |i, j| if j < nx { linear.c[kept[i]][j] } else { 0.0 });
    let mut g = DMatrix::zeros(n, processes.len());
    let mut q = DMatrix::zeros(processes.len(), processes.len());
    for (k, process) in processes.iter().enumerate() {
        a[(nx + k, nx + k)] = -1.0 / process.time;
        g[(nx + k, k)] = 1.0;
        q[(k, k)] = 2.0 * process.rms * process.rms / process.time;
        match &process.into {
            Enters::Rates(rates) => rates.iter().enumerate().for_each(|(i, rate)| a[(i, nx + k)] = *rate),
            Enters::Output(output) => c[(*output, nx + k)] = 1.0,
        }
    }
    let variance = |output: &String| noise.of_channel(output).map_or(0.0, |s| s.std * s.std);
    let variances: Vec<f64> = outputs.iter().map(variance).collect();
    let (a_d, b_d, q_d) = discrete(&a, &b, &(&g * &q * g.transpose()), dt);
    let names = processes.iter().map(|p| p.name.clone());
    Kalman {
        states: linear.states.iter().cloned().chain(names.clone()).collect(),
        inputs: linear.inputs.clone(),
        noises: names.collect(),
        x0: linear.x0.iter().copied().chain(processes.iter().map(|_| 0.0)).collect(),
        tau0: linear.tau0.clone(),
        dt,
        d: kept.iter().map(|k| linear.d[*k].clone()).collect(),
        r: rows(&DMatrix::from_fn(kept.len(), kept.len(), |i, j| if i == j { variances[i] } else { 0.0 })),
        outputs,
        a: rows(&a),
        b: rows(&b),
        g: rows(&g),
        c: rows(&c),
        q: rows(&q),
        a_d: rows(&a_d),
        b_d: rows(&b_d),
        q_d: rows(&q_d),
    }
}

impl Kalman {
    /// Unobserved states: neither an output nor the rate of an observed state depends on them; in
    /// the order of `states`.
    pub(super) fn unseen(&self) -> Vec<String> {
        let mut seen: Vec<bool> = (0..self.states.len()).map(|j| self.c.iter().any(|row| row[j] != 0.0)).collect();
        loop {
            let reaches = |j: usize| seen.iter().zip(&self.a).any(|(seen, row)| *seen && row[j] != 0.0);
            let more: Vec<usize> = (0..seen.len()).filter(|j| !seen[*j] && reaches(*j)).collect();
            if more.is_empty() {
                break;
            }
            more.into_iter().for_each(|j| seen[j] = true);
        }
        self.states.iter().zip(seen).filter(|(_, seen)| !seen).map(|(name, _)| name.clone()).collect()
    }
}

fn rows(m: &DMatrix<f64>) -> Vec<Vec<f64>> {
    m.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// Rate of each state per unit of force in the degree of freedom with index `k`: a column of M⁻¹.
fn pushed(model: &Model, linear: &Linear, k: usize) -> Option<Vec<f64>> {
    let graph = Graph::new();
    let channels = model.dofs.iter().map(|d| d.force().to_string()).collect();
    let equations = assemble(&graph, model, &Available { channels, position: true, ..Available::default() });
    let values = model.values();
    let at = |leaf: Leaf| match leaf {
        Leaf::State(_) => {
            let state = equations.states.iter().find(|s| s.leaf == leaf).and_then(|s| s.id.channel());
            linear.states.iter().position(|name| Some(name.as_str()) == state).map_or(0.0, |i| linear.x0[i])
        }
        Leaf::Parameter(p) => values[usize::from(p)],
        _ => 0.0,
    };
    let leaf = |dof: &Dof| equations.states.iter().find(|s| s.id == StateId::Velocity(*dof)).map(|s| s.leaf);
    let leaves: Vec<Leaf> = model.dofs.iter().map(leaf).collect::<Option<_>>()?;
    let mass = DMatrix::from_fn(leaves.len(), leaves.len(), |i, j| {
        equations.momentum[model.dofs[i].index()].derivative(leaves[j]).evaluate(&at)
    });
    let mobility = mass.try_inverse()?;
    let row = |name: &String| model.dofs.iter().position(|dof| dof.velocity() == name);
    Some(linear.states.iter().map(|name| row(name).map_or(0.0, |i| mobility[(i, k)])).collect())
}

/// e^M by scaling, a Taylor series and squaring; nalgebra has it only with its `std` feature. With
/// a scaled norm below one half, the remainder of the series after 16 terms is 0.5¹⁷/17! < 1e-19.
fn exponential(m: &DMatrix<f64>) -> DMatrix<f64> {
    let norm = m.row_iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
    let squarings = (2.0 * norm).max(1.0).log2().ceil() as i32;
    let scaled = m * 0.5_f64.powi(squarings);
    let mut term = DMatrix::identity(m.nrows(), m.nrows());
    let mut sum = term.clone();
    for k in 1..=16 {
        term = &term * &scaled / f64::from(k);
        sum += &term;
    }
    (0..squarings).fold(sum, |e, _| &e * &e)
}

/// A_d, B_d and Q_d for one step.
fn discrete(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    dt: f64,
) -> (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>) {
    let (n, m) = (a.nrows(), b.ncols());
    let mut noise = DMatrix::zeros(2 * n, 2 * n);
    noise.view_mut((0, 0), (n, n)).copy_from(&(-a * dt));
    noise.view_mut((0, n), (n, n)).copy_from(&(q * dt));
    noise.view_mut((n, n), (n, n)).copy_from(&(a.transpose() * dt));
    let noise = exponential(&noise);
    let a_d = noise.view((n, n), (n, n)).transpose();
    let q_d = &a_d * noise.view((0, n), (n, n));
    let mut held = DMatrix::zeros(n + m, n + m);
    held.view_mut((0, 0), (n, n)).copy_from(&(a * dt));
    held.view_mut((0, n), (n, m)).copy_from(&(b * dt));
    let b_d = exponential(&held).view((0, n), (n, m)).into_owned();
    let q_d = (&q_d + q_d.transpose()) * 0.5;
    (a_d, b_d, q_d)
}

pub(super) fn export(source: &Source<'_>, target: Target, options: &ExportOptions) -> Result<Export, ExportError> {
    let noise = source.file.noise.as_ref().ok_or_else(|| ExportError::NoNoise(source.path.to_path_buf()))?;
    let linear = commanded(source, options)?;
    let rate = source.file.sensors.values().map(|s| s.rate).fold(0.0, f64::max);
    let dt = if rate > 0.0 { 1.0 / rate } else { STEP };
    let found = kalman(source.model, &linear, noise, dt);
    let mut draft = told(source, &linear, target);
    let unseen = found.unseen();
    if !unseen.is_empty() {
        let text = format!(
            "no output observes {}: the filter propagates it by dead reckoning, and its row of the stationary gain \
             is 0",
            unseen.join(", ")
        );
        draft.warnings.push(Finding::new(&codes::UNSEEN, text));
    }
    let forces = source.model.dofs.iter().filter_map(|dof| {
        let f = noise.force_in(*dof)?;
        let unit = if dof.is_rotation() { "N m" } else { "N" };
        let [rms, time] = [f.rms, f.correlation_time].map(|x| number((x * 1e4).round() / 1e4));
        Some(format!("Random force in {dof}: {rms} {unit} rms, correlation {time} s"))
    });
    let forces: Vec<String> = forces.collect();
    let mut lines = vec![
        "Axes: forward-starboard-down, earth north-east-down; SI units, rad",
        "x_dot = A (x - x0) + B (tau - tau0) + G w,   y - y0 = C (x - x0) + D (tau - tau0) + e",
        "w: white, intensity Q; e: white, variance R at each sample (continuous filters use R dt)",
        "Discrete, inputs held over dt: A_d, B_d, Q_d",
    ];
    lines.extend(forces.iter().map(String::as_str));
    let limits = format!("{SMALL}; noise as in the runs of the fit");
    let stability = format!("{}; A_d, B_d, Q_d are exact for dt = {} s", spectrum(&found.a), number(found.dt));
    let head = draft.head(source, &lines, &Bounds { limits: &limits, stability: &stability });
    let bytes = match target {
        Target::KalmanMat => to_mat(&head.join("; "), &found),
        Target::KalmanPython => kalman_python::write(&head, &found).into_bytes(),
        Target::KalmanToml => toml(&head, &found, source.path)?.into_bytes(),
        _ => json(&head, &found, source.path)?.into_bytes(),
    };
    Ok(draft.finish(bytes))
}

#[derive(Serialize)]
struct File<'a> {
    format: u32,
    comment: &'a [String],
    #[serde(flatten)]
    kalman: &'a Kalman,
}

/// The error of a failed serialisation, which finite numbers and texts never cause.
fn unwritable(path: &Path) -> ExportError {
    ExportError::Value { name: path.display().to_string(), value: f64::NAN, positive: false }
}

fn json(head: &[String], found: &Kalman, path: &Path) -> Result<String, ExportError> {
    let text = serde_json::to_string_pretty(&File { format: 1, comment: head, kalman: found });
    text.map(|t| t + "\n").map_err(|_| unwritable(path))
}

fn toml(head: &[String], found: &Kalman, path: &Path) -> Result<String, ExportError> {
    toml::to_string(&File { format: 1, comment: head, kalman: found }).map_err(|_| unwritable(path))
}

/// The matrices with their names in a file.
pub(super) fn matrices(found: &Kalman) -> [(&'static str, &Vec<Vec<f64>>, usize); 10] {
    let (n, m, w, y) = (found.states.len(), found.inputs.len(), found.noises.len(), found.outputs.len());
    [
        ("A", &found.a, n),
        ("B", &found.b, m),
        ("G", &found.g, w),
        ("C", &found.c, n),
        ("D", &found.d, m),
        ("Q", &found.q, w),
        ("R", &found.r, y),
        ("A_d", &found.a_d, n),
        ("B_d", &found.b_d, m),
        ("Q_d", &found.q_d, n),
    ]
}

fn to_mat(comment: &str, found: &Kalman) -> Vec<u8> {
    let column = |x: &[f64]| x.iter().map(|x| vec![*x]).collect::<Vec<_>>();
    let (x0, tau0, dt) = (column(&found.x0), column(&found.tau0), column(&[found.dt]));
    let columns = [("x0", &x0, 1), ("tau0", &tau0, 1), ("dt", &dt, 1)];
    let all: Vec<(&str, &Vec<Vec<f64>>, usize)> = matrices(found).into_iter().chain(columns).collect();
    let comment = [comment.to_string()];
    let texts = [
        ("states", found.states.as_slice()),
        ("inputs", &found.inputs),
        ("outputs", &found.outputs),
        ("noises", &found.noises),
        ("comment", &comment),
    ];
    mat::variables(&all, &texts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::{ModelForce, ModelSensor};
    use crate::effects::Coriolis;
    use crate::export::linear;

    fn surge() -> (Model, ModelNoise) {
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        model.set("inertia@surge", 50.0);
        model.set("linear_drag@surge", 20.0);
        let force = ModelForce {
            dof: Dof::Surge,
            rms: 3.0,
            std: 0.1,
            correlation_time: 0.5,
            correlation_time_std: 0.1,
            share_of_thrust: None,
        };
        let sensor = |channel: &str, coloured: Option<f64>| ModelSensor {
            channel: channel.into(),
            std: 0.01,
            coloured_std: coloured,
            correlation_time: coloured.map(|_| 2.0),
            restlessness: 1.0,
        };
        (model, ModelNoise { innovations_white: true, force: vec![force], sensor: vec![sensor("u", Some(0.02))] })
    }

    #[test]
    fn the_matrices_are_those_worked_out_by_hand() {
        let (model, noise) = surge();
        let found = kalman(&model, &linear(&model, &Default::default()).unwrap(), &noise, 0.1);
        assert_eq!(found.states, ["u", "random_force_u", "noise_u"]);
        let expected = [[-0.4, 0.02, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, -0.5]];
        for (row, expected) in found.a.iter().zip(expected) {
            assert!(row.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{row:?}");
        }
        assert_eq!(found.c, [[1.0, 0.0, 1.0]]);
        // 2σ²/T and std²
        assert!((found.q[0][0] - 36.0).abs() < 1e-12 && (found.q[1][1] - 4e-4).abs() < 1e-16);
        assert!((found.r[0][0] - 1e-4).abs() < 1e-18);
    }

    #[test]
    fn a_heading_that_nobody_logs_is_unseen() {
        let effects = ["inertia", "linear_drag"];
        let mut model = Model::with_effects(&[Dof::Surge, Dof::Yaw], Coriolis::Tied, &effects).unwrap();
        for (name, value) in [("inertia@surge", 50.0), ("inertia@yaw", 5.0), ("linear_drag@yaw", 2.0)] {
            model.set(name, value);
        }
        let (_, mut noise) = surge();
        let at =
            |noise: &ModelNoise| kalman(&model, &linear(&model, &Default::default()).unwrap(), noise, 0.1).unseen();
        // u alone: neither r, which moves psi, nor psi
        assert_eq!(at(&noise), ["r", "psi"]);
        noise.sensor.push(ModelSensor { channel: "r".into(), ..noise.sensor[0].clone() });
        assert_eq!(at(&noise), ["psi"]);
        noise.sensor[1].channel = "psi".into();
        assert_eq!(at(&noise), Vec::<String>::new());
    }

    /// The stationary variance of the random force is σ² and a step keeps it: e^{−2dt/T} σ² + Q_d = σ².
    #[test]
    fn law_a_step_keeps_the_variance_of_the_random_force() {
        let (model, noise) = surge();
        for dt in [1e-3, 0.1, 2.0] {
            let found = kalman(&model, &linear(&model, &Default::default()).unwrap(), &noise, dt);
            let (a, q) = (found.a_d[1][1], found.q_d[1][1]);
            assert!((a - (-dt / 0.5_f64).exp()).abs() < 1e-12, "{dt}");
            assert!((a * a * 9.0 + q - 9.0).abs() < 1e-9, "{dt}: {q}");
            // u ← e^{−0.4 dt} u + (1 − e^{−0.4 dt})/20 τ
            assert!((found.b_d[0][0] - (1.0 - (-0.4 * dt).exp()) / 20.0).abs() < 1e-12);
        }
    }
}
