//! A bollard-pull table, the options of its fit, and the errors.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A bollard-pull table: one row for each steady command. Rows without a command are allowed and
/// have no effect.
#[derive(Debug, Clone, Copy)]
pub struct Bollard<'a> {
    /// Control voltage or normalised command of each row, V or 1.
    pub command: &'a [f64],
    /// Measured force of each row, N; positive for a positive command.
    pub force: &'a [f64],
    /// Supply voltage of each row, V; `None` if it was not logged.
    pub supply: Option<&'a [f64]>,
}

/// Treatment of the dead band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeadBand {
    /// Held at this value (as V); 0 is the paper's curve.
    Given(f64),
    /// Fitted to the table.
    Fitted,
}

/// Options of the fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CurveOptions {
    /// The dead band; none by default, as in the paper.
    pub deadband: DeadBand,
    /// Supply voltage at which a and b hold, V; the median of the table if absent.
    pub reference_supply: Option<f64>,
    /// Greatest |command| of the thruster; a greater one in the table gives the force of this one.
    pub max: Option<f64>,
}

impl Default for CurveOptions {
    fn default() -> CurveOptions {
        CurveOptions { deadband: DeadBand::Given(0.0), reference_supply: None, max: None }
    }
}

/// The reason why no curve can be fitted to a bollard table.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FitError {
    /// Columns have different lengths.
    #[error("a bollard table needs one {column} per command: it has {commands} commands and {values} values")]
    Lengths {
        /// The other column.
        column: &'static str,
        /// Number of commands.
        commands: usize,
        /// Number of its values.
        values: usize,
    },
    /// A cell is not usable.
    #[error("bollard table, row {row} (counted from 1): {column} = {value} must be {expected}")]
    BadCell {
        /// Which row, counted from 1 without the header.
        row: usize,
        /// Which column.
        column: &'static str,
        /// The value.
        value: f64,
        /// The valid values.
        expected: &'static str,
    },
    /// An option is out of its range.
    #[error("{option} = {value}: must be {expected}")]
    BadOption {
        /// Which option.
        option: &'static str,
        /// The given value.
        value: f64,
        /// The valid values.
        expected: &'static str,
    },
    /// One direction has too few rows.
    #[error(
        "{rows} rows with a {direction} command beyond the dead band: two coefficients and their spread need at least 3"
    )]
    TooFewRows {
        /// `forward` or `reverse`.
        direction: &'static str,
        /// How many there are.
        rows: usize,
    },
    /// The commands do not separate a from b, or c or n from them.
    #[error("the {direction} commands do not separate the parameters of the curve: provide more different commands")]
    NotIdentifiable {
        /// `forward`, `reverse` or, with a shape parameter, `forward and reverse`.
        direction: &'static str,
    },
    /// A shape parameter is at the end of the range of the search.
    #[error(
        "the best {parameter} is {value} or beyond, which is impossible for a thruster: check the table's columns and \
         their units"
    )]
    AtEnd {
        /// Which parameter.
        parameter: &'static str,
        /// End of the search, the dead band as V.
        value: f64,
    },
    /// The force has the sign opposite to the command.
    #[error("{direction} thrust opposes the command: reverse the sign of the force or of the command")]
    WrongSign {
        /// `forward` or `reverse`.
        direction: &'static str,
    },
    /// Thrust falls while the command grows.
    #[error("{direction} thrust falls as the command grows (a = {a} ± {a_std}, b = {b} ± {b_std}): {}",
        if *.b < 0.0 { "fit a dead band, or look for an offset of the load cell" } else { "the rows of high command are suspect" })]
    NotMonotone {
        /// `forward` or `reverse`.
        direction: &'static str,
        /// Quadratic coefficient, N/V².
        a: f64,
        /// Its standard deviation.
        a_std: f64,
        /// Linear coefficient, N/V.
        b: f64,
        /// Its standard deviation.
        b_std: f64,
    },
}

/// Checks a table and options.
pub(super) fn check(table: &Bollard<'_>, options: &CurveOptions) -> Result<(), FitError> {
    let commands = table.command.len();
    let columns = [("force", Some(table.force)), ("supply voltage", table.supply)];
    for (column, values) in columns.into_iter().filter_map(|(name, v)| Some((name, v?))) {
        if values.len() != commands {
            return Err(FitError::Lengths { column, commands, values: values.len() });
        }
    }
    for (column, values) in [("command", table.command), ("force", table.force)] {
        if let Some(row) = values.iter().position(|v| !v.is_finite()) {
            return Err(FitError::BadCell { row: row + 1, column, value: values[row], expected: "finite" });
        }
    }
    let volts = |v: f64| v.is_finite() && v > 0.0;
    let expected = "a positive number of volts";
    let supply = table.supply.unwrap_or_default();
    if let Some(row) = supply.iter().position(|v| !volts(*v)) {
        return Err(FitError::BadCell { row: row + 1, column: "supply voltage", value: supply[row], expected });
    }
    match (options.deadband, options.reference_supply) {
        (DeadBand::Given(value), _) if !(value.is_finite() && value >= 0.0) => {
            Err(FitError::BadOption { option: "deadband", value, expected: "a number of at least 0" })
        }
        _ if options.max.is_some_and(|max| !volts(max)) => Err(FitError::BadOption {
            option: "max",
            value: options.max.unwrap_or(f64::NAN),
            expected: "a positive number",
        }),
        (_, Some(value)) if !volts(value) => Err(FitError::BadOption { option: "reference_supply", value, expected }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bad_cell_or_option_is_named() {
        let table = Bollard { command: &[1.0, 2.0], force: &[5.0, f64::NAN], supply: None };
        let message = check(&table, &CurveOptions::default()).unwrap_err().to_string();
        assert_eq!(message, "bollard table, row 2 (counted from 1): force = NaN must be finite");
        let short = Bollard { force: &[5.0], ..table };
        assert!(matches!(check(&short, &CurveOptions::default()), Err(FitError::Lengths { values: 1, .. })));
        let flat = Bollard { force: &[5.0, 6.0], supply: Some(&[12.0, 0.0]), ..table };
        assert!(matches!(check(&flat, &CurveOptions::default()), Err(FitError::BadCell { row: 2, .. })));
        let good = Bollard { force: &[5.0, 6.0], ..table };
        let negative = CurveOptions { deadband: DeadBand::Given(-0.1), ..CurveOptions::default() };
        assert!(matches!(check(&good, &negative), Err(FitError::BadOption { option: "deadband", .. })));
        let dead = CurveOptions { reference_supply: Some(0.0), ..CurveOptions::default() };
        assert!(matches!(check(&good, &dead), Err(FitError::BadOption { option: "reference_supply", .. })));
    }
}
