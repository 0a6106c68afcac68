//! A random force that is not commanded: turbulence, a tether in the current, waves reflected by
//! the walls.
//!
//! ```text
//! τᵢ → τᵢ + σᵢ d(t)        d: normal numbers at the ticks of the control, linear between them
//! ```
//!
//! White from tick to tick, or AR(1) with a correlation time. It enters the balance as an effect
//! that reads a channel.

use super::Noise;
use crate::effects::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Strength and correlation time of a disturbance.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Disturbance {
    /// Standard deviation in each degree of freedom, N and N·m.
    pub std: [f64; 6],
    /// Correlation time, s; 0 for independent values at every tick.
    pub correlation: f64,
}

impl Disturbance {
    /// Force at the ticks 0 to `ticks` in one degree of freedom, N or N·m.
    pub(super) fn forces(&self, dof: Dof, ticks: usize, period: f64, noise: &mut Noise) -> Vec<f64> {
        let colour = if self.correlation > 0.0 { (-period / self.correlation).exp() } else { 0.0 };
        noise.coloured(ticks + 1, colour).into_iter().map(|d| d * self.std[dof.index()]).collect()
    }
}

/// Name of the channel of the disturbing force in `dof`.
pub(super) fn channel_of(dof: Dof) -> String {
    format!("disturbance_{}", dof.velocity())
}

/// The disturbing force, read from its channel.
#[derive(Debug)]
pub(super) struct DisturbingForce;

impl Effect for DisturbingForce {
    fn about(&self) -> About<'_> {
        About {
            id: "disturbing_force",
            family: Family::Environment,
            scope: Scope::Each(&Dof::ALL),
            formula: "d(t)",
            meaning: "A random force that nobody commands.",
            source: "Ljung, System Identification, 2nd ed. (1999), ch. 4",
            shown_by: "nothing: it is not logged",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        Vec::new()
    }

    fn channels(&self, place: Place) -> Vec<String> {
        vec![channel_of(place.here())]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, _: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let dof = place.here();
        let unit = if dof.is_rotation() { Dimension::MOMENT } else { Dimension::FORCE };
        wrench[dof.index()] += at.channel(&channel_of(dof)) * at.unit(unit, 1.0);
    }
}
