//! Functions of a model with their Jacobians, evaluated at several instants side by side, and the chain rule.
//!
//! ```text
//! f(x, θ, inputs)        ∂f/∂(x₀, θ) = A S + B,   A = ∂f/∂x,  B = ∂f/∂θ,  S = ∂x/∂(x₀, θ)
//! ```
//!
//! A and B are sparse; S and the result are tables with `width` columns, row by row.

use crate::dynamics::{Functions, Source};
use crate::simd::Wide;
use crate::symbolic::{Bound, Ends, Plan, Registers};

/// Columns of S that are summed at a time, so that sums do not wait for each other and an entry of
/// J is read once for all.
const TOGETHER: usize = 4;

/// A row of a Jacobian: index of the plan's value and column of each entry.
#[derive(Debug, Clone, Default)]
struct Row {
    /// ∂f/∂x
    by_state: Vec<(usize, usize)>,
    /// ∂f/∂θ, columns of S
    direct: Vec<(usize, usize)>,
}

/// Registers with the parameters in place.
pub(crate) fn prepared<const L: usize>(functions: &Functions, theta: &[[f64; L]]) -> Registers<L> {
    let mut registers = functions.plan.registers::<L>();
    for (slot, source) in functions.sources.iter().enumerate() {
        if let Source::Parameter(p) = *source {
            functions.plan.set(&mut registers, slot, theta[p]);
        }
    }
    functions.plan.prepare(&mut registers);
    registers
}

/// A set of functions with its registers.
pub(crate) struct Evaluator<'a, const L: usize> {
    plan: &'a Plan,
    registers: Bound<'a, L>,
    rows: Vec<Row>,
    /// Columns of S.
    width: usize,
}

impl<'a, const L: usize> Evaluator<'a, L> {
    /// The evaluator on prepared registers; `width`: columns of S, 0 without sensitivities.
    pub fn new(
        functions: &'a Functions,
        registers: &'a mut Registers<L>,
        states: usize,
        width: usize,
    ) -> Evaluator<'a, L> {
        let mut rows = vec![Row::default(); if width > 0 { functions.count } else { 0 }];
        if width > 0 {
            let by_state = functions.by_state.len();
            for (k, entry) in functions.by_state.iter().enumerate() {
                rows[entry.row].by_state.push((functions.count + k, entry.column));
            }
            for (k, entry) in functions.by_parameter.iter().enumerate() {
                rows[entry.row].direct.push((functions.count + by_state + k, states + entry.column));
            }
        }
        Evaluator { plan: &functions.plan, registers: registers.bind(), rows, width }
    }

    /// The registers of the inputs and results of an evaluation: states and their absolute values,
    /// inputs and parameters, values.
    #[inline(always)]
    pub fn ends(&mut self) -> Ends<'_, L> {
        self.plan.ends(&mut self.registers)
    }

    /// Computes all values for the states, absolute values and inputs that were written.
    #[inline(always)]
    pub fn evaluate<W: Wide<L>>(&mut self, wide: W) {
        self.plan.evaluate_sized(wide, &mut self.registers);
    }

    /// Computes A S + B row by row; `take` gets the index in the table and the value.
    #[inline(always)]
    pub fn chain<W: Wide<L>>(
        &mut self,
        wide: W,
        s: &[[f64; L]],
        direct: &mut [[f64; L]],
        mut take: impl FnMut(usize, W::Value),
    ) {
        let values = self.plan.ends(&mut self.registers).values;
        for (row, to) in self.rows.iter().zip(direct.chunks_exact_mut(self.width.max(1))) {
            row.direct.iter().for_each(|(value, column)| to[*column] = values[*value]);
        }
        for (k, (row, direct)) in self.rows.iter().zip(direct.chunks_exact(self.width.max(1))).enumerate() {
            let mut column = 0;
            while column + TOGETHER <= self.width {
                let sums = columns::<TOGETHER, L, W>(wide, row, values, s, self.width, direct, column);
                for (i, sum) in sums.into_iter().enumerate() {
                    take(k * self.width + column + i, sum);
                }
                column += TOGETHER;
            }
            for column in column..self.width {
                let [sum] = columns::<1, L, W>(wide, row, values, s, self.width, direct, column);
                take(k * self.width + column, sum);
            }
        }
    }
}

/// Σ a S + direct in `K` columns from `first` on.
#[inline(always)]
fn columns<const K: usize, const L: usize, W: Wide<L>>(
    wide: W,
    row: &Row,
    values: &[[f64; L]],
    s: &[[f64; L]],
    width: usize,
    direct: &[[f64; L]],
    first: usize,
) -> [W::Value; K] {
    let mut sums = [wide.splat(0.0); K];
    for k in 0..K {
        sums[k] = wide.load(&direct[first + k]);
    }
    for (value, column) in &row.by_state {
        let a = wide.load(&values[*value]);
        let from = &s[column * width + first..][..K];
        for k in 0..K {
            sums[k] = wide.plus(sums[k], a, wide.load(&from[k]));
        }
    }
    sums
}
