//! Result of the staged procedure: plain data, as in `fit --json`.

use serde::Serialize;

use super::bench::Bench;
use super::numbers::FlowNumbers;
use crate::effects::Place;
use crate::estimate::RowFit;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::thrust::efficiency::Efficiency;

/// An estimated quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// Id of the effect.
    pub effect: String,
    /// Degree of freedom, with `:other` for a coupling; empty for the whole vehicle.
    pub dof: String,
    /// Symbol.
    pub name: String,
    /// Value, SI.
    pub value: f64,
    /// Standard deviation, SI, including the uncertainty from earlier stages.
    pub std: f64,
    /// Standard deviation by the paper's (14), of this stage alone, SI.
    pub std_paper: f64,
    /// Unit.
    pub unit: String,
}

/// One stage of the procedure.
#[derive(Debug, Clone, Serialize)]
pub struct Stage {
    /// What was done: `bollard`, `advance`, `towing`, `steady`, `steady clockwise`, `oscillatory`,
    /// `zigzag`, `direct`; followed by the name of the run for a single one of several runs, and by
    /// the names of the thrusters for a group of thrusters.
    pub name: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// Names of the runs that took part.
    pub runs: Vec<String>,
    /// Number of rows.
    pub rows: usize,
    /// Standard deviation of the residual: N or N·m in bollard, steady and towing stages (its
    /// square is the paper's J), m/s or rad/s where the balance is integrated, m/s² or rad/s² in
    /// the direct fit.
    pub residual_std: f64,
    /// cond(HᵀH), as the paper prints.
    pub condition_number: f64,
    /// cond(H) with columns of unit length.
    pub condition_number_scaled: f64,
    /// The estimated quantities.
    pub estimates: Vec<Estimate>,
    /// Covariance of the estimates, in their order, SI.
    pub covariance: Vec<Vec<f64>>,
    /// Flow numbers of a single oscillatory run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub numbers: Option<FlowNumbers>,
    /// Findings about this stage.
    pub warnings: Vec<Finding>,
}

impl Stage {
    /// The estimate with this symbol.
    pub fn estimate(&self, name: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.name == name)
    }

    /// A stage from a fit of rows.
    pub(super) fn of_fit(name: impl Into<String>, dof: Dof, runs: Vec<String>, model: &Model, fit: &RowFit) -> Stage {
        let estimates = fit
            .parameters
            .iter()
            .enumerate()
            .map(|(k, column)| {
                let p = &model.parameters[column.parameter];
                Estimate {
                    effect: p.effect.clone(),
                    dof: place_name(p.place),
                    name: column.name.clone(),
                    value: fit.values[k],
                    std: fit.std(k),
                    std_paper: fit.std_paper[k],
                    unit: p.spec.dimension.to_string(),
                }
            })
            .collect();
        Stage {
            name: name.into(),
            dof,
            runs,
            rows: fit.rows,
            residual_std: fit.residual_std,
            condition_number: fit.condition_number,
            condition_number_scaled: fit.condition_number_scaled,
            estimates,
            covariance: fit.covariance.clone(),
            numbers: None,
            warnings: Vec::new(),
        }
    }
}

fn place_name(place: Place) -> String {
    match (place.dof, place.other) {
        (Some(dof), Some(other)) => format!("{dof}:{other}"),
        (Some(dof), None) => dof.to_string(),
        _ => String::new(),
    }
}

/// Result of all stages.
#[derive(Debug, Clone)]
pub struct StagedResult {
    /// Stages in the order in which they were done.
    pub stages: Vec<Stage>,
    /// The model with the estimated values.
    pub model: Model,
    /// Covariance of the model's parameters, in their order, SI: 0 for those that were not
    /// estimated. Parameters of different stages are correlated through the values that later
    /// stages hold.
    pub covariance: Vec<Vec<f64>>,
    /// Losses of thrust that belong to the estimates: the known ones and those measured with load
    /// cells.
    pub efficiency: Efficiency,
    /// Findings about the whole procedure.
    pub warnings: Vec<Finding>,
}

impl StagedResult {
    /// The result before the first stage: nothing is estimated yet.
    pub(super) fn begun(model: &Model, bench: Bench<'_>) -> StagedResult {
        StagedResult {
            stages: Vec::new(),
            model: model.clone(),
            covariance: Vec::new(),
            efficiency: bench.efficiency.clone(),
            warnings: Vec::new(),
        }
    }

    /// The last stage of this name in this degree of freedom.
    pub fn stage(&self, name: &str, dof: Dof) -> Option<&Stage> {
        self.stages.iter().rev().find(|s| s.name == name && s.dof == dof)
    }
}
