//! A [`Plan`] for one trajectory: its formulas side by side in the lanes of one register.
//!
//! ```text
//! f = c₀ + (d + q∘|x|)∘x + Σ cₖ aₖ + Σ cₖ aₖ bₖ        c, d, q: vectors of N formulas; a, b: numbers
//! ```
//!
//! Where there is but one instant at a time, lanes are the formulas. What a state's own rate reads of it, linearly or as
//! x|x|, needs no place in memory at all. The first N registers are the states x, the next N are |x|.

use super::body::{Batch, Body, Code, Kind, Place};
use super::four::Four;
use super::graph::{Binary, Unary};
use super::plan::{FEW, Plan, Registers, Size};

/// On a line of the cache, so that no vector straddles two.
#[derive(Debug, Clone)]
#[repr(align(64))]
struct Lines([[f64; 1]; FEW]);

/// A coefficient of all formulas.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
struct Column<const Q: usize>([[f64; 4]; Q]);

/// Up to N = 4·`Q` formulas of up to N states.
#[derive(Debug, Clone)]
pub struct Dense<const Q: usize> {
    registers: Box<Lines>,
    /// What is no row of the formulas, done before them.
    before: Body<u8>,
    before_coefficients: Vec<[f64; 1]>,
    start: [[f64; 4]; Q],
    /// d
    own: [[f64; 4]; Q],
    /// q
    own_quadratic: [[f64; 4]; Q],
    /// Of even length, as the next.
    linear: Vec<u8>,
    linear_coefficients: Vec<Column<Q>>,
    bilinear: Vec<[u8; 2]>,
    bilinear_coefficients: Vec<Column<Q>>,
}

/// Terms c·Πa with a vector c.
type Terms<T, const Q: usize> = Vec<(T, Column<Q>)>;

/// Adds `c` to the lane `lane` of the term with these factors.
fn add<T: PartialEq, const Q: usize>(terms: &mut Terms<T, Q>, factors: T, lane: usize, c: f64) {
    if let Some((_, known)) = terms.iter_mut().find(|(known, _)| *known == factors) {
        known.0.as_flattened_mut()[lane] += c;
    } else {
        let mut column = Column([[0.0; 4]; Q]);
        column.0.as_flattened_mut()[lane] = c;
        terms.push((factors, column));
    }
}

/// Drops what is 0 and makes the number even; `zero` are the factors of a term that stays 0.
fn even<T, const Q: usize>(terms: &mut Terms<T, Q>, zero: T) {
    terms.retain(|(_, column)| column.0.as_flattened().iter().any(|c| *c != 0.0));
    if terms.len() % 2 == 1 {
        terms.push((zero, Column([[0.0; 4]; Q])));
    }
}

impl<const Q: usize> Dense<Q> {
    const N: usize = 4 * Q;

