//! Forces of a balance at the samples of a log, without integration.
//!
//! For forces over time (Fig. 11 of Avila et al., 2013), and for the direct fit (30) whose
//! acceleration comes from differentiating the velocity. Every channel is read at the stamps of the
//! balance's own velocity.

use super::balance::{Balance, Source, compiled_components};
use super::nodes::{Nodes, Reader, stretches};
use super::regressor::{Block, Column};
use super::{Columns, RegressorError};
use crate::filter::{FilterError, PolynomialFilter};
use crate::frame::Dof;
use crate::log::check::time::gaps_of;
use crate::model::Model;
use crate::run::Run;
use crate::simd::Plain;
use crate::simulate::values_in_run;
use crate::symbolic::{Plan, Registers};

/// The parts of the force in one degree of freedom over time.
#[derive(Debug, Clone)]
pub struct Components {
    /// Time stamps of the velocity, s.
    pub time: Vec<f64>,
    /// Velocity of the degree of freedom, m/s or rad/s.
    pub velocity: Vec<f64>,
    /// Name of each term that acts in the balance (`thrust` for what the actuators make of the
    /// command), with its force at each time stamp, N or N·m.
    pub terms: Vec<(String, Vec<f64>)>,
}

impl Components {
    /// Sum of all forces: what changes the momentum, N or N·m.
    pub fn total(&self) -> Vec<f64> {
        (0..self.time.len()).map(|k| self.terms.iter().map(|(_, f)| f[k]).sum()).collect()
    }

    /// Sum of the terms whose name is `wanted`.
    pub fn sum_of(&self, wanted: impl Fn(&str) -> bool) -> Vec<f64> {
        let chosen: Vec<&Vec<f64>> = self.terms.iter().filter(|(name, _)| wanted(name)).map(|(_, f)| f).collect();
        (0..self.time.len()).map(|k| chosen.iter().map(|f| f[k]).sum()).collect()
    }
}

/// Forces of `model` in `dof` along the log of `run`, whose number is `index`.
///
/// # Errors
/// [`RegressorError`] if the balance reads what is not logged, or depends on memory.
pub fn force_components(dof: Dof, run: &Run, index: usize, model: &Model) -> Result<Components, RegressorError> {
    let (names, plan, sources) = compiled_components(model, dof, run)?;
    let values = values_in_run(model, index);
    let (time, mut rows) = evaluate(&plan, &sources, run, dof, model, &values);
    let velocity = rows.pop().unwrap_or_default();
    Ok(Components { time, velocity, terms: names.into_iter().zip(rows).collect() })
}

/// Regressors of the direct fit (30): the forces per unit of each free parameter at each sample.
/// The column of the own inertia has the derivative of the velocity by `filter`. Other momenta
/// (couplings) must be fixed at 0.
///
/// # Errors
/// As [`super::regressors_of`]; [`FilterError`] inside [`DirectError`].
pub fn direct_columns(
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    filter: &PolynomialFilter,
) -> Result<Columns, DirectError> {
    let mut columns = Columns::default();
    let inertia = model.inertia(dof);
    for (index, run) in runs.iter().enumerate() {
        let balance = Balance::compile(model, dof, run)?;
        let mut values = values_in_run(model, index);
        for p in model.free() {
            values[p] = 0.0;
        }
        let (time, rows) = evaluate(&balance.plan, &balance.sources, run, dof, model, &values);
        let Some(own) = run.signal(dof.velocity()) else { continue };
        let derivative = filter.apply(own, &gaps_of(run, [dof.velocity()]))?.derivative;
        let rate = |t: &f64| derivative.values()[own.time().partition_point(|s| s < t).min(own.len() - 1)];
        let begin = columns.rows();
        let width = balance.free.len() + 1;
        columns.rhs.extend(&rows[width]);
        columns.span.extend(time.iter().map(|t| (*t, *t)));
        for (j, p) in balance.free.iter().enumerate() {
            let place = columns.column_of(*p).unwrap_or_else(|| {
                let name = model.parameters[*p].spec.name.clone();
                columns.parameters.push(Column { parameter: *p, run: None, name });
                columns.columns.push(vec![0.0; begin]);
                columns.columns.len() - 1
            });
            let force = rows[width + 1 + j].iter().map(|f| -f);
            if Some(*p) == inertia {
                columns.columns[place].extend(time.iter().zip(force).map(|(t, f)| rate(t) + f));
            } else {
                columns.columns[place].extend(force);
            }
        }
        let rows = columns.rows();
        columns.columns.iter_mut().for_each(|c| c.resize(rows, 0.0));
        columns.blocks.push(Block { dof, run: index, rows: begin..rows });
    }
    Ok(columns)
}

/// Reason why there is no direct regressor.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DirectError {
    /// The balance has no regressor.
    #[error(transparent)]
    Regressor(#[from] RegressorError),
    /// The velocity cannot be differentiated.
    #[error(transparent)]
    Filter(#[from] FilterError),
}

/// Number of instants evaluated side by side.
const LANES: usize = 8;

/// The time stamps, and the outputs of `plan` there, one list for each output.
fn evaluate(
    plan: &Plan,
    sources: &[Source],
    run: &Run,
    dof: Dof,
    model: &Model,
    values: &[f64],
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let mut registers: Registers<LANES> = plan.registers();
    let (mut slots, mut readers) = (Vec::new(), Vec::new());
    for (slot, source) in sources.iter().enumerate() {
        let late = match source {
            Source::Parameter(p) => {
                plan.set(&mut registers, slot, [values[*p]; LANES]);
                continue;
            }
            Source::Time => 0.0,
            Source::Channel { late, .. } => late.map_or(0.0, |p| values[p]),
        };
        slots.push(slot);
        readers.push(Reader::new(run, source, late, model.input));
    }
    plan.prepare(&mut registers);
    let (mut time, mut rows) = (Vec::new(), vec![Vec::new(); plan.outputs()]);
    let Some(own) = run.signal(dof.velocity()) else { return (time, rows) };
    for stretch in stretches(run, dof.velocity(), own, &readers, Nodes::Own) {
        for times in stretch.time.chunks(LANES) {
            for (slot, reader) in slots.iter().zip(&mut readers) {
                let at = |k: usize| times[k.min(times.len() - 1)];
                plan.set(&mut registers, *slot, std::array::from_fn(|k| reader.read(at(k), false)));
            }
            plan.evaluate(Plain, &mut registers);
            for (k, row) in rows.iter_mut().enumerate() {
                row.extend_from_slice(&plan.output(&registers, k)[..times.len()]);
            }
        }
        time.extend(stretch.time);
    }
    (time, rows)
}
