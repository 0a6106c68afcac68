//! Innovations in windows, compared with those where the model was fitted.
//!
//! ```text
//! Λ = n (m² + s² − 1 − ln s²) / (1 + 11/12n)  ~  χ²(2)      m, s²: mean and variance of z = e/√s in a window
//! S_k = max(0, S_{k−1} + Λ_k/c − κ),   1 − 2ρ = e^{−ρκ}     P(S passes h within N windows) ≤ N e^{−ρh}
//! ```
//!
//! Λ: twice the logarithm of the likelihood ratio of free mean and variance against 0 and 1, with Bartlett's factor;
//! c: mean of Λ/2 on the runs of the fit, where innovations need not be quite white. A change shifts the mean, a
//! rougher sea increases the variance. h = ln(N/α)/ρ keeps the rate α of false alarms (Lundberg's inequality). Page,
//! *Biometrika* 41 (1954) 100-115; Basseville and Nikiforov, *Detection of Abrupt Changes* (1993), ch. 2, 7 and 9.

use super::{Change, Window};
use crate::estimate::filter_error::Channel;

/// κ: twice the mean of Λ without a change.
const SLACK: f64 = 4.0;

/// ρ that belongs to κ.
const EXPONENT: f64 = 0.398;

/// Upper limit of the sum, in thresholds: a passing disturbance is forgotten within a few windows.
const CAP: f64 = 1.25;

/// Least mean of z, and least standard deviation of z, that count as a change of the vehicle: sensors and models are
/// never exactly as assumed, and with many samples even the smallest deviation is significant.
const LARGE: (f64, f64) = (0.25, 1.15);

/// Minimum number of innovations of a window that is judged.
pub(super) const FEWEST: usize = 4;

/// Normalised innovations of a channel in one window. The first one is omitted: it determines the initial state.
pub(super) fn normalised(channel: &Channel) -> Vec<f64> {
    channel.next.iter().skip(1).map(|p| (p.measured - p.mean) / p.std).collect()
}

fn moments(z: &[f64]) -> (f64, f64) {
    let n = z.len() as f64;
    let mean = z.iter().sum::<f64>() / n;
    (mean, z.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n)
}

/// Λ of a window.
pub fn ratio(z: &[f64]) -> f64 {
    let n = z.len() as f64;
    let (mean, variance) = moments(z);
    // equal innovations have zero variance: use one of the size of rounding
    let variance = variance.max(1e-12);
    n * (mean * mean + variance - 1.0 - variance.ln()) / (1.0 + 11.0 / (12.0 * n))
}

/// Whether a window differs enough to indicate a change of the vehicle.
pub(super) fn is_large(z: &[f64]) -> bool {
    let (mean, variance) = moments(z);
    mean.abs() > LARGE.0 || variance.sqrt() > LARGE.1
}

/// c of a channel: mean of Λ/2 in windows of `window` seconds, at least 1.
pub fn restlessness<'a>(channels: impl Iterator<Item = &'a Channel>, window: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for channel in channels {
        let mut points = &channel.next[channel.next.len().min(1)..];
        while let Some(first) = points.first() {
            let end = points.iter().position(|p| p.time - first.time >= window).unwrap_or(points.len());
            let z: Vec<f64> = points[..end].iter().map(|p| (p.measured - p.mean) / p.std).collect();
            if z.len() >= FEWEST {
                (sum, count) = (sum + 0.5 * ratio(&z), count + 1.0);
            }
            points = &points[end..];
        }
    }
    if count > 0.0 { f64::max(sum / count, 1.0) } else { 1.0 }
}

/// Fills in the sums of the change detector and returns the changes where they exceed the threshold up to the end.
/// `z` holds the innovations of each window.
pub(super) fn changes(windows: &mut [Window], z: &[Vec<f64>], level: f64) -> Vec<Change> {
    let threshold = (windows.len().max(1) as f64 / level).ln() / EXPONENT;
    let mut found = Vec::new();
    let mut begin = 0;
    while begin < windows.len() {
        let same = |w: &Window| w.run == windows[begin].run && w.dof == windows[begin].dof;
        let end = begin + windows[begin..].iter().take_while(|w| same(w)).count();
        let (mut sum, mut since): (f64, usize) = (0.0, begin);
        for k in begin..end {
            // an average window lowers the sum by half of κ
            let excess = if windows[k].large { windows[k].likelihood_ratio } else { 2.0 } - SLACK;
            if sum <= 0.0 {
                since = k;
            }
            // one window alone must not carry the sum over the threshold; an overflow counts as the maximum
            let excess = if excess.is_nan() { threshold } else { excess.min(threshold) };
            sum = (sum + excess).clamp(0.0, CAP * threshold);
            windows[k].cusum = sum;
        }
        let row = &windows[since..end];
        let more = row.iter().filter(|w| w.likelihood_ratio > SLACK || w.likelihood_ratio.is_nan()).count();
        if sum > threshold && more >= 2 {
            found.push(change(windows, z, begin, since, end));
        }
        begin = end;
    }
    found
}

