//! Formulas with ordinary operators and exact simplifications.
//!
//! Only simplifications without rounding are made: x + 0, 1·x, 0·x, x − x, −(−x), folding of
//! constants.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::graph::{Binary, Graph, Leaf, Node, Unary};

/// A formula: a handle to a node of its [`Graph`]; copying it copies the handle.
#[derive(Clone, Copy)]
pub struct Expr<'g> {
    pub(super) graph: &'g Graph,
    pub(super) id: u32,
}

impl<'g> Expr<'g> {
    /// The graph that holds this formula.
    pub fn graph(self) -> &'g Graph {
        self.graph
    }

    /// The value of a constant, `None` for anything else.
    pub fn as_constant(self) -> Option<f64> {
        match self.graph.node_of(self.id) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// Whether this is the number 0, so that it need not be computed.
    pub fn is_zero(self) -> bool {
        self.as_constant().is_some_and(|c| c == 0.0)
    }

    pub(super) fn is_one(self) -> bool {
        self.as_constant().is_some_and(|c| c.to_bits() == 1f64.to_bits())
    }

    /// Whether both are the same formula of one graph.
    pub fn same(self, other: Expr<'g>) -> bool {
        self.id == other.id
    }

    fn unary(self, op: Unary) -> Expr<'g> {
        match self.as_constant() {
            Some(c) => self.graph.constant(op.apply(c)),
            None => self.graph.node(Node::Unary(op, self.id)),
        }
    }

    fn binary(self, op: Binary, other: Expr<'g>) -> Expr<'g> {
        if let (Some(a), Some(b)) = (self.as_constant(), other.as_constant()) {
            return self.graph.constant(op.apply(a, b));
        }
        let commutes = matches!(op, Binary::Add | Binary::Mul | Binary::Min | Binary::Max);
        let (a, b) = if commutes && self.id > other.id { (other.id, self.id) } else { (self.id, other.id) };
        self.graph.node(Node::Binary(op, a, b))
    }

    /// |x|
    pub fn abs(self) -> Expr<'g> {
        self.unary(Unary::Abs)
    }
    /// −1, 0 or 1 by the sign of x.
    pub fn sign(self) -> Expr<'g> {
        self.unary(Unary::Sign)
    }
    /// 1 if x > 0, else 0.
    pub fn step(self) -> Expr<'g> {
        self.unary(Unary::Step)
    }
    /// sin x
    pub fn sin(self) -> Expr<'g> {
        self.unary(Unary::Sin)
    }
    /// cos x
    pub fn cos(self) -> Expr<'g> {
        self.unary(Unary::Cos)
    }
    /// tan x
    pub fn tan(self) -> Expr<'g> {
        self.unary(Unary::Tan)
    }
    /// arctan x
    pub fn atan(self) -> Expr<'g> {
        self.unary(Unary::Atan)
    }
    /// tanh x
    pub fn tanh(self) -> Expr<'g> {
        self.unary(Unary::Tanh)
    }
    /// eˣ
    pub fn exp(self) -> Expr<'g> {
        self.unary(Unary::Exp)
    }
    /// ln x
    pub fn ln(self) -> Expr<'g> {
        self.unary(Unary::Ln)
    }
    /// √x
    pub fn sqrt(self) -> Expr<'g> {
        self.unary(Unary::Sqrt)
    }
    /// xʸ
    pub fn pow(self, exponent: Expr<'g>) -> Expr<'g> {
        match exponent.as_constant() {
            Some(0.0) => self.graph.constant(1.0),
            _ if exponent.is_one() => self,
            Some(c) if c.to_bits() == 2f64.to_bits() => self * self,
            Some(c) if c.to_bits() == 3f64.to_bits() => self * self * self,
            _ => self.binary(Binary::Pow, exponent),
        }
    }
    /// The smaller of two.
    pub fn min(self, other: Expr<'g>) -> Expr<'g> {
        self.binary(Binary::Min, other)
    }
    /// The larger of two.
    pub fn max(self, other: Expr<'g>) -> Expr<'g> {
        self.binary(Binary::Max, other)
    }
    /// The angle of the point (`x`, self), rad: in (−π, π].
    pub fn atan2(self, x: Expr<'g>) -> Expr<'g> {
        self.binary(Binary::Atan2, x)
    }

    /// Value of the formula if leaves have the values of `read`; for tests and single numbers.
    /// Loops use a [`super::Plan`].
    pub fn evaluate(self, read: &dyn Fn(Leaf) -> f64) -> f64 {
        match self.graph.node_of(self.id) {
            Node::Constant(bits) | Node::Quantity(bits, _) => f64::from_bits(bits),
            Node::Leaf(leaf) => read(leaf),
            Node::Unary(op, a) => op.apply(self.at(a).evaluate(read)),
            Node::Binary(op, a, b) => op.apply(self.at(a).evaluate(read), self.at(b).evaluate(read)),
        }
    }

    pub(super) fn at(self, id: u32) -> Expr<'g> {
        Expr { graph: self.graph, id }
    }

    /// Every leaf that the formula reads, sorted, each once.
    pub fn leaves(self) -> Vec<Leaf> {
        let (mut seen, mut stack, mut found) = (vec![false; self.graph.len()], vec![self.id], Vec::new());
        while let Some(id) = stack.pop() {
            if std::mem::replace(&mut seen[id as usize], true) {
                continue;
            }
            match self.graph.node_of(id) {
                Node::Constant(_) | Node::Quantity(..) => {}
                Node::Leaf(leaf) => found.push(leaf),
                Node::Unary(_, a) => stack.push(a),
                Node::Binary(_, a, b) => stack.extend([a, b]),
            }
        }
        found.sort_unstable();
        found
    }
}

impl std::fmt::Debug for Expr<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.graph.node_of(self.id) {
            Node::Constant(bits) | Node::Quantity(bits, _) => write!(f, "{}", f64::from_bits(bits)),
            Node::Leaf(leaf) => write!(f, "{leaf:?}"),
            Node::Unary(op, a) => write!(f, "{op:?}({:?})", self.at(a)),
            Node::Binary(op, a, b) => write!(f, "{op:?}({:?}, {:?})", self.at(a), self.at(b)),
        }
    }
}

