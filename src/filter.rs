//! The polynomial filter: local least squares for the value and the first derivative, also on
//! uneven time.
//!
//! The polynomial of degree d is fitted by least squares to the samples of a window around tₖ; the
//! filtered value is the polynomial at tₖ, the derivative its slope there. Both are linear in the
//! samples, x̂ₖ = Σ wⱼ xⱼ, and the weights follow from polynomials orthogonal on the window's own
//! times,
//!
//! ```text
//! wⱼ = Σᵢ pᵢ(0) pᵢ(sⱼ) / ‖pᵢ‖²,   wⱼ' = Σᵢ pᵢ'(0) pᵢ(sⱼ) / ‖pᵢ‖² / h,   sⱼ = (tⱼ − tₖ)/h
//! ```
//!
//! so no matrix is inverted, and time is scaled by the window's half-width h (s). On even spacing
//! this is the filter of Savitzky and Golay, *Analytical Chemistry* 36 (1964) 1627; the recurrence
//! is Forsythe's, *J. SIAM* 5 (1957) 74. At the ends of a run, and at each gap, the window keeps
//! its width and becomes one-sided.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::progress;
use crate::run::{Signal, rounding};

/// Number of samples after which the filter checks whether the work was stopped.
const SAMPLES_A_LOOK: usize = 4096;

/// Width of the window of a filter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Window {
    /// An odd number of samples.
    Samples(usize),
    /// A width in seconds; the number of samples in it may vary.
    Seconds(f64),
}

/// A polynomial filter: width of its window and degree of its polynomial.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolynomialFilter {
    /// Width of the window.
    pub window: Window,
    /// Degree d of the local polynomial; 0 is the moving average.
    pub degree: usize,
}

/// A filtered signal on the time stamps of the original.
#[derive(Debug, Clone, PartialEq)]
pub struct Filtered {
    /// Filtered signal, unit of the original.
    pub value: Signal,
    /// First derivative, unit of the original per second.
    pub derivative: Signal,
}

/// Error of a filter.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FilterError {
    /// A symmetric window must contain an odd number of samples.
    #[error("a filter window of {samples} samples: the number must be odd")]
    EvenWindow {
        /// The requested number.
        samples: usize,
    },
    /// A window in seconds must be a positive number.
    #[error("a filter window of {seconds} s: must be a positive number of seconds")]
    BadWidth {
        /// The requested width, s.
        seconds: f64,
    },
    /// The window does not determine the polynomial.
    #[error("a filter window of {samples} samples at t = {time} s: a polynomial of degree {degree} needs at least {}", degree + 1)]
    TooFewSamples {
        /// Time stamp of the sample to be filtered, s.
        time: f64,
        /// Number of samples in its window.
        samples: usize,
        /// Requested degree.
        degree: usize,
    },
    /// Time does not increase.
    #[error("a time stamp does not increase at t = {time} s: a filter needs strictly increasing time")]
    TimeNotIncreasing {
        /// The second of the two stamps, s.
        time: f64,
    },
}

/// Weights of the samples of one window.
struct Weights {
    value: Vec<f64>,
    derivative: Vec<f64>,
}

