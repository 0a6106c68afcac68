//! Two thrusters whose commands are exchanged, by their plugs for example.
//!
//! ```text
//! τ → τ + (b_T − b_U)(F_U − F_T)
//! ```
//!
//! For thrusters with the same curve, so that exchanged commands mean exchanged forces. b, F:
//! [`super::SingleThruster`].

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, SingleThruster, Six};
use crate::symbolic::Expr;

/// The commands of two thrusters, exchanged.
#[derive(Debug)]
pub struct ThrusterSwap {
    id: String,
    thrusters: [SingleThruster; 2],
}

impl ThrusterSwap {
    /// Its id without thrusters.
    pub const ID: &'static str = "thruster_swap";

    /// The exchange of these two.
    pub fn of(thrusters: [SingleThruster; 2]) -> ThrusterSwap {
        ThrusterSwap { id: format!("{}@{}:{}", ThrusterSwap::ID, thrusters[0].name, thrusters[1].name), thrusters }
    }

    /// The effect without thrusters, as the catalogue lists it.
    pub(super) fn of_none() -> ThrusterSwap {
        ThrusterSwap { id: ThrusterSwap::ID.into(), thrusters: Default::default() }
    }
}

impl Effect for ThrusterSwap {
    fn about(&self) -> About<'_> {
        About {
            id: &self.id,
            family: Family::Actuator,
            scope: Scope::Thrusters,
            formula: "τ += (b_T − b_U)(F_U − F_T)",
            meaning: "The commands of two thrusters, exchanged.",
            source: "Alessandri, Caccia and Veruggio, Control Engineering Practice 7 (1999)",
            shown_by: "commands of the two that differ",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        Vec::new()
    }

    fn channels(&self, _: Place) -> Vec<String> {
        self.thrusters.iter().map(|t| t.channel.clone()).collect()
    }

    fn actuate<'g>(&self, at: &Instant<'g>, _: Place, _: &[Expr<'g>], _: &[Expr<'g>], tau: &mut Six<'g>) {
        let [one, other] = &self.thrusters;
        let wrench = std::array::from_fn(|i| one.wrench[i] - other.wrench[i]);
        let whole = at.graph.constant(1.0);
        for (force, share) in [(other, whole), (one, -whole)] {
            SingleThruster { wrench, ..force.clone() }.push(at, share, tau);
        }
    }
}
