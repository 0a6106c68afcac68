//! The model linearised at an operating point.
//!
//! ```text
//! δẋ = A δx + B δτ      δy = C δx + D δτ        A = ∂f/∂x, B = ∂f/∂τ, C = ∂h/∂x, D = ∂h/∂τ at (x₀, τ₀)
//! ```
//!
//! x: velocities, the angles that change with them, memory of effects (thrust lag); τ: nominal
//! force and moment; y: the channels that the sensors log. The derivatives are exact derivatives of
//! the model's formulas, not differences. Unless τ₀ is given, it is the force that holds the
//! velocities of the point.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::header::{Bounds, Draft};
use super::losses::Losses;
use super::number::{number, numbers};
use super::stability::spectrum;
use super::{Export, ExportError, ExportOptions, Source, Target, codes, mat};
use crate::chain::{Available, Equations, State, StateId, assemble};
use crate::effects::Family;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::symbolic::{Expr, Graph, Leaf};

/// A linear model. Matrices by rows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Linear {
    /// Names of the states: `u`, `psi`, `thrust_lag.0`.
    pub states: Vec<String>,
    /// Names of the inputs: `tau_u`.
    pub inputs: Vec<String>,
    /// Names of the outputs, as columns of a log.
    pub outputs: Vec<String>,
    /// ∂f/∂x.
    #[serde(rename = "A")]
    pub a: Vec<Vec<f64>>,
    /// ∂f/∂τ.
    #[serde(rename = "B")]
    pub b: Vec<Vec<f64>>,
    /// ∂h/∂x.
    #[serde(rename = "C")]
    pub c: Vec<Vec<f64>>,
    /// ∂h/∂τ.
    #[serde(rename = "D")]
    pub d: Vec<Vec<f64>>,
    /// States at the operating point.
    pub x0: Vec<f64>,
    /// Forces at the operating point, N and N·m.
    pub tau0: Vec<f64>,
    /// ẋ at the operating point.
    pub rate0: Vec<f64>,
}

/// Limits of validity of a linear model.
pub(super) const SMALL: &str = "small motions about x0 and tau0; nonlinear terms and delays are not included";

/// Maximum number of Newton steps in the search for the forces that hold a point.
const STEPS: usize = 30;

/// Linearises `model` at the point `at` (states and forces by name, SI).
///
/// # Errors
/// [`ExportError::Point`] for an unknown name; [`ExportError::NoTrim`] if no force holds the point.
pub fn linear(model: &Model, at: &std::collections::BTreeMap<String, f64>) -> Result<Linear, ExportError> {
    let graph = Graph::new();
    let channels: BTreeSet<String> = model.dofs.iter().map(|d| d.force().to_string()).collect();
    let available = Available { channels, position: true, ..Available::default() };
    let equations = assemble(&graph, model, &available);
    let point = Point::new(model, &equations, at)?;
    let (x0, tau0) = point.hold(at)?;
    let read = |leaf: Leaf| point.read(leaf, &x0, &tau0);
    let by_leaves = |formulas: &[Expr<'_>], leaves: &[Vec<Leaf>]| -> Vec<Vec<f64>> {
        let entry = |f: &Expr<'_>, leaves: &Vec<Leaf>| leaves.iter().map(|l| f.derivative(*l).evaluate(&read)).sum();
        formulas.iter().map(|f| leaves.iter().map(|leaves| entry(f, leaves)).collect()).collect()
    };
    let state_leaves: Vec<Vec<Leaf>> = point.states.iter().map(|s| vec![s.leaf]).collect();
    let rates: Vec<Expr<'_>> = point.states.iter().map(|s| s.rate).collect();
    let logged: Vec<_> = equations.logged.iter().filter(|(name, _)| point.outputs.contains(&name.as_str())).collect();
    let seen: Vec<Expr<'_>> = logged.iter().map(|(_, e)| *e).collect();
    let input_leaves: Vec<Vec<Leaf>> = point
        .forces
        .iter()
        .map(|input| {
            let all = rates.iter().chain(&seen).flat_map(|e| e.leaves()).collect::<BTreeSet<Leaf>>();
            let own = |leaf: &Leaf| match leaf {
                Leaf::Input(i) | Leaf::Delayed { input: i, .. } => Some(*i) == *input,
                _ => false,
            };
            all.into_iter().filter(own).collect()
        })
        .collect();
    Ok(Linear {
        states: point.names(model),
        inputs: model.dofs.iter().map(|d| d.force().to_string()).collect(),
        outputs: logged.iter().map(|(name, _)| (*name).to_string()).collect(),
        a: by_leaves(&rates, &state_leaves),
        b: by_leaves(&rates, &input_leaves),
        c: by_leaves(&seen, &state_leaves),
        d: by_leaves(&seen, &input_leaves),
        rate0: rates.iter().map(|r| r.evaluate(&read)).collect(),
        x0,
        tau0,
    })
}