    /// The plan with the parameters in `registers`, which were prepared; its first `states` leaves are the states.
    /// `None` where there are more than N states or formulas, or more registers than a byte can name.
    pub fn of(plan: &Plan, registers: &Registers<1>, states: usize) -> Option<Dense<Q>> {
        let Size::Small(body) = &plan.body else { return None };
        if states > Self::N || plan.outputs > Self::N || plan.registers + 2 * Self::N > FEW {
            return None;
        }
        let values = &registers.all;
        let mut place: Vec<u8> =
            (0..plan.registers).map(|r| if r < states { r } else { r + 2 * Self::N - states } as u8).collect();
        let mut dense = Dense {
            registers: Box::new(Lines([[0.0]; FEW])),
            before: Body::default(),
            before_coefficients: Vec::new(),
            start: [[0.0; 4]; Q],
            own: [[0.0; 4]; Q],
            own_quadratic: [[0.0; 4]; Q],
            linear: Vec::new(),
            linear_coefficients: Vec::new(),
            bilinear: Vec::new(),
            bilinear_coefficients: Vec::new(),
        };
        let start = dense.start.as_flattened_mut();
        for (to, from) in start.iter_mut().zip(&values[plan.first_output..plan.first_output + plan.outputs]) {
            *to = from[0];
        }
        let (mut linear, mut bilinear): (Terms<u8, Q>, Terms<[u8; 2], Q>) = (Vec::new(), Vec::new());
        let (mut operations, mut rows, mut coefficients) = (0..body.operations.len(), body.rows.iter(), 0);
        let (mut ones, mut twos) = (0, 0);
        for batch in &body.batches {
            let before = dense.before.count();
            match batch.kind {
                Kind::Each(code) => {
                    for k in operations.by_ref().take(batch.count) {
                        let mut op = body.operations[k];
                        let lane = op.out.index().checked_sub(plan.first_output);
                        let of_state = op.a.index() < states;
                        let [a, b] = [op.a, op.b].map(|r| place[r.index()]);
                        match (code, lane) {
                            (Code::Unary(Unary::Abs), _) if of_state => place[op.out.index()] = op.a + Self::N as u8,
                            (Code::Copy, Some(_)) => place[op.out.index()] = a,
                            (Code::Binary(Binary::Mul), Some(lane)) => add(&mut bilinear, [a, b], lane, 1.0),
                            _ => {
                                (op.a, op.b, op.out) = (a, b, place[op.out.index()]);
                                dense.before.operations.push(op);
                            }
                        }
                        let summed = matches!((code, lane), (Code::Binary(Binary::Mul), Some(_)));
                        if let (Some(lane), false) = (lane, summed) {
                            start[lane] = 0.0;
                            add(&mut linear, place[body.operations[k].out.index()], lane, 1.0);
                        } else if let Some(lane) = lane {
                            start[lane] = 0.0;
                        }
                    }
                }
                Kind::Rows => {
                    for row in rows.by_ref().take(batch.count) {
                        let (one, two) = (row.linear as usize, row.bilinear as usize);
                        let (a, ab) = (&body.linear[ones..ones + one], &body.bilinear[twos..twos + two]);
                        let c = &body.coefficients[coefficients..coefficients + one + two];
                        (ones, twos, coefficients) = (ones + one, twos + two, coefficients + one + two);
                        let c = c.iter().map(|c| values[*c as usize][0]);
                        if let Some(lane) = row.out.index().checked_sub(plan.first_output) {
                            start[lane] = values[row.start.index()][0];
                            for (a, c) in a.iter().zip(c.clone()) {
                                add(&mut linear, place[a.index()], lane, c);
                            }
                            for (ab, c) in ab.iter().zip(c.skip(one)) {
                                add(&mut bilinear, ab.map(|r| place[r.index()]), lane, c);
                            }
                        } else {
                            let mut row = *row;
                            (row.out, row.start) = (place[row.out.index()], place[row.start.index()]);
                            dense.before.rows.push(row);
                            dense.before.linear.extend(a.iter().map(|r| place[r.index()]));
                            dense.before.bilinear.extend(ab.iter().map(|ab| ab.map(|r| place[r.index()])));
                            dense.before_coefficients.extend(c.map(|c| [c]));
                        }
                    }
                }
            }
            if dense.before.count() > before {
                dense.before.batches.push(Batch { kind: batch.kind, count: dense.before.count() - before });
            }
        }
        for (value, to) in values.iter().zip(&place).skip(states) {
            dense.registers.0[usize::from(*to)] = *value;
        }
        for (a, column) in &mut linear {
            if let Some(own) = column.0.as_flattened_mut().get_mut(a.index()) {
                dense.own.as_flattened_mut()[a.index()] = std::mem::take(own);
            }
        }
        for ([a, b], column) in &mut bilinear {
            let (low, high) = (a.index().min(b.index()), a.index().max(b.index()));
            if let (Some(own), true) = (column.0.as_flattened_mut().get_mut(low), high == low + Self::N) {
                dense.own_quadratic.as_flattened_mut()[low] = std::mem::take(own);
            }
        }
        let zero = place[plan.zero];
        even(&mut linear, zero);
        even(&mut bilinear, [zero; 2]);
        dense.linear_coefficients = linear.iter().map(|(_, c)| *c).collect();
        dense.bilinear_coefficients = bilinear.iter().map(|(_, c)| *c).collect();
        dense.linear = linear.into_iter().map(|(a, _)| a).collect();
        dense.bilinear = bilinear.into_iter().map(|(ab, _)| ab).collect();
        Some(dense)
    }

    /// The leaves after the states, in their order.
    #[inline(always)]
    pub fn inputs(&mut self) -> &mut [[f64; 1]] {
        &mut self.registers.0[2 * Self::N..]
    }

