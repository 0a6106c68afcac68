//! Results of earlier stages that later stages hold: values with their covariance, and its
//! propagation.
//!
//! ```text
//! cov(θ, held) = J Σ_held        cov θ = cov(θ | held) + J Σ_held Jᵀ        J = ∂θ̂/∂held
//! ```
//!
//! J is computed by central differences of one standard deviation through the fit itself (delta
//! method). Losses of thrust are held like any parameter, so that a drag and an inertia that depend
//! on the same η_inter are correlated correctly. A drag may have one value for each direction of
//! motion; a row uses those of its own direction.

mod expected;

use std::borrow::Cow;

use super::Bench;
use super::curves::with_curve_moved;
use super::effective_thrust::acting_forces;
use super::small_sample;
use crate::effects::id;
use crate::estimate::{Columns, IntegralError, RegressorOptions, RowFit, StdMethod, fit_rows, regressors_of};
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, Signal};
use crate::thrust::efficiency::Efficiency;
use crate::thrust::measured::MeasuredCurve;
use crate::thrust::thruster::Thruster;

/// Direction of motion: the sign of the velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// Ahead, to starboard, down, clockwise.
    Positive,
    /// The opposite.
    Negative,
}

/// Quantity of an entry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Known {
    /// A parameter of the model, for one direction of motion or for both.
    Parameter(usize, Option<Direction>),
    /// Entry of η_inter with this number.
    Interaction(usize),
    /// Slope of η_adv.
    Slope,
    /// Intercept of η_adv.
    Intercept,
    /// A coefficient of a thruster's curve: number of the curve and of the coefficient.
    Curve(usize, usize),
}

#[derive(Debug, Clone, Copy)]
struct Entry {
    known: Known,
    value: f64,
}

/// How rows are built and solved.
#[derive(Debug, Clone, Copy)]
pub(super) struct How {
    /// Options of the rows.
    pub regressor: RegressorOptions,
    /// Method of the standard deviations that the rows' own noise causes.
    pub std: StdMethod,
    /// Whether there are so few rows that Student's t is needed.
    pub few: bool,
}

/// A fit and its dependence on the held values.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub fit: RowFit,
    /// ∂θ̂/∂held: one row per parameter, one column per entry that was held at the time.
    jacobian: Vec<Vec<f64>>,
    /// Factor by which the rows' own standard deviations are wider than those of the residuals
    /// alone, because of few rows.
    pub widening: f64,
}

/// Results of earlier stages.
#[derive(Debug, Clone, Default)]
pub(super) struct Held {
    /// Losses that turn nominal forces into effective ones; runs of load cells have none.
    pub efficiency: Efficiency,
    /// The thrusters, for runs that log each of them.
    pub thrusters: Vec<Thruster>,
    /// Thruster curves that were fitted to bollard tables.
    pub curves: Vec<MeasuredCurve>,
    entries: Vec<Entry>,
    covariance: Vec<Vec<f64>>,
}

impl Held {
    /// Only what is known of the thrust beforehand.
    pub fn of_bench(bench: &Bench<'_>) -> Held {
        let mut held = Held {
            efficiency: bench.efficiency.clone(),
            thrusters: bench.thrusters.to_vec(),
            curves: bench.curves.to_vec(),
            ..Held::default()
        };
        for (i, curve) in bench.curves.iter().enumerate() {
            let covariance = &curve.fit.covariance;
            for k in 0..MeasuredCurve::COEFFICIENTS {
                held.know(Known::Curve(i, k), curve.value(k), &covariance[k][..=k]);
            }
        }
        held
    }

    /// For load cells: their balance contains no thrust, so nothing of its uncertainty is
    /// propagated.
    pub fn without_thrust() -> Held {
        Held::default()
    }

    /// Adds a quantity. The last element of `row` is its variance, the ones before are its
    /// covariances with the entries added last; with all earlier entries it is uncorrelated.
    pub fn know(&mut self, known: Known, value: f64, row: &[f64]) {
        let before = self.entries.len();
        let mut own = vec![0.0; before + 1 - row.len()];
        own.extend_from_slice(row);
        for (k, line) in self.covariance.iter_mut().enumerate() {
            line.push(own[k]);
        }
        self.covariance.push(own);
        self.entries.push(Entry { known, value });
    }

