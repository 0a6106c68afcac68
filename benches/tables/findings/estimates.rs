//! Logs with an attitude that an estimator has smoothed, here the complementary filter of the plant.

use super::faults::{Fault, Log};

/// Time constants of the smoothing, s.
pub const SMOOTHINGS: [f64; 3] = [0.3, 0.5, 1.0];

const fn smoothed(number: usize, name: &'static str) -> Fault {
    Fault { section: "Estimates", log: Log::Smoothed(number), name, codes: &["K106"], inject: |t, _| t.csv() }
}

/// A heading smoothed with each of [`SMOOTHINGS`].
pub const ESTIMATES: [Fault; 3] = [
    smoothed(0, "a heading smoothed over 0.3 s"),
    smoothed(1, "a heading smoothed over 0.5 s"),
    smoothed(2, "a heading smoothed over 1 s"),
];
