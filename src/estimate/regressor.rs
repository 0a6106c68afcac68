//! Integral regressors: the balance of momentum, integrated between samples by the trapezoid.
//!
//! ```text
//! Σⱼ θⱼ cⱼₖ = yₖ
//! cⱼₖ = [∂π/∂θⱼ]ₖ − Σ ½ (fⱼ + fⱼ') Δt,   fⱼ = ∂(w + τ)/∂θⱼ,   yₖ = −(the same with the free θ at 0)
//! ```
//!
//! There is one row k for each [`Span`] of each run, and one column for each free linear parameter
//! (one per run for a parameter with a value of its own in each run). No acceleration is measured
//! or differentiated; all states are read from the log, at the instants that
//! [`super::nodes`](super::Nodes) defines. Avila et al. (2013), eq. 4, 5, 9 and 10.

use serde::{Deserialize, Serialize};

use super::balance::{Balance, RegressorError, Source};
use super::nodes::{Nodes, Reader, Span, Stretch, stretches};
use super::shared_stamps::write_rows;
use super::sums::Sums;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, Signal, rounding_of_commands};
use crate::simd::Plain;
use crate::simulate::values_in_run;
use crate::symbolic::Registers;

/// Number of instants evaluated side by side.
pub(super) const LANES: usize = 8;

/// How the balance is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RegressorOptions {
    /// What a row spans.
    pub span: Span,
    /// Instants of the trapezoid.
    pub nodes: Nodes,
}

/// The parameter that a column multiplies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Index of the parameter in the model.
    pub parameter: usize,
    /// Index of the run, if the parameter has a value of its own in each.
    pub run: Option<usize>,
    /// Symbol of the parameter, with the name of the run if it has its own there.
    pub name: String,
}

/// Rows of one degree of freedom in one run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Degree of freedom.
    pub dof: Dof,
    /// Index of the run.
    pub run: usize,
    /// Its rows.
    pub rows: std::ops::Range<usize>,
}

/// A linear system in the free parameters: Σⱼ θⱼ `columns[j]` = `rhs`.
#[derive(Debug, Clone, Default)]
pub struct Columns {
    /// The parameter that each column multiplies.
    pub parameters: Vec<Column>,
    /// The columns, each as long as `rhs`; unit of the momentum over that of the parameter.
    pub columns: Vec<Vec<f64>>,
    /// Right-hand side, N·s or N·m·s.
    pub rhs: Vec<f64>,
    /// Beginning and end of each row, s.
    pub span: Vec<(f64, f64)>,
    /// Which rows belong to which run and degree of freedom, in order.
    pub blocks: Vec<Block>,
}

impl Columns {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rhs.len()
    }

    /// The columns as slices.
    pub fn slices(&self) -> Vec<&[f64]> {
        self.columns.iter().map(Vec::as_slice).collect()
    }

    /// Index of the column of the parameter `parameter` in all runs.
    pub fn column_of(&self, parameter: usize) -> Option<usize> {
        self.parameters.iter().position(|c| c.parameter == parameter)
    }

    /// Appends rows, still 0, between neighbours of these instants. Returns the new part of the
    /// right-hand side, then that of the columns `places`, in their order.
    fn extended(&mut self, places: &[usize], time: &[f64]) -> Vec<&mut [f64]> {
        let (before, rows) = (self.rhs.len(), self.rhs.len() + time.len() - 1);
        self.span.extend(time.windows(2).map(|t| (t[0], t[1])));
        lengthen(&mut self.rhs, rows);
        let mut new: Vec<(usize, &mut [f64])> = Vec::with_capacity(places.len());
        for (place, column) in self.columns.iter_mut().enumerate() {
            if let Some(at) = places.iter().position(|p| *p == place) {
                lengthen(column, rows);
                new.push((at, &mut column[before..]));
            }
        }
        new.sort_unstable_by_key(|(at, _)| *at);
        std::iter::once(&mut self.rhs[before..]).chain(new.into_iter().map(|(_, column)| column)).collect()
    }

    pub(super) fn index(&mut self, model: &Model, parameter: usize, run: usize, name: &str) -> usize {
        let spec = &model.parameters[parameter].spec;
        let own = spec.per_run.then_some(run);
        let known = self.parameters.iter().position(|c| c.parameter == parameter && c.run == own);
        known.unwrap_or_else(|| {
            let name = if own.is_some() { format!("{} [{name}]", spec.name) } else { spec.name.clone() };
            self.parameters.push(Column { parameter, run: own, name });
            self.columns.push(vec![0.0; self.rhs.len()]);
            self.columns.len() - 1
        })
    }
}

