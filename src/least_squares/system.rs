//! Checks of a linear system H θ = y before it is solved, and the names for its messages.

use thiserror::Error;

/// The reason why a linear system has no reliable least-squares solution.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LeastSquaresError {
    /// There is no unknown.
    #[error("there is no column: nothing to estimate")]
    NoColumns,
    /// Columns must be as long as the right-hand side.
    #[error("column `{column}` has {found} rows, the right-hand side has {expected}")]
    Length {
        /// Name of the column.
        column: String,
        /// Its rows.
        found: usize,
        /// Rows of the right-hand side.
        expected: usize,
    },
    /// The number of columns of a block differs from that of earlier blocks, or a flat array does
    /// not split into rows.
    #[error("{found} values do not make rows of {expected} columns")]
    Width {
        /// Columns, or values of a flat array.
        found: usize,
        /// Columns that are expected.
        expected: usize,
    },
    /// The residual's standard deviation (15) needs more rows than unknowns.
    #[error("{rows} rows for the {} unknowns {}: at least {} rows are needed", columns.len(), quoted(columns), columns.len() + 1)]
    TooFewRows {
        /// Rows.
        rows: usize,
        /// Names of the columns.
        columns: Vec<String>,
    },
    /// A bootstrap needs blocks to draw from.
    #[error("{rows} rows make fewer than two blocks of {length} rows: take shorter blocks")]
    TooFewBlocks {
        /// Rows.
        rows: usize,
        /// Rows of a block.
        length: usize,
    },
    /// A value is NaN or infinite.
    #[error("column `{column}`, row {row} (from 0): {value} is not a finite number")]
    NotFinite {
        /// Name of the column, or of the right-hand side.
        column: String,
        /// Row, from 0.
        row: usize,
        /// The value.
        value: f64,
    },
    /// A column holds nothing but zeros.
    #[error("column `{column}` is zero in every row: its coefficient could be anything; leave it out or excite it")]
    ZeroColumn {
        /// Name of the column.
        column: String,
    },
    /// Two columns are the same up to a factor; two constant columns are the common case.
    #[error("columns `{first}` and `{second}` are {}the same up to a factor: leave one out", if *constant { "both constant, " } else { "" })]
    Proportional {
        /// Name of the first column.
        first: String,
        /// Name of the second column.
        second: String,
        /// Whether both are constant.
        constant: bool,
    },
    /// A column is a combination of others, to rounding.
    #[error("column `{column}` is a combination of {} (rank {rank}): this data cannot tell them apart", quoted(others))]
    Dependent {
        /// Name of the column.
        column: String,
        /// Names of the columns it is made of.
        others: Vec<String>,
        /// Rank of H.
        rank: usize,
    },
    /// The right-hand side does not vary: there is nothing to explain, and R² is 0/0.
    #[error("`{column}` {}: there is nothing to explain", if *zero { "is zero in every row" } else { "is constant, as a column is" })]
    NoVariance {
        /// Name of the right-hand side.
        column: String,
        /// Whether it is zero (else constant beside a constant column).
        zero: bool,
    },
    /// A coefficient is outside the range of a double.
    #[error(
        "the coefficient of `{column}` lies beyond the range of a double: bring the column nearer to the others' scale"
    )]
    OutOfRange {
        /// Name of the column.
        column: String,
    },
}

fn quoted(names: &[String]) -> String {
    names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
}

/// Names of columns and right-hand side, for messages.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Names {
    /// Names of the columns; those that are missing are called `column 0`, `column 1`, …
    pub columns: Vec<String>,
    /// Name of the right-hand side; `y` when absent.
    pub response: Option<String>,
}

impl Names {
    /// Name of column `j`.
    pub fn column(&self, j: usize) -> String {
        self.columns.get(j).cloned().unwrap_or_else(|| format!("column {j}"))
    }

    /// Names of the first `p` columns.
    pub fn all(&self, p: usize) -> Vec<String> {
        (0..p).map(|j| self.column(j)).collect()
    }

    /// Name of the right-hand side.
    pub fn response(&self) -> String {
        self.response.clone().unwrap_or_else(|| "y".into())
    }
}

