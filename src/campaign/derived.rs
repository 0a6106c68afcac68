//! Channels that are calculated from a run instead of logged, for the effects that read them.
//!
//! ```text
//! KC = U_m T / L_c      supply_voltage_ratio = V / V_ref      anchor = where the run begins
//! ```
//!
//! U_m: greatest speed of the run, m/s (rad/s times L_c in rotation); T: period of the strongest
//! sine in the command, s, 0 if it does not oscillate; L_c: characteristic length, m; V_ref: mean
//! supply voltage of the campaign, V.

use std::sync::Arc;

use crate::effects::channel;
use crate::frame::Dof;
use crate::run::{Run, Signal};
use crate::vehicle::Vehicle;

/// Adds the derived channels to every run; logged channels of the same name stay.
pub(super) fn add(runs: &mut [Run], vehicle: &Vehicle, dofs: &[Dof]) {
    let means: Vec<f64> = runs.iter().filter_map(Run::supply_voltage).map(|s| mean(s.values())).collect();
    let reference = mean(&means);
    for run in runs.iter_mut() {
        let mut made: Vec<(String, Signal)> = Vec::new();
        let ends: Option<Arc<[f64]>> = run.span().filter(|(a, b)| b > a).map(|(a, b)| vec![a, b].into());
        if let Some(volts) = run.supply_voltage().filter(|_| reference > 0.0) {
            let ratio: Vec<f64> = volts.values().iter().map(|v| v / reference).collect();
            made.push((channel::SUPPLY_RATIO.into(), Signal::new(volts.shared_time().clone(), ratio)));
        }
        if let Some(ends) = ends {
            let constant = |value: f64| Signal::new(ends.clone(), vec![value; 2]);
            let anchors = [(channel::ANCHOR_NORTH, Dof::Surge), (channel::ANCHOR_EAST, Dof::Sway)];
            for (name, dof) in anchors {
                if let Some(start) = run.signal(dof.position()).and_then(|s| s.values().first()) {
                    made.push((name.into(), constant(*start)));
                }
            }
            for dof in dofs {
                if let Some(number) = keulegan_carpenter(run, *dof, vehicle) {
                    made.push((channel::keulegan_carpenter(*dof), constant(number)));
                }
            }
        }
        for (name, signal) in made {
            run.signals.entry(name).or_insert(signal);
        }
    }
}

/// Returns KC of a run in `dof`; `None` without a characteristic length, a velocity or a command.
fn keulegan_carpenter(run: &Run, dof: Dof, vehicle: &Vehicle) -> Option<f64> {
    let length = vehicle.characteristic_length()?;
    let greatest = run.signal(dof.velocity())?.values().iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let speed = if dof.is_rotation() { greatest * length } else { greatest };
    Some(speed * dominant_period(run.signal(dof.force())?) / length)
}

/// Largest number of samples that the search for a period uses.
const SAMPLES: usize = 2048;

/// Returns the period of the strongest sine of a signal about its mean, s; 0 for a signal that does
/// not vary.
pub(super) fn dominant_period(signal: &Signal) -> f64 {
    let (time, x) = (signal.time(), signal.values());
    let (Some(first), Some(last)) = (time.first(), time.last()) else { return 0.0 };
    let span = last - first;
    let centre = mean(x);
    let greatest = x.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let scatter = (x.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / x.len() as f64).sqrt();
    if span <= 0.0 || scatter <= 1e-3 * greatest {
        return 0.0;
    }
    let every = x.len().div_ceil(SAMPLES);
    let samples: Vec<(f64, f64)> = time.iter().zip(x).step_by(every).map(|(t, v)| (t - first, v - centre)).collect();
    // a quarter of the resolution 1/span: at this step the peak is a parabola; no vehicle
    // oscillates faster than 5 Hz
    let step = 0.25 / span;
    let most = (0.5 * samples.len() as f64 / span).min(5.0).min(1000.0 * step);
    let grid: Vec<f64> = (3..).map(|k| f64::from(k) * step).take_while(|f| *f <= most.max(4.0 * step)).collect();
    let powers = powers(&samples, 3.0 * step, step, grid.len());
    let Some(best) = (0..grid.len()).max_by(|a, b| powers[*a].total_cmp(&powers[*b])) else { return 0.0 };
    let shift = match (best.checked_sub(1).map(|k| powers[k]), powers.get(best + 1)) {
        (Some(before), Some(after)) => {
            let bend = before - 2.0 * powers[best] + after;
            if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 }
        }
        _ => 0.0,
    };
    1.0 / (grid[best] + shift * step)
}