/// Lengthens a column by zeros; new memory is zero already, and is touched only when rows are
/// written.
fn lengthen(column: &mut Vec<f64>, rows: usize) {
    if column.is_empty() {
        *column = vec![0.0; rows];
    } else {
        column.resize(rows, 0.0);
    }
}

/// The regressors of the balance of `dof`, stacked over `runs`.
///
/// # Errors
/// [`RegressorError`] if the balance is not linear in the free parameters or reads what is not
/// logged.
pub fn regressors_of(
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    options: RegressorOptions,
) -> Result<Columns, RegressorError> {
    let mut columns = Columns::default();
    stack(&mut columns, dof, runs, model, options)?;
    check_scale(dof, &columns.rhs, runs)?;
    Ok(columns)
}

/// Refuses a balance in which nothing known acts: every solution could be multiplied by any factor.
fn check_scale(dof: Dof, known: &[f64], runs: &[&Run]) -> Result<(), RegressorError> {
    // what rounding leaves of a command, over a second
    let rounding = runs.iter().map(|run| rounding_of_commands(std::slice::from_ref(*run))).fold(0.0, f64::max);
    if !known.is_empty() && known.iter().all(|y| y.abs() <= rounding) {
        return Err(RegressorError::NoScale { dof });
    }
    Ok(())
}

fn stack(
    columns: &mut Columns,
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    options: RegressorOptions,
) -> Result<(), RegressorError> {
    for (index, run) in runs.iter().enumerate() {
        let balance = Balance::compile(model, dof, run)?;
        if balance.free.is_empty() {
            return Err(RegressorError::NothingFree { dof });
        }
        let places: Vec<usize> = balance.free.iter().map(|p| columns.index(model, *p, index, &run.name)).collect();
        let begin = columns.rows();
        if let Some(own) = run.signal(dof.velocity()) {
            let mut reading = Reading::new(&balance, own, run, index, model, options);
            for stretch in stretches(run, dof.velocity(), own, &reading.readers, options.nodes) {
                if let Some(inputs) = reading.at_stamps(&stretch) {
                    let new = columns.extended(&places, &stretch.time);
                    write_rows(&balance.plan, &reading.registers, &stretch.time, &inputs, new);
                } else {
                    reading.walk(stretch, &places, columns);
                }
            }
        }
        let rows = columns.rows();
        columns.columns.iter_mut().for_each(|c| c.resize(rows, 0.0));
        columns.blocks.push(Block { dof, run: index, rows: begin..rows });
    }
    Ok(())
}

/// A balance prepared for evaluation at the instants of one run.
pub(super) struct Reading<'a> {
    pub balance: &'a Balance,
    pub registers: Registers<LANES>,
    slots: Vec<usize>,
    pub readers: Vec<Reader>,
    own: &'a Signal,
    span: Span,
    /// Whether a value just before an instant may differ from that just after it.
    jumps: bool,
}

