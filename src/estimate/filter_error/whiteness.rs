//! Test of the innovations for whiteness.
//!
//! ```text
//! Ljung-Box:   Q = N (N+2) Σ_k r_k²/(N−k)  ~  χ²(m)
//! r_k: autocorrelation of the innovations z = e/√s at lag k
//! ```
//!
//! Ljung and Box, *Biometrika* 65 (1978) 297-303.

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Lags of the Ljung-Box test.
const LAGS: usize = 20;

/// Autocorrelation at lag one up to which coloured innovations do no harm, however significant the
/// colour is.
const HARMLESS: f64 = 0.15;

/// Probability of calling white innovations harmfully coloured, over all channels.
const LEVEL: f64 = 1e-3;

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

    /// The two combined.
    pub fn with(&self, other: &Whiteness) -> Whiteness {
        let products = std::array::from_fn(|k| self.products[k] + other.products[k]);
        Whiteness { products, count: self.count + other.count }
    }

    /// Probability that white innovations are correlated as much as these; 1 if there are too few.
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

    /// Whether chance makes the innovations of one of `channels` channels as correlated as these,
    /// at one per cent for all of them together.
    pub fn is_white(&self, channels: usize) -> bool {
        self.p_value() >= 0.01 / channels.max(1) as f64
    }

    /// Whether the innovations of one of `channels` channels are correlated beyond chance, and by
    /// enough to do harm. Used for the runs of the fit: on others, the errors of the parameters
    /// colour the innovations, most where the motion is largest.
    pub fn is_coloured(&self, channels: usize) -> bool {
        self.p_value() < LEVEL / channels.max(1) as f64 && self.first().abs() > HARMLESS
    }

    /// Autocorrelation at lag one.
    pub fn first(&self) -> f64 {
        if self.products[0] > 0.0 { self.products[1] / self.products[0] } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// White numbers pass at 1 % in all but a few of a hundred cases; correlated ones never pass.
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
