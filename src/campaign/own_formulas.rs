//! Checks of the user's formulas against the model and the logs.
//!
//! ```text
//! [formula] · [unit of the parameter] = N, N·m in rotation
//! ```
//!
//! ```text
//! [observed formula] = [column of the log]
//! ```
//!
//! A formula of states, forces and time alone has a unit. The unit of a further column of a log is
//! not known, and in a sum of unlike units the numbers have hidden units: such formulas are not
//! judged. The number in an observed `0.3*q` may be a lever arm in m; a force has a parameter that
//! takes such a unit.

use super::baseline::wrong;
use super::error::Error;
use super::file::{CampaignFile, EffectTable};
use super::logs::Logged;
use super::moves::moves;
use crate::formula::Formula;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, Signal};
use crate::symbolic::{DimensionError, Graph, Leaf};
use crate::units::Dimension;

/// Refuses a user's formula that reads a state which is neither modelled nor logged, whose unit
/// does not match that of its parameter, or that gives no finite number somewhere in a log.
///
/// # Errors
/// [`Error::File`] with the place in the campaign file.
pub(super) fn check(file: &CampaignFile, model: &Model, runs: &[Run]) -> Result<(), Error> {
    let effects = file.effects.iter().enumerate().map(|(i, e)| (format!("effect[{i}].formula"), &e.formula));
    let observed = file.observed.iter().enumerate().map(|(i, o)| (format!("observe[{i}].formula"), &o.formula));
    for (at, text) in effects.chain(observed) {
        let formula = Formula::parse(text).map_err(|e| wrong(file, &at, &e))?;
        let simulated = |dof: &Dof| [Some(dof.velocity()), dof.is_rotation().then(|| dof.position())];
        let states: Vec<&str> = model.dofs.iter().flat_map(simulated).flatten().collect();
        for run in runs.iter().filter(|run| moves(run.kind)) {
            let known: Vec<&str> =
                run.signals.keys().map(String::as_str).chain(states.iter().copied()).chain(["t"]).collect();
            formula.check(known).map_err(|e| wrong(file, &at, &format!("run `{}`: {e}", run.name)))?;
            if let Some(text) = no_number(&formula, run) {
                return Err(wrong(file, &at, &text));
            }
        }
    }
    for (i, table) in file.effects.iter().enumerate() {
        if let Some(text) = wrong_unit(table) {
            return Err(wrong(file, &format!("effect[{i}].unit"), &text));
        }
    }
    Ok(())
}

/// Refuses an observed formula whose unit differs from the unit in the header of its column.
///
/// # Errors
/// [`Error::File`] with the place in the campaign file.
pub(super) fn check_observed_units(file: &CampaignFile, logged: &[Logged]) -> Result<(), Error> {
    for (i, table) in file.observed.iter().enumerate() {
        let formula = Formula::parse(&table.formula).ok().filter(|formula| !formula.has_numbers());
        let Some(Ok(predicted)) = formula.as_ref().and_then(dimension) else { continue };
        for log in logged {
            let Some(unit) = log.units.get(&table.channel) else { continue };
            if unit.parse().is_ok_and(|measured: Dimension| measured != predicted) {
                let text = format!(
                    "`{}` is in {predicted}, but run `{}` has `{}` in {unit}: they must have the same unit; correct \
                     the formula, or the unit of the column with columns.{} = {{ name, unit }}",
                    table.formula, log.run.name, table.channel, table.channel
                );
                return Err(wrong(file, &format!("observe[{i}].formula"), &text));
            }
        }
    }
    Ok(())
}

/// Returns where a formula gives no finite number along a log; `None` if it is finite everywhere,
/// or reads what is not logged.
fn no_number(formula: &Formula, run: &Run) -> Option<String> {
    let read: Vec<&Signal> = formula.names().into_iter().filter_map(|name| run.signal(name)).collect();
    let stamps: Vec<f64> = read.iter().max_by_key(|signal| signal.len())?.time().to_vec();
    let values = formula.over(run, &stamps).ok()?;
    let bad = values.iter().position(|x| !x.is_finite())?;
    let said: Vec<String> = formula
        .names()
        .into_iter()
        .filter_map(|name| Some(format!("{name} = {:.6}", run.signal(name)?.at(stamps[bad]))))
        .collect();
    let how = if values[bad].is_nan() { "is not a number (NaN)" } else { "is infinite" };
    Some(format!(
        "run `{}`: the formula {how} at t = {} s, where {}; a root or a logarithm needs a positive argument and a \
         divisor must not be 0: guard it, e.g. with max(x, 0)",
        run.name,
        stamps[bad],
        said.join(", ")
    ))
}

