//! A model compiled for numerical evaluation: rates of the states, predictions of the sensors, and
//! the Jacobians of both.
//!
//! ```text
//! ẋ = f(x, θ, inputs)      y = h(x, θ, inputs)
//! A = ∂f/∂x, B = ∂f/∂θ, C = ∂h/∂x, D = ∂h/∂θ      by symbolic differentiation; only nonzero entries are kept
//! ```

use std::collections::BTreeSet;

use crate::chain::{Available, StateId, assemble};
use crate::frame::Dof;
use crate::model::Model;
use crate::symbolic::{Expr, Graph, Lateness, Leaf, Plan, derivatives};

/// An entry of a sparse matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// Row.
    pub row: usize,
    /// Column.
    pub column: usize,
}

/// A plan whose first outputs are the functions, followed by the entries of their Jacobians.
#[derive(Debug, Clone)]
pub struct Functions {
    /// The compiled formulas: values, entries by state, entries by parameter.
    pub plan: Plan,
    /// Number of functions.
    pub count: usize,
    /// Entries of the Jacobian with respect to the states.
    pub by_state: Vec<Entry>,
    /// Entries of the Jacobian with respect to the directions.
    pub by_parameter: Vec<Entry>,
    /// Source of each leaf of the plan: all states, all inputs, then the other leaves that are
    /// read.
    pub sources: Vec<Source>,
}

/// Source of the value of a leaf.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// State with this index in [`Dynamics::states`].
    State(usize),
    /// Parameter with this index in the model.
    Parameter(usize),
    /// Slot with this index in [`Dynamics::inputs`].
    Input(usize),
}

/// A compiled model.
#[derive(Debug, Clone)]
pub struct Dynamics {
    /// Kind of each state.
    pub states: Vec<StateId>,
    /// Names of the logged channels that the model predicts, in the order of `observation`.
    pub outputs: Vec<String>,
    /// Their units, in the same order; empty if a formula of the user does not determine it.
    pub units: Vec<String>,
    /// Model parameters with respect to which the Jacobians are computed.
    pub directions: Vec<usize>,
    /// Rates of the states.
    pub rates: Functions,
    /// Predictions of the sensors.
    pub observation: Functions,
    /// Quasi-steady values of the memory states, which come last in `states`.
    pub start: Functions,
    /// M = ∂π/∂ν of the simulated velocities, row by row.
    pub inertia: Functions,
    /// Leaves that are read from the run, each with the name of its channel.
    pub inputs: Vec<(Leaf, String)>,
}

impl Dynamics {
    /// Compiles a model whose runs have the channels `available` and log the channels `observed`.
    /// Jacobians are with respect to the states and the model parameters `directions` (none:
    /// simulation only, without Jacobians).
    pub fn compile(
        model: &Model,
        available: &Available,
        observed: &BTreeSet<String>,
        directions: &[usize],
    ) -> Dynamics {
        Dynamics::build(model, available, observed, directions, !directions.is_empty())
    }

    /// [`Dynamics::compile`] with Jacobians with respect to the states even if there are no
    /// directions.
    pub fn sensitive(
        model: &Model,
        available: &Available,
        observed: &BTreeSet<String>,
        directions: &[usize],
    ) -> Dynamics {
        Dynamics::build(model, available, observed, directions, true)
    }

