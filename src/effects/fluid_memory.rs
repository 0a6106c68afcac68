//! Fluid memory: a force that remembers earlier speed.
//!
//! ```text
//! wᵢ −= k z,      T ż = νᵢ − z
//! ```
//!
//! k: kg/s (kg·m²/s), at least 0: a wake feeds no energy to the motion; T: time constant, s; z:
//! filtered velocity. The simplest state-space form of Cummins' convolution (Cummins 1962; Fossen
//! 2021, ch. 5).

use super::parameter::{force, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "fluid_memory";

/// A drag that follows the speed with a delay: wake and radiation memory.
#[derive(Debug)]
pub struct FluidMemory;

impl Effect for FluidMemory {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Body,
            scope: Scope::Each(&Dof::ALL),
            formula: "−k z, T ż = νᵢ − z",
            meaning: "A drag that follows the speed with a delay: wake and radiation memory.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 5",
            shown_by: "speed that changes within a few time constants, at several periods",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        vec![
            ParameterSpec::linear(format!("k_mem{}", dof.velocity()), force(dof).over(velocity(dof))).at_least(0.0),
            ParameterSpec::shape(format!("T_mem{}", dof.velocity()), Dimension::TIME, &[1.0, 3.0, 8.0], 0.1, 60.0),
        ]
    }

    fn wrench<'g>(&self, _: &Instant<'g>, place: Place, theta: &[Expr<'g>], memory: &[Expr<'g>], wrench: &mut Six<'g>) {
        wrench[place.here().index()] -= theta[0] * memory[0];
    }

    fn memory<'g>(&self, at: &Instant<'g>, place: Place, _: &Six<'g>) -> Vec<Expr<'g>> {
        vec![at.nu_r[place.here().index()]]
    }

    fn memory_rate<'g>(
        &self,
        at: &Instant<'g>,
        place: Place,
        theta: &[Expr<'g>],
        memory: &[Expr<'g>],
        _: &Six<'g>,
    ) -> Vec<Expr<'g>> {
        vec![(at.nu_r[place.here().index()] - memory[0]) / theta[1]]
    }
}
