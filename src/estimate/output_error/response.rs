//! The response of an estimate to other inputs, to first order.
//!
//! ```text
//! Δθ = −(JᵀJ)⁻¹ Jᵀ r'          r': residuals at the estimate, under the other inputs
//! ```

use super::{OutputErrorError, OutputErrorFit, OutputErrorOptions, Problem, normal_factor};
use crate::run::Run;

impl OutputErrorFit {
    /// How far the unknowns move if the same runs have other inputs: one Gauss-Newton step from the
    /// estimate, with free initial states, on the segments of the fit.
    ///
    /// # Errors
    /// [`OutputErrorError`] when a run lacks what the model reads.
    pub fn response(&self, runs: &[Run], options: &OutputErrorOptions) -> Result<Vec<f64>, OutputErrorError> {
        let tracks = Problem::new(&self.model, runs, options)?.tracks;
        let problem = Problem { tracks, ..self.problem.clone() };
        let step = |problem: &Problem| {
            let linearised = problem.linearise(&self.model, &self.initial_states);
            normal_factor(problem, &self.model, &linearised).solve()
        };
        // the step that remains at the estimate itself is subtracted
        let (there, here) = (step(&problem), step(&self.problem));
        Ok(here.iter().zip(&there).map(|(here, there)| here - there).collect())
    }
}
