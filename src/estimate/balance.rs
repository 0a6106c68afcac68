//! The balance of momentum of one degree of freedom, separated by free parameter.
//!
//! ```text
//! Δπᵢ − ∫(wᵢ + τᵢ) dt = e₀ + Σ θⱼ cⱼ = 0        cⱼ = Δ(∂πᵢ/∂θⱼ) − ∫ ∂(wᵢ + τᵢ)/∂θⱼ dt
//! ```
//!
//! The derivatives are symbolic, so that every effect of the catalogue has its column without extra
//! code. What is not affine in the free parameters, or depends on a state that no sensor logs, is
//! refused by name: it needs output error.

use std::collections::BTreeSet;

use thiserror::Error;

use crate::chain::{Available, Equations, StateId, assemble};
use crate::effects::Family;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, Signal};
use crate::symbolic::{Expr, Graph, Leaf, Plan};
use crate::units::Dimension;

/// Reason why a balance has no regressor.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RegressorError {
    /// The degree of freedom is not in the model.
    #[error("{dof} is not among the model's degrees of freedom")]
    NotModelled {
        /// The one asked for.
        dof: Dof,
    },
    /// Terms whose state no sensor logs, sensors that change the log, free parameters that enter by a shape.
    #[error("no regressor for {}: memory, sensors and free shape parameters need output error", .terms.join(", "))]
    NeedsOutputError {
        /// The terms, each with its parameter if that is the cause.
        terms: Vec<String>,
    },
    /// Two free parameters multiply each other.
    #[error("`{first}` and `{second}` are both free but multiply each other: fix one, or use output error")]
    Product {
        /// One of them.
        first: String,
        /// The other; the same one if it enters as a power.
        second: String,
    },
    /// The balance reads a channel that the run does not have.
    #[error("run `{run}` has no channel `{channel}`, which the balance of {dof} reads")]
    MissingChannel {
        /// Name of the run.
        run: String,
        /// The channel.
        channel: String,
        /// Degree of freedom of the balance.
        dof: Dof,
    },
    /// No parameter of the balance is free.
    #[error("nothing to estimate in {dof}: no parameter of its balance is free")]
    NothingFree {
        /// The degree of freedom.
        dof: Dof,
    },
    /// Every force in the balance is multiplied by a free parameter, so that any multiple of a
    /// solution is a solution.
    #[error("the balance of {dof} contains no known force: fix an inertia or the scale of thrust")]
    NoScale {
        /// The degree of freedom.
        dof: Dof,
    },
}

/// The source of the value of a leaf of the plan.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Source {
    /// Time of the run.
    Time,
    /// A channel of the log, read earlier by the value of a parameter if it has a delay.
    Channel {
        /// Its name.
        name: String,
        /// The parameter that holds the delay.
        late: Option<usize>,
    },
    /// Parameter of this index.
    Parameter(usize),
}

/// The compiled balance of one degree of freedom in one run.
#[derive(Debug, Clone)]
pub(super) struct Balance {
    /// Formulas: π, its derivatives by `free`, then w + τ, its derivatives by `free`.
    pub plan: Plan,
    /// The source of each leaf of the plan.
    pub sources: Vec<Source>,
    /// Free parameters of the model in this balance, sorted.
    pub free: Vec<usize>,
}

impl Balance {
    /// Compiles the balance of `dof` for the channels of `run`.
    pub fn compile(model: &Model, dof: Dof, run: &Run) -> Result<Balance, RegressorError> {
        if !model.dofs.contains(&dof) {
            return Err(RegressorError::NotModelled { dof });
        }
        let missing =
            |channel: &str| RegressorError::MissingChannel { run: run.name.clone(), channel: channel.to_string(), dof };
        let has = |name: &str| run.signal(name).is_some_and(|s| !s.is_empty());
        for needed in [dof.velocity(), dof.force()] {
            if !has(needed) {
                return Err(missing(needed));
            }
        }
        let channels: BTreeSet<String> = run.signals.keys().filter(|name| has(name)).cloned().collect();
        let graph = Graph::new();
        let equations = assemble(&graph, model, &Available { channels, ..Available::default() });
        let (momentum, force) = (equations.momentum[dof.index()], equations.force[dof.index()]);

        let formulas = columns(model, &equations, momentum, force)?;
        let plan = Plan::compile(&formulas.outputs);
        let sources = sources(&plan, &equations, dof, run)?;
        Ok(Balance { plan, sources, free: formulas.free })
    }
}

