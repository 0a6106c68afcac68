//! A thruster on a bench: fit of curve, dead time and rotor lag to command and force over time.
//!
//! ```text
//! n' = (V'(t − d) − n) r(|n|),      F = F₀ + a n|n| + b n,      V' = sign(V) max(0, |V| − c)
//! r(n) = 1/T₁ + (1/T₂ − 1/T₁) (n − n₁)/(n₂ − n₁)  =  (1 + κ n)/T
//! ```
//!
//! The load cell is taken to ring with the bench if that reduces the sum of squared residuals by
//! more than a tenth; its reading y is then
//!
//! ```text
//! y'' = ω² (F − y) − 2 ζ ω y'
//! ```
//!
//! n: speed of the rotor, as the command that holds it; d: dead time, s; T₁, T₂: time constants of
//! the rotor, s, at the least and the greatest |command| of the runs, n₁ and n₂, which are what
//! runs show; T: time constant near rest, s, and κ: relative increase of the rotor's rate for each
//! unit of its speed, both reported only if the runs come near rest; F₀: zero of the load cell, N,
//! one for each run; a, b, c as in [`curve`](super::curve), a and b one pair for each direction.
//! The command is held between samples. The fit is least squares by Levenberg-Marquardt; standard
//! deviations are those of a sandwich over blocks of a second, because a bench rings and its
//! residuals are not white. Source of the lag that falls with speed: Yoerger, Cooke and Slotine,
//! IEEE J. Oceanic Eng. 15 (1990) 167-178; Healey et al., IEEE J. Oceanic Eng. 20 (1995) 354-361.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::curve::Coefficients;

/// One run of the bench.
#[derive(Debug, Clone, Copy)]
pub struct BenchRun<'a> {
    /// Time stamps of command and force, s.
    pub time: &'a [f64],
    /// Command, V or normalised.
    pub command: &'a [f64],
    /// Force along the axis, N.
    pub force: &'a [f64],
}

/// A number with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Value {
    /// Estimate.
    pub value: f64,
    /// Standard deviation; 0 if the value was held.
    pub std: f64,
}

/// The properties of a thruster that a bench shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BenchFit {
    /// Quadratic and linear coefficient ahead, N; `None` without commands ahead.
    pub forward: Option<[Value; 2]>,
    /// The same astern.
    pub reverse: Option<[Value; 2]>,
    /// Dead band c of the command.
    pub deadband: Value,
    /// Dead time d, s.
    pub delay: Value,
    /// Time constant T of the rotor near rest, s; `None` if no command comes near rest.
    pub lag: Option<Value>,
    /// κ: the time constant at speed n is T/(1 + κ|n|); `None` with `lag`.
    pub lag_slope: Option<Value>,
    /// Time constant at the least, the middle and the greatest |command| of the runs, s: command and value.
    pub lag_at: Vec<(f64, Value)>,
    /// Resonance of the bench, Hz, and its damping ratio ζ, if it rings.
    pub ringing: Option<[Value; 2]>,
    /// Zero of the load cell in each run, N.
    pub offsets: Vec<Value>,
    /// Root mean square of the residuals, N.
    pub rms: f64,
    /// Part of the variance of the force that is explained.
    pub explained: f64,
    /// Whether the search converged.
    pub converged: bool,
}

/// The reason why the runs of a bench cannot be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BenchError {
    /// Too few rows.
    #[error("a bench run needs at least 50 rows with command and force, but has {0}")]
    TooFew(usize),
    /// The command does not change.
    #[error("the command of the bench never changes: the lag needs steps or a sweep")]
    Constant,
}

/// Index of each unknown among the parameters; `None` if it is held.
struct Places {
    forward: Option<usize>,
    reverse: Option<usize>,
    deadband: Option<usize>,
    dynamics: usize,
    offsets: usize,
    ringing: Option<usize>,
    held_deadband: f64,
    /// Least and greatest |command|.
    commands: [f64; 2],
}

/// Share of rows above which a part is fitted: the curve of a direction by the commands in that
/// direction, the dead band by the small commands.
const NEAR_ZERO: f64 = 0.02;
/// Ratio of the cost with ringing to that without below which the bench counts as ringing.
const RINGS: f64 = 0.9;
/// Maximum number of steps of the search.
const STEPS: usize = 100;
/// Shortest time constant, s: below it a step is over within the samples of any bench.
const LEAST_LAG: f64 = 1e-3;
/// Largest ratio of the least to the greatest |command| at which the least one counts as near rest.
const NEAR_REST: f64 = 0.1;
/// Length of a block of the sandwich, s.
const BLOCK: f64 = 1.0;

