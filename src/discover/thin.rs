//! The residual on a coarser grid, on which candidates are scored.
//!
//! ```text
//! z(t_j) ≈ Σ_k hat_k(t_j) z(t_k)      hat_k: 1 at t_k, 0 at its neighbours on the coarse grid, straight in between
//! Σ_j z_j r_j = Σ_k w_k z_k r̄_k       w_k = Σ_j hat_k(t_j),   r̄_k = Σ_j hat_k(t_j) r_j / w_k
//! ```
//!
//! What a candidate would add is smooth, because a force is integrated before it is seen; it is computed at every fifth
//! of a second and a straight line in between, whatever the rate of the log. The residual keeps every sample. At periods
//! of 3 s and longer the line is within 2 % of the curve, which costs less than 0.1 % of the score.

use std::sync::Arc;

use crate::estimate::output_error::{LANES, OutputErrorFit};
use crate::run::{Run, Signal, rounding};
use crate::simulate::{Emission, Stretch, integrate_fast};

/// Distance of the points of the coarse grid, s; a log that is slower keeps its own.
pub(super) const STEP: f64 = 0.2;

/// The residual of a fit on a coarse grid.
#[derive(Debug)]
pub(super) struct Thin {
    /// The fit's segments on the coarse grid of each run.
    pub segments: Vec<Stretch>,
    /// By track: weight √w/σ and weighted residual √w r̄/σ of each point and output; 0 where nothing is measured.
    pub rows: Vec<Vec<(f64, f64)>>,
}

impl Thin {
    /// The residuals of `fit` with points at least `step` seconds apart. The outputs' signals in `runs` are replaced by
    /// ones that have the coarse grid as time stamps.
    pub fn new(fit: &OutputErrorFit, runs: &mut [Run], step: f64) -> Thin {
        let problem = &fit.problem;
        let outputs = problem.dynamics.outputs.len();
        let residuals = residuals(fit);
        let mut segments = Vec::with_capacity(problem.segments.len());
        let mut grids: Vec<Vec<usize>> = vec![Vec::new(); problem.tracks.len()];
        for segment in &problem.segments {
            let time = &problem.tracks[segment.track].time;
            let grid = &mut grids[segment.track];
            let first = grid.len();
            for k in segment.first..=segment.last {
                let far = grid
                    .get(first..)
                    .and_then(<[usize]>::last)
                    .is_none_or(|l| time[k] - time[*l] >= step - rounding(time[k]));
                if far || k == segment.last {
                    grid.push(k);
                }
            }
            segments.push(Stretch { track: segment.track, first, last: grid.len() - 1 });
        }
        let mut rows: Vec<Vec<(f64, f64)>> = grids.iter().map(|g| vec![(0.0, 0.0); g.len() * outputs]).collect();
        for stretch in &segments {
            let (time, grid) = (&problem.tracks[stretch.track].time, &grids[stretch.track]);
            let residual = &residuals[stretch.track];
            for k in stretch.first..=stretch.last {
                let before = grid[k.saturating_sub(1).max(stretch.first)];
                let after = grid[(k + 1).min(stretch.last)];
                for output in 0..outputs {
                    let (mut weight, mut sum) = (0.0, 0.0);
                    for j in before..=after {
                        let r = residual[j * outputs + output];
                        let hat = hat(time[j], time[before], time[grid[k]], time[after]);
                        if !r.is_nan() && hat > 0.0 {
                            weight += hat;
                            sum += hat * r;
                        }
                    }
                    if weight > 0.0 {
                        let scale = 1.0 / problem.sigma[output];
                        rows[stretch.track][k * outputs + output] =
                            (weight.sqrt() * scale, sum / weight.sqrt() * scale);
                    }
                }
            }
        }
        for (track, grid) in problem.tracks.iter().zip(&grids) {
            let time: Arc<[f64]> = grid.iter().map(|k| track.time[*k]).collect();
            for name in &problem.dynamics.outputs {
                if let Some(signal) = runs[track.run].signals.get_mut(name) {
                    *signal = Signal::new(time.clone(), vec![0.0; time.len()]);
                }
            }
        }
        Thin { segments, rows }
    }
}

/// 1 at `top`, 0 at `before` and `after` and beyond, straight in between; at an end of the grid one side is missing.
fn hat(t: f64, before: f64, top: f64, after: f64) -> f64 {
    if t < top {
        (t - before) / (top - before)
    } else if t > top {
        (after - t) / (after - top)
    } else {
        1.0
    }
}

/// Measured less simulated at every sample, by track; NaN where nothing is measured.
pub(super) fn residuals(fit: &OutputErrorFit) -> Vec<Vec<f64>> {
    let problem = &fit.problem;
    let outputs = problem.dynamics.outputs.len();
    let mut all: Vec<Vec<f64>> = problem.tracks.iter().map(|t| vec![f64::NAN; t.time.len() * outputs]).collect();
    let order: Vec<usize> = (0..problem.segments.len()).collect();
    for batch in order.chunks(LANES) {
        let (stretches, theta, start) = problem.lanes::<LANES>(&fit.model, &fit.initial_states, batch);
        let mut take = |at: &Emission<'_, LANES>| {
            for lane in 0..LANES {
                let (Some(stretch), Some(k)) = (stretches[lane], at.grid[lane]) else { continue };
                for output in 0..outputs {
                    all[stretch.track][k * outputs + output] =
                        problem.measured(&stretches, at.grid, lane, output) - at.outputs[output][lane];
                }
            }
        };
        integrate_fast(&problem.dynamics, &problem.tracks, &stretches, &theta, &start, false, &mut take);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hats on a grid are a partition of unity: no sample is lost or counted twice.
    #[test]
    fn law_hats_add_up_to_one() {
        let grid = [0.0, 0.2, 0.4, 0.5];
        for t in [0.0, 0.03, 0.1, 0.2, 0.35, 0.4, 0.47, 0.5] {
            let sum: f64 = (0..grid.len())
                .map(|k| {
                    let (before, after) = (grid[k.saturating_sub(1)], grid[(k + 1).min(3)]);
                    if t < before || t > after { 0.0 } else { hat(t, before, grid[k], after) }
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-12, "{t}: {sum}");
        }
    }
}