/// Checks the shapes: there are columns, all as long as `y`, and enough rows.
pub(super) fn check_shape(h: &[&[f64]], y: &[f64], names: &Names) -> Result<(), LeastSquaresError> {
    if h.is_empty() {
        return Err(LeastSquaresError::NoColumns);
    }
    if let Some(j) = h.iter().position(|c| c.len() != y.len()) {
        let (found, expected) = (h[j].len(), y.len());
        return Err(LeastSquaresError::Length { column: names.column(j), found, expected });
    }
    if y.len() <= h.len() {
        return Err(LeastSquaresError::TooFewRows { rows: y.len(), columns: names.all(h.len()) });
    }
    Ok(())
}

/// Checks the values: all are finite, and no column is zero.
pub(super) fn check_values(h: &[&[f64]], y: &[f64], names: &Names) -> Result<(), LeastSquaresError> {
    for (j, column) in h.iter().copied().chain([y]).enumerate() {
        check_finite(column, 0, || if j == h.len() { names.response() } else { names.column(j) })?;
    }
    match h.iter().position(|c| c.iter().all(|x| *x == 0.0)) {
        Some(j) => Err(LeastSquaresError::ZeroColumn { column: names.column(j) }),
        None => Ok(()),
    }
}

/// The first value of `x` that is not finite, as an error; `from` is added to its row.
pub(super) fn check_finite(x: &[f64], from: usize, name: impl Fn() -> String) -> Result<(), LeastSquaresError> {
    match x.iter().position(|x| !x.is_finite()) {
        Some(row) => Err(LeastSquaresError::NotFinite { column: name(), row: from + row, value: x[row] }),
        None => Ok(()),
    }
}

/// Checks that no two columns are the same up to a factor. Columns that differ in an early row cost
/// almost nothing.
pub(super) fn check_apart(h: &[&[f64]], names: &Names) -> Result<(), LeastSquaresError> {
    for j in 0..h.len() {
        for i in 0..j {
            if proportional(h[i], h[j]) {
                let (first, second) = (names.column(i), names.column(j));
                return Err(LeastSquaresError::Proportional { first, second, constant: is_constant(h[i]) });
            }
        }
    }
    Ok(())
}

/// Whether all values are the same; true without rows.
pub(super) fn is_constant(x: &[f64]) -> bool {
    x.iter().all(|value| value.to_bits() == x[0].to_bits())
}

/// Whether b is a multiple of a, to the rounding of one product.
fn proportional(a: &[f64], b: &[f64]) -> bool {
    let Some(k) = a.iter().position(|x| *x != 0.0) else { return false };
    let factor = b[k] / a[k];
    let same = |(a, b): (&f64, &f64)| (factor * a - b).abs() <= 2.0 * f64::EPSILON * b.abs();
    factor != 0.0 && factor.is_finite() && a.iter().zip(b).all(same)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_columns() {
        let names = Names { columns: vec!["u".into(), "u|u|".into()], response: Some("tau_u".into()) };
        let (a, b) = ([1.0, 2.0, 3.0], [3.0, 6.0, 9.0]);
        let text = check_apart(&[&a, &b], &names).unwrap_err().to_string();
        assert_eq!(text, "columns `u` and `u|u|` are the same up to a factor: leave one out");
        let text = check_apart(&[&[1.0; 3], &[5.0; 3]], &names).unwrap_err().to_string();
        assert_eq!(text, "columns `u` and `u|u|` are both constant, the same up to a factor: leave one out");
        let text = check_shape(&[&a[..2], &b[..2]], &a[..2], &names).unwrap_err().to_string();
        assert_eq!(text, "2 rows for the 2 unknowns `u`, `u|u|`: at least 3 rows are needed");
        let text = check_values(&[&a, &b], &[0.0, f64::NAN, 1.0], &names).unwrap_err().to_string();
        assert_eq!(text, "column `tau_u`, row 1 (from 0): NaN is not a finite number");
        assert!(check_apart(&[&a, &[3.0, 6.0, 9.1]], &names).is_ok());
    }
}
