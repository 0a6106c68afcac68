//! Forecasts: the errors of predictions compared with the variance that the filter states for them
//! beforehand.
//!
//! ```text
//! H ahead:  (y − ŷ(t | t−H))² against its variance  c P(t | t−H) cᵀ + R          no updates for H seconds
//! ```
//!
//! If innovations are held back, an isolated sample more than five standard deviations off its
//! prediction one sample ahead is an error of the sensor, and no prediction is judged by it.
//!
//! A test of whiteness ([`super::whiteness`]) alone is not enough: an unmodelled lag of the thrust
//! left white innovations, but predictions eight seconds ahead had five times the expected error.

use rayon::prelude::*;

use super::noise::NoiseModel;
use super::prediction::Prediction;
use super::problem::{Batch, Filtered};
use super::sensor::{Sensors, shortest};
use super::tails::OUTLIER;
use super::transition::{Belief, Transition};
use super::whiteness::Whiteness;
use crate::model::Model;
use crate::noise::Noise;
use crate::simd::Plain;
use crate::simulate::{Evaluator, Feed, prepared};

/// Horizons of predictions, s, beside one sample ahead and the free run.
pub const AHEAD: [f64; 2] = [2.0, 8.0];

/// Time at the beginning of a run, s, in which the filter finds its state before any prediction
/// begins: a prediction that starts from a turn rate not known yet tests the initial guess, not the
/// model.
const SETTLED: f64 = 2.0;

/// Limit at which normalised innovations are clipped for the test of whiteness: one outlier says
/// nothing about correlation.
const CLIPPED: f64 = 4.0;

/// A point of a predicted series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Time, s.
    pub time: f64,
    /// Measured value, NaN where there is none.
    pub measured: f64,
    /// Predicted value.
    pub mean: f64,
    /// Standard deviation with which a sample is expected about the mean.
    pub std: f64,
}

/// One channel of one stretch.
#[derive(Debug, Clone)]
pub struct Channel {
    /// Index of the output.
    pub output: usize,
    /// Predictions one sample ahead, for each of [`AHEAD`], and of the free run.
    pub predictions: Vec<Prediction>,
    /// Whiteness of its innovations.
    pub whiteness: Whiteness,
    /// Σ z² of its innovations.
    pub squares: f64,
    /// The free run, point by point.
    pub free: Vec<Point>,
    /// One sample ahead, point by point.
    pub next: Vec<Point>,
    /// Every prediction more than one sample ahead, in order.
    pub(super) foretold: Vec<Foretold>,
}

impl Channel {
    /// Squared errors of the predictions `ahead` seconds ahead (one of [`AHEAD`]) that do not
    /// overlap in time, in order.
    pub fn squares_apart(&self, ahead: f64) -> Vec<f64> {
        let mut last = f64::NEG_INFINITY;
        let mut squares = Vec::new();
        for f in self.foretold.iter().filter(|f| self.predictions[f.at].ahead == Some(ahead)) {
            if f.time > last + ahead - 1e-6 {
                squares.push(f.error * f.error);
                last = f.time;
            }
        }
        squares
    }
}

/// A prediction more than one sample ahead.
#[derive(Debug, Clone, Copy)]
pub(super) struct Foretold {
    /// Instant that is predicted, s.
    pub time: f64,
    /// Index in the channel's `predictions` of the one to which it belongs.
    pub at: usize,
    /// Predicted value.
    pub mean: f64,
    /// Measured minus predicted value.
    pub error: f64,
    /// Variance of the error that the filter expected.
    pub variance: f64,
    /// Whether the sample is wild, so that it says nothing about the prediction.
    pub wild: bool,
}

/// One stretch of a run.
#[derive(Debug, Clone)]
pub struct Forecast {
    /// Name of the run.
    pub run: String,
    /// Its channels, in the order of the outputs.
    pub channels: Vec<Channel>,
}

/// A prediction under way.
struct Branch {
    ahead: Option<f64>,
    belief: Option<Belief<1>>,
    began: f64,
    /// Time at which its first prediction begins, s.
    first: f64,
}

impl Filtered {
    /// Predicts every stretch with `model` under `noise`.
    pub fn forecast(&self, model: &Model, noise: &NoiseModel, limit: f64) -> Vec<Forecast> {
        self.forecast_drawn(model, noise, limit, None)
    }

    /// The same; with a seed, each prediction starts from a state drawn from the distribution that
    /// the filter estimates, and is driven by forces drawn from the noise model.
    pub(super) fn forecast_drawn(
        &self,
        model: &Model,
        noise: &NoiseModel,
        limit: f64,
        seed: Option<u64>,
    ) -> Vec<Forecast> {
        let Some(mobilities) = self.mobilities(model) else { return Vec::new() };
        let silent = self.silent(noise);
        let of = |k| {
            let drawn = seed.map(|seed| Noise::new(seed, k as u64));
            let mut forecast = forecast(self.batch::<1>(model, &[k], [noise.clone()], &mobilities, limit), drawn);
            // innovations of an output whose noise was not estimated say nothing about the noise
            let beside = forecast.channels.iter_mut().filter(|channel| silent[channel.output]);
            beside.for_each(|channel| channel.whiteness = Whiteness::of(&[]));
            forecast
        };
        (0..self.problem.segments.len()).into_par_iter().map(of).collect()
    }
}

