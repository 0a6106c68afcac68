//! Inertia that grows with the amplitude of the motion.
//!
//! ```text
//! mᵢ → mᵢ + c KC,      KC = U_m T / L_c
//! ```
//!
//! c: kg (kg·m²) per unit of the Keulegan-Carpenter number of the run; U_m: greatest speed of the run, m/s;
//! T: period, s; L_c: characteristic length, m. Avila et al. (2013), eq. 22 and Table 5.

use super::parameter::{force, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six, channel};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "added_mass_amplitude";

/// Added mass that depends on the amplitude of the oscillation.
#[derive(Debug)]
pub struct AddedMassAmplitude;

impl Effect for AddedMassAmplitude {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Body,
            scope: Scope::Each(&Dof::ALL),
            formula: "mᵢ → mᵢ + c KC",
            meaning: "Added mass that depends on the amplitude of the oscillation.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), Table 5",
            shown_by: "oscillations of different amplitude or period",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        let dimension = force(dof).over(velocity(dof)).times(Dimension::TIME);
        vec![ParameterSpec::linear(format!("c_KC{}", dof.velocity()), dimension)]
    }

    fn channels(&self, place: Place) -> Vec<String> {
        vec![channel::keulegan_carpenter(place.here())]
    }

    fn momentum<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], momentum: &mut Six<'g>) {
        let dof = place.here();
        momentum[dof.index()] += theta[0] * at.channel(&channel::keulegan_carpenter(dof)) * at.nu_r[dof.index()];
    }
}
