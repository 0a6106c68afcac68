//! A [`Plan`] for one trajectory: its formulas are the lanes of one register.
//!
//! ```text
//! f = c + (d + q∘|x|)∘x + a∘|x| + Σ cₖ∘Pₖx + Σ cₖ∘Pₖx∘P'ₖx + Σ cₖ∘Pₖx∘P'ₖ|x| + …
//! c = c₀ + Σ cᵢ i, d = d₀ + Σ dᵢ i, a = Σ aᵢ i
//! i: inputs and what depends on them alone      c, d, q, a: a number for each of N formulas
//! P: states in other lanes
//! ```
//!
//! With one instant at a time, the lanes hold the formulas. The part that depends on inputs alone
//! is computed once an instant by [`Dense::drive`]; states move from lane to lane without a detour
//! through memory. Only parts that are no polynomials go through memory, and their terms are added
//! last (…).

use super::body::Place;
use super::plan::{FEW, Plan, Registers};
use super::sorted::{Entry, Factor, Part, Sorted};
use crate::simd::{Four, Plain, Turn};

/// Registers aligned to a cache line, so that no vector straddles two.
#[derive(Debug, Clone)]
#[repr(align(64))]
struct Lines([[f64; 1]; FEW]);

/// A coefficient for each formula.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
struct Column<const Q: usize>([[f64; 4]; Q]);

/// Terms c·Πa with a vector c and factors a from memory.
type Terms<T, const Q: usize> = Vec<(T, Column<Q>)>;

/// A term c∘Px or c∘Px∘P'x of four formulas: coefficients, the vectors of four states that are
/// read, and their lanes.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
struct Turned<const K: usize> {
    coefficient: [f64; 4],
    turns: [Turn; K],
    from: [u8; K],
    /// Lanes that are in use.
    taken: [bool; 4],
}

impl<const K: usize> Default for Turned<K> {
    /// A term that adds nothing.
    fn default() -> Turned<K> {
        Turned { coefficient: [0.0; 4], turns: [Turn::default(); K], from: [0; K], taken: [false; 4] }
    }
}

/// Contribution to c, d and a of a register that depends on inputs alone.
#[derive(Debug, Clone, Copy)]
struct Drive<const Q: usize> {
    start: Column<Q>,
    own: Column<Q>,
    size: Column<Q>,
    from: u8,
}

/// Up to N = 4·`Q` formulas of up to N states.
#[derive(Debug, Clone)]
pub struct Dense<const Q: usize> {
    /// The states, their absolute values, the inputs, and the other registers of the operations.
    registers: Box<Lines>,
    /// Operations that read inputs alone.
    early: Part,
    /// Operations that read states.
    late: Part,
    /// c₀ and d₀
    start: Column<Q>,
    own: Column<Q>,
    drives: Vec<Drive<Q>>,
    /// q
    own_quadratic: Column<Q>,
    /// Terms of the states. The first of each list is stored separately: most planar models have no
    /// other.
    linear: [Turned<1>; Q],
    product: [Turned<2>; Q],
    linears: [Vec<Turned<1>>; Q],
    products: [Vec<Turned<2>>; Q],
    /// Terms whose second factor is an absolute value.
    crossed: [Vec<Turned<2>>; Q],
    /// The other terms, with states from memory.
    rest: Terms<u8, Q>,
    rest_products: Terms<[u8; 2], Q>,
    /// Whether there are no terms but the first of each list.
    only_first: bool,
}

/// The coefficients c, d and a under the inputs of one instant.
#[derive(Debug, Clone, Copy)]
pub struct Driven<V, const Q: usize> {
    start: [V; Q],
    own: [V; Q],
    size: [V; Q],
}

impl<V: Copy, const Q: usize> Driven<V, Q> {
    /// Adds the contribution of a register that depends on inputs alone.
    #[inline(always)]
    fn add<F: Four<Value = V>>(&mut self, four: F, drive: &Drive<Q>, value: f64) {
        let value = four.splat(value);
        for q in 0..Q {
            self.start[q] = four.fused(four.load(&drive.start.0[q]), value, self.start[q]);
            self.own[q] = four.fused(four.load(&drive.own.0[q]), value, self.own[q]);
            self.size[q] = four.fused(four.load(&drive.size.0[q]), value, self.size[q]);
        }
    }
}

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

/// Stores c times the product of `states` in the lane `lane` of the first term that reads them from
/// the right vectors and has that lane free.
fn turn<const K: usize>(all: &mut Vec<Turned<K>>, lane: usize, states: [usize; K], c: f64) {
    let (lane, from) = (lane % 4, states.map(|s| (s / 4) as u8));
    let at = all.iter().position(|t| t.from == from && !t.taken[lane]).unwrap_or_else(|| {
        all.push(Turned { from, ..Turned::default() });
        all.len() - 1
    });
    let term = &mut all[at];
    (term.coefficient[lane], term.taken[lane]) = (c, true);
    term.turns.iter_mut().zip(states).for_each(|(turn, state)| turn.set(lane, state % 4));
}

impl<const Q: usize> Dense<Q> {
    const N: usize = 4 * Q;

