//! Thrust that follows the command with a lag, the same in every degree of freedom.
//!
//! ```text
//! τᵢ → zᵢ,   T żᵢ = τᵢ − zᵢ
//! ```
//!
//! T: time constant, s. The paper measures a settling time of 0.1 s; Yoerger, Cooke and Slotine (1990).

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "thrust_lag";

/// A lag of first order between command and thrust.
#[derive(Debug)]
pub struct ThrustLag;

impl Effect for ThrustLag {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Actuator,
            scope: Scope::Everywhere,
            formula: "τᵢ → zᵢ,   T żᵢ = τᵢ − zᵢ",
            meaning: "A first-order lag between command and thrust.",
            source: "Yoerger, Cooke and Slotine, IEEE Journal of Oceanic Engineering 15 (1990)",
            shown_by: "commands that change within a few time constants",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::shape("T_lag", Dimension::TIME, &[0.15, 0.3, 0.6, 1.2, 2.4], 0.02, 20.0)]
    }

    fn actuate<'g>(&self, at: &Instant<'g>, _: Place, _: &[Expr<'g>], memory: &[Expr<'g>], tau: &mut Six<'g>) {
        for (dof, z) in at.dofs.iter().zip(memory) {
            tau[dof.index()] = *z;
        }
    }

    fn memory<'g>(&self, at: &Instant<'g>, _: Place, tau: &Six<'g>) -> Vec<Expr<'g>> {
        at.dofs.iter().map(|dof| tau[dof.index()]).collect()
    }

    fn memory_rate<'g>(
        &self,
        at: &Instant<'g>,
        _: Place,
        theta: &[Expr<'g>],
        memory: &[Expr<'g>],
        tau: &Six<'g>,
    ) -> Vec<Expr<'g>> {
        at.dofs.iter().zip(memory).map(|(dof, z)| (tau[dof.index()] - *z) / theta[0]).collect()
    }
}
