//! Users' formulas: text with states, commands, channels and time, parsed into the crate's own
//! [`Expr`].
//!
//! ```text
//! wind_speed^2 * cos(wind_dir - psi)        abs(theta) > 0.2 && t < 40
//! ```
//!
//! Operators + − * / ^ (also **), comparisons > < >= <= == !=, && || !, brackets; functions
//! [`FUNCTIONS`]; the constant `pi`. A comparison gives 1 or 0, and any value other than 0 counts
//! as true. A formula is differentiated, compiled and simulated like the formulas of the catalogue.

mod error;
mod syntax;

use std::collections::BTreeSet;

pub use error::FormulaError;
use syntax::{Name, Operator, Syntax};

use crate::nearest::nearest;
use crate::run::{Run, Signal};
use crate::simd::Plain;
use crate::symbolic::{Expr, Graph, Leaf, Plan};
use crate::units::Dimension;

/// Functions that a formula may call.
pub const FUNCTIONS: [&str; 13] =
    ["abs", "sign", "sin", "cos", "tan", "atan", "tanh", "exp", "ln", "log", "sqrt", "min", "max"];

/// A parsed formula with known functions; [`Formula::check`] checks its names.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    text: String,
    syntax: Syntax,
    names: Vec<Name>,
}

impl Formula {
    /// Parses a formula.
    ///
    /// # Errors
    /// [`FormulaError`] with the column of the error.
    pub fn parse(text: &str) -> Result<Formula, FormulaError> {
        let mut formula = Formula { text: text.to_string(), syntax: syntax::parse(text)?, names: Vec::new() };
        formula.names = formula.resolve(&formula.syntax)?;
        Ok(formula)
    }

    /// The text as it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Names of the states, commands and channels that it reads, each once; `t` is the time.
    pub fn names(&self) -> BTreeSet<&str> {
        self.names.iter().map(|n| n.text.as_str()).collect()
    }

    /// Whether it contains a number that is no exponent: such a number may have a unit, as the
    /// lever arm in `0.3*q`.
    pub fn has_numbers(&self) -> bool {
        has_numbers(&self.syntax)
    }

    /// Refuses names that are not in `known`.
    ///
    /// # Errors
    /// [`FormulaError::UnknownName`] with its column and the nearest known name.
    pub fn check<'a>(&self, known: impl IntoIterator<Item = &'a str> + Clone) -> Result<(), FormulaError> {
        let strange = self.names.iter().find(|n| !known.clone().into_iter().any(|k| k == n.text));
        strange.map_or(Ok(()), |name| Err(self.unknown(name, "channel", known)))
    }

    fn unknown<'a>(&self, name: &Name, kind: &'static str, known: impl IntoIterator<Item = &'a str>) -> FormulaError {
        FormulaError::UnknownName {
            formula: self.text.clone(),
            column: self.column(name),
            name: name.text.clone(),
            kind,
            nearest: nearest(&name.text, known).map(str::to_string),
        }
    }

    fn column(&self, name: &Name) -> usize {
        self.text[..name.at].chars().count() + 1
    }

    /// Checks functions and their arguments; returns the names that the formula reads.
    fn resolve(&self, syntax: &Syntax) -> Result<Vec<Name>, FormulaError> {
        let all = |parts: &[&Syntax]| -> Result<Vec<Name>, FormulaError> {
            let lists: Result<Vec<_>, _> = parts.iter().map(|part| self.resolve(part)).collect();
            Ok(lists?.concat())
        };
        match syntax {
            Syntax::Number(_) => Ok(Vec::new()),
            Syntax::Name(name) if name.text == "pi" => Ok(Vec::new()),
            Syntax::Name(name) => Ok(vec![name.clone()]),
            Syntax::Minus(a) | Syntax::Not(a) => self.resolve(a),
            Syntax::Binary(_, a, b) => all(&[a.as_ref(), b.as_ref()]),
            Syntax::Call(name, arguments) => {
                if !FUNCTIONS.contains(&name.text.as_str()) {
                    return Err(self.unknown(name, "function", FUNCTIONS));
                }
                let takes = if matches!(name.text.as_str(), "min" | "max") { 2 } else { 1 };
                if arguments.len() != takes {
                    let (formula, column) = (self.text.clone(), self.column(name));
                    let found = arguments.len();
                    return Err(FormulaError::Arguments { formula, column, name: name.text.clone(), takes, found });
                }
                all(&arguments.iter().collect::<Vec<_>>())
            }
        }
    }

    /// The formula as an [`Expr`] of `graph`; `read` gives the expression for each of its names.
    pub fn lower<'g>(&self, graph: &'g Graph, read: &dyn Fn(&str) -> Expr<'g>) -> Expr<'g> {
        lower(&self.syntax, graph, read)
    }

    /// Values of the formula at the instants `time` (s) of a run; channels are linear between
    /// samples and constant outside them. A condition gives 1 where it is true.
    ///
    /// # Errors
    /// [`FormulaError::UnknownName`] for a channel that the run does not have.
    pub fn over(&self, run: &Run, time: &[f64]) -> Result<Vec<f64>, FormulaError> {
        let known = || run.signals.iter().filter(|(_, s)| !s.is_empty()).map(|(name, _)| name.as_str());
        self.check(known().chain(["t"]).collect::<Vec<_>>())?;
        let names: Vec<&str> = self.names().into_iter().collect();
        let graph = Graph::new();
        let index = |name: &str| names.iter().position(|n| *n == name).unwrap_or_default() as u16;
        let plan = Plan::compile(&[self.lower(&graph, &|name| graph.leaf(Leaf::Input(index(name)), Dimension::ONE))]);
        let columns: Vec<(usize, Vec<f64>)> = names
            .iter()
            .filter_map(|name| {
                let slot = plan.slot(Leaf::Input(index(name)))?;
                Some((slot, run.signal(name).map_or_else(|| time.to_vec(), |signal| between(signal, time))))
            })
            .collect();
        const LANES: usize = 8;
        let mut registers = plan.registers::<LANES>();
        plan.prepare(&mut registers);
        let mut values = Vec::with_capacity(time.len());
        for first in (0..time.len()).step_by(LANES) {
            let row = |lane: usize| (first + lane).min(time.len() - 1);
            for (slot, column) in &columns {
                plan.set(&mut registers, *slot, std::array::from_fn(|lane| column[row(lane)]));
            }
            plan.evaluate(Plain, &mut registers);
            values.extend_from_slice(&plan.output(&registers, 0)[..LANES.min(time.len() - first)]);
        }
        Ok(values)
    }
}

