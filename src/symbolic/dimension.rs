//! Dimension of a formula from the dimensions of its leaves: the check of an effect's unit.
//!
//! A constant other than 0 is a pure number and can be added to pure numbers only; 0 has every
//! dimension.

use std::collections::BTreeMap;

use thiserror::Error;

use super::expr::Expr;
use super::graph::{Binary, Node, Unary};
use crate::units::Dimension;

/// The reason why a formula is dimensionally wrong.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum DimensionError {
    /// Two terms that are added or compared have different dimensions.
    #[error("{left} and {right} cannot be added or compared")]
    Mismatch {
        /// Dimension of the first term.
        left: Dimension,
        /// Dimension of the second term.
        right: Dimension,
    },
    /// The argument of a transcendental function is no pure number.
    #[error("argument in {found} where a pure number is needed")]
    Argument {
        /// Dimension of the argument.
        found: Dimension,
    },
    /// A power of something that is no pure number, with an exponent that is not a whole number.
    #[error("a power that is no whole number, of {base}")]
    Power {
        /// Dimension of the base.
        base: Dimension,
    },
}

impl Expr<'_> {
    /// Dimension of the formula.
    ///
    /// # Errors
    /// [`DimensionError`] when terms do not fit together.
    pub fn dimension(self) -> Result<Dimension, DimensionError> {
        Ok(infer(self, &mut BTreeMap::new())?.unwrap_or(Dimension::ONE))
    }
}

/// Dimension of a formula; `None` for the number 0, which has every dimension. Shared parts are
/// computed once (`known`): a chain of actuators reads its force twice at every link.
fn infer(of: Expr<'_>, known: &mut BTreeMap<u32, Option<Dimension>>) -> Result<Option<Dimension>, DimensionError> {
    if let Some(found) = known.get(&of.id) {
        return Ok(*found);
    }
    let found = inferred(of, known)?;
    known.insert(of.id, found);
    Ok(found)
}

fn inferred(of: Expr<'_>, known: &mut BTreeMap<u32, Option<Dimension>>) -> Result<Option<Dimension>, DimensionError> {
    let pure = |found: Option<Dimension>| match found {
        None | Some(Dimension::ONE) => Ok(Some(Dimension::ONE)),
        Some(found) => Err(DimensionError::Argument { found }),
    };
    match of.graph.node_of(of.id) {
        Node::Constant(_) if of.is_zero() => Ok(None),
        Node::Constant(_) => Ok(Some(Dimension::ONE)),
        Node::Quantity(_, dimension) => Ok(Some(dimension)),
        Node::Leaf(leaf) => Ok(Some(of.graph.leaf_dimension(leaf))),
        Node::Unary(op, a) => {
            let a = infer(of.at(a), known)?;
            match op {
                Unary::Neg | Unary::Abs => Ok(a),
                Unary::Sign | Unary::Step => Ok(Some(Dimension::ONE)),
                Unary::Sqrt => match a {
                    Some(d) if d.kg % 2 == 0 && d.m % 2 == 0 && d.s % 2 == 0 => {
                        Ok(Some(Dimension::new(d.kg / 2, d.m / 2, d.s / 2)))
                    }
                    Some(base) => Err(DimensionError::Power { base }),
                    None => Ok(None),
                },
                _ => pure(a),
            }
        }
        Node::Binary(op, a, b) => {
            let (a, b) = (of.at(a), of.at(b));
            let (da, db) = (infer(a, known)?, infer(b, known)?);
            match (op, da, db) {
                (Binary::Mul, None, _) | (Binary::Mul, _, None) => Ok(None),
                (Binary::Mul, Some(x), Some(y)) => Ok(Some(x.times(y))),
                (Binary::Div, x, y) => Ok(x.map(|x| x.over(y.unwrap_or(Dimension::ONE)))),
                (Binary::Pow, None | Some(Dimension::ONE), e) => pure(e),
                (Binary::Pow, Some(base), _) => match b.as_constant() {
                    Some(c) if c.fract() == 0.0 && c.abs() < 16.0 => Ok(Some(base.power(c as i8))),
                    _ => Err(DimensionError::Power { base }),
                },
                (Binary::Atan2, Some(left), Some(right)) if left == right => Ok(Some(Dimension::ONE)),
                (Binary::Atan2, None, _) | (Binary::Atan2, _, None) => Ok(Some(Dimension::ONE)),
                (_, None, other) | (_, other, None) => Ok(other),
                (_, Some(left), Some(right)) if left == right => Ok(Some(left)),
                (_, Some(left), Some(right)) => Err(DimensionError::Mismatch { left, right }),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Graph, Leaf};
    use super::*;

    #[test]
    fn law_drag_is_a_force_and_a_slip_is_seen() {
        let g = Graph::new();
        let u = g.leaf(Leaf::State(0), Dimension::VELOCITY);
        let d = g.leaf(Leaf::Parameter(0), Dimension::new(1, -1, 0));
        assert_eq!((d * u * u.abs()).dimension(), Ok(Dimension::FORCE));
        assert!(matches!((d * u + u).dimension(), Err(DimensionError::Mismatch { .. })));
        assert!(matches!(u.sin().dimension(), Err(DimensionError::Argument { .. })));
        assert_eq!((u / 0.01 * 0.0 + u).dimension(), Ok(Dimension::VELOCITY));
    }

    /// A formula that reads itself twice at each of 200 links would have 2²⁰⁰ paths.
    #[test]
    fn what_is_shared_is_asked_once() {
        let g = Graph::new();
        let u = g.leaf(Leaf::State(0), Dimension::VELOCITY);
        let chain = (0..200).fold(u, |x, k| x + x.sign() * (x.abs() * f64::from(k + 2)));
        assert_eq!(chain.dimension(), Ok(Dimension::VELOCITY));
    }
}
