//! The heading of every file, and the findings about parts of the model that it does not contain.

use super::body::{Parts, coriolis};
use super::coefficients::{Coefficients, Matrix, Tensor};
use super::number::{number, numbers};
use super::{Export, Source, Target, codes};
use crate::effects::Family;
use crate::finding::Finding;
use crate::frame::Dof;

/// A coefficient that a target may or may not contain: row, first and second velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cell {
    /// Constant force.
    Constant(usize),
    /// Force proportional to a velocity.
    Linear(usize, usize),
    /// Force proportional to ν_j |ν_k|.
    Absolute(usize, usize, usize),
    /// Force proportional to ν_j ν_k.
    Product(usize, usize, usize),
    /// Added mass.
    Added(usize, usize),
}

impl Cell {
    /// SNAME's name: `X_u|u|`.
    fn name(self) -> String {
        let [row, velocity] = [Dof::sname as fn(Dof) -> &'static str, Dof::velocity as fn(Dof) -> &'static str];
        let (r, v) = (|i: usize| row(Dof::ALL[i]), |i: usize| velocity(Dof::ALL[i]));
        match self {
            Cell::Constant(i) => format!("{}_0", r(i)),
            Cell::Linear(i, j) => format!("{}_{}", r(i), v(j)),
            Cell::Absolute(i, j, k) => format!("{}_{}|{}|", r(i), v(j), v(k)),
            Cell::Product(i, j, k) => format!("{}_{}{}", r(i), v(j), v(k)),
            Cell::Added(i, j) => format!("{}_{}dot", r(i), v(j)),
        }
    }
}

/// `text` on one line. Control characters, line separators and marks of text direction become
/// blanks: no name can then end a comment or a string of the file, or show its code in an order
/// other than the one in which it runs (compilers refuse such marks: gcc's `-Wbidi-chars`).
pub(super) fn one_line(text: &str) -> String {
    let breaks = |c: char| {
        c.is_control()
            || matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    text.chars().map(|c| if breaks(c) { ' ' } else { c }).collect()
}

/// Limits of a file: where its equations are valid, and with which steps they may be integrated.
pub(super) struct Bounds<'a> {
    /// What the target does not model or cannot be used for.
    pub limits: &'a str,
    /// The longest stable step, or the motions that grow.
    pub stability: &'a str,
}

impl Bounds<'_> {
    /// The lines of the heading.
    pub fn lines(&self) -> [String; 2] {
        [format!("Limits: {}", self.limits), format!("Stability: {}", self.stability)]
    }
}

/// A file under construction: its findings and losses.
pub(super) struct Draft {
    pub target: Target,
    pub lost: Vec<String>,
    pub warnings: Vec<Finding>,
}

impl Draft {
    pub fn new(target: Target) -> Draft {
        Draft { target, lost: Vec::new(), warnings: Vec::new() }
    }

    /// Adds findings for the terms that have no coefficients.
    pub fn left_out(&mut self, found: &Coefficients) {
        for left in &found.left_out {
            let text = format!("`{}` is not in the file: {}", left.term, left.reason);
            match left.family {
                Family::Environment | Family::Sensor => self.warnings.push(Finding::new(&codes::NOT_VEHICLE, text)),
                Family::Body | Family::Actuator => {
                    self.lost.push(left.term.clone());
                    self.warnings.push(Finding::new(&codes::EFFECT_LOST, text));
                }
            }
        }
    }

    /// Adds findings for the coefficients that the target does not contain.
    pub fn missing(&mut self, found: &Coefficients, rest: &Tensor, added: &Matrix, holds: &dyn Fn(Cell) -> bool) {
        let mut cells: Vec<(Cell, f64)> = Vec::new();
        for i in 0..6 {
            cells.push((Cell::Constant(i), found.constant[i]));
            for j in 0..6 {
                cells.push((Cell::Linear(i, j), found.linear[i][j]));
                cells.push((Cell::Added(i, j), -added[i][j]));
                for k in 0..6 {
                    cells.push((Cell::Absolute(i, j, k), found.absolute[i][j][k]));
                    cells.push((Cell::Product(i, j, k), rest[i][j][k]));
                }
            }
        }
        for (cell, value) in cells.into_iter().filter(|(cell, value)| *value != 0.0 && !holds(*cell)) {
            let name = cell.name();
            let text =
                format!("{name} = {} is not in the file: `{}` cannot represent it", number(value), self.target.name());
            self.lost.push(name);
            self.warnings.push(Finding::new(&codes::COEFFICIENT_LOST, text));
        }
    }

