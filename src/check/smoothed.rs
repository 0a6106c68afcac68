//! Angles that an estimator has smoothed: their noise is slow, and their differences are too quiet.
//!
//! ```text
//! Δe = Δψ − c ∫ψ̇(r) dt − β Δt − d Δr − …         residual of the angle against the gyro, step by step
//! white noise of a sensor   ρ₁ = corr(Δeₖ, Δeₖ₊₁) = −½
//! smoothed over T           ρ₁ = −(1 − a)/2,   ⟨Δe²⟩ = 2 σ² (1 − a),   D(K) = 2 σ² (1 − aᴷ),   a = e^(−Δ/T)
//! integral of the gyro      ⟨Δe²⟩ = (σ_r Δ)²,  D(K) = K (σ_r Δ)²
//! both of these             ρ₁ = −w/2,         D(K) = (w + K (1 − w)) ⟨Δe²⟩
//! ```
//!
//! D(K) is the mean square of the change of e over K steps. An angle is reported if ρ₁ is not that of
//! white noise, Δe is larger than the noise of the gyro makes it (σ_r from third differences), D stops
//! growing, and ρ₁ belongs to the T that D shows. All four are required, so that a good angle
//! beside a noisy gyro, a filtered gyro and stamps that are late at random are not reported: the
//! latter make a white error of the angle beside a rate whose integral wanders. A smoothing whose
//! error is below the integrated noise of the gyro is not detected. Source of the structure
//! function: Allan, *Proceedings of the IEEE* 54 (1966) 221-230.

use super::attitude::{self, kinematics};
use super::codes;
use super::fit::fit;
use super::report::{Agreement, Found};
use super::samples::Samples;
use crate::frame::Dof;
use crate::log::number::short;
use crate::run::Run;

/// Least number of steps that distinguish −½ from the correlation of a smoothed angle.
const ROWS: usize = 150;
/// Range of the correlation of neighbouring steps of a smoothed angle: white noise lies below it,
/// slow motion above it.
const QUIET: [f64; 2] = [-0.33, 0.15];
/// Least ⟨Δe²⟩, relative to that from the noise of the gyro.
const BEYOND_GYRO: f64 = 4.0;
/// Greatest D(K)/(K D(1)); independent steps have 1.
const SATURATED: f64 = 0.8;
/// Largest distance of ρ₁ below the value that belongs to T, in standard deviations of 1/√n.
const SCATTER: f64 = 2.5;
/// Time over which D is evaluated, s.
const REACH: f64 = 2.0;

/// An angle that was smoothed.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// Channel.
    pub channel: &'static str,
    /// Time constant T, s.
    pub seconds: f64,
    /// Standard deviation σ of its error, rad.
    pub error: f64,
    /// Number of samples, and number of independent samples that they are worth: n (1 − a)/(1 + a).
    pub samples: [f64; 2],
}

/// Returns the smoothed angles of a run; the lags of `agreements`, those of [`attitude::measure`],
/// are removed.
pub fn measure(run: &Run, agreements: &[Agreement]) -> Vec<Smoothed> {
    [Dof::Roll, Dof::Pitch, Dof::Yaw].into_iter().filter_map(|dof| of(run, dof, agreements)).collect()
}

