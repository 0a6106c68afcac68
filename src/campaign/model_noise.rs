//! The noise in a model file: what its fit has found to be random, for every verb that uses the
//! model.

use serde::{Deserialize, Serialize};

use super::noise::Noise;
use crate::estimate::filter_error::{Coloured, Filtered, NoiseModel, RandomForce, SensorNoise};
use crate::frame::Dof;
use crate::monitor::KnownNoise;
use crate::navigation::upright;

/// The `[noise]` table of a model file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelNoise {
    /// Whether no channel has innovations that are correlated beyond chance.
    pub innovations_white: bool,
    /// Random forces; a degree of freedom without one is not listed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub force: Vec<ModelForce>,
    /// The noise of each channel that the model predicts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensor: Vec<ModelSensor>,
}

/// A random force of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelForce {
    /// Degree of freedom in which it acts.
    pub dof: Dof,
    /// Standard deviation of the force, N or N·m.
    pub rms: f64,
    /// Standard deviation of `rms`, N or N·m.
    pub std: f64,
    /// Correlation time, s.
    pub correlation_time: f64,
    /// Standard deviation of `correlation_time`, s.
    pub correlation_time_std: f64,
    /// `rms` over that of the thrust.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share_of_thrust: Option<f64>,
}

/// The noise of a channel of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelSensor {
    /// The channel, as in a log.
    pub channel: String,
    /// Standard deviation of the white part, SI.
    pub std: f64,
    /// Standard deviation of the part that is correlated in time, SI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coloured_std: Option<f64>,
    /// Correlation time of that part, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation_time: Option<f64>,
    /// Factor by which windows of its innovations differ from white ones more than by chance: 1 for
    /// noise that is as described here.
    pub restlessness: f64,
}

impl From<&Noise> for ModelNoise {
    fn from(found: &Noise) -> ModelNoise {
        let force = found.force.iter().map(|f| ModelForce {
            dof: f.dof,
            rms: f.rms,
            std: f.std,
            correlation_time: f.correlation_time,
            correlation_time_std: f.correlation_time_std,
            share_of_thrust: f.share_of_thrust,
        });
        let sensor = found.sensors.iter().map(|s| ModelSensor {
            channel: s.channel.clone(),
            std: s.std,
            coloured_std: s.coloured_std,
            correlation_time: s.correlation_time,
            restlessness: s.restlessness,
        });
        ModelNoise { innovations_white: found.innovations_white, force: force.collect(), sensor: sensor.collect() }
    }
}

impl ModelNoise {
    /// Returns the random force in a degree of freedom.
    pub fn force_in(&self, dof: Dof) -> Option<&ModelForce> {
        self.force.iter().find(|f| f.dof == dof)
    }

    /// Returns the noise of a channel.
    pub fn of_channel(&self, channel: &str) -> Option<&ModelSensor> {
        self.sensor.iter().find(|s| s.channel == channel)
    }

    /// Returns the noise in the form that the monitoring of these runs takes.
    pub(super) fn known(&self, filtered: &Filtered) -> KnownNoise {
        let outputs = filtered.problem.dynamics.outputs.iter();
        let restless = |output: &String| {
            self.of_channel(upright::instrument_of(output).unwrap_or(output)).map_or(1.0, |s| s.restlessness)
        };
        KnownNoise { noise: self.of(filtered), restless: outputs.map(restless).collect() }
    }

    /// Returns the random forces, N or N·m and s.
    pub fn forces(&self) -> Vec<RandomForce> {
        let force = |f: &ModelForce| RandomForce { dof: f.dof, rms: f.rms, time: f.correlation_time };
        self.force.iter().map(force).filter(|f| f.rms > 0.0).collect()
    }

    /// Returns the noise in the form that a filter of these runs takes. A channel without noise in
    /// the model file has the noise that the runs show.
    pub(super) fn of(&self, filtered: &Filtered) -> NoiseModel {
        let dynamics = &filtered.problem.dynamics;
        let sensor = |(output, sigma): (&String, &f64)| {
            let known = self.of_channel(upright::instrument_of(output).unwrap_or(output));
            let coloured = known.and_then(|s| s.coloured_std.zip(s.correlation_time));
            SensorNoise {
                std: known.map_or(*sigma, |s| s.std),
                coloured: coloured.map(|(rms, time)| Coloured { rms, time }),
            }
        };
        let forces = self.forces().into_iter().filter(|f| dynamics.velocities().contains(&f.dof));
        NoiseModel {
            forces: forces.collect(),
            sensors: dynamics.outputs.iter().zip(&filtered.problem.sigma).map(sensor).collect(),
        }
    }
}