/// The change whose first window is `since`, dated to the sample from which on the innovations deviate most.
fn change(windows: &[Window], z: &[Vec<f64>], begin: usize, since: usize, end: usize) -> Change {
    let before = since.saturating_sub(1).max(begin);
    let instants = |k: usize| {
        let (from, to, count) = (windows[k].from, windows[k].to, z[k].len() as f64);
        // innovations of one sensor are evenly spaced except for drop-outs; the first one is omitted
        (0..z[k].len()).map(move |i| from + (to - from) * (i as f64 + 1.0) / count)
    };
    // by chance the sum may have begun a window early
    let after = (since + 2).min(end - 1);
    let near: Vec<(f64, f64)> = (before..=after).flat_map(|k| instants(k).zip(z[k].iter().copied())).collect();
    let values: Vec<f64> = near.iter().map(|(_, z)| *z).collect();
    let splits = 0..values.len().saturating_sub(FEWEST);
    let best = splits.map(|k| (k, ratio(&values[k..]))).max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(k, _)| k);
    let rest: Vec<f64> = z[since..end].concat();
    let n = rest.len().max(1) as f64;
    let noise = windows[since].noise;
    Change {
        run: windows[since].run.clone(),
        dof: windows[since].dof,
        from: near.get(best).map_or(windows[since].from, |(t, _)| *t),
        times_noise: (rest.iter().map(|z| z * z).sum::<f64>() / n).sqrt(),
        shift: noise * rest.iter().sum::<f64>() / n,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Dof;
    use crate::noise::Noise;

    /// A log of windows of 80 innovations each, with the given mean and standard deviation in each window.
    fn log(parts: &[(f64, f64)], seed: u64) -> (Vec<Window>, Vec<Vec<f64>>) {
        let mut noise = Noise::new(seed, 1);
        let z: Vec<Vec<f64>> =
            parts.iter().map(|(mean, std)| noise.coloured(80, 0.0).iter().map(|x| mean + std * x).collect()).collect();
        let one = |(k, z): (usize, &Vec<f64>)| Window {
            run: "dive".into(),
            dof: Dof::Surge,
            from: 8.0 * k as f64,
            to: 8.0 * (k + 1) as f64,
            samples: 80,
            rms: 1.0,
            mean: 0.0,
            noise: 1.0,
            chi_squared: 80.0,
            likelihood_ratio: ratio(z),
            p_value: 1.0,
            cusum: 0.0,
            large: is_large(z),
            off: false,
        };
        (z.iter().enumerate().map(one).collect(), z)
    }

    fn found(parts: &[(f64, f64)], seed: u64) -> Vec<Change> {
        let (mut windows, z) = log(parts, seed);
        changes(&mut windows, &z, 0.01)
    }

    /// The mean of χ²(2) is 2; from 4000 windows it is known to 2·√(1/4000) = 0.03, and Bartlett's factor to 1/n².
    #[test]
    fn law_of_the_ratio_without_a_change() {
        let mut noise = Noise::new(7, 1);
        for n in [10, 80] {
            let mean = (0..4000).map(|_| ratio(&noise.coloured(n, 0.0))).sum::<f64>() / 4000.0;
            assert!((mean - 2.0).abs() < 0.13, "{n}: {mean}");
        }
    }

    /// The bound is on the safe side: 500 logs at 1 % give at most five alarms, by chance two more in a hundred cases.
    #[test]
    fn law_false_alarms_keep_their_rate() {
        let alarms = (0..500).filter(|seed| !found(&[(0.0, 1.0); 30], *seed).is_empty()).count();
        assert!(alarms <= 7, "{alarms}");
    }

    #[test]
    fn a_lasting_change_is_dated_and_sized() {
        let calm = [(0.0, 1.0); 6];
        for (changed, times, shift) in [((1.5, 1.0), 1.8, 1.5), ((0.0, 2.0), 2.0, 0.0)] {
            let all = found(&[&calm[..], &[changed; 6][..]].concat(), 3);
            assert_eq!(all.len(), 1);
            assert!((all[0].from - 48.0).abs() < 2.0, "{all:?}");
            // 480 innovations: three standard deviations of their mean
            assert!((all[0].times_noise - times).abs() < 0.2 && (all[0].shift - shift).abs() < 0.3, "{all:?}");
        }
    }

    #[test]
    fn a_touch_that_passes_is_no_change() {
        let mut parts = [(0.0, 1.0); 12];
        (parts[4], parts[5]) = ((10.0, 1.0), (10.0, 3.0));
        assert!(found(&parts, 5).is_empty());
    }
}
