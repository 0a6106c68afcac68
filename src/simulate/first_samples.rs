//! Detection of first samples of a channel that are faults of the sensor.
//!
//! ```text
//! d_k = min(|y_k − ℓ₁₂|, |y_k − ℓ₃₅|, |y_k − ℓ₄₇|)   ℓ_ij: line through samples k+i and k+j at the time of k
//! a_k = min |y_k − y_{k+i}|,  i = 1, 2, 3             s: the nine steps after the first three samples
//! wild, of k = 0, 1, 2:   d_k > 3 q₉₀(d)  and  a_k > 3 q₈₀(s)         q₉₀: of the next 200 samples
//!                         and no start from rest: y_{k+1} − y_k, y_{k+2} − y_{k+1}, y_{k+3} − y_{k+2}
//!                         of one sign, each at most twice the next
//! ```
//!
//! Nothing is known of a state before a stretch begins, so that its first samples are accepted
//! whatever they are, even by an estimator that holds outliers back. A first heading 30 standard
//! deviations off made the innovations of a whole run coloured. Even if two samples are wild, one
//! of the three lines goes through good ones. After a step of its command a vehicle starts from
//! rest on a curve that bends more from sample to sample than anything later in the log.

use super::track::NO_SAMPLE;

/// Number of later samples against which the first ones are judged.
const JUDGED: usize = 200;

/// Minimum number of samples to judge against.
const LEAST: usize = 20;

/// Quantile of the distances that counts as usual.
const USUAL: f64 = 0.9;

/// Number of steps that show how steeply a run begins, and the quantile of them that counts: one
/// wild sample makes two large steps.
const NEAR: usize = 9;
const STEEP: f64 = 0.8;

/// Ratio to the usual distance above which a sample is wild: with Gaussian noise one in a million.
const TIMES: f64 = 3.0;

/// Largest ratio of a step from rest to the next step: for a vehicle with a time constant of 1.5
/// samples or more.
const SETTLES: f64 = 2.0;

/// Number of first samples that are judged.
const FIRST: usize = 3;

/// Number of later samples that the lines use.
const AHEAD: usize = 7;

/// A first sample that is left out.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstSample {
    /// Name of the channel.
    pub channel: String,
    /// Time stamp, s.
    pub time: f64,
    /// Logged value, SI.
    pub value: f64,
}

/// Removes the wild first samples of each stretch from `observed`, which has a row for each grid
/// point with one value for each output. Returns them.
pub(super) fn leave_out(observed: &mut [f64], time: &[f64], starts: &[usize], outputs: &[String]) -> Vec<FirstSample> {
    let width = outputs.len();
    let mut left_out = Vec::new();
    for (column, channel) in outputs.iter().enumerate() {
        let turns = matches!(channel.as_str(), "phi" | "psi");
        for (k, first) in starts.iter().enumerate() {
            let last = starts.get(k + 1).copied().unwrap_or(time.len());
            let known = (*first..last).filter(|row| !observed[row * width + column].is_nan());
            let rows: Vec<usize> = known.take(FIRST + JUDGED + AHEAD).collect();
            let samples: Vec<(f64, f64)> =
                rows.iter().map(|row| (time[*row], observed[row * width + column])).collect();
            for k in wild(&samples, turns) {
                let (time, value) = samples[k];
                observed[rows[k] * width + column] = NO_SAMPLE;
                left_out.push(FirstSample { channel: channel.clone(), time, value });
            }
        }
    }
    left_out
}

/// Indices of the wild ones of the first samples. `turns`: the channel is an angle, known up to
/// whole turns.
fn wild(samples: &[(f64, f64)], turns: bool) -> Vec<usize> {
    let count = samples.len().saturating_sub(AHEAD);
    if count < FIRST + LEAST {
        return Vec::new();
    }
    let off: Vec<f64> = (0..count).map(|k| off_lines(&samples[k..=k + AHEAD], turns)).collect();
    let usual = quantile(&off[FIRST..], USUAL);
    let apart = |i: usize, j: usize| nearest_turn(samples[i].1 - samples[j].1, turns).abs();
    let steps: Vec<f64> = (FIRST..FIRST + NEAR).map(|k| apart(k, k + 1)).collect();
    let step = quantile(&steps, STEEP);
    let stands_off = |k: &usize| (1..=3).all(|i| apart(*k, k + i) > TIMES * step);
    let sets_off = |k: &usize| {
        let steps: Vec<f64> = (*k..k + 3).map(|i| nearest_turn(samples[i + 1].1 - samples[i].1, turns)).collect();
        steps.windows(2).all(|s| s[0] * s[1] > 0.0 && s[0].abs() <= SETTLES * s[1].abs())
    };
    // a channel that does not change does not show what is usual
    let far: Vec<usize> = (0..FIRST).filter(|k| usual > 0.0 && off[*k] > TIMES * usual).collect();
    let wild: Vec<usize> = far.into_iter().filter(stands_off).filter(|k| !sets_off(k)).collect();
    // if all are, the run begins like that, and it is no fault
    if wild.len() < FIRST { wild } else { Vec::new() }
}

