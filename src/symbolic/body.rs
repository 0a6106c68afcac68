//! The operations of a [`Plan`](super::Plan) at every instant: batches of one kind of operation,
//! and rows that are summed in one loop.
//!
//! ```text
//! row = c₀ + Σ cₖ aₖ bₖ        b may be the register that holds 1
//! ```
//!
//! Terms with one factor and with two share a loop: entering a second loop costs more than a
//! product. Coefficients change with the parameters alone: they are gathered once, in the order in
//! which they are used.

use std::ops::{Index, IndexMut};

use super::graph::{Binary, Unary};
use crate::simd::Wide;

/// The index of a register.
pub(super) trait Place: Copy {
    /// The index from a number, which must fit.
    fn of(register: u32) -> Self;
    /// The number.
    fn index(self) -> usize;
}

impl Place for u8 {
    fn of(register: u32) -> u8 {
        register as u8
    }
    #[inline(always)]
    fn index(self) -> usize {
        usize::from(self)
    }
}

impl Place for u32 {
    fn of(register: u32) -> u32 {
        register
    }
    #[inline(always)]
    fn index(self) -> usize {
        self as usize
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Code {
    Copy,
    Unary(Unary),
    Binary(Binary),
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Operation<P> {
    pub code: Code,
    pub a: P,
    pub b: P,
    pub out: P,
}

/// A sum of terms, added to the register `start`; the batch says how many terms.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<P> {
    pub out: P,
    pub start: P,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Each(Code),
    /// Rows with this number of terms.
    Rows(usize),
}

impl Kind {
    /// Rank among the kinds of one level.
    pub fn order(self) -> usize {
        match self {
            Kind::Each(Code::Copy) => 0,
            Kind::Each(Code::Unary(op)) => 1 + op as usize,
            Kind::Each(Code::Binary(op)) => 32 + op as usize,
            Kind::Rows(terms) => 64 + terms,
        }
    }
}

/// The next `count` operations or rows, all of one kind.
#[derive(Debug, Clone, Copy)]
pub(super) struct Batch {
    pub kind: Kind,
    pub count: usize,
}

/// Operations in their order.
#[derive(Debug, Clone, Default)]
pub(super) struct Body<P> {
    pub batches: Vec<Batch>,
    pub operations: Vec<Operation<P>>,
    pub rows: Vec<Row<P>>,
    /// The register that holds 1.
    pub one: P,
    /// a and b of each c·a·b, row by row
    pub factors: Vec<[P; 2]>,
    /// c of each term
    pub coefficients: Vec<u32>,
}

impl Body<u32> {
    /// The same body with another index type, which must be able to index all registers.
    pub fn with_places<P: Place>(&self) -> Body<P> {
        let operation =
            |o: &Operation<u32>| Operation { code: o.code, a: P::of(o.a), b: P::of(o.b), out: P::of(o.out) };
        let row = |r: &Row<u32>| Row { out: P::of(r.out), start: P::of(r.start) };
        Body {
            batches: self.batches.clone(),
            operations: self.operations.iter().map(operation).collect(),
            rows: self.rows.iter().map(row).collect(),
            one: P::of(self.one),
            factors: self.factors.iter().map(|[a, b]| [P::of(*a), P::of(*b)]).collect(),
            coefficients: self.coefficients.clone(),
        }
    }
}

impl<P: Place> Body<P> {
    /// Number of operations and rows.
    pub fn count(&self) -> usize {
        self.operations.len() + self.rows.len()
    }

    /// Whether it only copies the registers `0..count`, which are states, to those from `first` on.
    pub fn copies_to(&self, first: usize, count: usize, states: usize) -> bool {
        let copy =
            |o: &Operation<P>| o.code == Code::Copy && o.a.index() < count && o.out.index() == first + o.a.index();
        count <= states && self.rows.is_empty() && self.operations.len() == count && self.operations.iter().all(copy)
    }

    /// The coefficients in the order of their use.
    pub fn gather<const L: usize>(&self, registers: &[[f64; L]]) -> Vec<[f64; L]> {
        self.coefficients.iter().map(|c| registers[*c as usize]).collect()
    }

    /// Runs all batches once.
    #[inline(always)]
    pub fn run<const L: usize, W: Wide<L>, R>(&self, wide: W, registers: &mut R, mut coefficients: &[[f64; L]])
    where
        R: Index<usize, Output = [f64; L]> + IndexMut<usize> + ?Sized,
    {
        let (mut operations, mut rows) = (&self.operations[..], &self.rows[..]);
        let mut factors = &self.factors[..];
        for batch in &self.batches {
            match batch.kind {
                Kind::Each(code) => {
                    let (now, rest) = operations.split_at(batch.count);
                    each(wide, code, now, registers);
                    operations = rest;
                }
                Kind::Rows(terms) => {
                    let (now, rest) = rows.split_at(batch.count);
                    let (these, others) = factors.split_at(terms * batch.count);
                    let (by, left) = coefficients.split_at(terms * batch.count);
                    match terms {
                        1 => sums::<1, L, W, P, R>(wide, now, these, by, registers),
                        2 => sums::<2, L, W, P, R>(wide, now, these, by, registers),
                        3 => sums::<3, L, W, P, R>(wide, now, these, by, registers),
                        4 => sums::<4, L, W, P, R>(wide, now, these, by, registers),
                        5 => sums::<5, L, W, P, R>(wide, now, these, by, registers),
                        6 => sums::<6, L, W, P, R>(wide, now, these, by, registers),
                        _ => long_sums(wide, terms, now, these, by, registers),
                    }
                    (factors, coefficients) = (others, left);
                    rows = rest;
                }
            }
        }
    }
}

/// Rows of `N` terms, each in one unrolled loop.
#[inline(always)]
fn sums<const N: usize, const L: usize, W: Wide<L>, P: Place, R>(
    wide: W,
    rows: &[Row<P>],
    factors: &[[P; 2]],
    coefficients: &[[f64; L]],
    registers: &mut R,
) where
    R: Index<usize, Output = [f64; L]> + IndexMut<usize> + ?Sized,
{
    for ((row, factors), by) in rows.iter().zip(factors.as_chunks::<N>().0).zip(coefficients.as_chunks::<N>().0) {
        // two independent sums: neither waits for the other
        let mut sums = [wide.load(&registers[row.start.index()]), wide.splat(0.0)];
        for k in 0..N {
            // without `map`: its closure would stay a call
            let [a, b] = factors[k];
            let (a, b) = (wide.load(&registers[a.index()]), wide.load(&registers[b.index()]));
            sums[k % 2] = wide.plus(sums[k % 2], wide.load(&by[k]), wide.mul(a, b));
        }
        registers[row.out.index()] = wide.store(wide.add(sums[0], sums[1]));
    }
}

/// Rows of any number of terms.
#[inline(always)]
fn long_sums<const L: usize, W: Wide<L>, P: Place, R>(
    wide: W,
    terms: usize,
    rows: &[Row<P>],
    factors: &[[P; 2]],
    coefficients: &[[f64; L]],
    registers: &mut R,
) where
    R: Index<usize, Output = [f64; L]> + IndexMut<usize> + ?Sized,
{
    for (k, row) in rows.iter().enumerate() {
        let these = k * terms..(k + 1) * terms;
        let mut sum = wide.load(&registers[row.start.index()]);
        for ([a, b], by) in factors[these.clone()].iter().zip(&coefficients[these]) {
            let ab = wide.mul(wide.load(&registers[a.index()]), wide.load(&registers[b.index()]));
            sum = wide.plus(sum, wide.load(by), ab);
        }
        registers[row.out.index()] = wide.store(sum);
    }
}

/// out = f(a), operation by operation.
#[inline(always)]
fn ones<const L: usize, W: Wide<L>, P: Place, R>(
    wide: W,
    operations: &[Operation<P>],
    registers: &mut R,
    f: impl Fn(W, W::Value) -> W::Value,
) where
    R: Index<usize, Output = [f64; L]> + IndexMut<usize> + ?Sized,
{
    for op in operations {
        let a = wide.load(&registers[op.a.index()]);
        registers[op.out.index()] = wide.store(f(wide, a));
    }
}

/// out = f(a, b), operation by operation.
#[inline(always)]
fn pairs<const L: usize, W: Wide<L>, P: Place, R>(
    wide: W,
    operations: &[Operation<P>],
    registers: &mut R,
    f: impl Fn(W, W::Value, W::Value) -> W::Value,
) where
    R: Index<usize, Output = [f64; L]> + IndexMut<usize> + ?Sized,
{
    for op in operations {
        let (a, b) = (wide.load(&registers[op.a.index()]), wide.load(&registers[op.b.index()]));
        registers[op.out.index()] = wide.store(f(wide, a, b));
    }
}

/// One operation on many registers. Functions without a machine instruction go lane by lane.
#[inline(always)]
pub(super) fn each<const L: usize, W: Wide<L>, P: Place, R>(
    wide: W,
    code: Code,
    operations: &[Operation<P>],
    registers: &mut R,
) where
    R: Index<usize, Output = [f64; L]> + IndexMut<usize> + ?Sized,
{
    match code {
        Code::Copy => ones(wide, operations, registers, W::same),
        Code::Unary(Unary::Abs) => ones(wide, operations, registers, W::abs),
        Code::Unary(Unary::Neg) => ones(wide, operations, registers, W::neg),
        Code::Unary(op) => {
            for o in operations {
                let mut lanes = registers[o.a.index()];
                for a in &mut lanes {
                    *a = op.apply(*a);
                }
                registers[o.out.index()] = lanes;
            }
        }
        Code::Binary(Binary::Add) => pairs(wide, operations, registers, W::add),
        Code::Binary(Binary::Sub) => pairs(wide, operations, registers, W::sub),
        Code::Binary(Binary::Mul) => pairs(wide, operations, registers, W::mul),
        Code::Binary(Binary::Div) => pairs(wide, operations, registers, W::div),
        Code::Binary(op) => {
            for o in operations {
                let (mut lanes, b) = (registers[o.a.index()], registers[o.b.index()]);
                for (a, b) in lanes.iter_mut().zip(b) {
                    *a = op.apply(*a, b);
                }
                registers[o.out.index()] = lanes;
            }
        }
    }
}
