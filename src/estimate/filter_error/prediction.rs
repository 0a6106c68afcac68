//! The errors of predictions, compared with their expected size.
//!
//! ```text
//! ratio = √(Σ (y − ŷ)² / Σ (c P cᵀ + R)),      n ratio²  ~  χ²(n)      n: number of independent errors
//! (ln Σ (y − ŷ)² − mean ln Σ draw²) / (std √(1 + 1/N))  ~  t(N − 1)    of N draws
//! ```
//!
//! If a vehicle may turn either way, the sum of squares has a longer tail than χ², because some
//! predictions go to the other side. Its logarithm is nearly normal. By its rank alone,
//! a prediction would be beyond all draws by chance once in N + 1.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

/// Number of draws that measure how far predictions spread.
pub(super) const DRAWS: usize = 32;

/// The error of a prediction and its expected size.
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
    /// Σ error² of each draw of parameters, forces and initial state, if the linearised filter was
    /// tested with draws.
    pub(super) drawn: Option<[f64; DRAWS]>,
}

impl Prediction {
    pub(super) fn new(ahead: Option<f64>) -> Prediction {
        Prediction { ahead, squares: 0.0, expected: 0.0, count: 0, drawn: None }
    }

    pub(super) fn add(&mut self, error: f64, variance: f64) {
        self.squares += error * error;
        self.expected += variance;
        self.count += 1;
    }

    /// Root-mean-square error, in the channel's unit.
    pub fn rms(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }

    /// Root-mean-square error that was expected, in the channel's unit.
    pub fn expected_rms(&self) -> f64 {
        (self.expected / self.count.max(1) as f64).sqrt()
    }

    /// The two combined.
    pub fn with(&self, other: &Prediction) -> Prediction {
        let (squares, expected) = (self.squares + other.squares, self.expected + other.expected);
        let drawn = match (self.drawn, other.drawn) {
            (Some(a), Some(b)) => Some(std::array::from_fn(|k| a[k] + b[k])),
            (one, None) | (None, one) => one,
        };
        Prediction { squares, expected, count: self.count + other.count, drawn, ..*self }
    }

    /// Error over the expected error; 1 if nothing was predicted, infinite if the model diverges.
    pub fn ratio(&self) -> f64 {
        if self.runs_away() {
            f64::INFINITY
        } else if self.expected > 0.0 {
            (self.squares / self.expected).sqrt()
        } else {
            1.0
        }
    }

    /// Whether a prediction has no finite value any more: the model diverges from where the vehicle
    /// was.
    pub fn runs_away(&self) -> bool {
        !self.squares.is_finite()
    }

    /// Number of independent errors. Predictions half a horizon apart share half of their error. If
    /// the draws spread more widely than so many independent errors would, there are fewer of them:
    /// 2 mean²/variance.
    fn independent(&self) -> f64 {
        let half = 0.5 * self.count as f64;
        let by_draws = self.drawn.map_or(half, |drawn| {
            let mean = drawn.iter().sum::<f64>() / DRAWS as f64;
            let variance = drawn.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (DRAWS - 1) as f64;
            if variance > 0.0 { 2.0 * mean * mean / variance } else { half }
        });
        half.min(by_draws).max(1.0)
    }

    /// Probability of such a ratio by chance: the larger of the values by χ² and by the draws.
    pub fn p_value(&self) -> f64 {
        let n = self.independent();
        if self.runs_away() {
            0.0
        } else if self.count == 0 {
            1.0
        } else {
            let plain = ChiSquared::new(n).map_or(1.0, |chi| chi.sf(n * self.ratio().powi(2)));
            self.p_by_draws().map_or(plain, |by_draws| plain.max(by_draws))
        }
    }

    /// Probability that another draw has as large an error; `None` if there are no draws, or all
    /// are alike.
    fn p_by_draws(&self) -> Option<f64> {
        let logs = self.drawn?.map(|draw| draw.max(f64::MIN_POSITIVE).ln());
        let mean = logs.iter().sum::<f64>() / DRAWS as f64;
        let std = (logs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (DRAWS - 1) as f64).sqrt();
        let t = (self.squares.ln() - mean) / (std * (1.0 + 1.0 / DRAWS as f64).sqrt());
        let student = StudentsT::new(0.0, 1.0, (DRAWS - 1) as f64).ok()?;
        t.is_finite().then(|| student.sf(t))
    }

    /// Whether this prediction, one of `of` that are tested, has a larger error than it should: by
    /// more than a fifth, beyond one chance in a thousand over all tests, and by more than any
    /// draw. The spread of the draws has longer tails than χ² if a vehicle may turn either way.
    pub fn errs(&self, of: usize) -> bool {
        let beyond_draws = self.drawn.is_none_or(|drawn| drawn.iter().all(|draw| *draw < self.squares));
        self.runs_away() || self.ratio() > 1.2 && self.p_value() < 1e-3 / of.max(1) as f64 && beyond_draws
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forty errors whose mean square is `times` the expected one; all draws are as expected but
    /// one, which is `widest` times that.
    fn prediction(times: f64, widest: Option<f64>) -> Prediction {
        let count = 40;
        let expected = count as f64;
        let drawn = widest.map(|widest| std::array::from_fn(|k| if k == 7 { widest * expected } else { expected }));
        Prediction { ahead: Some(8.0), squares: times * expected, expected, count, drawn }
    }

    #[test]
    fn an_error_within_its_draws_is_no_error() {
        assert!(prediction(9.0, None).errs(1));
        assert!(prediction(9.0, Some(2.0)).errs(1));
        assert!(!prediction(9.0, Some(10.0)).errs(1), "one draw in 32 errs as much");
    }

    #[test]
    fn draws_that_spread_widely_leave_room_beyond_the_last_of_them() {
        let spread = |k: usize| 40.0 * (0.7 * (k as f64 - 15.5) / 9.2).exp();
        let of = |times: f64| Prediction { drawn: Some(std::array::from_fn(spread)), ..prediction(times, None) };
        // beyond all draws and beyond χ², but the next draw may well be as large
        assert!(!of(4.0).errs(6), "{}", of(4.0).p_value());
        assert!(of(40.0).errs(6), "{}", of(40.0).p_value());
    }

    #[test]
    fn what_runs_away_errs() {
        for squares in [f64::NAN, f64::INFINITY] {
            let lost = Prediction { squares, expected: f64::NAN, ..prediction(1.0, Some(f64::INFINITY)) };
            assert!(lost.errs(6) && lost.ratio().is_infinite() && lost.p_value() < 1e-9);
        }
    }

    #[test]
    fn a_small_excess_is_no_error_however_sure() {
        let sure = Prediction { squares: 1.4e6, expected: 1e6, count: 1_000_000, ..prediction(1.0, None) };
        assert!(sure.p_value() < 1e-9);
        assert!(!sure.errs(1), "by less than a fifth");
    }

    #[test]
    fn the_more_are_asked_the_more_it_takes() {
        let one = prediction(2.5, None);
        assert!(one.errs(1), "{}", one.p_value());
        assert!(!one.errs(1000), "{}", one.p_value());
    }
}
