//! Formulas as sums of products, which are cheap to evaluate.
//!
//! ```text
//! f = c₀ + Σ cₖ aₖ + Σ cₖ aₖ bₖ        c read parameters alone, a and b are leaves or results of their own
//! ```
//!
//! A drag (d + d_q|u|) u becomes d·u + d_q·|u|·u: two terms of the row that is summed anyway,
//! instead of three operations with a register each. A part that other formulas read too, or that
//! is no polynomial, stays a separate result.

use std::rc::Rc;

use super::expr::Expr;
use super::graph::{Binary, Node, Unary};

/// No factor.
pub(super) const NONE: u32 = u32::MAX;

/// A term c·a·b; factors are nodes, sorted, [`NONE`] if there are fewer than two.
#[derive(Debug, Clone, Copy)]
pub(super) struct Term<'g> {
    pub coefficient: Expr<'g>,
    pub factors: [u32; 2],
}

impl<'g> Term<'g> {
    pub fn of(factor: Expr<'g>) -> Term<'g> {
        Term { coefficient: factor.graph.constant(1.0), factors: [factor.id, NONE] }
    }

    fn degree(&self) -> usize {
        self.factors.iter().filter(|f| **f != NONE).count()
    }

    fn times(&self, other: &Term<'g>) -> Term<'g> {
        let [a, b] = self.factors;
        let mut all = [a, b, other.factors[0], other.factors[1]];
        all.sort_unstable();
        Term { coefficient: self.coefficient * other.coefficient, factors: [all[0], all[1]] }
    }
}

/// Properties of the nodes of a graph during compilation.
#[derive(Debug, Default)]
pub(super) struct Products<'g> {
    /// Whether a node depends on parameters and constants alone.
    early: Vec<Option<bool>>,
    /// Number of nodes and outputs that read a node.
    uses: Vec<u32>,
    sums: Vec<Option<Rc<[Term<'g>]>>>,
}

impl<'g> Products<'g> {
    /// Counts how often the nodes of the formulas are read.
    pub fn new(outputs: &[Expr<'g>]) -> Products<'g> {
        let mut products = Products::default();
        let mut stack = Vec::new();
        let visit = |uses: &mut Vec<u32>, e: Expr<'g>, stack: &mut Vec<Expr<'g>>| {
            let id = e.id as usize;
            if uses.len() <= id {
                uses.resize(id + 1, 0);
            }
            uses[id] += 1;
            if uses[id] == 1 {
                stack.push(e);
            }
        };
        outputs.iter().for_each(|e| visit(&mut products.uses, *e, &mut stack));
        while let Some(node) = stack.pop() {
            match node.graph.node_of(node.id) {
                Node::Constant(_) | Node::Quantity(..) | Node::Leaf(_) => {}
                Node::Unary(_, a) => visit(&mut products.uses, node.at(a), &mut stack),
                Node::Binary(_, a, b) => {
                    visit(&mut products.uses, node.at(a), &mut stack);
                    visit(&mut products.uses, node.at(b), &mut stack);
                }
            }
        }
        products
    }

    /// Whether the formula depends on parameters and constants alone.
    pub fn is_early(&mut self, of: Expr<'g>) -> bool {
        let id = of.id as usize;
        if let Some(Some(known)) = self.early.get(id) {
            return *known;
        }
        let early = match of.graph.node_of(of.id) {
            Node::Constant(_) | Node::Quantity(..) => true,
            Node::Leaf(leaf) => leaf.is_parameter(),
            Node::Unary(_, a) => self.is_early(of.at(a)),
            Node::Binary(_, a, b) => self.is_early(of.at(a)) && self.is_early(of.at(b)),
        };
        if self.early.len() <= id {
            self.early.resize(id + 1, None);
        }
        self.early[id] = Some(early);
        early
    }

    /// Whether several nodes or outputs read it.
    pub fn is_shared(&self, of: Expr<'g>) -> bool {
        self.uses.get(of.id as usize).is_some_and(|n| *n > 1)
    }

    /// The formula as a sum of terms; a single term, the formula itself, if it is no polynomial.
    pub fn sum(&mut self, of: Expr<'g>) -> Rc<[Term<'g>]> {
        if self.is_early(of) {
            return Rc::new([Term { coefficient: of, factors: [NONE; 2] }]);
        }
        let id = of.id as usize;
        if let Some(Some(known)) = self.sums.get(id) {
            return known.clone();
        }
        let sum: Rc<[Term<'g>]> = match of.graph.node_of(of.id) {
            Node::Unary(Unary::Neg, a) => self.part(of.at(a)).iter().map(negative).collect(),
            Node::Binary(Binary::Add, a, b) => joined(&self.part(of.at(a)), self.part(of.at(b)).iter().copied()),
            Node::Binary(Binary::Sub, a, b) => joined(&self.part(of.at(a)), self.part(of.at(b)).iter().map(negative)),
            Node::Binary(Binary::Mul, a, b) => self.product(of.at(a), of.at(b)),
            Node::Binary(Binary::Div, a, b) if self.is_early(of.at(b)) => {
                let inverse = of.graph.constant(1.0) / of.at(b);
                self.product(of.at(a), inverse)
            }
            _ => Rc::new([Term::of(of)]),
        };
        if self.sums.len() <= id {
            self.sums.resize(id + 1, None);
        }
        self.sums[id] = Some(sum.clone());
        sum
    }

    /// A part of a formula: as its terms if nothing else reads it or it is a single term, else as
    /// one factor.
    fn part(&mut self, of: Expr<'g>) -> Rc<[Term<'g>]> {
        let sum = self.sum(of);
        if sum.len() == 1 || !self.is_shared(of) { sum } else { Rc::new([Term::of(of)]) }
    }

    fn product(&mut self, a: Expr<'g>, b: Expr<'g>) -> Rc<[Term<'g>]> {
        let (first, second) = (self.part(a), self.part(b));
        let (one, many) = if first.len() == 1 { (&first, &second) } else { (&second, &first) };
        if one.len() == 1 && many.iter().all(|t| t.degree() + one[0].degree() <= 2) {
            return many.iter().map(|t| t.times(&one[0])).collect();
        }
        Rc::new([as_one_factor(a, &first).times(&as_one_factor(b, &second))])
    }
}

/// A sum as a term with at most one factor.
fn as_one_factor<'g>(of: Expr<'g>, sum: &[Term<'g>]) -> Term<'g> {
    match sum {
        [term] if term.degree() < 2 => *term,
        [term] => {
            let product = of.at(term.factors[0]) * of.at(term.factors[1]);
            Term { coefficient: term.coefficient, ..Term::of(product) }
        }
        _ => Term::of(of),
    }
}

fn negative<'g>(term: &Term<'g>) -> Term<'g> {
    Term { coefficient: -term.coefficient, ..*term }
}

/// Joins two sums; terms with the same factors become one.
fn joined<'g>(first: &[Term<'g>], second: impl Iterator<Item = Term<'g>>) -> Rc<[Term<'g>]> {
    let mut all = first.to_vec();
    for term in second {
        match all.iter_mut().find(|known| known.factors == term.factors) {
            Some(known) => known.coefficient += term.coefficient,
            None => all.push(term),
        }
    }
    all.into()
}

#[cfg(test)]
mod tests {
    use super::super::{Graph, Leaf};
    use super::*;
    use crate::units::Dimension;

