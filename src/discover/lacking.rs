//! Whether a fit lacks an effect of the catalogue at all, without its name.
//!
//! ```text
//! p = level · exp(ln p_best − ln p_threshold)        one pass of scores, step 2 of the search
//! ```
//!
//! Predictions seconds ahead are a coarse test: a gyro that is 50 ms late passes it, and moves the yaw inertia by five of its
//! deviations. The scores see it. Which effect it is they do not say: a name has to pass the rest of the search.

use std::sync::Arc;

use super::candidate::Candidate;
use super::screen::Score;
use super::search::{SearchOptions, Task, asked, has_own_values, p_of_all, screened};
use crate::effects::{Effect, Place};
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions};
use crate::estimate::output_error::OutputErrorError;
use crate::run::Run;

/// An effect that a fit lacks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lacking {
    /// Probability of such a score by chance, of all candidates.
    pub p_value: f64,
    /// How many candidates were asked.
    pub candidates: usize,
}

/// Whether `fit` to `runs` lacks an effect of the catalogue, or one of `own`, beyond chance.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub fn lacking(
    fit: &FilterErrorFit,
    runs: &[Run],
    own: &[(Arc<dyn Effect>, Place)],
    fitting: &FilterErrorOptions,
    options: &SearchOptions,
) -> Result<Option<Lacking>, OutputErrorError> {
    let task = Task { train: runs, held: &[], own, fitting, options };
    // what has a value of its own in every run follows anything that comes and goes
    let list: Vec<Candidate> = asked(&fit.model, &task).into_iter().filter(|c| !has_own_values(c)).collect();
    let screen = screened(fit, &list, &task)?;
    let beyond = |score: &&Score| score.log_p < screen.threshold && list[score.candidate].is_possible(score);
    let best = screen.scores.iter().find(beyond);
    let p_value = |best: &Score| p_of_all(best.log_p, screen.threshold, options.level);
    Ok(best.map(|best| Lacking { p_value: p_value(best), candidates: list.len() }))
}