impl<'a> Reading<'a> {
    /// Prepares the run `index`, with the values of the model's parameters there; `own` logs the
    /// velocity of the balance.
    pub fn new(
        balance: &'a Balance,
        own: &'a Signal,
        run: &Run,
        index: usize,
        model: &Model,
        options: RegressorOptions,
    ) -> Reading<'a> {
        let values = values_in_run(model, index);
        let mut registers: Registers<LANES> = balance.plan.registers();
        let (mut slots, mut readers) = (Vec::new(), Vec::new());
        for (slot, source) in balance.sources.iter().enumerate() {
            match source {
                Source::Parameter(p) => {
                    let value = if model.parameters[*p].fixed { values[*p] } else { 0.0 };
                    balance.plan.set(&mut registers, slot, [value; LANES]);
                }
                Source::Time => {
                    slots.push(slot);
                    readers.push(Reader::new(run, source, 0.0, model.input));
                }
                Source::Channel { late, .. } => {
                    slots.push(slot);
                    readers.push(Reader::new(run, source, late.map_or(0.0, |p| values[p]), model.input));
                }
            }
        }
        balance.plan.prepare(&mut registers);
        let jumps = readers.iter().any(Reader::jumps);
        Reading { balance, registers, slots, readers, own, span: options.span, jumps }
    }

    /// The values read at the instants of a stretch, slot by slot, if all instants are stamps of
    /// all channels and rows span one interval.
    pub fn at_stamps<'s>(&'s self, stretch: &'s Stretch) -> Option<Vec<(usize, &'s [f64])>> {
        let one = self.span == Span::Samples(1) && !self.jumps;
        if one { at_stamps(stretch, self.own, &self.slots, &self.readers) } else { None }
    }

    /// Adds the rows of a stretch, whatever its instants are.
    pub fn walk(&mut self, stretch: Stretch, places: &[usize], columns: &mut Columns) {
        let Reading { balance, registers, slots, readers, jumps, .. } = self;
        let mut sums = Sums::new(balance.free.len() + 1, self.span);
        let Stretch { time, own } = stretch;
        let mut after = registers.clone();
        for (chunk, times) in time.chunks(LANES).enumerate() {
            let mut evaluate = |registers: &mut Registers<LANES>, before: bool| {
                for (slot, reader) in slots.iter().zip(readers.iter_mut()) {
                    let at = |k: usize| times[k.min(times.len() - 1)];
                    balance.plan.set(registers, *slot, std::array::from_fn(|k| reader.read(at(k), before)));
                }
                balance.plan.evaluate(Plain, registers);
            };
            evaluate(registers, true);
            if *jumps {
                evaluate(&mut after, false);
            }
            let outputs = |registers: &Registers<LANES>| -> Vec<[f64; LANES]> {
                (0..balance.plan.outputs()).map(|k| balance.plan.output(registers, k)).collect()
            };
            let ends = outputs(registers);
            let begins = if *jumps { outputs(&after) } else { ends.clone() };
            for (k, t) in times.iter().enumerate() {
                sums.arrive(*t, k, &ends);
                if own[chunk * LANES + k] {
                    sums.close(places, columns);
                }
                sums.leave(k, &begins);
            }
        }
        sums.finish(places, columns);
    }
}

/// The values read at the instants of a stretch, slot by slot, if all instants are stamps of all
/// channels.
fn at_stamps<'a>(
    stretch: &'a Stretch,
    own: &Signal,
    slots: &[usize],
    readers: &'a [Reader],
) -> Option<Vec<(usize, &'a [f64])>> {
    let time = &stretch.time;
    if !stretch.own.iter().all(|own| *own) || !time.windows(2).all(|t| t[0] < t[1]) {
        return None;
    }
    let first = own.time().partition_point(|t| t < time.first().unwrap_or(&0.0));
    let read = |(slot, reader): (&usize, &'a Reader)| match reader.on_stamps(own) {
        Some(values) => Some((*slot, values.get(first..first + time.len())?)),
        None => reader.is_time().then_some((*slot, &time[..])),
    };
    slots.iter().zip(readers).map(read).collect()
}