/// Returns why formula and unit do not give a force; `None` if they do, or if it cannot be told.
fn wrong_unit(table: &EffectTable) -> Option<String> {
    let formula = Formula::parse(&table.formula).ok()?;
    let found = match dimension(&formula)? {
        Ok(found) => found,
        Err(wrong @ DimensionError::Mismatch { .. }) if !formula.has_numbers() => {
            return Some(format!("`{}`: {wrong}", table.formula));
        }
        // a number may have the missing unit, and a tanh of a speed is a smooth sign
        Err(_) => return None,
    };
    let force = if table.dof.is_rotation() { Dimension::MOMENT } else { Dimension::FORCE };
    let wanted = force.over(found);
    (wanted != table.unit).then(|| {
        format!(
            "`{}` is in {found}; times a parameter in {} that gives {}, not {force}: the unit of the parameter must be \
             {wanted}",
            table.formula,
            table.unit,
            found.times(table.unit)
        )
    })
}

/// Returns the unit of a formula, or why it has none; `None` if it reads a column of the log.
fn dimension(formula: &Formula) -> Option<Result<Dimension, DimensionError>> {
    let graph = Graph::new();
    let names: Vec<&str> = formula.names().into_iter().collect();
    let units: Vec<Dimension> = names.iter().map(|name| known_unit(name)).collect::<Option<_>>()?;
    let leaf = |name: &str| {
        let k = names.iter().position(|n| *n == name).unwrap_or_default();
        graph.leaf(Leaf::Input(k as u16), units.get(k).copied().unwrap_or(Dimension::ONE))
    };
    Some(formula.lower(&graph, &leaf).dimension())
}

/// Returns the unit of a state, a force or the time; `None` for a column of the log.
fn known_unit(name: &str) -> Option<Dimension> {
    let of = |dof: Dof| {
        let rotation = dof.is_rotation();
        let velocity = if rotation { Dimension::RATE } else { Dimension::VELOCITY };
        let position = if rotation { Dimension::ONE } else { Dimension::LENGTH };
        let force = if rotation { Dimension::MOMENT } else { Dimension::FORCE };
        [(dof.velocity(), velocity), (dof.position(), position), (dof.force(), force)]
    };
    let known = Dof::ALL.into_iter().flat_map(of).find(|(known, _)| *known == name);
    known.map(|(_, unit)| unit).or_else(|| (name == "t").then_some(Dimension::TIME))
}

#[cfg(test)]
mod tests {
    use super::super::file::EffectRole;
    use super::*;

    fn table(formula: &str, unit: Dimension) -> EffectTable {
        EffectTable { id: "own".into(), dof: Dof::Surge, formula: formula.into(), unit, role: EffectRole::Baseline }
    }

    #[test]
    fn a_unit_that_makes_no_force_is_told_with_the_right_one() {
        let drag = Dimension::new(1, -1, 0);
        assert_eq!(wrong_unit(&table("u*abs(u)", drag)), None);
        let told = wrong_unit(&table("u*abs(u)*r", drag)).unwrap();
        assert!(told.contains("the unit of the parameter must be kg*s/m"), "{told}");
        // a column has no known unit, and in a sum of unlike units the numbers have units of their
        // own
        assert_eq!(wrong_unit(&table("wind^2*cos(psi)", Dimension::FORCE)), None);
        assert_eq!(wrong_unit(&table("u^2 + 0.1*u", Dimension::FORCE)), None);
        assert_eq!(
            wrong_unit(&table("u + r", drag)).as_deref(),
            Some("`u + r`: m/s and 1/s cannot be added or compared")
        );
        assert!(wrong_unit(&table("u^2 + u", drag)).is_some(), "an exponent has no unit to hide");
    }

    #[test]
    fn a_formula_without_a_number_is_told_with_the_instant() {
        let mut run = Run { name: "a.csv".into(), ..Run::default() };
        run.signals.insert("u".into(), Signal::new(vec![0.0, 1.0, 2.0].into(), vec![0.5, 0.1, -0.2]));
        let of = |text: &str| no_number(&Formula::parse(text).unwrap(), &run);
        assert!(of("sqrt(u)").unwrap().contains("NaN) at t = 2 s, where u = -0.2"), "{:?}", of("sqrt(u)"));
        assert!(of("1/(u - 0.1)").unwrap().contains("infinite at t = 1 s"));
        assert_eq!(of("sqrt(max(u, 0))"), None);
        assert_eq!(of("sqrt(v)"), None, "what is not logged is not judged");
    }
}
