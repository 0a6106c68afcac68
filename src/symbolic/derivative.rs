//! Derivative of a formula by one of its leaves, by the chain rule on the graph.
//!
//! |x|′ = sign x, which is 0 at x = 0. Sign and step are constant almost everywhere: their derivative
//! is 0. Min and max of equal arguments have the derivative of the second. The delayed channel
//! depends on its delay T: ∂x(t − T)/∂T = −ẋ(t − T).

use std::collections::HashMap;

use super::expr::Expr;
use super::graph::{Binary, Leaf, Node, Unary};
use crate::units::Dimension;

impl<'g> Expr<'g> {
    /// ∂ self / ∂ `by`.
    pub fn derivative(self, by: Leaf) -> Expr<'g> {
        derivatives(&[self], by)[0]
    }
}

/// ∂ `of` / ∂ `by` of formulas of one graph; shared parts are differentiated once.
pub fn derivatives<'g>(of: &[Expr<'g>], by: Leaf) -> Vec<Expr<'g>> {
    let Some(first) = of.first() else { return Vec::new() };
    let touched = first.graph.touched_by(by);
    let mut known = HashMap::new();
    of.iter().map(|e| derive(*e, by, &touched, &mut known)).collect()
}

fn derive<'g>(of: Expr<'g>, by: Leaf, touched: &[bool], known: &mut HashMap<u32, Expr<'g>>) -> Expr<'g> {
    let graph = of.graph;
    if !touched[of.id as usize] {
        return graph.zero();
    }
    if let Some(done) = known.get(&of.id) {
        return *done;
    }
    let (zero, one) = (graph.zero(), graph.constant(1.0));
    let result = match graph.node_of(of.id) {
        Node::Constant(_) | Node::Quantity(..) => zero,
        Node::Leaf(leaf) if leaf == by => one,
        Node::Leaf(leaf @ Leaf::Delayed { input, late }) => {
            let elapsed = late.drift.is_some_and(|p| by == Leaf::Parameter(p));
            let dimension = graph.leaf_dimension(leaf);
            let dimension = if elapsed { dimension } else { dimension.over(Dimension::TIME) };
            -graph.leaf(Leaf::DelayedRate { input, late, elapsed }, dimension)
        }
        Node::Leaf(_) => zero,
        Node::Unary(op, a) => {
            let a = of.at(a);
            let da = derive(a, by, touched, known);
            if da.is_zero() {
                zero
            } else {
                match op {
                    Unary::Neg => -da,
                    Unary::Abs => a.sign() * da,
                    Unary::Sign | Unary::Step => zero,
                    Unary::Sin => a.cos() * da,
                    Unary::Cos => -(a.sin() * da),
                    Unary::Tan => (of * of + 1.0) * da,
                    Unary::Atan => da / (a * a + 1.0),
                    Unary::Tanh => (one - of * of) * da,
                    Unary::Exp => of * da,
                    Unary::Ln => da / a,
                    Unary::Sqrt => da / (of * 2.0),
                }
            }
        }
        Node::Binary(op, a, b) => {
            let (a, b) = (of.at(a), of.at(b));
            let (da, db) = (derive(a, by, touched, known), derive(b, by, touched, known));
            match op {
                Binary::Add => da + db,
                Binary::Sub => da - db,
                Binary::Mul => da * b + a * db,
                Binary::Div => (da - of * db) / b,
                Binary::Pow if db.is_zero() => b * a.pow(b - 1.0) * da,
                Binary::Pow => of * (db * a.ln() + b * da / a),
                Binary::Min => {
                    let first = (b - a).step();
                    first * da + (one - first) * db
                }
                Binary::Max => {
                    let first = (a - b).step();
                    first * da + (one - first) * db
                }
                Binary::Atan2 => (b * da - a * db) / (a * a + b * b),
            }
        }
    };
    known.insert(of.id, result);
    result
}

#[cfg(test)]
mod tests {
    use super::super::Graph;
    use super::*;
    use crate::symbolic::Lateness;

    /// Central differences with h = 1e-6 are accurate to about 1e-9 for functions of size 1; 1e-7
    /// is a margin of 100.
    #[test]
    fn law_derivatives_agree_with_central_differences() {
        let g = Graph::new();
        let x = g.leaf(Leaf::State(0), Dimension::ONE);
        let y = g.leaf(Leaf::State(1), Dimension::ONE);
        let formulas = [
            x * y.abs(),
            x.sin() * y.cos(),
            x.tan() / y,
            x.tanh() - y.exp() * x,
            (x * x + 1.0).sqrt().ln(),
            x.atan() * y,
            (x * x).pow(y),
            x.pow(g.constant(1.5)),
            x.min(y) + x.max(y * 2.0),
            (x * y).atan2(y),
            (-x).abs() * (x - y).step(),
        ];
        let (x0, y0, h) = (0.7, -0.4, 1e-6);
        let value = |f: Expr<'_>, a: f64, b: f64| f.evaluate(&|leaf| if leaf == Leaf::State(0) { a } else { b });
        for f in formulas {
            for (leaf, dx, dy) in [(Leaf::State(0), h, 0.0), (Leaf::State(1), 0.0, h)] {
                let numeric = (value(f, x0 + dx, y0 + dy) - value(f, x0 - dx, y0 - dy)) / (2.0 * h);
                let exact = value(f.derivative(leaf), x0, y0);
                assert!((numeric - exact).abs() < 1e-7, "{f:?} by {leaf:?}: {exact} against {numeric}");
            }
        }
    }

    #[test]
    fn delay_differentiates_to_the_rate() {
        let g = Graph::new();
        let late = Lateness { constant: Some(5), drift: Some(6) };
        let delayed = g.leaf(Leaf::Delayed { input: 2, late }, Dimension::FORCE);
        let by = |parameter: u16| delayed.derivative(Leaf::Parameter(parameter));
        assert_eq!(by(5).leaves(), [Leaf::DelayedRate { input: 2, late, elapsed: false }]);
        assert_eq!(by(6).leaves(), [Leaf::DelayedRate { input: 2, late, elapsed: true }]);
        assert_eq!(by(6).dimension(), Ok(Dimension::FORCE));
        assert!(by(4).is_zero());
    }
}