impl Weights {
    /// Weights for the point `at` among the window's times (s), which are strictly increasing and
    /// more than `degree`.
    fn new(times: &[f64], at: f64, degree: usize) -> Weights {
        let n = times.len();
        let h = times.iter().map(|t| (t - at).abs()).fold(0.0, f64::max);
        // A single sample has no width: any scale will do.
        let h = if h > 0.0 { h } else { 1.0 };
        let s: Vec<f64> = times.iter().map(|t| (t - at) / h).collect();
        let (mut value, mut derivative) = (vec![0.0; n], vec![0.0; n]);
        // pᵢ and pᵢ₋₁ on the samples, then each with its slope at s = 0, then ‖pᵢ₋₁‖².
        let (mut p, mut p_before) = (vec![1.0; n], vec![0.0; n]);
        let (mut at0, mut at0_before) = ((1.0, 0.0), (0.0, 0.0));
        let mut norm_before = 1.0;
        for i in 0..=degree {
            let norm: f64 = p.iter().map(|p| p * p).sum();
            for j in 0..n {
                value[j] += at0.0 * p[j] / norm;
                derivative[j] += at0.1 * p[j] / (norm * h);
            }
            // pᵢ₊₁ = (s − α) pᵢ − β pᵢ₋₁
            let alpha = s.iter().zip(&p).map(|(s, p)| s * p * p).sum::<f64>() / norm;
            let beta = if i == 0 { 0.0 } else { norm / norm_before };
            let next = (0..n).map(|j| (s[j] - alpha) * p[j] - beta * p_before[j]).collect();
            let next0 = (-alpha * at0.0 - beta * at0_before.0, at0.0 - alpha * at0.1 - beta * at0_before.1);
            p_before = std::mem::replace(&mut p, next);
            at0_before = std::mem::replace(&mut at0, next0);
            norm_before = norm;
        }
        Weights { value, derivative }
    }
}

fn dot(weights: &[f64], values: &[f64]) -> f64 {
    weights.iter().zip(values).map(|(w, x)| w * x).sum()
}

/// Whether the spacing is even, apart from the rounding of printed time stamps.
fn is_even(times: &[f64]) -> bool {
    let n = times.len();
    if n < 2 {
        return false;
    }
    let step = (times[n - 1] - times[0]) / (n - 1) as f64;
    let slack = 1e-6 * step + 2.0 * rounding(times[0]);
    times.windows(2).all(|t| (t[1] - t[0] - step).abs() <= slack)
}

impl PolynomialFilter {
    /// Filters a signal; no window reaches across a gap.
    ///
    /// `gaps` are the time stamps (s) at which a gap ends, as in [`crate::run::Run::gaps`]. A
    /// stretch between gaps that is shorter than the window is fitted as a whole.
    ///
    /// # Errors
    /// A window that is even, not positive, or holds too few samples for the degree anywhere; time
    /// not increasing.
    pub fn apply(&self, signal: &Signal, gaps: &[f64]) -> Result<Filtered, FilterError> {
        self.check(signal)?;
        let (time, x) = (signal.time(), signal.values());
        let (mut value, mut derivative) = (Vec::with_capacity(x.len()), Vec::with_capacity(x.len()));
        let mut start = 0;
        while start < time.len() {
            let gap = gaps.iter().copied().filter(|&g| g > time[start]).fold(f64::INFINITY, f64::min);
            let end = time.partition_point(|&t| t < gap);
            self.stretch(&time[start..end], &x[start..end], &mut value, &mut derivative)?;
            start = end;
        }
        let stamps = signal.shared_time();
        Ok(Filtered { value: Signal::new(stamps.clone(), value), derivative: Signal::new(stamps.clone(), derivative) })
    }

    fn check(&self, signal: &Signal) -> Result<(), FilterError> {
        match self.window {
            Window::Samples(samples) if samples % 2 == 0 => return Err(FilterError::EvenWindow { samples }),
            Window::Samples(samples) if samples <= self.degree => {
                let time = signal.time().first().copied().unwrap_or(0.0);
                return Err(FilterError::TooFewSamples { time, samples, degree: self.degree });
            }
            Window::Seconds(seconds) if !(seconds.is_finite() && seconds > 0.0) => {
                return Err(FilterError::BadWidth { seconds });
            }
            _ => {}
        }
        match signal.time().windows(2).find(|t| t[1].is_nan() || t[1] <= t[0]) {
            Some(t) => Err(FilterError::TimeNotIncreasing { time: t[1] }),
            None => Ok(()),
        }
    }