    /// The plan for the parameters in `registers`, which must be prepared. `None` if there are more
    /// than N states or formulas, or more registers than a byte can address.
    pub fn of(plan: &Plan, registers: &Registers<1>) -> Option<Dense<Q>> {
        let sorted = Sorted::of(plan, registers, Self::N)?;
        let zero = Column([[0.0; 4]; Q]);
        let mut dense = Dense {
            registers: Box::new(Lines([[0.0]; FEW])),
            early: sorted.early,
            late: sorted.late,
            start: zero,
            own: zero,
            drives: Vec::new(),
            own_quadratic: zero,
            linear: [Turned::default(); Q],
            product: [Turned::default(); Q],
            linears: [const { Vec::new() }; Q],
            products: [const { Vec::new() }; Q],
            crossed: [const { Vec::new() }; Q],
            rest: Vec::new(),
            rest_products: Vec::new(),
            only_first: false,
        };
        dense.start.0.as_flattened_mut()[..sorted.start.len()].copy_from_slice(&sorted.start);
        for (place, value) in sorted.registers {
            dense.registers.0[place.index()] = [value];
        }
        sorted.entries.iter().filter(|e| e.coefficient != 0.0).for_each(|e| dense.take(e));
        for q in 0..Q {
            dense.linear[q] = first(&mut dense.linears[q]);
            dense.product[q] = first(&mut dense.products[q]);
        }
        let none =
            |q: usize| dense.linears[q].is_empty() && dense.products[q].is_empty() && dense.crossed[q].is_empty();
        dense.only_first = (0..Q).all(none) && !dense.remembers();
        Some(dense)
    }

    /// Adds a term to the list of its kind.
    fn take(&mut self, entry: &Entry) {
        use Factor::{Input, Other, Size, State};
        let Entry { lane, coefficient: c, first, second } = *entry;
        let place = |factor: Factor| match factor {
            State(k) => k as u8,
            Size(k) => (k + Self::N) as u8,
            Input(place) | Other(place) => place,
        };
        match (first, second) {
            (State(k), None) if k == lane => self.own.0.as_flattened_mut()[lane] += c,
            (State(k), None) => turn(&mut self.linears[lane / 4], lane, [k], c),
            (Input(i), None) => self.drive_of(i).start.0.as_flattened_mut()[lane] += c,
            (a, None) => add(&mut self.rest, place(a), lane, c),
            (Input(i), Some(State(k))) | (State(k), Some(Input(i))) if k == lane => {
                self.drive_of(i).own.0.as_flattened_mut()[lane] += c;
            }
            (Input(i), Some(Size(k))) | (Size(k), Some(Input(i))) if k == lane => {
                self.drive_of(i).size.0.as_flattened_mut()[lane] += c;
            }
            (State(k), Some(Size(s))) | (Size(s), Some(State(k))) if k == lane && s == lane => {
                self.own_quadratic.0.as_flattened_mut()[lane] += c;
            }
            (State(a), Some(State(b))) => turn(&mut self.products[lane / 4], lane, [a.min(b), a.max(b)], c),
            (State(a), Some(Size(b))) | (Size(b), Some(State(a))) => {
                turn(&mut self.crossed[lane / 4], lane, [a, b], c);
            }
            (a, Some(b)) => add(&mut self.rest_products, [place(a), place(b)], lane, c),
        }
    }

    fn drive_of(&mut self, from: u8) -> &mut Drive<Q> {
        let at = self.drives.iter().position(|d| d.from == from).unwrap_or_else(|| {
            let zero = Column([[0.0; 4]; Q]);
            self.drives.push(Drive { start: zero, own: zero, size: zero, from });
            self.drives.len() - 1
        });
        &mut self.drives[at]
    }

    /// Whether a term or an operation reads the states from memory.
    fn remembers(&self) -> bool {
        !(self.late.is_empty() && self.rest.is_empty() && self.rest_products.is_empty())
    }

    /// Whether the formulas may depend on inputs.
    #[inline(always)]
    pub fn is_driven(&self) -> bool {
        !(self.drives.is_empty() && self.only_first)
    }

    /// The coefficients under these inputs, the leaves after the states in their order, for the
    /// evaluations that follow.
    #[inline(always)]
    pub fn drive<F: Four>(&mut self, four: F, inputs: &[f64]) -> Driven<F::Value, Q> {
        let mut driven =
            Driven { start: loaded(four, &self.start), own: loaded(four, &self.own), size: [four.splat(0.0); Q] };
        if self.only_first && self.early.is_empty() {
            // nothing else reads the registers
            for drive in &self.drives {
                driven.add(four, drive, inputs[drive.from.index() - 2 * Self::N]);
            }
            return driven;
        }
        let all = &mut self.registers.0;
        all[2 * Self::N..].iter_mut().zip(inputs).for_each(|(to, x)| *to = [*x]);
        self.early.body.run(Plain, all, &self.early.coefficients);
        for drive in &self.drives {
            driven.add(four, drive, all[drive.from.index()][0]);
        }
        driven
    }

