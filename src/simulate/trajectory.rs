//! The result of a simulation.

/// A simulated run: one row for each grid point.
#[derive(Debug, Clone)]
pub struct Trajectory {
    /// Time stamps, s.
    pub time: Vec<f64>,
    /// Outputs, `time.len()` rows with one value for each output of the dynamics.
    pub outputs: Vec<f64>,
    /// States, `time.len()` rows.
    pub states: Vec<f64>,
}
