//! Thrust that a propeller loses at speed, by its advance ratio.
//!
//! ```text
//! T = ρ D⁴ n|n| K_T(J),   K_T(J) = K₀ − K₁ J,   J = u/(n D)      →      X −= k |n| u,   k = ρ D³ K₁
//! ```
//!
//! n: turns of the propeller in the unit of the column `propeller_n`. The part at rest,
//! ρ D⁴ K₀ n|n|, is the curve of the thruster. Lewis (ed.), *Principles of Naval Architecture* II
//! (1988), ch. VI; Fossen (2021), ch. 9.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "propeller_advance";

/// Column with the turns of the propeller.
const TURNS: &str = "propeller_n";

/// The loss of thrust with the advance of the propeller.
#[derive(Debug)]
pub struct PropellerAdvance;

impl Effect for PropellerAdvance {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Actuator,
            scope: Scope::Vehicle(&[Dof::Surge]),
            formula: "X −= k |n| u",
            meaning: "Loss of thrust of a propeller as its advance speed grows.",
            source: "Lewis (ed.), Principles of Naval Architecture II (1988), ch. VI",
            shown_by: "a log of the propeller speed (propeller_n); vehicle speed and propeller speed that vary \
                       independently",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear("k_nu", Dimension::new(1, 0, -1))]
    }

    fn channels(&self, _: Place) -> Vec<String> {
        vec![TURNS.into()]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        wrench[0] -= theta[0] * at.channel(TURNS).abs() * at.nu_r[0];
    }
}
