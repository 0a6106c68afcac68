//! The `[noise]` table: prior knowledge of the sensors' noise and of the random force.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::estimate::filter_error::Forces;
use crate::frame::Dof;

/// The `[noise]` table: standard deviations by channel in SI units, and the keys `force` and `force_max`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct NoiseTable {
    /// The random force; estimated when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<ForceNoise>,
    /// Greatest rms of the random force by degree of freedom, N or N·m.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub force_max: BTreeMap<Dof, f64>,
    /// Standard deviation of the noise of a channel, in its SI unit; estimated from the data where absent.
    #[serde(flatten)]
    pub sensors: BTreeMap<String, f64>,
}

/// Prior knowledge of the random force.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ForceNoise {
    /// Given by a word.
    Word(ForceWord),
    /// Held: rms by degree of freedom, N or N·m, and `correlation_time`, s.
    Held(BTreeMap<String, f64>),
}

/// A word for the random force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ForceWord {
    /// Estimated: the default.
    Estimate,
    /// There is none.
    None,
}

/// Key of the correlation time in a force that is held.
const CORRELATION_TIME: &str = "correlation_time";

impl NoiseTable {
    /// Whether the table is empty.
    pub fn is_empty(&self) -> bool {
        *self == NoiseTable::default()
    }

    /// Returns the random force in the form that the estimator takes.
    ///
    /// # Errors
    /// The key of a held force that is no degree of freedom or has an impossible number, and what
    /// would be right.
    pub fn forces(&self) -> Result<Forces, (String, &'static str)> {
        let table = match &self.force {
            None | Some(ForceNoise::Word(ForceWord::Estimate)) => {
                return Ok(Forces::Estimate { most: self.force_max.clone() });
            }
            Some(ForceNoise::Word(ForceWord::None)) => return Ok(Forces::None),
            Some(ForceNoise::Held(table)) => table,
        };
        let mut rms = BTreeMap::new();
        let mut time = 1.0;
        for (key, value) in table {
            let dof = Dof::from_name(key);
            match (dof, key == CORRELATION_TIME) {
                (None, false) => return Err((key.clone(), "a degree of freedom, or `correlation_time`")),
                (_, true) if !(value.is_finite() && *value > 0.0) => return Err((key.clone(), "a time above 0 s")),
                _ if !(value.is_finite() && *value >= 0.0) => return Err((key.clone(), "an rms of 0 or more")),
                (Some(dof), _) => drop(rms.insert(dof, *value)),
                (None, true) => time = *value,
            }
        }
        Ok(Forces::Held { rms, time })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> NoiseTable {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn a_force_is_estimated_absent_held_or_bounded() {
        assert_eq!(read("u = 0.005").forces(), Ok(Forces::Estimate { most: BTreeMap::new() }));
        assert_eq!(read("u = 0.005").sensors["u"], 0.005);
        assert_eq!(read("force = 'estimate'").forces(), read("").forces());
        assert_eq!(read("force = 'none'").forces(), Ok(Forces::None));
        let held = Forces::Held { rms: [(Dof::Surge, 1.2), (Dof::Yaw, 0.3)].into(), time: 0.8 };
        assert_eq!(read("force = { surge = 1.2, yaw = 0.3, correlation_time = 0.8 }").forces(), Ok(held));
        let bounded = Forces::Estimate { most: [(Dof::Surge, 2.0)].into() };
        assert_eq!(read("force_max = { surge = 2.0 }").forces(), Ok(bounded));
        assert!(read("force = { up = 1.0 }").forces().is_err());
        assert!(read("force = { surge = -1.0 }").forces().is_err());
        assert!(read("force = { surge = 1.0, correlation_time = 0.0 }").forces().is_err());
        let table = read("force = { surge = 1.2 }\nr = 0.003\nforce_max = { yaw = 1.0 }");
        assert_eq!(read(&toml::to_string(&table).unwrap()), table);
    }
}