    fn build(
        model: &Model,
        available: &Available,
        observed: &BTreeSet<String>,
        directions: &[usize],
        with: bool,
    ) -> Dynamics {
        let graph = Graph::new();
        let equations = assemble(&graph, model, available);
        let logged: Vec<_> = equations.logged.iter().filter(|(name, _)| observed.contains(name)).collect();

        // a position that is neither observed nor read is not integrated
        let mut needed: BTreeSet<Leaf> = logged.iter().flat_map(|(_, e)| e.leaves()).collect();
        let always = |id: StateId| !matches!(id, StateId::Position(_) | StateId::Quaternion(_));
        needed.extend(equations.states.iter().filter(|s| always(s.id)).map(|s| s.leaf));
        loop {
            let more: BTreeSet<Leaf> =
                equations.states.iter().filter(|s| needed.contains(&s.leaf)).flat_map(|s| s.rate.leaves()).collect();
            if more.is_subset(&needed) {
                break;
            }
            needed.extend(more);
        }
        let states: Vec<_> = equations.states.iter().filter(|s| needed.contains(&s.leaf)).collect();
        let leaves: Vec<Leaf> = states.iter().map(|s| s.leaf).collect();
        let by: Vec<Leaf> = directions.iter().map(|p| Leaf::Parameter(*p as u16)).collect();

        let rates: Vec<_> = states.iter().map(|s| s.rate).collect();
        let rates = Formulas::of(&rates, with.then_some((&leaves, &by)));
        let observation: Vec<_> = logged.iter().map(|(_, e)| *e).collect();
        let observation = Formulas::of(&observation, with.then_some((&leaves, &by)));
        let start = Formulas::of(&states.iter().filter_map(|s| s.start).collect::<Vec<_>>(), None);
        let velocities: Vec<usize> = states.iter().filter_map(|s| velocity(s.id)).map(Dof::index).collect();
        let element = |i: usize, j: usize| equations.momentum[i].derivative(Leaf::State(j as u16));
        let inertia: Vec<_> = velocities.iter().flat_map(|i| velocities.iter().map(|j| element(*i, *j))).collect();
        let inertia = Formulas::of(&inertia, None);
        let mut inputs: Vec<(Leaf, String)> = Vec::new();
        for leaf in [&rates, &observation, &start, &inertia].iter().flat_map(|f| f.leaves()) {
            let (Leaf::Input(channel)
            | Leaf::Rate(channel)
            | Leaf::Delayed { input: channel, .. }
            | Leaf::DelayedRate { input: channel, .. }) = leaf
            else {
                continue;
            };
            if inputs.iter().all(|(known, _)| *known != leaf) {
                inputs.push((leaf, equations.inputs[usize::from(channel)].clone()));
            }
        }
        let leading: Vec<Leaf> = leaves.iter().copied().chain(inputs.iter().map(|(leaf, _)| *leaf)).collect();
        let [rates, observation, start, inertia] =
            [rates, observation, start, inertia].map(|f| f.compile(&leading, leaves.len()));
        Dynamics {
            states: states.iter().map(|s| s.id).collect(),
            outputs: logged.iter().map(|(name, _)| name.clone()).collect(),
            units: logged.iter().map(|(_, e)| e.dimension().map(|d| d.to_string()).unwrap_or_default()).collect(),
            directions: directions.to_vec(),
            rates,
            observation,
            start,
            inertia,
            inputs,
        }
    }

    /// Degrees of freedom whose velocities are states; they are the first ones.
    pub fn velocities(&self) -> Vec<Dof> {
        self.states.iter().filter_map(|id| velocity(*id)).collect()
    }

    /// Model parameters that are delays of inputs: if they change, the inputs have to be read
    /// again.
    pub fn delays(&self) -> BTreeSet<usize> {
        let late = |leaf: &Leaf| match leaf {
            Leaf::Delayed { late, .. } | Leaf::DelayedRate { late, .. } => Some(*late),
            _ => None,
        };
        self.inputs.iter().filter_map(|(leaf, _)| late(leaf)).flat_map(Lateness::parameters).collect()
    }

    /// Index of the first of the four states of the attitude quaternion, if there is one.
    pub fn quaternion(&self) -> Option<usize> {
        self.states.iter().position(|id| matches!(id, StateId::Quaternion(_)))
    }

    /// Number of memory states; they are the last ones.
    pub fn memories(&self) -> usize {
        self.start.count
    }
}