/// The equations with the data that their evaluation needs.
struct Point<'g, 'a> {
    model: &'a Model,
    states: Vec<State<'g>>,
    outputs: Vec<&'static str>,
    /// Index of the input of each degree of freedom's force, if the equations read it.
    forces: Vec<Option<u16>>,
    values: Vec<f64>,
    given: Vec<f64>,
}

impl<'g, 'a> Point<'g, 'a> {
    fn new(
        model: &'a Model,
        equations: &Equations<'g>,
        at: &std::collections::BTreeMap<String, f64>,
    ) -> Result<Point<'g, 'a>, ExportError> {
        // velocities, memory, the logged angles, and the states that these depend on; a position
        // that nothing reads is left out
        let outputs: Vec<&'static str> = model
            .dofs
            .iter()
            .flat_map(|d| [Some(d.velocity()), d.is_rotation().then(|| d.position())])
            .flatten()
            .collect();
        let mut needed: BTreeSet<Leaf> = equations
            .logged
            .iter()
            .filter(|(name, _)| outputs.contains(&name.as_str()))
            .flat_map(|(_, e)| e.leaves())
            .collect();
        let moves = |s: &&State<'g>| !matches!(s.id, StateId::Position(_));
        needed.extend(equations.states.iter().filter(moves).map(|s| s.leaf));
        loop {
            let read = equations.states.iter().filter(|s| needed.contains(&s.leaf)).flat_map(|s| s.rate.leaves());
            let more: BTreeSet<Leaf> = read.collect();
            if more.is_subset(&needed) {
                break;
            }
            needed.extend(more);
        }
        let states: Vec<State<'g>> = equations.states.iter().filter(|s| needed.contains(&s.leaf)).copied().collect();
        let known: Vec<&str> =
            states.iter().filter_map(|s| s.id.channel()).chain(model.dofs.iter().map(|d| d.force())).collect();
        if let Some(key) = at.keys().find(|key| !known.contains(&key.as_str())) {
            return Err(ExportError::Point { key: key.clone(), known: known.join(", ") });
        }
        let given = states.iter().map(|s| s.id.channel().and_then(|c| at.get(c)).copied().unwrap_or(0.0)).collect();
        let index = |dof: &Dof| equations.inputs.iter().position(|name| name == dof.force()).map(|i| i as u16);
        let forces = model.dofs.iter().map(index).collect();
        Ok(Point { model, states, outputs, forces, values: model.values(), given })
    }

    fn read(&self, leaf: Leaf, x: &[f64], tau: &[f64]) -> f64 {
        match leaf {
            Leaf::State(_) => self.states.iter().position(|s| s.leaf == leaf).map_or(0.0, |i| x[i]),
            Leaf::Parameter(p) => self.values[usize::from(p)],
            Leaf::Input(i) | Leaf::Delayed { input: i, .. } => {
                self.forces.iter().position(|f| *f == Some(i)).map_or(0.0, |k| tau[k])
            }
            Leaf::Rate(_) | Leaf::DelayedRate { .. } => 0.0,
        }
    }

