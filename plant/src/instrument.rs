//! Instruments: samples of the motion with noise, systematic errors and time stamps.
//!
//! ```text
//! sample at t − latency, stamped t + jitter:   y = quantised((1 + s) x + b + e + outlier)
//! e: normal or Student t, white or AR(1)       DVL: v + ω × p, turned by α about z
//! compass: ψ + a cos ψ + b sin ψ               low pass: T ẏ = x − y
//! smoothed angle: ŷ₊ = ŷ + Δx + (Δ/T)(y − ŷ), a complementary filter
//! ```

use nalgebra::Vector3;

use crate::attitude::{angles, rotation, wrapped};
use crate::plant::{State, nu_of, quaternion_of};
use crate::random::Random;

/// One channel of an instrument.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Column of the log: `u` … `r`, `x` … `psi`, `load_u` …, `supply_V`.
    pub name: &'static str,
    /// Standard deviation of the logged noise.
    pub noise: f64,
    /// Bias b.
    pub bias: f64,
    /// Scale error s.
    pub scale: f64,
    /// Step of the quantisation; 0 for none.
    pub quantum: f64,
}

impl Channel {
    /// A channel with noise and no other error.
    pub fn new(name: &'static str, noise: f64) -> Channel {
        Channel { name, noise, bias: 0.0, scale: 0.0, quantum: 0.0 }
    }
}

/// An instrument: channels that are sampled together.
#[derive(Debug, Clone, PartialEq)]
pub struct Instrument {
    /// Its channels.
    pub channels: Vec<Channel>,
    /// Sample rate, Hz.
    pub rate: f64,
    /// Offset of the sampling instants from the multiples of the sample period, s.
    pub phase: f64,
    /// Age of a sample at its time stamp, s.
    pub latency: f64,
    /// Standard deviation of the error of the time stamps, s; an error is at most 0.4 sample periods.
    pub jitter: f64,
    /// Share of the samples that are lost.
    pub dropouts: f64,
    /// Share of the samples that are outliers, and their size in units of the noise.
    pub outliers: (f64, f64),
    /// Degrees of freedom of Student's t; `None` for normal noise.
    pub student: Option<u32>,
    /// Correlation of the noise from sample to sample.
    pub colour: f64,
    /// Time constant of a low-pass filter before the log, s; 0 for none. The filter acts on the
    /// noise as well; the standard deviation of the channel is that of the filtered noise.
    pub low_pass: f64,
    /// Time constant of a complementary filter for angles, s; 0 for none.
    pub smoothing: f64,
    /// Rate at which the value is renewed if it is logged more often, Hz; between renewals it is repeated.
    pub renewed: Option<f64>,
    /// Lever arm of velocities and of horizontal positions, m.
    pub lever_arm: Vector3<f64>,
    /// Misalignment α of velocities about z, rad.
    pub misalignment: f64,
    /// Compass deviation a cos ψ + b sin ψ, rad.
    pub deviation: (f64, f64),
    /// Compass error per newton of [`Truth::effort`], rad/N.
    pub magnetic: f64,
}