    /// Adds a finding for the degrees of freedom that the target has and the model does not.
    pub fn not_modelled(&mut self, found: &Coefficients) {
        let others: Vec<&str> = Dof::ALL.iter().filter(|d| !found.dofs.contains(d)).map(|d| d.name()).collect();
        if !others.is_empty() {
            let text = format!(
                "{} are not in the model: the target moves there without added mass and damping",
                others.join(", ")
            );
            self.warnings.push(Finding::new(&codes::NOT_MODELLED, text));
        }
    }

    /// Adds a finding where products in the file correct the target's own Coriolis forces.
    pub fn cancelled(&mut self, found: &Coefficients, rest: &Tensor) {
        let implied = coriolis(&found.inertia);
        let differs = |i: usize| (0..6).any(|j| (0..6).any(|k| rest[i][j][k] != 0.0 && implied[i][j][k] != 0.0));
        let rows: Vec<&str> = found.dofs.iter().filter(|d| differs(d.index())).map(|d| d.name()).collect();
        if !rows.is_empty() {
            let text = format!(
                "{}: the model's Coriolis terms are not those of its inertia; the products in the file compensate for \
                 the difference",
                rows.join(", ")
            );
            self.warnings.push(Finding::new(&codes::CANCELLED, text));
        }
    }

    /// Adds a finding for moments of inertia that no rigid body has.
    pub fn body(&mut self, parts: &Parts) {
        let [a, b, c, ..] = parts.body.central();
        if a + b < c || a + c < b || b + c < a || a.min(b).min(c) <= 0.0 {
            let text = format!(
                "no rigid body can have the moments of inertia {} kg*m2 about its centre of gravity: give others with \
                 --inertia",
                numbers(&[a, b, c], ", ")
            );
            self.warnings.push(Finding::new(&codes::TRIANGLE, text));
        }
    }

    /// The first lines of every file: source, target, signs, axes, range, limits and stability,
    /// losses.
    pub fn head(&self, source: &Source<'_>, conventions: &[&str], bounds: &Bounds<'_>) -> Vec<String> {
        let file = source.file;
        let name = if file.vehicle.name.is_empty() { "a vehicle" } else { &file.vehicle.name };
        let mut lines = vec![
            format!("{name}: written by hydrosysid {} from {}", env!("CARGO_PKG_VERSION"), source.path.display()),
            format!("(model of hydrosysid {}, estimator {})", file.hydrosysid, file.estimator.name()),
            format!("Target: {} ({})", self.target.name(), self.target.version()),
        ];
        if !file.converged {
            lines.push("DO NOT USE THESE NUMBERS: they come from a fit that did not converge".into());
        }
        lines.extend(conventions.iter().map(|line| (*line).to_string()));
        if !file.envelope.is_empty() {
            let range = |(channel, [low, high]): (&String, &[f64; 2])| {
                let digits = |x: f64| number((x * 1e3).round() / 1e3);
                format!("{channel} {} to {}", digits(*low), digits(*high))
            };
            let ranges: Vec<String> = file.envelope.iter().map(range).collect();
            lines.push(format!("Fitted between (SI units): {}", ranges.join(", ")));
        }
        lines.extend(bounds.lines());
        lines.extend(source.losses.told());
        lines.push(match self.lost.is_empty() {
            true => "Nothing of the model is lost here".into(),
            false => format!("LOST, this file moves differently from the model: {}", self.lost.join(", ")),
        });
        lines.iter().map(|line| one_line(line)).collect()
    }

    pub fn finish(self, bytes: Vec<u8>) -> Export {
        Export {
            format: 1,
            target: self.target,
            version: self.target.version(),
            lost: self.lost,
            warnings: self.warnings,
            bytes,
        }
    }
}
