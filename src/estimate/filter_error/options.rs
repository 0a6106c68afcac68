//! Options of the filter-error fit, and what can go wrong.

use std::collections::BTreeMap;

use crate::estimate::output_error::OutputErrorOptions;
use crate::frame::Dof;

/// What is known of the random forces beforehand.
#[derive(Debug, Clone, PartialEq)]
pub enum Forces {
    /// Estimated, in every degree of freedom.
    Estimate {
        /// Greatest rms by degree of freedom, N or N·m; no bound in those that are not listed.
        most: BTreeMap<Dof, f64>,
    },
    /// There are none.
    None,
    /// Held: rms by degree of freedom, N or N·m, and their correlation time, s.
    Held {
        /// Rms by degree of freedom; none in those that are not listed.
        rms: BTreeMap<Dof, f64>,
        /// Correlation time, s.
        time: f64,
    },
}

impl Default for Forces {
    fn default() -> Forces {
        Forces::Estimate { most: BTreeMap::new() }
    }
}

impl Forces {
    /// Whether they are estimated.
    pub fn is_estimated(&self) -> bool {
        matches!(self, Forces::Estimate { .. })
    }
}

/// How the fit is done.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterErrorOptions {
    /// How runs are made ready: longest step, position, stated noise of the sensors.
    pub base: OutputErrorOptions,
    /// The random forces.
    pub forces: Forces,
    /// Greatest number of passes that linearise where steps are taken in turns, and of steps together after that.
    pub iterations: usize,
    /// Converged when a step would lower −2 ln L by less than this; a fit with `refine` goes on to a tenth of it.
    pub tolerance: f64,
    /// Whether forces that the likelihood does not ask for are taken out, and sensors' noise is given colour where it
    /// does. A ratio of likelihoods wants the same noise on both sides.
    pub refine: bool,
    /// −2 ln L by which steps of parameters and noise together have to lead higher than steps in turns that have stuck on the way,
    /// to be taken: a deviation of one parameter, as by less the place is another and the answer the same. Infinite:
    /// they are not tried, as is right for fits that are held against each other.
    pub higher: f64,
    /// Deviations beyond which innovations are held back; `None` to do so where there are outliers. A ratio of likelihoods
    /// wants the same on both sides.
    pub limit: Option<f64>,
    /// −2 ln L that a fit has to give hope of coming below: one that does not is given up.
    pub bar: f64,
    /// Whether each step is told to who watches.
    pub told: bool,
}

impl Default for FilterErrorOptions {
    fn default() -> FilterErrorOptions {
        let base = OutputErrorOptions::default();
        FilterErrorOptions {
            base,
            forces: Forces::default(),
            iterations: 120,
            tolerance: 1e-2,
            refine: true,
            higher: 1.0,
            limit: None,
            bar: f64::INFINITY,
            told: false,
        }
    }
}
