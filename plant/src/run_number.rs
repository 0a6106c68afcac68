//! Keulegan-Carpenter number of a run: KC = U_m T / L_c.
//!
//! U_m is the highest speed of the run (rad/s times L_c in rotation), T the period of the strongest
//! sine of the command. The motion depends on the inertia and the inertia on the motion; four
//! rehearsals are enough to converge.

use std::f64::consts::TAU;

use crate::log::Log;
use crate::plant::place;

/// KC of a rehearsed run in degree of freedom `i`, from its true states and its commanded wrenches
/// every `period` s.
pub(crate) fn run_number(log: &Log, wrenches: &[[f64; 6]], period: f64, i: usize, length: f64) -> f64 {
    let greatest = log.truth.iter().fold(0.0, |m: f64, (_, x)| m.max(x[place::NU + i].abs()));
    let speed = if i > 2 { greatest * length } else { greatest };
    let force: Vec<f64> = wrenches.iter().map(|w| w[i]).collect();
    speed * strongest_period(&force, period) / length
}

/// Period of the strongest sine about the mean, s; 0 for a force that does not vary.
fn strongest_period(x: &[f64], step: f64) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    let greatest = x.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let scatter = (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / x.len() as f64).sqrt();
    if scatter <= 1e-3 * greatest || greatest == 0.0 {
        return 0.0;
    }
    let span = step * (x.len() - 1) as f64;
    let power = |frequency: f64| {
        let (mut re, mut im) = (0.0, 0.0);
        for (k, v) in x.iter().enumerate() {
            let (sin, cos) = (TAU * frequency * k as f64 * step).sin_cos();
            re += (v - mean) * cos;
            im += (v - mean) * sin;
        }
        re * re + im * im
    };
    let grid: Vec<f64> = (3..).map(|k| 0.25 * f64::from(k) / span).take_while(|f| *f < 1.0).collect();
    let best = grid.iter().map(|f| power(*f)).enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(k, _)| k);
    // ternary search of the peak between the neighbours on the grid
    let (mut low, mut high) = (grid[best] - 0.25 / span, grid[best] + 0.25 / span);
    for _ in 0..30 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if power(a) < power(b) { low = a } else { high = b }
    }
    2.0 / (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strongest_sine_is_found() {
        let x: Vec<f64> = (0..600).map(|k| 3.0 + (TAU * 0.1 * f64::from(k) / 11.3).sin()).collect();
        // the mean over a non-integer number of periods moves the peak by less than 1 %
        assert!((strongest_period(&x, 0.1) / 11.3 - 1.0).abs() < 0.01);
        assert!(strongest_period(&[2.0; 50], 0.1).abs() < 1e-12);
    }
}
