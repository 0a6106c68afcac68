//! Results of the innovations window by window, and lasting changes.

use serde::Serialize;

use crate::frame::Dof;

/// One window in one degree of freedom.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Window {
    /// Name of the run.
    pub run: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// Beginning, s.
    pub from: f64,
    /// End, s.
    pub to: f64,
    /// Number of samples.
    pub samples: usize,
    /// Root mean square of the innovations, m/s or rad/s (of a degree of freedom without a logged velocity: m or rad).
    pub rms: f64,
    /// Mean of the innovations, in the same unit.
    pub mean: f64,
    /// Root mean square that the filter expects: random force and noise of the sensor.
    pub noise: f64,
    /// Sum of the squared innovations over their variances.
    pub chi_squared: f64,
    /// Likelihood ratio Λ over its value where the model was fitted: 2 on average without a change.
    pub likelihood_ratio: f64,
    /// Probability of such a ratio without a change.
    pub p_value: f64,
    /// The sum S of the change detector after this window.
    pub cusum: f64,
    /// Whether the difference is large enough to be a change of the vehicle.
    pub large: bool,
    /// Whether the model disagrees in this window: large, and beyond chance in the whole log.
    pub off: bool,
}

/// A lasting change.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// Name of the run.
    pub run: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// Instant at which it began, s: the sample from which on the innovations deviate most.
    pub from: f64,
    /// Root mean square of the innovations from there on, over the expected one.
    pub times_noise: f64,
    /// Mean of the innovations from there on, in the unit of the windows.
    pub shift: f64,
}