fn forecast(batch: Batch<'_, 1>, mut drawn: Option<Noise>) -> Forecast {
    let Batch { problem, stretches, theta, noise, mobility, mut belief, limit } = batch;
    let dynamics = &problem.dynamics;
    let (nx, ny) = (dynamics.states.len(), dynamics.outputs.len());
    let coloured: Vec<usize> = noise[0].coloured().map(|(output, _)| output).collect();
    let forces = noise[0].forces.len();
    let variance = noise[0].sensors.iter().map(|s| [s.std.powi(2)]).collect();
    let [mut rates, mut observe] = [&dynamics.rates, &dynamics.observation].map(|f| prepared(f, &theta));
    let rates = Evaluator::new(&dynamics.rates, &mut rates, nx, 0);
    let observe = Evaluator::new(&dynamics.observation, &mut observe, nx, 0);
    let mut transition = Transition::new(dynamics, rates, noise, mobility);
    let mut sensors = Sensors::new(dynamics, observe, variance, (forces, &coloured), 0, limit);
    let mut feed = Feed::new(&problem.tracks, &stretches, dynamics.inputs.len());

    let track = stretches[0].map_or(0, |s| s.track);
    let time = |grid: usize| problem.tracks[track].time[grid];
    let begin = stretches[0].map_or(0.0, |s| time(s.first));
    let settled = begin + SETTLED;
    // two branches for the longest horizon, half of it apart: there are few such predictions
    let starts = [(AHEAD[0], 0.0), (AHEAD[1], 0.0), (AHEAD[1], AHEAD[1] / 2.0)];
    let ahead = starts.map(|(h, later)| Branch { ahead: Some(h), belief: None, began: 0.0, first: settled + later });
    let free = Branch { ahead: None, belief: None, began: 0.0, first: settled };
    let mut branches: Vec<Branch> = ahead.into_iter().chain([free]).collect();
    let kinds = || [Some(0.0)].into_iter().chain(AHEAD.map(Some)).chain([None]);
    let mut channels: Vec<Channel> = (0..ny)
        .map(|output| Channel {
            output,
            predictions: kinds().map(Prediction::new).collect(),
            whiteness: Whiteness::of(&[]),
            squares: 0.0,
            free: Vec::new(),
            next: Vec::new(),
            foretold: Vec::new(),
        })
        .collect();
    let mut z = vec![Vec::new(); ny];
    let mut wild = vec![false; ny];
    let (mut instant, longest) = (0, feed.steps());
    for step in 0..=longest {
        if let Some(grid) = feed.grid[0] {
            let now = time(grid);
            if limit.is_finite() {
                sensors.look(Plain, &feed, instant, &belief.x);
                for (output, wild) in wild.iter_mut().enumerate() {
                    let measured = problem.measured(&stretches, &feed.grid, 0, output);
                    if !measured.is_nan() {
                        let ([mean], [variance]) = sensors.expect(Plain, output, &belief);
                        // only an isolated one: if wild samples follow one another, the filter
                        // itself is lost
                        *wild = !*wild && sensors.error(output, measured, mean).abs() > OUTLIER * variance.sqrt();
                    }
                }
            }
            for branch in &mut branches {
                let due = branch.ahead.is_none_or(|h| now - branch.began > h - 1e-6);
                if let (Some(belief), true) = (&branch.belief, due) {
                    sensors.look(Plain, &feed, instant, &belief.x);
                    for (output, channel) in channels.iter_mut().enumerate() {
                        let ([mean], [variance]) = sensors.expect(Plain, output, belief);
                        let [measured] = std::array::from_fn::<f64, 1, _>(|lane| {
                            problem.measured(&stretches, &feed.grid, lane, output)
                        });
                        let at = channel.predictions.iter().position(|p| p.ahead == branch.ahead);
                        if let (Some(at), false) = (at, measured.is_nan()) {
                            let error = sensors.error(output, measured, mean);
                            if !wild[output] {
                                channel.predictions[at].add(error, variance);
                            }
                            let wild = wild[output];
                            channel.foretold.push(Foretold { time: now, at, mean, error, variance, wild });
                        }
                        if branch.ahead.is_none() {
                            channel.free.push(Point { time: now, measured, mean, std: variance.sqrt() });
                        }
                    }
                }
            }
            sensors.look(Plain, &feed, instant, &belief.x);
            for output in 0..ny {
                let measured = problem.measured(&stretches, &feed.grid, 0, output);
                if measured.is_nan() {
                    continue;
                }
                sensors.update(Plain, output, &[measured], &mut belief, &mut None, &mut |at| {
                    let (e, s) = (at.e[0], at.s[0]);
                    let (channel, root) = (&mut channels[output], s.sqrt());
                    // for the first sample there is no prediction, only the initial estimate
                    if now > begin && !wild[output] {
                        channel.predictions[0].add(e, s);
                    }
                    channel.squares += e * e / s;
                    channel.next.push(Point { time: now, measured, mean: measured - e, std: root });
                    z[output].push((e / root).clamp(-CLIPPED, CLIPPED));
                });
            }
            for branch in &mut branches {
                let due = branch.ahead.is_some_and(|h| now - branch.began > h - 1e-6);
                if now >= branch.first - 1e-6 && (branch.belief.is_none() || due) {
                    let mut start = belief.clone();
                    if let Some(noise) = &mut drawn {
                        start.draw(noise);
                    }
                    (branch.belief, branch.began) = (Some(start), now);
                }
            }
        }
        if step == longest {
            break;
        }
        feed.go_on(step);
        instant = 2;
        transition.predict(Plain, &feed, &mut belief);
        for belief in branches.iter_mut().filter_map(|b| b.belief.as_mut()) {
            transition.predict(Plain, &feed, belief);
            if let Some(noise) = &mut drawn {
                transition.push(&mut belief.x, noise);
            }
        }
    }
    for (channel, z) in channels.iter_mut().zip(&z) {
        channel.whiteness = Whiteness::of(z);
    }
    Forecast { run: problem.tracks[track].name.clone(), channels }
}