    /// Filters one stretch without gaps and appends to the two results.
    fn stretch(
        &self,
        t: &[f64],
        x: &[f64],
        value: &mut Vec<f64>,
        derivative: &mut Vec<f64>,
    ) -> Result<(), FilterError> {
        let even = is_even(t);
        // On even time the weights depend only on the window's length and the position in it, which
        // are constant in the middle of the stretch.
        let mut kept: Option<(usize, usize, Weights)> = None;
        for k in 0..t.len() {
            if k.is_multiple_of(SAMPLES_A_LOOK) {
                progress::look();
            }
            let (from, to) = self.reach(t, k);
            if to - from <= self.degree {
                return Err(FilterError::TooFewSamples { time: t[k], samples: to - from, degree: self.degree });
            }
            let weights = match kept.take() {
                Some((place, length, weights)) if even && place == k - from && length == to - from => weights,
                _ => Weights::new(&t[from..to], t[k], self.degree),
            };
            value.push(dot(&weights.value, &x[from..to]));
            derivative.push(dot(&weights.derivative, &x[from..to]));
            kept = Some((k - from, to - from, weights));
        }
        Ok(())
    }

    /// First sample of the window of sample k, and the one after its last.
    fn reach(&self, t: &[f64], k: usize) -> (usize, usize) {
        let n = t.len();
        match self.window {
            Window::Samples(samples) => {
                let samples = samples.min(n);
                let from = k.saturating_sub(samples / 2).min(n - samples);
                (from, from + samples)
            }
            Window::Seconds(width) => {
                // Slightly wider, so that a sample on the edge is inside however its stamp was
                // rounded.
                let width = width * (1.0 + 1e-9);
                let begin = (t[k] - width / 2.0).min(t[n - 1] - width).max(t[0]);
                let end = (t[k] + width / 2.0).max(t[0] + width);
                (t.partition_point(|&s| s < begin), t.partition_point(|&s| s <= end))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filter(window: Window, degree: usize) -> PolynomialFilter {
        PolynomialFilter { window, degree }
    }

    fn uneven(n: usize) -> Vec<f64> {
        (0..n).map(|i| 0.1 * i as f64 + 0.03 * (1.7 * i as f64).sin()).collect()
    }

    #[test]
    fn paper_weights_of_savitzky_and_golay() {
        // Their Table I, quadratic, 5 points: (−3, 12, 17, 12, −3)/35; first derivative (−2, −1, 0, 1, 2)/10.
        let w = Weights::new(&[-2.0, -1.0, 0.0, 1.0, 2.0], 0.0, 2);
        for (w, printed) in w.value.iter().zip([-3.0, 12.0, 17.0, 12.0, -3.0]) {
            assert!((w - printed / 35.0).abs() < 1e-15, "rounding only");
        }
        for (w, printed) in w.derivative.iter().zip([-2.0, -1.0, 0.0, 1.0, 2.0]) {
            assert!((w - printed / 10.0).abs() < 1e-15, "rounding only");
        }
    }

    #[test]
    fn law_a_polynomial_passes_unchanged_on_uneven_time_ends_included() {
        let time = uneven(60);
        let x: Vec<f64> = time.iter().map(|t| 2.0 - t + 0.5 * t * t - 0.1 * t * t * t).collect();
        let slope: Vec<f64> = time.iter().map(|t| -1.0 + t - 0.3 * t * t).collect();
        let signal = Signal::new(time.into(), x.clone());
        for window in [Window::Samples(9), Window::Samples(21), Window::Seconds(1.0), Window::Seconds(2.5)] {
            let out = filter(window, 3).apply(&signal, &[]).unwrap();
            for k in 0..x.len() {
                // values up to 20, weights of one-sided windows up to 5: some hundred roundings
                assert!((out.value.values()[k] - x[k]).abs() < 1e-11, "{window:?} {k}");
                assert!((out.derivative.values()[k] - slope[k]).abs() < 1e-10, "{window:?} {k}");
            }
        }
    }

    #[test]
    fn law_high_degree_stays_well_conditioned_far_from_zero_time() {
        // time since 1970: without local scaled time a polynomial of degree 8 has no accuracy
        let time: Vec<f64> = uneven(81).iter().map(|t| 1.7e9 + t).collect();
        let x: Vec<f64> = time.iter().map(|t| (t - 1.7e9 - 4.0) / 4.0).map(|s| s.powi(8) - s).collect();
        let out = filter(Window::Samples(31), 8).apply(&Signal::new(time.into(), x.clone()), &[]).unwrap();
        let worst = out.value.values().iter().zip(&x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // a stamp near 1.7e9 s is rounded to 2.4e-7 s and the slope reaches 2 /s, but filter and
        // signal share the rounded stamps: the remaining error is rounding amplified by one-sided
        // weights
        assert!(worst < 1e-9, "{worst}");
    }

    #[test]
    fn law_no_window_reaches_across_a_gap() {
        let time: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i) + if i >= 20 { 5.0 } else { 0.0 }).collect();
        let gap = time[20];
        let x: Vec<f64> = time.iter().map(|&t| if t < gap { 1.0 } else { -1.0 }).collect();
        let signal = Signal::new(time.into(), x.clone());
        let parted = filter(Window::Samples(7), 0).apply(&signal, &[gap]).unwrap();
        assert!(parted.value.values().iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-13), "constants: rounding only");
        let smeared = filter(Window::Samples(7), 0).apply(&signal, &[]).unwrap();
        assert!((smeared.value.values()[19] - 1.0).abs() > 0.1);
    }

    #[test]
    fn even_and_uneven_paths_agree() {
        let even: Vec<f64> = (0..50).map(|i| 0.05 * f64::from(i)).collect();
        let x: Vec<f64> = even.iter().map(|t| (3.0 * t).sin()).collect();
        let mut nudged = even.clone();
        nudged[49] += 1e-5; // more than printed rounding: weights are made afresh everywhere
        assert!(is_even(&even) && !is_even(&nudged));
        let a = filter(Window::Samples(11), 3).apply(&Signal::new(even.into(), x.clone()), &[]).unwrap();
        let b = filter(Window::Samples(11), 3).apply(&Signal::new(nudged.into(), x), &[]).unwrap();
        for k in 0..40 {
            assert!((a.value.values()[k] - b.value.values()[k]).abs() < 1e-12, "windows that do not hold the nudge");
        }
    }

    #[test]
    fn seconds_and_samples_mean_the_same_on_even_time() {
        let time: Vec<f64> = (0..50).map(|i| 0.1 * f64::from(i)).collect();
        let x: Vec<f64> = time.iter().map(|t| t.cos()).collect();
        let signal = Signal::new(time.into(), x);
        let a = filter(Window::Samples(9), 2).apply(&signal, &[]).unwrap();
        let b = filter(Window::Seconds(0.8), 2).apply(&signal, &[]).unwrap();
        for k in 0..50 {
            assert!((a.value.values()[k] - b.value.values()[k]).abs() < 1e-12, "same window, rounding only: {k}");
        }
    }

    #[test]
    fn what_cannot_be_filtered_is_said() {
        let signal = Signal::new(vec![0.0, 0.1, 0.2, 5.0, 5.1].into(), vec![0.0; 5]);
        let apply = |window, degree, gaps: &[f64]| filter(window, degree).apply(&signal, gaps).unwrap_err();
        assert_eq!(apply(Window::Samples(4), 2, &[]), FilterError::EvenWindow { samples: 4 });
        assert!(matches!(apply(Window::Samples(3), 3, &[]), FilterError::TooFewSamples { samples: 3, degree: 3, .. }));
        assert!(matches!(apply(Window::Seconds(0.0), 1, &[]), FilterError::BadWidth { .. }));
        assert!(matches!(apply(Window::Seconds(f64::NAN), 1, &[]), FilterError::BadWidth { .. }));
        assert_eq!(
            apply(Window::Samples(3), 2, &[5.0]),
            FilterError::TooFewSamples { time: 5.0, samples: 2, degree: 2 }
        );
        let back = Signal::new(vec![0.0, 0.2, 0.1].into(), vec![0.0; 3]);
        let error = filter(Window::Samples(3), 1).apply(&back, &[]).unwrap_err();
        assert_eq!(error, FilterError::TimeNotIncreasing { time: 0.1 });
    }

    #[test]
    fn an_empty_signal_stays_empty() {
        let out = filter(Window::Samples(5), 2).apply(&Signal::new(vec![].into(), vec![]), &[]).unwrap();
        assert!(out.value.is_empty());
    }
}