    #[test]
    fn a_row_of_the_equations_is_one_sum() {
        let g = Graph::new();
        let [u, v, r] = [0, 1, 2].map(|k| g.leaf(Leaf::State(k), Dimension::ONE));
        let [m, d, q] = [0, 1, 2].map(|k| g.leaf(Leaf::Parameter(k), Dimension::ONE));
        let tau = g.leaf(Leaf::Input(0), Dimension::ONE);
        let row = (tau + m * v * r - (d + q * u.abs()) * u - d * u) / m;
        let mut products = Products::new(&[row]);
        let sum = products.sum(row);
        let degrees: Vec<usize> = sum.iter().map(Term::degree).collect();
        assert_eq!(degrees, [1, 2, 1, 2], "τ, v·r, u with both of its coefficients, u|u|");
        assert!(sum.iter().all(|t| products.is_early(t.coefficient)));
    }

    #[test]
    fn what_is_shared_or_no_polynomial_stays_whole() {
        let g = Graph::new();
        let [u, v] = [0, 1].map(|k| g.leaf(Leaf::State(k), Dimension::ONE));
        let slip = u - v;
        let formulas = [slip * slip.abs(), (u + v) * (u.sin() + 2.0), u * v * u];
        let mut products = Products::new(&formulas);
        for formula in formulas {
            let sum = products.sum(formula);
            assert_eq!((sum.len(), sum[0].degree()), (1, 2), "{formula:?}");
        }
    }
}
