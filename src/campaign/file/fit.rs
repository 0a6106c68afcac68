//! The `[fit]` table: which estimator, and how it works.

use serde::{Deserialize, Serialize};

use crate::estimate::output_error::{Loss, OutputErrorOptions};

/// How parameters are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    /// Maximum likelihood of a model with a random force.
    FilterError,
    /// Output error on segments: simulation against measurement.
    OutputError,
    /// The paper's procedure, stage by stage.
    Staged,
    /// Integral least squares on all runs at once.
    Integral,
}

impl Estimator {
    /// Name as in a campaign and in results.
    pub const fn name(self) -> &'static str {
        ["filter_error", "output_error", "staged", "integral"][self as usize]
    }
}

/// Options of the fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FitTable {
    /// The estimator. When absent: `staged` where bollard or towing runs take part beside runs that show every drag at
    /// constant speed; `filter_error` otherwise, for its intervals hold where a vehicle is pushed, too, with the losses of
    /// thrust that bollard runs show.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimator: Option<Estimator>,
    /// Length of the segments of output error, s.
    pub segment: f64,
    /// Longest step of the integrator, s; at most half of the quickest time constant of the motion in any case. When absent:
    /// 0.1, or a fifth of that time constant where that is longer and every velocity is logged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longest_step: Option<f64>,
    /// What a residual of output error costs: `squares`, or where outliers are feared `huber` or `student`.
    pub loss: Loss,
    /// Whether output error joins segments to whole runs where the data allow it. True: its errors then come near the
    /// Cramér-Rao bound; a run that something unknown disturbs keeps its segments by itself.
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
