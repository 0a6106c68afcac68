//! A [`Plan`] split for one trajectory: operations that depend on inputs alone, those that depend
//! on states, and the terms of its formulas.
//!
//! ```text
//! f = c₀ + Σ c a + Σ c a b
//! a, b: a state, its absolute value, a register that depends on inputs alone, or any other
//! ```

use super::body::{Batch, Body, Code, Kind, Operation, Place, Row};
use super::graph::Binary;
use super::plan::{FEW, Plan, Registers, Size};

/// Operations with their coefficients.
#[derive(Debug, Clone, Default)]
pub(super) struct Part {
    pub body: Body<u8>,
    pub coefficients: Vec<[f64; 1]>,
}

impl Part {
    pub fn is_empty(&self) -> bool {
        self.body.batches.is_empty()
    }

    /// Closes the batch that began after `before` operations.
    fn close(&mut self, kind: Kind, before: usize) {
        let count = self.body.count() - before;
        if count > 0 {
            self.body.batches.push(Batch { kind, count });
        }
    }
}

/// Kind of a factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Factor {
    /// The state with this index.
    State(usize),
    /// Its absolute value.
    Size(usize),
    /// A register that depends on inputs alone.
    Input(u8),
    /// A register that depends on states.
    Other(u8),
}

/// c·a or c·a·b in the formula `lane`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    pub lane: usize,
    pub coefficient: f64,
    pub first: Factor,
    pub second: Option<Factor>,
}

/// A plan with its parameters, split. Registers have new indices: 0..n the states, n..2n their
/// absolute values, then the rest.
pub(super) struct Sorted {
    /// Operations that depend on inputs alone.
    pub early: Part,
    /// Operations that depend on states.
    pub late: Part,
    /// Constant part of each formula.
    pub start: Vec<f64>,
    pub entries: Vec<Entry>,
    /// Values of the registers by new index; leaves after the states follow the absolute values.
    pub registers: Vec<(u8, f64)>,
}

/// State of the walk through the operations.
struct Walk {
    /// New index of each register.
    place: Vec<u8>,
    /// Whether the register at a new index depends on states.
    late: [bool; FEW],
    /// Lanes of the states and of the formulas.
    width: usize,
}

impl Walk {
    fn at(&self, register: u8) -> u8 {
        self.place[register.index()]
    }

    fn reads_states(&self, place: u8) -> bool {
        self.late[place.index()]
    }

    fn factor(&self, register: u8) -> Factor {
        let place = self.at(register);
        match place.index() {
            k if k < self.width => Factor::State(k),
            k if k < 2 * self.width => Factor::Size(k - self.width),
            _ if self.reads_states(place) => Factor::Other(place),
            _ => Factor::Input(place),
        }
    }
}

