//! Thruster curves from the bollard tables that a campaign names.
//!
//! ```text
//! bollard = "t200.csv"   →   rows where this thruster alone is driven
//!                        →   equation (1), each direction by itself
//! ```
//!
//! The force is that along the thruster's axis (`force`), or that of a load cell in body axes
//! divided by the component of the axis in its direction. Thrusters with the same rows share one
//! curve, and its error.

use std::path::PathBuf;

use serde::Serialize;

use super::codes;
use super::error::Error;
use super::file::CampaignFile;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::log;
use crate::run::{Run, Signal, thruster_command, thruster_of};
use crate::thrust::bollard::{Bollard, CurveOptions, DeadBand};
use crate::thrust::curve::Supply;
use crate::thrust::fit::{DirectionFit, Estimate, fit_curve};
use crate::thrust::measured::MeasuredCurve;
use crate::thrust::thruster::{BollardTable, Thruster};

/// A curve fitted to a bollard table, for the result.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FittedCurve {
    /// Names of the thrusters that have it.
    pub thrusters: Vec<String>,
    /// The table.
    pub file: String,
    /// Coefficients for V > 0.
    pub forward: DirectionFit,
    /// Coefficients for V < 0.
    pub reverse: DirectionFit,
    /// Dead band, as V; without deviation if it was given.
    pub deadband: Estimate,
    /// Exponent of the supply voltage, if the table has several voltages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supply_exponent: Option<Estimate>,
}

impl FittedCurve {
    /// Returns the result for a curve that `thrusters` have.
    pub(super) fn of(curve: &MeasuredCurve, thrusters: &[Thruster]) -> FittedCurve {
        FittedCurve {
            thrusters: curve.thrusters.iter().map(|k| thrusters[*k].name.clone()).collect(),
            file: curve.file.clone(),
            forward: curve.fit.forward,
            reverse: curve.fit.reverse,
            deadband: curve.fit.deadband,
            supply_exponent: curve.fit.exponent,
        }
    }
}

/// Results of the tables.
#[derive(Default)]
pub(super) struct Curves {
    pub curves: Vec<MeasuredCurve>,
    pub findings: Vec<Finding>,
    pub sources: Vec<PathBuf>,
}

/// The rows of one thruster.
#[derive(Clone, PartialEq)]
struct Rows {
    command: Vec<f64>,
    force: Vec<f64>,
    supply: Option<Vec<f64>>,
}

/// Fits the curve of every thruster with a bollard table, and writes it into the file's thrusters
/// instead of the table.
///
/// # Errors
/// [`Error::Log`] if a table cannot be read, findings if it gives no curve.
pub(super) fn fit(file: &mut CampaignFile) -> Result<Curves, Error> {
    let mut found = Curves::default();
    let mut known: Vec<(Rows, CurveOptions, Option<Supply>)> = Vec::new();
    for k in 0..file.thrusters.len() {
        let Some(table) = file.thrusters[k].bollard.clone() else { continue };
        let path = file.folder().join(&table.file);
        let log = log::read(&path, &file.log, &[]).map_err(|source| Error::Log { run: table.file.clone(), source })?;
        if !found.sources.contains(&path) {
            found.findings.extend(log.warnings.iter().map(|f| f.clone().of_run(&table.file)));
            found.sources.push(path);
        }
        let run = Run { name: table.file.clone(), signals: log.signals, ..Run::default() };
        let pulses = |column: &str| log.units.get(column) == Some(&"us");
        let refused = |text: String| {
            let text = format!("thruster {:?}: {text}", file.thrusters[k].name);
            Error::Refused { findings: vec![Finding::at(&codes::BOLLARD, &table.file, None, None, &text)] }
        };
        let rows = rows_of(k, &file.thrusters, &table, &run, &pulses).map_err(refused)?;
        let thruster = &file.thrusters[k];
        let deadband = if table.fit_deadband { DeadBand::Fitted } else { DeadBand::Given(thruster.deadband) };
        let options = CurveOptions { deadband, reference_supply: table.reference_supply, max: thruster.max };
        let key = (rows, options, thruster.supply);
        let index = match known.iter().position(|other| *other == key) {
            Some(index) => index,
            None => {
                let rows = &key.0;
                let bollard = Bollard { command: &rows.command, force: &rows.force, supply: rows.supply.as_deref() };
                let fit = fit_curve(&bollard, &options).map_err(|e| refused(e.to_string()))?;
                found.curves.push(MeasuredCurve { file: table.file.clone(), thrusters: Vec::new(), fit });
                known.push(key);
                known.len() - 1
            }
        };
        let curve = &mut found.curves[index];
        curve.thrusters.push(k);
        let fitted = curve.fit.curve;
        let thruster = &mut file.thrusters[k];
        (thruster.forward, thruster.reverse) = (fitted.forward, fitted.reverse);
        thruster.deadband = fitted.deadband;
        thruster.supply = fitted.supply.or(thruster.supply);
        // beyond the maximum of a curve that bends down nothing is known
        thruster.max = Some(thruster.max.map_or(fitted.max, |max| max.min(fitted.max))).filter(|max| max.is_finite());
        thruster.bollard = None;
    }
    Ok(found)
}

