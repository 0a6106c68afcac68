//! The graph of a formula; equal nodes are stored once.

use std::cell::RefCell;
use std::collections::HashMap;

use super::expr::Expr;
use crate::units::Dimension;

/// A quantity that a formula reads at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Leaf {
    /// A state of the simulation, by index.
    State(u16),
    /// A parameter of the model, by index.
    Parameter(u16),
    /// A logged or commanded channel, by index.
    Input(u16),
    /// Time derivative of a channel, by its interpolation.
    Rate(u16),
    /// The channel `input` at an earlier instant.
    Delayed {
        /// Index of the channel.
        input: u16,
        /// How much earlier.
        late: Lateness,
    },
    /// Derivative of [`Leaf::Delayed`] by its constant delay with the opposite sign, which is its time derivative, or by
    /// its drift: that times the elapsed time.
    DelayedRate {
        /// Index of the channel.
        input: u16,
        /// How much earlier.
        late: Lateness,
        /// Whether it is the derivative by the drift.
        elapsed: bool,
    },
}

/// A delay in terms of the parameters of a model: T + δ (t − t₀), s; t₀ is the start of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Lateness {
    /// Index of the parameter that holds the constant delay T, s.
    pub constant: Option<u16>,
    /// Index of the parameter that holds the delay per second of the run, δ.
    pub drift: Option<u16>,
}

impl Lateness {
    /// Constant delay, s, and delay per second of the run for these parameter values.
    pub fn values(self, theta: &[f64]) -> [f64; 2] {
        [self.constant, self.drift].map(|index| index.map_or(0.0, |p| theta[usize::from(p)]))
    }

    /// Indices of its parameters.
    pub fn parameters(self) -> impl Iterator<Item = usize> {
        [self.constant, self.drift].into_iter().flatten().map(usize::from)
    }
}

impl Leaf {
    /// Whether it is constant over all instants.
    pub(super) fn is_parameter(self) -> bool {
        matches!(self, Leaf::Parameter(_))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Unary {
    Neg,
    Abs,
    /// −1, 0 or 1.
    Sign,
    /// 1 for a positive argument, else 0.
    Step,
    Sin,
    Cos,
    Tan,
    Atan,
    Tanh,
    Exp,
    Ln,
    Sqrt,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Pow,
    Min,
    Max,
    /// The angle of the point (b, a).
    Atan2,
}

impl Unary {
    #[inline(always)]
    pub(super) fn apply(self, a: f64) -> f64 {
        match self {
            Unary::Neg => -a,
            Unary::Abs => a.abs(),
            Unary::Sign => f64::from(i8::from(a > 0.0) - i8::from(a < 0.0)),
            Unary::Step => f64::from(u8::from(a > 0.0)),
            Unary::Sin => a.sin(),
            Unary::Cos => a.cos(),
            Unary::Tan => a.tan(),
            Unary::Atan => a.atan(),
            Unary::Tanh => a.tanh(),
            Unary::Exp => a.exp(),
            Unary::Ln => a.ln(),
            Unary::Sqrt => a.sqrt(),
        }
    }
}

impl Binary {
    #[inline(always)]
    pub(super) fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Binary::Add => a + b,
            Binary::Sub => a - b,
            Binary::Mul => a * b,
            Binary::Div => a / b,
            Binary::Pow => a.powf(b),
            Binary::Min => a.min(b),
            Binary::Max => a.max(b),
            Binary::Atan2 => a.atan2(b),
        }
    }
}

/// A node; constants are kept by their bits so that nodes can be compared and hashed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Node {
    Constant(u64),
    /// A constant with a unit.
    Quantity(u64, Dimension),
    Leaf(Leaf),
    Unary(Unary, u32),
    Binary(Binary, u32, u32),
}

#[derive(Debug, Default)]
struct Store {
    nodes: Vec<Node>,
    index: HashMap<Node, u32>,
    dimensions: HashMap<Leaf, Dimension>,
}

/// Holds the nodes of the formulas that are built together.
#[derive(Debug, Default)]
pub struct Graph {
    store: RefCell<Store>,
}

impl Graph {
    /// An empty graph.
    pub fn new() -> Graph {
        Graph::default()
    }

    /// A number without a unit; 0 has every unit: see [`Expr::dimension`].
    pub fn constant(&self, value: f64) -> Expr<'_> {
        // −0 becomes 0: x + (−0) is x as well
        let value = if value == 0.0 { 0.0 } else { value };
        self.node(Node::Constant(value.to_bits()))
    }

    /// A known quantity: a number with its dimension.
    pub fn quantity(&self, value: f64, dimension: Dimension) -> Expr<'_> {
        match dimension {
            Dimension::ONE => self.constant(value),
            _ => self.node(Node::Quantity(value.to_bits(), dimension)),
        }
    }

    /// The number 0.
    pub fn zero(&self) -> Expr<'_> {
        self.constant(0.0)
    }

    /// A quantity that is read at every instant, with its dimension.
    pub fn leaf(&self, leaf: Leaf, dimension: Dimension) -> Expr<'_> {
        self.store.borrow_mut().dimensions.insert(leaf, dimension);
        self.node(Node::Leaf(leaf))
    }

    pub(super) fn node(&self, node: Node) -> Expr<'_> {
        let mut store = self.store.borrow_mut();
        let next = u32::try_from(store.nodes.len()).expect("a formula has fewer than 2^32 nodes");
        let Store { nodes, index, .. } = &mut *store;
        let id = *index.entry(node).or_insert_with(|| {
            nodes.push(node);
            next
        });
        Expr { graph: self, id }
    }

    pub(super) fn node_of(&self, id: u32) -> Node {
        self.store.borrow().nodes[id as usize]
    }

    /// For each node, whether a change of the leaf `by` can change it; nodes come after those they read.
    pub(super) fn touched_by(&self, by: Leaf) -> Vec<bool> {
        let store = self.store.borrow();
        let mut touched = Vec::with_capacity(store.nodes.len());
        for node in &store.nodes {
            let here = match *node {
                Node::Constant(_) | Node::Quantity(..) => false,
                Node::Leaf(Leaf::Delayed { late, .. })
                    if late.parameters().any(|p| by == Leaf::Parameter(p as u16)) =>
                {
                    true
                }
                Node::Leaf(leaf) => leaf == by,
                Node::Unary(_, a) => touched[a as usize],
                Node::Binary(_, a, b) => touched[a as usize] || touched[b as usize],
            };
            touched.push(here);
        }
        touched
    }

    pub(super) fn leaf_dimension(&self, leaf: Leaf) -> Dimension {
        self.store.borrow().dimensions.get(&leaf).copied().unwrap_or(Dimension::ONE)
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.store.borrow().nodes.len()
    }
}
