//! A slow random force that has absorbed a missing effect.
//!
//! ```text
//! (σ, T) → (σ √(T₁/T), T₁)     where T > 10 s, 5 s for what each run has for itself,  T₁ = 1 s: over a second it pushes as it did
//! ```
//!
//! Forces of water last for a second or three. A force that lasts for tens of seconds follows a trim, a tide or a
//! snagged tether as well as any effect does, and with it a constant effect has no score: a pitch moment of 75
//! standard deviations was reported as "a random force (correlation 35 s)". The candidates are therefore scored again
//! with a force that is as strong from one second to the next but decays as forces of water do. The likelihood ratio
//! of a refit decides as for all others.

use super::screen::{Score, screen};
use super::searched::Search;
use super::task::Task;
use crate::estimate::filter_error::{FilterErrorFit, RandomForce};
use crate::estimate::output_error::OutputErrorError;

/// Correlation time with which the candidates are scored again, s.
const USUAL: f64 = 1.0;

/// Maximum number of candidates that are refitted because of it.
const MOST: usize = 3;

/// The fit with its slow forces at the usual correlation time; `None` if none is slow.
fn quickened(fit: &FilterErrorFit, is_slow: impl Fn(&RandomForce) -> bool) -> Option<FilterErrorFit> {
    if !fit.noise.forces.iter().any(&is_slow) {
        return None;
    }
    let mut quick = fit.clone();
    for force in quick.noise.forces.iter_mut().filter(|f| is_slow(f)) {
        force.rms *= (USUAL / force.time).sqrt();
        force.time = USUAL;
    }
    Some(quick)
}

/// Scores of candidates that a slow force of the last fit hides, the best probe of each. Only candidates that are not
/// in `known` and that are `wanted`; `is_slow` decides which forces are slow.
///
/// # Errors
/// As [`screen`].
pub(super) fn hidden(
    found: &Search,
    known: &[Score],
    wanted: impl Fn(&Score) -> bool,
    is_slow: fn(&RandomForce) -> bool,
    task: &Task<'_>,
) -> Result<Vec<Score>, OutputErrorError> {
    let Some(quick) = quickened(found.last_fit(), is_slow) else { return Ok(Vec::new()) };
    let asked = (task.options.level, task.options.seed);
    let under = screen(&quick, task.train, &found.candidates, &task.fitting.base, asked)?;
    let mut best: Vec<Score> = Vec::new();
    for score in under.scores {
        let is_known = known.iter().chain(&best).any(|k| k.candidate == score.candidate);
        if best.len() < MOST && !is_known && score.log_p < under.threshold && wanted(&score) {
            best.push(score);
        }
    }
    Ok(best)
}
