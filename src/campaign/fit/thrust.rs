//! What the deviations of measured thruster curves leave uncertain in a fit: the delta method.
//!
//! ```text
//! cov θ  ←  cov θ + J Σ_curve Jᵀ          J = ∂θ̂/∂(a, b, …), by one deviation of each coefficient
//! ```

use super::super::load::{Campaign, moves};
use crate::procedure::{acting_forces, with_curve_moved};
use crate::run::Run;
use crate::thrust::measured::MeasuredCurve;

/// J Σ Jᵀ, row-major by the values that `moved` gives of runs with a curve moved: how far each estimate is from where it
/// was. `None` where no curve was measured.
pub(super) fn carried<E>(
    campaign: &Campaign,
    runs: &[Run],
    moved: impl Fn(&[Run]) -> Result<Vec<f64>, E>,
) -> Result<Option<Vec<Vec<f64>>>, E> {
    let mut sum: Option<Vec<Vec<f64>>> = None;
    let commanded = |curve: &MeasuredCurve| {
        runs.iter().any(|run| curve.thrusters.iter().any(|k| run.signal(&format!("V{}", k + 1)).is_some()))
    };
    for curve in campaign.curves.iter().filter(|c| commanded(c)) {
        let covariance = &curve.fit.covariance;
        let mut columns: Vec<(usize, Vec<f64>)> = Vec::new();
        for k in 0..MeasuredCurve::COEFFICIENTS {
            let std = covariance[k][k].max(0.0).sqrt();
            if std > 0.0 {
                let runs: Vec<Run> = runs.iter().map(|run| with(campaign, run, curve, k, std)).collect();
                columns.push((k, moved(&runs)?.iter().map(|d| d / std).collect()));
            }
        }
        let Some(size) = columns.first().map(|(_, column)| column.len()) else { continue };
        let sum = sum.get_or_insert_with(|| vec![vec![0.0; size]; size]);
        for (k, left) in &columns {
            for (l, right) in &columns {
                for i in 0..size {
                    for j in 0..size {
                        sum[i][j] += left[i] * covariance[*k][*l] * right[j];
                    }
                }
            }
        }
    }
    Ok(sum)
}

/// The run with the forces that act, one coefficient of a curve moved.
fn with(campaign: &Campaign, run: &Run, curve: &MeasuredCurve, coefficient: usize, by: f64) -> Run {
    let thrusters = &campaign.file.thrusters;
    let nominal = with_curve_moved(run, thrusters, curve, coefficient, by);
    if moves(run.kind) { acting_forces(&nominal, &campaign.file.efficiency, thrusters).0 } else { nominal }
}

/// How the standard deviations came about, with the curves' part in it.
pub(super) fn told(method: &str, carried: bool) -> String {
    let more = if carried { ", with those of the thrusters' curves by the delta method" } else { "" };
    format!("{method}{more}")
}