fn has_numbers(syntax: &Syntax) -> bool {
    match syntax {
        Syntax::Number(_) => true,
        Syntax::Name(_) => false,
        Syntax::Binary(Operator::Power, base, exponent) => {
            has_numbers(base) || !matches!(**exponent, Syntax::Number(_)) && has_numbers(exponent)
        }
        Syntax::Minus(a) | Syntax::Not(a) => has_numbers(a),
        Syntax::Binary(_, a, b) => has_numbers(a) || has_numbers(b),
        Syntax::Call(_, arguments) => arguments.iter().any(has_numbers),
    }
}

/// A signal at the instants `time`, linear between its samples.
fn between(signal: &Signal, time: &[f64]) -> Vec<f64> {
    let (stamps, x) = (signal.time(), signal.values());
    time.iter()
        .map(|t| match stamps.partition_point(|s| s <= t) {
            0 => x[0],
            k if k == stamps.len() => x[k - 1],
            k => x[k - 1] + (x[k] - x[k - 1]) * (t - stamps[k - 1]) / (stamps[k] - stamps[k - 1]),
        })
        .collect()
}

fn lower<'g>(syntax: &Syntax, graph: &'g Graph, read: &dyn Fn(&str) -> Expr<'g>) -> Expr<'g> {
    let one = graph.constant(1.0);
    let truth = |x: Expr<'g>| x.sign().abs();
    let of = |part: &Syntax| lower(part, graph, read);
    match syntax {
        Syntax::Number(value) => graph.constant(*value),
        Syntax::Name(name) if name.text == "pi" => graph.constant(std::f64::consts::PI),
        Syntax::Name(name) => read(&name.text),
        Syntax::Minus(a) => -of(a),
        Syntax::Not(a) => one - truth(of(a)),
        Syntax::Binary(operator, a, b) => {
            let (a, b) = (of(a), of(b));
            match operator {
                Operator::Or => truth(a).max(truth(b)),
                Operator::And => truth(a) * truth(b),
                Operator::Greater => (a - b).step(),
                Operator::Less => (b - a).step(),
                Operator::GreaterEqual => one - (b - a).step(),
                Operator::LessEqual => one - (a - b).step(),
                Operator::Equal => one - truth(a - b),
                Operator::Unequal => truth(a - b),
                Operator::Add => a + b,
                Operator::Subtract => a - b,
                Operator::Multiply => a * b,
                Operator::Divide => a / b,
                Operator::Power => a.pow(b),
            }
        }
        Syntax::Call(name, arguments) => {
            let x = of(&arguments[0]);
            match (name.text.as_str(), arguments.get(1)) {
                ("min", Some(y)) => x.min(of(y)),
                ("max", Some(y)) => x.max(of(y)),
                ("abs", _) => x.abs(),
                ("sign", _) => x.sign(),
                ("sin", _) => x.sin(),
                ("cos", _) => x.cos(),
                ("tan", _) => x.tan(),
                ("atan", _) => x.atan(),
                ("tanh", _) => x.tanh(),
                ("exp", _) => x.exp(),
                ("sqrt", _) => x.sqrt(),
                // the remaining FUNCTIONS: ln and log, both natural
                _ => x.ln(),
            }
        }
    }
}

#[cfg(test)]
mod tests;
