//! Result of a search: its steps, the names that remain, and the effects that help but get no name.

use super::candidate::Candidate;
use super::constancy::ChangedParameter;
use super::screen::Screen;
use super::task::SearchOptions;
use crate::effects::named;
use crate::estimate::filter_error::FilterErrorFit;
use crate::model::Model;

/// Maximum number of reported names that broke a rule.
pub(super) const BEHAVES: usize = 2;

/// An effect that was added.
#[derive(Debug, Clone)]
pub struct Added {
    /// The candidate.
    pub candidate: Candidate,
    /// Names of other effects that the data allow.
    pub also_possible: Vec<String>,
    /// Fall of −2 ln L by the refit.
    pub gain: f64,
    /// Probability of such a gain by chance, over all candidates.
    pub p_value: f64,
    /// Fall of −2 ln L on held-out runs.
    pub held_out_gain: f64,
    /// Share of its signal that a refit of the model cannot absorb.
    pub left: f64,
    /// Runners-up that broke no rule, each with the model that contained it instead.
    pub(super) rivals: Vec<(Added, Model)>,
}

/// An effect that improves the fit but broke a rule.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct BehavesLike {
    /// `id`, `id@dof` or `id@dof:other`.
    pub id: String,
    /// The broken rule, in words.
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
    /// Name of the added effect; `None` for the baseline.
    pub name: Option<String>,
    /// The fit.
    pub fit: FilterErrorFit,
}

/// Result of the search.
#[derive(Debug, Clone)]
pub struct Search {
    /// The baseline, then one entry per added effect.
    pub steps: Vec<Step>,
    /// Effects in the final model, in the order in which they were added.
    pub added: Vec<Added>,
    /// Names of effects that were added and removed again.
    pub removed: Vec<String>,
    /// Effects that help but broke a rule, the greatest gain first.
    pub behaves_like: Vec<BehavesLike>,
    /// Whether a fit started from the log was better than one started from the last model, which was thus far from
    /// the truth.
    pub astray: bool,
    /// Effect that begins at an instant, if it is all that is missing: nothing is named then.
    pub appeared: Option<ChangedParameter>,
    /// Whether something other than the commands moves the vehicle: nothing is named then.
    pub hopeless: bool,
    /// Candidates whose fit from the log was no better than that from the last model, with the number of steps at
    /// that time.
    pub(super) vain: Vec<(Candidate, usize)>,
    /// Candidates at the last step.
    pub candidates: Vec<Candidate>,
    /// Their scores.
    pub screen: Screen,
}

impl Search {
    /// Whether the maximum number of names ended the search while another candidate was beyond chance.
    pub fn is_cut_short(&self, options: &SearchOptions) -> bool {
        self.added.len() >= options.most && self.screen.asks()
    }

    /// Adds a name and the fit with it. Names that this fit does not contain are removed, and their gain is added to
    /// its gain.
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