    /// Adds the parameters `keep` of a fit; `direction` for a fit of one direction alone. Returns
    /// each entry with its number in the fit.
    pub fn add(&mut self, found: &Found, keep: &[usize], direction: Option<Direction>) -> Vec<(usize, usize)> {
        let chosen: Vec<usize> =
            (0..found.fit.parameters.len()).filter(|k| keep.contains(&found.fit.parameters[*k].parameter)).collect();
        let mut added: Vec<(usize, usize)> = Vec::new();
        for k in chosen {
            let before = self.entries.len();
            let carried =
                |l: usize| found.jacobian[k].iter().enumerate().map(|(j, d)| d * self.covariance[j][l]).sum::<f64>();
            let own = |l: usize| added.iter().find(|(entry, _)| *entry == l).map(|(_, i)| found.fit.covariance[k][*i]);
            let mut row: Vec<f64> = (0..before).map(|l| own(l).unwrap_or_else(|| carried(l))).collect();
            row.push(found.fit.covariance[k][k]);
            self.know(Known::Parameter(found.fit.parameters[k].parameter, direction), found.fit.values[k], &row);
            added.push((before, k));
        }
        added
    }

    /// Adds the drag of one direction beside that of all windows, `all`, which is at the entries
    /// `of_all`. The covariance between the best estimate and an estimate from part of the same
    /// rows follows from that of the best estimate: cov(θ_part, θ) = G cov θ, where G maps θ to the
    /// part: here the negative direction has `asymmetry` more of quadratic drag.
    pub fn add_direction(
        &mut self,
        part: &Found,
        keep: &[usize],
        direction: Direction,
        (all, of_all): (&Found, &[(usize, usize)]),
        asymmetry: impl Fn(usize) -> Option<usize>,
    ) {
        for (entry, k) in self.add(part, keep, Some(direction)) {
            let parameter = part.fit.parameters[k].parameter;
            let extra = asymmetry(parameter).filter(|_| direction == Direction::Negative);
            for (other, l) in of_all {
                let with = |p: usize| {
                    let i = all.fit.parameters.iter().position(|c| c.parameter == p);
                    i.map_or(0.0, |i| all.fit.covariance[i][*l])
                };
                let covariance = with(parameter) + extra.map_or(0.0, with);
                self.covariance[entry][*other] = covariance;
                self.covariance[*other][entry] = covariance;
            }
        }
    }

    /// Adds quantities found from rows whose thrust depends on held values: `jacobian` is the
    /// derivative (one row per quantity), `own` the covariance from the rows themselves. Returns
    /// the total covariance.
    pub fn derive(&mut self, found: &[(Known, f64)], jacobian: &[Vec<f64>], own: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let before = self.entries.len();
        let with = |held: &Held, i: usize, l: usize| -> f64 {
            jacobian[i].iter().enumerate().map(|(j, d)| d * held.covariance[j][l]).sum()
        };
        let carried = |held: &Held, i: usize, k: usize| -> f64 {
            jacobian[k].iter().enumerate().map(|(l, d)| d * with(held, i, l)).sum()
        };
        let mut all = vec![vec![0.0; found.len()]; found.len()];
        for (i, (known, value)) in found.iter().enumerate() {
            for k in 0..=i {
                all[i][k] = own[i][k] + carried(self, i, k);
                all[k][i] = all[i][k];
            }
            let row: Vec<f64> = (0..before).map(|l| with(self, i, l)).chain(all[i][..=i].iter().copied()).collect();
            self.know(*known, *value, &row);
        }
        all
    }

    /// Derivative of `values`, found from runs with given losses, with respect to each entry that
    /// the thrust depends on: one row per value.
    pub fn moved_by_thrust<E>(
        &self,
        runs: &[&Run],
        values: impl Fn(&[&Run], &Efficiency) -> Result<Vec<f64>, E>,
    ) -> Result<Vec<Vec<f64>>, E> {
        let usual = values(runs, &self.efficiency)?;
        let mut jacobian = vec![vec![0.0; self.entries.len()]; usual.len()];
        for (k, entry) in self.entries.iter().enumerate() {
            let std = self.covariance[k][k].max(0.0).sqrt();
            if std == 0.0 || matches!(entry.known, Known::Parameter(..)) {
                continue;
            }
            let at = |by: f64| {
                let nominal = self.nominal(runs, Some((k, by)));
                let nominal: Vec<&Run> = nominal.iter().map(AsRef::as_ref).collect();
                values(&nominal, &self.losses(Some((k, by))))
            };
            for (row, (up, down)) in jacobian.iter_mut().zip(at(std)?.into_iter().zip(at(-std)?)) {
                row[k] = (up - down) / (2.0 * std);
            }
        }
        Ok(jacobian)
    }

    /// The entry of a parameter for both directions, as found last.
    pub fn entry_of(&self, parameter: usize) -> Option<usize> {
        self.entries.iter().rposition(|e| e.known == Known::Parameter(parameter, None))
    }

    /// Whether an earlier stage has found this parameter.
    pub fn has(&self, parameter: usize) -> bool {
        self.entries.iter().any(|e| matches!(e.known, Known::Parameter(p, _) if p == parameter))
    }