    /// The formulas at the states `x` and the inputs that [`Dense::drive`] was last called with.
    #[inline(always)]
    pub fn evaluate<F: Four>(&mut self, four: F, driven: &Driven<F::Value, Q>, x: &[F::Value; Q]) -> [F::Value; Q] {
        // loops instead of closures: code that is not inlined here is not vectorised
        let mut size = *x;
        for q in 0..Q {
            size[q] = four.abs(x[q]);
        }
        // two independent sums: neither waits for the other
        let (mut near, mut far) = (driven.start, [four.splat(0.0); Q]);
        for q in 0..Q {
            let own = four.fused(four.load(&self.own_quadratic.0[q]), size[q], driven.own[q]);
            near[q] = four.fused(own, x[q], four.fused(driven.size[q], size[q], near[q]));
            far[q] = plus_product(four, plus_turned(four, far[q], x, &self.linear[q]), x, x, &self.product[q]);
        }
        if !self.only_first {
            for q in 0..Q {
                for term in &self.linears[q] {
                    near[q] = plus_turned(four, near[q], x, term);
                }
                for term in &self.products[q] {
                    far[q] = plus_product(four, far[q], x, x, term);
                }
                for term in &self.crossed[q] {
                    far[q] = plus_product(four, far[q], x, &size, term);
                }
            }
            let all = &mut self.registers.0;
            let places = all.as_flattened_mut().as_chunks_mut::<4>().0;
            for q in 0..Q {
                places[q] = four.store(x[q]);
                places[Q + q] = four.store(size[q]);
            }
            self.late.body.run(Plain, all, &self.late.coefficients);
            near = summed(four, near, &self.rest, |a| all[a.index()][0]);
            far = summed(four, far, &self.rest_products, |[a, b]| all[a.index()][0] * all[b.index()][0]);
        }
        for q in 0..Q {
            near[q] = four.add(near[q], far[q]);
        }
        near
    }
}

/// Removes and returns the first term of a list, or a term that adds nothing.
fn first<const K: usize>(terms: &mut Vec<Turned<K>>) -> Turned<K> {
    if terms.is_empty() { Turned::default() } else { terms.remove(0) }
}

/// The vector of states with this index. Q is a power of two, so that the mask keeps the index in
/// range.
#[inline(always)]
fn four_of<V: Copy, const Q: usize>(x: &[V; Q], from: u8) -> V {
    x[from.index() & (Q - 1)]
}

/// sum + c∘Px
#[inline(always)]
fn plus_turned<F: Four, const Q: usize>(four: F, sum: F::Value, x: &[F::Value; Q], term: &Turned<1>) -> F::Value {
    let a = four.turn(four_of(x, term.from[0]), &term.turns[0]);
    four.fused(four.load(&term.coefficient), a, sum)
}

/// sum + c∘Px∘P'y
#[inline(always)]
fn plus_product<F: Four, const Q: usize>(
    four: F,
    sum: F::Value,
    x: &[F::Value; Q],
    y: &[F::Value; Q],
    term: &Turned<2>,
) -> F::Value {
    let a = four.turn(four_of(x, term.from[0]), &term.turns[0]);
    let b = four.turn(four_of(y, term.from[1]), &term.turns[1]);
    four.fused(four.load(&term.coefficient), four.mul(a, b), sum)
}

#[inline(always)]
fn loaded<F: Four, const Q: usize>(four: F, column: &Column<Q>) -> [F::Value; Q] {
    let mut all = [four.splat(0.0); Q];
    for q in 0..Q {
        all[q] = four.load(&column.0[q]);
    }
    all
}

/// sum + Σ c·a
#[inline(always)]
fn summed<T: Copy, F: Four, const Q: usize>(
    four: F,
    mut sum: [F::Value; Q],
    terms: &Terms<T, Q>,
    value: impl Fn(T) -> f64,
) -> [F::Value; Q] {
    for (factors, c) in terms {
        let a = four.splat(value(*factors));
        for q in 0..Q {
            sum[q] = four.fused(four.load(&c.0[q]), a, sum[q]);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::{Expr, Graph, Leaf};
    use super::*;
    use crate::units::Dimension;

    /// Terms are summed in another order: some roundings of 1e-16 each.
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
        let plan = Plan::compile_after(&formulas, &leading, 3);
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
        let mut dense = Dense::<2>::of(&plan, &registers).expect("small enough");
        let inputs: Vec<f64> = leading[3..].iter().map(|leaf| value(*leaf)).collect();
        let x = [[0.7, -0.4, 1.3, 0.0], [0.0; 4]];
        let driven = dense.drive(Plain, &inputs);
        let all = dense.evaluate(Plain, &driven, &x);
        let check = |found: f64, f: Expr<'_>| {
            let exact = f.evaluate(&value);
            assert!((found - exact).abs() <= 4e-15 * exact.abs().max(1.0), "{f:?}: {found} and {exact}");
        };
        all.as_flattened().iter().zip(formulas).for_each(|(found, f)| check(*found, f));
        assert!(Dense::<1>::of(&plan, &registers).is_none(), "seven formulas in four lanes");
    }
}
