//! The random part of a run: a force in each degree of freedom, and the noise of each sensor.
//!
//! ```text
//! ν̇ = M⁻¹ (f + d),   ḋᵢ = −dᵢ/Tᵢ + white,  std dᵢ = σᵢ
//! y = h(x) + b + e,   e white, b first-order where needed
//! ```
//!
//! The unknowns are estimated as logarithms: ln σᵢ, ln Tᵢ, and ln of the standard deviation of each
//! sensor. If T is near the sample time, only the intensity σ²T has an effect.

use crate::frame::Dof;

/// A random force in one degree of freedom: a first-order Gauss-Markov process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RandomForce {
    /// Degree of freedom in which it acts.
    pub dof: Dof,
    /// Stationary standard deviation, N or N·m.
    pub rms: f64,
    /// Correlation time, s.
    pub time: f64,
}

impl RandomForce {
    /// Ratio of the random force to the commanded force beyond which the random force is no
    /// disturbance: the model does not know what moves the vehicle, however well it predicts with a
    /// force of any size. The free runs of a vehicle in a gale stay far below it.
    pub const OVERWHELMING: f64 = 10.0;
}

/// The part of a sensor's noise that is correlated in time, a first-order Gauss-Markov process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coloured {
    /// Stationary standard deviation, in the channel's unit.
    pub rms: f64,
    /// Correlation time, s.
    pub time: f64,
}

/// Noise of one sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorNoise {
    /// Standard deviation of the white part, in the channel's unit.
    pub std: f64,
    /// The part that is correlated in time, if the likelihood asks for one.
    pub coloured: Option<Coloured>,
}

/// The noise model: random forces and sensor noise.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseModel {
    /// Random forces, in the order of ν; a degree of freedom without one is not listed.
    pub forces: Vec<RandomForce>,
    /// Noise of each output of the model, in its order.
    pub sensors: Vec<SensorNoise>,
}

/// One unknown of the noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinate {
    /// ln σ of the random force of this index.
    ForceRms(usize),
    /// ln T of the random force of this index.
    ForceTime(usize),
    /// ln of the standard deviation of the white noise of this output.
    Sensor(usize),
    /// ln of the standard deviation of the coloured noise of this output.
    ColouredRms(usize),
    /// ln of the correlation time of the coloured noise of this output.
    ColouredTime(usize),
}

impl NoiseModel {
    /// Outputs whose noise has a coloured part.
    pub fn coloured(&self) -> impl Iterator<Item = (usize, Coloured)> + '_ {
        self.sensors.iter().enumerate().filter_map(|(output, sensor)| Some((output, sensor.coloured?)))
    }

    /// Number of Gauss-Markov states: forces, then coloured noise.
    pub fn processes(&self) -> usize {
        self.forces.len() + self.coloured().count()
    }

    /// All unknowns: those of the forces, then of the sensors, then of the coloured parts.
    pub fn coordinates(&self) -> Vec<Coordinate> {
        let forces = (0..self.forces.len()).flat_map(|i| [Coordinate::ForceRms(i), Coordinate::ForceTime(i)]);
        let sensors = (0..self.sensors.len()).map(Coordinate::Sensor);
        let coloured = self.coloured().flat_map(|(c, _)| [Coordinate::ColouredRms(c), Coordinate::ColouredTime(c)]);
        forces.chain(sensors).chain(coloured).collect()
    }

    /// Value of an unknown, as a logarithm.
    pub fn at(&self, coordinate: Coordinate) -> f64 {
        let coloured = |c: usize| self.sensors[c].coloured.unwrap_or(Coloured { rms: 1.0, time: 1.0 });
        match coordinate {
            Coordinate::ForceRms(i) => self.forces[i].rms,
            Coordinate::ForceTime(i) => self.forces[i].time,
            Coordinate::Sensor(c) => self.sensors[c].std,
            Coordinate::ColouredRms(c) => coloured(c).rms,
            Coordinate::ColouredTime(c) => coloured(c).time,
        }
        .ln()
    }

    /// Sets an unknown to a logarithm.
    pub fn set(&mut self, coordinate: Coordinate, log: f64) {
        let value = log.exp();
        match coordinate {
            Coordinate::ForceRms(i) => self.forces[i].rms = value,
            Coordinate::ForceTime(i) => self.forces[i].time = value,
            Coordinate::Sensor(c) => self.sensors[c].std = value,
            Coordinate::ColouredRms(c) => self.sensors[c].coloured.iter_mut().for_each(|x| x.rms = value),
            Coordinate::ColouredTime(c) => self.sensors[c].coloured.iter_mut().for_each(|x| x.time = value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_unknowns_are_set_and_read_back() {
        let force = RandomForce { dof: Dof::Surge, rms: 2.0, time: 0.5 };
        let white = SensorNoise { std: 0.01, coloured: None };
        let both = SensorNoise { std: 0.02, coloured: Some(Coloured { rms: 0.03, time: 4.0 }) };
        let mut noise = NoiseModel { forces: vec![force], sensors: vec![white, both] };
        assert_eq!((noise.processes(), noise.coordinates().len()), (2, 6));
        for (k, coordinate) in noise.coordinates().into_iter().enumerate() {
            noise.set(coordinate, k as f64 * 0.1);
            assert!((noise.at(coordinate) - k as f64 * 0.1).abs() < 1e-15);
        }
    }
}
