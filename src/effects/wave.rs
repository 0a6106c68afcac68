//! A wave of one period, with a phase of its own in each run.
//!
//! ```text
//! wᵢ += a sin(2πt/T) + b cos(2πt/T)
//! ```
//!
//! a, b: N (N·m), of each run; T: period, s; t: time of the run, s.

use super::parameter::force;
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Periods to try, s: so close that a run of a minute misses none in between.
const PERIODS: [f64; 24] = [
    1.5, 1.75, 2.0, 2.25, 2.5, 2.8, 3.1, 3.4, 3.8, 4.2, 4.6, 5.1, 5.6, 6.2, 6.8, 7.5, 8.3, 9.2, 10.2, 11.4, 12.8, 14.5,
    17.0, 20.0,
];

/// A periodic force from outside.
#[derive(Debug)]
pub struct Wave;

impl Effect for Wave {
    fn about(&self) -> About<'_> {
        About {
            id: "wave",
            family: Family::Environment,
            scope: Scope::Each(&Dof::ALL),
            formula: "a sin(2πt/T) + b cos(2πt/T), own phase in each run",
            meaning: "A periodic force from outside.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 10",
            shown_by: "runs of several periods, with commands of other periods",
        }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let dof = place.here();
        let v = dof.velocity();
        vec![
            ParameterSpec::linear(format!("a_wave{v}"), force(dof)).per_run(),
            ParameterSpec::linear(format!("b_wave{v}"), force(dof)).per_run(),
            ParameterSpec::shape(format!("T_wave{v}"), Dimension::TIME, &PERIODS, 0.5, 100.0),
        ]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let phase = at.time / theta[2] * std::f64::consts::TAU;
        wrench[place.here().index()] += theta[0] * phase.sin() + theta[1] * phase.cos();
    }
}
