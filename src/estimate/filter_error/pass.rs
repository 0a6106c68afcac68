//! One pass of the filter over the runs, several stretches side by side.
//!
//! ```text
//! −2 ln L = Σ (e²/s + ln s)        e: innovation, s: its variance, sample by sample
//! ```

use super::adjoint::Tape;
use super::beginning::KnownBeginning;
use super::problem::Batch;
use super::sensor::{Innovation, Sensors};
use super::transition::{Belief, Sensitivities, Transition};
use crate::estimate::output_error::Problem;
use crate::progress;
use crate::simd::Wide;
use crate::simulate::{Evaluator, Feed, Stretch, prepared};

/// Number of steps from one check whether the work is still wanted to the next.
const STEPS_A_LOOK: usize = 64;

/// Number of steps of a leg, of which a tape holds what the backward pass needs; the last leg has
/// fewer than twice as many. This is some 100 MB for a batch in six degrees of freedom. A minute at
/// 10 Hz fits in one leg.
const STEPS_A_LEG: usize = 1024;

/// The point that a pass has reached.
#[derive(Clone)]
struct Place<'a, const L: usize> {
    feed: Feed<'a, L>,
    belief: Belief<L>,
    step: usize,
}

/// Filters the stretches of a batch; with `sensitive` it also carries ∂x/∂θ. `take` receives every
/// innovation. With a tape, the backward pass follows, leg by leg from the last one; each leg but
/// the last is filtered once more for it. `known` is carried along in a pass without a tape.
#[inline(always)]
pub(super) fn filter<const L: usize, W: Wide<L>>(
    wide: W,
    batch: Batch<'_, L>,
    sensitive: bool,
    mut tape: Option<&mut Tape<L>>,
    mut known: Option<&mut KnownBeginning<L>>,
    take: &mut impl FnMut(&Innovation<'_, L>),
) {
    let Batch { problem, stretches, theta, noise, mobility, belief, limit } = batch;
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

    let feed = Feed::new(&problem.tracks, &stretches, dynamics.inputs.len());
    let longest = feed.steps();
    let mut place = Place { feed, belief, step: 0 };
    let mut left = Vec::new();
    let legs = if tape.is_some() { (longest / STEPS_A_LEG).max(1) } else { 1 };
    let forth = (0..legs).map(|leg| (leg, false));
    for (leg, again) in forth.chain((0..legs - 1).rev().map(|leg| (leg, true))) {
        let last = leg + 1 == legs;
        if again {
            left.pop().into_iter().for_each(|there| place = there);
            sensitivities = None;
        } else if !last {
            left.push(place.clone());
        }
        let end = if last { longest } else { (leg + 1) * STEPS_A_LEG };
        let mut tape = tape.as_deref_mut().filter(|_| again || last);
        loop {
            let Place { feed, belief, step } = &mut place;
            if *step == end && !last {
                break;
            }
            if feed.grid.iter().any(Option::is_some) {
                let mut take = std::convert::identity(
                    #[inline(always)]
                    |at: &Innovation<'_, L>| {
                        if let Some(tape) = &mut tape {
                            tape.sample(at);
                        }
                        if let Some(known) = &mut known {
                            known.sample(wide, at);
                        }
                        if !again {
                            take(at);
                        }
                    },
                );
                let instant = if *step == 0 { 0 } else { 2 };
                samples(wide, problem, &stretches, feed, instant, &mut sensors, belief, &mut sensitivities, &mut take);
            }
            if *step == longest {
                break;
            }
            if *step % STEPS_A_LOOK == 0 {
                progress::look();
            }
            feed.go_on(*step);
            *step += 1;
            if let Some(tape) = &mut tape {
                tape.before(wide, belief);
            }
            transition.predict(wide, feed, belief);
            if let Some(tape) = &mut tape {
                tape.step(&transition, feed.h);
            }
            if let Some(known) = &mut known {
                known.step(wide, &mut transition);
            }
            if let Some(sensitivities) = &mut sensitivities {
                transition.carry(wide, sensitivities);
            }
        }
        if let Some(tape) = tape {
            tape.unwind(wide);
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
        let mut measured = [0.0; L];
        for lane in 0..L {
            measured[lane] = problem.measured(stretches, &feed.grid, lane, output);
        }
        if measured.iter().any(|y| !y.is_nan()) {
            sensors.update(wide, output, &measured, belief, sensitivities, take);
        }
    }
}
