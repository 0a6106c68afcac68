//! Effects of the surroundings with a value of their own in every run: the current of the day, the
//! ballast of the dive.
//!
//! ```text
//! θ → θ_run        all else as the effect itself has it
//! ```
//!
//! In a run that took no part in a fit the value is that of the run's first half.

use super::bias::Bias;
use super::current::Current;
use super::earth_force::EarthForce;
use super::restoring_force::RestoringForce;
use super::{About, Effect, Instant, ParameterSpec, Place, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;

/// An effect with parameter values of its own in every run.
#[derive(Debug)]
pub struct EachRun {
    of: &'static dyn Effect,
    id: &'static str,
    formula: &'static str,
    meaning: &'static str,
    shown_by: &'static str,
}

impl EachRun {
    /// A current that differs from run to run.
    pub const CURRENT: EachRun = EachRun {
        of: &Current,
        id: "current_each_run",
        formula: "M ν̇_r + C(ν_r)ν_r + D(ν_r)ν_r = τ, ν_r = ν − Rᵀ(V_N, V_E, 0), own V_N, V_E in each run",
        meaning: "Water that moves over ground, differently in every run.",
        shown_by: "several headings in every run, or speeds both well above and below the current",
    };

    /// A force in one compass direction that differs from run to run.
    pub const EARTH_FORCE: EachRun = EachRun {
        of: &EarthForce,
        id: "earth_force_each_run",
        formula: "(X, Y, Z) += Rᵀ(F_N, F_E, 0), own F_N, F_E in each run",
        meaning: "A steady force with a fixed compass direction that differs from run to run: the wind of the day.",
        shown_by: "several headings in every run, at small and at large speeds",
    };

    /// A net weight that differs from run to run.
    pub const WEIGHT: EachRun = EachRun {
        of: &RestoringForce(Dof::Heave),
        id: "weight_each_run",
        formula: "(W − B) cos θ cos φ, own W − B in each run",
        meaning: "Weight minus buoyancy that differs from run to run: the ballast of the dive.",
        shown_by: "runs of different dives in which heave is free",
    };

    /// A constant force that differs from run to run.
    pub const BIAS: EachRun = EachRun {
        of: &Bias,
        id: "bias_each_run",
        formula: "−b, own b in each run",
        meaning: "A constant force that differs from run to run: ballast, trim, cable of the day.",
        shown_by: "runs of different days; motion in both directions separates it from friction",
    };
}

impl Effect for EachRun {
    fn about(&self) -> About<'_> {
        About { id: self.id, formula: self.formula, meaning: self.meaning, shown_by: self.shown_by, ..self.of.about() }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        // a shared parameter would have one value for all runs
        let own = |spec: ParameterSpec| ParameterSpec { shared: None, ..spec }.per_run();
        self.of.parameters(place).into_iter().map(own).collect()
    }

    fn same_in_all_runs(&self) -> Option<&str> {
        Some(self.of.about().id)
    }

    fn pose(&self) -> &'static [&'static str] {
        self.of.pose()
    }

    fn wrench<'g>(
        &self,
        at: &Instant<'g>,
        place: Place,
        theta: &[Expr<'g>],
        memory: &[Expr<'g>],
        wrench: &mut Six<'g>,
    ) {
        self.of.wrench(at, place, theta, memory, wrench);
    }

    fn water<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>]) -> Option<[Expr<'g>; 3]> {
        self.of.water(at, place, theta)
    }
}
