//! Uncertainty of a fit that comes from measured thruster curves and losses: the delta method.
//!
//! ```text
//! cov θ  ←  cov θ + J Σ Jᵀ
//! J = ∂θ̂/∂(a, b, …, η_inter), by a step of one standard deviation of each
//! ```

use super::super::load::{Campaign, moves, with_nominal_forces};
use crate::noise::Noise;
use crate::procedure::{acting_forces, with_curve_moved};
use crate::run::{Run, thruster_command};
use crate::thrust::measured::{MeasuredCurve, Moves};

/// Derivatives of the estimates with respect to the coefficients of one curve: number of the
/// coefficient, and ∂θ̂/∂c.
pub(in crate::campaign) struct Slopes<'a> {
    curve: &'a MeasuredCurve,
    columns: Vec<(usize, Vec<f64>)>,
}

impl Slopes<'_> {
    /// Returns the change of the estimates for a curve drawn from the uncertainty of its table.
    pub fn drawn(&self, noise: &mut Noise) -> Vec<f64> {
        let by = self.curve.drawn(noise);
        let count = self.columns.first().map_or(0, |(_, column)| column.len());
        (0..count).map(|i| self.columns.iter().map(|(k, column)| by[*k] * column[i]).sum()).collect()
    }
}

/// Returns ∂θ̂/∂c of every measured curve through which a run is commanded; `moved` returns the
/// change of each estimate for runs with a changed curve.
pub(in crate::campaign) fn slopes<'a, E>(
    campaign: &'a Campaign,
    runs: &[Run],
    moved: impl Fn(&[Run]) -> Result<Vec<f64>, E>,
) -> Result<Vec<Slopes<'a>>, E> {
    let commanded = |curve: &&MeasuredCurve| {
        runs.iter().any(|run| curve.thrusters.iter().any(|k| run.signal(&thruster_command(*k)).is_some()))
    };
    let mut all = Vec::new();
    for curve in campaign.curves.iter().filter(commanded) {
        let mut columns: Vec<(usize, Vec<f64>)> = Vec::new();
        for k in 0..MeasuredCurve::COEFFICIENTS {
            let std = curve.fit.covariance[k][k].max(0.0).sqrt();
            if std > 0.0 {
                let by = [(curve, MeasuredCurve::one(k, std))];
                let runs: Vec<Run> = runs.iter().map(|run| under(campaign, run, &by)).collect();
                columns.push((k, moved(&runs)?.iter().map(|d| d / std).collect()));
            }
        }
        if !columns.is_empty() {
            all.push(Slopes { curve, columns });
        }
    }
    Ok(all)
}

/// Returns J Σ Jᵀ of curves and losses, row-major by the values that `moved` returns; `None` if
/// none was measured.
pub(super) fn carried<E>(
    campaign: &Campaign,
    runs: &[Run],
    moved: impl Fn(&[Run]) -> Result<Vec<f64>, E>,
) -> Result<Option<Vec<Vec<f64>>>, E> {
    let mut sum: Option<Vec<Vec<f64>>> = None;
    for Slopes { curve, columns } in slopes(campaign, runs, &moved)? {
        let covariance = &curve.fit.covariance;
        let size = columns[0].1.len();
        let sum = sum.get_or_insert_with(|| vec![vec![0.0; size]; size]);
        for (k, left) in &columns {
            for (l, right) in &columns {
                add_product(sum, covariance[*k][*l], left, right);
            }
        }
    }
    for column in by_interaction(campaign, runs, moved)? {
        let size = column.len();
        add_product(sum.get_or_insert_with(|| vec![vec![0.0; size]; size]), 1.0, &column, &column);
    }
    Ok(sum)
}

/// Adds factor · left rightᵀ to `sum`.
fn add_product(sum: &mut [Vec<f64>], factor: f64, left: &[f64], right: &[f64]) {
    for (row, left) in sum.iter_mut().zip(left) {
        for (entry, right) in row.iter_mut().zip(right) {
            *entry += left * factor * right;
        }
    }
}

/// Returns the change of the estimates by one standard deviation of each loss by interaction.
fn by_interaction<E>(
    campaign: &Campaign,
    runs: &[Run],
    moved: impl Fn(&[Run]) -> Result<Vec<f64>, E>,
) -> Result<Vec<Vec<f64>>, E> {
    let mut columns = Vec::new();
    for (k, entry) in campaign.file.efficiency.eta_inter.0.iter().enumerate() {
        let Some(std) = entry.std.filter(|std| *std > 0.0) else { continue };
        let mut efficiency = campaign.file.efficiency.clone();
        efficiency.eta_inter.0[k].value += std;
        let thrusters = &campaign.file.thrusters;
        let acting = |run: Run| if moves(run.kind) { acting_forces(&run, &efficiency, thrusters).0 } else { run };
        let runs: Vec<Run> = with_nominal_forces(runs.to_vec()).into_iter().map(acting).collect();
        columns.push(moved(&runs)?);
    }
    Ok(columns)
}

/// Returns every measured curve with coefficients drawn from the uncertainty of its table.
pub(in crate::campaign) fn drawn<'a>(campaign: &'a Campaign, noise: &mut Noise) -> Vec<(&'a MeasuredCurve, Moves)> {
    campaign.curves.iter().map(|curve| (curve, curve.drawn(noise))).collect()
}

/// Returns the run with the nominal forces of other curves.
pub(in crate::campaign) fn nominal_under(campaign: &Campaign, run: &Run, curves: &[(&MeasuredCurve, Moves)]) -> Run {
    let other =
        |run: Run, (curve, by): &(&MeasuredCurve, Moves)| with_curve_moved(&run, &campaign.file.thrusters, curve, by);
    curves.iter().fold(run.clone(), other)
}

/// Returns the run with the acting forces of other curves.
pub(in crate::campaign) fn under(campaign: &Campaign, run: &Run, curves: &[(&MeasuredCurve, Moves)]) -> Run {
    if curves.is_empty() {
        return run.clone();
    }
    let nominal = nominal_under(campaign, run, curves);
    let (thrusters, efficiency) = (&campaign.file.thrusters, &campaign.file.efficiency);
    if moves(run.kind) { acting_forces(&nominal, efficiency, thrusters).0 } else { nominal }
}

/// Describes the method of the standard deviations, with the part of the curves.
pub(super) fn told(method: &str, carried: bool) -> String {
    let more = if carried { ", with those of the thrusters' curves and losses by the delta method" } else { "" };
    format!("{method}{more}")
}