    /// The states, with the memory states settled under these forces.
    fn settled(&self, tau: &[f64]) -> Vec<f64> {
        let mut x = self.given.clone();
        for (i, state) in self.states.iter().enumerate() {
            if let Some(start) = state.start {
                x[i] = start.evaluate(&|leaf| self.read(leaf, &x, tau));
            }
        }
        x
    }

    fn accelerations(&self, tau: &[f64]) -> DVector<f64> {
        let x = self.settled(tau);
        let moving = self.states.iter().filter(|s| matches!(s.id, StateId::Velocity(_)));
        let rates: Vec<f64> = moving.map(|s| s.rate.evaluate(&|leaf| self.read(leaf, &x, tau))).collect();
        DVector::from_vec(rates)
    }

    /// States and forces of the point. If no force is given, the forces are those that hold the
    /// velocities.
    fn hold(&self, at: &std::collections::BTreeMap<String, f64>) -> Result<(Vec<f64>, Vec<f64>), ExportError> {
        let mut tau: Vec<f64> = self.model.dofs.iter().map(|d| at.get(d.force()).copied().unwrap_or(0.0)).collect();
        if self.model.dofs.iter().any(|d| at.contains_key(d.force())) {
            return Ok((self.settled(&tau), tau));
        }
        let n = tau.len();
        let mut rate = self.accelerations(&tau);
        for _ in 0..STEPS {
            if rate.amax() < 1e-12 {
                break;
            }
            // memory may lie between force and acceleration, so the difference is taken over both
            let mut slope = DMatrix::zeros(n, n);
            for k in 0..n {
                let step = 1e-3 * tau[k].abs().max(1.0);
                let mut moved = tau.clone();
                moved[k] += step;
                slope.set_column(k, &((self.accelerations(&moved) - &rate) / step));
            }
            let Some(change) = slope.lu().solve(&rate) else { break };
            tau.iter_mut().zip(change.iter()).for_each(|(t, c)| *t -= c);
            rate = self.accelerations(&tau);
        }
        // a NaN is not below the limit and gives the error
        if rate.amax() < 1e-6 {
            return Ok((self.settled(&tau), tau));
        }
        let reason = "the actuators of the model block it; give the forces (tau_u, …) themselves".to_string();
        Err(ExportError::NoTrim { reason })
    }

    fn names(&self, model: &Model) -> Vec<String> {
        let name = |s: &State<'_>| match s.id {
            StateId::Memory { term, index } => format!("{}.{index}", model.terms[usize::from(term)].name()),
            id => id.channel().unwrap_or_default().to_string(),
        };
        self.states.iter().map(name).collect()
    }
}

/// The linear model with commands as inputs: A, B, C and D include the losses of thrust between
/// nominal and effective force.
pub(super) fn commanded(source: &Source<'_>, options: &ExportOptions) -> Result<Linear, ExportError> {
    let losses = &source.losses;
    if !losses.any() {
        return linear(source.model, &options.at);
    }
    let rows: Vec<usize> = source.model.dofs.iter().map(|d| d.index()).collect();
    let advance = |row: usize| Dof::ALL[Losses::speed(row)].velocity();
    let eta = |row: usize| losses.at(row, options.at.get(advance(row)).copied().unwrap_or(0.0));
    let mut at = options.at.clone();
    for row in &rows {
        at.entry(Dof::ALL[*row].force().to_string()).and_modify(|tau| *tau *= eta(*row)[0]);
    }
    let mut found = linear(source.model, &at)?;
    for (k, row) in rows.iter().enumerate() {
        let [eta, rate] = eta(*row);
        if eta <= 0.0 && found.tau0[k].abs() > 0.0 {
            let reason = format!("no thrust is left in {} at this speed", Dof::ALL[*row]);
            return Err(ExportError::NoTrim { reason });
        }
        found.tau0[k] = if eta > 0.0 { found.tau0[k] / eta } else { 0.0 };
        let speed = found.states.iter().position(|name| name == advance(*row));
        let tau0 = found.tau0[k];
        let matrices = [(&mut found.a, &mut found.b), (&mut found.c, &mut found.d)];
        for (by_state, by_input) in matrices {
            for (state, input) in by_state.iter_mut().zip(by_input) {
                if let Some(j) = speed {
                    state[j] += input[k] * tau0 * rate;
                }
                input[k] *= eta;
            }
        }
    }
    Ok(found)
}