impl Instrument {
    /// An instrument with white noise and no other error.
    pub fn new(rate: f64, channels: &[(&'static str, f64)]) -> Instrument {
        Instrument {
            channels: channels.iter().map(|(name, noise)| Channel::new(name, *noise)).collect(),
            rate,
            phase: 0.0,
            latency: 0.0,
            jitter: 0.0,
            dropouts: 0.0,
            outliers: (0.0, 0.0),
            student: None,
            colour: 0.0,
            low_pass: 0.0,
            smoothing: 0.0,
            renewed: None,
            lever_arm: Vector3::zeros(),
            misalignment: 0.0,
            deviation: (0.0, 0.0),
            magnetic: 0.0,
        }
    }

    /// The channel of this name.
    pub fn channel(&mut self, name: &str) -> Option<&mut Channel> {
        self.channels.iter_mut().find(|c| c.name == name)
    }

    /// Whether it has this channel.
    pub fn has(&self, name: &str) -> bool {
        self.channels.iter().any(|c| c.name == name)
    }

    /// Whether it measures angular rates.
    pub fn is_gyro(&self) -> bool {
        ["p", "q", "r"].iter().any(|name| self.has(name))
    }
}

/// True values at one instant.
#[derive(Debug, Clone, Copy)]
pub struct Truth {
    /// Time of the run, s.
    pub time: f64,
    /// States.
    pub state: State,
    /// Sum of the magnitudes of the commanded forces along the three body axes, N; it disturbs a compass.
    pub effort: f64,
    /// Wrench of the thrusters, N and N·m.
    pub load: [f64; 6],
    /// Supply voltage, V.
    pub supply: f64,
}

/// Minimum internal rate of an instrument with a low-pass filter, Hz.
const FILTER_RATE: f64 = 200.0;

/// An instrument during one run, with its state and its samples so far.
#[derive(Debug, Clone)]
pub struct Working<'a> {
    instrument: &'a Instrument,
    random: Random,
    next: i64,
    /// Number of internal samples for each one that is logged.
    every: i64,
    /// Of the last sample of each channel: value without noise, state of the filter or smoother,
    /// AR(1) noise, logged value.
    last: Vec<[f64; 4]>,
    started: bool,
    /// Stamps, s.
    pub stamps: Vec<f64>,
    /// Values by channel.
    pub values: Vec<Vec<f64>>,
}

impl<'a> Working<'a> {
    /// The instrument before its first sample, which is at `start` or later.
    pub fn new(instrument: &'a Instrument, start: f64, random: Random) -> Working<'a> {
        let every = if instrument.low_pass > 0.0 { (FILTER_RATE / instrument.rate).ceil() } else { 1.0 };
        let first = ((start + instrument.latency - instrument.phase) * instrument.rate * every - 1e-6).ceil();
        let channels = instrument.channels.len();
        Working {
            instrument,
            random,
            next: first as i64,
            every: every as i64,
            last: vec![[0.0; 4]; channels],
            started: false,
            stamps: Vec::new(),
            values: vec![Vec::new(); channels],
        }
    }

    /// Time of the next sample, s.
    pub fn due(&self) -> f64 {
        self.stamp(self.next) - self.instrument.latency
    }

    fn stamp(&self, n: i64) -> f64 {
        self.instrument.phase + n as f64 / (self.instrument.rate * self.every as f64)
    }

    /// Takes the sample that is due.
    pub fn sample(&mut self, truth: &Truth) {
        let (instrument, n) = (self.instrument, self.next);
        self.next += 1;
        let logs = n.rem_euclid(self.every) == 0;
        let step = 1.0 / (instrument.rate * self.every as f64);
        let stamp = self.stamp(n);
        let renewal = instrument
            .renewed
            .is_none_or(|rate| !self.started || (stamp * rate + 1e-9).floor() > ((stamp - step) * rate + 1e-9).floor());
        let lost = instrument.dropouts > 0.0 && logs && self.random.uniform() < instrument.dropouts;
        let outlier = logs && instrument.outliers.0 > 0.0 && self.random.uniform() < instrument.outliers.0;
        for (k, channel) in instrument.channels.iter().enumerate() {
            let mut x = (1.0 + channel.scale) * value(instrument, channel.name, truth) + channel.bias;
            let [before, state, ar, held] = self.last[k];
            let angle = matches!(channel.name, "phi" | "theta" | "psi");
            if angle && self.started {
                x = before + wrapped(x - before);
            }
            let fresh = match instrument.student {
                Some(freedom) => self.random.student(freedom),
                None => self.random.normal(),
            };
            let colour = instrument.colour;
            let ar = if self.started { colour * ar + (1.0 - colour * colour).sqrt() * fresh } else { fresh };
            let noise = channel.noise * ar;
            let mut y = x + noise;
            let mut memory = y;
            if instrument.low_pass > 0.0 {
                // scaled up before the filter, so that the filtered noise has the stated standard deviation
                let a = (-step / instrument.low_pass).exp();
                let raw = x + noise * ((1.0 + a) / (1.0 - a)).sqrt();
                memory = if self.started { a * state + (1.0 - a) * raw } else { x + noise };
                y = memory;
            } else if instrument.smoothing > 0.0 && angle {
                let gain = (step / instrument.smoothing).min(1.0);
                let carried = state + x - before;
                memory = if self.started { carried + gain * (y - carried) } else { y };
                y = memory;
            }
            if outlier {
                y += instrument.outliers.1 * channel.noise * if self.random.uniform() < 0.5 { -1.0 } else { 1.0 };
            }
            if channel.quantum > 0.0 {
                y = (y / channel.quantum).round() * channel.quantum;
            }
            let y = if renewal { y } else { held };
            self.last[k] = [x, memory, ar, y];
            if logs && !lost {
                self.values[k].push(if angle { wrapped(y) } else { y });
            }
        }
        self.started = true;
        if logs && !lost {
            let most = 0.4 / instrument.rate;
            let jitter = if instrument.jitter > 0.0 { instrument.jitter * self.random.normal() } else { 0.0 };
            self.stamps.push(stamp + jitter.clamp(-most, most));
        }
    }

    /// The instrument.
    pub fn instrument(&self) -> &Instrument {
        self.instrument
    }

    /// Whether its measurement depends on the command at the same instant.
    pub fn sees_command(&self) -> bool {
        self.instrument.magnetic != 0.0 || self.instrument.channels.iter().any(|c| c.name.starts_with("load"))
    }

    /// The newest sample of channel `k` whose stamp is not after `t`.
    pub fn newest(&self, k: usize, t: f64) -> Option<f64> {
        let index = self.stamps.iter().rposition(|stamp| *stamp <= t + 1e-9)?;
        Some(self.values[k][index])
    }
}

/// Value that a channel would measure without noise, bias and scale error; the mounting of the
/// instrument, the compass deviation and the magnetic disturbance are included.
fn value(instrument: &Instrument, name: &str, truth: &Truth) -> f64 {
    let nu = nu_of(&truth.state);
    let attitude = || angles(&rotation(quaternion_of(&truth.state)));
    match name {
        "u" | "v" | "w" => {
            let omega = Vector3::new(nu[3], nu[4], nu[5]);
            let at = Vector3::new(nu[0], nu[1], nu[2]) + omega.cross(&instrument.lever_arm);
            let (sin, cos) = instrument.misalignment.sin_cos();
            match name {
                "u" => at.x * cos + at.y * sin,
                "v" => at.y * cos - at.x * sin,
                _ => at.z,
            }
        }
        "p" => nu[3],
        "q" => nu[4],
        "r" => nu[5],
        "x" | "y" => {
            let at = rotation(quaternion_of(&truth.state)) * instrument.lever_arm;
            if name == "x" { truth.state[0] + at.x } else { truth.state[1] + at.y }
        }
        "z" => truth.state[2],
        "phi" => attitude()[0],
        "theta" => attitude()[1],
        "psi" => {
            let psi = attitude()[2];
            let (a, b) = instrument.deviation;
            psi + a * psi.cos() + b * psi.sin() + instrument.magnetic * truth.effort
        }
        "load_u" => truth.load[0],
        "load_v" => truth.load[1],
        "load_w" => truth.load[2],
        "load_p" => truth.load[3],
        "load_q" => truth.load[4],
        "load_r" => truth.load[5],
        _ => truth.supply,
    }
}
