//! What earlier stages have found and later ones hold: values with their covariance, carried on.
//!
//! ```text
//! cov θ = cov(θ | held) + J Σ_held Jᵀ        J = ∂θ̂/∂held, by central differences of one standard deviation
//! ```
//!
//! A drag may have one value for each direction of motion; a row takes those of its own direction.

use crate::estimate::{Columns, IntegralError, RegressorOptions, RowFit, StdMethod, fit_rows, regressors_of};
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, Signal};

/// Direction of motion: the sign of the velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// Ahead, to starboard, down, clockwise.
    Positive,
    /// The opposite.
    Negative,
}

/// A parameter that a stage has found.
#[derive(Debug, Clone, Copy)]
struct Entry {
    parameter: usize,
    /// For which direction; both when absent.
    direction: Option<Direction>,
    value: f64,
}

/// What earlier stages have found.
#[derive(Debug, Clone, Default)]
pub(super) struct Held {
    entries: Vec<Entry>,
    covariance: Vec<Vec<f64>>,
}

impl Held {
    /// Adds what a fit has found of the parameters `keep`; `direction` for a fit of one direction alone.
    pub fn add(&mut self, fit: &RowFit, keep: &[usize], direction: Option<Direction>) {
        let chosen: Vec<usize> =
            (0..fit.parameters.len()).filter(|k| keep.contains(&fit.parameters[*k].parameter)).collect();
        let before = self.entries.len();
        let size = before + chosen.len();
        for row in &mut self.covariance {
            row.resize(size, 0.0);
        }
        for k in &chosen {
            self.entries.push(Entry { parameter: fit.parameters[*k].parameter, direction, value: fit.values[*k] });
            let mut row = vec![0.0; before];
            row.extend(chosen.iter().map(|l| fit.covariance[*k][*l]));
            self.covariance.push(row);
        }
    }

    /// Whether this parameter has been found.
    pub fn has(&self, parameter: usize) -> bool {
        self.entries.iter().any(|e| e.parameter == parameter)
    }

    /// Adds a value that is known exactly.
    pub fn know(&mut self, parameter: usize, value: f64) {
        self.entries.push(Entry { parameter, direction: None, value });
        let size = self.entries.len();
        self.covariance.push(Vec::new());
        self.covariance.iter_mut().for_each(|row| row.resize(size, 0.0));
    }

    /// Everything that `other` holds as well; the two were found apart.
    pub fn join(&mut self, other: Held) {
        let before = self.entries.len();
        for row in &mut self.covariance {
            row.resize(before + other.entries.len(), 0.0);
        }
        for row in other.covariance {
            self.covariance.push([vec![0.0; before], row].concat());
        }
        self.entries.extend(other.entries);
    }

    /// `model` with what is held, of a positive velocity where it depends on the direction.
    pub fn written(&self, model: &Model) -> Model {
        self.write_to(model, Direction::Positive, None)
    }

    fn directional(&self, model: &Model, dof: Dof) -> bool {
        self.entries.iter().any(|e| e.direction.is_some() && model.parameters[e.parameter].place.dof == Some(dof))
    }

    /// `model` with the held values for one direction, entry `shifted.0` moved by `shifted.1`.
    fn write_to(&self, model: &Model, direction: Direction, shifted: Option<(usize, f64)>) -> Model {
        let mut model = model.clone();
        for (k, entry) in self.entries.iter().enumerate() {
            if entry.direction.is_none_or(|d| d == direction) {
                let shift = shifted.filter(|(at, _)| *at == k).map_or(0.0, |(_, by)| by);
                model.parameters[entry.parameter].value = entry.value + shift;
            }
        }
        model
    }

    /// Rows of `dof` with only `free` free.
    fn rows(
        &self,
        (dof, runs): (Dof, &[&Run]),
        model: &Model,
        free: &[usize],
        options: RegressorOptions,
        shifted: Option<(usize, f64)>,
    ) -> Result<Columns, IntegralError> {
        let mut model = model.clone();
        for (k, parameter) in model.parameters.iter_mut().enumerate() {
            parameter.fixed = !free.contains(&k);
        }
        let of = |direction| regressors_of(dof, runs, &self.write_to(&model, direction, shifted), options);
        let mut columns = of(Direction::Positive)?;
        if self.directional(&model, dof) {
            let other = of(Direction::Negative)?;
            for block in &columns.blocks {
                let Some(own) = runs[block.run].signal(dof.velocity()) else { continue };
                for row in block.rows.clone() {
                    let (from, to) = columns.span[row];
                    if value_near(own, from) + value_near(own, to) < 0.0 {
                        columns.rhs[row] = other.rhs[row];
                    }
                }
            }
        }
        Ok(columns)
    }

    /// Fits `free` in the balance of `dof`, everything else held; `finish` may scale the rows. The covariance has what
    /// the held values leave uncertain.
    pub fn fit(
        &self,
        (dof, runs): (Dof, &[&Run]),
        model: &Model,
        free: &[usize],
        options: (RegressorOptions, StdMethod),
        finish: &dyn Fn(&mut Columns),
    ) -> Result<RowFit, IntegralError> {
        let inertia = model.parameter_of(&format!("inertia@{dof}")).filter(|p| free.contains(p));
        let solve = |shifted| -> Result<RowFit, IntegralError> {
            let mut columns = self.rows((dof, runs), model, free, options.0, shifted)?;
            finish(&mut columns);
            fit_rows(&columns, inertia, options.1)
                .map_err(|source| IntegralError::Linear { dofs: dof.to_string(), source })
        };
        let mut fit = solve(None)?;
        let n = fit.values.len();
        let mut jacobian = vec![vec![0.0; self.entries.len()]; n];
        for k in 0..self.entries.len() {
            let std = self.covariance[k][k].max(0.0).sqrt();
            let parameter = self.entries[k].parameter;
            // a drag of another degree of freedom does not stand in this balance; a mass may, by its Coriolis term
            let place = model.parameters[parameter].place;
            let elsewhere = place.dof != Some(dof) && model.parameters[parameter].effect != "inertia";
            if std > 0.0 && !free.contains(&parameter) && !elsewhere {
                let (up, down) = (solve(Some((k, std)))?, solve(Some((k, -std)))?);
                for i in 0..n {
                    jacobian[i][k] = (up.values[i] - down.values[i]) / (2.0 * std);
                }
            }
        }
        for i in 0..n {
            for j in 0..n {
                let carried = |k: usize, l: usize| jacobian[i][k] * self.covariance[k][l] * jacobian[j][l];
                let size = self.entries.len();
                fit.covariance[i][j] += (0..size).map(|k| (0..size).map(|l| carried(k, l)).sum::<f64>()).sum::<f64>();
            }
        }
        Ok(fit)
    }
}

fn value_near(signal: &Signal, t: f64) -> f64 {
    signal.values()[signal.time().partition_point(|s| *s < t - 1e-9).min(signal.len() - 1)]
}