/// A draft with findings about the parts that the linear model omits and about its operating point.
pub(super) fn told(source: &Source<'_>, found: &Linear, target: Target) -> Draft {
    let mut draft = Draft::new(target);
    for term in &source.model.terms {
        let channels = term.effect.channels(term.place);
        if term.effect.delays_command().is_some() {
            let text = format!("`{}` is not in the linear model", term.name());
            draft.lost.push(term.name());
            draft.warnings.push(Finding::new(&codes::DELAY, text));
        } else if !channels.is_empty() && term.effect.about().family != Family::Sensor {
            let text = format!("`{}` is not in the file: it reads {}", term.name(), channels.join(", "));
            draft.lost.push(term.name());
            draft.warnings.push(Finding::new(&codes::EFFECT_LOST, text));
        }
    }
    let moving =
        found.states.iter().zip(&found.rate0).filter(|(name, _)| Dof::ALL.iter().any(|d| d.velocity() == **name));
    let greatest = moving.map(|(_, rate)| rate.abs()).fold(0.0, f64::max);
    if greatest > 1e-6 {
        let text = format!(
            "at the operating point the velocities change by up to {greatest:.3} a second: it is not an equilibrium"
        );
        draft.warnings.push(Finding::new(&codes::EQUILIBRIUM, text));
    }
    for (name, value) in found.states.iter().zip(&found.x0) {
        if let Some([low, high]) = source.file.envelope.get(name).filter(|[low, high]| value < low || value > high) {
            let text = format!("{name} = {value} lies beyond the {low:.3} to {high:.3} of the fit");
            draft.warnings.push(Finding::new(&codes::OUT_OF_ENVELOPE, text));
        }
    }
    draft
}

pub(super) fn export(source: &Source<'_>, target: Target, options: &ExportOptions) -> Result<Export, ExportError> {
    let found = commanded(source, options)?;
    let draft = told(source, &found, target);
    let head = draft.head(
        source,
        &[
            "Axes: forward-starboard-down, earth north-east-down; SI units, rad",
            "x_dot = A (x - x0) + B (tau - tau0),   y - y0 = C (x - x0) + D (tau - tau0)",
            "tau: force and moment in body axes, as they are commanded",
        ],
        &Bounds { limits: SMALL, stability: &spectrum(&found.a) },
    );
    let bytes = match target {
        Target::LinearMat => mat::write(&head.join("; "), &found),
        Target::LinearPython => python(&head, &found).into_bytes(),
        _ => json(&head, &found)?.into_bytes(),
    };
    Ok(draft.finish(bytes))
}

fn json(head: &[String], found: &Linear) -> Result<String, ExportError> {
    #[derive(Serialize)]
    struct File<'a> {
        format: u32,
        comment: &'a [String],
        #[serde(flatten)]
        linear: &'a Linear,
    }
    let text = serde_json::to_string_pretty(&File { format: 1, comment: head, linear: found });
    // finite numbers and texts can always be written
    text.map(|t| t + "\n").map_err(|_| ExportError::Value {
        name: "linear model".into(),
        value: f64::NAN,
        positive: false,
    })
}

