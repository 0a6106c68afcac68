//! What the length of the integrator's steps costs.
//!
//! ```text
//! Σ (y_h − y_{h/2})² / σ²       over all samples of all segments, from the same initial states
//! ```
//!
//! A scheme of the fourth order leaves a sixteenth of its error at half the step, so that the difference is the error.

use super::problem::{LANES, Problem};
use crate::model::Model;
use crate::simulate::{Emission, Track, integrate_fast, values_in_run};

/// Sum of the squares of the integrator's error, in units of the noise.
pub(crate) fn step_error(problem: &Problem, model: &Model, x0: &[Vec<f64>]) -> f64 {
    let dynamics = &problem.dynamics;
    let finer: Vec<Track> =
        problem.tracks.iter().map(|track| track.finer(dynamics, &values_in_run(model, track.run))).collect();
    let order: Vec<usize> = (0..problem.segments.len()).collect();
    let outputs = dynamics.outputs.len();
    let mut sum = 0.0;
    for batch in order.chunks(LANES) {
        let (stretches, theta, start) = problem.lanes::<LANES>(model, x0, batch);
        let mut usual: Vec<Vec<f64>> = vec![Vec::new(); batch.len()];
        let mut keep = |at: &Emission<'_, LANES>| {
            for (lane, kept) in usual.iter_mut().enumerate().filter(|(lane, _)| at.grid[*lane].is_some()) {
                kept.extend(at.outputs.iter().map(|y| y[lane]));
            }
        };
        integrate_fast(dynamics, &problem.tracks, &stretches, &theta, &start, false, &mut keep);
        let mut compare = |at: &Emission<'_, LANES>| {
            for (lane, usual) in usual.iter().enumerate() {
                let (Some(k), Some(stretch)) = (at.grid[lane], stretches[lane]) else { continue };
                for output in 0..outputs {
                    let error = at.outputs[output][lane] - usual[(k - stretch.first) * outputs + output];
                    if !problem.measured(&stretches, at.grid, lane, output).is_nan() {
                        sum += (error / problem.sigma[output]).powi(2);
                    }
                }
            }
        };
        integrate_fast(dynamics, &finer, &stretches, &theta, &start, false, &mut compare);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::OutputErrorOptions;
    use super::*;
    use crate::effects::Coriolis;
    use crate::frame::Dof;
    use crate::run::{Run, Signal};

    /// RK4 is of the fourth order: the square of its error goes with the eighth power of the step. The time constant of
    /// 0.25 s is short beside the steps, and higher orders tell a little.
    #[test]
    fn law_half_the_step_errs_by_a_sixteenth() {
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        model.set("inertia@surge", 10.0);
        model.set("linear_drag@surge", 40.0);
        let time: std::sync::Arc<[f64]> = (0..101).map(|k| 0.1 * f64::from(k)).collect();
        let mut run = Run::default();
        let force: Vec<f64> = time.iter().map(|t| 20.0 * (3.0 * t).sin()).collect();
        run.signals.insert("tau_u".into(), Signal::new(time.clone(), force));
        run.signals.insert("u".into(), Signal::new(time, vec![0.0; 101]));
        let sigma = Some([("u".to_string(), 1e-3)].into());
        let errs = |longest_step: f64| {
            let options = OutputErrorOptions { longest_step, sigma: sigma.clone(), ..OutputErrorOptions::default() };
            let problem = Problem::new(&model, std::slice::from_ref(&run), &options).unwrap();
            let x0 = problem.initial_states(&model);
            step_error(&problem, &model, &x0)
        };
        let ratio = errs(0.1) / errs(0.05);
        assert!((200.0..900.0).contains(&ratio), "{ratio}");
    }
}