/// Returns the rows of `table` in which thruster `k` alone is driven. The error says what the table
/// lacks.
fn rows_of(
    k: usize,
    thrusters: &[Thruster],
    table: &BollardTable,
    run: &Run,
    pulses: &dyn Fn(&str) -> bool,
) -> Result<Rows, String> {
    let has = |name: &str| run.signal(name).filter(|s| !s.is_empty());
    let commands: Vec<&str> =
        run.signals.keys().map(String::as_str).filter(|name| thruster_of(name, "V").is_some()).collect();
    let own = thruster_command(k);
    let column = match (&table.command, commands.as_slice()) {
        (Some(named), _) => named.as_str(),
        (None, [only]) => only,
        (None, _) if has(&own).is_some() => &own,
        (None, _) => {
            return Err(format!(
                "no column `{own}` with its command; or name the column: bollard = {{ file = {:?}, command = \"…\" }}",
                table.file
            ));
        }
    };
    let Some(command) = has(column) else { return Err(format!("no column `{column}` with its command")) };
    let (force, part) = force_of(&thrusters[k], table, run)?;
    let supply = run.supply_voltage();
    let rows = command.len();
    if [Some(force), supply].into_iter().flatten().any(|s| s.len() != rows) {
        return Err("a row needs command, force and, where there is one, supply voltage".into());
    }
    let driven = |column: &str, x: f64, of: &Thruster| -> Result<f64, String> {
        if pulses(column) { of.command_of_pulse(x).map_err(|e| e.to_string()) } else { Ok(x) }
    };
    let mut found = Rows { command: Vec::new(), force: Vec::new(), supply: supply.map(|_| Vec::new()) };
    for row in 0..rows {
        let mut alone = true;
        for other in commands.iter().filter(|c| **c != column) {
            let number = other[1..].parse::<usize>().ok().and_then(|n| thrusters.get(n.wrapping_sub(1)));
            let x = run.signal(other).and_then(|s| s.values().get(row)).copied().unwrap_or(0.0);
            alone &= number.map_or(Ok(x), |of| driven(other, x, of))? == 0.0;
        }
        if alone {
            let mut pull = force.values()[row] / part;
            if let (Some(given), Some(volts)) = (thrusters[k].supply, supply) {
                // a given dependence on the supply is divided out, and only the coefficients are
                // fitted
                pull /= given.factor(volts.values()[row]);
            }
            found.command.push(driven(column, command.values()[row], &thrusters[k])?);
            found.force.push(pull);
            if let (Some(volts), Some(column)) = (supply, &mut found.supply) {
                column.push(volts.values()[row]);
            }
        }
    }
    if thrusters[k].supply.is_some() {
        found.supply = None;
    }
    Ok(found)
}

/// Returns the column with the force, and the component of the axis along it.
fn force_of<'a>(thruster: &Thruster, table: &BollardTable, run: &'a Run) -> Result<(&'a Signal, f64), String> {
    let cells: Vec<&str> = Dof::ALL.map(Dof::load).into_iter().filter(|name| run.signal(name).is_some()).collect();
    let column = match (&table.force, cells.as_slice()) {
        (Some(named), _) => named.as_str(),
        (None, _) if run.signal("force").is_some() => "force",
        (None, [only]) => only,
        (None, []) => return Err("no column `force`, and none of a load cell".into()),
        (None, _) => return Err(format!("{}: name the one to take as `force`", cells.join(", "))),
    };
    let Some(signal) = run.signal(column) else { return Err(format!("no column `{column}` with its force")) };
    let part = match Dof::ALL.into_iter().find(|dof| dof.load() == column) {
        Some(dof) => thruster.unit_wrench()[dof.index()],
        None => 1.0,
    };
    if part.abs() > 1e-6 { Ok((signal, part)) } else { Err(format!("its axis has no component along `{column}`")) }
}