/// Returns |Σ v exp(2πi f t)|² at `count` frequencies from `first` on, `step` apart. From one
/// frequency to the next the phase of each sample turns by the same angle, so that its sine and
/// cosine are calculated only once.
fn powers(samples: &[(f64, f64)], first: f64, step: f64, count: usize) -> Vec<f64> {
    let turned = |f: f64| samples.iter().map(move |(t, _)| (std::f64::consts::TAU * f * t).sin_cos());
    let mut at: Vec<(f64, f64)> = turned(first).zip(samples).map(|((s, c), (_, v))| (v * s, v * c)).collect();
    let by: Vec<(f64, f64)> = turned(step).collect();
    let power = |_| {
        let (mut re, mut im) = (0.0, 0.0);
        for ((s, c), (by_s, by_c)) in at.iter_mut().zip(&by) {
            re += *c;
            im += *s;
            (*s, *c) = (*s * by_c + *c * by_s, *c * by_c - *s * by_s);
        }
        re * re + im * im
    };
    (0..count).map(power).collect()
}

fn mean(x: &[f64]) -> f64 {
    if x.is_empty() { 0.0 } else { x.iter().sum::<f64>() / x.len() as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(period: f64) -> Signal {
        let time: Vec<f64> = (0..900).map(|k| 0.1 * f64::from(k)).collect();
        let x: Vec<f64> = time.iter().map(|t| 20.0 + 50.0 * (std::f64::consts::TAU * t / period).sin()).collect();
        Signal::new(time.into(), x)
    }

    #[test]
    fn the_strongest_sine_is_found() {
        for period in [4.0, 8.3, 28.0] {
            // the peak of a cut sine lies within some percent of the grid's step
            let found = dominant_period(&sine(period));
            assert!((found / period - 1.0).abs() < 0.02, "{found} {period}");
        }
        let flat = Signal::new(vec![0.0, 1.0, 2.0].into(), vec![3.0; 3]);
        assert_eq!(dominant_period(&flat), 0.0);
    }

    #[test]
    fn exact_amplitude_and_supply() {
        let mut run = Run::default();
        run.signals.insert("tau_u".into(), sine(8.0));
        let time = run.signals["tau_u"].shared_time().clone();
        run.signals
            .insert("u".into(), Signal::new(time.clone(), time.iter().map(|t| 0.5 * t.sin()).collect::<Vec<_>>()));
        run.signals.insert("x".into(), Signal::new(time.clone(), vec![7.0; 900]));
        run.signals.insert(
            "battery_V".into(),
            Signal::new(time, (0..900).map(|k| 16.0 + f64::from(k % 2)).collect::<Vec<_>>()),
        );
        let vehicle = Vehicle { length: Some(0.5), ..Vehicle::default() };
        let mut runs = [run];
        add(&mut runs, &vehicle, &[Dof::Surge]);
        let value = |name: &str| runs[0].signals[name].values()[0];
        assert!((value("KC_u") - 8.0).abs() < 0.2);
        assert!((value(channel::SUPPLY_RATIO) - 16.0 / 16.5).abs() < 1e-12);
        assert_eq!(value(channel::ANCHOR_NORTH), 7.0);
    }
}
