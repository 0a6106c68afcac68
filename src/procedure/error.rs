//! Errors of the procedure, and the errors of a stage that become findings.

use thiserror::Error;

use super::codes;
use crate::estimate::{IntegralError, LeastSquaresError, RegressorError};
use crate::filter::FilterError;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::thrust::efficiency::EfficiencyError;

/// Error of the staged procedure.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProcedureError {
    /// No run takes part in the fit.
    #[error("no run takes part in the fit: at least one needs role = \"train\"")]
    NoTrainingRun,
    /// Losses along the thrusters' own axes need the force of each thruster.
    #[error(
        "[efficiency] advance_speed = \"thruster_axis\" needs [[thruster]] tables and the force or command of each \
         thruster; run `{run}` has only forces on the whole vehicle: log V1 … or F1 …, or use \"vehicle\""
    )]
    AdvanceByThruster {
        /// A run without these forces.
        run: String,
    },
    /// A velocity or an angle cannot be filtered.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// The integral form cannot express a balance or determine its parameters.
    #[error(transparent)]
    Integral(#[from] IntegralError),
    /// Thrust efficiencies that cannot be estimated.
    #[error(transparent)]
    Efficiency(#[from] EfficiencyError),
    /// A linear system without solution.
    #[error("{stage}, {dof}: {source}")]
    Linear {
        /// The stage.
        stage: &'static str,
        /// Degree of freedom.
        dof: Dof,
        /// What is wrong.
        source: LeastSquaresError,
    },
}

impl ProcedureError {
    /// Turns a lack of data in one stage into a finding, so that the other stages go on. A balance
    /// that is not linear in its parameters or has a product of parameters stays an error.
    pub(super) fn unless_data<T>(
        stage: &str,
        dof: Dof,
        result: Result<T, IntegralError>,
    ) -> Result<Result<T, Finding>, Self> {
        use RegressorError as R;
        match result {
            Ok(value) => Ok(Ok(value)),
            Err(IntegralError::Regressor(e @ (R::NeedsOutputError { .. } | R::Product { .. }))) => {
                Err(IntegralError::Regressor(e).into())
            }
            Err(e) => Ok(Err(Finding::new(&codes::TOO_LITTLE, format!("{stage}, {dof}: {e}")))),
        }
    }
}
