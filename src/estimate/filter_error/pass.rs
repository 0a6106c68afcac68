//! One pass of the filter over the runs, several side by side.
//!
//! ```text
//! −2 ln L = Σ (e²/s + ln s)        e: innovation, s: its variance, sample by sample
//! ```

use super::problem::Batch;
use super::sensor::{Innovation, Sensors};
use super::transition::{Belief, Sensitivities, Transition};
use crate::estimate::output_error::Problem;
use crate::progress;
use crate::simulate::{Evaluator, Feed, Stretch, prepared};
use crate::wide::Wide;

/// Steps from one look at whether the work is still wanted to the next.
const STEPS_A_LOOK: usize = 64;

/// Filters the stretches of a batch; `sensitive` also carries ∂x/∂θ. `take` sees every innovation.
#[inline(always)]
pub(super) fn filter<const L: usize, W: Wide<L>>(
    wide: W,
    batch: Batch<'_, L>,
    sensitive: bool,
    take: &mut impl FnMut(&Innovation<'_, L>),
) {
    let Batch { problem, stretches, theta, noise, mobility, mut belief, limit } = batch;
    let dynamics = &problem.dynamics;
    let (nx, ny) = (dynamics.states.len(), dynamics.outputs.len());
    let columns = if sensitive { dynamics.directions.len() } else { 0 };
    let coloured: Vec<usize> = noise[0].coloured().map(|(output, _)| output).collect();
    let (forces, all) = (noise[0].forces.len(), noise[0].processes());
    let variance = (0..ny).map(|c| std::array::from_fn(|lane| noise[lane].sensors[c].std.powi(2))).collect();

    let [mut rates, mut observe] = [&dynamics.rates, &dynamics.observation].map(|f| prepared(f, &theta));
    let rates = Evaluator::new(&dynamics.rates, &mut rates, nx, 0);
    let observe = Evaluator::new(&dynamics.observation, &mut observe, nx, 0);
    let mut transition = Transition::new(dynamics, rates, noise, mobility);
    let mut sensors = Sensors::new(dynamics, observe, variance, (forces, &coloured), columns, limit);
    let mut sensitivities = sensitive.then(|| Sensitivities::none(nx + all, columns));

    let mut feed = Feed::new(&problem.tracks, &stretches, dynamics.inputs.len());
    let (mut instant, longest) = (0, feed.steps());
    for step in 0..=longest {
        if feed.grid.iter().any(Option::is_some) {
            samples(wide, problem, &stretches, &feed, instant, &mut sensors, &mut belief, &mut sensitivities, take);
        }
        if step == longest {
            break;
        }
        if step % STEPS_A_LOOK == 0 {
            progress::look();
        }
        feed.go_on(step);
        instant = 2;
        transition.predict(wide, &feed, &mut belief);
        if let Some(sensitivities) = &mut sensitivities {
            transition.carry(wide, sensitivities);
        }
    }
}

/// Takes all samples of a grid point into account, one after the other.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // the pieces of a pass
fn samples<const L: usize, W: Wide<L>>(
    wide: W,
    problem: &Problem,
    stretches: &[Option<Stretch>; L],
    feed: &Feed<'_, L>,
    instant: usize,
    sensors: &mut Sensors<'_, L>,
    belief: &mut Belief<L>,
    sensitivities: &mut Option<Sensitivities<L>>,
    take: &mut impl FnMut(&Innovation<'_, L>),
) {
    sensors.look(wide, feed, instant, &belief.x);
    for output in 0..problem.dynamics.outputs.len() {
        let measured: [f64; L] = std::array::from_fn(|lane| problem.measured(stretches, &feed.grid, lane, output));
        if measured.iter().any(|y| !y.is_nan()) {
            sensors.update(wide, output, &measured, belief, sensitivities, take);
        }
    }
}
