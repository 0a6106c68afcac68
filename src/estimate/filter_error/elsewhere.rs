//! Noise and parameters with which runs are filtered that took no part in a fit.
//!
//! ```text
//! σᵢ ← max(σᵢ, 10⁻⁴ rms τᵢ)        T = 1 s if there was no force
//! θ_run = argmax L(first half of the run; θ_run, θ̂, η̂)        for parameters with a value per run
//! ```
//!
//! A filter that takes its parameters as exact and expects no force trusts its model more with
//! every sample. The errors of the parameters make an unstable motion go another way all the same,
//! and such a filter does not recover: with parameters accurate to a part in a thousand, −2 ln L of
//! one run in nine was 819,000; with a random force of a millionth of a newton it is −26,500.

use super::noise::{NoiseModel, RandomForce};
use super::start::{TIME, strength};
use super::{FilterErrorFit, FilterErrorOptions, parameters_under};
use crate::estimate::output_error::OutputErrorError;
use crate::model::{Model, Parameter};
use crate::run::Run;

/// Least random force as a share of the thrust: the force that the errors of the best-known
/// parameters leave. In simulated campaigns without a force, parameters have standard deviations of
/// a ten-thousandth and more.
const LEAST: f64 = 1e-4;

impl NoiseModel {
    /// This noise, with at least the force that errors of the parameters make in every degree of
    /// freedom, for `runs` that took no part in their estimate.
    pub fn elsewhere(&self, model: &Model, runs: &[Run]) -> NoiseModel {
        let of = |dof: &crate::frame::Dof| {
            let least = LEAST * strength(model, runs, *dof);
            match self.forces.iter().find(|f| f.dof == *dof) {
                Some(force) => RandomForce { rms: force.rms.max(least), ..*force },
                None => RandomForce { dof: *dof, rms: least, time: TIME },
            }
        };
        NoiseModel { forces: model.dofs.iter().map(of).collect(), sensors: self.sensors.clone() }
    }
}

/// The first half of each run.
pub(crate) fn first_halves(runs: &[Run]) -> Vec<Run> {
    let half = |run: &Run| run.span().map(|(from, to)| run.between(from, 0.5 * (from + to)));
    runs.iter().filter_map(half).collect()
}

impl FilterErrorFit {
    /// The model for runs that took no part in the fit, with its parameters held. Parameters with a
    /// value per run (the phase of a wave) are estimated from the first half of each run, in the
    /// order of `runs`.
    ///
    /// # Errors
    /// [`OutputErrorError`] when a run lacks what the model reads, or the model diverges there.
    pub(crate) fn on_others(&self, runs: &[Run], options: &FilterErrorOptions) -> Result<Model, OutputErrorError> {
        let mut model = self.model.clone();
        let own = |p: &Parameter| p.spec.per_run && !p.fixed;
        let any = model.parameters.iter().any(own);
        for p in &mut model.parameters {
            p.fixed = !own(p);
            p.per_run.clear();
        }
        if any {
            let noise = self.noise.elsewhere(&model, runs);
            model = parameters_under(&model, &first_halves(runs), (&noise, self.limit), options)?;
        }
        model.parameters.iter_mut().for_each(|p| p.fixed = true);
        Ok(model)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::estimate::filter_error::SensorNoise;
    use crate::frame::Dof;
    use crate::run::Signal;

    /// 20 N are commanded in surge: a force of 1 N stays; without a force, one of 2 mN is added.
    #[test]
    fn a_force_that_is_none_is_a_little_elsewhere() {
        let model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        let mut run = Run::default();
        run.signals.insert("tau_u".into(), Signal::new(vec![0.0, 1.0].into(), vec![20.0, -20.0]));
        let sensors = vec![SensorNoise { std: 0.01, coloured: None }];
        let none = NoiseModel { forces: vec![], sensors: sensors.clone() };
        let runs = [run];
        assert_eq!(none.elsewhere(&model, &runs).forces, [RandomForce { dof: Dof::Surge, rms: 2e-3, time: 1.0 }]);
        let some = NoiseModel { forces: vec![RandomForce { dof: Dof::Surge, rms: 1.0, time: 3.0 }], sensors };
        assert_eq!(some.elsewhere(&model, &runs), some);
    }
}
