//! What a search has found: the steps it took, the names that stand, and what helped and is no name.

use super::candidate::Candidate;
use super::constancy::ChangedParameter;
use super::screen::Screen;
use super::task::SearchOptions;
use crate::effects::named;
use crate::estimate::filter_error::FilterErrorFit;
use crate::model::Model;

/// Names that broke a rule and are told.
pub(super) const BEHAVES: usize = 2;

/// An effect that was added.
#[derive(Debug, Clone)]
pub struct Added {
    /// The candidate.
    pub candidate: Candidate,
    /// Names of the others that the data allow.
    pub also_possible: Vec<String>,
    /// Fall of −2 ln L by the refit.
    pub gain: f64,
    /// Probability of as much by chance, of all candidates.
    pub p_value: f64,
    /// Fall of −2 ln L on the runs that took no part.
    pub held_out_gain: f64,
    /// Share of its signal that a refit of the model leaves.
    pub left: f64,
    /// What came second to it and broke no rule, each with the model that held it in its stead.
    pub(super) rivals: Vec<(Added, Model)>,
}

/// What helped and broke a rule.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct BehavesLike {
    /// `id`, `id@dof` or `id@dof:other`.
    pub id: String,
    /// Which rule, in words.
    pub why: String,
    /// Fall of −2 ln L.
    pub gain: f64,
}

impl BehavesLike {
    /// `behaves like the Munk moment (coriolis_yaw), but …`.
    pub fn told(&self) -> String {
        format!("behaves like {}, but {}", named(&self.id), self.why)
    }
}

/// One state of the search.
#[derive(Debug, Clone)]
pub struct Step {
    /// Name of what was added; `None` for the baseline.
    pub name: Option<String>,
    /// The fit.
    pub fit: FilterErrorFit,
}

/// What the search found.
#[derive(Debug, Clone)]
pub struct Search {
    /// Baseline, then one entry an effect added.
    pub steps: Vec<Step>,
    /// Effects that stand in the final model, in the order in which they came.
    pub added: Vec<Added>,
    /// Names of effects that were added and dropped again.
    pub removed: Vec<String>,
    /// What helped and broke a rule, the most helpful first.
    pub behaves_like: Vec<BehavesLike>,
    /// Whether a fit from the log was better than one from the last model: that one was far from the truth.
    pub astray: bool,
    /// What has begun at an instant, where that is all that is missing: nothing is named then.
    pub appeared: Option<ChangedParameter>,
    /// Whether what moves the vehicle is not its commands: nothing is named then.
    pub hopeless: bool,
    /// Candidates whose fit from the log has led no farther than that from the last model, and after how many steps.
    pub(super) vain: Vec<(Candidate, usize)>,
    /// Candidates at the last step.
    pub candidates: Vec<Candidate>,
    /// Their scores.
    pub screen: Screen,
}

impl Search {
    /// Whether the greatest number of names has ended it while another candidate was beyond chance.
    pub fn is_cut_short(&self, options: &SearchOptions) -> bool {
        self.added.len() >= options.most && self.screen.asks()
    }

    /// Takes a name, and the fit with it. Names that stand and are not in that go, and what they had gained it gains.
    pub(super) fn take(&mut self, mut name: Added, fit: FilterErrorFit) {
        let stands = |a: &Added| fit.model.term(&a.candidate.name()).is_some();
        for lost in self.added.extract_if(.., |a| !stands(a)) {
            name.gain += lost.gain;
            self.removed.push(lost.candidate.name());
        }
        self.steps.push(Step { name: Some(name.candidate.name()), fit });
        self.added.push(name);
    }

    /// Whether a candidate has been fitted from the log in vain beside fewer names.
    pub(super) fn was_in_vain(&self, candidate: &Candidate) -> bool {
        // the leading product of a Coriolis row and the row have one name
        let is_it = |other: &Candidate| {
            (other.name(), other.has_parameters()) == (candidate.name(), candidate.has_parameters())
        };
        self.vain.iter().any(|(other, steps)| *steps < self.steps.len() && is_it(other))
    }

    /// The final fit.
    pub fn last_fit(&self) -> &FilterErrorFit {
        &self.steps[self.steps.len() - 1].fit
    }
}
