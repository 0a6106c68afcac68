//! Compilation of a list of formulas into a [`Plan`].
//!
//! Registers hold leaves, absolute values of states, constants, results that depend on parameters
//! alone, all other results, and outputs. Operations of one kind that do not depend on each other
//! are adjacent and run as one batch.

use std::collections::HashMap;

use super::body::{Batch, Body, Code, Kind, Operation, Row};
use super::expr::Expr;
use super::graph::{Binary, Leaf, Node, Unary};
use super::plan::{FEW, Plan, Size};
use super::products::{NONE, Products, Term};

impl Plan {
    /// Compiles `outputs`, which belong to one graph; shared parts are computed once.
    pub fn compile(outputs: &[Expr<'_>]) -> Plan {
        Plan::compile_after(outputs, &[], 0)
    }

    /// [`Plan::compile`] with the slots `0..leading.len()` for these leaves, whether the formulas
    /// read them or not. The first `states` of them also have registers for their absolute values:
    /// drag reads those at every instant.
    pub fn compile_after(outputs: &[Expr<'_>], leading: &[Leaf], states: usize) -> Plan {
        let mut leaves = leading.to_vec();
        let mut others: Vec<Leaf> = outputs.iter().flat_map(|e| e.leaves()).filter(|l| !leading.contains(l)).collect();
        others.sort_unstable();
        others.dedup();
        leaves.extend(others);
        let mut builder = Builder {
            slots: leaves.iter().enumerate().map(|(slot, leaf)| (*leaf, slot as u32)).collect(),
            products: Products::new(outputs),
            sizes: (0..states as u32).map(|k| (k, leaves.len() as u32 + k)).collect(),
            next: (leaves.len() + states) as u32,
            ..Builder::default()
        };
        let rows: Vec<_> = outputs.iter().map(|e| builder.output(*e)).collect();
        let first_output = builder.next;
        for (k, (result, level)) in rows.into_iter().enumerate() {
            builder.place(result, level, first_output + k as u32);
        }
        builder.finish(leaves, states, first_output as usize, outputs.len())
    }
}

/// The way in which a result is computed.
enum Result {
    /// By an operation on registers.
    Operation(Code, u32, u32),
    /// As a sum: the register it begins with, then coefficient and factors of each term (the second
    /// is [`NONE`] if there is only one).
    Sum(Option<u32>, Vec<(u32, [u32; 2])>),
    /// As a copy of this register, once for each parameter vector.
    Early(u32),
}

#[derive(Default)]
struct Builder<'g> {
    slots: HashMap<Leaf, u32>,
    /// Register of the absolute value of the state in a slot.
    sizes: HashMap<u32, u32>,
    products: Products<'g>,
    constants: Vec<(u32, f64)>,
    register: HashMap<u32, u32>,
    /// Number of operations of the body from the leaves to the value of a register; 0 for a value
    /// that exists before the body runs.
    level: HashMap<u32, u32>,
    prologue: Vec<Operation<u32>>,
    results: Vec<(u32, Result, u32)>,
    next: u32,
}

impl<'g> Builder<'g> {
    fn fresh(&mut self) -> u32 {
        self.next += 1;
        self.next - 1
    }

    /// The register that holds a formula.
    fn register(&mut self, of: Expr<'g>) -> u32 {
        if let Some(known) = self.register.get(&of.id).copied().or_else(|| self.size(of)) {
            return known;
        }
        let register = match of.graph.node_of(of.id) {
            Node::Constant(bits) | Node::Quantity(bits, _) => {
                let register = self.fresh();
                self.constants.push((register, f64::from_bits(bits)));
                register
            }
            Node::Leaf(leaf) => self.slots[&leaf],
            node if self.products.is_early(of) => {
                let (code, a, b) = self.operands(of, node);
                let out = self.fresh();
                self.prologue.push(Operation { code, a, b, out });
                out
            }
            _ => {
                let (result, level) = self.result(of);
                let out = self.fresh();
                self.place(result, level, out);
                out
            }
        };
        self.register.insert(of.id, register);
        register
    }

    /// The register of a formula that is the absolute value of a state.
    fn size(&self, of: Expr<'g>) -> Option<u32> {
        let Node::Unary(Unary::Abs, a) = of.graph.node_of(of.id) else { return None };
        let Node::Leaf(leaf) = of.graph.node_of(a) else { return None };
        self.sizes.get(self.slots.get(&leaf)?).copied()
    }