    /// The formulas at the states `x`.
    #[inline(always)]
    pub fn evaluate<F: Four>(&mut self, four: F, x: &[F::Value; Q]) -> [F::Value; Q] {
        let all = &mut self.registers.0;
        let mut size = *x;
        let places = all.as_flattened_mut().as_chunks_mut::<4>().0;
        for q in 0..Q {
            size[q] = four.abs(x[q]);
            places[q] = four.store(x[q]);
            places[Q + q] = four.store(size[q]);
        }
        if !self.before.batches.is_empty() {
            self.before.run(all, &self.before_coefficients);
        }
        // loops instead of closures: what is not inlined here is not compiled for vectors
        // each kind in two halves, whose sums do not wait for each other
        let zero = [four.splat(0.0); Q];
        let mut start = zero;
        for q in 0..Q {
            start[q] = four.load(&self.start[q]);
        }
        let (places, columns) = (halves(&self.linear), halves(&self.linear_coefficients));
        let first = summed(four, start, places.0, columns.0, |a| all[a.index()][0]);
        let second = summed(four, zero, places.1, columns.1, |a| all[a.index()][0]);
        let (places, columns) = (halves(&self.bilinear), halves(&self.bilinear_coefficients));
        let product = |[a, b]: [u8; 2]| all[a.index()][0] * all[b.index()][0];
        let third = summed(four, zero, places.0, columns.0, product);
        let fourth = summed(four, zero, places.1, columns.1, product);
        let mut sum = zero;
        for q in 0..Q {
            let (own, quadratic) = (four.load(&self.own[q]), four.load(&self.own_quadratic[q]));
            let own = four.mul(four.add(own, four.mul(quadratic, size[q])), x[q]);
            let ones = four.add(four.add(first[q], second[q]), own);
            sum[q] = four.add(ones, four.add(third[q], fourth[q]));
        }
        sum
    }
}

#[inline(always)]
fn halves<T>(terms: &[T]) -> (&[T], &[T]) {
    terms.split_at(terms.len() / 2)
}

/// sum + Σ c·a
#[inline(always)]
fn summed<T: Copy, F: Four, const Q: usize>(
    four: F,
    mut sum: [F::Value; Q],
    places: &[T],
    columns: &[Column<Q>],
    value: impl Fn(T) -> f64,
) -> [F::Value; Q] {
    for (place, c) in places.iter().zip(columns) {
        let a = four.splat(value(*place));
        for q in 0..Q {
            sum[q] = four.add(sum[q], four.mul(four.load(&c.0[q]), a));
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::{Expr, Graph, Leaf, Plain};
    use super::*;
    use crate::units::Dimension;

    /// Sums in another order: some roundings of 1e-16 each.
    #[test]
    fn law_dense_agrees_with_direct_evaluation() {
        let g = Graph::new();
        let [u, v, r] = [0, 1, 2].map(|k| g.leaf(Leaf::State(k), Dimension::ONE));
        let [m, d] = [0, 1].map(|k| g.leaf(Leaf::Parameter(k), Dimension::ONE));
        let [tau, wind] = [0, 1].map(|k| g.leaf(Leaf::Input(k), Dimension::ONE));
        let slip = u - wind;
        let formulas = [
            (tau * (g.constant(1.0) - d * u.abs()) - d * u * u.abs() + v * r - u) / m,
            slip * slip.abs() * d + (v * v + 1.0).sqrt() * r * u,
            r,
            m * d,
            u * r.abs(),
            v.sin(),
            slip,
        ];
        let leading: Vec<Leaf> = (0..3).map(Leaf::State).chain((0..2).map(Leaf::Input)).collect();
        let plan = Plan::compile_after(&formulas, &leading);
        let value = |leaf: Leaf| match leaf {
            Leaf::State(k) => [0.7, -0.4, 1.3][usize::from(k)],
            Leaf::Input(k) => [-2.5, 0.3][usize::from(k)],
            _ => 1.75,
        };
        let mut registers = plan.registers::<1>();
        for (slot, leaf) in plan.leaves().iter().enumerate() {
            plan.set(&mut registers, slot, [value(*leaf)]);
        }
        plan.prepare(&mut registers);
        let mut dense = Dense::<2>::of(&plan, &registers, 3).expect("small enough");
        for (to, leaf) in dense.inputs().iter_mut().zip(&leading[3..]) {
            *to = [value(*leaf)];
        }
        let x = [[0.7, -0.4, 1.3, 0.0], [0.0; 4]];
        let all = dense.evaluate(Plain, &x);
        let check = |found: f64, f: Expr<'_>| {
            let exact = f.evaluate(&value);
            assert!((found - exact).abs() <= 4e-15 * exact.abs().max(1.0), "{f:?}: {found} and {exact}");
        };
        all.as_flattened().iter().zip(formulas).for_each(|(found, f)| check(*found, f));
        assert!(Dense::<1>::of(&plan, &registers, 3).is_none(), "seven formulas in four lanes");
    }
}
