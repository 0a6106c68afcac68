//! Instruments of a planned campaign: the channels that they log, their rate and their noise.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::estimate::output_error::OutputErrorOptions;
use crate::frame::Dof;
use crate::model::Model;

/// Noise and rate of one logged channel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Instrument {
    /// Standard deviation of its white noise, in the channel's unit.
    pub noise: f64,
    /// Samples a second, Hz.
    pub rate: f64,
}

/// Instruments by the channel that they log: `u`, `psi`; `x`, `y`, `z` only if position is measured independently.
pub type Instruments = BTreeMap<String, Instrument>;

/// An ordinary DVL, gyro and compass, for every velocity and angle that `model` simulates: 5 mm/s, 3 mrad/s and 0.5° at
/// 10 Hz, as in the virtual tank.
pub fn usual(model: &Model) -> Instruments {
    let mut instruments = Instruments::new();
    for dof in &model.dofs {
        let noise = if dof.is_rotation() { 0.003 } else { 0.005 };
        instruments.insert(dof.velocity().into(), Instrument { noise, rate: 10.0 });
        if dof.is_rotation() {
            instruments.insert(dof.position().into(), Instrument { noise: 0.5f64.to_radians(), rate: 10.0 });
        }
    }
    instruments
}

/// Whether these instruments measure the position of `model` independently of its velocity.
pub(super) fn position(instruments: &Instruments, model: &Model) -> bool {
    let mut translations = model.dofs.iter().filter(|dof| !dof.is_rotation()).peekable();
    translations.peek().is_some() && translations.all(|dof| instruments.contains_key(dof.position()))
}

/// `fitting` with the noise and the measured channels of these instruments.
pub(super) fn fitting(fitting: &OutputErrorOptions, instruments: &Instruments, model: &Model) -> OutputErrorOptions {
    let sigma = instruments.iter().map(|(channel, i)| (channel.clone(), i.noise)).collect();
    OutputErrorOptions { sigma: Some(sigma), position: position(instruments, model), ..fitting.clone() }
}

/// Whether `model` predicts this channel: a velocity or a position of one of its degrees of freedom.
pub(super) fn predicted(model: &Model, channel: &str) -> bool {
    model.dofs.iter().any(|dof: &Dof| dof.velocity() == channel || dof.position() == channel)
}
