//! Input of a search: the runs, the options of the fit and of the search.

use std::sync::Arc;

use super::candidate::{Candidate, candidates};
use super::screen::{Screen, screen};
use crate::effects::{Effect, Family, Place, Scope};
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions};
use crate::estimate::output_error::OutputErrorError;
use crate::model::Model;
use crate::progress;
use crate::run::Run;

/// Difference in −2 ln L within which two names are both possible: three standard deviations of it for one signal.
pub(super) const TIE: f64 = 9.0;

/// Fall of −2 ln L below which refits of rivals stop: small beside the differences that decide between them.
pub(super) const ROUGH: f64 = 0.5;

/// Options of the search.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchOptions {
    /// Probability of a name where nothing is missing, before the test on held-out runs.
    pub level: f64,
    /// Maximum number of effects to add.
    pub most: usize,
    /// Families of the catalogue that are searched; users' own effects are always searched.
    pub families: Vec<Family>,
    /// Seed of all random draws.
    pub seed: u64,
}

impl Default for SearchOptions {
    fn default() -> SearchOptions {
        let families = vec![Family::Body, Family::Actuator, Family::Environment, Family::Sensor];
        SearchOptions { level: 0.01, most: 5, families, seed: 1 }
    }
}

/// Input of the search.
pub(super) struct Task<'a> {
    pub train: &'a [Run],
    pub held: &'a [Run],
    pub own: &'a [(Arc<dyn Effect>, Place)],
    pub fitting: &'a FilterErrorOptions,
    pub options: &'a SearchOptions,
}

/// The scores of `list` beside a fit ([`screen`]).
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub(super) fn screened(fit: &FilterErrorFit, list: &[Candidate], task: &Task<'_>) -> Result<Screen, OutputErrorError> {
    progress::tell(format!("judging {} candidates", list.len()), 0, 0);
    screen(fit, task.train, list, &task.fitting.base, (task.options.level, task.options.seed))
}

/// Candidates of the searched families, and the user's own.
pub(super) fn asked(model: &Model, task: &Task<'_>) -> Vec<Candidate> {
    let mut list = candidates(model, task.train, task.own);
    // a campaign also defines its thrusters, but their effects are those of the catalogue
    let of_user = |c: &Candidate| {
        let about = c.terms[0].0.about();
        about.scope != Scope::Thrusters && task.own.iter().any(|(effect, _)| effect.about().id == about.id)
    };
    list.retain(|c| task.options.families.contains(&c.family()) || of_user(c));
    list
}