impl<const L: usize> Sensors<'_, L> {
    /// Measured minus predicted value; for an angle, the shortest difference.
    fn error(&self, output: usize, measured: f64, predicted: f64) -> f64 {
        if self.is_turn(output) { shortest(measured - predicted) } else { measured - predicted }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::estimate::filter_error::{FilterErrorOptions, filter_error};
    use crate::frame::Dof;
    use crate::model::Interpolation;
    use crate::run::{Run, Signal};

    /// 10 u̇ + 4 u = τ, every fiftieth sample off by 25 standard deviations. Of the predictions 2 s
    /// ahead, made at every twentieth sample from 2 s on, one in five ends at such a sample;
    /// counted, these would make a ratio of 11.
    #[test]
    fn predictions_are_not_judged_by_samples_that_are_the_sensors_fault() {
        let (h, r) = (0.1, 0.02);
        let time: Vec<f64> = (0..1200).map(|k| h * f64::from(k)).collect();
        let tau: Vec<f64> = time.iter().map(|t| if (t / 4.0).floor() % 2.0 < 1.0 { 6.0 } else { -3.0 }).collect();
        let (mut u, mut noise) = (0.0, Noise::new(5, 1));
        let logged: Vec<f64> = (0..1200)
            .map(|k| {
                let now = u + r * noise.normal() + if k % 50 == 20 { 25.0 * r } else { 0.0 };
                u = tau[k] / 4.0 + (u - tau[k] / 4.0) * f64::exp(-0.4 * h);
                now
            })
            .collect();
        let mut run = Run { name: "wild".into(), ..Run::default() };
        run.signals.insert("u".into(), Signal::new(time.clone().into(), logged));
        run.signals.insert("tau_u".into(), Signal::new(time.into(), tau));
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        model.input = Interpolation::Hold;
        model.parameters.iter_mut().zip([9.0, 5.0]).for_each(|(p, value)| p.value = value);
        let fit = filter_error(&model, &[run], &FilterErrorOptions::default()).unwrap();
        assert!(fit.limit.is_finite(), "there are outliers");
        let (share, by_chance) = fit.held_back().expect("there are outliers");
        assert!((by_chance - 0.0455).abs() < 1e-4, "1 - erf(2/√2) is not {by_chance}");
        // one in fifty, and of the rest no more than by chance: wild samples widen the noise that
        // is estimated
        assert!(share > 0.02 && share < 0.02 + 0.98 * by_chance, "{share}");
        // s (c − 0.02 · 2 · 5) = 0.98 c r²: wider by an eighth; by more than a half when the pull
        // of a wild sample grew with its size
        let wider = fit.noise.sensors[0].std / r;
        assert!(wider > 1.0 && wider < 1.2, "{wider}");
        let predictions = &fit.forecast()[0].channels[0].predictions;
        // 24 of 1200 samples are wild, and so are 11 of the 58 at which a prediction of 2 s ends
        assert_eq!((predictions[0].count, predictions[1].count), (1200 - 1 - 24, 58 - 11));
        assert!(
            predictions.iter().all(|p| p.ratio() < 1.2),
            "{:?}",
            predictions.iter().map(Prediction::ratio).collect::<Vec<_>>()
        );
    }
}