    /// `model` with the held values; those for positive velocity if they depend on the direction.
    pub fn written(&self, model: &Model) -> Model {
        self.write_to(model, Direction::Positive, None)
    }

    /// Covariance of the first `count` parameters of the model: for each the value found last for
    /// both directions.
    pub fn covariance_of(&self, count: usize) -> Vec<Vec<f64>> {
        let places: Vec<Option<usize>> = (0..count).map(|p| self.entry_of(p)).collect();
        let entry = |a: &Option<usize>, b: &Option<usize>| match (a, b) {
            (Some(a), Some(b)) => self.covariance[*a][*b],
            _ => 0.0,
        };
        places.iter().map(|a| places.iter().map(|b| entry(a, b)).collect()).collect()
    }

    /// The losses, with entry `shifted.0` moved by `shifted.1`.
    fn losses(&self, shifted: Option<(usize, f64)>) -> Efficiency {
        let mut efficiency = self.efficiency.clone();
        if let Some((k, by)) = shifted {
            match (self.entries[k].known, &mut efficiency.eta_adv) {
                (Known::Interaction(i), _) => efficiency.eta_inter.0[i].value += by,
                (Known::Slope, Some(line)) => line.slope += by,
                (Known::Intercept, Some(line)) => line.intercept += by,
                _ => {}
            }
        }
        efficiency
    }

    /// The runs with nominal forces, with entry `shifted.0` moved by `shifted.1`.
    fn nominal<'a>(&self, runs: &[&'a Run], shifted: Option<(usize, f64)>) -> Vec<Cow<'a, Run>> {
        let curve = shifted.and_then(|(k, by)| match self.entries[k].known {
            Known::Curve(i, coefficient) => Some((&self.curves[i], coefficient, by)),
            _ => None,
        });
        let of = |run: &&'a Run| match curve {
            Some((curve, k, by)) => {
                Cow::Owned(with_curve_moved(run, &self.thrusters, curve, &MeasuredCurve::one(k, by)))
            }
            None => Cow::Borrowed(*run),
        };
        runs.iter().map(of).collect()
    }

    /// The runs with effective forces, with entry `shifted.0` moved by `shifted.1`.
    fn effective_thrust<'a>(&self, runs: &[&'a Run], shifted: Option<(usize, f64)>) -> Vec<Cow<'a, Run>> {
        let (efficiency, nominal) = (self.losses(shifted), self.nominal(runs, shifted));
        if efficiency == Efficiency::default() {
            return nominal;
        }
        nominal.iter().map(|run| Cow::Owned(acting_forces(run, &efficiency, &self.thrusters).0)).collect()
    }

    fn directional(&self, model: &Model, dof: Dof) -> bool {
        let here =
            |e: &Entry| matches!(e.known, Known::Parameter(p, Some(_)) if model.parameters[p].place.dof == Some(dof));
        self.entries.iter().any(here)
    }

    /// `model` with the held values for one direction, with entry `shifted.0` moved by `shifted.1`.
    fn write_to(&self, model: &Model, direction: Direction, shifted: Option<(usize, f64)>) -> Model {
        let mut model = model.clone();
        for (k, entry) in self.entries.iter().enumerate() {
            if let Known::Parameter(p, of) = entry.known
                && of.is_none_or(|d| d == direction)
            {
                let shift = shifted.filter(|(at, _)| *at == k).map_or(0.0, |(_, by)| by);
                model.parameters[p].value = entry.value + shift;
            }
        }
        model
    }

    /// Rows of `dof` in which only the parameters `free` are free.
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

    /// Whether the quantity of this entry can change the balance of `dof`: a drag of another degree
    /// of freedom is not in it, but a mass may be, by its Coriolis term.
    fn counts(&self, k: usize, model: &Model, dof: Dof, free: &[usize]) -> bool {
        match self.entries[k].known {
            Known::Parameter(p, _) => {
                let parameter = &model.parameters[p];
                let elsewhere = parameter.place.dof.is_some_and(|d| d != dof) && parameter.effect != id::INERTIA;
                !free.contains(&p) && !elsewhere
            }
            Known::Interaction(i) => self.efficiency.eta_inter.0[i].dof == dof,
            Known::Slope | Known::Intercept | Known::Curve(..) => true,
        }
    }

    /// Fits `free` in the balance of `dof` to runs with nominal forces, everything else held;
    /// `finish` may scale the rows. The covariance includes the uncertainty of the held values.
    pub fn fit(
        &self,
        (dof, runs): (Dof, &[&Run]),
        model: &Model,
        free: &[usize],
        how: How,
        finish: &dyn Fn(&mut Columns),
    ) -> Result<Found, IntegralError> {
        let inertia = model.inertia(dof).filter(|p| free.contains(p));
        let usual = self.effective_thrust(runs, None);
        let solve = |shifted: Option<(usize, f64)>| -> Result<RowFit, IntegralError> {
            let thrust = |k: usize| !matches!(self.entries[k].known, Known::Parameter(..));
            let moved = shifted.filter(|(k, _)| thrust(*k)).map(|_| self.effective_thrust(runs, shifted));
            let acting: Vec<&Run> = moved.as_ref().unwrap_or(&usual).iter().map(AsRef::as_ref).collect();
            let mut columns = self.rows((dof, &acting), model, free, how.regressor, shifted)?;
            finish(&mut columns);
            fit_rows(&columns, inertia, how.std)
                .map_err(|source| IntegralError::Linear { dofs: dof.to_string(), source })
        };
        let mut fit = solve(None)?;
        let n = fit.values.len();
        let mut widening = 1.0;
        if how.few {
            let expected = self.expected((dof, runs), model, &fit, how.regressor, finish)?;
            widening = small_sample::widening((fit.rows - n) as f64, fit.residual_std.powi(2), expected);
            fit.covariance.iter_mut().flatten().for_each(|c| *c *= widening * widening);
        }
        let size = self.entries.len();
        let mut jacobian = vec![vec![0.0; size]; n];
        for k in (0..size).filter(|k| self.counts(*k, model, dof, free)) {
            let std = self.covariance[k][k].max(0.0).sqrt();
            if std > 0.0 {
                let (up, down) = (solve(Some((k, std)))?, solve(Some((k, -std)))?);
                for i in 0..n {
                    jacobian[i][k] = (up.values[i] - down.values[i]) / (2.0 * std);
                }
            }
        }
        for i in 0..n {
            for j in 0..n {
                let carried = |k: usize, l: usize| jacobian[i][k] * self.covariance[k][l] * jacobian[j][l];
                fit.covariance[i][j] += (0..size).map(|k| (0..size).map(|l| carried(k, l)).sum::<f64>()).sum::<f64>();
            }
        }
        Ok(Found { fit, jacobian, widening })
    }
}

