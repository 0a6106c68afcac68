//! A velocity compared with the change of its position: factor and lag.
//!
//! ```text
//! η(b) − η(a) = c ∫ own dt + d ∫ others dt + β (b − a)        f = 1/c = logged velocity over dη/dt
//! ```
//!
//! over windows [a, b]; η is an angle or a depth, `own` the rate of η due to the velocity that is judged, `others` that due
//! to all other velocities, β a constant bias. If η comes late, c is taken at its lag.

use super::fit::{Fit, fit};
use super::lag::{self, Lag};
use super::report::Agreement;
use super::samples::{Samples, windows};

/// Least ratio of the variance of the integrated velocity to that of its noise: below it noise would
/// bias c towards zero.
pub const CLEAR: f64 = 50.0;
/// Least share of the change that the velocities must explain.
const EXPLAINED: f64 = 0.7;

/// A velocity and the position that it changes.
pub struct Change<'a> {
    /// Name and samples of the velocity.
    pub velocity: (&'a str, &'a Samples),
    /// Name and samples of the position or angle.
    pub position: (&'a str, &'a Samples),
    /// Rate of the position due to the velocity.
    pub own: Samples,
    /// Rate of the position due to the other velocities.
    pub others: Samples,
    /// Shortest window, s.
    pub window: f64,
}

impl Change<'_> {
    /// Returns the agreement of the two over the windows that pass `usable`; `None` if the velocity does not move clearly
    /// or does not explain the change.
    pub fn agreement(&self, usable: impl Fn(&(f64, f64)) -> bool) -> Option<Agreement> {
        let ((name, velocity), (against, position)) = (self.velocity, self.position);
        let step = position.step().max(velocity.step());
        let width = self.window.max(2.0 * step);
        let still: Vec<_> = windows(&[position, velocity], width, 0.0).into_iter().filter(&usable).collect();
        if !clear(&column(&self.own, &still, 0.0), velocity.noise() * (velocity.step() * width).sqrt()) {
            return None;
        }
        let inner: Vec<_> = windows(&[position, velocity], width, lag::REACH).into_iter().filter(&usable).collect();
        // a positive lag of the position: it shows at t what the velocity showed at t − d
        let lag = lag::least(0.05, |d| self.fit(&inner, d).map(|f| (f.cost, f.rows - f.theta.len())));
        let best = match lag {
            Some(Lag { seconds, .. }) if seconds.abs() > 0.5 * step => self.fit(&inner, seconds)?,
            _ => self.fit(&still, 0.0)?,
        };
        let c = best.theta[0];
        if best.explained < EXPLAINED || c == 0.0 {
            return None;
        }
        Some(Agreement {
            channel: name.to_string(),
            against: format!("d({against})/dt"),
            factor: 1.0 / c,
            std: best.std[0] / (c * c),
            angle: None,
            lag: lag.filter(|l| l.std < 0.2),
        })
    }

    fn fit(&self, windows: &[(f64, f64)], late: f64) -> Option<Fit> {
        let position = self.position.1;
        let target: Vec<f64> = windows.iter().map(|(a, b)| position.at(*b) - position.at(*a)).collect();
        let length: Vec<f64> = windows.iter().map(|(a, b)| b - a).collect();
        let (mine, rest) = (column(&self.own, windows, late), column(&self.others, windows, late));
        let size = |column: &[f64]| column.iter().map(|x| x * x).sum::<f64>();
        // one of the two may be in another unit
        let visible = size(&rest) > 1e-4 * size(&mine).min(size(&target));
        if visible { fit(&[&mine, &length, &rest], &target) } else { fit(&[&mine, &length], &target) }
    }
}

fn column(rate: &Samples, windows: &[(f64, f64)], late: f64) -> Vec<f64> {
    windows.iter().map(|(a, b)| rate.integral(a - late, b - late)).collect()
}

/// Whether the variance of a column is clearly above that of its noise.
pub fn clear(column: &[f64], noise: f64) -> bool {
    let mean = column.iter().sum::<f64>() / column.len().max(1) as f64;
    let variance = column.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / column.len().max(1) as f64;
    variance > CLEAR * noise * noise && variance > 0.0
}
