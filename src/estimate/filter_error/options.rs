//! Options of the filter-error fit.

use std::collections::BTreeMap;

use crate::estimate::output_error::OutputErrorOptions;
use crate::frame::Dof;

/// What is known beforehand about the random forces.
#[derive(Debug, Clone, PartialEq)]
pub enum Forces {
    /// Estimated, in every degree of freedom.
    Estimate {
        /// Greatest rms by degree of freedom, N or N·m; unbounded in those that are not listed.
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

/// Options of the fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterErrorOptions {
    /// How runs are prepared: longest step, position, given noise of the sensors.
    pub base: OutputErrorOptions,
    /// The random forces.
    pub forces: Forces,
    /// Greatest number of passes of a climb with alternating steps; joint steps have a limit of
    /// their own.
    pub iterations: usize,
    /// The fit has converged when a step would lower −2 ln L by less than this; with `refine` it
    /// goes on to a tenth of it.
    pub tolerance: f64,
    /// Whether forces that the likelihood does not ask for are removed, and sensor noise is
    /// coloured where it asks for that. A likelihood ratio needs the same noise on both sides.
    pub refine: bool,
    /// Fall of −2 ln L by which joint steps of parameters and noise must improve on alternating
    /// steps that got stuck, in order to be taken. The default is the effect of one standard
    /// deviation of one parameter: with less, the place differs but the answer does not. Infinite:
    /// joint steps are not tried, as is right for fits that are compared with each other.
    pub higher: f64,
    /// Standard deviations beyond which innovations are held back; `None` to do so if there are
    /// outliers. A likelihood ratio needs the same limit on both sides.
    pub limit: Option<f64>,
    /// Value of −2 ln L that a fit must have hope of getting below; a fit without hope is given up.
    pub bar: f64,
    /// Whether each step is reported to the observer of the progress.
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
