//! Is the noise model itself right? What the filter says beforehand of its own errors, and how it then errs.
//!
//! ```text
//! ahead by H:  (y − ŷ(t | t−H))² beside its variance  c P(t | t−H) cᵀ + R          updates masked for H seconds
//! Ljung-Box:   Q = N (N+2) Σ_k r_k²/(N−k)  ~  χ²(m)      r_k: autocorrelation of the innovations z = e/√s at lag k
//! ```
//!
//! Whiteness alone is not enough: a lag of the thrust that no model had left white innovations, and predictions eight
//! seconds ahead that erred five times as much as they should. Ljung and Box, *Biometrika* 65 (1978) 297-303.

use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::noise::NoiseModel;
use super::problem::{Batch, Filtered};
use super::sensor::{Sensors, shortest};
use super::transition::{Belief, Transition};
use crate::model::Model;
use crate::simulate::{Evaluator, Feed, prepared};
use crate::wide::Plain;

/// Seconds ahead that are looked at beside one sample and the free run.
pub const AHEAD: [f64; 2] = [2.0, 8.0];

/// Seconds of a run in which the filter finds its state before a free run begins.
const SETTLED: f64 = 2.0;

/// Lags of the Ljung-Box test.
const LAGS: usize = 20;

/// Innovations beyond so many deviations count as so many: one outlier says nothing of correlation.
const CLIPPED: f64 = 4.0;

/// How a prediction errs, and how it should.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Seconds ahead: 0 for one sample, `None` for a free run.
    pub ahead: Option<f64>,
    /// Σ error².
    pub squares: f64,
    /// Σ of the variances that the filter expected.
    pub expected: f64,
    /// Number of predictions.
    pub count: usize,
}

/// Errors below this share of what is expected are of a sensor that takes no part: its stated noise is beyond all that it
/// shows.
const BESIDE: f64 = 0.1;

impl Prediction {
    fn new(ahead: Option<f64>) -> Prediction {
        Prediction { ahead, squares: 0.0, expected: 0.0, count: 0 }
    }

    fn add(&mut self, error: f64, variance: f64) {
        self.squares += error * error;
        self.expected += variance;
        self.count += 1;
    }

    /// Root-mean-square error, in the channel's unit.
    pub fn rms(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }

    /// The error that was expected, in the channel's unit.
    pub fn expected_rms(&self) -> f64 {
        (self.expected / self.count.max(1) as f64).sqrt()
    }

    /// Whether the sensor takes part: its errors are not far below all that is expected of it.
    pub fn takes_part(&self) -> bool {
        self.squares > BESIDE * BESIDE * self.expected
    }

    /// Both together.
    pub fn with(&self, other: &Prediction) -> Prediction {
        let (squares, expected) = (self.squares + other.squares, self.expected + other.expected);
        Prediction { squares, expected, count: self.count + other.count, ..*self }
    }

    /// Error over what was expected; 1 where nothing was predicted.
    pub fn ratio(&self) -> f64 {
        if self.expected > 0.0 { (self.squares / self.expected).sqrt() } else { 1.0 }
    }

    /// Probability that chance makes such a ratio; predictions half of a horizon apart share half of their error.
    pub fn p_value(&self) -> f64 {
        let n = (0.5 * self.count as f64).max(1.0);
        if self.count == 0 { 1.0 } else { ChiSquared::new(n).map_or(1.0, |chi| chi.sf(n * self.ratio().powi(2))) }
    }

    /// Whether it errs by more than it should: by a fifth at least, and beyond one chance in a thousand.
    pub fn errs(&self) -> bool {
        self.ratio() > 1.2 && self.p_value() < 1e-3
    }
}

/// A point of a predicted series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Time, s.
    pub time: f64,
    /// Measured value, NaN where there is none.
    pub measured: f64,
    /// Predicted value.
    pub mean: f64,
    /// Deviation with which a sample is expected about it.
    pub std: f64,
}

/// Autocorrelation of normalised innovations, summed over stretches.
#[derive(Debug, Clone, PartialEq)]
pub struct Whiteness {
    products: [f64; LAGS + 1],
    count: usize,
}

impl Whiteness {
    pub(super) fn of(z: &[f64]) -> Whiteness {
        let mut products = [0.0; LAGS + 1];
        for (lag, sum) in products.iter_mut().enumerate() {
            *sum = z.iter().skip(lag).zip(z).map(|(a, b)| a * b).sum();
        }
        Whiteness { products, count: z.len() }
    }

    /// Both together.
    pub fn with(&self, other: &Whiteness) -> Whiteness {
        let products = std::array::from_fn(|k| self.products[k] + other.products[k]);
        Whiteness { products, count: self.count + other.count }
    }