/// Names, formulas and sources of the forces in the balance of `dof`, separated by term; the
/// velocity comes last.
pub(super) fn compiled_components(
    model: &Model,
    dof: Dof,
    run: &Run,
) -> Result<(Vec<String>, Plan, Vec<Source>), RegressorError> {
    let channels: BTreeSet<String> =
        run.signals.iter().filter(|(_, s)| !s.is_empty()).map(|(n, _)| n.clone()).collect();
    let graph = Graph::new();
    let equations = assemble(&graph, model, &Available { channels, ..Available::default() });
    let acting = equations.components.iter().filter(|(_, six)| !six[dof.index()].is_zero());
    let name = |term: &Option<usize>| term.map_or_else(|| "thrust".to_string(), |k| model.terms[k].name());
    let (names, mut formulas): (Vec<String>, Vec<Expr<'_>>) =
        acting.map(|(term, six)| (name(term), six[dof.index()])).unzip();
    for state in equations.states.iter().filter(|s| formulas.iter().any(|f| f.leaves().contains(&s.leaf))) {
        if let StateId::Memory { term, .. } = state.id {
            return Err(RegressorError::NeedsOutputError { terms: vec![model.terms[usize::from(term)].name()] });
        }
    }
    formulas.push(graph.leaf(Leaf::State(dof.index() as u16), Dimension::ONE));
    let plan = Plan::compile(&formulas);
    let sources = sources(&plan, &equations, dof, run)?;
    Ok((names, plan, sources))
}

fn sources(plan: &Plan, equations: &Equations<'_>, dof: Dof, run: &Run) -> Result<Vec<Source>, RegressorError> {
    let of = |leaf: &Leaf| match source(*leaf, equations) {
        Source::Channel { name, .. } if run.signal(&name).is_none_or(Signal::is_empty) => {
            Err(RegressorError::MissingChannel { run: run.name.clone(), channel: name, dof })
        }
        source => Ok(source),
    };
    plan.leaves().iter().map(of).collect()
}

struct Formulas<'g> {
    outputs: Vec<Expr<'g>>,
    free: Vec<usize>,
}

/// π and w + τ, and their derivatives by the free parameters that they contain; refuses what is not
/// affine.
fn columns<'g>(
    model: &Model,
    equations: &Equations<'g>,
    momentum: Expr<'g>,
    force: Expr<'g>,
) -> Result<Formulas<'g>, RegressorError> {
    let mut leaves = momentum.leaves();
    leaves.extend(force.leaves());
    let mut blame = BTreeSet::new();
    for state in equations.states.iter().filter(|s| leaves.contains(&s.leaf)) {
        if let StateId::Memory { term, .. } = state.id {
            blame.insert(model.terms[usize::from(term)].name());
        }
    }
    // a sensor with neutral parameters does not change the log
    let changes_log = |p: &usize| !model.parameters[*p].fixed || !is_neutral(model, *p);
    for term in model.terms.iter().filter(|t| t.effect.about().family == Family::Sensor) {
        if term.parameters.iter().any(changes_log) {
            blame.insert(term.name());
        }
    }
    // the balance takes the logged velocity for that over ground
    if model.through_water {
        blame.extend(equations.waters.iter().map(|k| model.terms[*k].name()));
    }
    let reads = |p: &usize| {
        let is = |leaf: &Leaf| match *leaf {
            Leaf::Parameter(q) => usize::from(q) == *p,
            Leaf::Delayed { late, .. } => late.parameters().any(|q| q == *p),
            _ => false,
        };
        leaves.iter().any(is)
    };
    let free: Vec<usize> = model.free().into_iter().filter(reads).collect();
    for p in free.iter().map(|p| &model.parameters[*p]).filter(|p| !p.spec.is_linear()) {
        blame.insert(format!("{} ({})", p.term, p.spec.name));
    }
    if !blame.is_empty() {
        return Err(RegressorError::NeedsOutputError { terms: blame.into_iter().collect() });
    }

    let by = |e: Expr<'g>| -> Vec<Expr<'g>> { free.iter().map(|p| e.derivative(Leaf::Parameter(*p as u16))).collect() };
    let (of_momentum, of_force) = (by(momentum), by(force));
    for (j, first) in free.iter().enumerate() {
        for second in &free[j..] {
            let leaf = Leaf::Parameter(*second as u16);
            if !of_momentum[j].derivative(leaf).is_zero() || !of_force[j].derivative(leaf).is_zero() {
                let name = |p: usize| model.parameters[p].spec.name.clone();
                return Err(RegressorError::Product { first: name(*first), second: name(*second) });
            }
        }
    }
    let outputs = [vec![momentum], of_momentum, vec![force], of_force].concat();
    Ok(Formulas { outputs, free })
}

