//! Sample and hold: a slower sensor written at the rate of the log, each value repeated until the next.
//!
//! ```text
//! ρ = mean length of a stretch of equal values     held:  var(length) < ½ ρ (ρ − 1),  ρ > 1.3
//! ```
//!
//! Values that repeat by chance, such as coarse ones, give lengths with the variance of the
//! geometric law, ρ (ρ − 1); a clock gives lengths that differ by one at most. Long stretches, in
//! which the vehicle did not move, do not count. The values of a coarse sensor in steady motion
//! change as evenly as a clock, but mostly by one step of the resolution: they are not held.

use std::ops::Range;

/// Least share of stretches of usual length if values do not repeat by chance.
const SELDOM: f64 = 0.98;

/// Returns the stretches of equal values.
pub fn stretches(values: &[f64]) -> Vec<Range<usize>> {
    let mut next = 0;
    let range = |stretch: &[f64]| {
        next += stretch.len();
        next - stretch.len()..next
    };
    values.chunk_by(|a, b| a.to_bits() == b.to_bits()).map(range).collect()
}

/// Whether the channel, whose samples are held for `rows` rows, hardly ever gives a value twice
/// otherwise: with coarse values some stretches are long by chance.
pub fn seldom_repeats(stretches: &[Range<usize>], rows: f64) -> bool {
    let usual = stretches.iter().filter(|s| s.len() as f64 <= 2.0 * rows + 1.0).count();
    usual as f64 >= SELDOM * stretches.len() as f64
}

/// A signal that is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hold {
    /// Mean number of rows for which a value is held.
    pub rows: f64,
}

/// Returns the hold of these values; `None` if each row is a sample of its own.
pub fn of(values: &[f64]) -> Option<Hold> {
    let lengths: Vec<usize> = values.chunk_by(|a, b| a.to_bits() == b.to_bits()).map(<[f64]>::len).collect();
    // the log cuts the first and the last stretch
    let inner = lengths.get(1..lengths.len().checked_sub(1)?)?;
    let mut sorted = inner.to_vec();
    sorted.sort_unstable();
    let usual = *sorted.get(sorted.len() / 2)?;
    let short: Vec<f64> = inner.iter().filter(|n| **n <= 3 * usual + 2).map(|n| *n as f64).collect();
    if short.len() < 8 || is_coarse(values) {
        return None;
    }
    let mean = short.iter().sum::<f64>() / short.len() as f64;
    let variance = short.iter().map(|n| (n - mean).powi(2)).sum::<f64>() / short.len() as f64;
    (mean > 1.3 && variance < 0.5 * mean * (mean - 1.0)).then_some(Hold { rows: mean })
}

/// Whether most changes are as small as the smallest: steps of a resolution.
fn is_coarse(values: &[f64]) -> bool {
    let changes: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 0.0).collect();
    let least = changes.iter().copied().fold(f64::INFINITY, f64::min);
    2 * changes.iter().filter(|d| **d < 1.5 * least).count() > changes.len()
}

impl Hold {
    /// Returns the indices of the true samples: those where the value changes, and further ones at the
    /// usual interval within a long stretch. A stretch of [`Hold::frozen`] has only its first sample.
    pub fn samples(self, values: &[f64]) -> Vec<usize> {
        let most = self.rows.ceil() as usize;
        let mut frozen = self.frozen(values).into_iter().peekable();
        let mut kept = Vec::new();
        for k in 0..values.len() {
            while frozen.next_if(|stretch| stretch.end <= k).is_some() {}
            let stands = frozen.peek().is_some_and(|stretch| stretch.start < k);
            let changes = kept.last().is_none_or(|&l: &usize| values[l].to_bits() != values[k].to_bits());
            if changes || !stands && kept.last().is_some_and(|l| k - l > most) {
                kept.push(k);
            }
        }
        kept
    }

    /// Returns the long stretches at one value of a sensor that otherwise hardly ever gives a value
    /// twice: it has dropped out, and the log repeats its last sample. Stretches at 0, and at the
    /// beginning and end of the log, are excluded: there the vehicle may rest.
    pub fn frozen(self, values: &[f64]) -> Vec<Range<usize>> {
        let stretches = stretches(values);
        if !seldom_repeats(&stretches, self.rows) {
            return Vec::new();
        }
        let inside = stretches.get(1..stretches.len().saturating_sub(1)).unwrap_or_default();
        let long = |s: &&Range<usize>| s.len() as f64 > 3.0 * self.rows + 2.0 && values[s.start] != 0.0;
        inside.iter().filter(long).cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tank::Noise;

    #[test]
    fn a_clock_of_its_own_is_seen_and_coarse_values_are_not() {
        let slow = |rate: f64| -> Vec<f64> { (0..600).map(|k| (f64::from(k) * rate).floor().sin()).collect() };
        for (rate, rows) in [(0.55, 1.82), (0.2, 5.0), (0.5, 2.0)] {
            // the mean length is the ratio of the rates, except for the cut at both ends
            assert!((of(&slow(rate)).unwrap().rows - rows).abs() < 0.05, "{rate}");
        }
        let mut noise = Noise::new(3, 1);
        for quantum in [0.05, 0.3, 1.0, 2.0] {
            let coarse: Vec<f64> = (0..600).map(|_| (noise.normal() / quantum).round() * quantum).collect();
            assert_eq!(of(&coarse), None, "{quantum}");
        }
        let degrees: Vec<f64> = (0..600).map(|k| (f64::from(k) * 0.21).round()).collect();
        assert_eq!(of(&degrees), None, "whole degrees of a heading that turns steadily");
        assert_eq!(of(&vec![1.0; 100]), None);
        assert_eq!(of(&slow(1.0)), None);
    }

    /// A DVL at 5 Hz in rows of 25 Hz, which loses the bottom for 4 s. Coarse values and values at
    /// rest are not frozen.
    #[test]
    fn a_sensor_that_drops_out_has_no_samples_meanwhile() {
        let mut noise = Noise::new(4, 1);
        let samples: Vec<f64> = (0..200).map(|_| 0.4 + 0.02 * noise.normal()).collect();
        let mut values: Vec<f64> = (0..1000).map(|k| samples[k / 5]).collect();
        let last = values[400];
        values[400..500].fill(last);
        let hold = of(&values).unwrap();
        assert_eq!(hold.frozen(&values), vec![400..500]);
        let kept = hold.samples(&values);
        assert_eq!(kept.iter().filter(|k| (401..500).contains(*k)).count(), 0);
        assert_eq!(kept.len(), 200 - 19);
        values[400..500].fill(0.0);
        assert!(hold.frozen(&values).is_empty(), "it rests");
        let coarse: Vec<f64> = values.iter().map(|x| (x / 0.03).round() * 0.03).collect();
        assert!(hold.frozen(&coarse).is_empty(), "values repeat by chance");
    }

    #[test]
    fn samples_are_the_changes() {
        let values = [1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 4.0];
        assert_eq!(Hold { rows: 2.0 }.samples(&values), [0, 2, 4, 7, 10]);
    }
}