    /// Probability that white innovations are correlated as much as these; 1 for too few.
    pub fn p_value(&self) -> f64 {
        let lags = LAGS.min(self.count / 10);
        if lags == 0 || self.products[0] <= 0.0 {
            return 1.0;
        }
        let n = self.count as f64;
        let terms = (1..=lags).map(|k| (self.products[k] / self.products[0]).powi(2) / (n - k as f64));
        let q = n * (n + 2.0) * terms.sum::<f64>();
        ChiSquared::new(lags as f64).map_or(1.0, |chi| chi.sf(q))
    }

    /// Autocorrelation at lag one.
    pub fn first(&self) -> f64 {
        if self.products[0] > 0.0 { self.products[1] / self.products[0] } else { 0.0 }
    }
}

/// One channel of one stretch.
#[derive(Debug, Clone)]
pub struct Channel {
    /// Index of the output.
    pub output: usize,
    /// One sample ahead, each of [`AHEAD`], and the free run.
    pub predictions: Vec<Prediction>,
    /// Of its innovations.
    pub whiteness: Whiteness,
    /// Σ z² of its innovations.
    pub squares: f64,
    /// The free run, point by point.
    pub free: Vec<Point>,
    /// One sample ahead, point by point.
    pub next: Vec<Point>,
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
    /// When the first one begins.
    first: f64,
}

impl Filtered {
    /// How `model` under `noise` predicts every stretch.
    pub fn forecast(&self, model: &Model, noise: &NoiseModel, limit: f64) -> Vec<Forecast> {
        let Some(mobilities) = self.mobilities(model) else { return Vec::new() };
        (0..self.problem.segments.len())
            .into_par_iter()
            .map(|k| forecast(self.batch::<1>(model, &[k], [noise.clone()], &mobilities, limit)))
            .collect()
    }
}

fn forecast(batch: Batch<'_, 1>) -> Forecast {
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
    // those of the longest horizon twice, half of it apart: there are few of them
    let starts = [(AHEAD[0], 0.0), (AHEAD[1], 0.0), (AHEAD[1], AHEAD[1] / 2.0)];
    let ahead = starts.map(|(h, later)| Branch { ahead: Some(h), belief: None, began: 0.0, first: begin + later });
    let free = Branch { ahead: None, belief: None, began: 0.0, first: begin + SETTLED };
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
        })
        .collect();
    let mut z = vec![Vec::new(); ny];
    let (mut instant, longest) = (0, feed.steps());
    for step in 0..=longest {
        if let Some(grid) = feed.grid[0] {
            let now = time(grid);
            for branch in &mut branches {
                let due = branch.ahead.is_none_or(|h| now - branch.began > h - 1e-6);
                if let (Some(belief), true) = (&branch.belief, due) {
                    sensors.look(Plain, &feed, instant, &belief.x);
                    for (output, channel) in channels.iter_mut().enumerate() {
                        let ([mean], [variance]) = sensors.expect(Plain, output, belief);
                        let [measured] = std::array::from_fn::<f64, 1, _>(|lane| {
                            problem.measured(&stretches, &feed.grid, lane, output)
                        });
                        let at = channel.predictions.iter_mut().find(|p| p.ahead == branch.ahead);
                        if let (Some(at), false) = (at, measured.is_nan()) {
                            at.add(sensors.error(output, measured, mean), variance);
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
                    // of the first sample nothing is predicted but what is believed beforehand
                    if now > begin {
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
                    (branch.belief, branch.began) = (Some(belief.clone()), now);
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
        }
    }
    for (channel, z) in channels.iter_mut().zip(&z) {
        let takes_part = channel.squares > BESIDE * BESIDE * z.len() as f64;
        channel.whiteness = Whiteness::of(if takes_part { z } else { &[] });
    }
    Forecast { run: problem.tracks[track].name.clone(), channels }
}

impl<const L: usize> Sensors<'_, L> {
    /// Measured less predicted; of an angle the shortest way.
    fn error(&self, output: usize, measured: f64, predicted: f64) -> f64 {
        if self.is_turn(output) { shortest(measured - predicted) } else { measured - predicted }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// White numbers pass at 1 % in all but some of a hundred, correlated ones never do.
    #[test]
    fn law_white_innovations_pass_and_coloured_do_not() {
        let p = |colour: f64, seed: u64| {
            let z = Noise::new(seed, 1).coloured(600, colour);
            Whiteness::of(&z[..300]).with(&Whiteness::of(&z[300..])).p_value()
        };
        let white = (0..100).filter(|seed| p(0.0, *seed) < 0.01).count();
        assert!(white <= 5, "{white}");
        assert!((0..100).all(|seed| p(0.4, seed) < 0.01));
        assert_eq!(Whiteness::of(&[1.0; 3]).p_value(), 1.0);
    }
}
