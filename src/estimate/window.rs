//! Length of the windows over which a start is regressed: long enough against the noise of the
//! velocities, short compared with the motion.
//!
//! ```text
//! D(W) = ⟨(ν(t + W) − ν(t))²⟩ − 2 σ²
//! W: the least of 1, 2, 4, … 32 s with D(W) ≥ 10 · 2 σ² in all that move,
//!    and at most a half of the least with D(W) ≥ var ν
//! ```
//!
//! σ² is the white noise of the sensor, by second differences. A noise of 2 σ² in changes of
//! D + 2 σ² shrinks what is regressed on them by their ratio: a tenth is left to the fit. D reaches var ν
//! after about the time constant of the motion. A vehicle with a time constant of a second shows
//! its changes within one second; a ship that is logged once a second shows noise.

use crate::frame::Dof;
use crate::run::{Run, Signal};

/// Shortest window, s.
const SHORTEST: f64 = 1.0;

/// Multiples of the shortest window that are tried.
const TIMES: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// Ratio of changes to noise, as variances, from which on a window is long enough.
const CLEAR: f64 = 10.0;

/// Length of the windows for the velocities `dofs` of `runs`, s.
pub(super) fn length(dofs: &[Dof], runs: &[Run]) -> f64 {
    let (mut wanted, mut most) = (SHORTEST, f64::INFINITY);
    for dof in dofs {
        let signals: Vec<&Signal> = runs.iter().filter_map(|run| run.signal(dof.velocity())).collect();
        let noise = 2.0 * mean(signals.iter().map(|s| s.white_noise().powi(2)));
        let changes = TIMES.map(|times| mean(signals.iter().filter_map(|s| change(s, times * SHORTEST))) - noise);
        let window = |enough: f64| changes.iter().position(|d| *d >= enough).map(|k| TIMES[k] * SHORTEST);
        let Some(long_enough) = window(CLEAR * noise) else { continue };
        wanted = wanted.max(long_enough);
        let variance = mean(signals.iter().map(|s| variance(s.values()))) - 0.5 * noise;
        most = most.min(window(variance).map_or(f64::INFINITY, |settled| 0.5 * settled));
    }
    wanted.min(most).max(SHORTEST)
}

fn mean(of: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = of.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    if count > 0.0 { sum / count } else { f64::NAN }
}

fn variance(x: &[f64]) -> f64 {
    let middle = mean(x.iter().copied());
    mean(x.iter().map(|x| (x - middle).powi(2)))
}

/// Mean square of the changes over `window` seconds, with gaps ignored; `None` if a run is no
/// longer than that.
fn change(signal: &Signal, window: f64) -> Option<f64> {
    let (time, x) = (signal.time(), signal.values());
    let step = (time.last()? - time.first()?) / (time.len() - 1) as f64;
    let lag = ((window / step).round() as usize).max(1);
    (lag < x.len()).then(|| mean(x.iter().zip(&x[lag..]).map(|(a, b)| (b - a).powi(2))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// A velocity that follows a square wave with this time constant, logged at this step, with
    /// noise.
    fn runs(constant: f64, step: f64, noise: f64) -> Vec<Run> {
        let (mut v, mut random) = (0.0, Noise::new(3, 1));
        let time: std::sync::Arc<[f64]> = (0..2000).map(|k| step * f64::from(k)).collect();
        let follow = |t: &f64| {
            let to = if (t / (6.0 * constant)).floor() % 2.0 == 0.0 { 1.0 } else { -1.0 };
            v += (step / constant) * (to - v);
            v + noise * random.normal()
        };
        let values: Vec<f64> = time.iter().map(follow).collect();
        vec![Run { signals: [("u".to_string(), Signal::new(time, values))].into(), ..Run::default() }]
    }

    #[test]
    fn windows_are_long_beside_the_noise_and_short_beside_the_motion() {
        let of = |constant, step, noise| length(&[Dof::Surge], &runs(constant, step, noise));
        assert_eq!(of(1.0, 0.1, 0.01), 1.0, "a small vehicle");
        assert_eq!(of(1.0, 0.1, 0.3), 1.0, "the motion ends before the noise does");
        assert_eq!(of(30.0, 1.0, 0.001), 1.0, "a ship with good sensors");
        let ship = of(30.0, 1.0, 0.03);
        assert!((4.0..=16.0).contains(&ship), "{ship}");
        assert_eq!(length(&[Dof::Sway], &runs(1.0, 0.1, 0.0)), 1.0, "nothing is logged");
    }
}
