//! What a [`Plan`](super::Plan) does at every instant: batches of one operation each, and rows that are summed in one go.
//!
//! ```text
//! row = c₀ + Σ cₖ aₖ + Σ cₖ aₖ bₖ
//! ```
//!
//! Coefficients change with the parameters alone: they are gathered once, in the order in which they are used.

use std::ops::{Index, IndexMut};

use super::graph::{Binary, Unary};

/// Where a register is.
pub(super) trait Place: Copy {
    /// From its number, which fits.
    fn of(register: u32) -> Self;
    /// Its number.
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

/// A sum of the next so many terms of each kind, added to the register `start`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<P> {
    pub out: P,
    pub start: P,
    pub linear: u32,
    pub bilinear: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Each(Code),
    Rows,
}

impl Kind {
    /// Where it stands among others of its level.
    pub fn order(self) -> usize {
        match self {
            Kind::Rows => 0,
            Kind::Each(Code::Copy) => 1,
            Kind::Each(Code::Unary(op)) => 2 + op as usize,
            Kind::Each(Code::Binary(op)) => 32 + op as usize,
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
    /// a of each c·a
    pub linear: Vec<P>,
    /// a and b of each c·a·b
    pub bilinear: Vec<[P; 2]>,
    /// c of each term, row by row, the linear ones first.
    pub coefficients: Vec<u32>,
}

impl Body<u32> {
    /// The same with other places, which must be able to name all registers.
    pub fn with_places<P: Place>(&self) -> Body<P> {
        let operation =
            |o: &Operation<u32>| Operation { code: o.code, a: P::of(o.a), b: P::of(o.b), out: P::of(o.out) };
        let row =
            |r: &Row<u32>| Row { out: P::of(r.out), start: P::of(r.start), linear: r.linear, bilinear: r.bilinear };
        Body {
            batches: self.batches.clone(),
            operations: self.operations.iter().map(operation).collect(),
            rows: self.rows.iter().map(row).collect(),
            linear: self.linear.iter().map(|a| P::of(*a)).collect(),
            bilinear: self.bilinear.iter().map(|[a, b]| [P::of(*a), P::of(*b)]).collect(),
            coefficients: self.coefficients.clone(),
        }
    }
}

impl<P: Place> Body<P> {
    /// Number of operations and rows.
    pub fn count(&self) -> usize {
        self.operations.len() + self.rows.len()
    }

    /// The coefficients in the order of their use.
    pub fn gather<const L: usize>(&self, registers: &[[f64; L]]) -> Vec<[f64; L]> {
        self.coefficients.iter().map(|c| registers[*c as usize]).collect()
    }

    /// Does everything once.
    #[inline(always)]
    pub fn run<const L: usize, R>(&self, registers: &mut R, mut coefficients: &[[f64; L]])
    where
        R: Index<usize, Output = [f64; L]> + IndexMut<usize> + ?Sized,
    {
        let (mut operations, mut rows) = (&self.operations[..], &self.rows[..]);
        let (mut linear, mut bilinear) = (&self.linear[..], &self.bilinear[..]);
        for batch in &self.batches {
            match batch.kind {
                Kind::Each(code) => {
                    let (now, rest) = operations.split_at(batch.count);
                    each(code, now, registers);
                    operations = rest;
                }
                Kind::Rows => {
                    let (now, rest) = rows.split_at(batch.count);
                    for row in now {
                        let mut sum = registers[row.start.index()];
                        let (ones, twos) = (row.linear as usize, row.bilinear as usize);
                        for (a, c) in linear[..ones].iter().zip(coefficients) {
                            let a = &registers[a.index()];
                            sum = std::array::from_fn(|i| sum[i] + c[i] * a[i]);
                        }
                        coefficients = &coefficients[ones..];
                        for ([a, b], c) in bilinear[..twos].iter().zip(coefficients) {
                            let (a, b) = (&registers[a.index()], &registers[b.index()]);
                            sum = std::array::from_fn(|i| sum[i] + c[i] * (a[i] * b[i]));
                        }
                        coefficients = &coefficients[twos..];
                        (linear, bilinear) = (&linear[ones..], &bilinear[twos..]);
                        registers[row.out.index()] = sum;
                    }
                    rows = rest;
                }
            }
        }
    }
}

#[inline(always)]
fn lanes<const L: usize, P: Place, R>(operations: &[Operation<P>], registers: &mut R, f: impl Fn(f64) -> f64)
where
    R: Index<usize, Output = [f64; L]> + IndexMut<usize> + ?Sized,
{
    for op in operations {
        let a = registers[op.a.index()];
        registers[op.out.index()] = std::array::from_fn(|i| f(a[i]));
    }
}

#[inline(always)]
fn pairs<const L: usize, P: Place, R>(operations: &[Operation<P>], registers: &mut R, f: impl Fn(f64, f64) -> f64)
where
    R: Index<usize, Output = [f64; L]> + IndexMut<usize> + ?Sized,
{
    for op in operations {
        let (a, b) = (registers[op.a.index()], registers[op.b.index()]);
        registers[op.out.index()] = std::array::from_fn(|i| f(a[i], b[i]));
    }
}

/// One operation on many registers.
#[inline(always)]
pub(super) fn each<const L: usize, P: Place, R>(code: Code, operations: &[Operation<P>], registers: &mut R)
where
    R: Index<usize, Output = [f64; L]> + IndexMut<usize> + ?Sized,
{
    match code {
        Code::Copy => lanes(operations, registers, |a| a),
        Code::Unary(Unary::Neg) => lanes(operations, registers, |a| -a),
        Code::Unary(Unary::Abs) => lanes(operations, registers, f64::abs),
        Code::Unary(op) => lanes(operations, registers, |a| op.apply(a)),
        Code::Binary(Binary::Add) => pairs(operations, registers, |a, b| a + b),
        Code::Binary(Binary::Sub) => pairs(operations, registers, |a, b| a - b),
        Code::Binary(Binary::Mul) => pairs(operations, registers, |a, b| a * b),
        Code::Binary(Binary::Div) => pairs(operations, registers, |a, b| a / b),
        Code::Binary(op) => pairs(operations, registers, |a, b| op.apply(a, b)),
    }
}