/// Fits the runs of one thruster together. `deadband`: the known dead band, held if the commands do
/// not come near 0.
///
/// # Errors
/// [`BenchError`].
pub fn fit_bench(runs: &[BenchRun<'_>], deadband: f64) -> Result<BenchFit, BenchError> {
    let rows: usize = runs.iter().map(|r| r.time.len()).sum();
    if rows < 50 {
        return Err(BenchError::TooFew(rows));
    }
    let commands = || runs.iter().flat_map(|r| r.command).copied();
    if runs.iter().all(|r| r.command.iter().all(|v| v.to_bits() == r.command[0].to_bits())) {
        return Err(BenchError::Constant);
    }
    let least = commands().map(f64::abs).fold(f64::INFINITY, f64::min);
    let most = commands().map(f64::abs).fold(0.0, f64::max);
    let share = |keep: &dyn Fn(f64) -> bool| commands().filter(|v| keep(*v)).count() as f64 / rows as f64;
    let ahead = share(&|v| v > 0.05 * most) > NEAR_ZERO;
    let astern = share(&|v| v < -0.05 * most) > NEAR_ZERO;
    // the dead band shows if commands come near it
    let small = least < 0.1 * most && share(&|v| v.abs() > 0.02 * most && v.abs() < 0.3 * most) > NEAR_ZERO;
    let mut next = 0;
    let mut take = |there: bool, n: usize| {
        let at = next;
        next += if there { n } else { 0 };
        there.then_some(at)
    };
    let quiet = Places {
        forward: take(ahead, 2),
        reverse: take(astern, 2),
        deadband: take(small, 1),
        dynamics: take(true, 3).unwrap_or(0),
        offsets: take(true, runs.len()).unwrap_or(0),
        ringing: None,
        held_deadband: deadband,
        commands: [least, most],
    };
    let width = next;
    let plain = search(runs, &quiet, start(runs, &quiet, width, most));
    let rings = Places { ringing: Some(width), ..quiet };
    // a lever with a load cell rings at some 20 Hz with little damping
    let begin = plain.best.clone().resize_vertically(width + 2, 0.0);
    let rung = (0..3)
        .map(|k| {
            let mut begin = begin.clone();
            (begin[width], begin[width + 1]) = (10.0 * f64::powi(2.0, k), 0.2);
            (begin[rings.dynamics], begin[rings.dynamics + 1], begin[rings.dynamics + 2]) = (0.005, 0.02, 0.015);
            search(runs, &rings, begin)
        })
        .min_by(|a, b| a.cost.total_cmp(&b.cost));
    let (places, Found { best, residuals, cost, converged }) = match rung {
        Some(rung) if rung.cost < RINGS * plain.cost => (rings, rung),
        _ => (Places { ringing: None, ..rings }, plain),
    };
    let covariance = covariance(runs, &places, &best, &residuals);
    Ok(told(runs, &places, &best, &covariance, cost, converged))
}

/// The end of a search.
struct Found {
    best: DVector<f64>,
    residuals: DVector<f64>,
    cost: f64,
    converged: bool,
}

/// Number of dampings that are tried for one step: from the least, 1e-12, to one with which a step
/// vanishes.
const TRIES: usize = 24;

/// Levenberg-Marquardt.
fn search(runs: &[BenchRun<'_>], places: &Places, begin: DVector<f64>) -> Found {
    let mut best = begin;
    let (mut residuals, mut cost) = priced(runs, places, &best);
    let (mut damping, mut converged) = (1e-3, false);
    for _ in 0..STEPS {
        let jacobian = jacobian(runs, places, &best, &residuals);
        let normal = jacobian.tr_mul(&jacobian);
        let gradient = jacobian.tr_mul(&residuals);
        let (mut fell, mut solved) = (0.0, true);
        for _ in 0..TRIES {
            let mut damped = normal.clone();
            for k in 0..best.len() {
                damped[(k, k)] += damping * normal[(k, k)].max(1e-12);
            }
            let Some(step) = damped.lu().solve(&gradient) else {
                solved = false;
                break;
            };
            let tried = bounded(&(&best - step), places);
            let (other, price) = priced(runs, places, &tried);
            if price < cost {
                fell = (cost - price) / cost;
                (best, residuals, cost) = (tried, other, price);
                damping = (damping * 0.2).max(1e-12);
                break;
            }
            damping *= 5.0;
        }
        if fell < 1e-7 {
            // if no step of any length lowers a finite cost, this is a minimum
            converged = solved && cost.is_finite();
            break;
        }
    }
    Found { best, residuals, cost, converged }
}

/// The start of the search: a curve with 0.8 of the greatest force at the greatest command, a dead
/// time of 0.01 s, time constants of 0.1 s and 0.06 s.
fn start(runs: &[BenchRun<'_>], places: &Places, width: usize, most: f64) -> DVector<f64> {
    let mut x = DVector::zeros(width);
    let greatest = runs.iter().flat_map(|r| r.force).fold(0.0, |m: f64, f| m.max(f.abs()));
    for place in [places.forward, places.reverse].into_iter().flatten() {
        (x[place], x[place + 1]) = (0.5 * greatest / (most * most), 0.3 * greatest / most);
    }
    if let Some(place) = places.deadband {
        x[place] = places.held_deadband.max(0.02 * most);
    }
    (x[places.dynamics], x[places.dynamics + 1], x[places.dynamics + 2]) = (0.01, 0.1, 0.06);
    x
}

/// Limits dead band, dead time, lag and ringing to meaningful values.
fn bounded(x: &DVector<f64>, places: &Places) -> DVector<f64> {
    let mut x = x.clone();
    if let Some(place) = places.deadband {
        x[place] = x[place].max(0.0);
    }
    x[places.dynamics] = x[places.dynamics].clamp(0.0, 1.0);
    x[places.dynamics + 1] = x[places.dynamics + 1].clamp(LEAST_LAG, 10.0);
    x[places.dynamics + 2] = x[places.dynamics + 2].clamp(LEAST_LAG, 10.0);
    if let Some(place) = places.ringing {
        x[place] = x[place].clamp(1.0, 1e3);
        x[place + 1] = x[place + 1].clamp(1e-3, 0.95);
    }
    x
}

/// Residuals and their sum of squares.
fn priced(runs: &[BenchRun<'_>], places: &Places, x: &DVector<f64>) -> (DVector<f64>, f64) {
    let mut residuals = Vec::new();
    for (k, run) in runs.iter().enumerate() {
        let offset = x[places.offsets + k];
        let mut shown: Vec<f64> = rotor(run, places, x).into_iter().map(|n| thrust(n, places, x)).collect();
        if let Some(place) = places.ringing {
            shown = rung(&shown, run.time, x[place], x[place + 1]);
        }
        residuals.extend(shown.iter().zip(run.force).map(|(shown, force)| shown + offset - force));
    }
    let residuals = DVector::from_vec(residuals);
    let cost = residuals.norm_squared();
    (residuals, cost)
}

/// Reading of a bench with this resonance (Hz) and damping ratio under a force; exact for a force
/// that is constant between stamps.
fn rung(force: &[f64], time: &[f64], frequency: f64, damping: f64) -> Vec<f64> {
    let omega = std::f64::consts::TAU * frequency;
    let free = omega * (1.0 - damping * damping).sqrt();
    let (mut y, mut rate) = (force[0], 0.0);
    let mut out = vec![y];
    for k in 1..force.len() {
        let h = time[k] - time[k - 1];
        let mean = 0.5 * (force[k] + force[k - 1]);
        let (decay, sin, cos) = ((-damping * omega * h).exp(), (free * h).sin(), (free * h).cos());
        let (off, slope) = (y - mean, (rate + damping * omega * (y - mean)) / free);
        // e^(−ζωt) (A cos + B sin) with A = y − F, B = (y' + ζωA)/ω_d, and its derivative
        y = mean + decay * (off * cos + slope * sin);
        rate = decay * (rate * cos - (damping * omega * slope + free * off) * sin);
        out.push(y);
    }
    out
}

fn thrust(n: f64, places: &Places, x: &DVector<f64>) -> f64 {
    let place = if n >= 0.0 { places.forward } else { places.reverse };
    place.map_or(0.0, |p| x[p] * n * n.abs() + x[p + 1] * n)
}

/// Rate of the rotor near rest, 1/s, and its increase for each unit of the rotor's speed.
fn rates(places: &Places, x: &DVector<f64>) -> [f64; 2] {
    let [least, most] = places.commands;
    let [slow, fast] = [1, 2].map(|k| 1.0 / x[places.dynamics + k]);
    let slope = if most > least { (fast - slow) / (most - least) } else { 0.0 };
    [slow - slope * least, slope]
}

/// Speed of the rotor at each stamp. The command acts with the delay d, so that a step may fall
/// between stamps.
fn rotor(run: &BenchRun<'_>, places: &Places, x: &DVector<f64>) -> Vec<f64> {
    let band = places.deadband.map_or(places.held_deadband, |p| x[p]);
    let delay = x[places.dynamics];
    let [rest, slope] = rates(places, x);
    let live = |v: f64| v.signum() * (v.abs() - band).max(0.0);
    let (time, command) = (run.time, run.command);
    let mut n = live(command[0]);
    let mut out = vec![n];
    let mut at = 0;
    for k in 1..time.len() {
        let (mut t, end) = (time[k - 1], time[k]);
        while t < end {
            while at + 1 < time.len() && time[at + 1] + delay <= t {
                at += 1;
            }
            let until = if at + 1 < time.len() { (time[at + 1] + delay).min(end) } else { end };
            let until = if until > t { until } else { end };
            let wanted = if t < time[0] + delay { command[0] } else { command[at] };
            let rate = (rest + slope * n.abs()).max(0.1);
            n += (live(wanted) - n) * (1.0 - (-rate * (until - t)).exp());
            t = until;
        }
        out.push(n);
    }
    out
}

/// Derivatives of the residuals, by finite differences.
fn jacobian(runs: &[BenchRun<'_>], places: &Places, x: &DVector<f64>, residuals: &DVector<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(residuals.len(), x.len());
    for k in 0..x.len() {
        let step = 1e-5 * x[k].abs().max(1e-2);
        let mut moved = x.clone();
        moved[k] += step;
        let (other, _) = priced(runs, places, &moved);
        out.set_column(k, &((other - residuals) / step));
    }
    out
}

/// Covariance by the sandwich: the inverse normal matrix on both sides of the sum over blocks of a
/// second.
fn covariance(runs: &[BenchRun<'_>], places: &Places, x: &DVector<f64>, residuals: &DVector<f64>) -> DMatrix<f64> {
    let jacobian = jacobian(runs, places, x, residuals);
    let width = x.len();
    let Some(bread) = jacobian.tr_mul(&jacobian).try_inverse() else {
        return DMatrix::from_diagonal_element(width, width, f64::INFINITY);
    };
    let (mut meat, mut row) = (DMatrix::zeros(width, width), 0);
    for run in runs {
        let block = |k: usize| ((run.time[k] - run.time[0]) / BLOCK).floor() as i64;
        let mut sum = DVector::zeros(width);
        for k in 0..run.time.len() {
            sum += jacobian.row(row).transpose() * residuals[row];
            row += 1;
            if k + 1 == run.time.len() || block(k + 1) != block(k) {
                meat += &sum * sum.transpose();
                sum.fill(0.0);
            }
        }
    }
    &bread * meat * &bread
}

/// A function of the parameters, with its standard deviation by its gradient.
fn derived(of: &dyn Fn(&DVector<f64>) -> f64, x: &DVector<f64>, covariance: &DMatrix<f64>) -> Value {
    let value = of(x);
    let gradient = DVector::from_fn(x.len(), |k, _| {
        let step = 1e-6 * x[k].abs().max(1e-3);
        let mut moved = x.clone();
        moved[k] += step;
        (of(&moved) - value) / step
    });
    // a parameter of unknown value (infinite variance) does not count if the function does not
    // depend on it
    let known = DMatrix::from_fn(x.len(), x.len(), |i, j| {
        let product = gradient[i] * gradient[j];
        if product == 0.0 { 0.0 } else { product * covariance[(i, j)] }
    });
    Value { value, std: known.sum().max(0.0).sqrt() }
}

fn told(
    runs: &[BenchRun<'_>],
    places: &Places,
    x: &DVector<f64>,
    covariance: &DMatrix<f64>,
    cost: f64,
    converged: bool,
) -> BenchFit {
    let value = |k: usize| Value { value: x[k], std: covariance[(k, k)].max(0.0).sqrt() };
    let pair = |place: Option<usize>| place.map(|p| [value(p), value(p + 1)]);
    let from = |of: &dyn Fn([f64; 2]) -> f64| derived(&|x| of(rates(places, x)), x, covariance);
    let [least, most] = places.commands;
    let at = |n: f64| (n, from(&|[rest, slope]| 1.0 / (rest + slope * n)));
    let near_rest = least <= NEAR_REST * most && rates(places, x)[0] > 0.0;
    let rows: usize = runs.iter().map(|r| r.time.len()).sum();
    let scatter: f64 = runs
        .iter()
        .map(|run| {
            let mean = run.force.iter().sum::<f64>() / run.force.len() as f64;
            run.force.iter().map(|f| (f - mean).powi(2)).sum::<f64>()
        })
        .sum();
    BenchFit {
        forward: pair(places.forward),
        reverse: pair(places.reverse),
        deadband: places.deadband.map_or(Value { value: places.held_deadband, std: 0.0 }, value),
        delay: value(places.dynamics),
        lag: near_rest.then(|| from(&|[rest, _]| 1.0 / rest)),
        lag_slope: near_rest.then(|| from(&|[rest, slope]| slope / rest)),
        lag_at: [least, 0.5 * (least + most), most].map(at).to_vec(),
        ringing: places.ringing.map(|p| [value(p), value(p + 1)]),
        offsets: (0..runs.len()).map(|k| value(places.offsets + k)).collect(),
        rms: (cost / rows as f64).sqrt(),
        explained: 1.0 - cost / scatter.max(f64::MIN_POSITIVE),
        converged,
    }
}

impl BenchFit {
    /// Curve coefficients ahead and astern; a direction in which the bench did not run has those of
    /// the other.
    pub fn coefficients(&self) -> Option<[Coefficients; 2]> {
        let of = |pair: [Value; 2]| Coefficients { a: pair[0].value, b: pair[1].value };
        let forward = self.forward.or(self.reverse)?;
        Some([of(forward), of(self.reverse.unwrap_or(forward))])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thrust::noise::Noise;

    /// A sweep of steps under `n' = (V' − n)(1 + κ|n|)/T`, by fine Euler steps, independent of the
    /// fit.
    fn bench(seed: u64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let (band, delay, lag, slope, a, b, zero) = (0.08, 0.03, 0.12, 1.5, 36.0, 23.0, 2.0);
        let command = |t: f64| 0.9 * ((t / 0.7).floor() * 2.3).sin();
        let (mut n, mut noise) = (0.0, Noise::new(seed));
        let (mut time, mut commands, mut forces) = (Vec::new(), Vec::new(), Vec::new());
        let fine = 1e-4;
        for k in 0..400_000 {
            let t = f64::from(k) * fine;
            if k % 50 == 0 {
                time.push(t);
                commands.push(command(t));
                let thrust: f64 = a * n * f64::abs(n) + b * n;
                forces.push(zero + thrust + 0.3 * noise.normal());
            }
            let v: f64 = if t < delay { command(0.0) } else { command(t - delay) };
            let live = v.signum() * (v.abs() - band).max(0.0);
            n += fine * (live - n) * (1.0 + slope * f64::abs(n)) / lag;
        }
        (time, commands, forces)
    }

    #[test]
    fn curve_lag_and_dead_time_come_back() {
        let (time, command, force) = bench(3);
        let fit = fit_bench(&[BenchRun { time: &time, command: &command, force: &force }], 0.05).unwrap();
        assert!(fit.converged && fit.explained > 0.99, "{fit:?}");
        let near = |v: Value, truth: f64| {
            // four standard deviations, and the error of frozen rates over a step of 5 ms
            assert!((v.value - truth).abs() < 4.0 * v.std + 0.01 * truth.abs(), "{v:?} against {truth}");
        };
        near(fit.lag.unwrap(), 0.12);
        near(fit.lag_slope.unwrap(), 1.5);
        // T/(1 + κ n) at the greatest command
        let (n, lag) = fit.lag_at[2];
        near(lag, 0.12 / (1.0 + 1.5 * n));
        near(fit.deadband, 0.08);
        near(fit.offsets[0], 2.0);
        // the fit holds the command between samples of 5 ms: a step is seen up to one sample late
        assert!((fit.delay.value - 0.03).abs() < 0.006, "{:?}", fit.delay);
        let [forward, reverse] = fit.coefficients().unwrap();
        for c in [forward, reverse] {
            assert!((c.a + c.b - 59.0).abs() < 1.0, "{c:?}");
        }
    }

    #[test]
    fn what_shows_nothing_is_refused() {
        let (time, force) = ((0..100).map(|k| 0.01 * f64::from(k)).collect::<Vec<_>>(), vec![1.0; 100]);
        let still = BenchRun { time: &time, command: &force, force: &force };
        assert_eq!(fit_bench(&[still], 0.0), Err(BenchError::Constant));
        let short = BenchRun { time: &time[..9], command: &force[..9], force: &force[..9] };
        assert_eq!(fit_bench(&[short], 0.0), Err(BenchError::TooFew(9)));
    }
}