fn of(run: &Run, dof: Dof, agreements: &[Agreement]) -> Option<Smoothed> {
    let angle = Samples::of_angle(run.signal(dof.position())?)?;
    let rate = Samples::of(run.signal(dof.velocity())?)?;
    let agreement = agreements.iter().find(|a| a.channel == dof.velocity());
    // an angle that turns without relation to its rate shows nothing here
    if agreement.is_none() && spread(angle.values()) > 0.3 {
        return None;
    }
    let step = angle.step().max(rate.step());
    let late = agreement.and_then(|a| a.lag).map_or(0.0, |l| l.seconds);
    let late = if late.abs() > 0.5 * step { late } else { 0.0 };
    let every = (rate.step() / angle.step() - 0.25).ceil().max(1.0) as usize;
    let level = attitude::level_windows(run);
    let chosen: Vec<usize> = (0..angle.values().len()).step_by(every).collect();
    let usual = every as f64 * angle.step();
    let whole = |w: &&[usize]| {
        let (a, b) = (angle.time()[w[0]], angle.time()[w[1]]);
        let inside = a - late >= rate.time()[0] && b - late <= rate.time()[rate.time().len() - 1];
        inside && (0.5..1.5).contains(&((b - a) / usual)) && level(&(a, b))
    };
    let steps: Vec<&[usize]> = chosen.windows(2).filter(whole).collect();
    if steps.len() < ROWS {
        return None;
    }
    let (own, others) = kinematics(run, dof, &rate);
    let over = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        steps.iter().map(|w| f(angle.time()[w[0]], angle.time()[w[1]])).collect()
    };
    let target: Vec<f64> = steps.iter().map(|w| angle.values()[w[1]] - angle.values()[w[0]]).collect();
    let mut columns = vec![
        over(&|a, b| own.integral(a - late, b - late)),
        over(&|a, b| b - a),
        over(&|a, b| rate.at(b - late) - rate.at(a - late)),
    ];
    let rest = over(&|a, b| others.integral(a - late, b - late));
    if rest.iter().map(|x| x * x).sum::<f64>() > 1e-4 * columns[0].iter().map(|x| x * x).sum::<f64>() {
        columns.push(rest);
    }
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let theta = fit(&columns, &target)?.theta;
    let left: Vec<f64> =
        (0..target.len()).map(|k| target[k] - columns.iter().zip(&theta).map(|(c, x)| c[k] * x).sum::<f64>()).collect();
    let stretches: Vec<(usize, usize)> = stretches(&steps);
    let square = left.iter().map(|x| x * x).sum::<f64>() / left.len() as f64;
    let neighbours = mean(stretches.iter().flat_map(|(a, b)| left[*a..*b].windows(2).map(|w| w[0] * w[1])))?;
    let correlation = neighbours / square;
    // the standard deviation of a correlation of −½ from n samples is 0.7/√n
    let least = QUIET[0].max(-0.5 + 3.5 / (left.len() as f64).sqrt());
    let gyro = (rate.noise() * theta[0]).powi(2) * rate.step() * usual;
    let count = (REACH / usual).round().max(4.0) as usize;
    let far = mean(stretches.iter().flat_map(|(a, b)| {
        let sums: Vec<f64> = std::iter::once(0.0)
            .chain(left[*a..*b].iter().scan(0.0, |sum, x| {
                *sum += x;
                Some(*sum)
            }))
            .collect();
        (count..sums.len()).map(move |k| (sums[k] - sums[k - count]).powi(2)).collect::<Vec<_>>()
    }))?;
    let smoothed = (least..QUIET[1]).contains(&correlation)
        && square > BEYOND_GYRO * gyro
        && far < SATURATED * count as f64 * square;
    if !smoothed {
        return None;
    }
    let kept = memory((far - count as f64 * gyro).max(0.0) / (square - gyro), count);
    let belongs = -0.5 * (1.0 - kept) - SCATTER / (left.len() as f64).sqrt();
    (neighbours / (square - gyro) > belongs).then(|| Smoothed {
        channel: dof.position(),
        seconds: -usual / kept.ln(),
        error: ((square - gyro) / (2.0 * (1.0 - kept))).sqrt(),
        samples: [left.len() as f64, left.len() as f64 * (1.0 - kept) / (1.0 + kept)],
    })
}

/// Returns the runs of consecutive steps.
fn stretches(steps: &[&[usize]]) -> Vec<(usize, usize)> {
    let mut found = vec![(0, 1)];
    for k in 1..steps.len() {
        match found.last_mut() {
            Some(last) if steps[k][0] == steps[k - 1][1] => last.1 = k + 1,
            _ => found.push((k, k + 1)),
        }
    }
    found
}

/// Returns the a of (1 − aᴷ)/(1 − a) = `ratio`, by bisection.
fn memory(ratio: f64, count: usize) -> f64 {
    let (mut low, mut high) = (0.01_f64, 0.9999);
    for _ in 0..60 {
        let a = 0.5 * (low + high);
        if (1.0 - a.powi(count as i32)) / (1.0 - a) < ratio { low = a } else { high = a }
    }
    0.5 * (low + high)
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (n, sum) = values.fold((0_usize, 0.0), |(n, sum), x| (n + 1, sum + x));
    (n > 0).then(|| sum / n as f64)
}

fn spread(values: &[f64]) -> f64 {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    high - low
}