/// The degree of freedom of a state that is a velocity.
fn velocity(id: StateId) -> Option<Dof> {
    match id {
        StateId::Velocity(dof) => Some(dof),
        _ => None,
    }
}

/// Formulas with the entries of their Jacobians.
struct Formulas<'g> {
    all: Vec<Expr<'g>>,
    count: usize,
    by_state: Vec<Entry>,
    by_parameter: Vec<Entry>,
}

impl<'g> Formulas<'g> {
    /// `jacobians`: the states and the parameters with respect to which they are computed.
    fn of(formulas: &[Expr<'g>], jacobians: Option<(&[Leaf], &[Leaf])>) -> Formulas<'g> {
        let mut all = formulas.to_vec();
        let mut entries = |by: &[Leaf]| {
            let mut found = Vec::new();
            for (column, leaf) in by.iter().enumerate() {
                for (row, derivative) in derivatives(formulas, *leaf).into_iter().enumerate() {
                    if !derivative.is_zero() {
                        all.push(derivative);
                        found.push(Entry { row, column });
                    }
                }
            }
            found
        };
        let (by_state, by_parameter) = match jacobians {
            None => (Vec::new(), Vec::new()),
            Some((state, parameter)) => (entries(state), entries(parameter)),
        };
        Formulas { all, count: formulas.len(), by_state, by_parameter }
    }

    /// The leaves that they read, sorted.
    fn leaves(&self) -> BTreeSet<Leaf> {
        self.all.iter().flat_map(|e| e.leaves()).collect()
    }

    /// `leading`: the states, then the inputs.
    fn compile(self, leading: &[Leaf], states: usize) -> Functions {
        let plan = Plan::compile_after(&self.all, leading, states);
        let place = |leaf: Leaf| leading.iter().position(|known| *known == leaf);
        let source = |leaf: &Leaf| match (*leaf, place(*leaf)) {
            (Leaf::Parameter(p), _) => Source::Parameter(usize::from(p)),
            (Leaf::State(_), found) => Source::State(found.unwrap_or(usize::MAX)),
            (_, found) => Source::Input(found.map_or(usize::MAX, |k| k - states)),
        };
        let sources = plan.leaves().iter().map(source).collect();
        Functions { plan, count: self.count, by_state: self.by_state, by_parameter: self.by_parameter, sources }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    fn compile(effects: &[&str], observed: &[&str], channels: &[&str]) -> Dynamics {
        let model = Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Tied, effects).unwrap();
        let names = |list: &[&str]| list.iter().map(|s| (*s).to_string()).collect::<BTreeSet<_>>();
        let available = Available { channels: names(channels), position: true, ..Available::default() };
        Dynamics::compile(&model, &available, &names(observed), &model.free())
    }

    #[test]
    fn only_states_that_matter_are_integrated() {
        let tau = ["tau_u", "tau_v", "tau_r"];
        let basic = ["inertia", "linear_drag"];
        let heading_free = compile(&basic, &["u", "v", "r"], &tau);
        assert_eq!(heading_free.states.len(), 3);
        let with_heading = compile(&basic, &["u", "v", "r", "psi"], &tau);
        assert_eq!(with_heading.states.len(), 4);
        let with_position = compile(&basic, &["u", "x"], &tau);
        assert_eq!(with_position.states.len(), 5, "x reads the heading");
        let lag = compile(&["inertia", "linear_drag", "thrust_lag"], &["u"], &tau);
        assert_eq!(lag.memories(), 3);
        assert_eq!(lag.states.len(), 6);
    }

    #[test]
    fn delays_are_inputs_of_their_own() {
        let delayed = compile(&["inertia", "linear_drag", "thrust_delay"], &["u"], &["tau_u"]);
        assert!(delayed.inputs.iter().any(|(leaf, name)| matches!(leaf, Leaf::Delayed { .. }) && name == "tau_u"));
        assert_eq!(delayed.delays().len(), 1);
    }
}