fn value_near(signal: &Signal, t: f64) -> f64 {
    signal.values()[signal.time().partition_point(|s| *s < t - 1e-9).min(signal.len() - 1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    /// u̇ = (τ − k u)/m at constant u̇ = 0.1 m/s²: 10 s of a mass of 100 kg with a drag of 20 kg/s.
    fn ramp() -> Run {
        let time: Vec<f64> = (0..=100).map(|k| 0.1 * f64::from(k)).collect();
        let mut run = Run { name: "ramp.csv".into(), ..Run::default() };
        let force: Vec<f64> = time.iter().map(|t| 10.0 + 2.0 * t).collect();
        run.signals
            .insert("u".into(), Signal::new(time.clone().into(), time.iter().map(|t| 0.1 * t).collect::<Vec<_>>()));
        run.signals.insert("tau_u".into(), Signal::new(time.into(), force));
        run
    }

    #[test]
    fn exact_carry_of_a_held_drag() {
        let model = Model::with_effects(&[Dof::Surge], Coriolis::Free, &["inertia", "linear_drag"]).unwrap();
        let (m, k) = (model.parameter_of("inertia@surge").unwrap(), model.parameter_of("linear_drag@surge").unwrap());
        let mut held = Held::default();
        held.know(Known::Parameter(k, None), 20.0, &[4.0]);
        let how = How { regressor: RegressorOptions::default(), std: StdMethod::Paper, few: false };
        let run = ramp();
        let found = held.fit((Dof::Surge, &[&run]), &model, &[m], how, &|_| {}).unwrap();
        assert!((found.fit.values[0] - 100.0).abs() < 1e-6, "no noise: {:?}", found.fit.values);
        // m = Σ R²/Σ Δu R with R = (10 + 2 t − 0.1 k t) Δt = 10 Δt at k = 20 and Δu = 0.1 Δt, so
        // that dm/dk is the mean of −0.1 t/0.1 over 10 s, −5, except for the curvature over one
        // deviation of 2 kg/s
        assert!((found.jacobian[0][0] / -5.0 - 1.0).abs() < 0.01, "{:?}", found.jacobian);
        let added = held.add(&found, &[m], None);
        assert_eq!(added.len(), 1);
        let covariance = held.covariance_of(model.parameters.len());
        assert!((covariance[m][k] - found.jacobian[0][0] * 4.0).abs() < 1e-9);
        assert_eq!(covariance[m][k], covariance[k][m]);
        assert!((covariance[m][m] / (found.jacobian[0][0].powi(2) * 4.0) - 1.0).abs() < 1e-6, "no noise of its own");
    }
}
