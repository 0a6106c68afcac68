//! A sensor: its sample rate, noise, noise correlation, resolution and latency.
//!
//! ```text
//! tⱼ = j / rate        yⱼ = round_q(x(tⱼ − latency) + σ eⱼ)        q: quantum, σ: noise, e: white or AR(1)
//! ```
//!
//! Systematic errors of a sensor (bias, scale, misalignment) are effects of the model and not
//! simulated here.

use super::Noise;
use crate::run::Signal;

/// A sensor of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Channel that it logs: a state of the model or an auxiliary channel of the trial.
    pub channel: String,
    /// Sample rate, Hz.
    pub rate: f64,
    /// Standard deviation of its noise, in the channel's unit.
    pub noise: f64,
    /// Correlation of its noise from sample to sample, 0 (white) to below 1.
    pub colour: f64,
    /// Resolution, in the channel's unit; 0 for none.
    pub quantum: f64,
    /// Age of the logged values, s.
    pub latency: f64,
}

impl Sensor {
    /// A sensor with white noise, without quantisation or latency.
    pub fn new(channel: impl Into<String>, rate: f64, noise: f64) -> Sensor {
        Sensor { channel: channel.into(), rate, noise, colour: 0.0, quantum: 0.0, latency: 0.0 }
    }

    /// The sensor with coloured noise.
    pub fn colour(self, colour: f64) -> Sensor {
        Sensor { colour, ..self }
    }

    /// The sensor with a resolution.
    pub fn quantum(self, quantum: f64) -> Sensor {
        Sensor { quantum, ..self }
    }

    /// The sensor with a latency, s.
    pub fn latency(self, latency: f64) -> Sensor {
        Sensor { latency, ..self }
    }

    /// Time stamps from 0 to `duration`, s.
    pub fn stamps(&self, duration: f64) -> Vec<f64> {
        // the last stamp may exceed the end only by rounding
        let last = (duration * self.rate * (1.0 + 1e-12)).floor() as usize;
        (0..=last).map(|j| j as f64 / self.rate).collect()
    }

    /// Instants whose values the samples report, s; before the start the vehicle is in its initial
    /// state.
    pub fn instants(&self, duration: f64) -> Vec<f64> {
        self.stamps(duration).into_iter().map(|t| (t - self.latency).clamp(0.0, duration)).collect()
    }

    /// The log of this sensor for the true values at its [`Sensor::instants`].
    pub fn log(&self, truth: &[f64], noise: &mut Noise) -> Signal {
        let errors = noise.coloured(truth.len(), self.colour);
        let read = |(x, e): (&f64, &f64)| {
            let y = x + self.noise * e;
            if self.quantum > 0.0 { (y / self.quantum).round() * self.quantum } else { y }
        };
        let time: Vec<f64> = (0..truth.len()).map(|j| j as f64 / self.rate).collect();
        Signal::new(time.into(), truth.iter().zip(&errors).map(read).collect::<Vec<f64>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_latency_and_quantum_are_as_told() {
        let sensor = Sensor::new("u", 3.0, 0.02).quantum(0.001).latency(0.25);
        assert_eq!(sensor.stamps(2.0).len(), 7);
        assert_eq!(sensor.instants(2.0)[..2], [0.0, 1.0 / 3.0 - 0.25]);
        let log = sensor.log(&[0.5; 7], &mut Noise::new(1, 1));
        assert_eq!(log.time(), sensor.stamps(2.0));
        assert!(log.values().iter().all(|y| ((y / 0.001).round() * 0.001 - y).abs() < 1e-15), "{:?}", log.values());
        assert!(log.values().iter().any(|y| *y != 0.5));
    }

    #[test]
    fn a_perfect_sensor_tells_the_truth() {
        let log = Sensor::new("r", 10.0, 0.0).log(&[0.1, 0.2], &mut Noise::new(3, 0));
        assert_eq!(log.values(), [0.1, 0.2]);
    }
}
