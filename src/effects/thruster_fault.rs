//! A thruster that fails at some time of the run.
//!
//! ```text
//! τᵢ → (1 − k) τᵢ   from t₀ on
//! ```
//!
//! k: 1; t₀: time of the run, s. The edge is a tenth of a second wide, so that t₀ can be refined.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Half width of the edge, s.
const EDGE: f64 = 0.05;

/// A loss of thrust from an instant on.
#[derive(Debug)]
pub struct ThrusterFault;

impl Effect for ThrusterFault {
    fn about(&self) -> About<'_> {
        About {
            id: "thruster_fault",
            family: Family::Actuator,
            scope: Scope::Each(&Dof::ALL),
            formula: "τᵢ → (1 − k) τᵢ   from t₀ on",
            meaning: "A loss of thrust from some instant on.",
            source: "Alessandri, Caccia and Veruggio, Control Engineering Practice 7 (1999)",
            shown_by: "a run that continues before and after",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let v = place.here().velocity();
        let grid: Vec<f64> = (1..24).map(|k| 5.0 * f64::from(k)).collect();
        vec![
            ParameterSpec::linear(format!("k_fault{v}"), Dimension::ONE),
            ParameterSpec::shape(format!("t_fault{v}"), Dimension::TIME, &grid, 0.0, 1e6),
        ]
    }

    fn actuate<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], tau: &mut Six<'g>) {
        let i = place.here().index();
        let failed = (((at.time - theta[1]) / at.unit(Dimension::TIME, EDGE)).tanh() + 1.0) * 0.5;
        tau[i] = tau[i] - theta[0] * failed * tau[i];
    }
}
