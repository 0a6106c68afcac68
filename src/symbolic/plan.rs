//! Formulas compiled into a flat list of operations that works on several instants side by side.
//!
//! A [`Plan`] splits its operations in two: the *prologue* reads only parameters and runs once for
//! each parameter vector; the *body* runs at every instant. Most of a body is rows c₀ + Σ c·a·b,
//! summed in one loop; the rest are batches of one operation each. A register holds `L` lanes, one
//! for each trajectory or instant, which share the cost of interpretation.

use super::body::{Body, Operation, each};
use super::graph::Leaf;
use crate::simd::{Lanes, Plain, Wide};

/// Number of registers that a one-byte index can address.
pub(super) const FEW: usize = 256;

/// A list of formulas, ready to be evaluated.
#[derive(Debug, Clone)]
pub struct Plan {
    pub(super) leaves: Vec<Leaf>,
    /// Number of leaves that are states; they come first, and the registers of their absolute
    /// values follow the leaves.
    pub(super) states: usize,
    pub(super) constants: Vec<(u32, f64)>,
    pub(super) prologue: Vec<Operation<u32>>,
    pub(super) body: Size,
    pub(super) first_output: usize,
    pub(super) outputs: usize,
    pub(super) registers: usize,
}

/// The body with the shortest possible indices: a one-byte index is always inside an array of 256.
#[derive(Debug, Clone)]
pub(super) enum Size {
    Small(Body<u8>),
    Large(Body<u32>),
}

/// The memory of one evaluation of a [`Plan`], `L` lanes wide.
#[derive(Debug, Clone)]
pub struct Registers<const L: usize> {
    pub(super) all: Lanes<L>,
    /// Coefficients of the body's terms, in the order of their use.
    coefficients: Lanes<L>,
}

/// Registers whose addresses are known: looked up once for many evaluations.
#[derive(Debug)]
pub struct Bound<'a, const L: usize> {
    all: &'a mut [[f64; L]],
    coefficients: &'a [[f64; L]],
}

impl<const L: usize> Registers<L> {
    /// Binds the registers for evaluations.
    pub fn bind(&mut self) -> Bound<'_, L> {
        Bound { all: &mut self.all, coefficients: &self.coefficients }
    }
}

/// The registers of the inputs and outputs of an evaluation.
#[derive(Debug)]
pub struct Ends<'a, const L: usize> {
    /// The leaves that are states, slot by slot, to be written.
    pub states: &'a mut [[f64; L]],
    /// Their absolute values: [`Plan::evaluate`] writes them itself.
    pub sizes: &'a mut [[f64; L]],
    /// The other leaves, to be written.
    pub others: &'a mut [[f64; L]],
    /// The formulas' values after [`Plan::evaluate`].
    pub values: &'a [[f64; L]],
}