impl<'g> Add for Expr<'g> {
    type Output = Expr<'g>;
    fn add(self, other: Expr<'g>) -> Expr<'g> {
        match (self.is_zero(), other.is_zero()) {
            (true, _) => other,
            (_, true) => self,
            _ => self.binary(Binary::Add, other),
        }
    }
}

impl<'g> Sub for Expr<'g> {
    type Output = Expr<'g>;
    fn sub(self, other: Expr<'g>) -> Expr<'g> {
        match (self.is_zero(), other.is_zero()) {
            (_, true) => self,
            (true, _) => -other,
            _ if self.same(other) => self.graph.zero(),
            _ => self.binary(Binary::Sub, other),
        }
    }
}

impl<'g> Mul for Expr<'g> {
    type Output = Expr<'g>;
    fn mul(self, other: Expr<'g>) -> Expr<'g> {
        match () {
            () if self.is_zero() || other.is_zero() => self.graph.zero(),
            () if self.is_one() => other,
            () if other.is_one() => self,
            () => self.binary(Binary::Mul, other),
        }
    }
}

impl<'g> Div for Expr<'g> {
    type Output = Expr<'g>;
    fn div(self, other: Expr<'g>) -> Expr<'g> {
        match () {
            () if self.is_zero() => self,
            () if other.is_one() => self,
            () => self.binary(Binary::Div, other),
        }
    }
}

impl<'g> Neg for Expr<'g> {
    type Output = Expr<'g>;
    fn neg(self) -> Expr<'g> {
        match self.graph.node_of(self.id) {
            Node::Unary(Unary::Neg, a) => self.at(a),
            _ => self.unary(Unary::Neg),
        }
    }
}

impl<'g> Add<f64> for Expr<'g> {
    type Output = Expr<'g>;
    fn add(self, other: f64) -> Expr<'g> {
        self + self.graph.constant(other)
    }
}

impl<'g> Sub<f64> for Expr<'g> {
    type Output = Expr<'g>;
    fn sub(self, other: f64) -> Expr<'g> {
        self - self.graph.constant(other)
    }
}

impl<'g> Mul<f64> for Expr<'g> {
    type Output = Expr<'g>;
    fn mul(self, other: f64) -> Expr<'g> {
        self * self.graph.constant(other)
    }
}

impl<'g> Div<f64> for Expr<'g> {
    type Output = Expr<'g>;
    fn div(self, other: f64) -> Expr<'g> {
        self / self.graph.constant(other)
    }
}

impl<'g> AddAssign for Expr<'g> {
    fn add_assign(&mut self, other: Expr<'g>) {
        *self = *self + other;
    }
}

impl<'g> SubAssign for Expr<'g> {
    fn sub_assign(&mut self, other: Expr<'g>) {
        *self = *self - other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Dimension;

    #[test]
    fn equal_formulas_are_one_node() {
        let g = Graph::new();
        let u = g.leaf(Leaf::State(0), Dimension::VELOCITY);
        let r = g.leaf(Leaf::State(1), Dimension::RATE);
        assert_eq!((u * r).id, (r * u).id);
        assert!((u * r - u * r).is_zero());
        assert_eq!((u * 1.0 + 0.0).id, u.id);
        assert_eq!((-(-u)).id, u.id);
        assert!((u * 0.0).is_zero());
    }

    #[test]
    fn leaves_are_listed_once() {
        let g = Graph::new();
        let u = g.leaf(Leaf::State(0), Dimension::VELOCITY);
        let d = g.leaf(Leaf::Parameter(0), Dimension::ONE);
        assert_eq!((d * u * u.abs()).leaves(), [Leaf::State(0), Leaf::Parameter(0)]);
    }
}
