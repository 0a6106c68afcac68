//! Joins segments where the data allow it: fewer free initial states, more information.
//!
//! ```text
//! Δ = (cost joined − cost apart) / s²  ~  χ²(states given up)        joined where Δ < n + 3 √(2 n)
//! ```
//!
//! Every free initial state takes information away: with segments of 8 s logged at 3 Hz, errors of
//! drag are twice the Cramér-Rao bound. A correct model carries a state across the border of two
//! segments as well as within them. A model that is not correct, or a run with another disturbance,
//! does not, and then the segments stay short. The short fit gives the start, without which long
//! segments end in wrong minima. At the end, channels are weighted by their residuals.

use super::{OutputErrorError, OutputErrorFit, OutputErrorOptions, Problem, fit_from};
use crate::simulate::Stretch;

/// Number of segments that become one in each round; in the second, all of a run do.
const ROUNDS: [usize; 2] = [4, usize::MAX];

/// Joins the segments of a fit as far as the data allow.
pub(super) fn joined(
    mut fit: OutputErrorFit,
    options: &OutputErrorOptions,
) -> Result<OutputErrorFit, OutputErrorError> {
    // with correlated residuals Δ does not follow χ², and clusters have to stay shorter than runs
    if !fit.converged || fit.problem.loss.is_robust() || !fit.problem.is_white(&fit.linearised) {
        return Ok(fit);
    }
    for count in ROUNDS {
        let groups = groups(&fit.problem, count);
        let given_up = (fit.problem.segments.len() - groups.len()) * fit.problem.free_states();
        if given_up == 0 {
            continue;
        }
        let stretch = |group: &[usize]| {
            let (first, last) = (fit.problem.segments[group[0]], fit.problem.segments[group[group.len() - 1]]);
            Stretch { last: last.last, ..first }
        };
        let mut problem = fit.problem.clone();
        problem.segments = groups.iter().map(|group| stretch(group)).collect();
        let x0 = groups.iter().map(|group| fit.initial_states[group[0]].clone()).collect();
        // if the joined fit diverges, the border is needed
        let Ok(longer) = fit_from(&fit.model, problem, x0, options) else { break };
        let unknowns = fit.problem.unknowns.len() + fit.problem.free_states() * fit.problem.segments.len();
        let scale = fit.cost / (fit.samples - unknowns) as f64;
        let (n, delta) = (given_up as f64, (longer.cost - fit.cost) / scale);
        if !longer.converged || delta > n + 3.0 * (2.0 * n).sqrt() {
            break;
        }
        fit = longer;
    }
    Ok(if options.sigma.is_none() { weighed(fit, options) } else { fit })
}

/// The fit with each channel weighted by its residuals, if the noise was not given. Differences of
/// slow samples take part of the motion for noise, and with wrong weights neither errors nor
/// standard deviations are the best. The relaxation of Jategaonkar (2015), section 4.4; a fit that
/// fails keeps its former weights.
fn weighed(mut fit: OutputErrorFit, options: &OutputErrorOptions) -> OutputErrorFit {
    // the second pass changes standard deviations by less than a hundredth
    const PASSES: usize = 2;
    for _ in 0..PASSES {
        let mut problem = fit.problem.clone();
        for (sigma, rms) in problem.sigma.iter_mut().zip(&fit.residual_rms) {
            // a channel that is met to the last bit, or that no segment observes, keeps its weight
            if *rms > 1e-3 * *sigma {
                *sigma = *rms;
            }
        }
        match fit_from(&fit.model, problem, fit.initial_states.clone(), options) {
            Ok(again) if again.converged && again.problem.is_white(&again.linearised) => fit = again,
            _ => break,
        }
    }
    fit
}

/// Groups of up to `count` neighbouring segments of one track without a gap between them; by index.
fn groups(problem: &Problem, count: usize) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (k, segment) in problem.segments.iter().enumerate() {
        let follows = |last: &Stretch| {
            last.track == segment.track
                && last.last + 1 == segment.first
                && !problem.tracks[segment.track].starts.contains(&segment.first)
        };
        match groups.last_mut() {
            Some(group) if group.len() < count && follows(&problem.segments[k - 1]) => group.push(k),
            _ => groups.push(vec![k]),
        }
    }
    groups
}
