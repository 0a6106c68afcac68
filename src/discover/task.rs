//! What a search works on: the runs, how they are fitted, and what is asked of them.

use std::sync::Arc;

use super::candidate::{Candidate, candidates};
use super::screen::{Screen, screen};
use crate::effects::{Effect, Family, Place, Scope};
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions};
use crate::estimate::output_error::OutputErrorError;
use crate::model::Model;
use crate::progress;
use crate::run::Run;

/// Names within this of −2 ln L are both possible: three deviations of the difference of two names for one signal.
pub(super) const TIE: f64 = 9.0;

/// Fall of −2 ln L below which the refits of rivals are no longer improved: little beside what tells them apart.
pub(super) const ROUGH: f64 = 0.5;

/// How the search is done.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchOptions {
    /// Probability of a name where nothing is missing, before held-out runs are asked.
    pub level: f64,
    /// Greatest number of effects to add.
    pub most: usize,
    /// Families of the catalogue that are searched; users' own effects always are.
    pub families: Vec<Family>,
    /// Seed of what is drawn by chance.
    pub seed: u64,
}

impl Default for SearchOptions {
    fn default() -> SearchOptions {
        let families = vec![Family::Body, Family::Actuator, Family::Environment, Family::Sensor];
        SearchOptions { level: 0.01, most: 5, families, seed: 1 }
    }
}

/// What the search works on.
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

/// The candidates of the families that are searched, and the user's own.
pub(super) fn asked(model: &Model, task: &Task<'_>) -> Vec<Candidate> {
    let mut list = candidates(model, task.train, task.own);
    // thrusters come with the campaign, too, but their effects are those of the catalogue
    let of_user = |c: &Candidate| {
        let about = c.terms[0].0.about();
        about.scope != Scope::Thrusters && task.own.iter().any(|(effect, _)| effect.about().id == about.id)
    };
    list.retain(|c| task.options.families.contains(&c.family()) || of_user(c));
    list
}