impl Plan {
    /// The leaves that the formulas read; the index of a leaf in this list is its slot.
    pub fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }

    /// Slot of a leaf for [`Plan::set`]; `None` if no formula reads it.
    pub fn slot(&self, leaf: Leaf) -> Option<usize> {
        self.leaves.iter().position(|known| *known == leaf)
    }

    /// Number of formulas.
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// Whether the first `count` formulas are the first states, in the same order, and all others
    /// are constant over all instants.
    pub fn is_states(&self, count: usize) -> bool {
        match &self.body {
            Size::Small(body) => body.copies_to(self.first_output, count, self.states),
            Size::Large(body) => body.copies_to(self.first_output, count, self.states),
        }
    }

    /// New registers with the constants set.
    pub fn registers<const L: usize>(&self) -> Registers<L> {
        let mut all = Lanes::zeros(self.registers.max(FEW));
        for (register, constant) in &self.constants {
            all[*register as usize] = [*constant; L];
        }
        Registers { all, coefficients: Lanes::default() }
    }

    /// Computes the part that depends on parameters alone. Call it after parameters are set.
    #[inline(always)]
    pub fn prepare<const L: usize>(&self, registers: &mut Registers<L>) {
        for operation in &self.prologue {
            each(Plain, operation.code, std::slice::from_ref(operation), &mut *registers.all);
        }
        let coefficients = match &self.body {
            Size::Small(body) => body.gather(&registers.all),
            Size::Large(body) => body.gather(&registers.all),
        };
        registers.coefficients = Lanes::of(&coefficients);
    }

    /// Computes the rest. Call it at every instant.
    #[inline(always)]
    pub fn evaluate<W: Wide<L>, const L: usize>(&self, wide: W, registers: &mut Registers<L>) {
        let mut bound = registers.bind();
        let Ends { states, sizes, .. } = self.ends(&mut bound);
        for (size, x) in sizes.iter_mut().zip(states) {
            *size = wide.store(wide.abs(wide.load(x)));
        }
        self.evaluate_sized(wide, &mut bound);
    }

    /// [`Plan::evaluate`] with the absolute values of the states already set: see [`Ends::sizes`].
    #[inline(always)]
    pub fn evaluate_sized<W: Wide<L>, const L: usize>(&self, wide: W, bound: &mut Bound<'_, L>) {
        match &self.body {
            Size::Small(body) => {
                if let Some(all) = bound.all.first_chunk_mut::<FEW>() {
                    body.run(wide, all, bound.coefficients);
                }
            }
            Size::Large(body) => body.run(wide, &mut *bound.all, bound.coefficients),
        }
    }

    /// Sets the leaf in `slot`.
    #[inline(always)]
    pub fn set<const L: usize>(&self, registers: &mut Registers<L>, slot: usize, value: [f64; L]) {
        registers.all[slot] = value;
    }

    /// Value of formula `k` after [`Plan::evaluate`].
    #[inline(always)]
    pub fn output<const L: usize>(&self, registers: &Registers<L>, k: usize) -> [f64; L] {
        registers.all[self.first_output + k]
    }

    /// The registers of the inputs and outputs of an evaluation.
    #[inline(always)]
    pub fn ends<'a, const L: usize>(&self, bound: &'a mut Bound<'_, L>) -> Ends<'a, L> {
        let (before, values) = bound.all.split_at_mut(self.first_output);
        let (leaves, after) = before.split_at_mut(self.leaves.len());
        let (states, others) = leaves.split_at_mut(self.states);
        Ends { states, others, sizes: &mut after[..self.states], values: &values[..self.outputs] }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Expr, Graph};
    use super::*;
    use crate::units::Dimension;

    /// Terms are summed in another order, and a division is a product with an inverse: some
    /// roundings of 1e-16 each.
    #[test]
    fn law_plan_agrees_with_direct_evaluation_in_every_lane() {
        let g = Graph::new();
        let u = g.leaf(Leaf::State(0), Dimension::ONE);
        let r = g.leaf(Leaf::State(1), Dimension::ONE);
        let m = g.leaf(Leaf::Parameter(0), Dimension::ONE);
        let slip = u - r;
        let formulas = [
            (u * r + u.abs() * 2.0) / (m * m),
            m * 3.0,
            u,
            g.constant(4.0),
            u.tanh().max(r),
            (slip + m) * (slip.abs() - 2.0) * u - (m + m * u.abs()) * r + m,
            slip,
            -u,
            (u + 1.0) / (r * r + 1.0),
            slip.sin() * u * r * r - slip * slip,
        ];
        let close = |x: f64, f: Expr<'_>, lane: usize| {
            let exact = f.evaluate(&|leaf| value(leaf, lane));
            assert!((x - exact).abs() <= 4e-15 * exact.abs().max(1.0), "{f:?} lane {lane}: {x} and {exact}");
        };
        for (leading, states) in [(&[][..], 0), (&[Leaf::Input(3), Leaf::State(1)], 0), (&[Leaf::State(0)], 1)] {
            let plan = Plan::compile_after(&formulas, leading, states);
            let mut registers = plan.registers::<4>();
            for (slot, leaf) in plan.leaves().iter().enumerate() {
                assert_eq!(plan.slot(*leaf), Some(slot));
                plan.set(&mut registers, slot, std::array::from_fn(|lane| value(*leaf, lane)));
            }
            plan.prepare(&mut registers);
            plan.evaluate(Plain, &mut registers);
            for (k, f) in formulas.iter().enumerate() {
                for (lane, x) in plan.output(&registers, k).into_iter().enumerate() {
                    close(x, *f, lane);
                }
                let last = plan.output(&registers, k);
                assert_eq!(plan.ends(&mut registers.bind()).values[k], last);
            }
        }
    }

    #[test]
    fn states_in_their_places_are_told_from_all_else() {
        let g = Graph::new();
        let states = [Leaf::State(0), Leaf::State(1)];
        let [u, r] = states.map(|leaf| g.leaf(leaf, Dimension::ONE));
        let m = g.leaf(Leaf::Parameter(0), Dimension::ONE);
        let is = |formulas: &[Expr<'_>], count| Plan::compile_after(formulas, &states, 2).is_states(count);
        assert!(is(&[u, r], 2) && is(&[u], 1) && is(&[u, r, g.constant(1.0), m * m], 2));
        assert!(!is(&[r, u], 2) && !is(&[u + m, r], 2) && !is(&[u, r, u * r], 2) && !is(&[u, u], 2));
        assert!(!is(&[u, m], 2) && !is(&[r], 1) && !is(&[u, r.abs()], 2));
    }

    fn value(leaf: Leaf, lane: usize) -> f64 {
        match leaf {
            Leaf::State(0) => 0.5 - lane as f64,
            Leaf::State(_) => 0.25 * lane as f64,
            _ => 1.5 + lane as f64,
        }
    }
}
