//! The `[fit]` table: the estimator and its options.

use serde::{Deserialize, Serialize};

use crate::estimate::output_error::{Loss, OutputErrorOptions};

/// Method of estimation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    /// Maximum likelihood for a model with a random force.
    FilterError,
    /// Output error on segments: simulation against measurement.
    OutputError,
    /// The paper's procedure, stage by stage.
    Staged,
    /// Integral least squares on all runs at once.
    Integral,
}

impl Estimator {
    /// Returns the name in a campaign and in results.
    pub const fn name(self) -> &'static str {
        ["filter_error", "output_error", "staged", "integral"][self as usize]
    }
}

/// Options of the fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FitTable {
    /// The estimator. If absent: `staged` if bollard or towing runs take part together with runs
    /// that show every drag at constant speed; otherwise `filter_error`, because its intervals also
    /// hold for a vehicle with a random force, with the losses of thrust that bollard runs show.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimator: Option<Estimator>,
    /// Length of the segments of output error, s.
    pub segment: f64,
    /// Longest step of the integrator, s; in any case at most half of the shortest time constant
    /// of the motion. If absent: 0.1, or a fifth of that time constant if that is longer and every
    /// velocity is logged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longest_step: Option<f64>,
    /// Loss function of the residuals of output error: `squares`, or if outliers are feared `huber`
    /// or `student`.
    pub loss: Loss,
    /// Whether output error joins segments to whole runs if the data allow it. True: its errors
    /// then come near the Cramér-Rao bound; a run with an unknown disturbance keeps its segments in
    /// any case.
    pub join: bool,
}

impl Default for FitTable {
    fn default() -> FitTable {
        let OutputErrorOptions { segment, longest_step, loss, .. } = OutputErrorOptions::default();
        FitTable { estimator: None, segment, longest_step, loss, join: true }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_estimator_reads_by_name() {
        let table: FitTable = toml::from_str("estimator = 'staged'\nsegment = 5.0\nloss = 'huber'").unwrap();
        assert_eq!(table.estimator.map(Estimator::name), Some("staged"));
        assert_eq!((table.loss, table.join), (Loss::Huber, true));
        assert_eq!(toml::from_str::<FitTable>(&toml::to_string(&table).unwrap()).unwrap(), table);
        assert!(toml::from_str::<FitTable>("estimator = 'magic'").is_err());
    }
}
