//! What chance lets the initial values of a memory take of the cost.
//!
//! ```text
//! E[fall] = s τ Σ (1 − w² [(RᵀR)⁻¹]ₘₘ)      over segments and memories; s: noise level, τ: its colour
//! ```
//!
//! Each segment has its own initial value of every memory, held by a prior of weight w: where the log says more of it
//! than the prior (R is the factor of both), it follows the noise. An effect with a memory lowers the cost by that
//! whether it is there or not, the more the more coloured the noise ([`super::colour`]); its name is judged without.

use super::colour::{colours, taken_up};
use super::gap::variance;
use super::search::noise_level;
use crate::estimate::output_error::OutputErrorFit;

/// The cost of a fit with what chance gave its memories added again.
pub(super) fn fair_cost(fit: &OutputErrorFit) -> f64 {
    fit.cost + given(fit)
}

/// What chance gave to the memories of a fit, in units of the noise variance.
fn given(fit: &OutputErrorFit) -> f64 {
    let problem = &fit.problem;
    let nx = problem.dynamics.states.len();
    let first = nx - problem.dynamics.memories();
    if first == nx {
        return 0.0;
    }
    let colour = colours(fit).into_iter().fold(0.0, f64::max);
    let of_segment = |(k, segment): (usize, &crate::simulate::Stretch)| {
        let (_, std) = problem.memory_prior(&fit.model, &fit.initial_states, k);
        let free = |m: usize| {
            let left = variance(&fit.linearised[k], nx, |i| f64::from(u8::from(i == m))) / std[m - first].powi(2);
            1.0 - left.clamp(0.0, 1.0)
        };
        let samples = (segment.last - segment.first + 1) as f64;
        taken_up(colour, samples) * (first..nx).map(free).sum::<f64>()
    };
    noise_level(fit).max(1.0) * problem.segments.iter().enumerate().map(of_segment).sum::<f64>()
}
