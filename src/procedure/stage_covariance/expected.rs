//! Variance of the rows of means that the noise of the samples predicts.
//!
//! ```text
//! s₀² = mean over rows of Σ_c (∂e/∂c)² σ_c²/n    c: each logged channel; n samples of noise σ_c per window
//! ```
//!
//! Computed through the regressors themselves: one channel of a window at a time moves by the
//! standard deviation of its mean.

use super::Held;
use crate::estimate::{Columns, IntegralError, RegressorOptions, RowFit, SteadyWindow, noise_of_mean};
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, Signal};

impl Held {
    /// Predicted variance of the rows of means, from the noise of the samples in each mean; average
    /// over the rows, in the unit of a row squared.
    pub(super) fn expected(
        &self,
        (dof, runs): (Dof, &[&Run]),
        model: &Model,
        fit: &RowFit,
        options: RegressorOptions,
        finish: &dyn Fn(&mut Columns),
    ) -> Result<f64, IntegralError> {
        let free: Vec<usize> = fit.parameters.iter().map(|c| c.parameter).collect();
        let residual = |run: &Run| -> Result<Vec<f64>, IntegralError> {
            let acting = self.effective_thrust(&[run], None);
            let acting: Vec<&Run> = acting.iter().map(AsRef::as_ref).collect();
            let mut columns = self.rows((dof, &acting), model, &free, options, None)?;
            finish(&mut columns);
            let of = |row: usize| {
                let told = fit
                    .parameters
                    .iter()
                    .zip(&fit.values)
                    .filter_map(|(c, value)| Some(columns.columns[columns.column_of(c.parameter)?][row] * value));
                columns.rhs[row] - told.sum::<f64>()
            };
            Ok((0..columns.rows()).map(of).collect())
        };
        let (mut sum, mut rows) = (0.0, 0);
        for run in runs {
            let Some((from, to)) = run.signal(dof.velocity()).and_then(ends) else { continue };
            let here = residual(run)?;
            rows += here.len();
            for channel in Dof::ALL.into_iter().flat_map(|dof| [dof.velocity(), dof.position(), dof.force()]) {
                let Some(signal) = run.signal(channel) else { continue };
                let noise = noise_of_mean(signal, SteadyWindow { from, to }).filter(|noise| *noise > 0.0);
                let Some(noise) = noise else { continue };
                let moved = signal.values().iter().map(|x| x + noise).collect::<Vec<_>>();
                let mut other = (*run).clone();
                other.signals.insert(channel.into(), Signal::new(signal.shared_time().clone(), moved));
                sum += residual(&other)?.iter().zip(&here).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            }
        }
        Ok(if rows > 0 { sum / rows as f64 } else { 0.0 })
    }
}

/// First and last time stamp, s.
fn ends(signal: &Signal) -> Option<(f64, f64)> {
    Some((*signal.time().first()?, *signal.time().last()?))
}