    fn operands(&mut self, of: Expr<'g>, node: Node) -> (Code, u32, u32) {
        match node {
            Node::Unary(op, a) => {
                let a = self.register(of.at(a));
                (Code::Unary(op), a, a)
            }
            Node::Binary(op, a, b) => (Code::Binary(op), self.register(of.at(a)), self.register(of.at(b))),
            Node::Constant(_) | Node::Quantity(..) | Node::Leaf(_) => {
                let a = self.register(of);
                (Code::Copy, a, a)
            }
        }
    }

    fn level(&self, register: u32) -> u32 {
        self.level.get(&register).copied().unwrap_or(0)
    }

    /// The computation of a formula at every instant, and its level.
    fn result(&mut self, of: Expr<'g>) -> (Result, u32) {
        let sum = self.products.sum(of);
        match &sum[..] {
            [term] if term.factors == [of.id, NONE] => {
                let node = of.graph.node_of(of.id);
                let (code, a, b) = self.operands(of, node);
                (Result::Operation(code, a, b), 1 + self.level(a).max(self.level(b)))
            }
            [Term { coefficient, factors: [a, b] }] if *a != NONE && coefficient.is_one() => {
                let code = if *b == NONE { Code::Copy } else { Code::Binary(Binary::Mul) };
                let a = self.register(of.at(*a));
                let b = if *b == NONE { a } else { self.register(of.at(*b)) };
                (Result::Operation(code, a, b), 1 + self.level(a).max(self.level(b)))
            }
            terms => self.row(of, terms),
        }
    }

    fn row(&mut self, of: Expr<'g>, terms: &[Term<'g>]) -> (Result, u32) {
        let (mut start, mut all, mut level) = (None, Vec::new(), 0);
        for term in terms.iter().filter(|t| !t.coefficient.is_zero()) {
            let c = self.register(term.coefficient);
            let [a, b] = term.factors.map(|f| if f == NONE { NONE } else { self.register(of.at(f)) });
            level = level.max(self.level(a)).max(self.level(b));
            match a {
                NONE => start = Some(c),
                a => all.push((c, [a, b])),
            }
        }
        (Result::Sum(start, all), 1 + level)
    }

    /// The computation of an output, still without its register.
    fn output(&mut self, of: Expr<'g>) -> (Result, u32) {
        if self.products.is_early(of) {
            return (Result::Early(self.register(of)), 0);
        }
        // a formula that others read too has, or gets, a register of its own
        if self.products.is_shared(of) || self.register.contains_key(&of.id) {
            let a = self.register(of);
            return (Result::Operation(Code::Copy, a, a), 1 + self.level(a));
        }
        self.result(of)
    }

    fn place(&mut self, result: Result, level: u32, out: u32) {
        self.level.insert(out, level);
        self.next = self.next.max(out + 1);
        match result {
            Result::Early(a) => self.prologue.push(Operation { code: Code::Copy, a, b: a, out }),
            result => self.results.push((level, result, out)),
        }
    }

    fn finish(mut self, leaves: Vec<Leaf>, states: usize, first_output: usize, outputs: usize) -> Plan {
        let kind = |result: &Result| match result {
            Result::Operation(code, ..) => Kind::Each(*code),
            Result::Sum(_, terms) => Kind::Rows(terms.len()),
            Result::Early(_) => Kind::Rows(0),
        };
        // a stable sort keeps the order within a batch
        self.results.sort_by_key(|(level, result, _)| (*level, kind(result).order()));
        // a sum without a constant begins with a register that stays 0; a term with one factor reads
        // one that stays 1
        let (zero, one) = (self.fresh(), self.fresh());
        self.constants.push((one, 1.0));
        let mut body = Body { one, ..Body::default() };
        let mut before = 0;
        for (level, result, out) in self.results {
            let kind = kind(&result);
            match body.batches.last_mut() {
                Some(last) if last.kind == kind && before == level => last.count += 1,
                _ => body.batches.push(Batch { kind, count: 1 }),
            }
            before = level;
            match result {
                Result::Operation(code, a, b) => body.operations.push(Operation { code, a, b, out }),
                Result::Sum(start, all) => {
                    body.rows.push(Row { out, start: start.unwrap_or(zero) });
                    body.coefficients.extend(all.iter().map(|(c, _)| *c));
                    body.factors.extend(all.iter().map(|(_, [a, b])| [*a, if *b == NONE { one } else { *b }]));
                }
                Result::Early(_) => {}
            }
        }
        let registers = self.next as usize;
        Plan {
            leaves,
            states,
            constants: self.constants,
            prologue: self.prologue,
            body: if registers <= FEW { Size::Small(body.with_places()) } else { Size::Large(body) },
            first_output,
            outputs,
            registers,
        }
    }
}
