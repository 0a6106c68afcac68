//! Running integrals of a balance over any instants, and the rows made from them.
//!
//! ```text
//! cⱼₖ = Δ(∂π/∂θⱼ) − Σ ½ (fⱼ + fⱼ') Δt
//! ```

use super::nodes::Span;
use super::regressor::{Columns, LANES};

/// Running integrals from the beginning of a row to the instant reached; index 0 is the known part.
pub(super) struct Sums {
    span: Span,
    begin: Option<f64>,
    time: f64,
    /// Number of intervals of the own sensor since the beginning.
    intervals: usize,
    momentum_at_begin: Vec<f64>,
    momentum: Vec<f64>,
    force: Vec<f64>,
    integral: Vec<f64>,
}

impl Sums {
    pub fn new(width: usize, span: Span) -> Sums {
        let zero = || vec![0.0; width];
        Sums {
            span,
            begin: None,
            time: 0.0,
            intervals: 0,
            momentum_at_begin: zero(),
            momentum: zero(),
            force: zero(),
            integral: zero(),
        }
    }

    /// Integrates up to the instant `t`; `outputs` are those just before it, in lane `lane`.
    pub fn arrive(&mut self, t: f64, lane: usize, outputs: &[[f64; LANES]]) {
        let width = self.integral.len();
        for j in 0..width {
            self.momentum[j] = outputs[j][lane];
            let force = outputs[width + j][lane];
            self.integral[j] += 0.5 * (self.force[j] + force) * (t - self.time);
        }
        self.time = t;
        if self.begin.is_none() {
            self.begin_row();
        }
    }

    /// Sets the force to that just after the instant.
    pub fn leave(&mut self, lane: usize, outputs: &[[f64; LANES]]) {
        let width = self.integral.len();
        for j in 0..width {
            self.force[j] = outputs[width + j][lane];
        }
    }

    fn begin_row(&mut self) {
        self.begin = Some(self.time);
        self.intervals = 0;
        self.momentum_at_begin.copy_from_slice(&self.momentum);
        self.integral.fill(0.0);
    }

    /// Writes a row if it is complete; called at a sample of the own sensor.
    pub fn close(&mut self, places: &[usize], columns: &mut Columns) {
        let Some(begin) = self.begin.filter(|begin| *begin < self.time) else { return };
        self.intervals += 1;
        match self.span {
            Span::FromStart => self.write(begin, places, columns),
            Span::Samples(n) if self.intervals >= n => {
                self.write(begin, places, columns);
                self.begin_row();
            }
            Span::Samples(_) => {}
        }
    }

    /// Writes the rest of a longer window as a row; called at the end of a stretch.
    pub fn finish(&mut self, places: &[usize], columns: &mut Columns) {
        if let (Span::Samples(_), Some(begin)) = (self.span, self.begin)
            && self.intervals > 0
        {
            self.write(begin, places, columns);
        }
    }

    fn write(&self, begin: f64, places: &[usize], columns: &mut Columns) {
        let value = |j: usize| self.momentum[j] - self.momentum_at_begin[j] - self.integral[j];
        columns.rhs.push(-value(0));
        columns.span.push((begin, self.time));
        let rows = columns.rhs.len();
        for (j, place) in places.iter().enumerate() {
            let column = &mut columns.columns[*place];
            column.resize(rows - 1, 0.0);
            column.push(value(j + 1));
        }
    }
}
