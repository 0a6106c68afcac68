//! Correction of the parameter slopes if those of the Gauss-Newton rows mislead.
//!
//! ```text
//! Rᵀ d = ∂(−ln L)/∂θ
//! R: factor of the rows' information,  d: the right-hand side that they should have had
//! ```
//!
//! The rows of a Gauss-Newton step hold the gain fixed. If a model follows its data badly, or a
//! heading rotates much of the state estimate, their slope leads to points where the likelihood
//! does not rise although it could. The difference from the slope of the likelihood itself
//! ([`super::differences`]) changes slowly from step to step, so it is computed when a step has
//! failed, and kept.

use nalgebra::DMatrix;

use super::noise_steps::NEAR_TOP;
use super::steps::Search;
use crate::estimate::output_error::Fold;

/// Step of the differences, in standard deviations: its square is negligible, and so are roundings
/// of ln L.
const STEP: f64 = 1e-3;

/// Greatest fall of −2 ln L promised by a whole step of the parameters for which the slopes are
/// computed anew after a step that led down: a few standard deviations of each parameter. Farther
/// off, the quadratic fails before the fixed gain matters.
const WORTH_CORRECTING: f64 = 300.0;

/// The slopes of the likelihood minus those of the rows, by unknown.
#[derive(Debug, Clone)]
pub(super) struct SlopeCorrection {
    more: Vec<f64>,
    /// Whether they were computed at the current point.
    pub fresh: bool,
}

impl SlopeCorrection {
    /// The factor with a right-hand side that adds these slopes; unknowns without information keep
    /// their own.
    fn applied(&self, factor: Fold<1>) -> Fold<1> {
        let p = self.more.len();
        let mut right = vec![0.0; p];
        for i in 0..p {
            let pivot = factor.at(i, i)[0];
            let sum: f64 = (0..i).map(|j| factor.at(j, i)[0] * right[j]).sum();
            right[i] = if pivot == 0.0 { 0.0 } else { (self.more[i] - sum) / pivot };
        }
        let mut corrected = factor;
        right.into_iter().enumerate().for_each(|(i, more)| corrected.add(i, p, more));
        corrected
    }
}

impl Search<'_> {
    /// Factor of the information at the current point; its last column has the correction, if there
    /// is one.
    pub(super) fn corrected_factor(&self) -> Fold<1> {
        let factor = self.filtered.factor(&self.model, &self.current);
        match &self.correction {
            Some(correction) => correction.applied(factor),
            None => factor,
        }
    }

    /// Computes the slopes of the likelihood at the current point; their curvature is taken from
    /// the rows, 1 by the scale.
    pub(super) fn correct_slopes(&mut self) {
        let joint = self.joint(Vec::new(), STEP);
        let factor = self.filtered.factor(&self.model, &self.current);
        let p = joint.len();
        let of_rows = |k: usize| (0..=k).map(|i| factor.at(i, k)[0] * factor.at(i, p)[0]).sum::<f64>();
        let (slopes, _) = self.differences(&joint, Some(DMatrix::identity(p, p)));
        let more = (0..p).map(|k| slopes[k] / joint.scales[k] - of_rows(k)).collect();
        self.correction = Some(SlopeCorrection { more, fresh: true });
    }

    /// Reacts to slopes that have led to a lower likelihood. Near the maximum they are computed
    /// anew. Far off, where the quadratic fails or the noise is still to change, an old correction
    /// is dropped, because the slopes of the rows lead farther. Returns whether the slopes have
    /// changed.
    pub(super) fn takes_slopes_anew(&mut self) -> bool {
        if !self.to_the_top() || self.correction.as_ref().is_some_and(|correction| correction.fresh) {
            return false;
        }
        let far = self.correction.take().is_some();
        let promised = self.promised();
        let near = self.noise_moves < NEAR_TOP && (self.tolerance..WORTH_CORRECTING).contains(&promised);
        if near {
            self.correct_slopes();
        }
        near || far
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::estimate::filter_error::tests::{sailed, search};
    use crate::estimate::filter_error::{FilterErrorOptions, filter_error};
    use crate::frame::Dof;
    use crate::model::Model;
    use crate::tank::{BlindOptions, blind};

    /// Only fixes and headings, and a model without quadratic drag: on the way, its rows, which
    /// hold the gain fixed, lead to points where the likelihood does not rise.
    #[test]
    fn a_fit_of_fixes_rests_where_the_likelihood_does() {
        let mut campaign = blind(&BlindOptions { duration: 40.0, ..BlindOptions::default() }).expect("the tank sails");
        campaign
            .runs
            .iter_mut()
            .for_each(|run| run.signals.retain(|name, _| !["u", "v", "r"].contains(&name.as_str())));
        let without: Vec<&str> = vec!["inertia", "linear_drag"];
        let model =
            Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Tied, &without).expect("it is known");
        let options = FilterErrorOptions::default();
        let fit = filter_error(&model, &campaign.runs, &options).expect("the runs determine it");
        assert!(fit.converged);
        let mut search = Search::new(&fit.model, fit.filtered, fit.noise, &options).expect("it does not run away");
        search.limit = fit.limit;
        search.renew();
        search.correct_slopes();
        // a parameter is then at most a third of its standard deviation off
        assert!(search.promised() < 0.1, "{}", search.promised());
    }

    #[test]
    fn a_corrected_factor_has_the_slopes_of_the_likelihood_and_the_information_of_the_rows() {
        let (campaign, options) = (sailed(), FilterErrorOptions::default());
        let mut search = search(&campaign, &options);
        let (rows, joint) = (search.corrected_factor(), search.joint(Vec::new(), STEP));
        search.correct_slopes();
        let corrected = search.corrected_factor();
        let p = joint.len();
        let (slopes, _) = search.differences(&joint, Some(DMatrix::identity(p, p)));
        for k in 0..p {
            let slope: f64 = (0..=k).map(|i| corrected.at(i, k)[0] * corrected.at(i, p)[0]).sum::<f64>();
            let slope = slope * joint.scales[k];
            // equal except for rounding: the triangle has the same numbers
            assert!((slope - slopes[k]).abs() < 1e-9 * slopes[k].abs().max(1.0), "{k}: {slope} {}", slopes[k]);
            assert!((0..=k).all(|i| corrected.at(i, k) == rows.at(i, k)));
        }
        assert!((0..p).any(|i| corrected.at(i, p) != rows.at(i, p)));
    }
}
