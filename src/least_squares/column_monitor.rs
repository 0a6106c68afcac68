//! Monitor of columns while their rows are folded: which are constant, and which are the same up to
//! a factor.
//!
//! Most columns differ in their first rows, after which the monitor costs nothing.

use super::system::{LeastSquaresError, Names};

/// Relation of two columns in the rows so far.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Pair {
    /// Both are zero so far.
    Open,
    /// The second is this many times the first.
    Factor(f64),
    /// They differ.
    Apart,
}

/// Rounding of one product and one quotient.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

impl Pair {
    fn after(self, a: &[f64], b: &[f64]) -> Pair {
        let mut pair = self;
        for (a, b) in a.iter().zip(b) {
            pair = match pair {
                Pair::Apart => return Pair::Apart,
                Pair::Open if *a == 0.0 && *b == 0.0 => Pair::Open,
                Pair::Open if *a == 0.0 || *b == 0.0 || !(b / a).is_finite() || b / a == 0.0 => Pair::Apart,
                Pair::Open => Pair::Factor(b / a),
                Pair::Factor(f) if (f * a - b).abs() <= ROUNDING * b.abs() => pair,
                Pair::Factor(_) => Pair::Apart,
            };
        }
        pair
    }

    fn and(self, other: Pair) -> Pair {
        match (self, other) {
            (Pair::Open, pair) | (pair, Pair::Open) => pair,
            (Pair::Factor(f), Pair::Factor(g)) if (f - g).abs() <= ROUNDING * f.abs() => self,
            _ => Pair::Apart,
        }
    }
}

/// Columns of a system, the right-hand side last.
#[derive(Debug, Clone)]
pub(super) struct ColumnMonitor {
    /// The value of each column that is constant so far; `None` before the first row.
    constant: Vec<Option<f64>>,
    varies: Vec<bool>,
    /// Of the columns j and i < j, at j (j − 1)/2 + i.
    pairs: Vec<Pair>,
}

impl ColumnMonitor {
    /// For `width` columns, the right-hand side among them.
    pub fn new(width: usize) -> ColumnMonitor {
        let p = width - 1;
        ColumnMonitor {
            constant: vec![None; width],
            varies: vec![false; width],
            pairs: vec![Pair::Open; p * p.saturating_sub(1) / 2],
        }
    }

    /// Takes the next rows into account.
    pub fn look(&mut self, columns: &[&[f64]]) {
        for (j, column) in columns.iter().enumerate().filter(|(_, c)| !c.is_empty()) {
            if !self.varies[j] {
                let value = *self.constant[j].get_or_insert(column[0]);
                self.varies[j] = column.iter().any(|x| x.to_bits() != value.to_bits());
            }
        }
        for j in 1..columns.len() - 1 {
            for i in 0..j {
                let pair = &mut self.pairs[j * (j - 1) / 2 + i];
                *pair = pair.after(columns[i], columns[j]);
            }
        }
    }

    /// The same columns at other indices of `width`. Relations of pairs are dropped, and new
    /// columns do not count as constant.
    pub fn placed(&self, places: &[usize], width: usize) -> ColumnMonitor {
        let mut placed = ColumnMonitor::new(width);
        placed.pairs.fill(Pair::Apart);
        placed.varies.fill(true);
        for (j, place) in places.iter().enumerate() {
            placed.constant[*place] = self.constant[j];
            placed.varies[*place] = self.varies[j];
        }
        placed
    }

    /// The state of the columns `kept`, with a right-hand side of which nothing is known.
    pub fn kept(&self, kept: &[usize]) -> ColumnMonitor {
        let mut left = ColumnMonitor::new(kept.len() + 1);
        left.varies.fill(true);
        for (k, j) in kept.iter().enumerate() {
            (left.constant[k], left.varies[k]) = (self.constant[*j], self.varies[*j]);
            for (m, i) in kept[..k].iter().enumerate() {
                left.pairs[k * k.saturating_sub(1) / 2 + m] = self.pairs[j * (j - 1) / 2 + i];
            }
        }
        left
    }

    /// Merges the state of another monitor, of further rows.
    pub fn merge(&mut self, other: &ColumnMonitor) {
        for j in 0..self.varies.len() {
            let same = match (self.constant[j], other.constant[j]) {
                (Some(a), Some(b)) => a.to_bits() == b.to_bits(),
                _ => true,
            };
            self.varies[j] |= other.varies[j] || !same;
            self.constant[j] = self.constant[j].or(other.constant[j]);
        }
        for (pair, other) in self.pairs.iter_mut().zip(&other.pairs) {
            *pair = pair.and(*other);
        }
    }

    /// The value of column `j` if it is the same in all rows.
    pub fn constant(&self, j: usize) -> Option<f64> {
        self.constant[j].filter(|_| !self.varies[j])
    }

    /// Returns an error if a column is zero or two columns are the same up to a factor.
    pub fn judge(&self, names: &Names) -> Result<(), LeastSquaresError> {
        let p = self.varies.len() - 1;
        if let Some(j) = (0..p).find(|j| self.constant(*j) == Some(0.0)) {
            return Err(LeastSquaresError::ZeroColumn { column: names.column(j) });
        }
        for j in 1..p {
            for i in 0..j {
                if matches!(self.pairs[j * (j - 1) / 2 + i], Pair::Factor(_)) {
                    let (first, second) = (names.column(i), names.column(j));
                    let constant = self.constant(i).is_some();
                    return Err(LeastSquaresError::Proportional { first, second, constant });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_the_same_in_all_parts_is_told() {
        let names = Names::default();
        let (a, b, y) = ([0.0, 1.0, 2.0], [0.0, 3.0, 6.0], [1.0, 2.0, 1.0]);
        let mut whole = ColumnMonitor::new(3);
        whole.look(&[&a, &b, &y]);
        let mut other = ColumnMonitor::new(3);
        other.look(&[&[5.0], &[15.0], &[1.0]]);
        whole.merge(&other);
        assert!(matches!(whole.judge(&names), Err(LeastSquaresError::Proportional { constant: false, .. })));
        other.look(&[&[5.0], &[14.0], &[1.0]]);
        whole.merge(&other);
        assert_eq!(whole.judge(&names), Ok(()));
    }

    #[test]
    fn constants_differ_between_parts() {
        let part = |value: f64| {
            let mut watch = ColumnMonitor::new(2);
            watch.look(&[&[value, value], &[1.0, 2.0]]);
            watch
        };
        let mut whole = part(7.0);
        assert_eq!(whole.constant(0), Some(7.0));
        whole.merge(&part(7.0));
        assert_eq!(whole.constant(0), Some(7.0));
        whole.merge(&part(8.0));
        assert_eq!(whole.constant(0), None);
        assert!(matches!(part(0.0).judge(&Names::default()), Err(LeastSquaresError::ZeroColumn { .. })));
    }
}
