//! Formulas compiled into a flat list of operations that works on several instants side by side.
//!
//! A [`Plan`] splits its operations in two: the *prologue* reads only parameters and runs once a parameter vector,
//! the *body* runs at every instant. Each register holds `L` lanes, one a trajectory or an instant, so that the cost
//! of interpreting is shared and the compiler can use the vector units.

use std::collections::HashMap;

use super::graph::{Binary, Expr, Leaf, Node, Unary};

#[derive(Debug, Clone, Copy)]
enum Code {
    Unary(Unary),
    Binary(Binary),
}

#[derive(Debug, Clone, Copy)]
struct Operation {
    code: Code,
    a: u32,
    b: u32,
    out: u32,
}

/// A list of formulas, ready to be evaluated. Registers are laid out as constants, leaves, intermediate results.
#[derive(Debug, Clone)]
pub struct Plan {
    constants: Vec<f64>,
    leaves: Vec<Leaf>,
    prologue: Vec<Operation>,
    body: Vec<Operation>,
    outputs: Vec<u32>,
    registers: usize,
}

/// The memory of one evaluation of a [`Plan`], `L` lanes wide.
#[derive(Debug, Clone)]
pub struct Registers<const L: usize>(Vec<[f64; L]>);

impl Plan {
    /// Compiles `outputs`, which belong to one graph; shared parts are computed once.
    pub fn compile(outputs: &[Expr<'_>]) -> Plan {
        let mut builder = Builder::default();
        let order = depth_first(outputs);
        for node in &order {
            if let Some(c) = node.number() {
                builder.constants.push((node.id, c));
            } else if let Node::Leaf(leaf) = node.graph.node_of(node.id) {
                builder.leaves.push((node.id, leaf));
            }
        }
        builder.leaves.sort_unstable_by_key(|(_, leaf)| *leaf);
        builder.lay_out();
        for node in order {
            builder.emit(node);
        }
        let outputs = outputs.iter().map(|e| builder.register[&e.id]).collect();
        Plan {
            constants: builder.constants.iter().map(|(_, c)| *c).collect(),
            leaves: builder.leaves.iter().map(|(_, l)| *l).collect(),
            prologue: builder.prologue,
            body: builder.body,
            outputs,
            registers: builder.next as usize,
        }
    }

    /// The leaves that the formulas read, sorted; the place of a leaf in this list is its slot.
    pub fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }

    /// Slot of a leaf for [`Plan::set`], `None` when no formula reads it.
    pub fn slot(&self, leaf: Leaf) -> Option<usize> {
        self.leaves.binary_search(&leaf).ok()
    }

    /// Number of operations at every instant.
    pub fn operations(&self) -> usize {
        self.body.len()
    }

    /// Number of formulas.
    pub fn outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Fresh registers with the constants in place.
    pub fn registers<const L: usize>(&self) -> Registers<L> {
        let mut registers = vec![[0.0; L]; self.registers];
        for (register, constant) in registers.iter_mut().zip(&self.constants) {
            *register = [*constant; L];
        }
        Registers(registers)
    }

    /// Computes what depends on parameters alone; call it after parameters were set.
    #[inline(always)]
    pub fn prepare<const L: usize>(&self, registers: &mut Registers<L>) {
        execute(&self.prologue, &mut registers.0);
    }

    /// Computes everything else; call it at every instant.
    #[inline(always)]
    pub fn evaluate<const L: usize>(&self, registers: &mut Registers<L>) {
        execute(&self.body, &mut registers.0);
    }

    /// Sets the leaf in `slot`.
    #[inline(always)]
    pub fn set<const L: usize>(&self, registers: &mut Registers<L>, slot: usize, value: [f64; L]) {
        registers.0[self.constants.len() + slot] = value;
    }

    /// Value of formula `k` after [`Plan::evaluate`].
    #[inline(always)]
    pub fn output<const L: usize>(&self, registers: &Registers<L>, k: usize) -> [f64; L] {
        registers.0[self.outputs[k] as usize]
    }
}

#[inline(always)]
fn lanes<const L: usize>(a: [f64; L], f: impl Fn(f64) -> f64) -> [f64; L] {
    a.map(f)
}

#[inline(always)]
fn pairs<const L: usize>(a: [f64; L], b: [f64; L], f: impl Fn(f64, f64) -> f64) -> [f64; L] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