fn is_neutral(model: &Model, p: usize) -> bool {
    let parameter = &model.parameters[p];
    let at_neutral = |v: f64| (v - parameter.spec.neutral).abs() <= 0.0;
    at_neutral(parameter.value) && parameter.per_run.iter().all(|v| at_neutral(*v))
}

fn source(leaf: Leaf, equations: &Equations<'_>) -> Source {
    let channel = |name: &str, late| Source::Channel { name: name.to_string(), late };
    match leaf {
        Leaf::Parameter(p) => Source::Parameter(usize::from(p)),
        Leaf::State(k) => {
            let dof = Dof::ALL[usize::from(k) % 6];
            channel(if k < 6 { dof.velocity() } else { dof.position() }, None)
        }
        Leaf::Input(k) | Leaf::Rate(k) => match equations.inputs[usize::from(k)].as_str() {
            "t" => Source::Time,
            name => channel(name, None),
        },
        // a clock that drifts is refused: the balance has no other delay than a constant one
        Leaf::Delayed { input, late } | Leaf::DelayedRate { input, late, .. } => {
            channel(&equations.inputs[usize::from(input)], late.constant.map(usize::from))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    fn run(channels: &[&str]) -> Run {
        let mut run = Run { name: "p8".into(), ..Run::default() };
        for name in channels {
            run.signals.insert((*name).into(), Signal::new(vec![0.0, 1.0].into(), vec![0.0, 1.0]));
        }
        run
    }

    fn refuse(effects: &[&str], fixed: &[&str], channels: &[&str]) -> RegressorError {
        let mut model = Model::with_effects(&[Dof::Surge, Dof::Yaw], Coriolis::Tied, effects).unwrap();
        for name in fixed {
            let p = model.parameter_of(name).unwrap();
            model.parameters[p].fixed = true;
        }
        Balance::compile(&model, Dof::Surge, &run(channels)).unwrap_err()
    }

    const LOGGED: [&str; 4] = ["u", "r", "tau_u", "tau_r"];

    #[test]
    fn what_needs_output_error_is_named() {
        let error = refuse(&["inertia", "thrust_lag", "sensor_gyro_bias", "thrust_deadband@surge"], &[], &LOGGED);
        let RegressorError::NeedsOutputError { terms } = error else { panic!("{error}") };
        assert_eq!(terms.len(), 3, "{terms:?}");
        assert!(terms.contains(&"thrust_lag".to_string()) && terms.contains(&"sensor_gyro_bias".to_string()));
        assert!(terms.iter().any(|t| t.starts_with("thrust_deadband@surge (")));
    }

    #[test]
    fn fixed_shapes_and_neutral_sensors_have_regressors() {
        let mut model =
            Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "thrust_delay", "sensor_dvl_scale"])
                .unwrap();
        for name in ["thrust_delay", "sensor_dvl_scale"] {
            let p = model.parameter_of(name).unwrap();
            model.parameters[p].fixed = true;
        }
        let balance = Balance::compile(&model, Dof::Surge, &run(&LOGGED)).unwrap();
        assert_eq!(balance.free, [0]);
        assert!(balance.sources.contains(&Source::Channel { name: "tau_u".into(), late: Some(1) }));
    }

    #[test]
    fn products_of_free_parameters_are_named() {
        let effects = ["inertia", "thrust_interaction_loss@surge", "thrust_advance_loss@surge"];
        let error = refuse(&effects, &[], &LOGGED);
        assert!(matches!(&error, RegressorError::Product { first, second } if first != second), "{error}");
        let model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "thrust_advance_loss"]).unwrap();
        assert!(Balance::compile(&model, Dof::Surge, &run(&LOGGED)).is_ok(), "one of them alone is linear");
    }

    #[test]
    fn channels_that_the_log_lacks_are_named() {
        let error = refuse(&["inertia"], &[], &["u", "r"]);
        assert!(matches!(&error, RegressorError::MissingChannel { channel, .. } if channel == "tau_u"), "{error}");
    }
}
