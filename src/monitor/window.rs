//! What innovations say window by window, and of the whole.

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
    /// Σ of the squared innovations over their variances.
    pub chi_squared: f64,
    /// Likelihood ratio Λ over what it was where the model was fitted: 2 on the average where nothing has changed.
    pub likelihood_ratio: f64,
    /// Probability of so much where nothing has changed.
    pub p_value: f64,
    /// The sum S of the change detector after this window.
    pub cusum: f64,
    /// Whether the difference is large enough to be one of the vehicle.
    pub large: bool,
    /// Whether the window is off: large, and beyond chance in the whole log.
    pub off: bool,
}

/// A lasting change.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// Name of the run.
    pub run: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// When it began, s: the sample from which on the innovations differ most.
    pub from: f64,
    /// Root mean square of the innovations over what is expected, from there on.
    pub times_noise: f64,
    /// Mean of the innovations from there on, in the unit of the windows.
    pub shift: f64,
}