#[inline(always)]
fn execute<const L: usize>(operations: &[Operation], registers: &mut [[f64; L]]) {
    for op in operations {
        let (a, b) = (registers[op.a as usize], registers[op.b as usize]);
        registers[op.out as usize] = match op.code {
            Code::Binary(Binary::Add) => pairs(a, b, |a, b| a + b),
            Code::Binary(Binary::Sub) => pairs(a, b, |a, b| a - b),
            Code::Binary(Binary::Mul) => pairs(a, b, |a, b| a * b),
            Code::Binary(Binary::Div) => pairs(a, b, |a, b| a / b),
            Code::Unary(Unary::Neg) => lanes(a, |a| -a),
            Code::Unary(Unary::Abs) => lanes(a, f64::abs),
            Code::Unary(code) => lanes(a, |a| code.apply(a)),
            Code::Binary(code) => pairs(a, b, |a, b| code.apply(a, b)),
        };
    }
}

/// Every node that the formulas need, each after those it reads.
fn depth_first<'g>(outputs: &[Expr<'g>]) -> Vec<Expr<'g>> {
    let mut order = Vec::new();
    let mut done = HashMap::new();
    let mut stack: Vec<(Expr<'g>, bool)> = outputs.iter().rev().map(|e| (*e, false)).collect();
    while let Some((node, ready)) = stack.pop() {
        if ready {
            order.push(node);
            continue;
        }
        if done.insert(node.id, ()).is_some() {
            continue;
        }
        stack.push((node, true));
        match node.graph.node_of(node.id) {
            Node::Constant(_) | Node::Quantity(..) | Node::Leaf(_) => {}
            Node::Unary(_, a) => stack.push((node.at(a), false)),
            Node::Binary(_, a, b) => stack.extend([(node.at(b), false), (node.at(a), false)]),
        }
    }
    order
}

#[derive(Default)]
struct Builder {
    constants: Vec<(u32, f64)>,
    leaves: Vec<(u32, Leaf)>,
    register: HashMap<u32, u32>,
    /// Nodes that depend on parameters and constants alone.
    early: HashMap<u32, bool>,
    prologue: Vec<Operation>,
    body: Vec<Operation>,
    next: u32,
}

impl Builder {
    fn lay_out(&mut self) {
        let constants = self.constants.iter().map(|(id, _)| (*id, true));
        let leaves = self.leaves.iter().map(|(id, leaf)| (*id, matches!(leaf, Leaf::Parameter(_))));
        for (id, early) in constants.chain(leaves) {
            self.register.insert(id, self.next);
            self.early.insert(id, early);
            self.next += 1;
        }
    }

    fn emit(&mut self, node: Expr<'_>) {
        let (code, a, b) = match node.graph.node_of(node.id) {
            Node::Constant(_) | Node::Quantity(..) | Node::Leaf(_) => return,
            Node::Unary(op, a) => (Code::Unary(op), a, a),
            Node::Binary(op, a, b) => (Code::Binary(op), a, b),
        };
        let early = self.early[&a] && self.early[&b];
        let operation = Operation { code, a: self.register[&a], b: self.register[&b], out: self.next };
        if early {
            self.prologue.push(operation);
        } else {
            self.body.push(operation);
        }
        self.register.insert(node.id, self.next);
        self.early.insert(node.id, early);
        self.next += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::super::Graph;
    use super::*;
    use crate::units::Dimension;

    #[test]
    fn exact_plan_agrees_with_direct_evaluation_in_every_lane() {
        let g = Graph::new();
        let u = g.leaf(Leaf::State(0), Dimension::ONE);
        let r = g.leaf(Leaf::State(1), Dimension::ONE);
        let m = g.leaf(Leaf::Parameter(0), Dimension::ONE);
        let formulas = [(u * r + u.abs() * 2.0) / (m * m), m * 3.0, u, g.constant(4.0), u.tanh().max(r)];
        let plan = Plan::compile(&formulas);
        let mut registers = plan.registers::<4>();
        let value = |leaf: Leaf, lane: usize| match leaf {
            Leaf::State(0) => 0.5 - lane as f64,
            Leaf::State(_) => 0.25 * lane as f64,
            _ => 1.5 + lane as f64,
        };
        for (slot, leaf) in plan.leaves().iter().enumerate() {
            plan.set(&mut registers, slot, std::array::from_fn(|lane| value(*leaf, lane)));
        }
        plan.prepare(&mut registers);
        plan.evaluate(&mut registers);
        for (k, f) in formulas.iter().enumerate() {
            for (lane, x) in plan.output(&registers, k).into_iter().enumerate() {
                assert_eq!(x.to_bits(), f.evaluate(&|leaf| value(leaf, lane)).to_bits(), "formula {k} lane {lane}");
            }
        }
        // m·m and 3·m read parameters alone
        assert_eq!(plan.prologue.len(), 2);
    }
}