impl Sorted {
    /// Splits the plan for the parameters in `registers`, which must be prepared. `None` if there
    /// are more than `width` states or formulas, or more registers than a byte can address.
    pub fn of(plan: &Plan, registers: &Registers<1>, width: usize) -> Option<Sorted> {
        let Size::Small(body) = &plan.body else { return None };
        let (states, sizes) = (plan.states, plan.leaves.len()..plan.leaves.len() + plan.states);
        if states > width || plan.outputs > width || plan.registers + 2 * width > FEW {
            return None;
        }
        let place = |r: usize| match r {
            state if state < states => state,
            size if sizes.contains(&size) => width + size - sizes.start,
            other => other + 2 * width - states,
        };
        let place = (0..plan.registers).map(|r| place(r) as u8).collect();
        let mut walk = Walk { place, late: std::array::from_fn(|k| k < 2 * width), width };
        let values = |register: u8| registers.all[register.index()][0];
        let first_output = plan.first_output;
        let mut sorted = Sorted {
            early: Part::default(),
            late: Part::default(),
            start: (0..plan.outputs).map(|k| registers.all[first_output + k][0]).collect(),
            entries: Vec::new(),
            registers: Vec::new(),
        };
        let (mut operations, mut rows) = (body.operations.iter(), body.rows.iter());
        let (mut factors, mut coefficients) = (&body.factors[..], &body.coefficients[..]);
        for batch in &body.batches {
            let before = [sorted.early.body.count(), sorted.late.body.count()];
            match batch.kind {
                Kind::Each(code) => {
                    operations.by_ref().take(batch.count).for_each(|op| {
                        let lane = op.out.index().checked_sub(first_output);
                        sorted.operation(code, op, lane, &mut walk);
                    });
                }
                Kind::Rows(terms) => {
                    for row in rows.by_ref().take(batch.count) {
                        let c: Vec<f64> = coefficients[..terms].iter().map(|c| registers.all[*c as usize][0]).collect();
                        let ab = &factors[..terms];
                        (factors, coefficients) = (&factors[terms..], &coefficients[terms..]);
                        match row.out.index().checked_sub(first_output) {
                            Some(lane) => {
                                sorted.start[lane] = values(row.start);
                                let factor = |b: u8| (b != body.one).then(|| walk.factor(b));
                                let both = ab.iter().map(|[a, b]| (walk.factor(*a), factor(*b)));
                                sorted.entries.extend(both.zip(c).map(|((first, second), coefficient)| Entry {
                                    lane,
                                    coefficient,
                                    first,
                                    second,
                                }));
                            }
                            None => sorted.row(row, ab, &c, &mut walk),
                        }
                    }
                }
            }
            sorted.early.close(batch.kind, before[0]);
            sorted.late.close(batch.kind, before[1]);
        }
        sorted.multiply_inputs(plan.registers + 2 * width - states)?;
        let kept = registers.all.iter().zip(&walk.place).skip(states);
        sorted.registers = kept.map(|(value, place)| (*place, value[0])).collect();
        Some(sorted)
    }

    fn operation(&mut self, code: Code, op: &Operation<u8>, lane: Option<usize>, walk: &mut Walk) {
        let mut entry = |lane: usize, first: Factor, second: Option<Factor>| {
            self.start[lane] = 0.0;
            self.entries.push(Entry { lane, coefficient: 1.0, first, second });
        };
        match (code, lane) {
            (Code::Copy, Some(lane)) => entry(lane, walk.factor(op.a), None),
            (Code::Binary(Binary::Mul), Some(lane)) => entry(lane, walk.factor(op.a), Some(walk.factor(op.b))),
            _ => {
                let (a, b, out) = (walk.at(op.a), walk.at(op.b), walk.at(op.out));
                let late = walk.reads_states(a) || walk.reads_states(b);
                walk.late[out.index()] = late;
                let part = if late { &mut self.late } else { &mut self.early };
                part.body.operations.push(Operation { code: op.code, a, b, out });
                if let Some(lane) = lane {
                    entry(lane, walk.factor(op.out), None);
                }
            }
        }
    }

    /// Computes each product of two registers of inputs in a register of its own, from the index
    /// `next` on; `None` if there is no room.
    fn multiply_inputs(&mut self, next: usize) -> Option<()> {
        let (before, mut made) = (self.early.body.count(), Vec::new());
        for entry in &mut self.entries {
            let (Factor::Input(a), Some(Factor::Input(b))) = (entry.first, entry.second) else { continue };
            let known = made.iter().position(|ab| *ab == [a, b]);
            let out = next + known.unwrap_or(made.len());
            if out >= FEW {
                return None;
            }
            let out = out as u8;
            if known.is_none() {
                let code = Code::Binary(Binary::Mul);
                self.early.body.operations.push(Operation { code, a, b, out });
                made.push([a, b]);
            }
            (entry.first, entry.second) = (Factor::Input(out), None);
        }
        self.early.close(Kind::Each(Code::Binary(Binary::Mul)), before);
        Some(())
    }

    fn row(&mut self, row: &Row<u8>, ab: &[[u8; 2]], c: &[f64], walk: &mut Walk) {
        let ab: Vec<[u8; 2]> = ab.iter().map(|ab| ab.map(|r| walk.at(r))).collect();
        let (start, out) = (walk.at(row.start), walk.at(row.out));
        let late = ab.as_flattened().iter().chain([&start]).any(|place| walk.reads_states(*place));
        walk.late[out.index()] = late;
        let part = if late { &mut self.late } else { &mut self.early };
        part.body.rows.push(Row { out, start });
        part.body.factors.extend(ab);
        part.coefficients.extend(c.iter().map(|c| [*c]));
    }
}