/// Reports how many independent samples the samples of smoothed angles are worth.
pub fn judge(smoothed: &[Smoothed]) -> Vec<Found> {
    let say = |s: &Smoothed| {
        let text = format!(
            "{} is smoothed by an estimator (EKF, complementary filter): its error of about {}° lasts {} s, and it \
             varies far less from sample to sample than a sensor does; {} samples are worth about {} independent ones. \
             The default fit estimates such noise; output_error and integral treat each sample as independent: log the \
             raw compass or tilt as well",
            s.channel,
            short(s.error.to_degrees(), 2),
            short(s.seconds, 2),
            s.samples[0] as usize,
            s.samples[1].ceil() as usize
        );
        Found::new(&codes::SMOOTHED, &[s.channel], text)
    };
    smoothed.iter().map(say).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;
    use crate::run::Signal;

    /// A heading under r = 0.3 sin(0.5 t) at 10 Hz with noise of the angle and of the gyro; that of
    /// the angle is smoothed over `seconds`.
    fn sailed(seed: u64, angle: f64, gyro: f64, seconds: f64) -> Run {
        let mut noise = Noise::new(seed, 5);
        let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        let keep = if seconds > 0.0 { 1.0 - 0.1 / seconds } else { 0.0 };
        let (mut error, mut psi, mut r) = (0.0, Vec::new(), Vec::new());
        for t in time.iter() {
            error = keep * error + (1.0 - keep) * angle * noise.normal();
            psi.push(0.6 * (1.0 - (0.5 * t).cos()) + error);
            r.push(0.3 * (0.5 * t).sin() + gyro * noise.normal());
        }
        let mut run = Run::default();
        run.signals.insert("psi".into(), Signal::new(time.clone(), psi));
        run.signals.insert("r".into(), Signal::new(time, r));
        run
    }

    fn of_run(run: &Run) -> Vec<Smoothed> {
        measure(run, &attitude::measure(run))
    }

    #[test]
    fn a_smoothed_heading_is_told_with_its_time_constant() {
        for seconds in [0.3, 0.5, 1.0] {
            let found: Vec<Smoothed> = (0..20).flat_map(|seed| of_run(&sailed(seed, 0.009, 0.002, seconds))).collect();
            assert!(found.len() >= 19, "{seconds}: {}", found.len());
            let mean = |f: fn(&Smoothed) -> f64| found.iter().map(f).sum::<f64>() / found.len() as f64;
            // a sample every 0.1 s, 600 of them: single runs scatter by a third
            assert!((mean(|s| s.seconds) / seconds - 1.0).abs() < 0.3, "{seconds}: {}", mean(|s| s.seconds));
            let keep = 1.0 - 0.1 / seconds;
            let error = 0.009 * ((1.0 - keep) / (1.0 + keep)).sqrt();
            assert!((mean(|s| s.error) / error - 1.0).abs() < 0.2, "{seconds}: {}", mean(|s| s.error));
        }
        let found = judge(&of_run(&sailed(1, 0.009, 0.002, 0.5)));
        assert_eq!((found[0].code.code, &found[0].channels[..]), ("K106", &["psi".to_string()][..]));
    }

    /// A compass with white noise of half a degree in zig-zags of 2 rad/s; the stamps of both
    /// sensors are late at random, by 20 ms on average.
    #[test]
    fn stamps_that_come_late_by_chance_are_no_smoothing() {
        let heading = |t: f64| 1.5 * (1.0 - (1.3 * t).cos()) + 0.4 * (0.45 * t).sin();
        let rate = |t: f64| 1.95 * (1.3 * t).sin() + 0.18 * (0.45 * t).cos();
        for seed in 0..20 {
            let mut noise = Noise::new(seed, 6);
            let mut logged = |step: f64, sigma: f64, of: &dyn Fn(f64) -> f64| {
                let taken = (0..(40.0 / step) as usize).map(|k| step * k as f64);
                let mut rows: Vec<(f64, f64)> = taken
                    .map(|t| {
                        // half the sum of two squared normal numbers is exponential
                        let late = 0.01 * (noise.normal().powi(2) + noise.normal().powi(2));
                        (t + late, of(t) + sigma * noise.normal())
                    })
                    .collect();
                rows.sort_by(|a, b| a.0.total_cmp(&b.0));
                rows.dedup_by(|a, b| a.0 <= b.0);
                let (time, values): (Vec<f64>, Vec<f64>) = rows.into_iter().unzip();
                Signal::new(time.into(), values)
            };
            let mut run = Run::default();
            run.signals.insert("psi".into(), logged(0.1, 0.009, &heading));
            run.signals.insert("r".into(), logged(0.05, 0.005, &rate));
            let found = of_run(&run);
            assert!(found.is_empty(), "{seed}: {found:?}");
        }
    }

    /// Noise of a sensor, a good angle beside a noisy gyro, exact data, a dead gyro.
    #[test]
    fn sound_angles_are_not_told() {
        for seed in 0..20 {
            for (angle, gyro) in [(0.009, 0.003), (0.0005, 0.003), (0.0, 0.003), (0.001, 1e-5), (0.0, 0.0)] {
                let found = of_run(&sailed(seed, angle, gyro, 0.0));
                assert!(found.is_empty(), "{seed} {angle} {gyro}: {found:?}");
            }
            let mut dead = sailed(seed, 0.009, 0.003, 0.0);
            let rest: Vec<f64> = dead.signals["r"].values().iter().map(|x| 1e-7 * x).collect();
            let time = dead.signals["r"].shared_time().clone();
            dead.signals.insert("r".into(), Signal::new(time, rest));
            assert!(of_run(&dead).is_empty());
        }
    }
}
