//! What a simulation returns.

/// A simulated run: one row a grid point.
#[derive(Debug, Clone)]
pub struct Trajectory {
    /// Time stamps, s.
    pub time: Vec<f64>,
    /// Outputs, `time.len()` rows of one value an output of the dynamics.
    pub outputs: Vec<f64>,
    /// States, `time.len()` rows.
    pub states: Vec<f64>,
}
