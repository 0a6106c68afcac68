//! Thrust that follows the supply voltage.
//!
//! ```text
//! τ → τ (V/V_ref)ⁿ
//! ```
//!
//! n: 1; V_ref: mean supply voltage of the campaign, V. Thrust grows with the square of the
//! propeller's speed, which grows with the voltage.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six, channel};
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Thrust that falls with the battery.
#[derive(Debug)]
pub struct SupplyVoltage;

impl Effect for SupplyVoltage {
    fn about(&self) -> About<'_> {
        About {
            id: "supply_voltage",
            family: Family::Actuator,
            scope: Scope::Everywhere,
            formula: "τ → τ (V/V_ref)ⁿ",
            meaning: "Thrust that falls with the battery.",
            source: "Blue Robotics T200 public bollard-pull data (2019): 28.7 N at 10 V, 65.9 N at 20 V",
            shown_by: "a log of the supply voltage that varies",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::shape("n_supply", Dimension::ONE, &[1.0], -4.0, 6.0)]
    }

    fn channels(&self, _: Place) -> Vec<String> {
        vec![channel::SUPPLY_RATIO.into()]
    }

    fn actuate<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], tau: &mut Six<'g>) {
        let factor = at.channel(channel::SUPPLY_RATIO).pow(theta[0]);
        for dof in &at.dofs {
            tau[dof.index()] = tau[dof.index()] * factor;
        }
    }
}