/// A difference; for angles (`turns`), which are known up to whole turns, the smallest one.
pub(crate) fn nearest_turn(difference: f64, turns: bool) -> f64 {
    let tau = std::f64::consts::TAU;
    if turns { difference - tau * (difference / tau).round() } else { difference }
}

/// The value below which this share of the values lies. There must be at least one value.
pub(crate) fn quantile(values: &[f64], share: f64) -> f64 {
    let mut values = values.to_vec();
    let at = (share * (values.len() - 1) as f64).round() as usize;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

/// Distance of the first sample from the nearest of three lines through later ones.
fn off_lines(samples: &[(f64, f64)], turns: bool) -> f64 {
    let (t0, y0) = samples[0];
    let above = |y: f64| nearest_turn(y - y0, turns);
    let off = |i: usize, j: usize| {
        let ((ti, yi), (tj, yj)) = (samples[i], samples[j]);
        let (yi, yj) = (above(yi), above(yj));
        (yi + (yj - yi) / (tj - ti) * (t0 - ti)).abs()
    };
    off(1, 2).min(off(3, 5)).min(off(4, 7))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// A slow turn through ±π at 10 Hz with noise of 0.01 rad, wild where `spikes` are added.
    fn heading(seed: u64, spikes: &[(usize, f64)]) -> (Vec<f64>, Vec<f64>) {
        let mut noise = Noise::new(seed, 7);
        let time: Vec<f64> = (0..300).map(|k| 0.1 * f64::from(k)).collect();
        let angle = |t: &f64| 3.0 + 0.4 * (0.3 * t).sin() + 0.01 * noise.normal();
        let mut observed: Vec<f64> = time.iter().map(angle).collect();
        spikes.iter().for_each(|(k, by)| observed[*k] += by);
        let wrapped = observed.iter().map(|y| y - std::f64::consts::TAU * (y / std::f64::consts::TAU).round());
        (time, wrapped.collect())
    }

    fn left_out(seed: u64, spikes: &[(usize, f64)], starts: &[usize]) -> Vec<usize> {
        let (time, mut observed) = heading(seed, spikes);
        let left = leave_out(&mut observed, &time, starts, &["psi".to_string()]);
        let rows: Vec<usize> = (0..300).filter(|k| observed[*k].is_nan()).collect();
        assert_eq!(left.iter().map(|l| l.time).collect::<Vec<_>>(), rows.iter().map(|k| time[*k]).collect::<Vec<_>>());
        rows
    }

    #[test]
    fn a_wild_first_sample_is_left_out_and_no_other() {
        assert_eq!(left_out(1, &[(0, 0.3)], &[0]), [0]);
        assert_eq!(left_out(1, &[(0, 0.3), (2, -0.5)], &[0]), [0, 2]);
        assert_eq!(left_out(1, &[(1, 0.3)], &[0]), [1]);
        // after a gap, where another sample nearby is wild; in the middle of a stretch the
        // estimator holds it back
        assert_eq!(left_out(1, &[(150, -0.3), (152, 0.5), (80, 0.3)], &[0, 150]), [150, 152]);
        assert!(left_out(1, &[(3, 0.3), (5, 0.3)], &[0]).is_empty());
    }

    /// 500 beginnings of Gaussian noise.
    #[test]
    fn a_sound_first_sample_stays() {
        let lost: usize = (0..500).map(|seed| left_out(seed, &[], &[0]).len()).sum();
        assert_eq!(lost, 0);
    }

    #[test]
    fn a_beginning_that_is_steep_is_no_fault() {
        let time: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(k)).collect();
        let mut noise = Noise::new(4, 7);
        let mut observed: Vec<f64> = time.iter().map(|t| 1.0 - (-t).exp() + 1e-4 * noise.normal()).collect();
        assert!(leave_out(&mut observed, &time, &[0], &["u".to_string()]).is_empty());
        // a vehicle on its course that begins to turn between samples half a second apart, as a
        // real log has it
        let turn =
            [6.567, 6.609, 6.915, 7.464, 8.318, 8.977, 9.515, 9.788, 10.057, 10.216, 10.393, 10.506, 10.635, 10.716];
        let mut turning: Vec<f64> = (0..60).map(|k| turn.get(k).copied().unwrap_or(10.8 + 0.01 * k as f64)).collect();
        turning.iter_mut().for_each(|y| *y += 1e-3 * noise.normal());
        let at: Vec<f64> = (0..60).map(|k| 0.5 * f64::from(k)).collect();
        assert!(leave_out(&mut turning, &at, &[0], &["psi".to_string()]).is_empty());
        // a yaw rate from rest under full command, its time constant three samples long
        let mut rate: Vec<f64> = time.iter().map(|t| 0.4 * (1.0 - (-t / 0.3).exp()) + 0.003 * noise.normal()).collect();
        assert!(leave_out(&mut rate, &time, &[0], &["r".to_string()]).is_empty());
        let mut quiet = vec![0.5; 100];
        quiet[0] = 0.6;
        assert!(leave_out(&mut quiet, &time, &[0], &["u".to_string()]).is_empty(), "nothing is usual");
    }
}
