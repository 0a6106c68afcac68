//! Simulation of a manoeuvre by the model in the virtual tank, without noise.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::instrument::{self, Instruments};
use super::manoeuvre::Manoeuvre;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, Signal};
use crate::tank::{Basin, Noise, Sensor, TankError, amplitudes};

/// Basis of a plan: the model as the truth, the instruments, and the vehicle's length for Keulegan-Carpenter numbers.
#[derive(Debug, Clone)]
pub struct Course {
    /// The model whose values count as true.
    pub model: Model,
    /// Logged channels, with rate and noise.
    pub instruments: Instruments,
    /// Characteristic length, m; 1 m if it is unknown and no effect needs it.
    pub length: f64,
}

/// A simulated manoeuvre.
#[derive(Debug, Clone)]
pub struct Sailed {
    /// The manoeuvre.
    pub manoeuvre: Manoeuvre,
    /// Log of perfect instruments, with the commands.
    pub run: Run,
    /// Greatest |ν| of each modelled degree of freedom, m/s and rad/s.
    pub greatest: BTreeMap<Dof, f64>,
    /// Greatest horizontal distance from the start, m.
    pub reach: f64,
    /// Greatest |θ|, rad.
    pub pitch: f64,
}

/// Rate of the commands and of the samples from which the extent of the motion is taken, Hz.
const RATE: f64 = 10.0;

/// Integration step, s: half of the tank's own accuracy, as nothing here is compared with a log.
const STEP: f64 = 0.02;

impl Course {
    /// Simulates a manoeuvre.
    ///
    /// # Errors
    /// [`TankError`] when the motion diverges or the model reads a channel that a plan cannot foresee.
    pub fn sail(&self, manoeuvre: &Manoeuvre) -> Result<Sailed, TankError> {
        let logged = self.instruments.iter().filter(|(channel, _)| instrument::predicted(&self.model, channel));
        let mut sensors: Vec<Sensor> = logged.map(|(channel, i)| Sensor::new(channel.as_str(), i.rate, 0.0)).collect();
        let own = sensors.len();
        for dof in &self.model.dofs {
            for channel in [dof.velocity(), dof.position()] {
                if !sensors.iter().any(|s| s.channel == channel) {
                    sensors.push(Sensor::new(channel, RATE, 0.0));
                }
            }
        }
        let mut trial = manoeuvre.trial();
        let basin = Basin { step: STEP, control_rate: RATE, sensors, ..Basin::default() };
        amplitudes(&basin, &self.model, &mut trial, 0, self.length)?;
        let mut run = basin.sail(&self.model, &trial, 0, 0)?;
        let values = |channel: &str| run.signal(channel).map_or(&[][..], Signal::values);
        let most = |channel: &str| values(channel).iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let greatest = self.model.dofs.iter().map(|dof| (*dof, most(dof.velocity()))).collect();
        let (x, y) = (values("x"), values("y"));
        let far = |k: usize| x.get(k).unwrap_or(&0.0).hypot(*y.get(k).unwrap_or(&0.0));
        let reach = (0..x.len().max(y.len())).map(far).fold(0.0, f64::max);
        let pitch = most("theta");
        for watched in &basin.sensors[own..] {
            run.signals.remove(&watched.channel);
        }
        Ok(Sailed { manoeuvre: manoeuvre.clone(), run, greatest, reach, pitch })
    }

    /// Log of `sailed` by the real instruments: white noise for run number `index` of a campaign, drawn from `seed`.
    pub(super) fn logged(&self, sailed: &Sailed, index: usize, seed: u64) -> Run {
        let mut run = sailed.run.clone();
        for (number, (channel, instrument)) in self.instruments.iter().enumerate() {
            if let Some(signal) = run.signals.get_mut(channel) {
                let mut noise = Noise::new(seed, ((index as u64 + 1) << 16) + number as u64);
                let time: Arc<[f64]> = signal.shared_time().clone();
                let values: Vec<f64> = signal.values().iter().map(|x| x + instrument.noise * noise.normal()).collect();
                *signal = Signal::new(time, values);
            }
        }
        run
    }
}
