//! Formulas as data: the physics is written once and used in several ways.
//!
//! An effect writes its formula with ordinary operators on [`Expr`]. The result is a node of a
//! [`Graph`]: it can be differentiated ([`Expr::derivative`]), checked for its unit
//! ([`Expr::dimension`]) and compiled with others into a flat [`Plan`] that evaluates many instants
//! side by side. The regressor, the simulator, its sensitivities and the discovery use the same
//! formula.

mod body;
mod compile;
mod dense;
mod derivative;
mod dimension;
mod expr;
mod graph;
mod plan;
mod products;
mod sorted;

pub use dense::{Dense, Driven};
pub use derivative::derivatives;
pub use dimension::DimensionError;
pub use expr::Expr;
pub use graph::{Graph, Lateness, Leaf};
pub use plan::{Bound, Ends, Plan, Registers};