fn python(head: &[String], found: &Linear) -> String {
    let head = head.join("\n").replace('\\', "/").replace('"', "'");
    let matrix = |rows: &[Vec<f64>]| {
        let rows: Vec<String> = rows.iter().map(|row| format!("    [{}],\n", numbers(row, ", "))).collect();
        format!("[\n{}]", rows.concat())
    };
    let list = |names: &[String]| names.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
    let vector = |x: &[f64]| x.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", ");
    format!(
        "\"\"\"{head}\n\"\"\"\n\nSTATES = [{}]\nINPUTS = [{}]\nOUTPUTS = [{}]\nA = {}\nB = {}\nC = {}\nD = {}\nX0 = [{}]\nTAU0 = [{}]\n\n\ndef system():\n    \"\"\"The linear model of python-control.\"\"\"\n    import control\n\n    return control.ss(A, B, C, D, states=STATES, inputs=INPUTS, outputs=[f\"y_{{name}}\" for name in OUTPUTS])\n",
        list(&found.states),
        list(&found.inputs),
        list(&found.outputs),
        matrix(&found.a),
        matrix(&found.b),
        matrix(&found.c),
        matrix(&found.d),
        vector(&found.x0),
        vector(&found.tau0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use std::collections::BTreeMap;

    fn model(more: &[&str]) -> Model {
        let mut effects =
            vec!["inertia", "linear_drag", "quadratic_drag", "coriolis_surge", "coriolis_sway", "coriolis_yaw"];
        effects.extend(more);
        let mut model = Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Tied, &effects).unwrap();
        let values = [
            ("inertia@surge", 250.0),
            ("inertia@sway", 300.0),
            ("inertia@yaw", 60.0),
            ("linear_drag@surge", 20.0),
            ("quadratic_drag@surge", 120.0),
        ];
        for (name, value) in values {
            model.set(name, value);
        }
        model
    }

    #[test]
    fn the_matrices_are_those_worked_out_by_hand() {
        let at = BTreeMap::from([("u".to_string(), 0.5)]);
        let found = linear(&model(&[]), &at).unwrap();
        assert_eq!(found.states, ["u", "v", "r", "psi"]);
        assert_eq!(found.outputs, ["u", "v", "r", "psi"]);
        // −(d + 2 d|u|)/m, −m_u u/m_v, −(m_v − m_u) u/I_r
        assert!((found.a[0][0] + (20.0 + 120.0) / 250.0).abs() < 1e-12);
        assert!((found.a[1][2] + 250.0 * 0.5 / 300.0).abs() < 1e-12);
        assert!((found.a[2][1] + 50.0 * 0.5 / 60.0).abs() < 1e-12);
        assert!((found.a[3][2] - 1.0).abs() < 1e-15 && (found.b[2][2] - 1.0 / 60.0).abs() < 1e-15);
        // the holding force is 20·0.5 + 120·0.25
        assert!((found.tau0[0] - 40.0).abs() < 1e-6 && found.rate0[0].abs() < 1e-9, "{:?}", found.tau0);
    }

    #[test]
    fn thrust_lag_is_a_state_and_the_point_is_still_held() {
        let mut lagging = model(&["thrust_lag"]);
        lagging.set("thrust_lag", 0.4);
        let found = linear(&lagging, &BTreeMap::from([("u".to_string(), 0.5)])).unwrap();
        assert_eq!(found.states[4..], ["thrust_lag.0", "thrust_lag.1", "thrust_lag.2"]);
        assert!((found.a[4][4] + 2.5).abs() < 1e-12 && (found.b[4][0] - 2.5).abs() < 1e-12);
        assert!(found.b[0][0].abs() < 1e-15, "the force comes by way of the lag");
        assert!((found.tau0[0] - 40.0).abs() < 1e-6 && (found.x0[4] - 40.0).abs() < 1e-6);
    }

    #[test]
    fn an_unknown_name_is_told_with_what_there_is() {
        let error = linear(&model(&[]), &BTreeMap::from([("w".to_string(), 0.5)])).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the operating point has no `w`: this model has u, v, r, psi, tau_u, tau_v, tau_r"
        );
    }
}
