//! Stage (i): loss of thrust by interaction, from bollard-pull runs with load cells.
//!
//! ```text
//! load = η_inter τ_nom
//! ```

use super::result::{Estimate, Stage};
use super::{ProcedureError, prepare};
use crate::estimate::{LeastSquaresOptions, Names, StdMethod, least_squares_with};
use crate::frame::Dof;
use crate::run::{Run, Signal};
use crate::thrust::interaction::{Interaction, fit_interaction};

/// η_inter of `dof` from the runs that log its load cell; `None` when none does.
pub(super) fn stage(dof: Dof, runs: &[&Run]) -> Result<Option<(Stage, Interaction)>, ProcedureError> {
    let (mut nominal, mut load, mut blocks) = (Vec::new(), Vec::new(), Vec::new());
    for run in runs {
        let (Some(cell), Some(command)) = (run.signal(dof.load()), run.signal(dof.force())) else { continue };
        let begin = nominal.len();
        nominal.extend(cell.time().iter().map(|t| prepare::at(command, *t)));
        load.extend_from_slice(Signal::values(cell));
        blocks.push(begin..nominal.len());
    }
    if blocks.is_empty() {
        return Ok(None);
    }
    let fit = fit_interaction(&nominal, &load)?;
    let of_stage = |source| ProcedureError::Linear { stage: "bollard", dof, source };
    let names = Names { columns: vec!["eta_inter".into()], response: Some(dof.load().into()) };
    let options = LeastSquaresOptions { names, ..LeastSquaresOptions::default() };
    let linear = least_squares_with(&[&nominal], &load, &options).map_err(of_stage)?;
    let covariance = linear.covariance_by(StdMethod::Hac, &[&nominal], &load, &blocks).map_err(of_stage)?;
    let std = covariance[0][0].max(0.0).sqrt();
    let estimate = Estimate {
        effect: "thrust_interaction_loss".into(),
        dof: dof.to_string(),
        name: "eta_inter".into(),
        value: fit.value,
        std,
        std_paper: fit.std,
        unit: "1".into(),
    };
    let stage = Stage {
        name: "bollard".into(),
        dof,
        runs: runs.iter().map(|r| r.name.clone()).collect(),
        rows: fit.rows,
        residual_std: fit.residual_std,
        condition_number: linear.condition_number,
        condition_number_scaled: linear.condition_number_scaled,
        estimates: vec![estimate],
        numbers: None,
        warnings: Vec::new(),
    };
    Ok(Some((stage, Interaction { dof, thrusters: Vec::new(), value: fit.value, std: Some(std) })))
}
